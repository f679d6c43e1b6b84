"""VAL 3 manual, 3.7.1.2, Timeout: 0 waits for ever, > 0 waits so long, -1 does not wait."""

import pytest

from gateway.pure.controllers.val3.sio.channel import Channel
from hil_tests.lab.virtual.val3_sio import WAITS, Desk, error
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, UDP, with_timeout
from protocols.base.machine import ms

S = ms(1000)
CORE = "gateway.pure.controllers.val3.sio.core:SioCore."


@pytest.mark.requirement("VAL-SIO-01", by=("gateway.pure.controllers.val3.sio.calls:Get.advance", CORE + "get"))
@pytest.mark.parametrize("channel", [SERIAL, CLIENT, UDP], ids=lambda channel: channel.name)
def test_0_waits_until_data_come(channel: Channel) -> None:
    desk = Desk(with_timeout(channel, 0))
    data = [7.0, 7.0]
    assert desk.code(lambda: desk.core.get(desk.variable(channel.name), data, 0, start=2)) == 20, "it does not wait for what has no place"
    call = desk.get(desk.variable(channel.name), data)
    assert desk.core.deadline() is None
    assert desk.at(3600 * S).outcome(call) == WAITS
    desk.hears(desk.opened[0], b"A", sender=channel.address)
    assert desk.outcome(call) == 1 and data == [65.0, 7.0]


@pytest.mark.requirement(
    "VAL-SIO-02",
    by=("gateway.pure.controllers.val3.sio.channel:deadline_of", "gateway.pure.controllers.val3.sio.calls:Get.expire", CORE + "wake"),
)
@pytest.mark.parametrize("channel", [SERIAL, CLIENT, UDP], ids=lambda channel: channel.name)
def test_2_s_without_data_gives_0_after_2_s(channel: Channel) -> None:
    desk = Desk(with_timeout(channel, 2))
    sio = desk.variable(channel.name)
    call = desk.get(sio, [0.0])
    assert desk.at(2 * S - 1).outcome(call) == WAITS
    assert desk.at(2 * S).outcome(call) == 0
    assert desk.closed == []  # a time-out does not close
    desk.hears(desk.opened[0], b"A", sender=channel.address)
    assert desk.outcome(desk.get(sio, [0.0])) == 1


def test_opening_and_waiting_share_one_time() -> None:
    desk = Desk(with_timeout(CLIENT, 2), network="silent")
    call = desk.get(desk.variable(CLIENT.name), [0.0])
    desk.at(S + S // 2).answer(desk.numbers[0])
    assert desk.at(2 * S - 1).outcome(call) == WAITS
    assert desk.at(2 * S).outcome(call) == 0


@pytest.mark.requirement("VAL-SIO-03", by=("gateway.pure.controllers.val3.sio.channel:deadline_of", CORE + "wake", CORE + "received"))
def test_minus_1_takes_what_is_there_or_0_and_tells_an_error() -> None:
    desk = Desk(with_timeout(CLIENT, -1))
    sio, data = desk.variable(CLIENT.name), [0.0, 0.0]
    assert desk.outcome(desk.get(sio, data)) == 0
    desk.hears(desk.opened[0], b"abc")
    assert desk.outcome(desk.get(sio, data)) == 2 and data == [97.0, 98.0]
    assert desk.outcome(desk.get(sio, data)) == 1 and data == [99.0, 98.0]
    assert desk.outcome(desk.get(sio, data)) == 0
    desk.partner_closes(desk.opened[0])
    assert desk.outcome(desk.get(sio, data)) == -1
    assert desk.now == 0


def test_minus_1_without_a_connection_gives_minus_1_and_the_attempt_goes_on() -> None:
    desk = Desk(with_timeout(CLIENT, -1), network="silent")
    sio = desk.variable(CLIENT.name)
    assert desk.outcome(desk.get(sio, [0.0])) == -1 and len(desk.numbers) == 1
    assert desk.outcome(desk.set(sio, [1.0])) == -1 and len(desk.numbers) == 1
    desk.answer(desk.numbers[0])
    assert desk.outcome(desk.set(sio, [1.0])) == 1
    assert desk.outcome(desk.get(sio, [0.0])) == 0


def test_minus_1_writes_what_goes_at_once() -> None:
    desk = Desk(with_timeout(CLIENT, -1), capacity=3)
    sio = desk.variable(CLIENT.name)
    assert desk.outcome(desk.set(sio, [1.0, 2.0, 3.0, 4.0])) == 3
    assert desk.outcome(desk.set(sio, [5.0])) == -1
    desk.capacity = 10
    desk.settle()
    assert desk.sent == {1: b"\x01\x02\x03"}  # what was not taken in time is withdrawn


@pytest.mark.requirement(
    "VAL-SIO-10",
    by=(
        "gateway.pure.controllers.val3.sio.calls:ReadText.expire",
        "gateway.pure.controllers.val3.sio.calls:ReadText.fail",
        CORE + "read_text",
    ),
)
@pytest.mark.parametrize("channel", [SERIAL, CLIENT], ids=lambda channel: channel.name)
def test_the_operator_string_ends_in_a_run_time_error_where_sio_get_gives_0(channel: Channel) -> None:
    desk = Desk(with_timeout(channel, 1))
    sio = desk.variable(channel.name)
    call = desk.read_text(sio)
    assert desk.at(S - 1).outcome(call) == WAITS
    assert desk.at(S).outcome(call) == error(125)
    assert desk.at(2 * S).outcome(desk.get(sio, [0.0])) == WAITS
    assert desk.outcome(call := desk.get(sio, [0.0])) == WAITS
    assert desk.at(3 * S).outcome(call) == 0


@pytest.mark.requirement(
    "VAL-SIO-10", by=("gateway.pure.controllers.val3.sio.calls:ReadNum.fail", "gateway.pure.controllers.val3.sio.calls:WriteNum.fail")
)
def test_the_other_operators_too_when_the_time_is_over() -> None:
    desk = Desk(with_timeout(SERIAL, 1), capacity=0)
    sio = desk.variable(SERIAL.name)
    calls = [desk.read_num(sio), desk.write_num(sio, 1), desk.write_text(sio, "a")]
    assert [desk.outcome(call) for call in calls] == [WAITS] * 3
    desk.at(S)
    assert [desk.outcome(call) for call in calls] == [error(125)] * 3


def test_a_string_that_stays_incomplete_is_kept_for_the_next_reader() -> None:
    desk = Desk(with_timeout(SERIAL, 1))
    sio, data = desk.variable(SERIAL.name), [0.0] * 4
    call = desk.read_text(sio)
    desk.hears(1, b"ab")
    assert desk.at(S).outcome(call) == error(125)
    desk.hears(1, b"c\r")
    assert desk.outcome(desk.read_text(sio)) == "abc"
    desk.hears(1, b"xy")
    assert desk.outcome(desk.get(sio, data)) == 2 and data == [120.0, 121.0, 0.0, 0.0]
