"""VAL 3 sio, TCP client: against a plain socket on loopback."""

import asyncio
import os
import socket
import time

import pytest

from gateway.links.serial.val3_channels import SioRunner
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.variable import Sio
from hil_tests.lab.virtual.val3_loop import code, free_port, listener, play

RUNNER = "gateway.links.serial.val3_channels:SioRunner."
TCP = "gateway.links.serial.val3_wires:TcpWire."
NAME = "Socket\\partner"


def client(port: int, timeout_s: float = 0.0) -> Channel:
    return Channel(NAME, Kind.TCP_CLIENT, address="127.0.0.1", port=port, timeout_s=timeout_s)


@pytest.mark.requirement("VAL-SIO-05", by=(RUNNER + "get", RUNNER + "_arm"))
def test_a_closed_port_gives_minus_1_after_the_time_out() -> None:
    async def act(runner: SioRunner) -> None:
        started = time.monotonic()
        assert await runner.get(runner.variable(NAME), [0.0]) == -1
        assert 0.35 <= time.monotonic() - started < 2

    play(act, client(free_port(), 0.4))


@pytest.mark.requirement("VAL-SIO-05", by=(RUNNER + "_open", "gateway.pure.controllers.val3.sio.line:Line.refused"))
def test_a_server_that_comes_up_in_time_is_found() -> None:
    port = free_port()

    async def act(runner: SioRunner) -> None:
        waiting = asyncio.get_running_loop().create_task(runner.set(runner.variable(NAME), [1.0]))
        await asyncio.sleep(0.1)
        with listener(port):
            assert await asyncio.wait_for(waiting, 4) == 1

    play(act, client(port, 3))


@pytest.mark.requirement("VAL-SIO-05", by=(RUNNER + "_read", TCP + "read"))
def test_a_partner_that_closes_while_we_wait_gives_minus_1_at_once() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            waiting = loop.create_task(runner.get(runner.variable(NAME), [0.0]))
            partner, _ = await loop.sock_accept(server)
            partner.close()
            started = time.monotonic()
            assert await asyncio.wait_for(waiting, 4) == -1
            assert time.monotonic() - started < 1

        play(act, client(server.getsockname()[1], 6))


@pytest.mark.requirement("VAL-SIO-12", "VAL-SIO-13", by=(RUNNER + "_carry_out", RUNNER + "set", TCP + "write"))
def test_the_first_use_opens_and_two_variables_share_it() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            one, other = runner.variable(NAME), runner.variable()
            runner.link(other, one)
            assert runner.status(other) == (0, "", NAME)
            await asyncio.sleep(0.05)
            with pytest.raises(BlockingIOError):
                server.accept()
            assert await asyncio.wait_for(runner.set(one, [97.0]), 3) == 1
            assert await runner.set(other, [98.0]) == 1
            partner, _ = await loop.sock_accept(server)
            with pytest.raises(BlockingIOError):
                server.accept()
            heard = b""
            while len(heard) < 2:
                heard += await asyncio.wait_for(loop.sock_recv(partner, 9), 3)
            assert heard == b"ab"
            await loop.sock_sendall(partner, b"x\r")
            assert await runner.read_text(other) == "x"
            runner.end_application()
            assert await asyncio.wait_for(loop.sock_recv(partner, 9), 3) == b""
            partner.close()

        play(act, client(server.getsockname()[1]))


@pytest.mark.requirement("VAL-SIO-07", "VAL-SIO-08", "VAL-SIO-09", by=(RUNNER + "write_text", RUNNER + "read_text", RUNNER + "read_num"))
def test_strings_and_numbers_go_both_ways() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            sio = runner.variable(NAME)
            assert await runner.write_text(sio, "aé") == "aé"
            partner, _ = await loop.sock_accept(server)
            assert await runner.write_num(sio, 321.4) == 65.0
            heard = b""
            while len(heard) < 5:
                heard += await asyncio.wait_for(loop.sock_recv(partner, 9), 3)
            assert heard == "aé\rA".encode()
            for byte in "€uro\r".encode():
                await loop.sock_sendall(partner, bytes((byte,)))
            await loop.sock_sendall(partner, b"\xfe")
            assert await asyncio.wait_for(runner.read_text(sio), 3) == "€uro"
            assert await asyncio.wait_for(runner.read_num(sio), 3) == 254.0
            partner.close()

        play(act, client(server.getsockname()[1]))


