"""rho 3 Releases part 2, section 10: READ_BEGIN and WRITE_BEGIN on units."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import CHARACTER, INTEGER, TEXT
from gateway.pure.controllers.rho3.serial.events import ProgramAborted
from gateway.pure.controllers.rho3.serial.setup import Condition, Function, Process, Setup
from hil_tests.lab.virtual.rho3_line import DLE, NAK, ONE, STX, TWO, InterfaceBench, deleted, done, failed, v24_1, wire
from protocols.base.machine import ms

LINE = Setup((v24_1(5, input_timeout_ms=1000),), chunk=3)
LINK = Setup((v24_1(8),))


# ---- 10.3 the write buffer


@pytest.mark.requirement(
    "RHO-SER-34",
    by=(
        "gateway.pure.controllers.rho3.serial.manager:LineManager.write_begin",
        "gateway.pure.controllers.rho3.serial.line:Line.write_begin",
    ),
)
def test_write_begin_cuts_the_output_and_the_next_one_is_whole() -> None:
    bench = (
        InterfaceBench(LINE, leaves_at_once=False).write(ONE, "V24_1", (TEXT, b"first output")).write(ONE, "V24_1", (TEXT, b"x"), hold=True)
    )
    bench.says(b"fir").write_begin(ONE, "V24_1")
    assert bench.condition(ONE, "V24_1") == 0
    bench.write(ONE, "V24_1", (TEXT, b"--- abort ---"))
    for text in (b"---", b" ab", b"ort", b" --", b"-"):
        bench.says(text).left()
    bench.finds(deleted(1), done(2))
    assert bench.condition(ONE, "V24_1") == 0


@pytest.mark.requirement("RHO-SER-34", by="gateway.pure.controllers.rho3.serial.line:Line.write_begin")
def test_outputs_of_other_processes_stay() -> None:
    bench = (
        InterfaceBench(LINE, leaves_at_once=False).write(TWO, "V24_1", (TEXT, b"other")).write(ONE, "V24_1", (TEXT, b"mine")).says(b"oth")
    )
    bench.write_begin(ONE, "V24_1").left().says(b"er").left().says(b"").finds(deleted(2), done(1))


def test_write_begin_sets_status_0() -> None:
    bench = (
        InterfaceBench(LINE).at(0).read(ONE, "V24_1", INTEGER).at(ms(1000)).finds(failed(1, Condition.TIME_OUT)).write_begin(ONE, "V24_1")
    )
    assert bench.condition(ONE, "V24_1") == 0


@pytest.mark.requirement(
    "RHO-SER-35", by=("gateway.pure.controllers.rho3.serial.driver:Driver.write_begin", "protocols.p3964r.sender:Sender.revoke")
)
def test_a_block_on_the_line_is_completed_but_not_repeated_and_prepared_ones_are_dropped() -> None:
    bench = (
        InterfaceBench(LINK)
        .at(0)
        .write(ONE, "V24_1", (CHARACTER, 65))
        .write(ONE, "V24_1", (CHARACTER, 66))
        .says(STX)
        .hears(DLE)
        .says(wire(b"A"))
    )
    bench.write_begin(ONE, "V24_1").finds(deleted(2)).at(ms(550)).says(NAK).finds(deleted(1))
    assert bench.condition(ONE, "V24_1") == 0
    bench.write(ONE, "V24_1", (CHARACTER, 67)).at(ms(4549)).says(b"").at(ms(4550)).acknowledges(b"C").finds(done(3))


@pytest.mark.requirement("RHO-SER-35", by="gateway.pure.controllers.rho3.serial.driver:Driver._written")
def test_a_block_that_needed_no_repeat_needs_no_allowance() -> None:
    bench = InterfaceBench(LINK).at(0).write(ONE, "V24_1", (CHARACTER, 65)).says(STX).hears(DLE).says(wire(b"A")).write_begin(ONE, "V24_1")
    bench.write(ONE, "V24_1", (CHARACTER, 66)).hears(DLE).finds(deleted(1)).at(ms(1)).acknowledges(b"B").finds(done(2))


@pytest.mark.requirement("RHO-SER-35", by="protocols.p3964r.sender:Sender._transmit")
def test_transmission_not_begun_is_ended_even_after_the_connection() -> None:
    bench = InterfaceBench(LINK).at(0).write(ONE, "V24_1", (CHARACTER, 65)).says(STX).write_begin(ONE, "V24_1")
    bench.at(ms(100)).hears(DLE).says(NAK).finds(deleted(1))
    bench.write(ONE, "V24_1", (CHARACTER, 66)).at(ms(4099)).says(b"").at(ms(4100)).acknowledges(b"B").finds(done(2))


def test_a_revoked_job_that_gave_way_never_comes_back() -> None:
    low = Setup((v24_1(8, output_timeout_ms=-1),))
    bench = InterfaceBench(low).at(0).read(TWO, "V24_1", CHARACTER).write(ONE, "V24_1", (CHARACTER, 65)).says(STX).hears(STX).says(DLE)
    bench.write_begin(ONE, "V24_1").hears(wire(b"P")).says(DLE).finds(deleted(2), done(1, ord("P")))
    bench.at(ms(4000)).write(ONE, "V24_1", (CHARACTER, 66)).acknowledges(b"B").finds(done(3))


def test_others_outputs_by_3964r_stay() -> None:
    bench = InterfaceBench(LINK).at(0).write(TWO, "V24_1", (CHARACTER, 65)).write(ONE, "V24_1", (CHARACTER, 66)).write_begin(ONE, "V24_1")
    bench.acknowledges(b"A").finds(deleted(2), done(1)).says(b"")


# ---- 10.4 the read buffer


@pytest.mark.requirement(
    "RHO-SER-36",
    by=(
        "gateway.pure.controllers.rho3.serial.driver:Driver.read_begin",
        "gateway.pure.controllers.rho3.serial.manager:LineManager.read_begin",
    ),
)
def test_read_begin_by_3964r_clears_the_driver_and_not_the_line() -> None:
    bench = (
        InterfaceBench(Setup((v24_1(8, input_timeout_ms=100),)))
        .at(0)
        .read(ONE, "V24_1", CHARACTER)
        .at(ms(100))
        .finds(failed(1, Condition.TIME_OUT))
    )
    bench.gets(b"old").hears(STX).says(b"").read_begin(ONE, "V24_1")
    assert bench.condition(ONE, "V24_1") == 0
    bench.says(DLE).read(ONE, "V24_1", CHARACTER).hears(wire(b"N")).says(DLE).finds(done(2, ord("N")))


def test_read_begin_deletes_characters_unless_another_process_has_the_line() -> None:
    bench = InterfaceBench(LINE).at(0).hears(b"12\r").read_begin(ONE, "V24_1").read(ONE, "V24_1", INTEGER).hears(b"3\r").finds(done(1, 3))
    bench = InterfaceBench(LINE, leaves_at_once=False).at(0).write(TWO, "V24_1", (TEXT, b"x")).hears(b"12\r").read_begin(ONE, "V24_1")
    bench.says(b"x").left().read(ONE, "V24_1", INTEGER).finds(done(1), done(2, 12))


@pytest.mark.requirement("RHO-SER-37", by="gateway.pure.controllers.rho3.serial.manager:LineManager.function")
def test_without_a_unit_both_mean_the_phg() -> None:
    bench = InterfaceBench(Setup((v24_1(5),), chunk=2), "PHG", leaves_at_once=False).write(ONE, "PHG", (TEXT, b"text")).says(b"te")
    bench.write_begin(ONE, None).left().says(b"")
    assert deleted(1) in bench.told()
    bench.read(ONE, "PHG", INTEGER).hears(b"9").read_begin(ONE, None).hears(b"1\r")
    assert done(2, 91) in bench.told()  # the 9 had been taken by the READ already
    assert [bench.asked(lambda manager: manager.function(ONE, None))] == [Function.PHG]


# ---- 10.5 versions


@pytest.mark.parametrize(
    "version, files_option, text", [(3, True, "system error 83: invalid device address"), (4, False, "option not found")]
)
def test_older_versions_abort_the_program(version: int, files_option: bool, text: str) -> None:
    for asks in (InterfaceBench.read_begin, InterfaceBench.write_begin):
        bench = InterfaceBench(Setup((v24_1(5),), version=version, files_option=files_option))
        asks(bench, Process(9, stop_on_error=False), "V24_1").finds(ProgramAborted(9, Function.V24_1, None, text))


def test_version_4_does_nothing_and_version_5_needs_no_option() -> None:
    for setup, kept in ((Setup((v24_1(5),), version=4), True), (Setup((v24_1(5),), version=5, files_option=False), False)):
        bench = InterfaceBench(setup).hears(b"1\r").read_begin(ONE, "V24_1").read(ONE, "V24_1", INTEGER)
        bench.finds(*([done(1, 1)] if kept else []))
