"""rho 3 Releases part 1, section 8.1: a function waits until the line is free; part 1, 8.1 and part 3: the user interface."""

import pytest

from gateway.pure.controllers.rho3.serial.baps import CHARACTER, INTEGER, TEXT
from gateway.pure.controllers.rho3.serial.events import FormatWanted, KeyInput, UserInterfaceResumed, UserInterfaceStopped
from gateway.pure.controllers.rho3.serial.line_interface import Job, first
from gateway.pure.controllers.rho3.serial.manager import MOST_OUTPUTS, DeviceError
from gateway.pure.controllers.rho3.serial.setup import Assignment, Condition, Function, Setup, SetupError
from hil_tests.lab.virtual.rho3_line import ONE, THREE, TWO, InterfaceBench, deleted, done, failed, on, v24_1
from protocols.base.machine import ms

SHARED = Setup((v24_1(5), on("V24_2"), on("PRINTING")), chunk=4)


@pytest.mark.requirement(
    "RHO-SER-26", by=("gateway.pure.controllers.rho3.serial.line:Line._turn", "gateway.pure.controllers.rho3.serial.line:Line._begin")
)
def test_write_waits_until_printing_is_finished() -> None:
    bench = (
        InterfaceBench(SHARED, leaves_at_once=False)
        .prints(b"a list")
        .write(ONE, "V24_1", (TEXT, b"me"))
        .says(b"a li")
        .left()
        .says(b"st")
        .finds()
    )
    bench.left().says(b"me").finds(done(1))
    bench.left().says(b"").finds(done(2))


@pytest.mark.requirement("RHO-SER-26", by="gateway.pure.controllers.rho3.serial.line_interface:first")
def test_waiting_processes_are_served_by_priority_then_in_their_order() -> None:
    jobs = [Job(order + 1, process, Function.V24_1, order) for order, process in enumerate((THREE, TWO, ONE, TWO))]
    assert first(jobs) is jobs[2] and first(jobs[:2] + jobs[3:]) is jobs[1]
    bench = InterfaceBench(SHARED, leaves_at_once=False).prints(b"p", ONE).says(b"p")
    for process, text in ((THREE, b"3"), (TWO, b"2"), (ONE, b"1"), (TWO, b"II")):
        bench.write(process, "V24_1", (TEXT, text))
    for text in (b"1", b"2", b"II", b"3"):
        bench.left().says(text)
    bench.left().finds(done(1), done(4), done(3), done(5), done(2))


def test_a_write_is_contiguous_whatever_its_length() -> None:
    bench = (
        InterfaceBench(SHARED, leaves_at_once=False)
        .write(TWO, "V24_1", (TEXT, b"long "), (TEXT, b"text"))
        .write(ONE, "V24_2", (TEXT, b"now"))
    )
    bench.says(b"long").left().says(b" tex").left().says(b"t").left().says(b"now").left().finds(done(1), done(2))


def test_a_read_has_the_line_for_exactly_one_variable() -> None:
    bench = InterfaceBench(SHARED).read(TWO, "V24_1", INTEGER, INTEGER).write(ONE, "V24_2", (TEXT, b"between")).says(b"")
    bench.hears(b"1\r").says(b"between").finds(done(2)).hears(b"2\r").finds(done(1, 1, 2))


def test_the_coupling_keeps_its_line_and_gets_what_comes() -> None:
    bench = InterfaceBench(Setup((on("COUPLING"), v24_1(5)))).at(0).write(ONE, "V24_1", (TEXT, b"x")).at(ms(60_000)).says(b"").finds()
    bench.does(lambda line, now: line.manager.couple(b"answer")).says(b"answer")


def test_an_output_too_many_is_refused_and_room_says_so_before() -> None:
    bench = InterfaceBench(SHARED, leaves_at_once=False)
    for _ in range(MOST_OUTPUTS):
        assert bench.asked(lambda manager: manager.room(ONE, "V24_1"))
        bench.write(ONE, "V24_1", (TEXT, b"x"))
    assert not bench.asked(lambda manager: manager.room(ONE, "V24_1"))
    assert bench.asked(lambda manager: manager.room(TWO, "V24_1"))
    with pytest.raises(DeviceError, match="room"):
        bench.machine.manager.write(ONE, "V24_1", ((TEXT, b"x"),), 0)
    bench.says(b"x").finds()


# ---- protocols 2, 5, 6


@pytest.mark.requirement("RHO-SER-38", by="gateway.pure.controllers.rho3.serial.line:Line._read")
@pytest.mark.parametrize("protocol, echo", [(2, b"12\r"), (5, b"")])
def test_protocol_2_echoes_what_is_read_and_5_does_not(protocol: int, echo: bytes) -> None:
    bench = InterfaceBench(Setup((v24_1(protocol),))).read(ONE, "V24_1", INTEGER).hears(b"12\r").says(echo).finds(done(1, 12))
    bench.write(ONE, "V24_1", (TEXT, b"ok")).says(b"ok").finds(done(2))


