"""The smallest byte machine: reports what it receives, echoes it on request, and can ask for a wake."""

from dataclasses import dataclass

from protocols.base.machine import Damage, Ns


@dataclass(frozen=True, slots=True)
class Heard:
    """Good characters."""

    data: bytes


@dataclass(frozen=True, slots=True)
class HeardDamage:
    """A spoiled character."""

    kind: Damage


@dataclass(frozen=True, slots=True)
class AllSent:
    """Everything given to the line has left it."""

    at: Ns


@dataclass(frozen=True, slots=True)
class Woken:
    """The moment asked for has come."""

    asked: Ns
    at: Ns


@dataclass(frozen=True, slots=True)
class PortLost:
    """The port is gone."""


Event = Heard | HeardDamage | AllSent | Woken | PortLost


class EchoMachine:
    """Events in the order of the line."""

    def __init__(self, *, answer: bool = False) -> None:
        self._answer = answer
        self._output = bytearray()
        self._due: Ns | None = None

    def say(self, data: bytes) -> None:
        """Something to send; kick the loop afterwards."""
        self._output += data

    def wake_at(self, moment: Ns) -> None:
        """Asks for one wake; kick the loop afterwards."""
        self._due = moment

    def receive(self, data: bytes, now: Ns) -> list[Event]:
        if data == b"raise":
            raise RuntimeError("a machine of ours that breaks its word")
        if self._answer:
            self._output += data
        return [Heard(data)]

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        return [HeardDamage(kind)]

    def sent(self, now: Ns) -> list[Event]:
        return [AllSent(now)]

    def wake(self, now: Ns) -> list[Event]:
        if self._due is None or now < self._due:
            return []
        asked, self._due = self._due, None
        return [Woken(asked, now)]

    def deadline(self) -> Ns | None:
        return self._due

    def take_output(self) -> bytes:
        data = bytes(self._output)
        self._output.clear()
        return data

    def lost(self, now: Ns) -> list[Event]:
        self._output.clear()
        return [PortLost()]
