"""Meaning of an operand of a PLC program in axisgate: E and A bytes, flags, timers, counters.  Used by `axisgate explain`."""

from collections.abc import Iterator

from gateway.pure.controllers.reis.markers import meaning
from gateway.pure.controllers.rho3.signals.timers import flags_of
from gateway.pure.image.addresses import Kind, Operand
from gateway.pure.image.records.cell import RC_BYTES

Row = tuple[str, str, str, str]  # key, value, unit, source
WORDS = {
    Kind.INPUT: ("inputs of the PLC = RC outputs", "rho3 0.2"),
    Kind.OUTPUT: ("outputs of the PLC = RC inputs", "rho3 0.2"),
    Kind.FLAG: ("flags", "rho3 0.2"),
    Kind.TIMER: ("timer of the control, rest in ms", "rho3 3.5"),
    Kind.COUNTER: ("counter of the control", "rho3 3.5"),
}
FLAG_USES = (
    "counter {n}: counts down",
    "counter {n}: ready",
    "timer {n}: start",
    "timer {n}: ready",
    "timer {n}: active",
    "counter {n}: reset",
)


def operand_lines(place: Operand, controller: str) -> Iterator[Row]:
    """Rows for a table; `controller`: kind of [controller], "" for none."""
    words, source = WORDS[place.kind]
    if place.kind is Kind.FLAG and controller == "reis":
        words, source = "markers", "robotstar 5.2"
    yield str(place), words, "", source
    if place.kind in (Kind.TIMER, Kind.COUNTER):
        if place.number < 32:
            own = flags_of(place.number)
            first = own.start if place.kind is Kind.TIMER else own.decrement
            yield "flag", f"M {first // 8}.{first % 8}", "", "start" if place.kind is Kind.TIMER else "counts down"
        return
    size = place.bytes or 1
    if place.number + size <= RC_BYTES or place.kind is not Kind.FLAG:
        yield (
            "bits",
            f"{8 * place.number}..{8 * (place.number + size) - 1}" if place.bit is None else str(8 * place.number + place.bit),
            "",
            "",
        )
    if place.kind is Kind.FLAG and place.bit is not None:
        yield from _flag(place.number, place.bit, controller)


def _flag(byte: int, bit: int, controller: str) -> Iterator[Row]:
    if controller in ("", "rho3") and byte < 24:
        use, number = byte % 6, byte // 6 * 8 + bit
        yield "rho3", FLAG_USES[use].format(n=number), "", "rho3 3.5 (L4086-4113)"
    if controller in ("", "reis"):
        row = meaning(byte, bit)
        if row is not None:
            yield "Reis", row.name, "", f"written by {row.writer}{'' if row.done else ', not implemented in the original'}"
    if controller == "" and byte < 256:
        yield "line", "coordination flag of a partner's job", "", "read it with axisgate var"
