"""`axisgate bus infer` on recordings that lack something: it says in words what to record (AX-271)."""

import pytest

from gateway.pure.buses.inference.missing import missing
from gateway.pure.buses.inference.proposal import NothingFound, propose
from gateway.tools.bus.infer import as_json, finding_lines
from hil_tests.lab.virtual.bus_recording import P5, START, record
from hil_tests.unit.gateway.pure.buses.inference.test_three_other_layouts import SHIPPED
from protocols.base.machine import Frame

WHOLE = record(SHIPPED).frames
ACTUAL = range(610, 640)


def between(begin: float, end: float) -> list[Frame]:
    """A part of the recording, in seconds from its start."""
    return [frame for frame in WHOLE if START + begin * 1e9 <= frame.stamp_ns < START + end * 1e9]


@pytest.mark.parametrize(
    "frames, words",
    [
        ([], "no data frame"),
        ([Frame(100, b"", n * P5) for n in range(300)], "all of them without data"),
        (between(0.0, 0.2), "identifier 210, the most frequent, came 50 times"),
    ],
)
def test_no_cycle(frames: list[Frame], words: str) -> None:
    with pytest.raises(NothingFound, match=words):
        propose(frames)


def test_drives_that_stood_off_all_the_time() -> None:
    still = [frame._replace(data=bytes(8)) if frame.data else frame for frame in between(0.0, 0.8)]
    found = propose(still)
    assert missing(found) == ["none of the 6 cyclic messages ever changes: nothing was switched or moved"]
    assert "missing: none of the 6 cyclic messages" in "\n".join(finding_lines(found, None)) and as_json(found)["missing"] == missing(found)


def test_drives_that_were_switched_on_and_never_moved() -> None:
    (words,) = missing(propose(between(0.0, 0.85)))
    assert "no" not in words.split(":")[0].split()[:1] and "record moves of every axis" in words, words


def test_only_one_side_was_recorded() -> None:
    (words,) = missing(propose([frame for frame in WHOLE if frame.identifier not in ACTUAL]))
    assert "210, 220, 230 hold positions, but none follows another" in words


def test_a_recording_that_began_with_drives_on_and_passed_no_switch() -> None:
    found = propose(between(2.2, 4.1))
    words, axes = missing(found), ", ".join(str(axis.number) for axis in found.axes)
    assert len(found.axes) >= 2 and [line.partition(":")[0] for line in words] == [f"axis {axes}"] * 3
    assert ["drive_on" in words[0], "enable" in words[1], "reference switch" in words[2]] == [True] * 3


def test_a_whole_recording_lacks_nothing() -> None:
    assert missing(propose(WHOLE)) == []
