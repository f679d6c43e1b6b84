"""VAL 3 manual, 3.7.3: sioGet, sioSet, clearBuffer, sioLink, ioStatus."""

import functools
from collections.abc import Callable

import pytest

from gateway.pure.controllers.val3.sio.calls import AnyCall
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.variable import Sio
from hil_tests.lab.virtual.val3_sio import WAITS, Desk, error
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, SERVER, UDP, with_timeout
from protocols.base.machine import ms

S = ms(1000)
CALLS = "gateway.pure.controllers.val3.sio.calls:"
CORE = "gateway.pure.controllers.val3.sio.core:SioCore."
LINE = "gateway.pure.controllers.val3.sio.line:Line."


@pytest.mark.requirement(
    "VAL-SIO-04", by=(CALLS + "Get.advance", "gateway.pure.controllers.val3.sio.inbox:Inbox.take", CALLS + "Call.result")
)
def test_sio_get_ends_when_the_array_is_full_or_the_buffer_empty() -> None:
    desk = Desk(SERIAL)
    sio, data = desk.variable(SERIAL.name), [0.0] * 3
    desk.hears(1, b"\x01\x02\x03\x04\xff")
    assert desk.outcome(desk.get(sio, data)) == 3 and data == [1.0, 2.0, 3.0]
    assert desk.outcome(desk.get(sio, data)) == 2 and data == [4.0, 255.0, 3.0]
    call = desk.get(sio, data)
    assert desk.outcome(call) == WAITS
    with pytest.raises(RuntimeError, match="still waits"):
        call.result()


@pytest.mark.requirement("VAL-SIO-04", by=CORE + "get")
def test_sio_get_from_an_index_on() -> None:
    desk = Desk(SERIAL)
    sio, data = desk.variable(SERIAL.name), [0.0] * 4
    desk.hears(1, b"\x01\x02\x03\x04")
    assert desk.outcome(desk.get(sio, data, start=2)) == 2 and data == [0.0, 0.0, 1.0, 2.0]
    assert desk.code(lambda: desk.core.get(sio, data, 0, start=4)) == 20, "there is no such index"


def test_an_index_outside_the_array_is_error_20_or_21() -> None:
    desk = Desk(SERIAL)
    sio = desk.variable(SERIAL.name)
    assert desk.code(lambda: desk.core.get(sio, [0.0], 0, start=1)) == 20
    assert desk.code(lambda: desk.core.get(sio, [0.0], 0, start=-1)) == 21
    assert desk.code(lambda: desk.core.set(sio, [0.0], 0, start=1)) == 20
    assert desk.code(lambda: desk.core.set(sio, [0.0], 0, start=-1)) == 21


@pytest.mark.requirement("VAL-SIO-05", by=(CALLS + "Get.expire", LINE + "refused", LINE + "wake"))
def test_a_client_refused_by_its_server_tries_until_the_time_is_over_and_gives_minus_1() -> None:
    desk = Desk(with_timeout(CLIENT, 2), network="refuse")
    call = desk.get(desk.variable(CLIENT.name), [0.0])
    assert desk.at(2 * S - 1).outcome(call) == WAITS
    assert desk.at(2 * S).outcome(call) == -1
    assert len(desk.numbers) == 8  # at 0, 250, 500, .. 1750 ms
    assert desk.core.deadline() is None and len(desk.numbers) == 8  # nobody waits: no attempt


@pytest.mark.requirement("VAL-SIO-05", by=(CALLS + "Get.fail", CORE + "ended", LINE + "serve"))
def test_a_partner_that_closes_while_sio_get_waits_gives_minus_1_at_once() -> None:
    desk = Desk(with_timeout(CLIENT, 2))
    call = desk.get(desk.variable(CLIENT.name), [0.0])
    desk.at(S).partner_closes(1)
    assert desk.outcome(call) == -1 and desk.now == S


