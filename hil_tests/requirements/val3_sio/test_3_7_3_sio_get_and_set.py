"""VAL 3 manual, 3.7.3: sioGet, sioSet, clearBuffer, sioLink, ioStatus."""

import functools
from collections.abc import Callable

import pytest

from gateway.pure.controllers.val3.sio.calls import AnyCall
from gateway.pure.controllers.val3.sio.control import Code
from gateway.pure.controllers.val3.sio.core import SioCore
from gateway.pure.controllers.val3.sio.variable import Sio
from hil_tests.lab.virtual.val3_sio import WAITS, SioBench, error
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
    bench = SioBench(SERIAL)
    sio, data = bench.variable(SERIAL.name), [0.0] * 3
    bench.hears(1, b"\x01\x02\x03\x04\xff")
    assert bench.outcome(bench.get(sio, data)) == 3 and data == [1.0, 2.0, 3.0]
    assert bench.outcome(bench.get(sio, data)) == 2 and data == [4.0, 255.0, 3.0]
    call = bench.get(sio, data)
    assert bench.outcome(call) == WAITS
    with pytest.raises(RuntimeError, match="still waits"):
        call.result()


@pytest.mark.requirement("VAL-SIO-04", by=CORE + "get")
def test_sio_get_from_an_index_on() -> None:
    bench = SioBench(SERIAL)
    sio, data = bench.variable(SERIAL.name), [0.0] * 4
    bench.hears(1, b"\x01\x02\x03\x04")
    assert bench.outcome(bench.get(sio, data, start=2)) == 2 and data == [0.0, 0.0, 1.0, 2.0]
    assert bench.code(lambda: bench.core.get(sio, data, 0, start=4)) == 20, "there is no such index"


def test_an_index_outside_the_array_is_error_20_or_21() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    assert bench.code(lambda: bench.core.get(sio, [0.0], 0, start=1)) == 20
    assert bench.code(lambda: bench.core.get(sio, [0.0], 0, start=-1)) == 21
    assert bench.code(lambda: bench.core.set(sio, [0.0], 0, start=1)) == 20
    assert bench.code(lambda: bench.core.set(sio, [0.0], 0, start=-1)) == 21


@pytest.mark.requirement("VAL-SIO-05", by=(CALLS + "Get.expire", LINE + "refused", LINE + "wake"))
def test_a_client_refused_by_its_server_tries_until_the_time_is_over_and_gives_minus_1() -> None:
    bench = SioBench(with_timeout(CLIENT, 2), network="refuse")
    call = bench.get(bench.variable(CLIENT.name), [0.0])
    assert bench.at(2 * S - 1).outcome(call) == WAITS
    assert bench.at(2 * S).outcome(call) == -1
    assert len(bench.numbers) == 8  # at 0, 250, 500, .. 1750 ms
    assert bench.core.deadline() is None and len(bench.numbers) == 8  # nobody waits: no attempt


@pytest.mark.requirement("VAL-SIO-05", by=(CALLS + "Get.fail", CORE + "ended", LINE + "serve"))
def test_a_partner_that_closes_while_sio_get_waits_gives_minus_1_at_once() -> None:
    bench = SioBench(with_timeout(CLIENT, 2))
    call = bench.get(bench.variable(CLIENT.name), [0.0])
    bench.at(S).partner_closes(1)
    assert bench.outcome(call) == -1 and bench.now == S


def test_what_came_before_the_close_is_read_first() -> None:
    bench = SioBench(CLIENT)
    sio, data = bench.variable(CLIENT.name), [0.0] * 2
    bench.outcome(bench.set(sio, [1.0]))
    bench.hears(1, b"abc")
    bench.partner_closes(1)
    assert [bench.outcome(bench.get(sio, data)) for _ in range(3)] == [2, 1, -1]
    assert bench.closed == [1]


