"""Endless axes of a cell (P303 = 3, P311): programs, command sources, stop, a new cycle.  The emulator's record judges.  AX-354, AX-568."""

import functools
import math
import pathlib
from dataclasses import replace

import numpy as np
import pytest

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.axis_scaling import scaling_of
from gateway.assembly.last_positions import judge, remember
from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells import arms
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM, cell_text
from hil_tests.lab.cells.turning_cell import PORTAL, turning_cell
from hil_tests.lab.cells.turning_cell import cell_text as turning_text
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from motion.geometry.limits import limits_from
from motion.kinematics.endless import within
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.blocks import Block, Interpolation, PoseTarget
from motion.program.text.reader import read

CELL = turning_cell()
HEAD = "robot turntables\naxes deg deg deg deg deg\nstart 0 0 0 0 0\n"
EVERY = 0b11111
FINE = 5e-3  # deg: more than one increment of each axis
ARM6 = ARM.read_text()


class Turning:
    """All axes at 0 at the start; `turned()` is what their motors have turned since, in deg of the axes."""

    def __init__(self) -> None:
        self.bench = ServodynRobot(cell=CELL)
        self.planned = Planned(self.bench)

    def run(self, *lines: str) -> Job:
        return self.bench.settle(self.planned.order(HEAD + "\n".join(lines)))

    def turned(self) -> Array:
        self.bench.run(0.05)  # a set value is reached two SYNCs after it was sent
        return np.asarray(np.degrees(self.planned.driven().sets[-1]))

    def shown(self) -> list[float]:
        return self.bench.set()

    def home(self) -> Array:
        """At 0, by the shortest program; where the motors are then."""
        assert self.run("ptp joints 0 0 0 0 0").state is CommandState.DONE
        return self.turned()


@pytest.fixture(scope="module")
def turning() -> Turning:
    return Turning()


@pytest.mark.parametrize(
    ("lines", "way", "place"),
    [
        (["ptp joints 360 0 20 40 725"], (360, 0, 20, 40, 725), (0, 0, 20, 40, 5)),
        (["ptp joints 360 90 0 0 0", "ptp joints 360 0 0 0 0"], (720, 0, 0, 0, 0), (0, 0, 0, 0, 0)),  # behind a block 360 is 0 again
        (
            ["ptp joints 350 0 0 0 0", "ptp joints 10 0 0 0 0"],
            (10, 0, 0, 0, 0),
            (10, 0, 0, 0, 0),
        ),  # the programmed difference, no short way
        (["ptp rel joints 370 -20 0 0 0", "ptp rel joints 20 0 0 5 0"], (390, -20, 0, 5, 0), (30, 340, 0, 5, 0)),
        (["ptp rel joints -30 0 0 0 0", "ptp joints 0 0 0 0 0"], (-360, 0, 0, 0, 0), (0, 0, 0, 0, 0)),
    ],
)
def test_every_block_travels_from_the_place_within_the_modulo_to_the_programmed_number(
    turning: Turning, lines: list[str], way: tuple[float, ...], place: tuple[float, ...]
) -> None:
    begun = turning.home()
    assert turning.run(*lines).state is CommandState.DONE
    assert turning.turned() - begun == pytest.approx(way, abs=FINE)
    assert turning.shown() == pytest.approx(place, abs=1e-6)


def test_no_set_value_jumps_where_the_numbers_go_round_and_none_is_beyond_the_limits(turning: Turning) -> None:
    turning.home()
    assert turning.run("ptp joints 360 -400 20 1000 0", "ptp joints 90 0 0 0 0").state is CommandState.DONE
    turning.bench.run(0.2)
    driven = turning.planned.driven()
    speed, accel = driven.shares()
    assert 0.5 < speed <= 1.0 and 0.5 < accel <= 1.02, (speed, accel)
    lag = np.abs(np.degrees(driven.actual - driven.sets))
    assert lag.max() < 20.0 and lag[-1].max() < 1.0, "the motors are where the set values asked them to be"


def test_sources_move_within_the_modulo_and_by_any_difference(turning: Turning) -> None:
    begun, bench = turning.home(), turning.bench
    for code, targets in ((Code.PTP_RELATIVE, (350.0, -10.0)), (Code.PTP_RELATIVE, (30.0, 0.0)), (Code.PTP_ABSOLUTE, (90.0, 300.0))):
        job = bench.give(code, EVERY, targets=targets)
        assert bench.settle(job).state is CommandState.DONE, job.detail
        bench.run(0.1)
    assert turning.turned() - begun == pytest.approx((450, -60, 0, 0, 0), abs=FINE)
    assert turning.shown()[:2] == pytest.approx((90, 300), abs=1e-6)
    job = bench.give(Code.PTP_ABSOLUTE, EVERY, targets=(361.0,))
    assert job.state is CommandState.REFUSED and "0..360 deg" in job.detail


