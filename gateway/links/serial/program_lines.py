"""Serial lines of BAPS2 programs, moved by the turns of a process that has no event loop of its own (AX-1021)."""

import asyncio
from collections.abc import Callable, Mapping
from typing import TypeVar

from gateway.links.serial.rho3_devices import Rho3Lines
from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.program_units import ProgramUnits
from gateway.pure.controllers.rho3.serial.setup import Setup
from protocols.base.machine import Ns

R = TypeVar("R")


class ProgramLines:
    """ports: name of a line -> its address.  `units` is the interface of programs; it moves the bytes in each turn."""

    def __init__(self, setup: Setup, ports: Mapping[str, str]) -> None:
        self._loop = asyncio.new_event_loop()
        self.units = ProgramUnits(setup, self._inside, self._step)
        self._lines = self._loop.run_until_complete(self._opened(setup, ports))

    def reasons(self) -> dict[str, str]:
        """Why each line is not connected; empty: it is."""
        return {name: runner.state.why for name, runner in self._lines.runners.items()}

    def close(self) -> None:
        """Release the ports."""
        self._loop.run_until_complete(self._closed())
        self._loop.close()

    async def _opened(self, setup: Setup, ports: Mapping[str, str]) -> Rho3Lines:
        return Rho3Lines(setup, ports, self.units.hear)

    async def _closed(self) -> None:
        self._lines.close()

    def _inside(self, action: Callable[[LineManager, Ns], R], /) -> R:
        async def call() -> R:
            return self._lines.do(action)

        return self._loop.run_until_complete(call())

    def _step(self) -> None:
        """Handle due times and received bytes; never waits."""
        self._loop.call_soon(self._loop.stop)
        self._loop.run_forever()
