"""A CAN suite's access to a bus: send frames, receive the next one until a deadline; the same for adapters and virtual time.

A machine in virtual time gets and returns frames as pairs (identifier, data); the identifier of a remote frame has bit 30.
"""

import select
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol

from drivers.ports.base import CanPort, PortError
from protocols.base.machine import Frame, FrameFault, Ns, ms

STEPS = 20_000  # of a device at one moment: more is a deadline that does not move
SLICE = ms(20)
LONGEST_SEND = ms(2000)
START: Ns = 1_000_000_000_000


class Pair(NamedTuple):
    """A frame as a device under test gets it."""

    identifier: int
    data: bytes


class StampedPair(Pair):
    """The same, with the moment at which the bus saw it."""

    stamp_ns: Ns


class FrameDevice(Protocol):
    """A guarded machine, as VirtualFrames drives it."""

    def receive(self, frames: Sequence[Pair], now: Ns) -> None: ...
    def wake(self, now: Ns) -> None: ...
    def deadline(self) -> Ns | None: ...
    def take_output(self) -> Iterable[Frame]: ...
    def lost(self, now: Ns) -> None: ...


class FrameWire(Protocol):
    """One end of a bus."""

    name: str
    simulated: bool
    late_ns: Ns  # worst lateness of this program since it was set to 0

    def now(self) -> Ns: ...
    def send(self, frame: Frame) -> Ns: ...  # the moment at which it left, as far as it is known
    def hear(self, until: Ns) -> Frame | FrameFault | None: ...  # the next one, stamped; None: that moment has come
    def close(self) -> None: ...


class VirtualFrames:
    """A machine at the other end; time passes only while the tester waits."""

    simulated = True

    def __init__(self, device: FrameDevice, name: str) -> None:
        self.name, self.device = name, device
        self.late_ns: Ns = 0
        self._now = START
        self._inbox: deque[Frame] = deque()
        self._turns, self._sent_at = 0, self._now
        self.act(device.wake)

    def now(self) -> Ns:
        return self._now

    def send(self, frame: Frame) -> Ns:
        self._turns = self._turns + 1 if self._sent_at == self._now else 0
        self._sent_at = self._now
        if self._turns > STEPS:
            raise RuntimeError("a case that sends and never waits")
        pair = StampedPair(frame.identifier, frame.data)
        pair.stamp_ns = self._now
        self.device.receive([pair], self._now)
        self._collect()
        return self._now

    def act(self, what: Callable[[Ns], None]) -> None:
        """Act on the device outside the bus."""
        what(self._now)
        self._collect()

    def hear(self, until: Ns) -> Frame | FrameFault | None:
        moment, turns = -1, 0
        while not self._inbox:
            due = self.device.deadline()
            if due is None or due > until:
                self._now = max(self._now, until)
                return None
            turns = turns + 1 if max(due, self._now) == moment else 0
            if turns > STEPS:
                raise PortError(0, f"{self.name}: the device's deadline never passes: it stays at {due}")
            moment = self._now = max(due, self._now)
            self.act(self.device.wake)
        return self._inbox.popleft()

    def _collect(self) -> None:
        self._inbox += [Frame(frame.identifier, frame.data, self._now) for frame in self.device.take_output()]

    def close(self) -> None:
        self.device.lost(self._now)


class RealFrames:
    """A port in real time; stamps are the port's own where it has them."""

    simulated = False

    def __init__(self, port: CanPort) -> None:
        self.name = port.name
        self.late_ns: Ns = 0
        self._port = port
        self._inbox: deque[Frame | FrameFault] = deque()

    def now(self) -> Ns:
        return time.monotonic_ns()

    def send(self, frame: Frame) -> Ns:
        begin = self.now()
        while not self._port.send([frame]):
            if self.now() - begin > LONGEST_SEND:
                raise PortError(0, f"{self.name}: accepts nothing any more; is another node on the bus?")
            time.sleep(0.001)
        return self.now()

    def hear(self, until: Ns) -> Frame | FrameFault | None:
        while not self._inbox:
            now = self.now()
            asked = min(until - now, SLICE)
            if asked > 0:
                select.select([self._port], [], [], asked / 1e9)
            self._take()
            after = self.now()
            self.late_ns = max(self.late_ns, after - now - max(asked, 0))
            if not self._inbox and after >= until:
                return None
        return self._inbox.popleft()

    def _take(self) -> None:
        now = self.now()
        self._inbox += [frame if 0 < now - frame.stamp_ns < ms(1000) else frame._replace(stamp_ns=now) for frame in self._port.receive()]
        self._inbox += [kind for kind, _ in self._port.take_faults()]

    def close(self) -> None:
        self._port.close()
