"""Signals that command the axes of a running cell: rho3 4.10 (L1295-1341, L7920-7945), 3.3; AX-332, AX-333, AX-335."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion, Quality
from hil_tests.unit.gateway.pure.arbitration.controls.bench import ACK, AUTO, CHAIN, DRIVE_ON, OTHER, PLC, RESET, ControlBench, cell_with

RHO3 = 'kind = "rho3"'
PROGRAMS = """
kind = "rho3"
kinematics = 2
[[controller.process]]
name = "FAR"
kinematics = [2]
steps = [ { output = 1 }, { output = 9 }, { to = { A1 = 1500.0 }, speed = "20 %" } ]
[[controller.process]]
name = "WATCH"
kind = "permanent"
steps = [ { input = 5 }, { output = 2 } ]
[[controller.process]]
name = "PAUSE"
repeat = true
steps = [ { wait_ms = 100 }, { output = 3 }, { wait_ms = 100 }, { output = 3, value = false } ]
"""
CELL, PLAYING = cell_with(RHO3), cell_with(PROGRAMS, "P24 = 8")


@pytest.fixture
def bench() -> ControlBench:
    made = ControlBench(CELL)
    made.run(0.3)
    return made


@pytest.fixture
def playing() -> ControlBench:
    made = ControlBench(PLAYING)
    made.run(0.3)
    return on(made.put(AUTO))


def on(bench: ControlBench) -> ControlBench:
    bench.put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [True, True]
    return bench


def motion(bench: ControlBench) -> Motion:
    return bench.core.state.motion


def test_drive_on_asks_for_control_and_gives_it_back_at_rest(bench: ControlBench) -> None:
    assert bench.dispatcher.owner == 0
    on(bench)
    assert bench.dispatcher.owner == PLC and bench.core.state.override == 1.0, "nobody else of this cell sets one"
    bench.put(off=(DRIVE_ON,)).run(0.5)
    assert bench.enabled() == [False, False] and bench.dispatcher.owner == 0


def test_what_is_set_at_start_switches_nothing_on_and_its_fall_switches_off() -> None:
    bench = ControlBench(CELL)
    bench.put(DRIVE_ON, cycles=1).run(1.0)
    assert bench.enabled() == [False, False]
    bench.put(off=(DRIVE_ON,)).put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [True, True]


def test_a_source_that_comes_back_with_the_bit_still_set_switches_nothing_on(bench: ControlBench) -> None:
    on(bench)
    bench.settle(bench.give(Code.DISABLE, 3))
    bench.quality(Quality.BAD, 8).quality(Quality.GOOD, 8).run(0.5)
    assert bench.enabled() == [False, False]
    bench.put(off=(DRIVE_ON,)).put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [True, True]
    bench.quality(Quality.BAD, 8).run(0.5)
    assert bench.enabled() == [True, True], "what a lost command source does is the command source's on_loss"
    bench.put(off=(DRIVE_ON,)).quality(Quality.GOOD, 8).run(0.5)
    assert bench.enabled() == [False, False], "it came back with drive-on at 0"


def test_single_axes_work_while_the_group_signal_is_0(bench: ControlBench) -> None:
    bench.put(193).run(1.0)
    assert bench.enabled() == [False, True]
    bench.put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [True, True]
    bench.put(off=(DRIVE_ON,)).run(0.5)
    assert bench.enabled() == [False, True] and bench.dispatcher.owner == PLC


def test_permits_and_control_count_as_for_every_source(bench: ControlBench) -> None:
    bench.permit(25, value=False)
    bench.put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [False, False], "no control allow"
    bench.permit(25)
    bench.put(off=(DRIVE_ON,)).run(0.2)
    bench.settle(bench.give(Code.REQUEST_CONTROL, source=OTHER))
    bench.dispatcher.control.link(OTHER, alive=True)
    bench.put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [False, False] and bench.dispatcher.owner == OTHER
    assert bench.dispatcher.source(PLC).by_code[Code.ENABLE].state is CommandState.REFUSED


def test_a_disabled_axis_goes_off_at_once_and_stays_off_until_a_new_start(bench: ControlBench) -> None:
    on(bench)
    bench.put(216).run(0.3)
    assert bench.enabled()[0] is False and bench.codes() == [1408]
    bench.put(off=(216,)).run(0.2)
    job = bench.settle(bench.give(Code.ENABLE, 1))
    assert job.state is CommandState.REFUSED and "A1 disabled" in job.detail
    assert bench.settle(bench.give(Code.ENABLE, 2)).state is CommandState.DONE
    bench.pulse(ACK)
    assert bench.codes() == []
    bench.put(off=(DRIVE_ON,)).put(DRIVE_ON).run(1.0)
    assert bench.enabled() == [False, True]


@pytest.mark.requirement("RHO-PLC-13", by="gateway.pure.controllers.rho3.signals.errors:Faults._clear")
def test_bit_62_leaves_emergency_stop_and_a_servo_error_that_only_control_reset_takes(bench: ControlBench) -> None:
    on(bench)
    bench.silent = {2}
    bench.run(0.3)
    bench.silent = set()
    bench.run(0.5)
    bench.rho3.interface.faults.came(91)
    bench.put(off=(CHAIN,)).put(CHAIN).run(0.1)
    assert {91, 528, 789} <= set(bench.codes())
    bench.pulse(ACK)
    assert 91 not in bench.codes() and {528, 789} <= set(bench.codes()) and bench.output(67)
    bench.pulse(RESET)
    assert bench.codes() == [] and not bench.output(67)


def test_emergency_stop_is_the_latch_of_the_cycle(bench: ControlBench) -> None:
    on(bench)
    bench.put(off=(CHAIN,)).run(0.3)
    assert bench.codes()[:1] == [528] and bench.output(67) and bench.enabled() == [False, False]
    bench.put(CHAIN).pulse(ACK)
    assert bench.codes() == [528] and bench.output(67)
    bench.pulse(RESET)
    assert bench.codes() == [] and not bench.output(67)
    bench.put(off=(CHAIN,)).put(CHAIN).run(0.2)
    assert bench.codes() == [528]
    bench.settle(bench.give(Code.FAULT_RESET))
    bench.cycle(2)
    assert bench.codes() == [] and not bench.output(67), "another command source's fault reset releases it, too"


def test_a_drive_that_falls_silent_is_an_error_until_control_reset(bench: ControlBench) -> None:
    on(bench)
    bench.silent = {2}
    bench.run(0.3)
    assert 789 in bench.codes()
    bench.pulse(ACK)
    assert 789 in bench.codes()
    bench.silent = set()
    bench.run(0.5)
    assert 789 in bench.codes(), "its cause is gone, it has not been reset"
    bench.pulse(RESET)
    assert bench.codes() == []


def test_a_program_moves_by_the_same_dispatcher(playing: ControlBench) -> None:
    playing.put(47 - 9 + 1)  # K02_A_MN has no meaning without KIN_A_MN
    playing.rho3.start("FAR")
    playing.run(0.5)
    assert 5.0 < playing.place() < 1500.0
    assert playing.settle(playing.give(Code.PTP_ABSOLUTE, 1, targets=(10.0,))).state is CommandState.REFUSED, "the axes are busy"
    assert playing.output(384) and playing.output(392)
    playing.run(12.0)
    assert abs(playing.place() - 1500.0) < 0.1 and playing.rho3.processes.processes == ()


@pytest.mark.requirement(
    "RHO-PLC-13", by=("gateway.pure.controllers.rho3.signals.errors:Faults.update", "gateway.pure.controllers.rho3.signals.errors:kind_of")
)
def test_bit_62_clears_a_runtime_error_and_the_process_goes_on_to_its_end(playing: ControlBench) -> None:
    playing.rho3.start("FAR")
    playing.run(0.5)
    playing.rho3.interface.faults.came(380)
    playing.run(0.1)
    assert playing.codes() == [380]
    before = playing.place()
    playing.put(ACK)
    assert playing.codes() == [], "with the edge"
    playing.rho3.interface.faults.came(91)
    playing.run(0.1)
    playing.put(off=(ACK,))
    assert playing.codes() == [91], "neither the bit that stands nor its fall clears anything"
    playing.put(ACK)
    assert playing.codes() == [] and motion(playing) is Motion.RUNNING and playing.place() > before
    assert [process.name for process in playing.rho3.processes.processes] == ["FAR"]
    playing.run(12.0)
    assert abs(playing.place() - 1500.0) < 0.1 and playing.rho3.processes.processes == ()


def test_automatic_taken_away_under_a_block_ends_program_and_motion(playing: ControlBench) -> None:
    playing.put(54, 38, 39)
    playing.rho3.start("FAR")
    playing.run(0.5)
    playing.put(off=(38,)).run(0.2)
    assert motion(playing) is Motion.RUNNING, "its kinematic is 2"
    playing.put(off=(39,)).run(1.5)
    assert motion(playing) is Motion.IDLE and playing.place() < 1000.0
    assert playing.codes() == [251] and any("AUTO/MANUAL switching" in line for line in playing.told)
    playing.put(39)
    with pytest.raises(Exception, match="1051"):
        playing.rho3.start("FAR")
    playing.pulse(ACK)
    assert playing.rho3.processes.processes == () and playing.codes() == []
    before = playing.place()
    playing.rho3.start("FAR")
    playing.run(0.5)
    assert playing.place() > before + 5.0, "deselected, it may run again"


def test_control_reset_ends_programs_with_their_motion_and_clears_outputs_up_to_p24(playing: ControlBench) -> None:
    for name in ("WATCH", "FAR", "PAUSE"):
        playing.rho3.start(name)
    playing.run(0.5)
    playing.put(61).pulse(RESET).run(1.5)
    assert [process.name for process in playing.rho3.processes.processes] == ["WATCH"], "61: permanent ones stay"
    assert motion(playing) is Motion.IDLE and playing.place() < 1000.0
    assert [playing.output(bit) for bit in (384, 386, 392)] == [False, False, True]
    playing.put(468).run(0.1)
    assert playing.output(385) and playing.rho3.processes.processes == ()
    playing.rho3.start("WATCH")
    playing.put(off=(61, 468)).pulse(RESET)
    assert playing.rho3.processes.processes == ()


def test_a_program_that_is_refused_ends_with_an_error(playing: ControlBench) -> None:
    playing.put(off=(AUTO,))
    playing.rho3.start("FAR")
    playing.cycle(3)
    assert playing.codes() == [250] and "Inadmis. in manual op." in playing.rho3.processes.processes[0].error_text
    playing.put(AUTO).pulse(ACK)
    playing.put(off=(DRIVE_ON,)).run(0.3)
    playing.rho3.start("FAR")
    playing.cycle(3)
    assert playing.codes() == [253]


def test_steps_that_wait_and_repeat(playing: ControlBench) -> None:
    playing.rho3.start("PAUSE")
    seen = []
    for _ in range(8):
        playing.run(0.05)
        seen.append(playing.output(386))
    assert seen == [False, False, True, True, False, False, True, True]