def test_a_stop_in_the_third_round_and_a_block_that_ends_early_leave_the_numbers_right(turning: Turning) -> None:
    begun, bench, planned = turning.home(), turning.bench, turning.planned
    job = planned.order(HEAD + "ptp joints 1500 0 0 0 0 until=464\nptp joints 100 0 0 0 0")
    planned.until(lambda state: state.axes[0].set > math.radians(800))
    planned.done(Code.STOP)
    planned.until(lambda state: state.motion is Motion.STOPPED)
    bench.give(Code.RESUME)
    planned.until(lambda state: state.axes[0].set > math.radians(1200))
    bench.permit(464)
    bench.settle(job)
    bench.permit(464, value=False)
    assert job.state is CommandState.DONE
    bench.run(0.05)
    most = np.degrees(planned.driven().sets[:, 0]) - begun[0]
    assert 1200 < most.max() < 1440, "stopped by the input in its fourth round"
    assert most[-1] == pytest.approx(1080 + 100, abs=FINE) and turning.shown()[0] == pytest.approx(100, abs=1e-6)


def test_a_new_cycle_reads_the_same_places_from_drives_that_have_counted_on(turning: Turning) -> None:
    assert turning.run("ptp rel joints 500 -700 30 400 1").state is CommandState.DONE
    before, bench = turning.shown(), turning.bench
    bench.restart_cycle()
    bench.run(0.5)
    shown = [(a - b + 180.0) % 360.0 - 180.0 for a, b in zip(bench.actual(), before, strict=True)]
    assert max(map(abs, shown)) < 1.0 and all(0.0 <= place < 360.0 for place in bench.set())
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
        assert bench.settle(bench.give(code, EVERY)).state is CommandState.DONE
    begun = turning.turned()
    assert turning.run("ptp rel joints 10 0 0 0 0").state is CommandState.DONE
    assert (turning.turned() - begun)[0] == pytest.approx(10, abs=1.0)


def test_a_zero_written_after_several_turns_is_right(turning: Turning, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path))
    assert turning.run("ptp rel joints 3333 -700 30 4000 1").state is CommandState.DONE
    turning.bench.run(0.5)
    for n, axis in enumerate(CELL.axis):
        counter, shown = turning.bench.core._axes[n].drive.position_inc, turning.bench.actual()[n]
        zero = zeros.entry(CELL, axis, shown, 77.0, "A. Fitter")["zero_inc"]
        scaling = scaling_of(axis).with_zero(float(str(zero)))
        assert math.degrees(within(scaling.to_si(counter), math.tau)) == pytest.approx(77.0, abs=FINE), "as the next start reads it"


