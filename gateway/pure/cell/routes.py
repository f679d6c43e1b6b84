"""[[route]] of a cell file as plain frozen data: two values joined, and what the target shows when the source is lost (AX-395)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Route:
    """One [[route]]; places are written as everywhere: DB30.DW0, RC 11.1, AW 92, K01_A_MN_RCI, axis.X.actual, order.number, io.lamp."""

    name: str
    from_: str
    to: str
    type: str = ""  # number form of the source's bytes; "": a bit, or a name that knows its own
    to_type: str = ""  # of the target; "": as type
    order: str = "ABCD"  # byte order of the source
    to_order: str = "ABCD"
    scale: float = 1.0  # target = source x scale + offset
    offset: float = 0.0
    edge: str = "level"  # level | rising | falling | change
    pulse_ms: int = 100  # rising, falling: so long the target is 1
    debounce_ms: int = 0
    every_ms: int = 0  # at most one change of the target in so long
    within_ms: int = 0  # what the plant needs from one command source to the other; 0: nothing said
    on_loss: str = "hold"  # hold | zero | value
    loss_value: float = 0.0
    loss_after_ms: int = 0
    valid: str = ""  # a bit that is 1 while the target shows the source
    life: str = ""  # a word that counts while the source lives
    comment: str = ""
