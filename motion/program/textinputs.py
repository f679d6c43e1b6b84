"""The text form of inputs around a block: wait= and delay= (fast start-off), measure_on and measure_off (flying measurement)."""

import re
from collections.abc import Mapping

from motion.program.blocks import Flying, StartWait
from motion.program.textwords import Fault, number

HEADS = ("measure_on", "measure_off")
LONGEST_DELAY_S = 3600.0
_INPUT = re.compile(r"(!?)(ch)?(\d+)")
_CHANNEL = re.compile(r"ch(\d+)")


def wait_of(keys: Mapping[str, str]) -> StartWait | None:
    """WAIT UNTIL directly before the movement, and MAX_TIME."""
    if "wait" not in keys:
        if "delay" in keys:
            raise Fault("delay", "belongs to wait=: so long after its input the block begins")
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
