"""Commands to the line process: JSON lines through a Unix socket, one answer to each; a bad command is answered, never fatal."""

import contextlib
import os
import socket
import time
from collections.abc import Callable
from functools import partial

from drivers.ports.base import PortError
from drivers.ports.serial.cable import PENDING_LIMIT, Fault
from gateway.simulation.control_requests import CLIENTS, Answer, BadCommandError, Command, serve
from gateway.simulation.line.cable import Line
from protocols.base.machine import Ns


class ControlSocket:
    """Listens, reads lines, answers.  Clients that do not read their answers are dropped."""

    def __init__(self, path: str, line: Line, carry: Callable[[Line, Command], Answer]) -> None:
        self._path, self._line, self._carry = path, line, carry
        self._listener: socket.socket | None = None
        self._clients: dict[int, tuple[socket.socket, bytearray]] = {}

    def open(self) -> None:
        """Claims the path; PortError if another line process answers there."""
        with socket.socket(socket.AF_UNIX) as probe:
            try:
                probe.connect(self._path)
            except OSError:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(self._path)  # left over from a killed process
            else:
                raise PortError(f"{self._path}: another line process of this name runs; stop it or take another --name")
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        self._listener.bind(self._path)
        self._listener.listen(CLIENTS)
        self._line.watch(self._listener.fileno(), self._accept)

    def close(self) -> None:
        """Ends all connections and removes the path if it is its own."""
        for client, _ in list(self._clients.values()):
            self._drop(client)
        if self._listener is not None:
            self._listener.close()
            self._listener = None
            with contextlib.suppress(FileNotFoundError):
                os.unlink(self._path)

    def _accept(self, now: Ns) -> None:
        assert self._listener is not None
        try:
            client, _ = self._listener.accept()
        except OSError:
            return
        if len(self._clients) >= CLIENTS:
            client.close()
            return
        client.setblocking(False)
        self._clients[client.fileno()] = (client, bytearray())
        self._line.watch(client.fileno(), partial(self._hear, client.fileno()))

    def _hear(self, fd: int, now: Ns) -> None:
        client, heard = self._clients[fd]
        if not serve(client, heard, partial(self._carry, self._line)):
            self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        self._line.unwatch(client.fileno())
        del self._clients[client.fileno()]
        client.close()


def carry_out(line: Line, command: Command) -> Answer:
    """One command.  Characters that have left the line before it are not affected."""
    line.move(time.monotonic_ns())
    match command.get("do"):
        case "unplug" | "plug" as what:
            line.plugged = what == "plug"
            return {"stamp_ns": line.note(what)}
        case "remove" | "insert" as what:
            side = _side(command, "side")
            (line.insert if what == "insert" else line.remove)(side)
            return {"stamp_ns": line.note(f"{what} {side}")}
        case "damage":
            return _damage(line, command)
        case "calm":
            for way in line.ways.values():
                way.calm()
            return {"stamp_ns": line.note("calm")}
        case "noise":
            return _noise(line, command)
        case "status":
            return _status(line)
        case "stop":
            line.stopping = True
            return {"stamp_ns": line.note("stop")}
        case other:
            raise BadCommandError(f"{other!r}: unplug, plug, remove, insert, damage, calm, noise, status or stop expected")


def _damage(line: Line, command: Command) -> Answer:
    sender, fault = _side(command, "from"), _fault(command)
    if "probability" in command:
        probability, seed = command["probability"], command.get("seed", 0)
        if not isinstance(probability, int | float) or not 0 <= probability <= 1 or not isinstance(seed, int):
            raise BadCommandError("probability 0..1 and an integer seed expected")
        line.ways[sender].spoil_some(fault, probability, seed)
        return {"stamp_ns": line.note(f"damage from={sender} kind={fault.value} probability={probability} seed={seed}")}
    n = command.get("next", 1)
    if not isinstance(n, int) or not 1 <= n <= 1_000_000:
        raise BadCommandError("next: 1..1000000 expected")
    line.ways[sender].spoil_next(fault, n)
    return {"stamp_ns": line.note(f"damage from={sender} kind={fault.value} next={n}")}


def _noise(line: Line, command: Command) -> Answer:
    """Characters (or one BREAK) as if the sender had sent them, after what it has sent already."""
    sender, text = _side(command, "from"), command.get("hex", "")
    if not isinstance(text, str):
        raise BadCommandError("hex: text expected")
    data = bytes.fromhex(text)
    if "kind" in command:
        data = data or b"\0"
    elif not data:
        raise BadCommandError("hex: at least one character expected")
    way = line.ways[sender]
    if way.waiting + len(data) > 2 * PENDING_LIMIT:
        raise BadCommandError("too many characters wait on this side already")
    if "kind" in command:
        way.spoil_next(_fault(command), way.waiting + 1)
    way.offer(data, time.monotonic_ns())
    return {"stamp_ns": line.note(f"noise from={sender} {data.hex()}")}


def _status(line: Line) -> Answer:
    line.recorder.flush()
    return {
        "stamp_ns": time.monotonic_ns(),
        "plugged": line.plugged,
        "inserted": {side: end.inserted for side, end in line.sides.items()},
        "characters": {side: way.count for side, way in line.ways.items()},
        "waiting": {side: way.waiting for side, way in line.ways.items()},
        "lost": line.lost,
        "overflow": line.overflow,
        "damaged": line.damaged,
        "baud": line.baud,
        "bits": line.bits,
        "scheduling": line.scheduling,
        "unrecorded": line.recorder.unrecorded,
    }


def _side(command: Command, key: str) -> str:
    side = str(command.get(key, "")).upper()
    if side not in ("A", "B"):
        raise BadCommandError(f"{key}: A or B expected")
    return side


def _fault(command: Command) -> Fault:
    try:
        return Fault(command.get("kind"))
    except ValueError:
        raise BadCommandError(f"kind: one of {', '.join(fault.value for fault in Fault)} expected") from None
