"""VAL 3 manual, 3.7.1 and 3.7.1.3: when connections are made, who shares them, when they are closed."""

from dataclasses import replace

import pytest

from hil_tests.lab.virtual.val3_sio import WAITS, Desk, error
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, SERVER, UDP, with_timeout
from protocols.base.machine import ms

S = ms(1000)
CORE = "gateway.pure.controllers.val3.sio.core:SioCore."
LINE = "gateway.pure.controllers.val3.sio.line:Line."


@pytest.mark.requirement("VAL-SIO-12", by=(LINE + "want", LINE + "begin", CORE + "end_application"))
def test_sockets_open_with_the_first_instruction_and_close_with_the_application() -> None:
    desk = Desk(CLIENT, SERVER, UDP)
    client, server, udp = (desk.variable(channel.name) for channel in (CLIENT, SERVER, UDP))
    desk.control(client, "timeout", 5)
    desk.core.status(server)
    assert (desk.numbers, desk.listening) == ([], [])
    desk.set(client, [1.0])
    assert (desk.numbers, desk.listening) == ([1], [])
    waiting = desk.get(server, [0.0])
    assert (desk.numbers, desk.listening) == ([1], [SERVER.name])
    reading = desk.read_num(udp)
    assert desk.numbers == [1, 2]
    done = desk.core.end_application()
    assert list(done) == [waiting, reading]
    desk.settle()
    assert (desk.closed, desk.listening, desk.outcome(waiting)) == ([1, 2], [], -1)
    assert desk.code(lambda: desk.core.get(client, [0.0], 0)) == 123


@pytest.mark.requirement("VAL-SIO-12", by="gateway.pure.controllers.val3.sio.core:SioCore.__init__")
def test_a_serial_line_is_always_on() -> None:
    desk = Desk(SERIAL)
    assert desk.numbers == [1]
    desk.hears(1, b"early")
    sio, data = desk.variable(SERIAL.name), [0.0] * 9
    assert desk.outcome(desk.get(sio, data)) == 5
    desk.core.end_application()
    desk.settle()
    assert desk.closed == []


@pytest.mark.requirement("VAL-SIO-13", by=(LINE + "_connection_of", LINE + "begin"))
def test_all_variables_of_a_client_share_one_connection() -> None:
    desk = Desk(CLIENT)
    one, other, data = desk.variable(CLIENT.name), desk.variable(), [0.0]
    desk.core.link(other, one)
    assert desk.outcome(desk.set(one, [1.0])) == 1 and desk.outcome(desk.set(other, [2.0])) == 1
    assert desk.numbers == [1] and desk.sent == {1: b"\x01\x02"}
    desk.hears(1, b"ab")
    assert desk.outcome(desk.get(other, data)) == 1 and data == [97.0]
    assert desk.outcome(desk.get(one, data)) == 1 and data == [98.0]


def test_a_client_connection_goes_with_the_last_variable() -> None:
    desk = Desk(CLIENT, SERIAL)
    one, other, serial = desk.variable(CLIENT.name), desk.variable(CLIENT.name), desk.variable(SERIAL.name)
    desk.set(one, [1.0])
    desk.core.delete(one)
    desk.settle()
    assert desk.closed == []
    desk.core.link(other, serial)
    desk.settle()
    assert desk.closed == [2]


@pytest.mark.requirement("VAL-SIO-14", by=(LINE + "accepted", LINE + "_give", LINE + "_connection_of"))
def test_each_variable_of_a_server_has_its_own_client_and_a_third_client_is_not_served() -> None:
    desk = Desk(SERVER)
    one, other, data = desk.variable(SERVER.name), desk.variable(SERVER.name), [0.0]
    waiting = desk.get(one, data)
    first, second, third = (desk.client_comes(SERVER.name) for _ in range(3))
    assert first is not None and second is not None and third is None
    desk.hears(first, b"1")
    desk.hears(second, b"2")
    assert desk.outcome(waiting) == 1 and data == [49.0]
    assert desk.outcome(desk.get(other, data)) == 1 and data == [50.0]
    desk.set(one, [1.0])
    desk.set(other, [2.0])
    assert desk.sent == {first: b"\x01", second: b"\x02"}


def test_two_variables_that_wait_get_the_clients_in_their_order() -> None:
    desk = Desk(SERVER)
    calls = [desk.get(desk.variable(SERVER.name), [0.0]) for _ in range(2)]
    first, second = desk.client_comes(SERVER.name), desk.client_comes(SERVER.name)
    assert first and second
    desk.hears(second, b"b")
    assert [desk.outcome(call) for call in calls] == [WAITS, 1]
    desk.hears(first, b"a")
    assert [desk.outcome(call) for call in calls] == [1, 1]


def test_a_server_serves_only_the_address_it_is_declared_for() -> None:
    desk = Desk(with_timeout(SERVER, -1))
    desk.core.change(replace(desk.core.channel(SERVER.name), address="10.0.0.5"))
    desk.get(desk.variable(SERVER.name), [0.0])
    assert desk.client_comes(SERVER.name, "10.0.0.6") is None
    assert desk.client_comes(SERVER.name, "10.0.0.5") is not None


