"""[rho3] of a cell: machine parameters as the old controller has them printed.  Shapes: users.md 3.5."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, MaxLen, MinLen

from gateway.pure.cell.marks import Loaded, Unit, Why, frozen

OVERFLOW = "more do not fit a bus without axes either; the rho 3 shows 3732 CAN DP overflow, system error 149"
ParamValue = bool | int | float | str | tuple["ParamValue", ...] | Mapping[str, "ParamValue"]


@dataclass(frozen=True, slots=True)
class IoBus:
    """One entry of P30: digital I/O blocks of a bus; baud 0..3 = 1 Mbit/s, 500, 250, 125 kbit/s."""

    inputs: Annotated[int, Ge(0), Le(5), Unit("blocks"), Why(OVERFLOW)] = 0
    outputs: Annotated[int, Ge(0), Le(4), Unit("blocks"), Why(OVERFLOW)] = 0
    baud: Annotated[int, Ge(0), Le(3), Why("0 = 1 Mbit/s, 1 = 500 kbit/s, 2 = 250 kbit/s, 3 = 125 kbit/s")] = 0


@dataclass(frozen=True, slots=True)
class IoBlock:
    """One entry of P31 or P32: PIC start byte, length in bytes, CAN identifier."""

    bus: Annotated[int, Ge(1), Le(2)]
    start: Annotated[int, Ge(0), Le(127), Unit("PIC byte")]
    length: Annotated[int, Ge(1), Le(8), Unit("bytes")]
    id: Annotated[int, Ge(471), Le(550)]


@dataclass(frozen=True, slots=True)
class OutputBlock(IoBlock):
    """One entry of P32."""

    id: Annotated[int, Ge(471), Le(480)]


@dataclass(frozen=True, slots=True)
class OfKinematic:
    """One entry of P306; monitoring: sub-query 6, "Monitoring axis WC" (L5580-5596)."""

    monitoring: Annotated[int, Ge(0), Le(3)] = 0


@dataclass(frozen=True, slots=True)
class MeasuringSystem:
    """One [[rho3.P401]] table."""

    axis: Annotated[int, Ge(1), Le(12)]
    module: Annotated[int, Ge(1), Le(12)]
    ref_mode: Annotated[int, Ge(0), Le(3)] = 0
    gear_factor: Annotated[float, Gt(0)] = 1.0
    pulses: Annotated[int, Ge(1), Le(3)] = 1  # 1 = 16384, 2 = 8192, 3 = 4096 increments per turn (rho3 2.6)
    evaluation: float = 16384.0  # negative together with output: direction reversed (rho3 2.9)
    output: Annotated[int, Ge(-20), Le(20)] = 0


Speeds = tuple[Annotated[float, Gt(0), Unit("deg/s or mm/s")], ...]
Ways = tuple[Annotated[float, Unit("deg or mm")], ...]


@dataclass(frozen=True, slots=True)
class Rho3:
    """[rho3]: machine parameters as printed; the ones the gateway uses are attributes, other legal numbers are kept."""

    P2: Annotated[int, Ge(0), Le(15)] = 0
    P5: Annotated[int | None, Ge(2), Le(32), Unit("ms"), Why("boosters on CAN accept no cycle above 32 ms")] = None  # clock, ms
    P9: Annotated[int, Ge(1), Le(1000), Unit("ms")] = 40  # strobe of coded outputs, ms
    P15: tuple[Annotated[int, Ge(0), Le(20)], ...] = ()
    P20: Annotated[int | None, Ge(0), Le(99)] = None
    P21: tuple[Annotated[int, Ge(0), Le(250), Unit("byte")], ...] = ()
    P24: int | Literal["all"] = "all"
    P30: Annotated[tuple[IoBus, ...], MaxLen(2)] = ()
    P31: tuple[IoBlock, ...] = ()
    P32: tuple[OutputBlock, ...] = ()
    P103: Speeds = ()
    P104: Speeds = ()
    P108: Speeds = ()
    P109: Speeds = ()
    P204: Ways = ()
    P205: Ways = ()
    P207: Ways = ()
    P208: Ways = ()
    P303: tuple[Annotated[int, Ge(0), Le(4)], ...] = ()
    P306: tuple[OfKinematic, ...] = ()
    P311: Ways = ()
    P313: tuple[Annotated[tuple[Annotated[int, Ge(0), Le(24)], ...], MinLen(6), MaxLen(6)], ...] = ()
    P401: tuple[MeasuringSystem, ...] = ()
    P601: bool = False
    others: Annotated[Mapping[str, ParamValue], Loaded(frozen)] = field(default_factory=dict)


COMPONENTS = "xyzabc"  # P313
ENDLESS = (3, 4)  # P303
COUPLED = (2, 15, 16, 19)  # P20: with a bit coupling
# Parameters of `others` that act when P601 sends them to the boosters, and those that act in [controller] kind = "rho3".
DOWNLOADED = frozenset(("P114", *(f"P{number}" for number in range(602, 616))))
JOGGED = frozenset(("P113", "P114", "P128"))  # act on jog keys of the page, the last two in addition to P113
CONTROLLED = frozenset(("P3", "P11", "P13", "P14", "P25", "P27", "P35", "P36", "P212", "P213", "P214"))
