"""What one of several kinematics asks for, and no other one, as real processes: an arm and a SCARA on ten emulated CiA 402 drives."""

from collections.abc import Iterator

import numpy as np
import pytest

from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.arm_and_scara import HEAD, both
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.partners.plc2 import ABORTED, DONE, REFUSED
from hil_tests.lab.running.cell_running import P5_MS
from hil_tests.lab.running.program_run import PROBE, PROGRAM, ProgramRun, program_run
from hil_tests.lab.virtual.planned_bench import Driven
from motion.files import bnr

PROGRAMS = {
    1: HEAD + "move arm ptp joints 10 30 90 0 60 0 and scara ptp joints 20 90 -200 0\n",
    2: HEAD + "kinematic scara\nmach_pos joints 0 80 -200 0\nmove arm ptp joints 15 30 90 0 60 0 and scara ptp joints 10 80 -200 0\n",
    4: HEAD + "move arm ptp joints 10 30 90 0 60 0 and scara ptp joints 10 80 -200 0\n",
    5: HEAD
    + "kinematic scara\nread_begin curve.bnr\nmove_file curve.bnr modulo=0,0,0,0\n"
    + "move arm ptp rel joints 5 0 0 0 0 0 and scara ptp rel joints 0 5 0 0\n",
    6: HEAD
    + "kinematic arm\nmeasure_on ch610\nkinematic scara\nmeasure_on ch620\n"
    + "move arm ptp joints 40 30 90 0 60 0 speed=5 and scara ptp joints 60 80 -200 0 speed=5\n"
    + "move arm ptp mpos and scara ptp mpos\n",
    3: HEAD + "kinematic scara\nmach_pos joints 0 80 90 0\nmove arm ptp joints 15 30 90 0 60 0\n",
}
K = np.arange(1, 301) / 300
POINTS = np.outer(10 * K**3 - 15 * K**4 + 6 * K**5, (40.0, -20.0, 30.0, 60.0)) + (10.0, 80.0, -200.0, 0.0)  # deg and mm
ARM, SCARA = 0b111111, 0b1111000000
MEASURING = "".join(
    f'[[measuring]]\nchannel = {channel}\ninput = {PROBE + n}\nrobot = "{robot}"\n\n'
    for n, (channel, robot) in enumerate(((610, "arm"), (620, "scara")))
)
SI = np.array([np.pi / 180] * 8 + [1e-3, np.pi / 180])


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ProgramRun]:
    folder = tmp_path_factory.mktemp("cell")
    (folder / "curve.bnr").write_bytes(bnr.encode(bnr.Header(time_base_us=1000 * P5_MS, axes=4), POINTS.tolist()))
    with program_run(
        folder, "arm6", PROGRAMS, "words", change=lambda text: both(text).replace("# ---- drives", f"{MEASURING}# ---- drives")
    ) as run:
        run.ready()
        yield run


def asked(robots: ProgramRun) -> Array:
    """What the drives were asked for last, deg and mm: increments, by the emulator's record."""
    return np.asarray(Driven(robots.cell, robots.run.record(), robots.run.p5_ms / 1e3).sets[-1] / SI)


def test_machine_positions_of_one_are_set_and_both_go_on_together_by_their_own_numbers(robots: ProgramRun) -> None:
    assert robots.command(PROGRAM, 1).state == DONE, robots.run.words()
    robots.still()
    before = asked(robots)
    assert robots.command(PROGRAM, 2).state == DONE, robots.run.words()
    robots.still()
    assert asked(robots) - before == pytest.approx([5, 0, 0, 0, 0, 0, 10, 0, 0, 0], abs=0.01)
    assert np.array(robots.sets()) / SI == pytest.approx([15, 30, 90, 0, 60, 0, 10, 80, -200, 0], abs=1e-6)
    assert robots.planner().placed == SCARA
    far = robots.command(PROGRAM, 3)
    assert (far.state, far.reason) == (REFUSED, Reason.PROGRAM_FAULT)
    said = [entry["text"] for entry in robots.run.journal("command") if "cannot be run" in entry["text"]]
    assert "line 9: block 1, axis S3: kinematic scara: mach_pos: target 90 mm is outside -400 .. 0 mm" in said[-1]


def test_points_of_a_file_are_set_values_of_one_while_the_other_rests_and_both_go_on(robots: ProgramRun) -> None:
    assert robots.command(PROGRAM, 4).state == DONE, robots.run.words()
    points = np.array([(10.0, 80.0, -200.0, 0.0), *POINTS], dtype=np.float32).astype(float)
    robots.plc.send(PROGRAM, 5)
    robots.watch("it moves", lambda s: s.motion is Motion.RUNNING and s.piece > 0)
    rows = robots.watch("at rest", lambda s: s.motion is Motion.IDLE, 60.0) / SI
    assert robots.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE, robots.run.words()
    filed = rows[(rows[:, 8] < -170.001) & (rows[:, 8] > -199.999)]
    nearest = [np.abs(points - row[6:]).max(axis=1).min() for row in filed]
    assert len(filed) > 20 and max(nearest) < 1e-6, "what is seen of it are its points"
    assert np.ptp(filed[:, :6], axis=0).max() == 0.0, "the arm rests"
    assert np.array(robots.sets()) / SI == pytest.approx([15, 30, 90, 0, 60, 0, 50, 65, -170, 60], abs=1e-5)


def test_each_goes_back_to_where_it_was_at_its_own_edge_both_in_one_block(robots: ProgramRun) -> None:
    for n in (0, 1):
        robots.coil(PROBE + n, False)
    assert robots.command(PROGRAM, 4).state == DONE, robots.run.words()
    robots.plc.send(PROGRAM, 6)
    robots.watch("some way", lambda s: s.axes[0].set / SI[0] > 15)
    robots.coil(PROBE, True)
    robots.watch("the arm has measured", lambda s: s.measured_mask == ARM)
    robots.watch("further", lambda s: s.axes[0].set / SI[0] > 25)
    robots.coil(PROBE + 1, True)
    robots.watch("both have", lambda s: s.measured_mask == ARM | SCARA)
    measured = [axis.measured for axis in robots.state().axes[: robots.axes]]
    robots.watch("at rest", lambda s: s.motion is Motion.IDLE, 60.0)
    assert robots.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE, robots.run.words()
    assert robots.sets() == pytest.approx(measured, abs=1e-9)
    arm, scara = ((measured[n] / SI[n] - 10) / way for n, way in ((0, 30), (6, 50)))
    assert 0.1 < arm < 0.35 and arm + 0.1 < scara < 0.9, "shares of their ways: the edge of the SCARA came later"