@pytest.mark.requirement("VAL-SIO-03", by=(RUNNER + "_run", RUNNER + "_pump_channel"))
def test_minus_1_connects_behind_the_program_and_takes_what_is_in_the_kernel() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            sio, data = runner.variable(NAME), [0.0] * 9
            assert await runner.get(sio, data) == -1
            partner, _ = await asyncio.get_running_loop().sock_accept(server)
            while await runner.get(sio, data) == -1:
                await asyncio.sleep(0.01)
            assert await runner.get(sio, data) == 0
            partner.sendall(b"abc")
            time.sleep(0.05)  # the loop does not run: nobody but the instruction itself can fetch them
            assert await runner.get(sio, data) == 3 and data[:3] == [97.0, 98.0, 99.0]
            partner.close()

        play(act, client(server.getsockname()[1], -1))


@pytest.mark.requirement("VAL-SIO-19", by=(TCP + "configure", RUNNER + "control"))
def test_nagle_false_sets_tcp_nodelay() -> None:
    def nodelay(runner: SioRunner, sio: Sio) -> list[int]:
        found = []
        for descriptor in runner.descriptors(sio):
            with socket.socket(fileno=os.dup(descriptor)) as twin:
                found.append(twin.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
        return found

    with listener() as server:

        async def act(runner: SioRunner) -> None:
            sio = runner.variable(NAME)
            assert await runner.set(sio, [1.0]) == 1
            assert nodelay(runner, sio) == [0]
            assert await runner.control(sio, "nagle", False) == 0
            assert nodelay(runner, sio) == [1]
            assert runner.clear_buffer(sio) == 0 and runner.clear_buffer(sio) == -1
            assert await runner.set(sio, [1.0]) == 1
            assert nodelay(runner, sio) == [1]  # a new connection too

        play(act, client(server.getsockname()[1]))


def test_a_partner_that_reads_nothing_holds_the_writer_back_until_the_time_is_over() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            sio, counts = runner.variable(NAME), list[int]()
            counts.append(await runner.set(sio, [85.0] * 9999))
            partner, _ = await loop.sock_accept(server)
            while counts[-1] == 9999:
                counts.append(await runner.set(sio, [85.0] * 9999))
            assert -1 <= counts[-1] < 9999
            await asyncio.sleep(0)
            heard, wanted = 0, sum(max(count, 0) for count in counts)
            while heard < wanted:
                heard += len(await asyncio.wait_for(loop.sock_recv(partner, 1 << 20), 3))
            assert heard == wanted  # what sioSet told went, and nothing else
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(loop.sock_recv(partner, 9), 0.05)
            partner.close()

        play(act, client(server.getsockname()[1], 0.2))


def test_a_program_that_reads_nothing_holds_the_partner_back_and_loses_nothing() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            sio, data = runner.variable(NAME), [0.0] * 9999
            assert await runner.set(sio, [1.0]) == 1
            partner, _ = await loop.sock_accept(server)
            stream = bytes(range(256)) * 40_000
            sending = loop.create_task(loop.sock_sendall(partner, stream))
            await asyncio.sleep(0.1)
            assert not sending.done()
            heard = bytearray()
            while len(heard) < len(stream):
                count = await runner.get(sio, data)
                assert count > 0
                heard += bytes(int(value) for value in data[:count])
            assert heard == stream
            partner.close()

        play(act, client(server.getsockname()[1], 2))


def test_a_reset_is_an_error_and_the_next_instruction_connects_again() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            sio = runner.variable(NAME)
            waiting = loop.create_task(code(runner.read_text(sio)))
            partner, _ = await loop.sock_accept(server)
            partner.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            partner.close()
            assert await waiting == 125
            assert await runner.set(sio, [1.0]) == 1
            again, _ = await loop.sock_accept(server)
            again.close()

        play(act, client(server.getsockname()[1], 2))


def test_a_killed_task_gives_its_place_to_the_next() -> None:
    with listener() as server:

        async def act(runner: SioRunner) -> None:
            loop = asyncio.get_running_loop()
            sio = runner.variable(NAME)
            killed, next_one = loop.create_task(runner.read_text(sio)), loop.create_task(runner.read_num(sio))
            partner, _ = await loop.sock_accept(server)
            await loop.sock_sendall(partner, b"A")
            await asyncio.sleep(0.05)
            assert not next_one.done()
            killed.cancel()
            assert await asyncio.wait_for(next_one, 3) == 65.0
            partner.close()

        play(act, client(server.getsockname()[1]))
