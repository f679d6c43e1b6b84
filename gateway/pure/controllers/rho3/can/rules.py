"""Judges the CAN configuration of a rho 3 (P5, P15, P30, P31, P32, P401) as its start-up would, with the control's own numbers.

Source: rho 3 Releases part 5, 6.2, 6.9-6.14 (L7256-7527); coupling: part 8, 11.1.2 (L10970-10998).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gateway.pure.controllers.rho3.can.tables import (
    AXES,
    BLOCK_BYTES,
    CAN_MODULES,
    FIRST_PLACE_ONLY,
    IMAGE_BYTES,
    INPUT_BLOCKS,
    INPUT_IDS,
    NO_SERVO_I,
    OUTPUT_BLOCKS,
    OUTPUT_IDS,
    P5_MAX_MS,
    P5_WATCHDOG_MS,
    RATES,
    Side,
    fits,
    kbit_s,
    room,
    table,
)
from gateway.pure.image.system_errors import system_number


@dataclass(frozen=True, slots=True)
class Block:
    """One entry of P31 or P32."""

    start: int  # first PIC byte, 0..127
    length: int  # bytes transferred, 1..8
    identifier: int

    @property
    def span(self) -> range:
        """PIC bytes."""
        return range(self.start, self.start + self.length)


@dataclass(frozen=True, slots=True)
class BusSetup:
    """One CAN bus: axes of P401 on it, numbers of P30, blocks of P31 and P32."""

    axes: int = 0
    input_blocks: int = 0  # P30
    output_blocks: int = 0
    baud: int = 0
    inputs: tuple[Block, ...] = ()  # P31
    outputs: tuple[Block, ...] = ()  # P32

    def blocks(self, side: Side) -> tuple[Block, ...]:
        return self.inputs if side is Side.INPUT else self.outputs

    def announced(self, side: Side) -> int:
        return self.input_blocks if side is Side.INPUT else self.output_blocks


@dataclass(frozen=True, slots=True)
class Setup:
    """All the parameters that decide whether the CAN module starts."""

    p5_ms: int
    buses: tuple[BusSetup, ...]
    p15: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing the control would not start with."""

    code: int  # number of the manual, 0: it has none
    text: str  # what the pendant shows, or our words
    parameter: str  # P number to look at
    value: str  # the present value
    hint: str

    @property
    def system_error(self) -> int:
        """3732 = system error 149; 0: it has no number."""
        return system_number(self.code) if self.code else 0


OVERFLOW, BAUD, UNDEFINED = 3732, 3733, 3734
TEXTS = {OVERFLOW: "CAN DP overflow", BAUD: "CAN incorr. BAUDR.", UNDEFINED: "CAN I/O block undef."}  # L7489-7500


def judge(setup: Setup) -> list[Finding]:
    """Everything wrong, clock and boards first, then bus by bus."""
    found = [*_clock(setup), *_boards(setup.p15)]
    for number, bus in enumerate(setup.buses, 1):
        found += [*_rate(number, bus), *_overflow(number, bus), *_undefined(number, bus), *_identifiers(number, bus)]
    return found + list(_overlaps(setup.buses))


def _clock(setup: Setup) -> Iterator[Finding]:
    if not any(bus.axes for bus in setup.buses):
        return
    if setup.p5_ms > P5_MAX_MS:
        yield Finding(0, "clock too slow for the boosters", "P5", f"{setup.p5_ms} ms", f"with CAN axes at most {P5_MAX_MS} ms (L7322)")
    elif setup.p5_ms > P5_WATCHDOG_MS and all(board in NO_SERVO_I for board in setup.p15):
        hint = f"at most {P5_WATCHDOG_MS} ms without an additional SERVO-i in P15 (watchdog of the control, L7322-7324)"
        yield Finding(0, "clock too slow without SERVO-i", "P5", f"{setup.p5_ms} ms", hint)


def _boards(p15: Sequence[int]) -> Iterator[Finding]:
    modules = [place for place, board in enumerate(p15, 1) if board in CAN_MODULES]
    if len(modules) > 1:
        yield Finding(0, "two CAN modules", "P15", f"places {modules}", "two CAN modules are not possible (L7320)")
    for place, board in enumerate(p15, 1):
        if board in FIRST_PLACE_ONLY and place > 1:
            yield Finding(0, "board on the wrong place", "P15", f"{board} at place {place}", "types 5 and 6 only at place 1 (L7318-7319)")


