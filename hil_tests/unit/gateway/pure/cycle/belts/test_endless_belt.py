"""The endless belt in programs: SYNC inside the part, an axis that rides along.  rho 3 Releases part 1, TO08 section 4, L11583-11672.

What the axes did is judged by the emulator's own record against the places of the belt's encoder, whose 16 bits overflow meanwhile.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gateway.assembly.belts import belt_facts
from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.cells import arms
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.turning_cell import PORTAL, cell_text
from hil_tests.lab.running.belt_run import SPEED
from hil_tests.lab.virtual.endless_belt import CELL, FACTOR, HEAD, TEXT, EndlessBelt
from motion.geometry.limits import limits_from
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write
from motion.sync.facts import BeltFacts
from motion.sync.parallel import Carrier

STEP = SPEED * 0.004 + 1e-4  # m of a cycle, and one increment
FINE = 5e-3  # deg: one increment of the axis is 0.0022
NEAR_OVERFLOW = 65536 - 3000  # counts: after 300 mm


@pytest.fixture
def bench() -> EndlessBelt:
    found = EndlessBelt()
    found.emulated.all[0].place = NEAR_OVERFLOW
    found.restart_cycle()
    found.run(0.1)
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
        assert found.settle(found.give(code, found.all)).state is CommandState.DONE
    found.ridden()
    found.places.clear()
    return found


def levels(off: Array) -> list[float]:
    """Where the axis stayed beside its belt for long, deg, in the order of time; off: it less the belt."""
    still = np.concatenate([[False], np.abs(off[50:] - off[:-50]) < 0.1, [False]]).astype(int)
    edges = np.flatnonzero(np.diff(still))
    return [float(np.median(off[first + 10 : last + 40])) for first, last in zip(edges[::2], edges[1::2], strict=True) if last - first > 30]


def jumps(bench: EndlessBelt) -> list[tuple[float, float]]:
    """The counter before and behind each of its jumps, m."""
    belts = [state.belt for state in bench.seen]
    return [(a, b) for a, b in itertools.pairwise(belts) if abs(b - a) > 10 * STEP]


@pytest.mark.requirement("RHO-MOT-29", by=("gateway.pure.cycle.belt_mover:BeltMover.step", "motion.sync.endless_axis:AlongAxis.follow"))
def test_sync_inside_the_part_lessens_the_counter_and_the_axis_stays_where_it_is_beside_its_belt(bench: EndlessBelt) -> None:
    bench.started(1)
    zero = 0.1 * math.floor(bench.emulated.all[0].place) - 1e3 * bench.core.state.belt
    lines = "ptp rel joints 10 5 0 0 0", "sync B1 >= 200mm", "ptp rel joints -10 0 0 0 0", "sync B1 >= 200mm", "ptp rel joints 30 0 0 0 0"
    job = bench.order("set_beltcnt 1 -40", "synchron B1 at=60mm", *lines, "sync B1 >= 200mm", "synchron_end")
    assert bench.finished(job).state is CommandState.DONE
    assert len(jumps(bench)) == 3
    for before, behind in jumps(bench):
        assert 0.2 - STEP <= before < 0.2, "in the cycle in which the condition holds"
        assert before - 0.2 <= behind <= before - 0.2 + STEP, "lessened by the limit, whatever it is beyond it"
    places, sets = bench.ridden()
    assert places[0] < 6553.6 < places[-1], "the encoder has overflown"
    found = levels(sets[:, 0] - FACTOR * places)
    begun = -FACTOR * (zero + 1e3 * bench.core.state.engaged - 0.05)  # a count is taken as the middle of its increment
    assert found == pytest.approx([begun + way for way in (10.0, 0.0, 30.0)], abs=FINE), "ways along the belt, from where SYNCHRON found it"
    assert sets[-1, 1] == pytest.approx(5.0, abs=FINE)
    assert np.abs(np.diff(sets[:, 0], 2)).max() < 3000 * 0.004**2 + 4e-3, "no set value jumps"


@pytest.mark.requirement("RHO-MOT-29", by=("gateway.pure.planning.handing_on:HandingOn._plan", "gateway.pure.planning.parts:begun"))
def test_the_first_example_of_the_manual_has_nothing_but_sync_in_its_part(bench: EndlessBelt) -> None:
    """SYNCHRON, SYNC BN1 >= MOD_VAL again and again, SYNCHRON_END: the axis rides for rounds, and rests within its modulo."""
    bench.started(1, 4 * SPEED)
    job = bench.order("synchron B1", *["sync B1 >= 1000mm"] * 3, "synchron_end", "ptp joints 90 0 0 0 0")
    bench.until(lambda s: s.parts >= 5)  # the first is that of no block before it, the second SYNCHRON
    assert bench.core.state.axes[0].set > 2.5 * math.tau, "it counts on from round to round inside the part"
    assert bench.finished(job).state is CommandState.DONE and len(jumps(bench)) == 3
    assert bench.set()[0] == pytest.approx(90.0, abs=1e-6)
    places, sets = bench.ridden()
    assert len(levels(sets[:, 0] - FACTOR * places)) == 1, "one level through all three"


def test_a_belt_that_runs_back_and_turns_its_axis_the_other_way(bench: EndlessBelt) -> None:
    bench.started(3, -SPEED)
    job = bench.order("synchron B3", "sync B3 <= -100mm", "ptp rel joints 0 0 0 0 7", "sync B3 <= -100mm", "synchron_end")
    assert bench.finished(job).state is CommandState.DONE
    assert [round(behind - before, 2) for before, behind in jumps(bench)] == [0.1, 0.1]
    _, sets = bench.ridden()
    assert 26.0 < sets[-1, 4] < 28.0, "-0.1 deg for each of nearly -200 mm, and 7"


def riding(bench: EndlessBelt) -> int:
    """A program whose SYNC waits on the belt."""
    bench.started(1)
    job = bench.order("synchron B1", "ptp rel joints 5 0 0 0 0", "sync B1 >= 9000mm", "ptp rel joints 0 9 0 0 0", "synchron_end")
    bench.until(lambda s: s.parts >= 2 and s.axes[0].set > math.radians(30.0))
    return job.id


def still(bench: EndlessBelt) -> bool:
    before = bench.set()
    bench.run(0.5)
    return bench.set() == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize("how", ["stop", "planner", "drives"])
def test_a_program_that_waits_on_its_belt_is_over_beside_it_and_its_counter_is_left_alone(bench: EndlessBelt, how: str) -> None:
    number = riding(bench)
    if how == "planner":
        bench.planner.alive = False
        bench.planner.held.clear()
        bench.core.planner_lost()
    else:
        bench.give(Code.STOP if how == "stop" else Code.DISABLE, bench.all)
    bench.until(lambda s: s.failed_job == number and s.motion is Motion.IDLE)
    bench.run(0.2)
    reasons = {"stop": Reason.STOPPED_BY_SOURCE, "planner": Reason.PLANNER_LOST, "drives": Reason.DRIVES_OFF}
    assert bench.core.state.failed_reason == reasons[how] and still(bench)
    assert not bench.belts.awaits and not bench.belts.carries and jumps(bench) == []
    assert all(0.0 <= axis.set < math.tau for axis in bench.core.state.axes[:5])


def test_feed_hold_keeps_the_axis_on_its_belt_and_sync_goes_on(bench: EndlessBelt) -> None:
    bench.started(1)
    job = bench.order("synchron B1", "ptp rel joints 90 90 0 0 0", "sync B1 >= 300mm", "synchron_end")
    bench.until(lambda s: s.axes[1].set > math.radians(20.0))
    bench.permit(27, value=False)
    bench.run(0.6)
    off = bench.set()[0] - FACTOR * 1e3 * bench.core.state.belt
    bench.run(0.6)
    assert bench.set()[0] - FACTOR * 1e3 * bench.core.state.belt == pytest.approx(off, abs=0.1) and bench.set()[1] < 89.0
    bench.run(1.2)
    assert bench.core.state.belt > 0.35 and jumps(bench) == [], "the block before it is not run yet"
    bench.permit(27)
    assert bench.finished(job).state is CommandState.DONE
    ((before, behind),) = jumps(bench)
    assert before > 0.35 and behind == pytest.approx(before - 0.3, abs=STEP), "what it was beyond the limit is left"


def test_a_belt_that_reaches_the_value_while_a_stopped_axis_leaves_it_keeps_its_counter(bench: EndlessBelt) -> None:
    bench.started(1)
    bench.order("synchron B1", "sync B1 >= 200mm", "synchron_end")
    bench.until(lambda s: s.belt > 0.19)
    bench.give(Code.STOP, bench.all)
    bench.until(lambda s: s.belt > 0.2)
    assert bench.belts.carries, "not at rest yet"
    bench.until(lambda s: s.motion is Motion.IDLE)
    assert jumps(bench) == []


AT = "synchron B1 at=60mm"
ON = "ptp rel joints 1 0 0 0 0"
SAYS = {
    "an absolute place of M: the axis parallel to belt B1 is endless": [AT, "ptp joints 10 0 0 0 0"],
    "line 7: block 2: Belt-sync. n.possible: belt=": [AT, ON, ON + " belt=70mm"],
    "SYNC of belt B1 inside its part waits for a belt value, not for an input": [AT, ON, "sync B1 input=464", ON],
    "SYNC in a part on belt B1 is one of this belt, not of B3": [AT, "sync B3 >= 10mm", ON],
    "belt B2 has none": ["synchron B2", "linear rel pose 0 0 0 0 0 0", "sync B2 >= 10mm", "synchron_end"],
    "line 8: block 1: Belt-sync. n.possible: SYNC inside a part needs": ["belt_type 1 2", AT, "sync B1 >= 10mm", "synchron_end"],
    "must be outside synchronous and alterable parts": [AT, "set_beltcnt 1 0", ON],
}


def test_what_the_manual_rules_out_is_20_before_anything_moves(bench: EndlessBelt) -> None:
    for words, lines in SAYS.items():
        job = bench.settle(bench.order(*lines))
        assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT), words
        assert words in job.detail and "(rho 3 20)" in job.detail, job.detail
    assert bench.set() == pytest.approx([0.0] * 5, abs=1e-9)


def test_outside_of_its_part_sync_sets_the_counter_as_ever(bench: EndlessBelt) -> None:
    bench.started(1)
    job = bench.order(
        "set_beltcnt 1 -40",
        "sync B1 >= 100mm",
        "synchron B1",
        "sync B1 >= 50mm",
        "synchron_end",
        "sync B1 >= 100mm",
        "ptp joints 0 0 0 0 0",
    )
    assert bench.finished(job).state is CommandState.DONE
    assert [round(behind, 3) for _, behind in jumps(bench)] == pytest.approx([-0.04, 0.0, -0.04], abs=2e-3)


def test_a_text_is_written_as_it_was_read_and_a_sync_that_ends_its_part_gets_a_block_without_way() -> None:
    text = (
        HEAD
        + "set_beltcnt 1 0\nsynchron B1\nsync B1 >= 100mm\nptp rel joints 1 0 0 0 0\nsync B1 >= 200mm\nsynchron_end\nptp joints 0 0 0 0 0\n"
    )
    program = read(text)
    assert [len(block.acts) for block in program.blocks] == [2, 1, 0] and program.blocks[1].line == 10
    assert program.blocks[1].synchron == program.blocks[0].synchron and program.blocks[2].synchron is None
    assert [replace(block, line=0) for block in read(write(program, "rho3")).blocks] == [replace(block, line=0) for block in program.blocks]
    with pytest.raises(TextFaults, match="synchron_end: is missing"):
        read(HEAD + "synchron B1\nptp rel joints 1 0 0 0 0\nsync B1 >= 200mm\n")


MACHINE, FACTS = machine_of_cell(CELL), belt_facts(CELL)


def on_paper(text: str, machine: Machine = MACHINE, facts: Sequence[BeltFacts] = FACTS) -> tuple[Array, Array]:
    """(n,) mm of the counter of belt 1 at 100 mm/s, and (n, axes) deg, of the only part."""
    sections, faults = sections_of(read(text), machine, facts)
    assert not faults
    made = DryRun(machine, facts, (0.1,) * len(facts), 4).run(sections)
    (way,) = made.belts
    first = int(np.argmin(np.abs(made.t - way.t[0])))
    return 1e3 * way.value, np.degrees(made.q[first : first + len(way.t)])


def test_in_the_dry_run_it_runs_as_in_the_cell() -> None:
    lines = AT, "sync B1 >= 200mm", "ptp rel joints 10 5 0 0 0", "sync B1 >= 150mm", "synchron_end", "ptp joints 0 0 0 0 0"
    counter, q = on_paper(HEAD + "\n".join(lines))
    back = np.flatnonzero(np.diff(counter) < -1.0)
    assert counter[back] == pytest.approx([200.0, 150.0], abs=0.2) and counter[back + 1] == pytest.approx([0.0, 0.0], abs=0.2)
    way = np.arange(len(counter)) * 0.1
    off = q[:, 0] - FACTOR * way
    assert levels(off[::4])[1] - levels(off[::4])[0] == pytest.approx(10.0, abs=FINE)
    told = sections_of(read(HEAD + "synchron B2\nlinear rel pose 0 0 0 0 0 0\nsync B2 >= 5mm\nsynchron_end\n"), MACHINE, FACTS)[1]
    assert [(fault.block, fault.code) for fault in told] == [(2, 20)]


def test_an_arm_works_beside_the_belt_while_its_additional_axis_rides_along() -> None:
    """The arm's points stand still, in poses; only the parallel axis has no place but by a difference."""
    beside = limits_from("E1", "deg", lower=0, upper=360, speed=90, accel=450, jerk=9000, modulo=360)
    arm = arms.robot("tx60-like")
    machine = replace(arm, limits=(*arm.limits, beside))
    facts = (replace(FACTS[0], carriers={1: Carrier(FACTS[0].carriers[1].factors, joint=6)}),)
    head = "angles val3\naxes deg deg deg deg deg deg deg\nstart 0 30 90 0 60 0 350\n"
    part = "synchron B1 at=0mm\nlinear pose 350 -110 170 180 0 10\nsync B1 >= 100mm\nlinear rel pose 0 30 0 0 0 0 extra=-20deg\n"
    _, q = on_paper(head + "ptp pose 350 -150 200 180 0 0\n" + part + "sync B1 >= 100mm\nsynchron_end\n", machine, facts)
    alone = Route(arm, tuple(map(math.radians, (0, 30, 90, 0, 60, 0))))
    for line in ("ptp pose 350 -150 200 180 0 0", "linear pose 350 -110 170 180 0 10", "linear rel pose 0 30 0 0 0 0"):
        alone.add(read(f"angles val3\nstart 0 30 90 0 60 0\n{line}\n").blocks[0])
    assert np.radians(q[-1, :6]) == pytest.approx(alone.position, abs=1e-6)
    off = q[:, 6] - FACTOR * 0.1 * np.arange(len(q))
    first, second = levels(off[::4])
    assert second - first == pytest.approx(-20.0, abs=FINE)
    faults = sections_of(read(head + "synchron B1\nlinear pose 350 -110 170 180 0 10 extra=5deg\n"), machine, facts)[1]
    assert [(fault.block, fault.code) for fault in faults] == [(1, 20)] and "absolute place of E1" in str(faults[0])


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ('axis = "M"', 'axis = "N"', "belt.B1.axis"),
        ("modulo = 360.0\n", "", "an axis parallel to a belt is endless: modulo in its"),
        ("factor = 0.36", "factor = 0.0", "a belt with factors 0 moves nothing"),
        ("factor = 0.36", "factor = nan", "belt.B1.factor"),
    ],
)
def test_a_belt_whose_axis_cannot_go_along_is_refused(before: str, after: str, says: str) -> None:
    assert before in TEXT
    with pytest.raises(CellFaults, match=says):
        load_cell(str(PORTAL), TEXT.replace(before, after, 1))


def test_an_axis_of_nobody_is_no_axis_of_a_belt() -> None:
    sixth = cell_text().partition("[[axis]]")[2].partition("[[axis]]")[0].replace('"M"', '"S9"').replace("module = 1", "module = 6")
    text = TEXT.replace("[[belt]]", f"[[axis]]{sixth}[[belt]]", 1).replace('axis = "M"', 'axis = "S9"').replace('"1..5"', '"1..6"')
    with pytest.raises(CellFaults, match="axis S9 does not belong to robot turntables, whose axes are M, S1, S2, S3, S4"):
        load_cell(str(PORTAL), text)
