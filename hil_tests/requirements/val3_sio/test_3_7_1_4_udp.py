"""VAL 3 manual, 3.7.1.2 (IP address of a UDP socket) and 3.7.1.4."""

from dataclasses import replace

import pytest

from gateway.pure.controllers.val3.sio.channel import READ_BUFFER
from hil_tests.lab.virtual.val3_sio import WAITS, SioBench
from hil_tests.requirements.val3_sio.stations import UDP

CORE = "gateway.pure.controllers.val3.sio.core:SioCore."
HEARS = "gateway.pure.controllers.val3.sio.line:Line.hears"
ANYONE = replace(UDP, address="0.0.0.0")


@pytest.mark.requirement("VAL-SIO-20", by=(CORE + "_writable", CORE + "received", HEARS))
def test_0_0_0_0_hears_everybody_and_must_not_write() -> None:
    bench = SioBench(ANYONE)
    sio, data = bench.variable(ANYONE.name), [0.0]
    calls = [bench.get(sio, data), bench.get(sio, data)]
    bench.hears(1, b"a", sender="10.0.0.1")
    bench.hears(1, b"b", sender="10.0.0.2")
    assert [bench.outcome(call) for call in calls] == [1, 1]
    core = bench.core
    writes = [lambda: core.set(sio, [1.0], 0), lambda: core.write_text(sio, "a", 0), lambda: core.write_num(sio, 1, 0)]
    assert [bench.code(write) for write in writes] == [122] * 3
    assert bench.datagrams == []


@pytest.mark.requirement("VAL-SIO-21", by=(CORE + "received", HEARS))
def test_a_fixed_address_hears_nobody_else() -> None:
    bench = SioBench(UDP)
    call = bench.get(bench.variable(UDP.name), [0.0])
    bench.hears(1, b"no", sender="192.168.0.8")
    assert bench.outcome(call) == WAITS
    bench.hears(1, b"y", sender=UDP.address)
    assert bench.outcome(call) == 1


@pytest.mark.parametrize("address, broadcasts", [("192.168.255.255", True), ("192.168.0.255", False), ("192.168.0.7", False)])
def test_x_x_255_255_is_a_broadcast(address: str, broadcasts: bool) -> None:
    channel = replace(UDP, address=address)
    assert channel.broadcasts is broadcasts
    bench = SioBench(channel)
    call = bench.get(bench.variable(UDP.name), [0.0])
    bench.hears(1, b"y", sender="192.168.3.4")
    assert bench.outcome(call) == (1 if broadcasts else WAITS)


def test_one_instruction_writes_one_datagram() -> None:
    bench = SioBench(UDP)
    sio = bench.variable(UDP.name)
    bench.set(sio, [1.0, 2.0])
    bench.write_text(sio, "ab")
    bench.write_num(sio, 3)
    assert bench.datagrams == [b"\x01\x02", b"ab\r", b"\x03"]


def test_datagrams_are_read_as_one_stream_and_the_rest_of_one_is_kept() -> None:
    bench = SioBench(UDP)
    sio, data = bench.variable(UDP.name), [0.0] * 3
    bench.get(sio, data)
    bench.hears(1, b"a", sender=UDP.address)
    bench.hears(1, b"bcd", sender=UDP.address)
    bench.hears(1, b"e\r", sender=UDP.address)
    assert bench.outcome(bench.get(sio, data)) == 3 and data == [98.0, 99.0, 100.0]
    assert bench.outcome(bench.read_text(sio)) == "e"


def test_a_datagram_there_is_no_room_for_is_lost_whole() -> None:
    bench = SioBench(UDP)
    sio = bench.variable(UDP.name)
    data = [0.0] * (READ_BUFFER + 8)
    bench.write_num(sio, 0)
    bench.hears(1, bytes(READ_BUFFER - 3), sender=UDP.address)
    bench.hears(1, b"lost", sender=UDP.address)
    bench.hears(1, b"fit", sender=UDP.address)
    assert bench.outcome(bench.get(sio, data)) == READ_BUFFER and data[READ_BUFFER - 3 : READ_BUFFER] == [102.0, 105.0, 116.0]