def test_what_came_before_the_close_is_read_first() -> None:
    desk = Desk(CLIENT)
    sio, data = desk.variable(CLIENT.name), [0.0] * 2
    desk.outcome(desk.set(sio, [1.0]))
    desk.hears(1, b"abc")
    desk.partner_closes(1)
    assert [desk.outcome(desk.get(sio, data)) for _ in range(3)] == [2, 1, -1]
    assert desk.closed == [1]


@pytest.mark.requirement("VAL-SIO-06", by=(CORE + "set", CALLS + "Set.complete", CORE + "taken"))
def test_sio_set_rounds_and_takes_modulo_256() -> None:
    desk = Desk(CLIENT)
    sio = desk.variable(CLIENT.name)
    assert desk.outcome(desk.set(sio, [256.4, -1.0, 65.4, 65.6])) == 4
    assert desk.outcome(desk.set(sio, [1.0, 2.0, 3.0], count=2)) == 2
    assert desk.outcome(desk.set(sio, [1.0, 2.0, 3.0], count=1, start=2)) == 1
    assert desk.outcome(desk.set(sio, [1.0], count=0)) == 0
    assert desk.datagrams == [b"\x00\xff\x41\x42", b"\x01\x02", b"\x03"]


@pytest.mark.requirement("VAL-SIO-06", by=(CORE + "set", CALLS + "Set.expire"))
def test_sio_set_of_more_than_there_is_and_without_a_connection_in_time() -> None:
    desk = Desk(with_timeout(CLIENT, 1), network="silent")
    sio = desk.variable(CLIENT.name)
    assert desk.code(lambda: desk.core.set(sio, [1.0, 2.0], 0, count=3)) == 20
    assert desk.code(lambda: desk.core.set(sio, [1.0, 2.0], 0, count=2, start=1)) == 20
    assert desk.code(lambda: desk.core.set(sio, [1.0, 2.0], 0, count=-1)) == 70
    assert desk.code(lambda: desk.core.set(sio, [1.0, 2.0], 0, count=0.5)) == 70
    call = desk.set(sio, [1.0])
    assert desk.at(S - 1).outcome(call) == WAITS
    assert desk.at(S).outcome(call) == -1


def test_sio_set_tells_how_much_went_when_the_partner_stops_taking_or_breaks() -> None:
    desk = Desk(with_timeout(CLIENT, 1), capacity=3)
    sio = desk.variable(CLIENT.name)
    call = desk.set(sio, [1.0] * 5)
    assert desk.at(S).outcome(call) == 3
    desk.capacity = 2
    call = desk.set(sio, [1.0] * 5)
    desk.breaks(1)
    assert desk.outcome(call) == 2 and desk.closed == [1]


USES: list[Callable[[SioCore, Sio], object]] = [
    lambda core, sio: core.get(sio, [0.0], 0),
    lambda core, sio: core.set(sio, [0.0], 0),
    lambda core, sio: core.read_text(sio, 0),
    lambda core, sio: core.read_num(sio, 0),
    lambda core, sio: core.write_text(sio, "a", 0),
    lambda core, sio: core.write_num(sio, 1, 0),
    lambda core, sio: core.clear_buffer(sio),
    lambda core, sio: core.control(sio, "timeout", 1),
    lambda core, sio: core.link(core.variable(), sio),
]


def codes(desk: Desk, sio: Sio) -> list[int]:
    """The run-time error of each use."""
    return [desk.code(functools.partial(use, desk.core, sio)) for use in USES]


@pytest.mark.requirement("VAL-SIO-11", by=(CORE + "_line", CORE + "link"))
def test_any_use_of_a_variable_without_a_link_is_error_123() -> None:
    desk = Desk(SERIAL)
    sio = desk.variable()
    assert codes(desk, sio) == [123] * 9
    gone = desk.variable(SERIAL.name)
    desk.core.delete(gone)
    assert codes(desk, gone)[:8] == [123] * 8, "its link goes with it"


