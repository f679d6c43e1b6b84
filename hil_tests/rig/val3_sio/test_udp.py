"""VAL 3 sio, UDP: plain sockets on loopback as partners; 127.0.0.2, 127.0.0.3 are other stations on it."""

import asyncio
import socket

import pytest

from gateway.links.serial.val3_channels import SioRunner
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from hil_tests.lab.virtual.val3_loop import code, free_port, play

RUNNER = "gateway.links.serial.val3_channels:SioRunner."
UDP = "gateway.links.serial.val3_wires:UdpWire."
NAME = "Socket\\udp"


def station(host: str, port: int) -> socket.socket:
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
    sock.bind((host, port))
    sock.settimeout(3)
    return sock


@pytest.mark.requirement("VAL-SIO-20", by=(UDP + "read", RUNNER + "_make", RUNNER + "get"))
def test_0_0_0_0_hears_everybody_and_writing_is_error_122() -> None:
    port = free_port(socket.SOCK_DGRAM)
    channel = Channel(NAME, Kind.UDP, bind="127.0.0.1", port=port, timeout_s=0.3)
    with station("127.0.0.2", 0) as one, station("127.0.0.3", 0) as other:

        async def act(runner: SioRunner) -> None:
            sio, data = runner.variable(NAME), [0.0] * 4
            assert await runner.get(sio, data) == 0
            one.sendto(b"a", ("127.0.0.1", port))
            other.sendto(b"b", ("127.0.0.1", port))
            assert [await runner.read_num(sio), await runner.read_num(sio)] == [97.0, 98.0]
            assert await code(runner.set(sio, [1.0])) == 122

        play(act, channel)


@pytest.mark.requirement("VAL-SIO-21", by=(UDP + "read", UDP + "write", UDP + "__init__"))
def test_a_fixed_address_talks_with_that_station_only() -> None:
    port = free_port(socket.SOCK_DGRAM)
    channel = Channel(NAME, Kind.UDP, bind="127.0.0.1", address="127.0.0.2", port=port, timeout_s=0.5)
    with station("127.0.0.2", port) as partner, station("127.0.0.3", port) as stranger:

        async def act(runner: SioRunner) -> None:
            sio = runner.variable(NAME)
            assert await runner.write_text(sio, "hello") == "hello"
            assert await asyncio.to_thread(partner.recvfrom, 99) == (b"hello\r", ("127.0.0.1", port))
            stranger.sendto(b"no\r", ("127.0.0.1", port))
            partner.sendto(b"yes\r", ("127.0.0.1", port))
            assert await runner.read_text(sio) == "yes"
            assert runner.clear_buffer(sio) == 0 and runner.clear_buffer(sio) == -1

        play(act, channel)


@pytest.mark.requirement(
    "VAL-SIO-21", by=(UDP + "__init__", "gateway.links.serial.val3_wires:own_address", "gateway.pure.controllers.val3.sio.line:Line.hears")
)
def test_x_x_255_255_sends_and_hears_broadcasts_only() -> None:
    port = free_port(socket.SOCK_DGRAM)
    channel = Channel(NAME, Kind.UDP, address="127.255.255.255", port=port, timeout_s=0.5)
    with station("127.255.255.255", port) as listener, station("127.0.0.2", 0) as partner:

        async def act(runner: SioRunner) -> None:
            sio, data = runner.variable(NAME), [0.0] * 9
            assert await runner.set(sio, [1.0, 2.0]) == 2
            assert (await asyncio.to_thread(listener.recvfrom, 99))[0] == b"\x01\x02"
            partner.sendto(b"for one\r", ("127.0.0.1", port))
            partner.sendto(b"all\r", ("127.255.255.255", port))
            assert await runner.read_text(sio) == "all"  # neither our own echo nor what was meant for one station
            assert await runner.get(sio, data) == 0

        play(act, channel)
