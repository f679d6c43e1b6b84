"""A tool's access to a line: send characters, receive the next one until a deadline, damage one; the same for real ports and virtual time.

A stamp is the moment at which a character had come in.  Virtual time: an emulated station is the other end, time passes only while the tool
waits, so a probe that waits four seconds for a block costs no time.
"""

import contextlib
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from drivers.ports.base import PortError
from protocols.base.machine import Damage, Machine, Ns, ms

STEPS = 100_000  # of a partner at one moment: more is a deadline that never passes
SLICE = ms(20)
NEAR = 500_000  # two moments of the same; so late is not late
LATES = 4000
SCHEDULED = "/proc/self/schedstat"
LAST_CHARACTERS = ms(2000)  # longest wait for them at the end


@dataclass(frozen=True, slots=True)
class Heard:
    """One character, or a damaged one."""

    stamp: Ns
    what: int | Damage


class Wire(Protocol):
    """One end of a line."""

    name: str
    char_ns: Ns
    simulated: bool
    late_ns: Ns  # worst lateness of this program since it was set to 0

    def held(self, since: Ns, until: Ns) -> Ns: ...  # by how much this program was late at the beginning and at the end of that span
    def now(self) -> Ns: ...
    def write(self, data: bytes) -> None: ...  # queued after what is still leaving
    def spoil(self) -> bool: ...  # one character with a wrong parity bit; False: this port cannot
    def send_break(self) -> bool: ...
    def drained(self) -> Ns: ...  # moment at which all written so far has left (or will have)
    def hear(self, until: Ns) -> Heard | None: ...  # the next character, at the latest at `until`; None: that moment has come
    def close(self) -> None: ...


class ToolPort(Protocol):
    """The part of a port that RealWire needs."""

    name: str
    char_ns: Ns

    def read(self) -> list[bytes | Damage]: ...
    def write(self, data: bytes) -> int: ...
    def unsent(self) -> int: ...  # characters that have not arrived, as far as the port knows
    def wait(self, seconds: float) -> None: ...  # until data can be read, at most this time
    def spoil(self) -> bool: ...
    def send_break(self) -> bool: ...
    def close(self) -> None: ...


def waited_ns() -> Ns:
    """How long this program has waited for a processor so far (proc(5)); 0 if the system does not report it."""
    try:
        with open(SCHEDULED, encoding="ascii") as file:
            return int(file.read().split()[1])
    except (OSError, ValueError, IndexError):
        return 0


class RealWire:
    """A port in real time.  `late_ns`: delay of this program itself; times measured during it are void."""

    simulated = False

    def __init__(self, port: ToolPort) -> None:
        self.name, self.char_ns = port.name, port.char_ns
        self.late_ns: Ns = 0
        self._port = port
        self._inbox: deque[Heard] = deque()
        self._drained: Ns = 0
        self._lates: deque[tuple[Ns, Ns, Ns]] = deque(maxlen=LATES)  # from, to, late

    def now(self) -> Ns:
        return time.monotonic_ns()

    def held(self, since: Ns, until: Ns) -> Ns:
        first = max((late for start, end, late in self._lates if start <= since <= end + NEAR), default=0)
        return first + max((late for start, end, late in self._lates if start <= until <= end + NEAR and end > since + NEAR), default=0)

    def _late(self, start: Ns, late: Ns) -> None:
        self.late_ns = max(self.late_ns, late)
        if late > NEAR:
            self._lates.append((start, self.now(), late))

    def write(self, data: bytes) -> None:
        start, left, waited = self.now(), data, waited_ns()
        while left:
            left = left[self._port.write(left) :]
            self._late(start, waited_ns() - waited)
            if left:
                time.sleep(0.001)
                if self.now() - start > 5_000 * 1_000_000:
                    raise PortError(f"{self.name}: accepts nothing any more, {len(left)} characters are waiting")
        self._drained = max(self._drained, start) + len(data) * self.char_ns

    def spoil(self) -> bool:
        return self._count(self._port.spoil())

    def send_break(self) -> bool:
        return self._count(self._port.send_break())

    def _count(self, done: bool) -> bool:
        if done:
            self._drained = max(self._drained, self.now()) + self.char_ns
        return done

    def drained(self) -> Ns:
        return self._drained

    def hear(self, until: Ns) -> Heard | None:
        while not self._inbox:
            now, waited = self.now(), waited_ns()
            asked = min(until - now, SLICE)
            if asked > 0:
                self._port.wait(asked / 1e9)
            self._take()
            after = self.now()
            self._late(now, max(after - now - max(asked, 0), waited_ns() - waited))
            if not self._inbox and after >= until:
                return None
        return self._inbox.popleft()

    def _take(self) -> None:
        now, items = self.now(), self._port.read()
        if items and self._drained > now and not self._port.unsent():
            self._drained = now  # no line delays our output: this answers all of it
        for item in items:
            for what in item if isinstance(item, bytes) else (item,):
                self._inbox.append(Heard(now, what))

    def close(self) -> None:
        """Once the last character has left: a partner that misses an acknowledgement repeats its block to the next tool."""
        with contextlib.suppress(PortError):
            end = self.now() + LAST_CHARACTERS
            while self.now() < min(self._drained, end):
                time.sleep(0.001)
            end = self.now() + SLICE
            while self._port.unsent() and self.now() < end:
                time.sleep(0.001)
        self._port.close()


