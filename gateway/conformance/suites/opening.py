"""A device opened for a suite: a machine in virtual time, or a port."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import parse_format
from gateway.conformance.framework.bench_file import Bench
from gateway.conformance.framework.machine import Guarded, load_machine
from gateway.conformance.framework.witness import Witness
from gateway.links.serial.tool_wire import RealWire, ToolPort, VirtualWire, Wire

OpenPort = Callable[[str, str], ToolPort]
START_LIMIT_S = 10.0


def silent(text: str) -> None:
    """Discards the text."""


@dataclass(slots=True)
class Opened:
    """What a session is made of.  open_port is handed in: which addresses there are is known above this room."""

    bench: Bench
    pics: Mapping[str, object]
    open_port: OpenPort
    make: Callable[[], Guarded] | None = None  # virtual time
    witness: Witness | None = None
    seed: int = 1
    say: Callable[[str], None] = silent
    pace: bool = True  # characters take their time in virtual time
    started_at: float = field(default_factory=time.monotonic)
    wires: int = 0

    def wire(self) -> Wire:
        """A new wire to the device; for a machine a new device at its end as well."""
        self.wires += 1
        if self.make is not None:
            char_ns = parse_format(self.bench.format).char_ns if self.pace else 0
            return VirtualWire(self.make(), char_ns, self.bench.url)
        while True:
            try:
                return RealWire(self.open_port(self.bench.url, self.bench.format))
            except PortError:
                if not self.bench.start or self.wires > 1 or time.monotonic() - self.started_at > START_LIMIT_S:
                    raise
                time.sleep(0.05)


def factory_of(bench: Bench) -> Callable[[], Guarded] | None:
    """The maker behind `machine:`; None for ports."""
    return load_machine(bench.url, bench.folder) if bench.url.startswith("machine:") else None
