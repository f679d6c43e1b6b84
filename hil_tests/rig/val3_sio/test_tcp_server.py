"""VAL 3 sio, TCP server: plain sockets on loopback as clients."""

import asyncio
import socket

import pytest

from gateway.links.serial.val3_channels import SioRunner
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from hil_tests.lab.virtual.val3_loop import free_port, play

RUNNER = "gateway.links.serial.val3_channels:SioRunner."
NAME = "Socket\\server"


async def connect(port: int) -> socket.socket:
    sock = socket.socket()
    sock.setblocking(False)
    await asyncio.wait_for(asyncio.get_running_loop().sock_connect(sock, ("127.0.0.1", port)), 3)
    return sock


def server(port: int, timeout_s: float = 3.0) -> Channel:
    return Channel(NAME, Kind.TCP_SERVER, bind="127.0.0.1", port=port, clients=2, timeout_s=timeout_s)


@pytest.mark.requirement("VAL-SIO-14", by=(RUNNER + "_accept", RUNNER + "_listen", "gateway.links.serial.val3_wires:listening_socket"))
def test_two_variables_serve_two_clients_and_a_third_is_turned_away() -> None:
    port = free_port()

    async def act(runner: SioRunner) -> None:
        loop = asyncio.get_running_loop()
        one, other = runner.variable(NAME), runner.variable(NAME)
        texts = [loop.create_task(runner.read_text(sio)) for sio in (one, other)]
        await asyncio.sleep(0.05)
        try:
            clients = [await connect(port) for _ in range(3)]
        except OSError as refused:
            raise AssertionError("nobody listens") from refused
        for number, client in enumerate(clients[:2]):
            await loop.sock_sendall(client, f"client {number}\r".encode())
        assert await asyncio.gather(*texts) == ["client 0", "client 1"]
        assert await runner.write_text(other, "hello") == "hello"
        assert await asyncio.wait_for(loop.sock_recv(clients[1], 99), 3) == b"hello\r"
        assert await asyncio.wait_for(loop.sock_recv(clients[2], 99), 3) == b""
        for client in clients:
            client.close()

    play(act, server(port))


@pytest.mark.requirement("VAL-SIO-12", by=(RUNNER + "_listen", RUNNER + "end_application"))
def test_nobody_listens_before_the_first_use_and_after_the_application() -> None:
    port = free_port()

    async def act(runner: SioRunner) -> None:
        loop = asyncio.get_running_loop()
        sio = runner.variable(NAME)
        with pytest.raises(ConnectionRefusedError):
            await connect(port)
        waiting = loop.create_task(runner.get(sio, [0.0]))
        await asyncio.sleep(0.05)
        try:
            client = await connect(port)
        except OSError as refused:
            raise AssertionError("nobody listens") from refused
        await loop.sock_sendall(client, b"a")
        assert await waiting == 1
        runner.end_application()
        assert await asyncio.wait_for(loop.sock_recv(client, 9), 3) == b""
        with pytest.raises(ConnectionRefusedError):
            await connect(port)
        client.close()

    play(act, server(port))


@pytest.mark.requirement("VAL-SIO-15", "VAL-SIO-16", by=(RUNNER + "delete", RUNNER + "clear_buffer", RUNNER + "_drop"))
def test_delete_and_clear_buffer_close_their_own_client() -> None:
    port = free_port()

    async def act(runner: SioRunner) -> None:
        loop = asyncio.get_running_loop()
        local, cleared, data = runner.variable(NAME), runner.variable(NAME), [0.0]
        waiting = [loop.create_task(runner.get(sio, data)) for sio in (local, cleared)]
        await asyncio.sleep(0.05)
        clients = [await connect(port) for _ in range(2)]
        for client in clients:
            await loop.sock_sendall(client, b"abc")
        assert await asyncio.gather(*waiting) == [1, 1]
        runner.delete(local)
        assert await asyncio.wait_for(hangs_up(clients[0]), 3)
        assert runner.clear_buffer(cleared) == 2 and runner.clear_buffer(cleared) == -1
        assert await asyncio.wait_for(hangs_up(clients[1]), 3)
        for client in clients:
            client.close()

    play(act, server(port))


async def hangs_up(client: socket.socket) -> bool:
    """Closed or reset: unread bytes make the kernel reset the connection."""
    try:
        return await asyncio.get_running_loop().sock_recv(client, 9) == b""
    except ConnectionResetError:
        return True


def test_a_port_that_is_taken_is_waited_for() -> None:
    port = free_port()
    holder = socket.socket()
    holder.bind(("127.0.0.1", port))
    holder.listen()

    async def act(runner: SioRunner) -> None:
        loop = asyncio.get_running_loop()
        waiting = loop.create_task(runner.get(runner.variable(NAME), [0.0]))
        await asyncio.sleep(0.1)
        holder.close()
        client = None
        while client is None:
            try:
                client = await connect(port)
            except OSError:
                await asyncio.sleep(0.05)
        await loop.sock_sendall(client, b"a")
        assert await waiting == 1
        client.close()

    play(act, server(port))
