"""Commands to an emulator process: JSON lines through runtime_dir()/emulator-NAME.sock, one answer line to each.

    {"do": "state"}                                   what every axis does, counters
    {"do": "quit"}                                    ends the process
    {"do": "flush"}                                   the record reaches its file
    {"do": "stuck_encoder", "axis": 1}                also wrong_sign, true_encoder, power_off, power_on
    {"do": "drop_actual", "axis": 1, "count": 3}      also drop_set
    {"do": "force_fault", "axis": 1, "code": 99}
    {"do": "load_torque", "axis": 1, "torque_nm": 2.5}
    {"do": "jump_encoder", "axis": 1, "increments": 4096}
    {"do": "phase_loss", "axis": 1, "on": true}       also undervoltage, over_temperature, motor_over_temperature, encoder_fault,
                                                      stick_brake

Answers are {"ok": true, "bus_time_ns": ...} or {"ok": false, "why": ...}.
"""

import contextlib
import json
import os
import select
import socket
from collections.abc import Callable

from drivers.emulator.servodyn.axis import CAUSES
from drivers.emulator.servodyn.slave import ServodynSlave
from drivers.ports.base import PortError, runtime_dir
from gateway.simulation.control_requests import CLIENTS, Answer, BadCommandError, Command, serve, switched, torque_nm, whole


def socket_path(name: str) -> str:
    return str(runtime_dir() / f"emulator-{name}.sock")


def carry_out(slave: ServodynSlave, command: Command) -> Answer:
    """One fault to trigger, or the state.  Raises BadCommandError."""
    plain = {
        "stuck_encoder": slave.stuck_encoder,
        "wrong_sign": slave.wrong_sign,
        "true_encoder": slave.true_encoder,
        "power_off": slave.power_off,
        "power_on": slave.power_on,
    }
    counted = {"drop_actual": slave.drop_actual, "drop_set": slave.drop_set}
    what = str(command.get("do"))
    if what == "state":
        return slave.state()
    try:
        if what in plain:
            plain[what](whole(command, "axis", 1, 6))
        elif what in counted:
            counted[what](whole(command, "axis", 1, 6), whole(command, "count", 0, 1_000_000))
        elif what == "force_fault":
            slave.force_fault(whole(command, "axis", 1, 6), whole(command, "code", 1, 255) if "code" in command else 99)
        elif what == "jump_encoder":
            slave.jump_encoder(whole(command, "axis", 1, 6), whole(command, "increments", -(1 << 31), (1 << 31) - 1))
        elif what in CAUSES:
            slave.cause(whole(command, "axis", 1, 6), what, switched(command))
        elif what == "stick_brake":
            slave.stick_brake(whole(command, "axis", 1, 6), switched(command))
        elif what == "load_torque":
            slave.load_torque(whole(command, "axis", 1, 6), torque_nm(command))
        else:
            known = ["state", "quit", "flush", *plain, *counted, *CAUSES, "stick_brake", "jump_encoder", "force_fault", "load_torque"]
            raise BadCommandError(f"{what!r} is not a command; known: {', '.join(known)}")
    except KeyError as error:
        raise BadCommandError(str(error.args[0])) from None
    return {"bus_time_ns": slave.state()["bus_time_ns"]}


class ControlServer:
    """Listens on the epoll of its process; a bad command is answered, a client that does not read is dropped."""

    def __init__(self, name: str, epoll: select.epoll, carry: Callable[[Command], Answer]) -> None:
        """Raises PortError when an emulator of this name runs already."""
        self._path, self._epoll, self._carry = socket_path(name), epoll, carry
        self._clients: dict[int, tuple[socket.socket, bytearray]] = {}
        with socket.socket(socket.AF_UNIX) as probe:
            try:
                probe.connect(self._path)
            except OSError:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(self._path)  # left over from a killed process
            else:
                raise PortError(f"{self._path}: another emulator of this name runs; stop it or take another --name")
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        self._listener.bind(self._path)
        self._listener.listen(CLIENTS)
        epoll.register(self._listener, select.EPOLLIN)

    def ready(self, fd: int) -> None:
        """This descriptor of the epoll is readable; foreign ones are ignored."""
        if fd == self._listener.fileno():
            self._accept()
        elif fd in self._clients:
            self._hear(fd)

    def close(self) -> None:
        for fd in list(self._clients):
            self._drop(fd)
        self._listener.close()
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self._path)

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:
            return
        if len(self._clients) >= CLIENTS:
            client.close()
            return
        client.setblocking(False)
        self._clients[client.fileno()] = (client, bytearray())
        self._epoll.register(client, select.EPOLLIN)

    def _hear(self, fd: int) -> None:
        if not serve(*self._clients[fd], self._carry):
            self._drop(fd)

    def _drop(self, fd: int) -> None:
        client, _ = self._clients.pop(fd)
        self._epoll.unregister(fd)
        client.close()


class EmulatorControl:
    """Client of a running emulator; every call waits for its answer, PortError when there is none."""

    def __init__(self, name: str, timeout_s: float = 5.0) -> None:
        self._name = name
        self._link = socket.socket(socket.AF_UNIX)
        self._link.settimeout(timeout_s)
        try:
            self._link.connect(socket_path(name))
        except OSError as error:
            self._link.close()
            raise PortError(
                f"emulator {name}: {error.strerror}; start it with: python -m gateway.simulation.drives.process --name {name}"
            ) from error
        self._answers = self._link.makefile("rb")

    def ask(self, do: str, **arguments: object) -> Answer:
        """Send one command.  Raises BadCommandError with the emulator's words, PortError when it is gone."""
        try:
            self._link.sendall(json.dumps({"do": do, **arguments}).encode() + b"\n")
            line = self._answers.readline()
        except OSError as error:
            raise PortError(f"emulator {self._name}: {error}") from error
        if not line:
            raise PortError(f"emulator {self._name}: ended")
        answer: Answer = json.loads(line)
        if answer.pop("ok") is not True:
            raise BadCommandError(str(answer.get("why")))
        return answer

    def state(self) -> Answer:
        return self.ask("state")

    def close(self) -> None:
        self._answers.close()
        self._link.close()
