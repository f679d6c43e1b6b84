"""rho 3 Releases part 1, sections 7.1 and 7.5: the driver task keeps its line, may not start, and forgets what an aborted program left."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import CHARACTER, INTEGER, array
from gateway.pure.controllers.rho3.serial.events import CouplingInput, DriverNotStarted
from gateway.pure.controllers.rho3.serial.setup import Condition, Function, Setup
from hil_tests.lab.virtual.rho3_line import ONE, STX, TWO, InterfaceBench, deleted, done, failed, on, v24_1, wire
from protocols.base.machine import ms

LINK = Setup((v24_1(8),))
FORTY = array(CHARACTER, 39)


@pytest.mark.requirement("RHO-SER-13", by="gateway.pure.controllers.rho3.serial.line:Line.submit")
def test_printing_on_the_line_of_a_driver_waits_for_ever() -> None:
    bench = InterfaceBench(Setup((v24_1(8), on("PRINTING")))).at(0).prints(b"listing").says(b"").at(ms(3_600_000)).says(b"").finds()
    assert bench.asked(lambda manager: manager.owner("SER_1")) is Function.V24_1
    assert bench.asked(lambda manager: manager.condition(TWO, "V24_1")) == Condition.NO_ERROR
    bench.write(ONE, "V24_1", (CHARACTER, 65)).acknowledges(b"A").finds(done(2))


@pytest.mark.requirement("RHO-SER-13", by="gateway.pure.controllers.rho3.serial.line:Line.disable")
def test_a_disabled_driver_answers_minus_2_and_leaves_the_line_to_printing() -> None:
    bench = InterfaceBench(Setup((v24_1(8), on("PRINTING")))).prints(b"list").disables(Function.V24_1).says(b"list").finds(done(1))
    bench.write(ONE, "V24_1", (CHARACTER, 65)).says(b"").finds(failed(2, Condition.OCCUPIED))
    assert bench.condition(ONE, "V24_1") == Condition.OCCUPIED


@pytest.mark.requirement("RHO-SER-14", by="gateway.pure.controllers.rho3.serial.manager:LineManager._start")
def test_no_driver_on_a_line_that_is_absent() -> None:
    bench = (
        InterfaceBench(Setup((v24_1(8, "SER_4"),), lines=("SER_1", "PHG")))
        .at(0)
        .finds(DriverNotStarted(Function.V24_1, Condition.NO_INTERFACE))
    )
    bench.write(ONE, "V24_1", (CHARACTER, 65)).says(b"").finds(failed(1, Condition.NO_INTERFACE))
    assert bench.condition(ONE, "V24_1") == Condition.NO_INTERFACE


@pytest.mark.requirement("RHO-SER-14", by="gateway.pure.controllers.rho3.serial.manager:LineManager._start")
def test_no_driver_on_the_line_of_the_coupling() -> None:
    bench = InterfaceBench(Setup((v24_1(8), on("COUPLING")))).at(0).finds(DriverNotStarted(Function.V24_1, Condition.OCCUPIED))
    bench.write(ONE, "V24_1", (CHARACTER, 65)).says(b"").finds(failed(1, Condition.OCCUPIED))
    bench.disables(Function.COUPLING).disables(Function.V24_1).disables(Function.V24_1, False)
    bench.read(ONE, "V24_1", CHARACTER).finds(failed(2, Condition.OCCUPIED))  # until the next control start
    bench.disables(Function.COUPLING, False).hears(b"?")
    assert b"".join(event.data for event in bench.told() if isinstance(event, CouplingInput)) == b"?"


@pytest.mark.requirement("RHO-SER-15", by="gateway.pure.controllers.rho3.serial.driver:Driver.drop")
def test_an_aborted_program_takes_the_rest_of_its_block_with_it() -> None:
    bench = InterfaceBench(LINK).read(ONE, "V24_1", CHARACTER).gets(bytes(range(40))).finds(done(1, 0))
    bench.ends(ONE).read(ONE, "V24_1", CHARACTER).finds()
    bench.gets(b"\x63").finds(done(2, 0x63))


def test_a_program_that_read_nothing_leaves_the_block_to_the_next() -> None:
    bench = InterfaceBench(LINK).gets(b"AB").ends(ONE).read(TWO, "V24_1", CHARACTER).finds(done(1, 65))
    bench.ends(ONE).read(TWO, "V24_1", CHARACTER).finds(done(2, 66))


def test_a_program_that_ended_well_leaves_the_rest_of_its_block() -> None:
    bench = InterfaceBench(LINK).gets(b"AB").read(ONE, "V24_1", CHARACTER).finds(done(1, 65)).ends(ONE, aborted=False)
    bench.read(TWO, "V24_1", CHARACTER).finds(done(2, 66))


def test_an_aborted_program_drops_its_calls_and_what_it_held_back() -> None:
    bench = InterfaceBench(LINK).at(0).write(ONE, "V24_1", (INTEGER, 1)).write(ONE, "V24_1", (INTEGER, 2)).read(ONE, "V24_1", CHARACTER)
    bench.write(ONE, "V24_1", (INTEGER, 3), hold=True).says(STX).ends(ONE)
    bench.finds(deleted(3), deleted(2)).write(ONE, "V24_1", (CHARACTER, 65), hold=True)
    bench.hears(b"\x10").says(b"\x15").finds(deleted(1))
    bench.at(ms(4000)).write(ONE, "V24_1", (CHARACTER, 66)).says(STX).hears(b"\x10").says(wire(b"AB"))