@pytest.mark.requirement("VAL-SIO-06", by=(CORE + "set", CALLS + "Set.complete", CORE + "taken"))
def test_sio_set_rounds_and_takes_modulo_256() -> None:
    bench = SioBench(CLIENT)
    sio = bench.variable(CLIENT.name)
    assert bench.outcome(bench.set(sio, [256.4, -1.0, 65.4, 65.6])) == 4
    assert bench.outcome(bench.set(sio, [1.0, 2.0, 3.0], count=2)) == 2
    assert bench.outcome(bench.set(sio, [1.0, 2.0, 3.0], count=1, start=2)) == 1
    assert bench.outcome(bench.set(sio, [1.0], count=0)) == 0
    assert bench.datagrams == [b"\x00\xff\x41\x42", b"\x01\x02", b"\x03"]


@pytest.mark.requirement("VAL-SIO-06", by=(CORE + "set", CALLS + "Set.expire"))
def test_sio_set_of_more_than_there_is_and_without_a_connection_in_time() -> None:
    bench = SioBench(with_timeout(CLIENT, 1), network="silent")
    sio = bench.variable(CLIENT.name)
    assert bench.code(lambda: bench.core.set(sio, [1.0, 2.0], 0, count=3)) == 20
    assert bench.code(lambda: bench.core.set(sio, [1.0, 2.0], 0, count=2, start=1)) == 20
    assert bench.code(lambda: bench.core.set(sio, [1.0, 2.0], 0, count=-1)) == 70
    assert bench.code(lambda: bench.core.set(sio, [1.0, 2.0], 0, count=0.5)) == 70
    call = bench.set(sio, [1.0])
    assert bench.at(S - 1).outcome(call) == WAITS
    assert bench.at(S).outcome(call) == -1


def test_sio_set_reports_how_much_went_when_the_partner_stops_taking_or_breaks() -> None:
    bench = SioBench(with_timeout(CLIENT, 1), capacity=3)
    sio = bench.variable(CLIENT.name)
    call = bench.set(sio, [1.0] * 5)
    assert bench.at(S).outcome(call) == 3
    bench.capacity = 2
    call = bench.set(sio, [1.0] * 5)
    bench.breaks(1)
    assert bench.outcome(call) == 2 and bench.closed == [1]


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


def codes(bench: SioBench, sio: Sio) -> list[int]:
    """The run-time error of each use."""
    return [bench.code(functools.partial(use, bench.core, sio)) for use in USES]


@pytest.mark.requirement("VAL-SIO-11", by=(CORE + "_line", CORE + "link"))
def test_any_use_of_a_variable_without_a_link_is_error_123() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable()
    assert codes(bench, sio) == [123] * 9
    gone = bench.variable(SERIAL.name)
    bench.core.delete(gone)
    assert codes(bench, gone)[:8] == [123] * 8, "its link goes with it"


@pytest.mark.requirement("VAL-SIO-11", by=(CORE + "_line", CORE + "status"))
def test_a_link_to_nothing_and_a_deleted_variable_too() -> None:
    bench = SioBench(SERIAL)
    nowhere, deleted = bench.variable("Socket\\none"), bench.variable(SERIAL.name)
    bench.core.delete(deleted)
    for sio in (nowhere, deleted):
        assert codes(bench, sio)[:8] == [123] * 8
    assert bench.core.status(nowhere) == (-2, "", "Socket\\none")
    assert bench.core.status(bench.variable()) == (-1, "", "")
    assert bench.core.status(bench.variable(CLIENT.name)) == (-2, "", CLIENT.name)


def test_io_status_describes_and_sio_link_takes_the_link_over() -> None:
    bench = SioBench(SERIAL, CLIENT)
    target, source = bench.variable(SERIAL.name), bench.variable(CLIENT.name)
    assert bench.core.status(target) == (0, "", SERIAL.name)
    bench.core.link(target, source)
    assert bench.core.status(target) == (0, "to the camera", CLIENT.name)
    assert bench.code(lambda: bench.core.link(target, bench.variable())) == 123
    assert bench.core.status(target)[2] == CLIENT.name


@pytest.mark.requirement("VAL-SIO-16", by=(CORE + "clear_buffer", LINE + "clear", "gateway.pure.controllers.val3.sio.inbox:Inbox.clear"))
def test_clear_buffer_of_a_serial_line_counts_what_it_drops() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    bench.hears(1, b"abc")
    bench.damaged(1)
    assert bench.clear(sio) == 3
    assert bench.clear(sio) == 0
    call = bench.get(sio, [0.0])
    assert bench.outcome(call) == WAITS and bench.closed == []


