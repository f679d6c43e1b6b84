"""The text form of inputs around a block: wait= and delay= (fast start-off), measure_on and measure_off (flying measurement), set_latch
(VAL 3), record_on and record_off (reference path)."""

import re
from collections.abc import Callable, Mapping

from motion.geometry.units import from_si, to_si
from motion.measure.latch import FAST_INPUTS
from motion.measure.record import ENTRIES
from motion.program.blocks import Called, Flying, Latching, Recording, StartWait
from motion.program.text.words import Fault, number, one

HEADS = ("measure_on", "measure_off")
LONGEST_DELAY_S = 3600.0
_INPUT = re.compile(r"(!?)(ch)?(\d+)")
_DISTANCE = re.compile(r"([-+0-9.eE]+)(mm|deg|cycles)")
_CHANNEL = re.compile(r"ch(\d+)")


def wait_of(keys: Mapping[str, str]) -> StartWait | None:
    """WAIT UNTIL directly before the movement, and MAX_TIME."""
    if "wait" not in keys:
        if "delay" in keys:
            raise Fault("delay", "belongs to wait=: the time from its input to the begin of the block")
        return None
    match = _INPUT.fullmatch(keys["wait"])
    if match is None:
        raise Fault("wait", f"{keys['wait']!r}: the number of an input (464) or a channel (ch611), with ! in front for its being 0")
    wanted, delay = int(match[3]), number("delay", keys.get("delay", "0"), 0.0, LONGEST_DELAY_S, "s")
    return StartWait(0 if match[2] else wanted, not match[1], wanted if match[2] else 0, delay)


def flying_of(head: str, rest: list[str]) -> Flying:
    """SF 43 and SF 44; edge 1 is the positive one (rho3 D-25)."""
    match = _CHANNEL.fullmatch(rest[0]) if rest else None
    if match is None or len(rest) > 2 or (head == "measure_off" and len(rest) > 1):
        raise Fault(head, "the channel of a probe: measure_on ch610, measure_on ch610 edge=0, measure_off ch610")
    if head == "measure_off":
        return Flying(int(match[1]), None)
    edges = {"edge=1": True, "edge=0": False}
    word = rest[1] if len(rest) > 1 else "edge=1"
    if word not in edges:
        raise Fault("edge", f"{word!r}; edge=1 (positive) or edge=0 (negative)")
    return Flying(int(match[1]), edges[word])


def latching_of(head: str, rest: list[str]) -> Latching:
    """setLatch."""
    if (name := one(head, rest)) not in FAST_INPUTS:
        raise Fault(head, f"{name} is not a fast input, {' and '.join(FAST_INPUTS)} are (VAL 3 70)")
    return Latching(name)


def recording_of(head: str, rest: list[str]) -> Recording:
    """SF 29: measuring system and distance; SF 30."""
    if head == "record_off":
        if rest:
            raise Fault(head, f"{' '.join(rest)} is too much")
        return Recording()
    found = _DISTANCE.fullmatch(rest[1]) if len(rest) == 2 else None
    if found is None or not rest[0].isdecimal() or rest[0] == "0":
        raise Fault(head, "measuring system from 1 on, and distance: record_on 1 13mm, record_on 4 5deg, record_on 1 10cycles")
    distance = number(head, found[1], 1e-6, 1e6, found[2])
    if found[2] == "cycles":
        if distance != int(distance):
            raise Fault(head, f"{distance:g}: a whole number of cycles")
        return Recording(int(rest[0]), distance, "cycles")
    return Recording(int(rest[0]), to_si(distance, found[2]), found[2])


def entry_of(words: list[str]) -> int:
    """`recorded N`."""
    if len(words) != 1 or not words[0].isdecimal() or not 1 <= int(words[0]) <= ENTRIES:
        raise Fault("recorded", f"{' '.join(words)!r}: an entry of the reference path, 1 (the latest) .. {ENTRIES}")
    return int(words[0])


def called(call: Called) -> str:
    """The statement of a call."""
    match call:
        case Flying():
            return f"measure_off ch{call.channel}" if call.edge is None else f"measure_on ch{call.channel} edge={int(call.edge)}"
        case Latching():
            return f"set_latch {call.name}"
        case Recording():
            far = call.distance if call.unit == "cycles" else from_si(call.distance, call.unit)
            return f"record_on {call.system} {far:.13g}{call.unit}" if call.system else "record_off"
    numbers = (call.number, call.kinematic, call.coordinate, call.position, call.value, call.time_ms)
    return " ".join(["ppo" if call.ppo else "iol", *(f"{value:.13g}" for value in numbers)])


FUNCTIONS: dict[str, Callable[[str, list[str]], Called]] = {
    **dict.fromkeys(HEADS, flying_of),
    "set_latch": latching_of,
    **dict.fromkeys(("record_on", "record_off"), recording_of),
}
