"""Command dispatcher: who may command, what is refused and with which reason, and that a command is taken once."""

import struct

import pytest

from gateway.pure.arbitration.command_block import (
    COMMAND_WORDS,
    STATUS_WORDS,
    TOGGLE,
    Code,
    Command,
    CommandBlock,
    Status,
    real,
    real_words,
)
from gateway.pure.arbitration.jobs import OnLoss
from gateway.pure.arbitration.link_watch import LinkEvent, LinkWatch
from gateway.pure.arbitration.ownership import NOBODY, Ownership
from gateway.pure.image.reasons import CommandState, Reason, Refusal, text
from gateway.pure.image.records.cell import CellState, Motion
from hil_tests.lab.virtual.cell_bench import ALL, CellBench
from protocols.base.machine import ms

FAR = (1200.0, 800.0, 500.0, 120.0, -80.0, 250.0)
KG_1200_5_AS_REAL = struct.unpack(">f", bytes.fromhex("0B4B0800"))[0]


class TestControl:
    def test_one_source_at_a_time_and_the_refusal_names_the_owner(self) -> None:
        control = Ownership()
        with pytest.raises(Refusal, match="does not have control: no command source has it; request it first"):
            control.demand(2)
        assert control.request(1, at_rest=True)
        with pytest.raises(Refusal, match="does not have control: command source 1 has it") as refusal:
            control.request(2, at_rest=True)
        assert refusal.value.reason is Reason.NOT_OWNER
        control.release(1, at_rest=True)
        assert control.request(2, at_rest=True)

    def test_granted_and_released_only_at_rest(self) -> None:
        control = Ownership()
        with pytest.raises(Refusal):
            control.request(1, at_rest=False)
        control.request(1, at_rest=True)
        with pytest.raises(Refusal):
            control.release(1, at_rest=False)
        assert control.owner == 1

    def test_a_dead_owner_may_be_replaced_and_is_the_owner_until_then(self) -> None:
        control = Ownership()
        control.request(1, at_rest=True)
        control.link(1, alive=False)
        assert control.owner == 1
        assert control.request(2, at_rest=True)
        assert control.owner == 2

    def test_asking_again_changes_nothing(self) -> None:
        control = Ownership()
        control.request(1, at_rest=True)
        assert not control.request(1, at_rest=False)
        assert NOBODY == 0


