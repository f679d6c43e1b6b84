"""A recorded cell with belts: encoders are inputs of the run, and a synchronous part comes out again as it was (issue 7; AX-485)."""

from dataclasses import replace

import pytest

from gateway.pure.image.reasons import CommandState
from gateway.pure.recording.messages import Message, What, pack_frames, unpack_frames
from gateway.recording.file import RecordError
from gateway.recording.replay import replay
from hil_tests.lab.running.belt_run import FIRST_ID, SPEED
from hil_tests.lab.virtual.belt_bench import CELL
from hil_tests.lab.virtual.recorded_belts import RecordedBelts


@pytest.fixture(scope="module")
def carried() -> RecordedBelts:
    """The belt runs when the recording begins; then a part of type 1, and one of type 2."""
    cell = RecordedBelts()
    cell.drive(1, SPEED)
    cell.drive(2, SPEED)
    cell.run(0.1)
    cell.record()
    cell.run(0.1)
    assert cell.tap.on
    for kind, lines in (
        (1, ("synchron B1 at=60mm", "linear pose 150 150 50 0 0 0 belt=60mm", "synchron_end", "linear pose 100 100 50 0 0 0")),
        (2, ("synchron B2 at=60mm", "linear pose 150 150 50 0 0 0 belt=120mm", "synchron_end", "ptp joints 100 100 50 0")),
    ):
        cell.zero(kind)
        job = cell.finished(cell.order(*lines))
        assert job.state is CommandState.DONE, (kind, job)
    return cell


def test_a_part_on_a_belt_comes_out_as_it_was(carried: RecordedBelts) -> None:
    found = carried.found()
    verdict = replay(found, CELL, CELL)
    assert (verdict.first, verdict.without_outputs) == (None, 0)
    assert verdict.cycles > 500 and max(state.belt for state in carried.seen) > 0.1, "belts ran in it"
    assert found.segments[0].start["encoders"][0][2:] != [None, 0], "the start says how far the encoder had counted"


def test_an_encoder_that_said_something_else_parts_in_its_cycle(carried: RecordedBelts) -> None:
    messages = list(carried.messages)
    at = [n for n, message in enumerate(messages) if message.what is What.HEARD][10]
    bus, phase, frames = unpack_frames(messages[at].payload)
    turned = [frame._replace(data=b"\0\0\0\0") if frame.identifier == FIRST_ID + 1 else frame for frame in frames]
    assert turned != frames
    carried.messages[at] = Message(What.HEARD, pack_frames(bus, phase, turned))
    verdict = replay(carried.found(), CELL, CELL)
    carried.messages[at] = messages[at]
    assert verdict.first is not None and verdict.first.name in ("cell.belt", "cell.belt_speed")
    assert verdict.cycles == 11


def test_a_start_that_forgot_the_encoders_is_refused_and_other_belts_too(carried: RecordedBelts) -> None:
    found = carried.found()
    old = {name: value for name, value in found.segments[0].start.items() if name != "encoders"}
    with pytest.raises(RecordError, match="recorded before axisgate kept the encoders"):
        replay(replace(found, segments=[replace(found.segments[0], start=old)]), CELL, CELL)
    with pytest.raises(RecordError, match=r"other belts than the recording's \(B1, B2, B3\)"):
        replay(found, CELL, replace(CELL, belt=CELL.belt[:2]))


def test_where_the_encoders_stood_counts(carried: RecordedBelts) -> None:
    """Without it the first telegram would be a beginning, and the belt would stand still for a cycle."""
    found = carried.found()
    bare = {**found.segments[0].start, "encoders": []}
    verdict = replay(replace(found, segments=[replace(found.segments[0], start=bare)]), CELL, CELL)
    assert verdict.first is not None and verdict.cycles < 10
