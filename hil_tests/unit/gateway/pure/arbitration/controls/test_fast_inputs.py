"""High-speed inputs and the PIC's timer of a running control: rho3 3.7 (L1240-1259, L5026-5032, L11382), 0.1 (L707); AX-477, AX-478."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.controllers.rho3.functions.processes import State
from gateway.pure.image.reasons import CommandState
from hil_tests.unit.gateway.pure.arbitration.controls.bench import CHAIN, RESET, ControlBench, cell_with
from protocols.base.machine import ms

BOARDS = 'kind = "rho3"\nboards = ["servo-3/5-narrow", "modular-i"]\n'
PROCESS = """
[[controller.process]]
name = "WAITS"
steps = [ {{ input = {input} }}, {{ output = {output} }} ]
"""
HOLD = 'kind = "rho3"\npic_timeout_ms = 50\n'


def bench_of(controller: str, rho3: str) -> ControlBench:
    made = ControlBench(cell_with(controller, rho3))
    made.cycle(2)
    return made


@pytest.mark.requirement("RHO-PLC-33", by="gateway.pure.controllers.rho3.signals.fast_io:Channels.read")
def test_a_process_waits_for_a_high_speed_input_and_mode_7_13_shows_its_board() -> None:
    bench = bench_of(BOARDS + PROCESS.format(input=623, output=7), "P11 = [1, 0, 0, 3]")
    control = bench.rho3
    assert [name for name in control.names() if "fast" in name] == [f"rho3.fast.{n}" for n in (610, 621, 622, 623)]
    process = control.start("WAITS")
    bench.cycle(5)
    assert process.state is State.WAITING and not bench.output(control.setup.numbers.first_output + 6)
    control.put("rho3.fast.623", 1)
    bench.cycle(2)
    assert bench.output(control.setup.numbers.first_output + 6) and not control.processes.processes
    assert list(control.pendant.view.fast_inputs()) == ["2: 001"], "the narrow board has none and is skipped"
    assert [control.value(f"rho3.fast.{n}") for n in (610, 621, 623)] == [0, 0, 1]
    for name, value, fault in (("rho3.fast.624", 1, KeyError), ("rho3.fast.610", 2, ValueError)):
        with pytest.raises(fault):
            control.put(name, value)


@pytest.mark.requirement("RHO-PLC-33", by="gateway.pure.controllers.rho3.signals.steps:Played._switched")
def test_a_process_that_reads_an_input_p11_does_not_have_ends_with_inadmissable_input() -> None:
    for channel in (611, 624, 801):
        bench = bench_of(BOARDS + PROCESS.format(input=channel, output=7), "P11 = [1, 0, 0, 3]")
        process = bench.rho3.start("WAITS")
        bench.cycle(2)
        assert (process.state, process.error) == (State.FAULTY, 254)
        assert process.error_text == f"inadmissable input: {channel}" and bench.codes() == [254]
        notes = [str(notice.text) for notice in bench.cell.warnings if "WAITS" in notice.where]
        assert notes == [f"inadmissable input: {channel}: it is not in P11"], "check has reported it before"


@pytest.mark.requirement("RHO-PLC-33", by="gateway.assembly.controllers:p11_of")
@pytest.mark.parametrize(
    ("controller", "p11", "word"),
    [
        (BOARDS, "[0, 1]", "incorr. highspeed-io: board 1"),
        (BOARDS, "[1, 0, 0, 9, 1, 0]", "incorr. highspeed-io: board 3"),
        (BOARDS, "[0, 0, 1, 10]", "incorr. highspeed-io: board 2"),
        ('kind = "rho3"', "[1, 0]", "incorr. highspeed-io: board 1"),
        ('kind = "rho3"\nhardware = "rho3.0"', "[1, 4, 5]", "incorr. highspeed-io: board 1"),
        (BOARDS, "[1]", "probe and inputs for each of at most three boards"),
        ('kind = "rho3"\nhardware = "rho3.0"', "[1, 4]", "probe, inputs, outputs"),
        (BOARDS + 'hardware = "rho3.0"', "[1, 4, 4]", "a rho3.0 has its own inputs"),
    ],
)
def test_p11_beyond_the_boards_aborts_the_run_up_and_check_says_it(controller: str, p11: str, word: str) -> None:
    with pytest.raises(CellFaults) as refused:
        cell_with(controller, f"P11 = {p11}")
    assert [word in str(fault) for fault in refused.value.faults] == [True]


@pytest.mark.requirement("RHO-PLC-34", by="gateway.pure.controllers.rho3.signals.fast_io:Channels.write")
def test_a_rho3_0_has_the_same_four_terminals_as_611_and_as_801() -> None:
    rack = 'kind = "rho3"\nhardware = "rho3.0"\n'
    bench = bench_of(rack + PROCESS.format(input=612, output=803), "P11 = [1, 2, 3]\nP36 = [-1, -1]")
    control = bench.rho3
    control.start("WAITS")
    bench.cycle(3)
    control.put("rho3.terminal.input.2", 1)
    bench.cycle(3)
    assert [control.value(f"rho3.terminal.output.{n}") for n in (1, 2, 3, 4)] == [0, 0, 1, 0]
    control.put("rho3.fast.612", 0)
    control.put("rho3.fast.611", 1)
    bench.cycle()
    assert [control.channels.read(n) for n in (611, 801, 612, 802)] == [True, True, False, False]
    control.put("rho3.fast.610", 1)
    assert control.channels.read(610) and control.value("rho3.terminal.input.1") == 1, "the probe is none of the four"
    for process, channel in (("input", 803), ("output", 804)):
        bad = bench_of(rack + PROCESS.format(**{"input": 611, "output": 803, process: channel}), "P11 = [1, 2, 3]")
        bad.rho3.put("rho3.fast.611", 1)
        faulty = bad.rho3.start("WAITS")
        bad.cycle(3)
        assert (faulty.error, faulty.error_text) == (254, f"inadmissable {process}: {channel}")


@pytest.mark.requirement("RHO-PLC-38", by="gateway.pure.controllers.rho3.signals.control:RhoControl._halt")
def test_a_late_cycle_of_the_pic_clears_everything_and_keeps_ready_open_until_a_restart() -> None:
    bench = bench_of(HOLD, "")
    bench.cycle(200)  # the start, which is not judged
    for code in (Code.REQUEST_CONTROL, Code.ENABLE):
        assert bench.settle(bench.give(code, 3)).state is CommandState.DONE
    assert any(bench.control.outputs) and all(bench.enabled())
    bench.now += ms(60)
    bench.cycle(3)
    assert not any(bench.control.outputs) and bench.codes()[-1] == 1275
    assert sum("PIC timer error" in line for line in bench.told) == 1
    bench.cycle(40)
    assert not any(bench.enabled()) and bench.core.state.emergency and not bench.core.state.ready
    bench.pulse(RESET)
    reset = bench.settle(bench.give(Code.FAULT_RESET, 3))
    bench.cycle(5)
    assert bench.core.state.emergency and not any(bench.control.outputs), reset
    assert bench.settle(bench.give(Code.ENABLE, 3)).state is CommandState.REFUSED
    assert bench.rho3.image.inputs == bytes(128) and not bench.rho3.image.input(CHAIN)


def test_a_pic_that_is_in_time_or_just_starts_is_left_alone() -> None:
    bench = bench_of(HOLD, "")
    bench.now += ms(200)
    bench.cycle(250)
    bench.now += ms(40)
    bench.cycle(3)
    assert not bench.rho3.halted and 1275 not in bench.codes()
    plain = bench_of('kind = "rho3"', "")
    plain.cycle(250)
    plain.now += ms(5000)
    plain.cycle(3)
    assert not plain.rho3.halted


@pytest.mark.parametrize(
    ("ends", "word"),
    [
        ('from = "A 40.0"\nto = "rho3.fast.623"', ""),
        ('from = "rho3.fast.610"\nto = "A 40.0"', ""),
        ('from = "A 40.0"\nto = "rho3.fast.624"', "did you mean rho3.fast.62"),
        ('from = "A 40.0"\nto = "rho3.integer.401"', "a route writes values a telegram of the cell carries, and inputs of [controller]"),
        ('from = "rho3.fast.620"\nto = "A 40.0"', "no value that can be read"),
    ],
)
def test_check_knows_which_values_of_the_control_a_route_may_join(ends: str, word: str) -> None:
    faults: tuple[str, ...] = ()
    try:
        cell_with(BOARDS, "P11 = [1, 0, 0, 3]", f'[[route]]\nname = "wire"\n{ends}\n')
    except CellFaults as refused:
        faults = tuple(str(fault) for fault in refused.faults)
    assert len(faults) == bool(word) and all(word in fault for fault in faults), faults


def test_a_measuring_channel_p11_does_not_have_is_refused() -> None:
    table = "\n[[measuring]]\nchannel = {}\ninput = 464\n"
    with pytest.raises(CellFaults) as refused:
        cell_with(BOARDS, "P11 = [1, 0, 0, 3]", table.format(611))
    told = [str(fault) for fault in refused.value.faults]
    assert len(told) == 1 and "measuring.611.channel" in told[0]
    assert "inadmissable input: P11 states 610, 621, 622, 623" in told[0]
    for p11, channel in (("P11 = [1, 0, 0, 3]", 622), ("", 611)):
        cell = cell_with(BOARDS, p11, table.format(channel))
        notes = [notice.text for notice in cell.notes if notice.where == f"measuring.{channel}.input"]
        assert notes == ["RC input 464 passes through the services process, one or two cycles later (AX-481)"]
