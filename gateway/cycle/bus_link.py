"""One drive bus of the cycle: its port, the family of drives on it, and the frames of a cycle."""

from collections import deque
from collections.abc import Sequence
from typing import Protocol

from drivers.drives.family import Actual, BusFamily, SetRecord
from drivers.drives.masters import OtherMaster
from drivers.ports.base import CanPort, PortError
from drivers.ports.can.broker import BrokerPort
from drivers.ports.can.open import open_can
from drivers.ports.can.wire import RECORD_BYTES
from gateway.assembly.cycle_belts import Encoder
from gateway.cycle.native.quick import NativeParts, QuickTelegrams
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, FrameFault

REOPEN_NS = 200_000_000
LISTEN_NS = 250_000_000  # before the first burst on a bus others can be on
DOUBLES, LEAK = 20, 16  # surplus actual values of one axis until they are reported; one is forgiven in so many cycles
BUS_OFF = (
    "bus-off: the controller left the bus after too many errors and is restarted; check cable, termination (120 ohm at both ends) and bit"
    " rate; if it stays away: sudo ip link set can0 type can restart (axisgate does that itself where it has CAP_NET_ADMIN)"
)


class BusTap(Protocol):
    """A recording's access to a bus."""

    def sent(self, bus: int, frames: Sequence[Frame]) -> None:
        """The burst has left."""

    def heard(self, bus: int, frames: Sequence[Frame]) -> None:
        """These came from the port."""


