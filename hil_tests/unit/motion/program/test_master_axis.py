"""LINEAR of axes without transformation: the main axes have the path speed, manual axes go along.  rho 3 TO04 section 11 (L5598-5644)."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, run
from hil_tests.lab.cells.printed_tables import PROGRAM
from motion.geometry.limits import limits_from
from motion.kinematics.identity import Identity
from motion.planner.arm import Arm
from motion.planner.robot import Machine
from motion.program.errors import BlockError
from motion.program.text.reader import read

HEAD = "robot turntables\nangles rho3\naxes deg deg deg deg deg\nstart 0 0 0 0 0\n"


@functools.cache
def tables(speed: float = 20_000.0) -> Machine:
    """P303 = 3, 4, 4, 4, 4; P311 = 360; fast slaves, so that the master alone sets the pace."""
    rates = {"accel": 100 * speed, "jerk": 25_000 * speed}
    axes = [limits_from(f"A{n}", "deg", lower=0, upper=360, speed=speed, modulo=360, **rates) for n in range(1, 6)]
    limits = tuple(replace(axis, manual=n > 0) for n, axis in enumerate(axes))
    return Machine(Identity(limits), limits)


def rates(lines: str, machine: Machine) -> Array:
    """(n, axes) deg/s of the set values at 1 ms."""
    arm = Arm(machine, (0.0,) * machine.axes)
    for block in read(HEAD + lines).blocks:
        arm.add(block)
    arm.finish()
    return np.degrees(np.diff(run(arm), axis=0)) / 1e-3


@pytest.mark.requirement("RHO-MOT-30", by="motion.planner.untransformed:main_rates")
def test_the_master_goes_through_the_printed_example_at_500_and_the_slaves_with_it() -> None:
    """Where a slave changes its speed 4 deg of the master before and behind the point are its ramp (zone); the master has none."""
    blocks = "".join(f"linear joints {' '.join(map(str, point))}\n" for point in PROGRAM)
    found = rates("set turn=500 zone=4,360,360,360,360 blend=joint\n" + blocks, tables())
    assert found[20:-20, 0] == pytest.approx(500.0, rel=2e-3), "constant but for the first and the last 20 ms of 0.73 s"
    assert np.sum(found, axis=0) * 1e-3 == pytest.approx([360, 360, 360, 680, 360], abs=1e-6)
    assert np.abs(found[:, 3]).max() == pytest.approx(500.0 * 360 / 20, rel=0.01), "the slave that turns 360 deg on 20 of the master"


def test_a_main_axis_takes_part_in_the_path_speed_and_manual_ones_alone_have_it() -> None:
    machine = tables()
    both = replace(machine, limits=tuple(replace(axis, manual=n > 1) for n, axis in enumerate(machine.limits)))
    found = rates("linear joints 300 400 100 0 0 turn=200\n", both)
    assert np.hypot(found[:, 0], found[:, 1]).max() == pytest.approx(200.0, rel=1e-4)
    assert found[:, 0].max() == pytest.approx(120.0, rel=1e-4) and found[:, 2].max() == pytest.approx(40.0, rel=1e-4)
    alone = rates("linear joints 0 300 400 0 0 turn=200\n", machine)
    assert np.hypot(alone[:, 1], alone[:, 2]).max() == pytest.approx(200.0, rel=1e-4)


def test_a_slave_that_cannot_keep_up_slows_the_master_and_ptp_keeps_the_limit_too() -> None:
    slow = rates("linear joints 100 300 0 0 0 turn=500\n", tables(600.0))
    assert slow[:, 1].max() == pytest.approx(600.0, rel=1e-3) and slow[:, 0].max() == pytest.approx(200.0, rel=1e-3)
    assert rates("ptp joints 100 30 0 0 0 turn=90\n", tables(600.0))[:, 0].max() == pytest.approx(90.0, rel=1e-4)


def test_linear_axes_are_led_by_path_and_others_go_along_in_the_same_time() -> None:
    limits = (
        limits_from("X", "mm", lower=-500, upper=500, speed=1000, accel=9000, jerk=4e5),
        replace(limits_from("C", "deg", lower=-360, upper=360, speed=900, accel=9000, jerk=4e5), manual=True),
    )
    machine = Machine(Identity(limits), limits)
    arm = Arm(machine, (0.0, 0.0))
    for block in read("robot turntables\naxes mm deg\nstart 0 0\nlinear joints 100 90 path=200\nlinear joints 100 180 turn=60\n").blocks:
        arm.add(block)
    arm.finish()
    found = np.diff(run(arm), axis=0) / 1e-3
    assert found[:, 0].max() == pytest.approx(0.2, rel=1e-4)
    led = found[:, 0] > 1e-6
    assert np.degrees(found[led, 1]) == pytest.approx(found[led, 0] * 900.0, rel=1e-6)
    assert np.degrees(found[~led, 1].max()) == pytest.approx(60.0, rel=1e-4)


@pytest.mark.parametrize("line", ("circular via pose 0 0 0 0 0 0 to joints 10 20 0 0 0", "spline joints 10 0 0 0 0"))
def test_circles_and_splines_have_no_meaning_there(line: str) -> None:
    with pytest.raises(BlockError):
        rates(line + "\n", tables())


def test_the_master_turns_on_over_the_end_of_its_round() -> None:
    found = rates("set turn=300 zone=5,5,5,5,5 blend=joint\n" + "linear rel joints 200 0 0 0 0\n" * 4, tables(600.0))
    assert math.isclose(float(np.sum(found[:, 0])) * 1e-3, 800.0, abs_tol=1e-6)
    assert found[300:-300, 0] == pytest.approx(300.0, rel=1e-3)