class VirtualWire:
    """A protocol machine at the other end; characters take their time, without a clock.  Without character times (TCP) written bytes arrive
    at once.
    """

    simulated = True

    def __init__(
        self, station: Machine[object], char_ns: Ns, name: str = "sim", on_event: Callable[[object, Ns], None] | None = None
    ) -> None:
        self.name, self.char_ns, self.station = name, char_ns, station
        self.late_ns: Ns = 0
        self._on_event = on_event or (lambda event, now: None)
        self._now: Ns = 0
        self._to_station: deque[tuple[Ns, bytes | Damage]] = deque()
        self._free_at: Ns = 0
        self._inbox: deque[Heard] = deque()
        self._station_free: Ns = 0
        self._sent_at: Ns | None = None
        self._speak()

    def now(self) -> Ns:
        return self._now

    def held(self, since: Ns, until: Ns) -> Ns:
        return self.late_ns

    def write(self, data: bytes) -> None:
        if data and not self.char_ns:
            self._put(bytes(data))
            return
        for byte in data:
            self._put(bytes((byte,)))

    def spoil(self) -> bool:
        self._put(Damage.PARITY)
        return True

    def send_break(self) -> bool:
        self._put(Damage.BREAK)
        return True

    def drained(self) -> Ns:
        return self._free_at

    def act(self, action: Callable[[Ns], None]) -> None:
        """The station's owner does something at this moment."""
        action(self._now)
        self._speak()

    def hear(self, until: Ns) -> Heard | None:
        at, steps = -1, 0
        while True:
            moment = self._next()
            if self._inbox and (moment is None or self._inbox[0].stamp <= moment) and self._inbox[0].stamp <= until:
                heard = self._inbox.popleft()
                self._now = max(self._now, heard.stamp)
                return heard
            if moment is None or moment > until:
                self._now = max(self._now, until)
                return None
            self._now = max(self._now, moment)
            steps = steps + 1 if self._now == at else 0
            at = self._now
            if steps > STEPS:
                raise PortError(0, f"{self.name}: a deadline of the simulated station never passes: it stays at {at / 1e6:.3f} ms")
            self._serve()

    def close(self) -> None:
        """Nothing is held."""

    # ---- inside
    def _put(self, what: bytes | Damage) -> None:
        self._free_at = max(self._free_at, self._now) + self.char_ns
        self._to_station.append((self._free_at, what))

    def _next(self) -> Ns | None:
        moments = [moment for moment in (self.station.deadline(), self._sent_at) if moment is not None]
        if self._to_station:
            moments.append(self._to_station[0][0])
        return min(moments) if moments else None

    def _serve(self) -> None:
        now = self._now
        if self._sent_at is not None and self._sent_at <= now:
            self._sent_at = None
            self._report(self.station.sent(now))
        while self._to_station and self._to_station[0][0] <= now:
            what = self._to_station.popleft()[1]
            self._report(self.station.damaged(what, now) if isinstance(what, Damage) else self.station.receive(what, now))
        due = self.station.deadline()
        if due is not None and due <= now:
            self._report(self.station.wake(now))

    def _report(self, events: Sequence[object]) -> None:
        self._speak()
        for event in events:
            self._on_event(event, self._now)
        self._speak()

    def _speak(self) -> None:
        data = self.station.take_output()
        if not data:
            return
        start = max(self._now, self._station_free)
        for at, byte in enumerate(data, 1):
            self._inbox.append(Heard(start + at * self.char_ns, byte))
        self._station_free = self._sent_at = start + len(data) * self.char_ns