class TestDispatcher:
    def test_commands_of_others_are_refused_except_stop(self) -> None:
        cell = CellBench().ready()
        assert cell.give(Code.PTP_ABSOLUTE, targets=FAR, source=2).reason is Reason.NOT_OWNER
        move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.5)
        assert cell.settle(cell.give(Code.STOP, source=2)).state is CommandState.DONE
        assert (move.state, move.reason, move.detail) == (CommandState.RUNNING, Reason.STOPPED_BY_SOURCE, "2")

    @pytest.mark.parametrize(
        ("targets", "reason"),
        [
            ((1500.1,), Reason.TARGET_LIMIT),
            ((-5.1,), Reason.TARGET_LIMIT),
            ((KG_1200_5_AS_REAL,), Reason.FORMAT_SUSPICION),
            ((1e-7,), Reason.FORMAT_SUSPICION),
            ((float("nan"),), Reason.FORMAT_SUSPICION),
            ((float("inf"),), Reason.FORMAT_SUSPICION),
            ((15051.0,), Reason.FORMAT_SUSPICION),
        ],
    )
    def test_targets_out_of_limits_or_in_a_wrong_format(self, targets: tuple[float, ...], reason: Reason) -> None:
        cell = CellBench().ready()
        job = cell.give(Code.PTP_ABSOLUTE, mask=1, targets=targets)
        assert (job.state, job.reason) == (CommandState.REFUSED, reason)
        assert "A1" in job.detail
        cell.run(0.2)
        assert cell.core.state.motion is Motion.IDLE

    def test_the_sentence_for_a_wrong_format_names_it(self) -> None:
        cell = CellBench().ready()
        job = cell.give(Code.PTP_ABSOLUTE, mask=1, targets=(KG_1200_5_AS_REAL,))
        assert "looks like KG read as IEEE" in text(job.reason, "en", job.detail)

    @pytest.mark.parametrize("value", [0.0, -5.0, 1500.0])
    def test_targets_on_the_limits_and_a_plain_zero_are_taken(self, value: float) -> None:
        cell = CellBench().ready()
        assert cell.give(Code.PTP_ABSOLUTE, mask=1, targets=(value,)).state is CommandState.ACCEPTED

    def test_relative_moves_add_to_the_set_position(self) -> None:
        cell = CellBench().ready()
        before = cell.set()[0]
        assert cell.settle(cell.give(Code.PTP_RELATIVE, mask=1, targets=(25.0,))).state is CommandState.DONE
        assert cell.set()[0] == pytest.approx(before + 25.0, abs=1e-9)

    @pytest.mark.parametrize("mask", [0, 0x40, 0x1000])
    def test_masks_without_axes_of_this_cell(self, mask: int) -> None:
        cell = CellBench().ready()
        assert cell.give(Code.PTP_ABSOLUTE, mask=mask).reason is Reason.MASK

    def test_rates_and_codes_out_of_range(self) -> None:
        cell = CellBench().ready()
        for velocity in (0.0, 1.0001):
            assert cell.give(Code.PTP_ABSOLUTE, velocity=velocity, targets=FAR).reason is Reason.RATE
        assert cell.give(Code.OVERRIDE, velocity=1.01).reason is Reason.RATE
        assert cell.dispatcher.command(1, Command(99), cell.now).reason is Reason.UNKNOWN_CODE

    def test_a_move_while_one_runs_or_waits_is_refused(self) -> None:
        cell = CellBench().ready()
        cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.3)
        assert cell.give(Code.PTP_ABSOLUTE, targets=FAR).reason is Reason.BUSY
        cell.settle(cell.give(Code.STOP))
        assert cell.give(Code.PTP_ABSOLUTE, targets=FAR).reason is Reason.BUSY

    def test_override_0_would_move_nothing_and_says_so(self) -> None:
        cell = CellBench().ready()
        cell.settle(cell.give(Code.OVERRIDE, velocity=0.0))
        assert cell.give(Code.PTP_ABSOLUTE, targets=FAR).reason is Reason.OVERRIDE_ZERO

    def test_a_new_owner_does_not_inherit_the_rest_of_a_move(self) -> None:
        cell = CellBench().ready()
        move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.5)
        cell.dispatcher.link(1, OnLoss.STOP, alive=False)
        cell._hand_over()
        cell.run(1.0)
        assert cell.core.state.motion is Motion.STOPPED
        assert (move.state, move.reason) == (CommandState.RUNNING, Reason.LINK_LOST)
        cell.settle(cell.give(Code.REQUEST_CONTROL, source=2))
        assert (cell.core.state.motion, move.state) == (Motion.IDLE, CommandState.ABORTED)
        assert cell.give(Code.RESUME, source=2).reason is Reason.NOTHING_TO_RESUME

    def test_a_cycle_that_is_not_there_ends_what_was_open_and_is_reported(self) -> None:
        cell = CellBench().ready()
        move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.5)
        cell.dispatcher.observe(CellState(), cell.now)
        assert (move.state, move.reason) == (CommandState.ABORTED, Reason.CYCLE_RESTARTED)
        assert cell.dispatcher.enabled_mask() == 0
        refused = cell.give(Code.ENABLE)
        assert (refused.state, refused.reason) == (CommandState.REFUSED, Reason.NOT_READY)

    @pytest.mark.parametrize(
        ("on_loss", "motion"), [(OnLoss.STOP, Motion.STOPPED), (OnLoss.HOLD, Motion.STOPPED), (OnLoss.FINISH, Motion.IDLE)]
    )
    def test_what_a_dead_link_does_to_the_move(self, on_loss: OnLoss, motion: Motion) -> None:
        cell = CellBench().ready()
        cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.5)
        cell.dispatcher.link(1, on_loss, alive=False)
        cell._hand_over()
        cell.run(6.0)
        assert cell.core.state.motion is motion

    def test_quick_stop_on_loss_takes_the_drives_off(self) -> None:
        cell = CellBench().ready()
        move = cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.5)
        cell.dispatcher.link(1, OnLoss.QUICK_STOP, alive=False)
        cell._hand_over()
        cell.run(0.5)
        assert (move.state, move.reason) == (CommandState.ABORTED, Reason.LINK_LOST)
        assert cell.core.state.stop_cause == Reason.LINK_LOST, "every command source reads why"

    def test_the_link_of_a_source_without_control_stops_nothing(self) -> None:
        cell = CellBench().ready()
        cell.give(Code.PTP_ABSOLUTE, targets=FAR)
        cell.run(0.3)
        cell.dispatcher.link(2, OnLoss.QUICK_STOP, alive=False)
        cell._hand_over()
        cell.run(0.1)
        assert cell.core.state.motion is Motion.RUNNING

    def test_an_order_for_an_older_cycle_is_never_obeyed(self) -> None:
        cell = CellBench().ready()
        cell.dispatcher.command(1, Command(Code.PTP_ABSOLUTE, ALL, 1.0, 1.0, (*FAR, *[0.0] * 6)), cell.now)
        cell.restart_cycle()
        cell._hand_over()
        assert cell.orders == []


