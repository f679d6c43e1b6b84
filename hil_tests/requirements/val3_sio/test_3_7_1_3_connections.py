"""VAL 3 manual, 3.7.1 and 3.7.1.3: when connections are made, who shares them, when they are closed."""

from dataclasses import replace

import pytest

from hil_tests.lab.virtual.val3_sio import WAITS, SioBench, error
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, SERVER, UDP, with_timeout
from protocols.base.machine import ms

S = ms(1000)
CORE = "gateway.pure.controllers.val3.sio.core:SioCore."
LINE = "gateway.pure.controllers.val3.sio.line:Line."


@pytest.mark.requirement("VAL-SIO-12", by=(LINE + "want", LINE + "begin", CORE + "end_application"))
def test_sockets_open_with_the_first_instruction_and_close_with_the_application() -> None:
    bench = SioBench(CLIENT, SERVER, UDP)
    client, server, udp = (bench.variable(channel.name) for channel in (CLIENT, SERVER, UDP))
    bench.control(client, "timeout", 5)
    bench.core.status(server)
    assert (bench.numbers, bench.listening) == ([], [])
    bench.set(client, [1.0])
    assert (bench.numbers, bench.listening) == ([1], [])
    waiting = bench.get(server, [0.0])
    assert (bench.numbers, bench.listening) == ([1], [SERVER.name])
    reading = bench.read_num(udp)
    assert bench.numbers == [1, 2]
    done = bench.core.end_application()
    assert list(done) == [waiting, reading]
    bench.settle()
    assert (bench.closed, bench.listening, bench.outcome(waiting)) == ([1, 2], [], -1)
    assert bench.code(lambda: bench.core.get(client, [0.0], 0)) == 123


@pytest.mark.requirement("VAL-SIO-12", by="gateway.pure.controllers.val3.sio.core:SioCore.__init__")
def test_a_serial_line_is_always_on() -> None:
    bench = SioBench(SERIAL)
    assert bench.numbers == [1]
    bench.hears(1, b"early")
    sio, data = bench.variable(SERIAL.name), [0.0] * 9
    assert bench.outcome(bench.get(sio, data)) == 5
    bench.core.end_application()
    bench.settle()
    assert bench.closed == []


@pytest.mark.requirement("VAL-SIO-13", by=(LINE + "_connection_of", LINE + "begin"))
def test_all_variables_of_a_client_share_one_connection() -> None:
    bench = SioBench(CLIENT)
    one, other, data = bench.variable(CLIENT.name), bench.variable(), [0.0]
    bench.core.link(other, one)
    assert bench.outcome(bench.set(one, [1.0])) == 1 and bench.outcome(bench.set(other, [2.0])) == 1
    assert bench.numbers == [1] and bench.sent == {1: b"\x01\x02"}
    bench.hears(1, b"ab")
    assert bench.outcome(bench.get(other, data)) == 1 and data == [97.0]
    assert bench.outcome(bench.get(one, data)) == 1 and data == [98.0]


def test_a_client_connection_goes_with_the_last_variable() -> None:
    bench = SioBench(CLIENT, SERIAL)
    one, other, serial = bench.variable(CLIENT.name), bench.variable(CLIENT.name), bench.variable(SERIAL.name)
    bench.set(one, [1.0])
    bench.core.delete(one)
    bench.settle()
    assert bench.closed == []
    bench.core.link(other, serial)
    bench.settle()
    assert bench.closed == [2]


@pytest.mark.requirement("VAL-SIO-14", by=(LINE + "accepted", LINE + "_give", LINE + "_connection_of"))
def test_each_variable_of_a_server_has_its_own_client_and_a_third_client_is_not_served() -> None:
    bench = SioBench(SERVER)
    one, other, data = bench.variable(SERVER.name), bench.variable(SERVER.name), [0.0]
    waiting = bench.get(one, data)
    first, second, third = (bench.client_comes(SERVER.name) for _ in range(3))
    assert first is not None and second is not None and third is None
    bench.hears(first, b"1")
    bench.hears(second, b"2")
    assert bench.outcome(waiting) == 1 and data == [49.0]
    assert bench.outcome(bench.get(other, data)) == 1 and data == [50.0]
    bench.set(one, [1.0])
    bench.set(other, [2.0])
    assert bench.sent == {first: b"\x01", second: b"\x02"}


def test_two_variables_that_wait_get_the_clients_in_their_order() -> None:
    bench = SioBench(SERVER)
    calls = [bench.get(bench.variable(SERVER.name), [0.0]) for _ in range(2)]
    first, second = bench.client_comes(SERVER.name), bench.client_comes(SERVER.name)
    assert first and second
    bench.hears(second, b"b")
    assert [bench.outcome(call) for call in calls] == [WAITS, 1]
    bench.hears(first, b"a")
    assert [bench.outcome(call) for call in calls] == [1, 1]


def test_a_server_serves_only_the_address_it_is_declared_for() -> None:
    bench = SioBench(with_timeout(SERVER, -1))
    bench.core.change(replace(bench.core.channel(SERVER.name), address="10.0.0.5"))
    bench.get(bench.variable(SERVER.name), [0.0])
    assert bench.client_comes(SERVER.name, "10.0.0.6") is None
    assert bench.client_comes(SERVER.name, "10.0.0.5") is not None


