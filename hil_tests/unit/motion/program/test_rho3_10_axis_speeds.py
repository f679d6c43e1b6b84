"""rho 3 Releases part 2, section 10: axis speeds on paths, P306 sub-query 6 = 0..3, on paper and in a cell of emulated drives.  AX-571."""

from dataclasses import replace

import pytest

from gateway.assembly.programs import machine_of_cell, machines_of_cell
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState, Reason
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from motion.timing.limiter import TooFast

PATH = find_config("portal", "cells")
SHIPPED = read_text(PATH)
FAST = "linear pose 450 100 50 0 0 0 path=1600\n"  # twice the speed of X
TEXT = f"""angles rho3
axes mm mm mm deg
start 50 50 50 0
linear pose 100 100 50 0 0 0 path=300
{FAST}linear pose 450 100 50 0 0 0 path=1600
linear pose 100 100 50 0 0 0 path=2400
"""
LINES = ["line 5: block 2, axis X: Interpolator Stop: 2 times", "line 7: block 4, axis X: Interpolator Stop: 3 times"]


def text(mode: object) -> str:
    return SHIPPED.replace("[robot]\n", f"[robot]\ntoo_fast = {mode}\n")


@pytest.fixture(scope="module")
def planned() -> Planned:
    cell = load_cell(str(PATH), SHIPPED.replace('by = "gateway", mode = 0', 'by = "none", mode = 0'))
    return Planned(ServodynRobot(cell=cell))


def driven(planned: Planned, mode: int) -> tuple[CommandState, list[str], set[str], tuple[float, float]]:
    """How the program ends, what was told of it, the warnings that stood meanwhile, and the shares of the limits it took."""
    planned.machine = machine_of_cell(load_cell(str(PATH), text(mode)))
    planned.bench.run(0.1)
    planned.driven()
    job, stood = planned.order(TEXT), set()
    while job.open:
        planned.bench.cycle()
        stood.add(planned.programs.state.warning)
    return job.state, planned.programs.slowing.take(), stood - {""}, planned.driven().shares()


@pytest.mark.requirement("RHO-MOT-45", by="gateway.pure.planning.warnings:Slowing.look")
def test_mode_3_keeps_the_path_and_the_limits_and_reports_the_axis_once_a_block(planned: Planned) -> None:
    state, told, stood, shares = driven(planned, 3)
    assert state is CommandState.DONE and max(shares) <= 1.02
    assert [each[: len(line)] for each, line in zip(told, LINES, strict=True)] == LINES
    assert stood == set(told), "the page shows it while the block is under way"
    assert planned.programs.state.warning == ""


def test_what_is_reported_goes_by_the_speed_that_is_asked_for(planned: Planned) -> None:
    planned.done(Code.OVERRIDE, 0.4)
    _, told, _, _ = driven(planned, 3)
    assert [each[:15] for each in told] == ["line 7: block 4"], "0.4 times 2 is within the limit"
    planned.done(Code.OVERRIDE, 0.3)
    assert driven(planned, 3)[1] == []
    planned.done(Code.OVERRIDE, 1.0)


@pytest.mark.parametrize("mode", [0, 2])
def test_modes_0_and_2_report_nothing_in_automatic_and_no_set_value_is_beyond_a_limit(planned: Planned, mode: int) -> None:
    state, told, stood, shares = driven(planned, mode)
    assert state is CommandState.DONE and told == [] and stood == set() and max(shares) <= 1.02


def test_mode_1_refuses_the_program_before_anything_moves(planned: Planned) -> None:
    planned.machine = machine_of_cell(load_cell(str(PATH), text(1)))
    before = [axis.set for axis in planned.state.axes]
    job = planned.bench.settle(planned.order(TEXT))
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert job.detail.startswith("line 5: block 2, axis X: Ax-Velocity exceeded: 2 times its speed")
    assert [axis.set for axis in planned.state.axes] == before


def test_p306_of_a_kinematic_is_too_fast_of_its_robot() -> None:
    def modes(rho3: str, robots: str) -> list[TooFast]:
        cell = load_cell(str(PATH), SHIPPED.replace("[robot]\n", f"[rho3]\n{rho3}\n\n[[robot]]\n{robots}"))
        return [machine.too_fast for machine in machines_of_cell(replace(cell, robot=cell.robot[:1]))]

    wanted = [TooFast.SLOW, TooFast.ABORT, TooFast.SLOW, TooFast.WARN]
    assert [modes(f"P306 = [ {{ monitoring = {mode} }} ]", "")[0] for mode in range(4)] == wanted
    for rho3, robots, words in (
        ("P306 = [ { monitoring = 4 } ]", "", "0..3"),
        ("P306 = [ { monitoring = 3 } ]", 'too_fast = "abort"\n', "P306[1].monitoring sets the same"),
        ("P306 = [ {}, {} ]", "", "1 [[robot]] tables"),
        ("P306 = [ { rtyp = 3 } ]", "", "rtyp"),
    ):
        with pytest.raises(CellFaults) as caught:
            modes(rho3, robots)
        assert words in str(caught.value), str(caught.value)


@pytest.mark.parametrize("mode", ["4", "-1", "true", "3.0", '"warn"'])
def test_what_is_no_mode_is_refused_with_those_there_are(mode: str) -> None:
    with pytest.raises(CellFaults, match=r"too_fast = .*: allowed slow \| abort \| error \| 0 \| 1 \| 2 \| 3"):
        load_cell(str(PATH), text(mode))