class TestCommandBlock:
    @staticmethod
    def block(code: int, toggle: bool, mask: int = 1) -> list[int]:
        return [(TOGGLE if toggle else 0) | code, mask, 10_000, 5_000, *real_words(1200.5), *[0] * 22]

    def test_the_first_telegram_after_a_start_is_only_adopted(self) -> None:
        block = CommandBlock()
        assert block.write(0, self.block(Code.PTP_ABSOLUTE, True)) is Reason.RESYNCHRONISED
        assert block.acknowledged
        assert block.write(0, self.block(Code.PTP_ABSOLUTE, True)) is None

    def test_a_changed_toggle_is_one_command(self) -> None:
        block = CommandBlock()
        block.write(0, [0])
        command = block.write(0, self.block(Code.PTP_ABSOLUTE, True))
        assert command == Command(4, 1, 1.0, 0.5, (1200.5, *[0.0] * 11))
        assert block.write(0, self.block(Code.PTP_ABSOLUTE, True)) is None, "a repeated telegram"

    def test_what_a_predecessor_left_set_is_adopted_too(self) -> None:
        block = CommandBlock(self.block(Code.PTP_ABSOLUTE, True))
        assert block.acknowledged
        assert not isinstance(block.write(0, self.block(Code.PTP_ABSOLUTE, False)), Command)

    def test_after_the_link_returned_the_next_telegram_is_adopted(self) -> None:
        block = CommandBlock()
        block.write(0, [0])
        block.link_returned()
        assert block.write(0, self.block(Code.PTP_ABSOLUTE, True)) is Reason.RESYNCHRONISED

    def test_single_registers_count_when_the_toggle_word_comes_last(self) -> None:
        block = CommandBlock()
        block.write(0, [0])
        words = self.block(Code.PTP_ABSOLUTE, True)
        for at in range(COMMAND_WORDS - 1, 0, -1):
            assert block.write(at, [words[at]]) is None
        assert isinstance(block.write(0, [words[0]]), Command)

    @pytest.mark.parametrize(
        ("code", "written"), [(Code.PTP_ABSOLUTE, 4), (Code.PTP_RELATIVE, 5), (Code.PROGRAM, 3), (Code.REFERENCE, 1), (Code.OVERRIDE, 2)]
    )
    def test_words_of_an_earlier_link_move_nothing(self, code: Code, written: int) -> None:
        block = CommandBlock(self.block(code, False))
        block.write(0, self.block(code, False))
        block.link_returned()
        block.write(0, self.block(code, False)[:written])
        refused = block.write(0, self.block(code, True)[:written])
        assert isinstance(refused, Refusal) and refused.reason is Reason.FORMAT_SUSPICION and "since the link began" in refused.detail
        block.write(1, self.block(code, True)[1:])
        assert isinstance(block.write(0, [self.block(code, False)[0]]), Command)
        stop = CommandBlock()
        stop.write(0, [0])
        assert isinstance(stop.write(0, [TOGGLE | Code.STOP]), Command), "a stop needs no number"

    @pytest.mark.parametrize(("first", "count"), [(0, COMMAND_WORDS + 1), (COMMAND_WORDS, 1), (-1, 1)])
    def test_words_beyond_the_block(self, first: int, count: int) -> None:
        with pytest.raises(IndexError):
            CommandBlock().write(first, [0] * count)

    def test_status_words(self) -> None:
        block = CommandBlock()
        block.write(0, [TOGGLE])
        status = Status(CommandState.DONE, Reason.NONE, 0x3F, 0x15, 0x2A, 0, 0.5, 70_000, 2)
        status.actual[1], status.lag[1] = 12.5, -0.25
        words = block.status_words(status)
        assert len(words) == STATUS_WORDS
        assert words[:9] == [TOGGLE | 3, 0, 0x3F, 0x15, 0x2A, 0, 5000, 70_000 & 0xFFFF, 2]
        assert (real(*words[14:16]), real(*words[16:18])) == (12.5, -0.25)

    def test_real_is_ieee_high_word_first(self) -> None:
        assert real_words(1200.5) == (0x4496, 0x1000)
        assert real_words(1e300) == (0x7F80, 0)


class TestLinkWatch:
    def test_silence_is_reported_once(self) -> None:
        watch = LinkWatch(ms(500), has_life_word=False)
        assert watch.telegram(ms(1)) is LinkEvent.ALIVE
        assert watch.telegram(ms(100)) is None
        assert watch.deadline() == ms(600)
        assert watch.wake(ms(599)) is None
        assert watch.wake(ms(600)) is LinkEvent.SILENT
        assert watch.wake(ms(700)) is None
        assert watch.telegram(ms(800)) is LinkEvent.ALIVE

    def test_a_constant_life_word_is_silence(self) -> None:
        watch = LinkWatch(ms(1000), has_life_word=True)
        assert watch.telegram(ms(0), 7) is None, "the first value only says where the counter stands"
        assert watch.telegram(ms(100), 8) is LinkEvent.ALIVE
        for moment in range(200, 1100, 100):
            watch.telegram(ms(moment), 8)
        assert watch.wake(ms(1100)) is LinkEvent.SILENT
