"""[rho3] of a cell: machine parameters as the old control has them printed.  Shapes: users.md 3.5."""

from collections.abc import Mapping
from dataclasses import dataclass, field

ParamValue = bool | int | float | str | tuple["ParamValue", ...] | Mapping[str, "ParamValue"]


@dataclass(frozen=True, slots=True)
class IoBus:
    """One entry of P30: digital I/O blocks of a bus; baud 0..3 = 1 Mbit/s, 500, 250, 125 kbit/s."""

    inputs: int = 0
    outputs: int = 0
    baud: int = 0


@dataclass(frozen=True, slots=True)
class IoBlock:
    """One entry of P31 or P32: PIC start byte, length in bytes, CAN identifier."""

    bus: int
    start: int
    length: int
    id: int


@dataclass(frozen=True, slots=True)
class OfKinematic:
    """One entry of P306; monitoring: sub-query 6, "Monitoring axis WC" (L5580-5596)."""

    monitoring: int = 0


@dataclass(frozen=True, slots=True)
class MeasuringSystem:
    """One [[rho3.P401]] table."""

    axis: int
    module: int
    ref_mode: int = 0
    gear_factor: float = 1.0
    pulses: int = 1  # 1 = 16384, 2 = 8192, 3 = 4096 increments per turn (rho3 2.6)
    evaluation: float = 16384.0  # negative together with output: direction reversed (rho3 2.9)
    output: int = 0


@dataclass(frozen=True, slots=True)
class Rho3:
    """[rho3]: machine parameters as printed; the ones the gateway uses are attributes, other legal numbers are kept."""

    P2: int = 0
    P5: int | None = None  # clock, ms
    P9: int = 40  # strobe of coded outputs, ms
    P15: tuple[int, ...] = ()
    P20: int | None = None
    P21: tuple[int, ...] = ()
    P24: int | str = "all"
    P30: tuple[IoBus, ...] = ()
    P31: tuple[IoBlock, ...] = ()
    P32: tuple[IoBlock, ...] = ()
    P103: tuple[float, ...] = ()
    P104: tuple[float, ...] = ()
    P108: tuple[float, ...] = ()
    P109: tuple[float, ...] = ()
    P204: tuple[float, ...] = ()
    P205: tuple[float, ...] = ()
    P207: tuple[float, ...] = ()
    P208: tuple[float, ...] = ()
    P303: tuple[int, ...] = ()
    P306: tuple[OfKinematic, ...] = ()
    P311: tuple[float, ...] = ()
    P313: tuple[tuple[int, ...], ...] = ()
    P401: tuple[MeasuringSystem, ...] = ()
    P601: bool = False
    others: Mapping[str, ParamValue] = field(default_factory=dict)


COMPONENTS = "xyzabc"  # P313
# Of `others`: what acts when P601 sends it to the boosters, and what acts in [controller] kind = "rho3".
DOWNLOADED = frozenset(("P114", *(f"P{number}" for number in range(602, 616))))
CONTROLLED = frozenset(("P3", "P11", "P13", "P14", "P25", "P27", "P36"))
