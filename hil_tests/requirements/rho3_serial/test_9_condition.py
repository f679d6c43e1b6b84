"""rho 3 Releases part 1, section 9: CONDITION of units and files, and `;;SER_IO_STOP`."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import CHARACTER, INTEGER, REAL, TEXT, point
from gateway.pure.controllers.rho3.serial.events import Finished, ProgramAborted
from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.programs import DirectiveError, ser_io_stop
from gateway.pure.controllers.rho3.serial.setup import Condition, Function, Process, Setup
from hil_tests.lab.virtual.rho3_line import DLE, NAK, ONE, STX, TWO, InterfaceBench, done, failed, v24_1, wire
from protocols.base.machine import Damage, Ns, ms

LINE = Setup((v24_1(5, input_timeout_ms=1000),))
LINK = Setup((v24_1(8, input_timeout_ms=60_000),))
ACK = ms(550)


@pytest.mark.requirement(
    "RHO-SER-31",
    by=(
        "gateway.pure.controllers.rho3.serial.line:Line._expire",
        "gateway.pure.controllers.rho3.serial.line_interface:LineInterface.finish",
    ),
)
def test_a_read_without_characters_is_a_time_out_minus_3() -> None:
    bench = InterfaceBench(LINE).at(0).read(ONE, "V24_1", INTEGER).at(ms(500)).hears(b"1").at(ms(1499)).finds()
    bench.at(ms(1500)).finds(failed(1, Condition.TIME_OUT))
    assert bench.condition(ONE, "V24_1") == -3


@pytest.mark.requirement(
    "RHO-SER-31",
    by=("gateway.pure.controllers.rho3.serial.line:Line.damaged", "gateway.pure.controllers.rho3.serial.line:Line._read_failed"),
)
@pytest.mark.parametrize("damage, code", [(Damage.PARITY, -4), (Damage.OVERRUN, -5), (Damage.FRAMING, -6), (Damage.BREAK, -6)], ids=str)
def test_a_spoiled_character_has_its_code(damage: Damage, code: int) -> None:
    bench = InterfaceBench(LINE).at(0).read(ONE, "V24_1", INTEGER).hears(b"1").damaged(damage).finds(failed(1, Condition(code)))
    assert bench.condition(ONE, "V24_1") == code
    bench.damaged(damage).read(ONE, "V24_1", INTEGER).finds(failed(2, Condition(code)))  # it came before the READ (8.3)
    bench.read(ONE, "V24_1", INTEGER).hears(b"7\r").finds(done(3, 7))
    assert bench.condition(ONE, "V24_1") == 0


def test_an_output_the_line_does_not_take_is_a_time_out_and_is_not_sent_later() -> None:
    bench = InterfaceBench(LINE, leaves_at_once=False).at(0).write(ONE, "V24_1", (TEXT, b"0123456789")).says(b"01234567")
    assert bench.condition(ONE, "V24_1") is None  # CONDITION waits for the output
    bench.at(ms(9_999)).left().says(b"89").at(ms(19_998)).finds().at(ms(19_999)).finds(failed(1, Condition.TIME_OUT))
    assert bench.condition(ONE, "V24_1") == Condition.TIME_OUT


def silence(bench: InterfaceBench) -> InterfaceBench:
    return bench.at(6 * ACK)


def naks(bench: InterfaceBench) -> InterfaceBench:
    return bench.hears(NAK * 6)


@pytest.mark.requirement("RHO-SER-31", by="gateway.pure.controllers.rho3.serial.driver:Driver._written")
def test_a_write_by_3964r_without_answer_is_minus_3_and_refused_minus_9() -> None:
    bench = (
        InterfaceBench(LINK).at(0).write(ONE, "V24_1", (CHARACTER, 1)).at(6 * ACK).says(STX * 6 + NAK).finds(failed(1, Condition.TIME_OUT))
    )
    assert bench.condition(ONE, "V24_1") == -3
    bench.write(ONE, "V24_1", (CHARACTER, 1))
    for turn in range(6):
        bench.at(6 * ACK + turn).hears(NAK)
    bench.says(STX * 6 + NAK).finds(failed(2, Condition.PROTOCOL))
    bench.write(ONE, "V24_1", (CHARACTER, 1)).says(STX)
    for turn in range(5):
        bench.at(6 * ACK + 10 + turn).damaged(Damage.PARITY).says(STX)
    bench.damaged(Damage.FRAMING).says(NAK).finds(failed(3, Condition.FRAMING))


@pytest.mark.parametrize("why, code", [("gap", -3), ("check", -9), ("parity", -4)])
def test_a_read_by_3964r_learns_why_the_partner_gave_up(why: str, code: int) -> None:
    bench = InterfaceBench(LINK).at(0).read(ONE, "V24_1", CHARACTER)
    moment: Ns = 0
    for _ in range(6):
        bench.hears(STX)
        if why == "parity":
            bench.damaged(Damage.PARITY)
        if why == "gap":
            moment += ms(220)
            bench.at(moment)
        else:
            bench.hears(b"A\x10\x03\x00")
    bench.finds(failed(1, Condition(code))).says((DLE + NAK) * 6)


def test_a_port_that_goes_away_is_minus_7() -> None:
    for setup, text in ((LINE, b"x"), (LINK, STX)):
        bench = InterfaceBench(setup, leaves_at_once=False).write(ONE, "V24_1", (CHARACTER, ord("x"))).says(text)
        bench.loses_the_port().finds(failed(1, Condition.INTERFACE)).says(b"")
    bench = InterfaceBench(LINE).read(ONE, "V24_1", INTEGER).loses_the_port().finds(failed(1, Condition.INTERFACE))
    bench = InterfaceBench(LINK).read(ONE, "V24_1", CHARACTER).loses_the_port().finds().gets(b"A").finds(done(1, 65))


def test_a_write_by_3964r_to_a_port_that_stays_away_is_a_time_out_too() -> None:
    control = LineManager(LINK)
    line = control.lines["SER_1"]
    for ticket in (1, 2):
        control.write(ONE, "V24_1", [(CHARACTER, ticket)], ms(0))
    assert line.deadline() == 6 * ACK
    assert line.wake(6 * ACK) == [failed(1, Condition.TIME_OUT)]
    assert line.take_output() == STX  # the port is back: the second is alive
    line.sent(6 * ACK)
    assert line.deadline() == 7 * ACK


def test_a_write_waits_for_a_block_of_the_partner_however_slowly_it_comes() -> None:
    bench = InterfaceBench(LINK).at(0).hears(STX).says(DLE).write(ONE, "V24_1", (CHARACTER, 1))
    for tick in range(1, 60):
        bench.at(ms(200 * tick)).hears(b"A")
    bench.hears(wire(b"A" * 59)[59:]).says(DLE + STX).hears(DLE).says(wire(b"\x01")).hears(DLE).finds(done(1))


def test_the_codes_of_text() -> None:
    bench = InterfaceBench(LINE).read(ONE, "V24_1", REAL).hears(b"1.2.3\r").finds(failed(1, Condition.DEC_VALUE))
    bench.read(ONE, "V24_1", TEXT).hears(b"x" * 81).finds(failed(2, Condition.LENGTH)).hears(b"\r").read_begin(ONE, "V24_1")
    bench.read(ONE, "V24_1", point(3)).hears(b"1,2\r").finds(failed(3, Condition.POINT))
    bench.read(ONE, "V24_1", INTEGER).hears(b"x\r").finds(failed(4, Condition.PROTOCOL))
    bench.write(ONE, "V24_1", (point(2), None)).finds(failed(5, Condition.POINT))
    bench.write(ONE, "V24_1", (REAL, float("inf"))).says(b"").finds(failed(6, Condition.DEC_VALUE))


def test_no_interface_is_minus_1_before_any_call() -> None:
    bench = InterfaceBench(LINE)
    assert [bench.condition(ONE, unit) for unit in ("V24_1", "V24_2", "PHG", "TTY")] == [0, -1, 0, -1]


def test_each_process_has_its_own_condition() -> None:
    bench = InterfaceBench(LINE).at(0).read(ONE, "V24_1", INTEGER).at(ms(1000)).finds(failed(1, Condition.TIME_OUT))
    assert (bench.condition(ONE, "V24_1"), bench.condition(TWO, "V24_1")) == (-3, 0)
    bench.ends(ONE)
    assert bench.condition(ONE, "V24_1") == 0


# ---- 9.1 SER_IO_STOP


@pytest.mark.requirement(
    "RHO-SER-32",
    by=(
        "gateway.pure.controllers.rho3.serial.programs:ser_io_stop",
        "gateway.pure.controllers.rho3.serial.line_interface:LineInterface.finish",
    ),
)
@pytest.mark.parametrize(
    "instruction, goes_on", [(";; SER_IO_STOP -", True), (";;SER_IO_STOP +", False), (";; ser_io_stop ; x", False), ("", False)]
)
def test_only_with_the_instruction_a_program_goes_on_after_a_time_out(instruction: str, goes_on: bool) -> None:
    source = f"; communication test\n{instruction}\n\nPROGRAM IO_TEST\nREAD V24_1, Index\nPROGRAM_END\n"
    process = Process(7, stop_on_error=ser_io_stop(source))
    bench = InterfaceBench(LINE).at(0).read(process, "V24_1", INTEGER).write(process, "V24_1", (TEXT, b"more")).at(ms(1000))
    if goes_on:
        bench.says(b"more").finds(failed(1, Condition.TIME_OUT), done(2))
    else:
        aborted = ProgramAborted(7, Function.V24_1, Condition.TIME_OUT, "Time out")
        bench.says(b"").finds(failed(1, Condition.TIME_OUT), aborted, Finished(2, Condition.NO_ERROR, (), True))


@pytest.mark.parametrize(
    "source, words",
    [
        (";;SER_IO_STOP -\n;;SER_IO_STOP +\n", "line 2"),
        ("PROGRAM A\n;;SER_IO_STOP -\n", "line 2"),
        (";;SER_IO_STOP *\n", "line 1"),
    ],
)
def test_the_instruction_occurs_once_at_the_beginning(source: str, words: str) -> None:
    with pytest.raises(DirectiveError, match=words):
        ser_io_stop(source)
    assert ser_io_stop(";;PROCESS_TYPE = PERMANENT\n;;SER_IO_STOP -\nPROGRAM A") is False


def test_a_block_received_well_leaves_the_condition_of_a_write_alone() -> None:
    bench = (
        InterfaceBench(LINK).at(0).write(ONE, "V24_1", (CHARACTER, 1)).at(6 * ACK).finds(failed(1, Condition.TIME_OUT)).says(STX * 6 + NAK)
    )
    bench.gets(b"A")
    assert bench.condition(ONE, "V24_1") == Condition.TIME_OUT
    bench.hears(STX).says(b"").read(ONE, "V24_1", CHARACTER).says(DLE).hears(wire(b"B")).says(DLE).finds(done(2, 65))
