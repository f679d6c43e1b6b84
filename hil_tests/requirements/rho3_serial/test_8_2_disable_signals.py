"""rho 3 Releases part 1, sections 8.2 to 8.5: RC inputs 13.1 to 13.6 take a function off its line."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import CHARACTER, INTEGER, TEXT
from gateway.pure.controllers.rho3.serial.events import CouplingInput
from gateway.pure.controllers.rho3.serial.setup import DISABLE_BITS, INFO_TEXTS, Condition, Function, Process, Setup
from hil_tests.lab.virtual.rho3_line import DLE, NAK, ONE, STX, TWO, InterfaceBench, done, failed, on, v24_1, wire
from protocols.base.machine import ms

V1 = Function.V24_1


@pytest.mark.requirement("RHO-SER-27", by="gateway.pure.controllers.rho3.serial.line:Line.disable")
@pytest.mark.parametrize("protocol", [2, 5])
def test_0_to_1_aborts_a_read_with_minus_7(protocol: int) -> None:
    bench = InterfaceBench(Setup((v24_1(protocol),))).read(ONE, "V24_1", INTEGER).disables(V1).finds(failed(1, Condition.INTERFACE))
    assert bench.condition(ONE, "V24_1") == -7
    bench.disables(V1, False).hears(b"1\r").finds()  # only a new call goes on
    bench.read_begin(ONE, "V24_1").read(ONE, "V24_1", INTEGER).hears(b"2\r").finds(done(2, 2)).says(b"2\r" if protocol == 2 else b"")


@pytest.mark.requirement("RHO-SER-27", by="gateway.pure.controllers.rho3.serial.driver:Driver.suspend")
def test_0_to_1_aborts_a_write_by_3964r_with_minus_7() -> None:
    bench = (
        InterfaceBench(Setup((v24_1(8),))).write(ONE, "V24_1", (CHARACTER, 1)).write(TWO, "V24_1", (CHARACTER, 2)).says(STX).disables(V1)
    )
    bench.finds(failed(1, Condition.INTERFACE), failed(2, Condition.INTERFACE)).hears(DLE).says(b"")
    bench.disables(V1, False).says(b"").write(ONE, "V24_1", (CHARACTER, 3)).acknowledges(b"\x03").finds(done(3))


@pytest.mark.requirement("RHO-SER-28", by="gateway.pure.controllers.rho3.serial.manager:LineManager._refusal")
@pytest.mark.parametrize("protocol", [2, 5, 8])
def test_1_at_the_call_is_minus_2(protocol: int) -> None:
    bench = InterfaceBench(Setup((v24_1(protocol),))).disables(V1)
    bench.read(ONE, "V24_1", INTEGER).write(ONE, "V24_1", (CHARACTER, 1)).says(b"")
    bench.finds(failed(1, Condition.OCCUPIED), failed(2, Condition.OCCUPIED))
    assert bench.condition(ONE, "V24_1") == -2


@pytest.mark.requirement(
    "RHO-SER-29", by=("gateway.pure.controllers.rho3.serial.line:Line._begin", "gateway.pure.controllers.rho3.serial.driver:Driver.resume")
)
def test_1_to_0_goes_on_with_a_3964r_read_and_an_empty_fifo() -> None:
    bench = InterfaceBench(Setup((v24_1(8), on("V24_2")))).read(ONE, "V24_1", CHARACTER).disables(V1).finds()
    assert bench.condition(ONE, "V24_1") == Condition.INTERFACE
    bench.hears(b"left over\r").says(b"").disables(V1, False)
    assert bench.condition(ONE, "V24_1") == Condition.NO_ERROR
    bench.gets(b"A").finds(done(1, 65))
    bench.read(ONE, "V24_2", TEXT).disables(V1).disables(Function.V24_2).finds(failed(2, Condition.INTERFACE))
    bench.disables(Function.V24_2, False).read(TWO, "V24_2", TEXT).finds()  # no "left over": deleted when the driver came back


def test_a_read_by_3964r_that_waits_for_time_is_not_timed_while_disabled() -> None:
    bench = InterfaceBench(Setup((v24_1(8, input_timeout_ms=1000),))).at(0).read(ONE, "V24_1", CHARACTER).at(ms(900)).disables(V1)
    bench.at(ms(5000)).finds().disables(V1, False).at(ms(5999)).finds().at(ms(6000)).finds(failed(1, Condition.TIME_OUT))


def test_a_program_that_stops_on_errors_is_not_aborted_by_a_suspended_read() -> None:
    bench = InterfaceBench(Setup((v24_1(8),))).read(Process(9), "V24_1", CHARACTER).disables(V1).disables(V1, False).finds()
    bench.gets(b"A").finds(done(1, 65))


def test_calls_that_wait_for_the_line_are_aborted_too() -> None:
    bench = (
        InterfaceBench(Setup((on("V24_2"), v24_1(5))), leaves_at_once=False)
        .write(TWO, "V24_2", (TEXT, b"x"))
        .write(ONE, "V24_1", (TEXT, b"y"))
    )
    bench.disables(V1).finds(failed(2, Condition.INTERFACE)).says(b"x").left().says(b"").finds(done(1))


def test_what_was_given_to_the_port_is_gone_and_the_rest_is_not_sent() -> None:
    bench = InterfaceBench(Setup((v24_1(5),), chunk=3), leaves_at_once=False).write(ONE, "V24_1", (TEXT, b"firstly")).says(b"fir")
    bench.disables(V1).left().says(b"").finds(failed(1, Condition.INTERFACE))


def test_the_six_signals_are_rc_inputs_112_to_117() -> None:
    assert list(DISABLE_BITS.values()) == [112, 113, 114, 115, 116, 117]
    bench = InterfaceBench(Setup((v24_1(5), on("COUPLING", line="SER_2"))), rc_inputs=bytes(14) + b"\x04")
    assert bench.asked(lambda manager: manager.info()) == ["READ/WR. SER 1 disab"]
    bench.rc_byte_14(0x3F)
    assert bench.asked(lambda manager: manager.info()) == list(INFO_TEXTS.values())
    bench.rc_byte_14(0).write(ONE, "V24_1", (TEXT, b"x")).says(b"x").finds(done(1))


@pytest.mark.requirement(
    "RHO-SER-30",
    by=(
        "gateway.pure.controllers.rho3.serial.manager:LineManager.rc_inputs",
        "gateway.pure.controllers.rho3.serial.manager:LineManager.info",
    ),
)
def test_8_5_coupling_and_3964r_change_over_on_one_line() -> None:
    bench = InterfaceBench(Setup((on("COUPLING"), v24_1(8))), rc_inputs=bytes(14) + b"\x04").at(0)

    def switch(coupl_on_di: bool) -> InterfaceBench:
        """PIC program: DISCOUPL_RCI = NOT COUPL_ON_DI; DISSER_1_RCI = COUPL_ON_DI."""
        return bench.rc_byte_14(0b001 * (not coupl_on_di) | 0b100 * coupl_on_di)

    assert bench.asked(lambda manager: manager.owner("SER_1")) is Function.COUPLING
    switch(False).read(ONE, "V24_1", CHARACTER).gets(b"A").finds(done(1, 65))
    assert bench.asked(lambda manager: manager.info()) == ["Disable coupling PG "]
    assert bench.asked(lambda manager: manager.couple(b"x")) is False  # the programming unit sees a time-out
    switch(True)
    assert bench.asked(lambda manager: manager.info()) == ["READ/WR. SER 1 disab"]
    bench.hears(STX).says(b"")
    assert b"".join(event.data for event in bench.told() if isinstance(event, CouplingInput)) == STX


def test_a_block_under_way_when_the_driver_is_disabled_is_forgotten() -> None:
    bench = (
        InterfaceBench(Setup((v24_1(8),))).at(0).hears(STX).says(DLE).hears(b"half").disables(V1).hears(wire(b"half")).at(ms(500)).says(b"")
    )
    bench.disables(V1, False).hears(b"of it" + NAK).at(ms(1000)).says(b"").read(ONE, "V24_1", CHARACTER).gets(b"A").finds(done(1, 65))