@pytest.mark.requirement(
    "RHO-SER-38", by=("gateway.pure.controllers.rho3.serial.line:Line._needs_panel", "gateway.pure.controllers.rho3.serial.line:Line._turn")
)
def test_protocol_6_stops_the_user_interface_and_resumes_it() -> None:
    stopped, resumed = UserInterfaceStopped("PHG"), UserInterfaceResumed("PHG")
    bench = InterfaceBench(Setup(()), "PHG", leaves_at_once=False).write(ONE, None, (TEXT, b"hello")).says(b"hello").finds(stopped)
    assert bench.asked(lambda manager: manager.display(b"menu")) is False
    bench.left().finds(done(1), resumed).read(ONE, "PHG", CHARACTER, CHARACTER).hears(b"A").finds(stopped)
    bench.hears(b"B").finds(done(2, 65, 66), resumed)
    assert bench.asked(lambda manager: manager.display(b"menu")) is True


def test_keys_belong_to_the_user_interface_while_no_program_reads() -> None:
    bench = InterfaceBench(Setup(()), "PHG").hears(b"K")
    bench.finds(KeyInput("PHG", b"K")).does(lambda line, now: line.manager.display(b"menu")).says(b"menu")


def test_a_v24_unit_with_protocol_6_does_the_same_on_its_line() -> None:
    bench = InterfaceBench(Setup((v24_1(6),))).write(ONE, "V24_1", (TEXT, b"x")).says(b"x")
    bench.finds(UserInterfaceStopped("SER_1"), done(1), UserInterfaceResumed("SER_1"))


def test_without_a_phg_its_port_is_like_any_other() -> None:
    bench = InterfaceBench(Setup((v24_1(5, "PHG"),), panel=None), "PHG").hears(b"7\r").read(ONE, "V24_1", INTEGER).finds(done(1, 7))
    bench.write(ONE, None, (TEXT, b"x")).says(b"").finds(failed(2, Condition.NO_INTERFACE))


# ---- what the assignment may be


def test_a_change_of_the_rate_opens_the_port_anew_before_anything_is_said() -> None:
    fast = Assignment(Function.V24_2, "SER_1", 5, "19200 8E1")
    bench = InterfaceBench(Setup((v24_1(5), fast))).hears(b"noise").write(ONE, "V24_2", (TEXT, b"x"))
    bench.says(b"").finds(FormatWanted("SER_1", "19200 8E1")).loses_the_port().finds()
    bench.does(lambda line, now: line.manager.lines["SER_1"].reopened(now))
    bench.says(b"x").finds(done(1))
    bench.read(ONE, "V24_2", CHARACTER).finds().hears(b"y").finds(done(2, ord("y")))


@pytest.mark.parametrize(
    "assignments, words",
    [
        ((v24_1(1),), "V24_1: protocol 1"),
        ((v24_1(5), v24_1(8, "SER_2")), "SER_1 and to SER_2"),
        ((on("PHG", 5),), "PHG: protocol 5"),
        ((on("PRINTING", 8),), "protocol 8 is for"),
    ],
)
def test_an_assignment_no_control_could_have_is_refused(assignments: tuple[Assignment, ...], words: str) -> None:
    with pytest.raises(SetupError, match=words):
        Setup(assignments)


def test_characters_nobody_reads_are_kept_up_to_the_limit_then_an_overrun() -> None:
    bench = InterfaceBench(Setup((v24_1(5),), fifo=2)).hears(b"ABCD").read(ONE, "V24_1", CHARACTER, CHARACTER).finds(done(1, 65, 66))
    bench.read(ONE, "V24_1", CHARACTER).finds(failed(2, Condition.OVERRUN)).hears(b"E").read(ONE, "V24_1", CHARACTER).finds(done(3, 69))


def test_a_thousand_variables_in_one_burst() -> None:
    bench = InterfaceBench(Setup((v24_1(5),), fifo=2000)).read(ONE, "V24_1", *(CHARACTER,) * 1000).hears(b"x" * 1000)
    bench.finds(done(1, *(ord("x"),) * 1000))


def test_the_end_of_a_program_deletes_its_outputs_only_if_it_was_aborted() -> None:
    def half_done() -> InterfaceBench:
        return (
            InterfaceBench(SHARED, leaves_at_once=False)
            .write(ONE, "V24_1", (TEXT, b"first"))
            .write(TWO, "V24_1", (TEXT, b"other"))
            .says(b"firs")
        )

    half_done().ends(ONE, aborted=False).left().says(b"t").left().says(b"othe").finds(done(1))
    half_done().ends(ONE, aborted=True).says(b"othe").finds(deleted(1))


def test_units_by_name() -> None:
    bench = InterfaceBench(SHARED)
    bench.does(lambda line, now: line.manager.assign(ONE, "barcodereader", "V24_1. "))
    bench.write(ONE, "barcodereader", (TEXT, b"send")).says(b"send").finds(done(1))
    assert bench.machine.manager.function(ONE, "v24_2") is Function.V24_2
    with pytest.raises(DeviceError, match="barcodereader"):
        bench.machine.manager.function(TWO, "barcodereader")