@pytest.mark.requirement("VAL-SIO-11", by=(CORE + "_line", CORE + "status"))
def test_a_link_to_nothing_and_a_deleted_variable_too() -> None:
    desk = Desk(SERIAL)
    nowhere, deleted = desk.variable("Socket\\none"), desk.variable(SERIAL.name)
    desk.core.delete(deleted)
    for sio in (nowhere, deleted):
        assert codes(desk, sio)[:8] == [123] * 8
    assert desk.core.status(nowhere) == (-2, "", "Socket\\none")
    assert desk.core.status(desk.variable()) == (-1, "", "")
    assert desk.core.status(desk.variable(CLIENT.name)) == (-2, "", CLIENT.name)


def test_io_status_describes_and_sio_link_takes_the_link_over() -> None:
    desk = Desk(SERIAL, CLIENT)
    target, source = desk.variable(SERIAL.name), desk.variable(CLIENT.name)
    assert desk.core.status(target) == (0, "", SERIAL.name)
    desk.core.link(target, source)
    assert desk.core.status(target) == (0, "to the camera", CLIENT.name)
    assert desk.code(lambda: desk.core.link(target, desk.variable())) == 123
    assert desk.core.status(target)[2] == CLIENT.name


@pytest.mark.requirement("VAL-SIO-16", by=(CORE + "clear_buffer", LINE + "clear", "gateway.pure.controllers.val3.sio.inbox:Inbox.clear"))
def test_clear_buffer_of_a_serial_line_counts_what_it_drops() -> None:
    desk = Desk(SERIAL)
    sio = desk.variable(SERIAL.name)
    desk.hears(1, b"abc")
    desk.damaged(1)
    assert desk.clear(sio) == 3
    assert desk.clear(sio) == 0
    call = desk.get(sio, [0.0])
    assert desk.outcome(call) == WAITS and desk.closed == []


@pytest.mark.requirement("VAL-SIO-16", by=(CORE + "clear_buffer", LINE + "clear", LINE + "_close"))
@pytest.mark.parametrize("channel", [CLIENT, UDP], ids=lambda channel: channel.name)
def test_clear_buffer_closes_a_socket_and_gives_minus_1_the_second_time(channel: object) -> None:
    desk = Desk(CLIENT, UDP)
    sio = desk.variable(getattr(channel, "name", None))
    assert desk.clear(sio) == -1 and desk.numbers == []  # it opens nothing
    desk.set(sio, [1.0])
    desk.hears(1, b"abc", sender=UDP.address)
    assert desk.clear(sio) == 3 and desk.closed == [1]
    assert desk.clear(sio) == -1
    assert desk.outcome(desk.get(sio, [0.0])) == WAITS and desk.numbers == [1, 2]


@pytest.mark.requirement("VAL-SIO-16", by=(LINE + "clear", LINE + "shut"))
def test_clear_buffer_of_a_server_closes_the_own_client_and_with_the_last_one_the_server() -> None:
    desk = Desk(with_timeout(SERVER, -1))
    one, other = desk.variable(SERVER.name), desk.variable(SERVER.name)
    assert desk.clear(one) == -1
    desk.get(one, [0.0])
    first, second = desk.client_comes(SERVER.name), desk.client_comes(SERVER.name)
    assert desk.outcome(desk.get(one, [0.0])) == 0 and desk.outcome(desk.get(other, [0.0])) == 0
    assert desk.clear(one) == 0 and desk.closed == [first] and desk.listening == [SERVER.name]
    assert desk.clear(one) == -1
    assert desk.clear(other) == 0 and desk.closed == [first, second] and desk.listening == []
    assert desk.clear(other) == -1


def test_clear_buffer_ends_an_attempt_and_those_who_wait_on_it() -> None:
    desk = Desk(CLIENT, SERVER, network="silent")
    calls: list[AnyCall] = []
    for channel in (CLIENT, SERVER):
        sio = desk.variable(channel.name)
        calls += [desk.get(sio, [0.0]), desk.read_num(sio)]
        assert desk.clear(sio) == 0 and desk.clear(sio) == -1
    assert [desk.outcome(call) for call in calls] == [-1, error(125), -1, error(125)]
    assert desk.closed == [1] and desk.listening == []
