"""Serial units of programs in virtual time: one LineManager, bytes by hand at its lines."""

from collections.abc import Callable
from typing import TypeVar

from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.program_units import ProgramUnits
from gateway.pure.controllers.rho3.serial.setup import Setup
from protocols.base.machine import Ns

R = TypeVar("R")


class VirtualUnits:
    """`units` for a CellRun; now: the time of its bench."""

    def __init__(self, setup: Setup, now: Callable[[], Ns]) -> None:
        self._now = now
        self.manager = LineManager(setup, b"", now())
        self.units = ProgramUnits(setup, self._do, self._step)
        self.heard: dict[str, bytes] = dict.fromkeys(setup.lines, b"")  # what the partner has received

    def send(self, line: str, data: bytes) -> None:
        """The partner sends."""
        for event in self.manager.lines[line].receive(data, self._now()):
            self.units.hear(event, self._now())
        self._move()

    def taken(self, line: str) -> bytes:
        """What the partner has received since it last looked."""
        self._step()
        data, self.heard[line] = self.heard[line], b""
        return data

    def _do(self, action: Callable[[LineManager, Ns], R], /) -> R:
        found = action(self.manager, self._now())
        for event in self.manager.take_events():
            self.units.hear(event, self._now())
        self._move()
        return found

    def _step(self) -> None:
        for line in self.manager.lines.values():
            due = line.deadline()
            if due is not None and due <= self._now():
                for event in line.wake(self._now()):
                    self.units.hear(event, self._now())
        self._move()

    def _move(self) -> None:
        """Characters leave at once."""
        for name, line in self.manager.lines.items():
            while data := line.take_output():
                self.heard[name] += data
                for event in line.sent(self._now()):
                    self.units.hear(event, self._now())