def test_a_client_that_came_back_finds_its_place_and_what_it_sent_before_is_kept() -> None:
    bench = SioBench(with_timeout(SERVER, -1))
    sio, data = bench.variable(SERVER.name), [0.0] * 8
    bench.control(sio, "clients", 1)
    bench.get(sio, data)
    first = bench.client_comes(SERVER.name)
    assert first is not None and bench.client_comes(SERVER.name) is None
    bench.hears(first, b"job")
    bench.partner_closes(first)
    second = bench.client_comes(SERVER.name)
    assert second is not None and bench.client_comes(SERVER.name) is None
    assert [bench.outcome(bench.get(sio, data)) for _ in range(2)] == [3, -1] and bench.closed == [first]
    bench.hears(second, b"new")
    assert bench.outcome(bench.get(sio, data)) == 3 and data[:3] == [110.0, 101.0, 119.0]


def test_a_client_that_left_without_a_word_is_forgotten_and_dead_ones_do_not_pile_up() -> None:
    bench = SioBench(with_timeout(SERVER, -1))
    bench.get(bench.variable(SERVER.name), [0.0])
    for _ in range(5):
        number = bench.client_comes(SERVER.name)
        assert number is not None
        bench.hears(number, b"x")
        bench.partner_closes(number)
    assert bench.closed == [1, 2, 3]  # two places: two may leave their words
    silent = bench.client_comes(SERVER.name)
    assert silent is not None and bench.closed == [1, 2, 3]
    bench.partner_closes(silent)
    assert bench.closed == [1, 2, 3, silent]


@pytest.mark.requirement("VAL-SIO-15", by=(CORE + "lost", LINE + "serve", LINE + "_close"))
@pytest.mark.parametrize("writes", [False, True])
def test_a_read_or_write_error_closes_and_the_next_instruction_opens_again(writes: bool) -> None:
    bench = SioBench(with_timeout(CLIENT, 1))
    sio = bench.variable(CLIENT.name)
    late = bench.get(sio, [0.0])
    bench.at(S)
    assert bench.outcome(late) == 0 and bench.closed == []  # a time-out does not close
    bench.breaks(1)
    assert bench.outcome(bench.set(sio, [1.0]) if writes else bench.get(sio, [0.0])) == -1
    assert bench.closed == [1] and bench.numbers == [1]
    assert bench.outcome(bench.set(sio, [2.0])) == 1 and bench.numbers == [1, 2]


@pytest.mark.requirement("VAL-SIO-15", by=(CORE + "delete", LINE + "release"))
def test_a_local_server_variable_takes_its_connection_with_it() -> None:
    bench = SioBench(SERVER)
    local, stays = bench.variable(SERVER.name), bench.variable(SERVER.name)
    call = bench.get(local, [0.0])
    first, second = bench.client_comes(SERVER.name), bench.client_comes(SERVER.name)
    other = bench.get(stays, [0.0])
    bench.core.delete(local)
    bench.settle()
    assert bench.closed == [first] and bench.outcome(call) == error(123)
    assert bench.code(lambda: bench.core.get(local, [0.0], 0)) == 123, "it is gone"
    assert bench.outcome(other) == WAITS and bench.listening == [SERVER.name]
    bench.core.delete(stays)
    bench.settle()
    assert bench.closed == [first, second] and bench.listening == []


def test_one_error_is_reported_to_every_task_that_waits_on_a_shared_connection() -> None:
    bench = SioBench(CLIENT, capacity=0)
    calls = [bench.get(bench.variable(CLIENT.name), [0.0]), bench.read_text(bench.variable(CLIENT.name))]
    calls.append(bench.write_text(bench.variable(CLIENT.name), "a"))
    bench.breaks(1)
    assert [bench.outcome(call) for call in calls] == [-1, error(125), error(125)] and bench.closed == [1]


def test_a_serial_port_that_vanishes_is_an_error_once_and_comes_back_by_itself() -> None:
    bench = SioBench(SERIAL)
    sio, data = bench.variable(SERIAL.name), [0.0] * 4
    bench.hears(1, b"a")
    bench.network = "refuse"
    bench.breaks(1)
    assert [bench.outcome(bench.get(sio, data)) for _ in range(3)] == [1, -1, -1]
    assert bench.outcome(bench.write_text(sio, "x")) == error(125) and bench.datagrams == []
    assert len(bench.at(S).numbers) == 5 and set(bench.numbers) == {1}
    bench.network = "open"
    bench.at(2 * S)
    call = bench.get(sio, data)
    assert len(bench.numbers) == 6 and bench.outcome(call) == WAITS
    bench.hears(1, b"b")
    assert bench.outcome(call) == 1 and data[0] == 98.0


def test_a_server_whose_port_is_taken_tries_again_while_somebody_waits() -> None:
    bench = SioBench(with_timeout(SERVER, 1))
    call = bench.get(bench.variable(SERVER.name), [0.0])
    bench.core.not_listening(SERVER.name, 0)
    bench.at(S)
    assert bench.outcome(call) == -1 and bench.listening == [SERVER.name] * 2


def test_a_full_buffer_holds_a_partner_back_and_spoils_a_serial_line() -> None:
    bench = SioBench(CLIENT, SERIAL)
    client, serial = bench.variable(CLIENT.name), bench.variable(SERIAL.name)
    bench.set(client, [1.0])
    room = bench.core.room(2)
    bench.hears(2, bytes(room))
    assert bench.core.room(2) == 0
    bench.hears(1, bytes(room + 1))
    bench.hears(1, b"more")
    data = [0.0] * room
    assert [bench.outcome(bench.get(serial, data)) for _ in range(2)] == [room, -1]
    assert bench.outcome(bench.get(serial, data)) == WAITS
    assert bench.outcome(bench.get(client, data)) == room and bench.core.room(2) == room
