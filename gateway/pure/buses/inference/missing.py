"""What a recording lacks for a better proposal, in words, for the next recording."""

from collections import Counter
from collections.abc import Sequence

from gateway.pure.buses.inference.roles import SET_CHAIN, Inferred
from gateway.pure.buses.inference.series import LEAST
from protocols.base.machine import Frame


def no_cycle(frames: Sequence[Frame]) -> str:
    """Why nothing in it counts as cyclic."""
    if not frames:
        return "the recording contains no data frame"
    counts = Counter(frame.identifier for frame in frames if frame.data)
    if not counts:
        return f"{len(frames)} frames, all of them without data: set values and actual values are missing"
    number, times = counts.most_common(1)[0]
    if times < LEAST:
        return f"{len(frames)} frames: a cycle is seen from {LEAST} messages on; identifier {number}, the most frequent, came {times} times"
    return f"{len(frames)} frames: no message with data has a steady cycle"


def missing(found: Inferred) -> list[str]:
    """What was not in the recording; nothing when the data of every axis are complete."""
    positions = sorted({each.identifier for each in found.signals if each.name == "position_inc"})
    if not found.axes:
        return [_no_position(found)] if not positions else [_no_follower(positions)]
    sentences = []
    for name, todo in zip(SET_CHAIN, ("switch the drives on", "let them take control"), strict=True):
        without = [axis.number for axis in found.axes if not any(each.name == name for each in found.of(axis.set_id))]
        if without:
            sentences.append(f"axis {_list(without)}: no bit of the set value rises as {name}; begin with drives off, then {todo}")
    without = [axis.number for axis in found.axes if not any(each.name == "reference_switch" for each in found.of(axis.actual_id))]
    if without:
        sentences.append(
            f"axis {_list(without)}: no bit changes at one place of the way; move over the reference switch in both directions"
        )
    return sentences


def _no_position(found: Inferred) -> str:
    still = sum(not any(series.flips(bit) for bit in range(8 * series.length)) for series in found.cycles.messages)
    count = len(found.cycles.messages)
    if still == count:
        return f"none of the {count} cyclic messages ever changes: nothing was switched or moved"
    return (
        f"none of the {count} cyclic messages ({still} never change) contains a number that moves as a position does: "
        "record moves of every axis, longer than a motor turn, with a rest before and after"
    )


def _no_follower(positions: Sequence[int]) -> str:
    if len(positions) == 1:
        return f"only identifier {positions[0]} contains a position: set values and actual values must be in one recording"
    return (
        f"identifiers {_list(positions)} hold positions, but none follows another within a few cycles: set values or actual values are "
        "missing, or the axes did not move"
    )


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))