def _rate(number: int, bus: BusSetup) -> Iterator[Finding]:
    if not kbit_s(bus.baud):
        codes = ", ".join(f"{code} = {rate.kbit_s} kbit/s" for code, rate in RATES.items())
        yield Finding(0, "no such bit rate", "P30", f"baud = {bus.baud}", codes)
    elif bus.axes and bus.baud:
        hint = f"bus {number} carries axes: 1 Mbit/s, baud = 0"
        yield Finding(BAUD, TEXTS[BAUD], "P30", f"baud = {bus.baud}", hint)


def _overflow(number: int, bus: BusSetup) -> Iterator[Finding]:
    if bus.axes > AXES:
        yield Finding(
            OVERFLOW, TEXTS[OVERFLOW], "P401", f"{bus.axes} axes", f"at most {AXES} axes on a bus; use the other one for axes 7..12"
        )
    for side, most in ((Side.INPUT, INPUT_BLOCKS), (Side.OUTPUT, OUTPUT_BLOCKS)):
        count = bus.announced(side)
        size = count * BLOCK_BYTES
        if fits(bus.axes, size if side is Side.INPUT else 0, size if side is Side.OUTPUT else 0) and count <= most:
            continue
        left = room(bus.axes)
        bytes_left = left.inputs if side is Side.INPUT else left.outputs
        hint = f"{bus.axes} axes on bus {number} leave {bytes_left} bytes of {side.word}s; bytes by axes: {table(side)}; use the other bus"
        yield Finding(OVERFLOW, TEXTS[OVERFLOW], "P30", f"{count} {side.word} blocks", hint)


def _undefined(number: int, bus: BusSetup) -> Iterator[Finding]:
    for side in Side:
        count, here = bus.announced(side), len(bus.blocks(side))
        if here != count:
            hint = f"P30 announces {count} {side.word} blocks on bus {number}"
            code = UNDEFINED if here < count else 0
            yield Finding(code, TEXTS[UNDEFINED] if code else "more blocks than P30 announces", side.value, f"{here} blocks", hint)
        for block in bus.blocks(side):
            if not (1 <= block.length <= BLOCK_BYTES and block.start >= 0 and block.span.stop <= IMAGE_BYTES):
                value = f"start {block.start}, length {block.length}"
                yield Finding(UNDEFINED, TEXTS[UNDEFINED], side.value, value, "bytes 0..127 of the PIC image, 1..8 of them")


def _identifiers(number: int, bus: BusSetup) -> Iterator[Finding]:
    seen: set[int] = set()
    for side in Side:
        for block in bus.blocks(side):
            key, value = side.value, f"bus, id = {(number, block.identifier)}"
            if side is Side.OUTPUT and block.identifier not in OUTPUT_IDS:
                yield Finding(UNDEFINED, TEXTS[UNDEFINED], key, f"id = {block.identifier}", "outputs are sent with 471..480")
            elif side is Side.INPUT and block.identifier not in INPUT_IDS and block.identifier not in OUTPUT_IDS:
                hint = "modules send 541..550; 471..480 connects another rho 3"
                yield Finding(UNDEFINED, TEXTS[UNDEFINED], key, f"id = {block.identifier}", hint)
            if block.identifier in seen:
                hint = "this identifier is used twice on its bus; two controls on a bus must not send the same one (L10998)"
                yield Finding(0, "identifier twice", key, value, hint)
            seen.add(block.identifier)


def _overlaps(buses: Sequence[BusSetup]) -> Iterator[Finding]:
    for side in Side:
        covered: dict[int, int] = {}
        blocks = [block for bus in buses for block in bus.blocks(side)]
        for number, block in enumerate(blocks, 1):
            clash = next((byte for byte in block.span if byte in covered), None)
            if clash is not None:
                hint = f"byte {clash} belongs to block {covered[clash]} already"
                yield Finding(0, "bytes twice", side.value, f"start {block.start}", hint)
            covered.update(dict.fromkeys(block.span, number))
