"""SYNC and the special functions 15, 21, 28 in programs of a cell: planner, core, drives and encoders in virtual time.

rho 3 Releases part 1: L1694-1742 (SF 28, SYNC), L5998-6091 (SF 21), L6133-6219 (SF 15), L11583-11625 (endless belt).
"""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.planner import pack_planner, unpack_planner
from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.running.belt_run import SPEED
from hil_tests.lab.virtual.belt_bench import ALL, FACTS, HEAD, MACHINE, BeltBench
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write
from motion.sync.belts import SET_COUNTER, STANDARD_TOLERANCE
from motion.sync.cam import cam

STEP = SPEED * 0.004 + 1e-4  # of a cycle, and one increment
AWAY = "linear pose 100 140 50 0 0 0"


@pytest.fixture
def bench() -> BeltBench:
    return BeltBench()


def set_at(bench: BeltBench) -> tuple[float, float, float]:
    """The counter of belt 1 before and after it was set, and y of the robot then; m."""
    pairs = zip(bench.seen, bench.seen[1:], strict=False)
    before, now = next(pair for pair in pairs if abs(pair[1].belt - pair[0].belt) > 10 * STEP)
    return before.belt, now.belt, now.axes[1].set


@pytest.mark.parametrize(("sign", "turn"), [(">=", 1.0), ("<=", -1.0)])
def test_sync_waits_for_the_belt_sets_its_counter_and_the_program_goes_on(bench: BeltBench, sign: str, turn: float) -> None:
    bench.started(1, turn * SPEED)
    job = bench.order("set_beltcnt 1 250", f"sync B1 {sign} {turn * 60}mm", AWAY)
    assert bench.finished(job).state is CommandState.DONE
    before, after, y = set_at(bench)
    assert 0.060 - STEP <= turn * before < 0.060, "in the cycle in which the condition holds"
    assert after == pytest.approx(0.250, abs=1e-9) and y == pytest.approx(0.1, abs=1e-9), "nothing has moved so far"
    assert bench.core.state.axes[1].set == pytest.approx(0.14, abs=1e-9)


@pytest.mark.requirement("RHO-MOT-20", by="gateway.pure.cycle.belts:CoreBelts.act")
def test_a_program_that_only_sets_a_reset_value_is_done_and_the_signal_loads_it(bench: BeltBench) -> None:
    """SPZ28 of the manual: SET_BELTCNT and nothing else; L1724-1732."""
    bench.started(1, 0.0)
    assert bench.finished(bench.order("set_beltcnt 1 -2000")).state is CommandState.DONE
    assert bench.core.state.belt == pytest.approx(0.0, abs=1e-3), "the counter itself stays"
    bench.permit(SET_COUNTER)
    bench.cycle()
    assert bench.core.state.belt == pytest.approx(-2.0, abs=1e-9)
    bench.permit(SET_COUNTER, value=False)
    bench.restart_cycle()
    bench.run(0.1)
    bench.zero(1)
    assert bench.core.state.belt == pytest.approx(0.0, abs=1e-9), "0 after a start"


def test_sync_on_an_input_waits_for_its_level(bench: BeltBench) -> None:
    bench.started(1)
    bench.permit(464, value=False)
    job = bench.order("ptp joints 110 100 50 0", "sync B1 input=464", "sync B1 input=!464", AWAY)
    bench.until(lambda s: s.axes[0].set > 0.11 - 1e-9 and s.parts > 0)
    bench.run(0.5)
    assert job.open and bench.core.state.belt > 0.06 and bench.core.state.axes[1].set == pytest.approx(0.1, abs=1e-9)
    bench.permit(464)
    bench.run(0.1)
    assert job.open and bench.core.state.belt < 0.1 * SPEED + STEP, "set at the level, and not again while it stands"
    bench.permit(464, value=False)
    assert bench.finished(job).state is CommandState.DONE


def test_a_stop_ends_a_program_that_waits_and_its_belt_is_left_alone(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order("sync B1 >= 100mm", AWAY)
    bench.run(0.2)
    assert job.state is CommandState.RUNNING
    assert bench.settle(bench.give(Code.STOP, ALL)).state is CommandState.DONE
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE)
    bench.run(1.0)
    assert bench.core.state.belt > 0.150 and bench.set()[1] == pytest.approx(100.0)
    assert bench.finished(bench.order("sync B1 >= 150mm", AWAY)).state is CommandState.DONE


