"""A device opened for a suite: a machine in virtual time, or a port."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar, cast

from drivers.ports.base import CanPort, PortError
from drivers.ports.can.open import open_can
from drivers.ports.serial.line_format import parse_format
from gateway.conformance.framework.bench_file import Bench
from gateway.conformance.framework.frame_wire import FrameWire, RealFrames, VirtualFrames
from gateway.conformance.framework.machine import AnyGuarded, Guarded, GuardedFrames, load_machine
from gateway.conformance.framework.power import BACK, Turn, switch_of
from gateway.conformance.framework.witness import Witness
from gateway.links.serial.tool_wire import RealWire, ToolPort, VirtualWire, Wire
from protocols.base.machine import Machine, Ns, ms

OpenPort = Callable[[str, str], ToolPort]
OpenBus = Callable[[str], CanPort]
Port = TypeVar("Port")
START_LIMIT_S = 10.0
SIM = "sim"


def silent(text: str) -> None:
    """Discards the text."""


@dataclass(slots=True)
class Opened:
    """Parts of a session.  open_port is passed in: the kinds of addresses are known above this room."""

    bench: Bench
    pics: Mapping[str, object]
    open_port: OpenPort
    make: Callable[[], AnyGuarded] | None = None  # virtual time
    witness: Witness | None = None
    seed: int = 1
    say: Callable[[str], None] = silent
    pace: bool = True  # characters have their duration in virtual time
    started_at: float = field(default_factory=time.monotonic)
    wires: int = 0
    open_bus: OpenBus = open_can

    def wire(self) -> Wire:
        """A new wire to the device; for a machine a new device at its end as well."""
        self.wires += 1
        if self.make is not None:
            char_ns = parse_format(self.bench.format).char_ns if self.pace else 0
            device = self.make()
            assert isinstance(device, Guarded), "a suite of characters tests a byte machine"
            return VirtualWire(device, char_ns, self.bench.url)
        return self._patiently(lambda: RealWire(self.open_port(self.bench.url, self.bench.format)))

    def bus(self) -> FrameWire:
        """The same for a CAN bus."""
        self.wires += 1
        if self.make is not None:
            device = self.make()
            assert isinstance(device, GuardedFrames), "a CAN suite tests a machine of frames"
            return VirtualFrames(device, self.bench.url)
        return self._patiently(lambda: RealFrames(self.open_bus(self.bench.url)))

    def turn(self) -> Turn | None:
        """Switches the supply, as the bench states."""
        return switch_of(self.bench, self.say)

    @property
    def back(self) -> Ns:
        """Longest time from power to an answer."""
        stated = self.bench.power.get("back_ms", self.bench.link.get("boot_ms"))
        return ms(stated) if isinstance(stated, (int, float)) else BACK

    def patiently(self, attempt: Callable[[], Port], limit_s: float) -> Port:
        """A port that goes and comes with the device's supply."""
        end = time.monotonic() + limit_s
        while True:
            try:
                return attempt()
            except PortError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)

    def _patiently(self, attempt: Callable[[], Port]) -> Port:
        """A device whose program was just started may not be there yet."""
        while True:
            try:
                return attempt()
            except PortError:
                if not self.bench.start or self.wires > 1 or time.monotonic() - self.started_at > START_LIMIT_S:
                    raise
                time.sleep(0.05)


def factory_of(bench: Bench, frames: bool = False, sim: Callable[[], object] | None = None) -> Callable[[], AnyGuarded] | None:
    """The maker for `machine:` and `sim` (the suite's own emulated device); None for ports."""
    if bench.url.startswith("machine:"):
        return load_machine(bench.url, bench.folder, frames)
    if bench.url != SIM or sim is None:
        return None
    return lambda: GuardedFrames(sim(), SIM) if frames else Guarded(cast(Machine[object], sim()), SIM)
