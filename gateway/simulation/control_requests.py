"""JSON lines of the control sockets of simulated processes: requests of a client, one answer line to each, values checked."""

import json
import socket
from collections.abc import Callable, Mapping
from typing import Any

CLIENTS = 8
LONGEST = 16384  # bytes of a command
Command = Mapping[str, object]
Answer = dict[str, Any]


class BadCommandError(ValueError):
    """The client's mistake, reported in the answer."""


def serve(client: socket.socket, heard: bytearray, carry: Callable[[Command], Answer]) -> bool:
    """Answer each complete line from a client; False: it is gone, sends too much or does not read its answers."""
    try:
        data = client.recv(LONGEST)
    except BlockingIOError:
        return True
    except OSError:
        return False
    heard += data
    if not data or len(heard) > LONGEST:
        return False
    while (end := heard.find(b"\n")) >= 0:
        text = bytes(heard[:end])
        del heard[: end + 1]
        try:
            client.send(json.dumps(_answer(text, carry)).encode() + b"\n")
        except OSError:
            return False
    return True


def _answer(text: bytes, carry: Callable[[Command], Answer]) -> Answer:
    try:
        command = json.loads(text)
        if not isinstance(command, dict):
            raise BadCommandError('an object with the key "do" expected')
        return {"ok": True, **carry(command)}
    except (ValueError, OSError) as error:  # JSON, BadCommandError, a full disk, no pty left
        return {"ok": False, "why": str(error)}


def whole(command: Command, key: str, low: int, high: int) -> int:
    """An integer of a command, in its range."""
    value = command.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise BadCommandError(f"{key}: {value!r}; expected a whole number {low}..{high}")
    return value


def switched(command: Command) -> bool:
    """Whether a command switches its fault on (the default) or off."""
    value = command.get("on", True)
    if not isinstance(value, bool):
        raise BadCommandError(f"on: {value!r}; expected true or false")
    return value


def torque_nm(command: Command) -> float:
    """A load torque of a command."""
    value = command.get("torque_nm")
    if not isinstance(value, int | float) or isinstance(value, bool) or not -10_000.0 <= value <= 10_000.0:
        raise BadCommandError(f"torque_nm: {value!r}; expected -10000..10000 Nm")
    return float(value)
