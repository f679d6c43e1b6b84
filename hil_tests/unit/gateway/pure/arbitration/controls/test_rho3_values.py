"""Timers, counters, INTEGER inputs, multi-function I/O, moved signals and the panel of a running control: rho3 3.3 to 3.7."""

import pytest

from gateway.pure.controllers.rho3.functions.display import Layer
from gateway.pure.image.records.cell import Quality
from hil_tests.unit.gateway.pure.arbitration.controls.bench import ControlBench, cell_with
from protocols.base.machine import ms

PARTS = "P3 = 16\nP13 = [0, 0, 0, 0, 0, 25]\nP14 = [3, 7]\nP27 = 0\nP36 = [26, 18]\nP20 = 15"


def bench_of(controller: str = 'kind = "rho3"\nhardware = "rho3.0"', rho3: str = PARTS, more: str = "") -> ControlBench:
    made = ControlBench(cell_with(controller, rho3, more))
    made.cycle(2)
    return made


def test_counters_and_timers_run_by_flags_the_plc_writes() -> None:
    bench = bench_of()
    control = bench.control
    assert [control.counter(n) for n in (0, 1, 15, 16)] == [3, 7, 0, None]
    for _ in range(2):
        assert control.write_flags(0, b"\x01")
        bench.cycle()
        assert control.write_flags(0, b"\x00")
        bench.cycle()
    assert control.counter(0) == 1 and control.flag_bytes()[1] & 1 == 0
    assert control.write_flags(2, bytes((1 << 5,)))
    bench.cycle()
    assert control.timer(5) == 200 and control.flag_bytes()[4] >> 5 & 1, "25 clocks of 8 ms"
    bench.cycle(26)
    assert control.timer(5) == 0 and control.flag_bytes()[3] >> 5 & 1
    assert not control.write_flags(127, b"\0\0") and control.timer(16) is None


def test_integer_inputs_are_taken_with_their_strobe() -> None:
    bench = bench_of()
    bench.inputs.values[76] = 91
    bench.cycle()
    assert bench.control.value("rho3.integer.401") == 0.0
    bench.put(672)
    assert bench.control.value("rho3.integer.401") == 91.0
    assert bench_of(rho3="P27 = 1").control.value("rho3.integer.401") == 0.0


def test_multi_function_terminals_and_the_board_are_values_of_the_cell() -> None:
    bench = bench_of()
    bench.control.put("rho3.terminal.input.2", 1)
    bench.put(18 * 8 + 3)
    assert bench.control.outputs[26] == 0b10
    assert [bench.control.value(f"rho3.terminal.output.{n}") for n in (1, 2, 3, 4)] == [0, 0, 0, 1]
    bench.control.put("rho3.board.input.7", 0x5A)
    assert bench.rho3.values.board_in[7] == 0x5A == bench.control.value("rho3.board.input.7")
    for name, value, kind in (
        ("rho3.terminal.input.2", 2, ValueError), ("rho3.board.input.0", 256, ValueError),
        ("rho3.terminal.output.1", 1, KeyError), ("rho3.integer.401", 1, KeyError), ("rho3.board.input.8", 1, KeyError),
    ):  # fmt: skip
        with pytest.raises(kind):
            bench.control.put(name, value)
    with pytest.raises(KeyError):
        bench.control.value("rho3.integer.409")
    plain = bench_of('kind = "rho3"', "")
    assert not any("terminal" in name or "board" in name for name in plain.control.names())


def test_signals_of_ours_work_where_the_cell_has_moved_them() -> None:
    moved = "[signals]\nSTBEXPA_RCI = 82\nPROGSEL_RCO = 122\nEMSTOP_RCO = 69\nUSER_1_RCO = 520\n"
    bench = bench_of('kind = "rho3"\n[[controller.process]]\nname = "X"\nsteps = [ { output = 2 } ]', "", moved)
    bench.put(82)
    assert bench.told == ["file not found"] and bench.output(121) and not bench.output(122)
    bench.rho3.start("X")
    bench.cycle(2)
    assert bench.output(521) and not bench.output(385)


def test_inputs_that_are_not_wired_count_and_a_lost_byte_reads_0() -> None:
    bench = bench_of('kind = "rho3"', "")
    bench.put(23, 22)
    assert bench.output(96) and bench.output(97)
    bench.quality(Quality.STALE, 2)
    assert bench.output(96)
    bench.quality(Quality.BAD, 2)
    assert not bench.output(96) and bench.output(68), "manual"


def test_a_silent_plc_is_an_error_after_the_grace_of_the_start() -> None:
    bench = bench_of('kind = "rho3"\nplc_silence_ms = 1000', "")
    control, state = bench.rho3, bench.core.state
    for seconds, heard, codes in ((80, False, []), (81.1, False, [1274]), (82, True, [1274]), (82.9, False, [1274])):
        control.step(bench.inputs, bytes(128), state, bench.now + ms(round(seconds * 1000)), heard=heard)
        assert bench.codes() == codes, seconds
    assert bench.errors.records[0].count == 1
    control.step(bench.inputs, bytes(128), state, bench.now + ms(83_100))
    assert bench.errors.records[0].count == 2, "after the first transmission its normal time counts"


def test_keys_screen_and_mode_of_the_panel() -> None:
    bench = bench_of('kind = "rho3"', "")
    functions = bench.rho3.functions
    functions.press("7")
    assert functions.display.read() == "7"
    functions.display.write(Layer.WRITE, 1, "HELLO")
    assert bench.control.status()["screen"] == ["HELLO".ljust(20), "Manual".ljust(20), *[" " * 20] * 2]
    functions.phg.mode = "7.12.1"
    bench.cycle(2)
    assert bench.output(115) and not bench.output(104)
