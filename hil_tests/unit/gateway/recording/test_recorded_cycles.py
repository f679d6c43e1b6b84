"""What the cycle hands to a recorder, played again: the same core makes the same outputs, a changed one parts where it must."""

import enum
import json
import pickle
from dataclasses import replace
from typing import Any

import pytest

from gateway.assembly.axes import core_axes
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.cell import FollowingError
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.fast_inputs import FastWires, InputLevel, Wire
from gateway.pure.image.records.cell import AxisFlag
from gateway.pure.recording.messages import Message, What
from gateway.pure.recording.player import Difference, Player
from gateway.recording.states import Snapshots, Start, StateError, carry_over, frozen
from hil_tests.lab.virtual.cell_bench import DEMO, FAMILY, CellBench
from hil_tests.lab.virtual.recorded_bench import RecordedBench, cycles_of
from protocols.base.errors import DecodeError

TARGET = (60.0, 50.0, 30.0, 5.0, 5.0, 5.0)


@pytest.fixture(scope="module")
def moved() -> RecordedBench:
    """Asked for during a move of a referenced cell; then another move, a silent drive, an emergency stop."""
    cell = RecordedBench().ready()
    assert isinstance(cell, RecordedBench)
    move = cell.give(Code.PTP_ABSOLUTE, targets=(10.0,) * 6)
    cell.run(0.05)
    cell.record()
    cell.run(0.02)
    assert move.open and not cell.tap.on and not cell.messages, "it waits until nothing moves"
    cell.settle(move)
    cell.run(0.1)
    cell.settle(cell.give(Code.PTP_ABSOLUTE, targets=TARGET))
    cell.silent = {2}
    cell.run(0.05)
    cell.silent = set()
    cell.permit(24, value=False)
    cell.run(0.2)
    return cell


def start_of(cell: RecordedBench) -> Any:
    """As the file keeps it."""
    pickled = next(payload for what, payload in cell.messages if what is What.START)
    state = pickle.loads(pickled)
    return json.loads(
        json.dumps({"core": frozen(state.core), "families": frozen(state.families), "late": state.late, "sent": state.sent_ns})
    )


def enums_of(tree: Any) -> list[Any]:
    """Members of enumerations, in the order of the state."""
    if isinstance(tree, dict) and "enum" in tree:
        return [tree]
    inner = tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ()
    return [found for each in inner for found in enums_of(each)]


def player(start: Any, cell: CellBench | None = None, wires: FastWires | None = None) -> Player:
    """A new core of the demo, or of `cell`, in the recorded state."""
    core = (cell or CellBench()).core
    pristine = CellBench().core
    families = [FAMILY]
    carried = carry_over(start["core"], frozen(pristine), core, Snapshots(core, families).settings)
    return Player(carried, families, start["late"], start["sent"], lambda number: f"rc_out.{number}", wires=wires)


def play(played: Player, messages: list[Message]) -> list[Difference]:
    first = [payload for what, payload in messages if what is What.IMAGE][:1]
    for payload in first:
        played.prepare_image(payload)
    return [difference for script in cycles_of(messages) for difference in played.play(script)]


def test_the_same_core_makes_the_same_outputs_from_a_start_in_the_middle_of_a_run(moved: RecordedBench) -> None:
    outputs = sum(message.what is What.OUTPUTS for message in moved.messages)
    played = player(start_of(moved))
    assert play(played, moved.messages) == [] and outputs > 100
    assert played.core.state.emergency and played.core.state.cycle == moved.core.state.cycle


def test_inputs_the_cycle_heard_itself_go_over_the_recorded_image(moved: RecordedBench) -> None:
    """AX-481: here one says that the chain is open, which the services never said."""
    chain = FastWires([Wire(24, False, lambda: InputLevel(False, 1))])
    differences = play(player(start_of(moved), wires=chain), moved.messages)
    assert differences and "cell.permits" in {difference.name for difference in differences[:20]}


