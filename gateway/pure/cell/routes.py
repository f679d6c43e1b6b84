"""[[route]] of a cell file as plain frozen data: two joined values, and the target's value when the source is lost (AX-395)."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Le

from gateway.pure.cell.marks import Name, Unit

RouteForm = Literal["", "bit", "u8", "s8", "u16", "s16", "u32", "s32", "KF", "KH", "KM", "DH", "KZ", "KG", "REAL", "BCD"]


@dataclass(frozen=True, slots=True)
class Route:
    """One [[route]]; places are written as everywhere: DB30.DW0, RC 11.1, AW 92, K01_A_MN_RCI, axis.X.actual, order.number, io.lamp."""

    name: Name
    from_: str
    to: str
    type: RouteForm = ""  # number form of the source's bytes; "": a bit, or a name that knows its own
    to_type: RouteForm = ""  # of the target; "": as type
    order: Literal["ABCD", "CDAB", "BADC", "DCBA"] = "ABCD"  # byte order of the source
    to_order: Literal["ABCD", "CDAB", "BADC", "DCBA"] = "ABCD"
    scale: float = 1.0  # target = source x scale + offset
    offset: float = 0.0
    edge: Literal["level", "rising", "falling", "change"] = "level"
    pulse_ms: Annotated[int, Ge(1), Le(60000), Unit("ms")] = 100  # rising, falling: how long the target is 1
    debounce_ms: Annotated[int, Ge(0), Le(60000), Unit("ms")] = 0
    every_ms: Annotated[int, Ge(0), Le(3_600_000), Unit("ms")] = 0  # shortest time between changes of the target
    # time that the plant allows from one command source to the other; 0: unspecified
    within_ms: Annotated[int, Ge(0), Le(3_600_000), Unit("ms")] = 0
    on_loss: Literal["hold", "zero", "value"] = "hold"
    loss_value: float = 0.0
    loss_after_ms: Annotated[int, Ge(0), Le(3_600_000), Unit("ms")] = 0
    valid: str = ""  # a bit that is 1 while the target shows the source
    life: str = ""  # a word that counts while the source lives
    comment: str = ""