def test_a_place_as_an_encoder_shows_it_that_counted_round_meanwhile_is_reported(
    turning: Turning, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ten turns of the motor are a round: 4096 turns are 216 degrees more."""
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path))
    state = turning.bench.core.state
    remember(CELL, state)

    def judged(turns: float) -> list[str]:
        ways = [turns * axis.drive.inc_per_turn / scaling_of(axis).inc_per_unit for axis in CELL.axis]
        axes = [replace(axis, actual=axis.actual + way) for axis, way in zip(state.axes, ways, strict=False)]
        return judge(CELL, replace(state, axes=axes))

    assert judged(0.0) == judged(73.0 * 10) == judged(0.02) == [], "where it was, but for whole rounds"
    assert judged(3.0) == judged(-2.5) == [], "turned by hand"
    (first, *others) = judged(4096.0)
    assert first.startswith("axis M: shown -144 deg from its position at the last stop, as when its encoder overflows by +4096 turns")
    assert "unless the axis was turned" in first and len(others) == len(CELL.axis) - 1
    assert "by -4096 turns" in judged(-4096.1)[0] and "by +1024 turns" not in judged(1024.0)[0], "by the range that is usual"
    told = [notice.text for notice in CELL.notices if notice.where == "axis.M.home"]
    assert len(told) == 1 and "reports where this may be" in told[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (turning_text().replace("modulo = 360.0", "modulo = 300.0", 1), "an endless axis has the positions 0..300"),
        (turning_text().replace('unit   = "deg"', 'unit   = "mm"', 1), "an endless axis turns"),
        (turning_text().replace("modulo = 360.0", "modulo = -1.0", 1), "modulo"),
        (ARM6.replace('name   = "J6"\n', 'name   = "J6"\nmodulo = 360.0\n'), "the arm of robot tx60-like has a geometry"),
        (turning_text().replace('name   = "M"\n', 'name   = "M"\nmanual = true\n'), "axis.M.manual = true: .*main axes are S1, S2"),
        (cell_text().replace('name   = "D1"\n', 'name   = "D1"\nmodulo = 360.0\n'), "carry robot or workpiece"),
    ],
)
def test_what_cannot_go_round_is_refused_in_words(text: str, says: str) -> None:
    with pytest.raises(CellFaults, match=says):
        load_cell(str(PORTAL if "turntables" in text else ARM), text)


@functools.cache
def positioner() -> Machine:
    """The shipped arm and an endless axis beside it."""
    arm = arms.robot("tx60-like")
    beside = limits_from("E1", "deg", lower=0, upper=360, speed=90, accel=450, jerk=9000, modulo=360)
    return replace(arm, limits=(*arm.limits, beside))


def test_an_additional_axis_goes_round_beside_lines_and_splines() -> None:
    start = (*map(math.radians, (0, 30, 90, 0, 60, 0)), math.radians(350))
    route = Route(positioner(), start)
    here = positioner().forward(start)
    found = []
    for kind, up, extra in (
        (Interpolation.LINEAR, 0.02, 370.0),
        (Interpolation.SPLINE, 0.04, 100.0),
        (Interpolation.SPLINE, 0.06, 380.0),
        (Interpolation.PTP, 0.0, 20.0),
    ):
        x, y, z = here.position
        route.add(Block(kind, PoseTarget(here._replace(position=(x, y, z + up)), extra=(math.radians(extra),))))
        found.append(math.degrees(route.position[6]))
    assert found[0] == pytest.approx(370)  # 350 -> 370
    route.finish()
    assert math.degrees(route.position[6]) == pytest.approx(740)  # 10 -> 100, 100 -> 380, 20 -> 20


def test_check_and_plot_know_it_from_the_cell() -> None:
    machine = machine_of_cell(CELL)
    route = Route(machine, (0.0,) * 5)
    for block in read(HEAD + "ptp joints 360 0 0 0 0\nptp joints 360 0 0 0 0").blocks:
        route.add(block)
    assert route.position[0] == pytest.approx(2 * math.tau)


RHO3 = "[rho3]\nP303 = {}\nP311 = {}\nP204 = [1, 1, 1, 1, 1]\nP205 = [1, 1, 1, 1, 1]\n\n[robot]"
PLAIN = turning_text().replace("modulo = 360.0\n", "").replace("min = 0.0, max = 360.0, ", "")


def rho3(p303: str, p311: str) -> str:
    return PLAIN.replace("[robot]", RHO3.format(p303, p311), 1)


def test_p303_and_p311_make_the_same_cell() -> None:
    cell = load_cell(str(PORTAL), rho3("[3, 4, 4, 4, 3]", "[360, 360, 360, 360.0, 360]"))
    assert [axis.modulo for axis in cell.axis] == [360.0] * 5 == [axis.modulo for axis in CELL.axis]
    assert [axis.limits for axis in cell.axis] == [axis.limits for axis in CELL.axis]
    some = load_cell(str(PORTAL), rho3("[3, 0, 1, 4, 3]", "[360, 0, 0, 360, 180]"))
    assert [(axis.modulo, axis.limits.min, axis.limits.max) for axis in some.axis] == [
        (360.0, 0.0, 360.0),
        (0.0, -1.0, 1.0),
        (0.0, -1.0, 1.0),
        (360.0, 0.0, 360.0),
        (180.0, 0.0, 180.0),
    ]


@pytest.mark.parametrize(
    ("p303", "p311", "says"),
    [
        ("[2, 0, 0, 0, 0]", "[0, 0, 0, 0, 0]", "endless manual axis"),
        ("[0, 0, 0, 0, 3]", "[0, 0, 0, 0, 0]", "axis S4 is endless"),
        ("[0, 0, 0, 0, 4]", "[0]", "its modulo value is needed"),
        ("[4, 4, 3, 4, 0]", "[360, 360, 360, 360, 0]", r"rho3.P303\[1\] = 4: allowed 0 or 3: axis M is the first .*main axes are S2, S4"),
    ],
)
def test_p303_without_a_meaning_a_modulo_or_a_master_is_refused(p303: str, p311: str, says: str) -> None:
    with pytest.raises(CellFaults, match=says):
        load_cell(str(PORTAL), rho3(p303, p311))