@pytest.mark.requirement("RHO-MOT-22", by="gateway.pure.planning.belt_statements:belts_after")
def test_the_type_of_a_belt_holds_for_later_programs_until_the_cycle_starts_anew(bench: BeltBench) -> None:
    part = "synchron B1 at=60mm", "linear pose 200 150 50 0 0 0 belt=160mm camin=30mm camout=50mm", "synchron_end"
    curve = cam(0.1, 0.03, 0.05)
    bench.started(1)
    assert bench.finished(bench.order("belt_type 1 73", *part)).state is CommandState.DONE
    inside = [s for s in bench.seen if 0.061 < s.belt < 0.159]
    assert len(inside) > 100 and bench.belts.all.all[0].tolerance == 7
    for s in inside:
        assert s.axes[0].set == pytest.approx(0.1 + 0.1 * curve.at(s.belt - 0.060)[0], abs=1e-9)
    arc = "synchron B1 at=60mm", "circular via pose 150 150 50 0 0 0 to pose 200 100 50 0 0 0 belt=160mm"
    assert "Belt-sync. n.possible" in bench.settle(bench.order(*arc)).detail, "CIRCULAR on a cam: still type 3"
    refused = bench.settle(bench.order("belt_type 1 1", "synchron B1", "ptp joints 1 1 1 1"))
    assert "a place of the axes does not lie on belt B1" in refused.detail, "on paper it was type 1 again"
    assert "Belt-sync. n.possible" in bench.settle(bench.order(*arc)).detail, "what was refused has changed nothing"
    bench.restart_cycle()
    bench.run(0.1)
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
        bench.settle(bench.give(code, ALL))
    assert "a place of the axes does not lie on belt B1" in bench.settle(bench.order("synchron B1", "ptp joints 1 1 1 1")).detail


def test_a_new_planner_goes_on_with_the_types_programs_have_set(bench: BeltBench) -> None:
    """AX-394; what its predecessor said last stands in its region."""
    arc = "synchron B1 at=60mm", "circular via pose 150 150 50 0 0 0 to pose 200 100 50 0 0 0 belt=160mm"
    bench.started(1)
    assert bench.finished(bench.order("belt_type 1 73")).state is CommandState.DONE
    said = unpack_planner(pack_planner(bench.programs.state))
    bench.another_planner(said)
    bench.run(0.1)
    assert "Belt-sync. n.possible" in bench.settle(bench.order(*arc)).detail, "CIRCULAR on a cam: still type 3"
    assert bench.programs.state.types[0] == (3, 7)
    bench.restart_cycle()
    bench.another_planner(unpack_planner(pack_planner(bench.programs.state)))
    bench.run(0.1)
    assert bench.programs.state.types[0] == (1, STANDARD_TOLERANCE), "a start-up of the control"


@pytest.mark.requirement("RHO-MOT-26", by="gateway.pure.cycle.belts:CoreBelts.act")
def test_below_the_threshold_stopped_a_robot_of_type_2_stands(bench: BeltBench) -> None:
    bench.started(2)
    part = "synchron B2 at=60mm", "linear pose 200 150 50 0 0 0 belt=160mm"
    job = bench.order("belt_param 2 200 300 160", *part)
    bench.until(lambda s: s.belt > 0.140)
    assert bench.core.state.axes[0].set == pytest.approx(0.1, abs=1e-9) and job.open, "150 mm/s counts as stopped"
    bench.settle(bench.give(Code.STOP, ALL))
    bench.finished(job)
    bench.restart_cycle()
    bench.run(0.1)
    for code in (Code.REQUEST_CONTROL, Code.FAULT_RESET, Code.OVERRIDE, Code.ENABLE):
        bench.settle(bench.give(code, ALL))
    bench.started(2)
    bench.order(*part)
    bench.until(lambda s: s.axes[0].set > 0.15)