class BusLink:
    """One drive bus: its port and the family of drives on it."""

    def __init__(
        self, url: str, family: BusFamily, number: int = 0, quick: NativeParts | None = None, *, protocol: str = "", listens: bool = False
    ) -> None:
        """`protocol`: of the [[bus]], determines the frames reserved for its master; `listens`: other masters are possible, so listen
        before the first burst, and send nothing while another master is active.
        """
        self.url, self.family, self.number = url, family, number
        self._other, self._listens, self._quiet_from = OtherMaster(protocol), listens, 0
        self._doubles: dict[int, int] = {}
        self._turns = 0
        self.telegrams: QuickTelegrams | None = quick.telegrams(family) if quick else None
        self._local: BrokerPort | None = None  # the port, where its messages may be made and read in C
        self._values: Sequence[SetRecord] = ()
        self._message: bytes | None = None  # the next burst as it goes to the local bus; None: `_burst` holds it
        self.tap: BusTap | None = None  # set during a recording
        self.port: CanPort | None = None
        self.fd = -1  # of the port
        self.refused = 0  # frames that the port did not accept: always counted
        self.foreign = 0
        self.last_error = ""
        self.acyclic: deque[Frame] = deque()  # from the master: one leaves with each burst, and one for each axis that has none in it
        self.encoders: dict[int, Encoder] = {}  # of belts, by identifier
        self.late = 0  # actual values that came in the cycle after theirs
        self._retry_ns = self.sent_ns = 0
        self._burst: list[Frame] = []

    def prepare(self, values: Sequence[SetRecord]) -> None:
        """The next burst; `values` by the index of the cell."""
        self._message = self.telegrams.message(values) if self.telegrams is not None and self.plain else None
        if self._message is None:
            self._burst = self.family.burst(values)
        else:
            self._values = values

    def send(self, now: int) -> bool:
        """The burst; False when the bus is not there."""
        if self.port is None and not self._open(now):
            return False
        assert self.port is not None
        if self._quiet_from and not self._free(now):
            return False
        self._turns += 1
        if self._turns % LEAK == 0:
            self._watch(now)
        faults = self.port.take_faults()
        if faults and any(kind is FrameFault.BUS_OFF for kind, _ in faults):
            self._lose(PortError(f"{self.url}: {BUS_OFF}"))
            return False
        self.sent_ns = now
        try:
            if self._message is not None and self._local is not None and self.plain and not self.acyclic:
                self.refused += len(self._message) // RECORD_BYTES - self._local.send_message(self._message)
            else:
                self._send_frames(self.port)
        except PortError as error:
            self._lose(error)
            return False
        return True

    def _free(self, now: int) -> bool:
        """No other master was received for long enough; a frame that the master of the services wants to send in between is requested
        again.
        """
        assert self.port is not None
        self.acyclic.clear()
        try:
            frames = self.port.receive()
        except PortError as error:
            self._lose(error)
            return False
        for frame in frames:
            if frame.identifier in self._other.names:
                self._quiet_from = now
                self._foreign(frame.identifier, now)
        if now - self._quiet_from < LISTEN_NS:
            return False
        self._quiet_from = 0
        return True

    def _watch(self, now: int) -> None:
        if words := self._other.wake(now):
            print(f"{self.url}: {words}", flush=True)
        if self._doubles:
            self._doubles = {index: min(count, 2 * DOUBLES) - 1 for index, count in self._doubles.items() if count > 1}

    def _foreign(self, identifier: int, now: int) -> None:
        waits = "nothing is sent while it is active; " if self._quiet_from else ""
        if words := self._other.heard(identifier, now):
            print(f"{self.url}: {waits}{words}", flush=True)

    def _double(self, index: int) -> None:
        """Two actual values in one cycle: now and then a late one, again and again a second drive with the same number."""
        self._doubles[index] = self._doubles.get(index, 0) + 1
        if self._doubles[index] == DOUBLES:
            print(
                f"{self.url}: the actual value of axis {index + 1} is received twice in a cycle: a second device has the same number;"
                " switch it off or give it another number",
                flush=True,
            )

    @property
    def plain(self) -> bool:
        """Frames may be built and read in C: the local bus is up, and no other part needs the frames."""
        return self._local is not None and self.tap is None and not self.encoders

    def _send_frames(self, port: CanPort) -> None:
        if self._message is not None:
            self._burst = self.family.burst(self._values)
        if self.tap is not None:
            self.tap.sent(self.number, self._burst)
        if self.acyclic:
            free = min(1 + self.family.unconfigured, len(self.acyclic))
            self._burst += [self.acyclic.popleft() for _ in range(free)]
        self.refused += len(self._burst) - port.send(self._burst)

    def receive(self, actuals: list[Actual | None], *, next_only: bool = False) -> int:
        """Read the received frames; return how many axes answered for the first time since the burst.  Frames from before it belong to a
        past cycle and count as late.  `next_only`: accept the first frames only, the rest waits for the next call.
        """
        if self.port is None:
            return 0
        try:
            frames = self.port.receive_next() if next_only else self.port.receive()
        except PortError as error:
            self._lose(error)
            return 0
        return self._hear(frames, actuals)

    def receive_odd(self, message: bytes | None, actuals: list[Actual | None]) -> int:
        """As receive(), for a message from the local bus that was not read in C; None: the bus is lost."""
        if message is None or self._local is None:
            return self.receive(actuals)
        return self._hear(self._local.frames_in(message), actuals)

    def _hear(self, frames: Sequence[Frame], actuals: list[Actual | None]) -> int:
        if self.tap is not None:
            self.tap.heard(self.number, frames)
        fresh, hear, sent_ns, masters = 0, self.family.hear, self.sent_ns, self._other.names
        for frame in frames:
            if frame.identifier in masters:
                if self._quiet_from:  # the burst is held back and keeps waiting
                    self._quiet_from = max(self._quiet_from, frame.stamp_ns)
                self._foreign(frame.identifier, sent_ns)
            try:
                heard = hear(frame)
            except DecodeError:
                encoder = self.encoders.get(frame.identifier)
                if encoder is None:
                    self.foreign += 1
                else:
                    fresh += encoder.hear(frame.data)
                continue
            if heard is None:
                continue
            index, actual = heard
            if frame.stamp_ns < sent_ns:
                self.late += 1
                continue
            if actuals[index] is None:
                fresh += 1
            else:
                self._double(index)
            actuals[index] = actual
        return fresh

    def receive_rest(self, axes: int) -> None:
        """Before the next burst: input modules are not waited for, but their frames count."""
        self.late += self.receive([None] * axes)

    def close(self) -> None:
        if self.port is not None:
            self.port.close()
            self.port = self._local = None

    def _open(self, now: int) -> bool:
        if now < self._retry_ns:
            return False
        self._retry_ns = now + REOPEN_NS
        try:
            self.port = open_can(self.url)
            self.fd = self.port.fileno()
            self._local = self.port if self.telegrams is not None and isinstance(self.port, BrokerPort) else None
        except PortError as error:
            self._say(error)
            return False
        self.last_error = ""
        self._quiet_from = now if self._listens else 0
        print(f"{self.url}: open", flush=True)
        return True

    def _lose(self, error: PortError) -> None:
        self.close()
        self.acyclic.clear()  # the master repeats its request
        self._say(error)

    def _say(self, error: PortError) -> None:
        if str(error) != self.last_error:
            self.last_error = str(error)
            print(self.last_error, flush=True)
