"""Plays coroutines against SioRunner: any exception and any wait without end is a failed assertion."""

import asyncio
import socket
from collections.abc import Awaitable, Callable, Coroutine
from typing import TypeVar

from gateway.links.serial.val3_channels import SioRunner
from gateway.pure.controllers.val3.sio.channel import Channel
from gateway.pure.controllers.val3.sio.errors import Val3Error

R = TypeVar("R")
LIMIT_S = 6.0


def play(act: Callable[[SioRunner], Coroutine[object, object, R]], *channels: Channel) -> R:
    """Runs `act(runner)` in a loop of its own, gives everything back."""

    complaints: list[str] = []  # what a callback of the loop raised

    async def whole() -> R:
        asyncio.get_running_loop().set_exception_handler(lambda _loop, context: complaints.append(f"{context}"))
        runner = await SioRunner.start(channels)
        try:
            return await act(runner)
        finally:
            runner.close()
            await asyncio.sleep(0)

    try:
        answer = asyncio.run(asyncio.wait_for(whole(), LIMIT_S))
    except TimeoutError as late:
        raise AssertionError(f"no end after {LIMIT_S:.0f} s") from late
    assert not complaints
    return answer


async def code(instruction: Awaitable[object]) -> int:
    """The run-time error it ends with; 0: none."""
    try:
        await instruction
    except Val3Error as failure:
        return int(failure.code)
    return 0


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """A port nobody has just now."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def listener(port: int = 0) -> socket.socket:
    """A server on loopback for one test."""
    server = socket.socket()
    server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    server.bind(("127.0.0.1", port))
    server.listen()
    server.setblocking(False)
    return server