SAYS = {
    "line 6: block 1: wrong belt-kind/-tol, belt 1: type 131 (rho 3 92)": ["belt_type 1 131", AWAY],
    "belt 4: Inadmiss. Belt-No, P501 = 3 (rho 3 93)": ["ptp joints 110 100 50 0", "belt_param 4 10 50 160", AWAY],
    "belt 9: Inadmiss. Belt-No, P501 = 3 (rho 3 93)": ["set_beltcnt 9 0"],
    "belt B9: Inadmiss. Belt-No; this cell has B1, B2, B3 (rho 3 93)": ["sync B9 >= 10mm", AWAY],
    "Belt-sync. n.possible: SYNC of belt B1 inside its part waits for a belt value": ["synchron B1", "sync B1 input=464", AWAY],
    "line 7: block 1: Belt-sync. n.possible: belt functions and SYNC must be outside": ["synchron B1", "belt_type 1 2", AWAY],
    "inside a part needs a belt of type 1 with an endless axis parallel to it": ["synchron B1", "sync B1 >= 5mm", "synchron_end"],
    "line 8: block 2: Belt-sync. n.possible: SYNC inside a part needs a belt of type 1": [
        AWAY,
        "synchron B2 at=5mm",
        "sync B2 >= 5mm",
        AWAY + " belt=9mm",
    ],
    "sync B1 input=4640: an RC input is needed": ["sync B1 input=4640", AWAY],
    "thresholds -1": ["belt_param 1 -1 50 160", AWAY],
}


def test_what_cannot_be_is_reported_before_anything_moves(bench: BeltBench) -> None:
    before = bench.set()
    for words, lines in SAYS.items():
        job = bench.settle(bench.order(*lines))
        assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT), words
        assert words in job.detail, job.detail
        assert bench.set() == before


def test_a_label_brings_its_statements_along(bench: BeltBench) -> None:
    bench.permit(464, value=False)
    bench.started(1, 0.0)
    lines = ("linear pose 100 120 50 0 0 0 until=464 error=NONE", "set_beltcnt 1 70", AWAY, "label NONE", "set_beltcnt 1 -90")
    assert bench.finished(bench.order(*lines, "linear pose 100 100 50 0 0 0")).state is CommandState.DONE
    assert max(s.axes[1].set for s in bench.seen) == pytest.approx(0.12, abs=1e-9), "the block in between is left out"
    bench.permit(SET_COUNTER)
    bench.cycle()
    assert bench.core.state.belt == pytest.approx(-0.09, abs=1e-9)


def test_statements_are_written_as_they_were_read() -> None:
    text = HEAD + "\n".join(
        (
            "set_beltcnt 1 -200",
            "belt_type 1 73",
            "sync B1 input=!464",
            "label HERE",
            "sync B1 >= 100mm",
            "synchron B1 at=60mm",
            "linear pose 200 150 50 0 0 0 belt=160mm",
            "synchron_end",
            "belt_param 1 10 50.5 160",
            "sync B1 <= -3mm",
        )
    ).replace("label HERE\n", "")
    program = read(text)
    first, *_ = program.blocks
    assert [act.inside for act in (*first.acts, *program.acts)] == [False] * 6 and len(first.acts) == 4
    assert read(write(program)) == program
    for line, says in {
        "sync B1": "sync: BELT >= 100mm",
        "sync B1 = 3mm": "sync: BELT >= 100mm",
        "sync B1 >= 3": "sync: '3': a number with mm or deg",
        "belt_type 1": "belt_type: 2 numbers, found 1",
        "belt_param 1.5 1 1 1": "whole numbers",
        "sync B1 >= 3mm\nlabel X\nlinear pose 1 1 1 0 0 0": "label: X must be before sync",
    }.items():
        with pytest.raises(TextFaults) as caught:
            read(HEAD + line + "\n")
        assert says in str(caught.value)


def test_in_the_dry_run_a_part_runs_by_the_type_its_program_has_set() -> None:
    text = "belt_type 1 3\nsynchron B1 at=50mm\nlinear pose 200 100 50 0 0 0 belt=200mm camin=30mm camout=70mm\n"
    sections, faults = sections_of(read(HEAD + text), MACHINE, FACTS)
    assert not faults
    made = DryRun(MACHINE, FACTS, (SPEED,) * 3, 4).run(sections)
    way = made.belts[0]
    for counter, share in ((0.080, 0.15), (0.105, 0.40), (0.130, 0.65)):
        row = int(abs(way.value - counter).argmin())
        assert made.tool[row, 0] == pytest.approx(0.1 + 0.1 * share, abs=2e-4)
    _, faults = sections_of(read(HEAD + "belt_type 1 4\n" + AWAY + "\nbelt_type 7 2\n"), MACHINE, FACTS)
    assert [(fault.block, fault.code) for fault in faults] == [(1, 92), (1, 93)]