def test_a_state_is_handed_over_where_python_reduces_enumerations_by_getattr(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python before 3.11.4 does, Debian 12's among them; the recorder then met a part left out that was to be called."""
    cell = CellBench().ready()
    expected = frozen(cell.core)
    monkeypatch.setattr(enum.Enum, "__reduce_ex__", lambda self, protocol: (getattr, (type(self), self._name_)))
    state = pickle.loads(Snapshots().take(Start(cell.core, [FAMILY], [0], [0])))
    assert enums_of(frozen(state.core)) == enums_of(expected) != []


def test_a_start_that_is_left_out_parts_at_once(moved: RecordedBench) -> None:
    fresh = Player(CellBench().core, [FAMILY], [0], [0])
    assert "cell.cycle" in {difference.name for difference in play(fresh, moved.messages)[:20]}


def test_another_limit_parts_in_the_cycle_in_which_it_counts(moved: RecordedBench) -> None:
    tight = replace(DEMO, axis=tuple(replace(axis, following_error=FollowingError(0.05, 0.1)) for axis in DEMO.axis))
    differences = play(player(start_of(moved), CellBench(cell=tight)), moved.messages)
    first = differences[0]
    assert first.name.startswith("axis.") and first.name.endswith(".flags")
    assert isinstance(first.got, AxisFlag) and isinstance(first.expected, AxisFlag)
    assert first.got & ~first.expected == AxisFlag.WARNING


def test_an_output_that_was_another_is_named_with_what_was_expected(moved: RecordedBench) -> None:
    messages = list(moved.messages)
    at = [n for n, message in enumerate(messages) if message.what is What.OUTPUTS][50]
    spoilt = bytearray(messages[at].payload)
    spoilt[-128 + 64 // 8] ^= 1  # RC output 64
    messages[at] = Message(What.OUTPUTS, bytes(spoilt))
    (difference,) = play(player(start_of(moved)), messages)
    assert (difference.name, difference.expected, difference.got) == ("rc_out.64", 0, 1)


def test_a_frame_that_was_another_is_named(moved: RecordedBench) -> None:
    messages = list(moved.messages)
    at = [n for n, message in enumerate(messages) if message.what is What.SENT][50]
    messages[at] = Message(What.SENT, messages[at].payload[:-1] + b"\x77")
    assert [difference.name for difference in play(player(start_of(moved)), messages)] == ["bus 1 sends"]


def test_a_script_that_cannot_be_played_is_a_decode_error(moved: RecordedBench) -> None:
    played = player(start_of(moved))
    with pytest.raises(DecodeError, match="cannot be played"):
        list(played.play([Message(What.BEGIN, b"\0" * 12), Message(What.ORDER, b"\xff")]))


def test_recording_begins_at_rest_with_its_start(moved: RecordedBench) -> None:
    assert moved.messages[0].what is What.START and moved.messages[1].what is What.IMAGE
    assert sum(message.what is What.START for message in moved.messages) == 1


def test_a_cycle_nobody_records_any_more_falls_silent() -> None:
    cell = RecordedBench()
    cell.record()
    cell.run(0.1)
    assert cell.tap.on
    cell.tap.turn(cell.now + 31_000_000_000)
    assert not cell.tap.on and cell.bus.tap is None


def test_a_state_with_a_class_that_is_none_of_ours_is_refused() -> None:
    core: CycleLogic = CellBench().core
    tree = frozen(core)
    tree["has"]["state"] = {"object": "subprocess:Popen", "has": {}, "number": 1}
    with pytest.raises(StateError, match="no class of a state"):
        carry_over(tree, frozen(CellBench().core), core, [])


def test_settings_come_from_the_cell_that_is_played() -> None:
    """A state says nothing of limits: those of the other cell stay."""
    tight = replace(DEMO, axis=tuple(replace(axis, following_error=FollowingError(0.05, 0.1)) for axis in DEMO.axis))
    core = CycleLogic(core_axes(tight, 4), 0.004, 1)
    carried = carry_over(frozen(CellBench().core), frozen(CellBench().core), core, Snapshots(core).settings)
    assert carried.plans[0].lag_trip == pytest.approx(0.0001)
