"""rho 3 Releases part 1, section 7.4: READ takes what it needs, one block after the other."""

import struct

import pytest

from gateway.pure.controllers.rho3.serial.baps import BINARY, CHARACTER, INTEGER, REAL, point
from gateway.pure.controllers.rho3.serial.events import ProgramAborted
from gateway.pure.controllers.rho3.serial.setup import Condition, Function, Process, Setup
from hil_tests.lab.virtual.rho3_line import DLE, NAK, ONE, STX, TWO, InterfaceBench, done, failed, v24_1, wire
from protocols.base.machine import ms

LINK = Setup((v24_1(8),))
STOPS = Process(9)  # no ;;SER_IO_STOP -
EIGHT = b"\x01\x00\x00\x00\x02\x00\x00\x00"


def aborted(text: str) -> ProgramAborted:
    return ProgramAborted(9, Function.V24_1, Condition.PROTOCOL, text)


@pytest.mark.requirement("RHO-SER-21", by="gateway.pure.controllers.rho3.serial.driver:Driver._serve")
def test_two_reads_share_a_block_and_the_next_block_is_opened_only_then() -> None:
    bench = InterfaceBench(LINK).at(0).read(ONE, "V24_1", INTEGER).gets(EIGHT).finds(done(1, 1))
    bench.at(ms(10)).hears(STX).says(b"")  # 4 bytes of the first are still unread: no room
    bench.at(ms(20)).read(ONE, "V24_1", INTEGER).finds(done(2, 2)).says(DLE)
    bench.read(ONE, "V24_1", CHARACTER).hears(wire(b"A")).says(DLE).finds(done(3, 65))


def test_a_block_nobody_reads_is_acknowledged_and_a_second_one_is_not() -> None:
    bench = InterfaceBench(LINK).at(0).gets(b"AB").finds()
    bench.at(ms(10)).hears(STX).says(b"").at(ms(410)).says(NAK)
    bench.read(ONE, "V24_1", CHARACTER, CHARACTER).finds(done(1, 65, 66))
    bench.gets(b"C")


def test_one_read_takes_its_variables_out_of_several_blocks() -> None:
    bench = InterfaceBench(LINK).read(ONE, "V24_1", INTEGER, INTEGER).gets(EIGHT[:4]).finds()
    bench.gets(EIGHT[4:]).finds(done(1, 1, 2))


@pytest.mark.requirement(
    "RHO-SER-22",
    by=(
        "gateway.pure.controllers.rho3.serial.driver:Driver._serve",
        "gateway.pure.controllers.rho3.serial.line_interface:LineInterface.abort",
    ),
)
def test_a_block_border_inside_an_item_is_protocol_error_read() -> None:
    bench = InterfaceBench(LINK).read(STOPS, "V24_1", INTEGER, INTEGER).gets(EIGHT[:5])
    bench.finds(failed(1, Condition.PROTOCOL, 1), aborted("Protocol error READ"))


@pytest.mark.requirement("RHO-SER-23", by="gateway.pure.controllers.rho3.serial.baps:unpack")
def test_a_binary_of_02_is_protocol_error_read() -> None:
    bench = InterfaceBench(LINK).read(STOPS, "V24_1", BINARY).gets(b"\x02")
    bench.finds(failed(1, Condition.PROTOCOL), aborted("Protocol error READ"))
    assert bench.condition(STOPS, "V24_1") == Condition.PROTOCOL
    bench.read(ONE, "V24_1", BINARY, BINARY).gets(b"\x01\x00").finds(done(2, True, False))


@pytest.mark.requirement("RHO-SER-24", by="gateway.pure.controllers.rho3.serial.baps:unpack")
@pytest.mark.parametrize("spoiled", [float("nan"), float("inf")])
def test_a_real_that_is_no_number_is_protocol_error_read(spoiled: float) -> None:
    bench = InterfaceBench(LINK).read(STOPS, "V24_1", REAL).gets(struct.pack("<f", spoiled))
    bench.finds(failed(1, Condition.PROTOCOL), aborted("Protocol error READ"))
    bench.read(ONE, "V24_1", point(2)).gets(struct.pack("<2f", 1.0, spoiled)).finds(failed(2, Condition.PROTOCOL))
    bench.read(ONE, "V24_1", REAL).gets(struct.pack("<f", 0.5)).finds(done(3, 0.5))


def test_after_a_border_inside_an_item_reading_starts_with_the_next_block() -> None:
    bench = InterfaceBench(LINK).read(ONE, "V24_1", INTEGER).gets(b"\x01\x02").finds(failed(1, Condition.PROTOCOL))
    bench.read(ONE, "V24_1", INTEGER).gets(EIGHT[:4]).finds(done(2, 1))


def test_an_empty_block_is_acknowledged_and_holds_nothing_up() -> None:
    bench = InterfaceBench(LINK).read(ONE, "V24_1", CHARACTER).gets(b"").finds()
    bench.gets(b"A").finds(done(1, 65))


def test_two_processes_read_one_variable_each_by_priority() -> None:
    bench = InterfaceBench(LINK).read(TWO, "V24_1", CHARACTER, CHARACTER).read(ONE, "V24_1", CHARACTER)
    bench.gets(b"ABC").finds(done(2, 65), done(1, 66, 67))


def test_write_and_read_use_the_line_in_both_directions() -> None:
    bench = InterfaceBench(LINK).read(TWO, "V24_1", CHARACTER).write(ONE, "V24_1", (CHARACTER, 66)).acknowledges(b"B").finds(done(2))
    bench.gets(b"A").finds(done(1, 65))
