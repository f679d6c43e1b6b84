"""The rho 3's serial devices on real ports, inside asyncio: one LineRunner for each line of a LineManager.

A program's call is awaited: `await lines.read(process, "V24_1", INTEGER)`.  All else goes through `lines.do`, which wakes the lines
afterwards.  Guide: docs/guide/rho3-lines.md.
"""

import asyncio
import time
from collections.abc import Callable, Mapping
from typing import TypeVar

from drivers.ports.base import BytePort
from drivers.ports.open import open_bytes
from gateway.links.serial.runner import LineRunner
from gateway.pure.controllers.rho3.serial.baps import BapsType, Item
from gateway.pure.controllers.rho3.serial.events import Event, Finished, FormatWanted
from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.setup import Condition, Process, Setup
from protocols.base.machine import Ns

R = TypeVar("R")
Listener = Callable[[Event, Ns], None]


def ignore(event: Event, now: Ns) -> None:
    """A listener that has no ears."""


class Rho3Lines:
    """Starts at once, inside a running loop.

    ports: line name -> address ("/dev/ttyUSB0", "pty:/path", "tcp://host:port") for each of setup.lines; ValueError names those missing.
    on_event receives every event except the end of awaited calls.
    """

    def __init__(self, setup: Setup, ports: Mapping[str, str], on_event: Listener = ignore, rc_inputs: bytes = b"") -> None:
        missing = [name for name in setup.lines if name not in ports]
        if missing:
            raise ValueError(f"no port for {', '.join(missing)}; lines of the setup: {', '.join(setup.lines)}")
        self._ports, self._on_event = dict(ports), on_event
        self._calls: dict[int, asyncio.Future[Finished]] = {}
        self._changed = asyncio.Event()
        self._closed = False
        self.manager = LineManager(setup, rc_inputs, time.monotonic_ns())
        self.runners = {name: self._run(name) for name in setup.lines}

    # ---- a program's calls
    async def write(self, process: Process, device: str | None, *items: Item, hold: bool = False) -> Finished:
        """Until the output has left the line (by 3964R: was acknowledged).  Waits for room first."""
        while not self.manager.room(process, device):
            await self._change()
        return await self._call(lambda manager, now: manager.write(process, device, items, now, hold))

    async def read(self, process: Process, device: str | None, *variables: BapsType) -> Finished:
        """Until all are read, or an error."""
        return await self._call(lambda manager, now: manager.read(process, device, variables, now))

    async def condition(self, process: Process, device: str | None) -> Condition:
        """CONDITION(device): waits for the outputs of this process."""
        while (found := self.manager.condition(process, device)) is None:
            await self._change()
        return found

    def do(self, action: Callable[[LineManager, Ns], R]) -> R:
        """Any other call: `lines.do(lambda manager, now: manager.write_begin(process, None, now))`."""
        result = action(self.manager, time.monotonic_ns())
        self._report_all(self.manager.take_events())
        self._kick()
        return result

    def close(self) -> None:
        """Release the ports; pending calls end with -7 or are cancelled.  A second call is harmless."""
        if self._closed:
            return
        self._closed = True
        for runner in self.runners.values():
            runner.close()
        for call in self._calls.values():
            call.cancel()
        self._calls.clear()

    # ---- inside
    def _run(self, name: str) -> LineRunner[Event]:
        url, place = self._ports[name], self.manager.lines[name]

        def opened() -> BytePort:
            return open_bytes(url, place.format)

        return LineRunner(opened, place, self._heard)

    def _heard(self, event: Event, now: Ns) -> None:
        """Events of any line; their consequences may have to leave by another one."""
        self._report(event, now)
        self._kick()

    def _report_all(self, events: list[Event]) -> None:
        for event in events:
            self._report(event, time.monotonic_ns())

    def _report(self, event: Event, now: Ns) -> None:
        if isinstance(event, FormatWanted):
            asyncio.get_running_loop().call_soon(self._reopen, event.line)
        if isinstance(event, Finished):
            self._changed.set()
            call = self._calls.pop(event.ticket, None)
            if call is not None:
                if not call.done():
                    call.set_result(event)
                return
        self._on_event(event, now)

    def _reopen(self, name: str) -> None:
        if not self._closed:
            self.runners[name].close()
            self.manager.lines[name].reopened(time.monotonic_ns())
            self.runners[name] = self._run(name)

    def _kick(self) -> None:
        for runner in self.runners.values():
            runner.kick()

    def _call(self, action: Callable[[LineManager, Ns], int]) -> asyncio.Future[Finished]:
        """Wait for its end before anything is reported: a refused call is over at once."""
        call: asyncio.Future[Finished] = asyncio.get_running_loop().create_future()

        def begin(manager: LineManager, now: Ns) -> None:
            ticket = action(manager, now)
            if ticket:
                self._calls[ticket] = call
            else:
                call.set_result(Finished(0, Condition.NO_ERROR))  # held back by `..`

        self.do(begin)
        return call

    async def _change(self) -> None:
        self._changed.clear()
        await self._changed.wait()
