"""Bit numbers of axisgate's own signals, which may be moved, out of the signal list (AX-002, AX-503)."""

from dataclasses import dataclass

from gateway.pure.image.signals import SignalList


@dataclass(frozen=True, slots=True)
class Numbers:
    """As shipped; `numbers_of` reads them from a list."""

    chain: int = 24  # RC input
    emergency: int = 67  # RC output
    first_output: int = 384  # RC output, USER_1_RCO
    first_integer: int = 608  # RC input, INTIN_0_RCI: eight bytes from here
    first_strobe: int = 672  # RC input, INTSTB_401_RCI


NAMES = {
    "chain": "EMSTOP_OK_RCI",
    "emergency": "EMSTOP_RCO",
    "first_output": "USER_1_RCO",
    "first_integer": "INTIN_0_RCI",
    "first_strobe": "INTSTB_401_RCI",
}
AS_SHIPPED = Numbers()


def numbers_of(signals: SignalList) -> Numbers:
    """The numbers as the (moved) list has them; ValueError: INTEGER inputs that begin inside a byte."""
    found = {field: signal.at.number for field, name in NAMES.items() if (signal := signals.named(name)) is not None}
    numbers = Numbers(**found)
    if numbers.first_integer % 8:
        raise ValueError(f"INTIN_0_RCI at {numbers.first_integer}: INTEGER inputs begin at a whole byte")
    return numbers
