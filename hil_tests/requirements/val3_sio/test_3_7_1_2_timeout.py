"""VAL 3 manual, 3.7.1.2, Timeout: 0 waits for ever, > 0 waits so long, -1 does not wait."""

import pytest

from gateway.pure.controllers.val3.sio.channel import Channel
from hil_tests.lab.virtual.val3_sio import WAITS, SioBench, error
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, UDP, with_timeout
from protocols.base.machine import ms

S = ms(1000)
CORE = "gateway.pure.controllers.val3.sio.core:SioCore."


@pytest.mark.requirement("VAL-SIO-01", by=("gateway.pure.controllers.val3.sio.calls:Get.advance", CORE + "get"))
@pytest.mark.parametrize("channel", [SERIAL, CLIENT, UDP], ids=lambda channel: channel.name)
def test_0_waits_until_data_come(channel: Channel) -> None:
    bench = SioBench(with_timeout(channel, 0))
    data = [7.0, 7.0]
    assert bench.code(lambda: bench.core.get(bench.variable(channel.name), data, 0, start=2)) == 20, (
        "it does not wait for what has no place"
    )
    call = bench.get(bench.variable(channel.name), data)
    assert bench.core.deadline() is None
    assert bench.at(3600 * S).outcome(call) == WAITS
    bench.hears(bench.opened[0], b"A", sender=channel.address)
    assert bench.outcome(call) == 1 and data == [65.0, 7.0]


@pytest.mark.requirement(
    "VAL-SIO-02",
    by=("gateway.pure.controllers.val3.sio.channel:deadline_of", "gateway.pure.controllers.val3.sio.calls:Get.expire", CORE + "wake"),
)
@pytest.mark.parametrize("channel", [SERIAL, CLIENT, UDP], ids=lambda channel: channel.name)
def test_2_s_without_data_gives_0_after_2_s(channel: Channel) -> None:
    bench = SioBench(with_timeout(channel, 2))
    sio = bench.variable(channel.name)
    call = bench.get(sio, [0.0])
    assert bench.at(2 * S - 1).outcome(call) == WAITS
    assert bench.at(2 * S).outcome(call) == 0
    assert bench.closed == []  # a time-out does not close
    bench.hears(bench.opened[0], b"A", sender=channel.address)
    assert bench.outcome(bench.get(sio, [0.0])) == 1


def test_opening_and_waiting_share_one_time() -> None:
    bench = SioBench(with_timeout(CLIENT, 2), network="silent")
    call = bench.get(bench.variable(CLIENT.name), [0.0])
    bench.at(S + S // 2).answer(bench.numbers[0])
    assert bench.at(2 * S - 1).outcome(call) == WAITS
    assert bench.at(2 * S).outcome(call) == 0


@pytest.mark.requirement("VAL-SIO-03", by=("gateway.pure.controllers.val3.sio.channel:deadline_of", CORE + "wake", CORE + "received"))
def test_minus_1_takes_what_is_there_or_0_and_reports_an_error() -> None:
    bench = SioBench(with_timeout(CLIENT, -1))
    sio, data = bench.variable(CLIENT.name), [0.0, 0.0]
    assert bench.outcome(bench.get(sio, data)) == 0
    bench.hears(bench.opened[0], b"abc")
    assert bench.outcome(bench.get(sio, data)) == 2 and data == [97.0, 98.0]
    assert bench.outcome(bench.get(sio, data)) == 1 and data == [99.0, 98.0]
    assert bench.outcome(bench.get(sio, data)) == 0
    bench.partner_closes(bench.opened[0])
    assert bench.outcome(bench.get(sio, data)) == -1
    assert bench.now == 0


def test_minus_1_without_a_connection_gives_minus_1_and_the_attempt_goes_on() -> None:
    bench = SioBench(with_timeout(CLIENT, -1), network="silent")
    sio = bench.variable(CLIENT.name)
    assert bench.outcome(bench.get(sio, [0.0])) == -1 and len(bench.numbers) == 1
    assert bench.outcome(bench.set(sio, [1.0])) == -1 and len(bench.numbers) == 1
    bench.answer(bench.numbers[0])
    assert bench.outcome(bench.set(sio, [1.0])) == 1
    assert bench.outcome(bench.get(sio, [0.0])) == 0


def test_minus_1_writes_what_goes_at_once() -> None:
    bench = SioBench(with_timeout(CLIENT, -1), capacity=3)
    sio = bench.variable(CLIENT.name)
    assert bench.outcome(bench.set(sio, [1.0, 2.0, 3.0, 4.0])) == 3
    assert bench.outcome(bench.set(sio, [5.0])) == -1
    bench.capacity = 10
    bench.settle()
    assert bench.sent == {1: b"\x01\x02\x03"}  # what was not taken in time is withdrawn


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
    bench = SioBench(with_timeout(channel, 1))
    sio = bench.variable(channel.name)
    call = bench.read_text(sio)
    assert bench.at(S - 1).outcome(call) == WAITS
    assert bench.at(S).outcome(call) == error(125)
    assert bench.at(2 * S).outcome(bench.get(sio, [0.0])) == WAITS
    assert bench.outcome(call := bench.get(sio, [0.0])) == WAITS
    assert bench.at(3 * S).outcome(call) == 0


@pytest.mark.requirement(
    "VAL-SIO-10", by=("gateway.pure.controllers.val3.sio.calls:ReadNum.fail", "gateway.pure.controllers.val3.sio.calls:WriteNum.fail")
)
def test_the_other_operators_too_when_the_time_is_over() -> None:
    bench = SioBench(with_timeout(SERIAL, 1), capacity=0)
    sio = bench.variable(SERIAL.name)
    calls = [bench.read_num(sio), bench.write_num(sio, 1), bench.write_text(sio, "a")]
    assert [bench.outcome(call) for call in calls] == [WAITS] * 3
    bench.at(S)
    assert [bench.outcome(call) for call in calls] == [error(125)] * 3


def test_a_string_that_stays_incomplete_is_kept_for_the_next_reader() -> None:
    bench = SioBench(with_timeout(SERIAL, 1))
    sio, data = bench.variable(SERIAL.name), [0.0] * 4
    call = bench.read_text(sio)
    bench.hears(1, b"ab")
    assert bench.at(S).outcome(call) == error(125)
    bench.hears(1, b"c\r")
    assert bench.outcome(bench.read_text(sio)) == "abc"
    bench.hears(1, b"xy")
    assert bench.outcome(bench.get(sio, data)) == 2 and data == [120.0, 121.0, 0.0, 0.0]
