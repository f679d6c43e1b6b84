"""Client of the line process: every method waits for the answer (a few milliseconds), raises PortError when there is none.

Each returns the stamp (ns, CLOCK_MONOTONIC) at which it took effect.
"""

import json
import socket
from typing import Any

from drivers.ports.base import PortError, runtime_dir
from protocols.base.machine import Ns


class LineControl:
    """Controls the cable called `name`."""

    def __init__(self, name: str, timeout_s: float = 5.0) -> None:
        self.name = name
        path = str(runtime_dir() / f"line-{name}.sock")
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(timeout_s)
        try:
            self._socket.connect(path)
        except OSError as error:
            self._socket.close()
            raise PortError(
                error.errno, f"{path}: no line process answers; start python -m gateway.simulation.line.process --name {name}"
            ) from error
        self._answers = self._socket.makefile("r", encoding="utf-8")

    @staticmethod
    def path(name: str, side: str) -> str:
        """The pty link of side "a" or "b"; as a port: "pty:" + path."""
        return str(runtime_dir() / f"{name}-{side.lower()}")

    def unplug(self) -> Ns:
        """Pulls the cable: characters vanish at the break, and are recorded."""
        return self._stamp(do="unplug")

    def plug(self) -> Ns:
        """Puts the cable back."""
        return self._stamp(do="plug")

    def remove(self, side: str) -> Ns:
        """Pulls the adapter of side A or B out of its computer."""
        return self._stamp(do="remove", side=side)

    def insert(self, side: str) -> Ns:
        """Puts it back; the link leads to a new pty."""
        return self._stamp(do="insert", side=side)

    def damage(self, sender: str, kind: str = "parity", next: int = 1) -> Ns:
        """The `next`-th character that leaves side `sender` from now on is damaged: parity, framing, overrun, break, flip, drop."""
        return self._stamp(**{"do": "damage", "from": sender, "kind": kind, "next": next})

    def damage_some(self, sender: str, kind: str, probability: float, seed: int = 0) -> Ns:
        """Every character of side `sender` is damaged with this probability, the same ones for the same seed."""
        return self._stamp(**{"do": "damage", "from": sender, "kind": kind, "probability": probability, "seed": seed})

    def calm(self) -> Ns:
        """Ends all damage."""
        return self._stamp(do="calm")

    def noise(self, sender: str, data: bytes) -> Ns:
        """Injected characters, as if sent by side `sender`."""
        return self._stamp(**{"do": "noise", "from": sender, "hex": data.hex()})

    def send_break(self, sender: str) -> Ns:
        """A BREAK, as if side `sender` had sent it."""
        return self._stamp(**{"do": "noise", "from": sender, "kind": "break"})

    def status(self) -> dict[str, Any]:
        """Counters and states; whatever was recorded up to now is in the file afterwards."""
        return self._ask(do="status")

    def stop(self) -> None:
        """Ends the process."""
        self._ask(do="stop")
        self.close()

    def close(self) -> None:
        """Twice does no harm."""
        self._answers.close()
        self._socket.close()

    def __enter__(self) -> "LineControl":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _stamp(self, **command: object) -> Ns:
        return int(self._ask(**command)["stamp_ns"])

    def _ask(self, **command: object) -> dict[str, Any]:
        try:
            self._socket.sendall(json.dumps(command).encode() + b"\n")
            line = self._answers.readline()
        except OSError as error:
            raise PortError(error.errno, f"line {self.name}: no answer ({error}); is the line process running?") from error
        if not line:
            raise PortError(f"line {self.name}: the line process has ended; start it again")
        answer: dict[str, Any] = json.loads(line)
        if not answer.pop("ok"):
            raise ValueError(f"line {self.name}: {answer['why']}")
        return answer