def test_a_client_that_came_back_finds_its_place_and_what_it_sent_before_is_kept() -> None:
    desk = Desk(with_timeout(SERVER, -1))
    sio, data = desk.variable(SERVER.name), [0.0] * 8
    desk.control(sio, "clients", 1)
    desk.get(sio, data)
    first = desk.client_comes(SERVER.name)
    assert first is not None and desk.client_comes(SERVER.name) is None
    desk.hears(first, b"job")
    desk.partner_closes(first)
    second = desk.client_comes(SERVER.name)
    assert second is not None and desk.client_comes(SERVER.name) is None
    assert [desk.outcome(desk.get(sio, data)) for _ in range(2)] == [3, -1] and desk.closed == [first]
    desk.hears(second, b"new")
    assert desk.outcome(desk.get(sio, data)) == 3 and data[:3] == [110.0, 101.0, 119.0]


def test_a_client_that_left_without_a_word_is_forgotten_and_dead_ones_do_not_pile_up() -> None:
    desk = Desk(with_timeout(SERVER, -1))
    desk.get(desk.variable(SERVER.name), [0.0])
    for _ in range(5):
        number = desk.client_comes(SERVER.name)
        assert number is not None
        desk.hears(number, b"x")
        desk.partner_closes(number)
    assert desk.closed == [1, 2, 3]  # two places: two may leave their words
    silent = desk.client_comes(SERVER.name)
    assert silent is not None and desk.closed == [1, 2, 3]
    desk.partner_closes(silent)
    assert desk.closed == [1, 2, 3, silent]


@pytest.mark.requirement("VAL-SIO-15", by=(CORE + "lost", LINE + "serve", LINE + "_close"))
@pytest.mark.parametrize("writes", [False, True])
def test_a_read_or_write_error_closes_and_the_next_instruction_opens_again(writes: bool) -> None:
    desk = Desk(with_timeout(CLIENT, 1))
    sio = desk.variable(CLIENT.name)
    late = desk.get(sio, [0.0])
    desk.at(S)
    assert desk.outcome(late) == 0 and desk.closed == []  # a time-out does not close
    desk.breaks(1)
    assert desk.outcome(desk.set(sio, [1.0]) if writes else desk.get(sio, [0.0])) == -1
    assert desk.closed == [1] and desk.numbers == [1]
    assert desk.outcome(desk.set(sio, [2.0])) == 1 and desk.numbers == [1, 2]


@pytest.mark.requirement("VAL-SIO-15", by=(CORE + "delete", LINE + "release"))
def test_a_local_server_variable_takes_its_connection_with_it() -> None:
    desk = Desk(SERVER)
    local, stays = desk.variable(SERVER.name), desk.variable(SERVER.name)
    call = desk.get(local, [0.0])
    first, second = desk.client_comes(SERVER.name), desk.client_comes(SERVER.name)
    other = desk.get(stays, [0.0])
    desk.core.delete(local)
    desk.settle()
    assert desk.closed == [first] and desk.outcome(call) == error(123)
    assert desk.code(lambda: desk.core.get(local, [0.0], 0)) == 123, "it is gone"
    assert desk.outcome(other) == WAITS and desk.listening == [SERVER.name]
    desk.core.delete(stays)
    desk.settle()
    assert desk.closed == [first, second] and desk.listening == []


def test_one_error_is_told_to_every_task_that_waits_on_a_shared_connection() -> None:
    desk = Desk(CLIENT, capacity=0)
    calls = [desk.get(desk.variable(CLIENT.name), [0.0]), desk.read_text(desk.variable(CLIENT.name))]
    calls.append(desk.write_text(desk.variable(CLIENT.name), "a"))
    desk.breaks(1)
    assert [desk.outcome(call) for call in calls] == [-1, error(125), error(125)] and desk.closed == [1]


def test_a_serial_port_that_vanishes_is_an_error_once_and_comes_back_by_itself() -> None:
    desk = Desk(SERIAL)
    sio, data = desk.variable(SERIAL.name), [0.0] * 4
    desk.hears(1, b"a")
    desk.network = "refuse"
    desk.breaks(1)
    assert [desk.outcome(desk.get(sio, data)) for _ in range(3)] == [1, -1, -1]
    assert desk.outcome(desk.write_text(sio, "x")) == error(125) and desk.datagrams == []
    assert len(desk.at(S).numbers) == 5 and set(desk.numbers) == {1}
    desk.network = "open"
    desk.at(2 * S)
    call = desk.get(sio, data)
    assert len(desk.numbers) == 6 and desk.outcome(call) == WAITS
    desk.hears(1, b"b")
    assert desk.outcome(call) == 1 and data[0] == 98.0


def test_a_server_whose_port_is_taken_tries_again_while_somebody_waits() -> None:
    desk = Desk(with_timeout(SERVER, 1))
    call = desk.get(desk.variable(SERVER.name), [0.0])
    desk.core.not_listening(SERVER.name, 0)
    desk.at(S)
    assert desk.outcome(call) == -1 and desk.listening == [SERVER.name] * 2


def test_a_full_buffer_holds_a_partner_back_and_spoils_a_serial_line() -> None:
    desk = Desk(CLIENT, SERIAL)
    client, serial = desk.variable(CLIENT.name), desk.variable(SERIAL.name)
    desk.set(client, [1.0])
    room = desk.core.room(2)
    desk.hears(2, bytes(room))
    assert desk.core.room(2) == 0
    desk.hears(1, bytes(room + 1))
    desk.hears(1, b"more")
    data = [0.0] * room
    assert [desk.outcome(desk.get(serial, data)) for _ in range(2)] == [room, -1]
    assert desk.outcome(desk.get(serial, data)) == WAITS
    assert desk.outcome(desk.get(client, data)) == room and desk.core.room(2) == room
