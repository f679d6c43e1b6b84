"""`Bench`: run a dialogue with any byte machine in virtual time, twice at once: in complete pieces and byte by byte.

Both twins must send and report the same.  An exception inside a machine is a failed assertion, and so is output that the test has not
asked for by its end (hil_tests/conftest.py).  Knows no protocol.
"""

import copy
from collections.abc import Callable, Iterator, Sequence
from typing import Generic, TypeVar, cast

from protocols.base.machine import Damage, Machine, Ns

M = TypeVar("M", bound=Machine[object])
R = TypeVar("R")
MOST_WAKES = 10_000  # at one moment: more is a deadline that does not move
played: list["Bench[Machine[object]]"] = []  # of the test under way


class _Twin(Generic[M]):
    """One of the two machines, with what it sent and reported since the last question."""

    def __init__(self, machine: M, in_pieces: bool) -> None:
        self.machine, self.in_pieces = machine, in_pieces
        self.said, self.told = bytearray(), list[object]()

    def act(self, what: str, action: Callable[[], R]) -> R:
        try:
            return action()
        except Exception as error:
            error.add_note(f"in {what}")
            raise

    def note(self, what: str, action: Callable[[], Sequence[object]]) -> None:
        events = self.act(what, action)
        assert isinstance(events, list), f"{what} returned {events!r}, a list of events expected"
        self.told += events

    def pieces(self, data: bytes) -> Iterator[bytes]:
        return (data[at : at + 1] for at in range(len(data))) if self.in_pieces else iter((data,) if data else ())

    def speak(self, leaves_at: Ns | None) -> None:
        output = self.act("take_output", self.machine.take_output)
        assert isinstance(output, bytes), f"take_output returned {output!r}, bytes expected"
        self.said += output
        if output and leaves_at is not None:
            now = leaves_at
            self.note("sent", lambda: self.machine.sent(now))
            self.speak(leaves_at)


class Bench(Generic[M]):
    """`line.at(ms(5)).hears(b"...").says(b"...").reports(event)`; the test must name all that is sent and reported.

    leaves_at_once=False: the machine's output stays on its way until `left()`; then its `sent` is called.
    """

    def __init__(self, machine: M, leaves_at_once: bool = True) -> None:
        self._twins = (_Twin(machine, False), _Twin(copy.deepcopy(machine), True))
        self._leaves_at_once = leaves_at_once
        self._now: Ns = 0
        self._speak()
        played.append(cast("Bench[Machine[object]]", self))

    @property
    def machine(self) -> M:
        """The twin that gets whole pieces, to look at."""
        return self._twins[0].machine

    def at(self, now: Ns) -> "Bench[M]":
        """Time passes until `now`; each deadline on the way is kept to the nanosecond."""
        assert now >= self._now, f"time goes on: {now} after {self._now}"
        for twin in self._twins:
            self._pass(twin, now)
        self._now = now
        return self

    def hears(self, data: bytes) -> "Bench[M]":
        for twin in self._twins:
            for piece in twin.pieces(data):
                self._give(twin, piece)
        return self

    def hears_apart(self, data: bytes) -> "Bench[M]":
        """One character after another, a microsecond between them: what follows is not in the same burst."""
        for at in range(len(data)):
            self.hears(data[at : at + 1]).at(self._now + 1000)
        return self

    def damaged(self, kind: Damage) -> "Bench[M]":
        for twin in self._twins:
            self._spoil(twin, kind)
        return self._speak()

    def does(self, action: Callable[[M, Ns], object]) -> "Bench[M]":
        """Its owner asks for something: `does(lambda link, now: link.send(b"A", now))`."""
        for twin in self._twins:
            self._do(twin, action)
        return self._speak()

    def left(self) -> "Bench[M]":
        """All output has left the line by now (leaves_at_once=False)."""
        for twin in self._twins:
            self._left(twin)
        return self._speak()

    def loses_the_port(self) -> "Bench[M]":
        for twin in self._twins:
            self._lost(twin)
        return self._speak()

    def says(self, expected: bytes) -> "Bench[M]":
        """Exactly this since last asked, in this order."""
        for twin in self._twins:
            said = bytes(twin.said)
            twin.said.clear()
            assert said == expected, f"{self._who(twin)}: says {said.hex(' ') or 'nothing'}, expected {expected.hex(' ') or 'nothing'}"
        return self

    def reports(self, *expected: object) -> "Bench[M]":
        """Exactly these since last asked, in this order."""
        for twin in self._twins:
            told, twin.told = twin.told, []
            assert told == list(expected), f"{self._who(twin)}: reports {told}, expected {list(expected)}"
        return self

    def told(self) -> list[object]:
        """What was reported since last asked, for a caller who compares it in his own way."""
        lists = []
        for twin in self._twins:
            lists.append(twin.told)
            twin.told = []
        assert lists[0] == lists[1], f"at {self._now / 1e6:.3f} ms: fed whole {lists[0]}, byte by byte {lists[1]}"
        return lists[0]

    def heard_out(self) -> None:
        """Check that nothing was sent or reported that the test has not asked for."""
        self.says(b"").reports()

    # ---- one twin
    def _give(self, twin: _Twin[M], piece: bytes) -> None:
        twin.note(f"receive({piece.hex(' ')})", lambda: twin.machine.receive(piece, self._now))
        twin.speak(self._leaves_at())

    def _do(self, twin: _Twin[M], action: Callable[[M, Ns], object]) -> None:
        twin.act("the owner's call", lambda: action(twin.machine, self._now))
        self._pass(twin, self._now)

    def _spoil(self, twin: _Twin[M], kind: Damage) -> None:
        twin.note(f"damaged({kind.name})", lambda: twin.machine.damaged(kind, self._now))

    def _left(self, twin: _Twin[M]) -> None:
        twin.note("sent", lambda: twin.machine.sent(self._now))

    def _lost(self, twin: _Twin[M]) -> None:
        twin.note("lost", lambda: twin.machine.lost(self._now))

    def _pass(self, twin: _Twin[M], until: Ns) -> None:
        for _ in range(MOST_WAKES):
            due = twin.act("deadline", twin.machine.deadline)
            if due is None or due > until:
                return
            self._wake(twin, max(due, self._now))
        raise AssertionError(f"{self._who(twin)}: the deadline stands still at {due}")

    def _wake(self, twin: _Twin[M], moment: Ns) -> None:
        twin.note("wake", lambda: twin.machine.wake(moment))
        twin.speak(moment if self._leaves_at_once else None)

    def _speak(self) -> "Bench[M]":
        for twin in self._twins:
            twin.speak(self._leaves_at())
        return self

    def _leaves_at(self) -> Ns | None:
        return self._now if self._leaves_at_once else None

    def _who(self, twin: _Twin[M]) -> str:
        return f"at {self._now / 1e6:.3f} ms, fed {'byte by byte' if twin.in_pieces else 'whole'}"