@pytest.mark.requirement("VAL-SIO-16", by=(CORE + "clear_buffer", LINE + "clear", LINE + "_close"))
@pytest.mark.parametrize("channel", [CLIENT, UDP], ids=lambda channel: channel.name)
def test_clear_buffer_closes_a_socket_and_gives_minus_1_the_second_time(channel: object) -> None:
    bench = SioBench(CLIENT, UDP)
    sio = bench.variable(getattr(channel, "name", None))
    assert bench.clear(sio) == -1 and bench.numbers == []  # it opens nothing
    bench.set(sio, [1.0])
    bench.hears(1, b"abc", sender=UDP.address)
    assert bench.clear(sio) == 3 and bench.closed == [1]
    assert bench.clear(sio) == -1
    assert bench.outcome(bench.get(sio, [0.0])) == WAITS and bench.numbers == [1, 2]


@pytest.mark.requirement("VAL-SIO-16", by=LINE + "clear")
def test_clear_buffer_of_a_server_closes_the_own_client() -> None:
    bench = SioBench(with_timeout(SERVER, -1))
    one, other = bench.variable(SERVER.name), bench.variable(SERVER.name)
    assert bench.clear(one) == -1
    bench.get(one, [0.0])
    first, second = bench.client_comes(SERVER.name), bench.client_comes(SERVER.name)
    assert bench.outcome(bench.get(one, [0.0])) == 0 and bench.outcome(bench.get(other, [0.0])) == 0
    assert bench.clear(one) == 0 and bench.closed == [first] and bench.listening == [SERVER.name]
    assert bench.clear(one) == -1
    assert bench.clear(other) == 0 and bench.closed == [first, second]
    assert bench.clear(other) == -1 and bench.listening == [SERVER.name], "the next client is heard"


@pytest.mark.requirement("VAL-SIO-16", by=(LINE + "clear", LINE + "change"))
def test_clear_buffer_after_each_error_keeps_no_client_away() -> None:
    """An application with time-out -1 calls it each time there is no client yet (AX-189); so does one that is a client."""
    bench = SioBench(with_timeout(SERVER, -1))
    sio = bench.variable(SERVER.name)
    for _ in range(3):
        assert bench.outcome(bench.set(sio, [1.0])) == -1 and bench.clear(sio) == -1
    bench.client_comes(SERVER.name)
    assert bench.outcome(bench.set(sio, [1.0])) == 1 and bench.listening == [SERVER.name]
    assert bench.control(sio, "clients", 2.0) == Code.BUSY
    assert bench.clear(sio) == 0 and bench.control(sio, "clients", 2.0) == Code.CHANGED
    bench.client_comes(SERVER.name)
    assert bench.control(sio, "port", 4100.0) == Code.CHANGED, "a client for whom nobody waits is turned away"
    bench.settle()
    assert bench.listening == [] and len(bench.closed) == 2
    bench.get(sio, [0.0])
    assert bench.listening == [SERVER.name]
    there = SioBench(with_timeout(CLIENT, -1), network="silent")
    asks = there.variable(CLIENT.name)
    for _ in range(3):
        assert there.outcome(there.set(asks, [1.0])) == -1 and there.clear(asks) == -1
    assert there.numbers == [1] and there.closed == [], "one attempt"
    assert there.control(asks, "port", 4100.0) == Code.CHANGED
    there.settle()
    assert there.closed == [1]


def test_clear_buffer_ends_an_attempt_and_those_who_wait_on_it() -> None:
    bench = SioBench(CLIENT, SERVER, network="silent")
    calls: list[AnyCall] = []
    for channel in (CLIENT, SERVER):
        sio = bench.variable(channel.name)
        calls += [bench.get(sio, [0.0]), bench.read_num(sio)]
        assert bench.clear(sio) == 0 and bench.clear(sio) == -1
    assert [bench.outcome(call) for call in calls] == [-1, error(125), -1, error(125)]
    assert bench.closed == [1] and bench.listening == [SERVER.name]
