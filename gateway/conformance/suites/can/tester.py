"""The tester's side of a CAN bus: frames sent and received, also unexpected ones."""

import itertools
from collections import deque
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import contextmanager, suppress

from gateway.conformance.framework.base import Seen, Tester
from gateway.conformance.framework.frame_wire import FrameWire
from gateway.pure.conformance.verdict import Ended, Fail
from protocols.base.machine import Frame, FrameFault, Ns, ms

IDLE = ms(30)
TRACE = 400  # pieces of one case: a long one shows its beginning and its end


class CanTester(Tester):
    """`connect` opens the wire; `heard` holds all frames of this case, with their stamps."""

    def __init__(self, connect: Callable[[], FrameWire], witness: Callable[[], Ns] = lambda: 0) -> None:
        super().__init__()
        self._connect, self._witness = connect, witness
        self._wire: FrameWire | None = None
        self.heard: list[Frame] = []
        self.faults: list[FrameFault] = []
        self._kept: deque[Frame] = deque()  # received while waiting for something else
        self.asked_at: Ns = 0  # when the last frame was sent
        self.answered_at: Ns = 0  # stamp of the last frame that was waited for

    # ---- the wire
    @property
    def wire(self) -> FrameWire:
        if self._wire is None:
            self._wire = self._connect()
            self.clock = "virtual" if self._wire.simulated else "monotonic clock of this host, at the port"
        return self._wire

    def drop(self) -> None:
        if self._wire is not None:
            self._wire.close()
            self._wire = None

    def now(self) -> Ns:
        return self.wire.now()

    def late(self) -> Ns:
        return 0 if self._wire is None or self._wire.simulated else max(self._wire.late_ns, self._witness())

    def begin(self) -> None:
        self.pause(IDLE if self.wire.simulated else 2 * IDLE)
        self.heard, self.faults = [], []
        self._kept.clear()
        self.wire.late_ns = 0
        self._witness()

    # ---- saying and hearing
    def say(self, identifier: int, data: bytes = b"") -> None:
        """Send; frames kept from before are not answers to this."""
        self._kept.clear()
        self.say_on(identifier, data)

    def say_on(self, identifier: int, data: bytes = b"") -> None:
        """As `say`, within a sequence: kept frames stay."""
        self.asked_at = self.wire.send(Frame(identifier, data))
        self._note(self.asked_at, "tester", data, identifier)

    def _note(self, stamp: Ns, side: str, data: bytes, identifier: int | None, note: str = "") -> None:
        trace = self.notes.trace
        if len(trace) == TRACE:
            trace.append(Seen(stamp, "tester", b"", ".."))
        elif len(trace) > TRACE:
            del trace[TRACE // 2]
        trace.append(Seen(stamp, side, data, note, identifier))

    def _next(self, until: Ns) -> Frame | None:
        """The next frame of the bus; None: that moment has come."""
        while True:
            found = self.wire.hear(until)
            if found is None:
                return None
            if isinstance(found, Frame):
                self._note(found.stamp_ns, "device", found.data, found.identifier)
                self.heard.append(found)
                return found
            self.faults.append(found)
            self._note(self.now(), "device", b"", None, f"error frame: {found.name.lower()}")

    def hear(self, wanted: Container[int], wait: Ns) -> Frame | None:
        """The next frame on one of these identifiers; the time-out counts from now, others are kept."""
        for kept in self._kept:
            if kept.identifier in wanted:
                self._kept.remove(kept)
                self.answered_at = kept.stamp_ns
                return kept
        until = self.now() + wait
        while (frame := self._next(until)) is not None:
            if frame.identifier in wanted:
                self.answered_at = frame.stamp_ns
                return frame
            self.notes.unasked += 1
            self._kept.append(frame)
        return None

    def pause(self, time: Ns) -> list[Frame]:
        """Wait; return the frames received."""
        until, found = self.now() + time, list[Frame]()
        while (frame := self._next(until)) is not None:
            found.append(frame)
        self._kept += found
        return found

    def drain(self) -> None:
        """Discard the frames received so far."""
        self._kept.clear()

    def collect(self, identifier: int, count: int, wait: Ns) -> list[Frame]:
        """The next `count` frames on this identifier; fewer if one is missing for so long."""
        found: list[Frame] = []
        while len(found) < count and (frame := self.hear((identifier,), wait)) is not None:
            found.append(frame)
        return found

    def silence(self, identifier: int, time: Ns, what: str) -> None:
        """Judged: nothing comes on this identifier."""
        found = [frame for frame in self.pause(time) if frame.identifier == identifier]
        if found:
            raise Fail(f"{what}: it sends {shown(found[0])}", f"nothing on {identifier:03X}h", shown(found[0]))


def shown(frame: Frame | None) -> str:
    return "nothing" if frame is None else f"{frame.identifier & 0x7FF:03X}h {frame.data.hex(' ').upper() or '(no data)'}"


def gaps(frames: Sequence[Frame]) -> list[Ns]:
    return [later.stamp_ns - before.stamp_ns for before, later in itertools.pairwise(frames)]


@contextmanager
def afterwards(*acts: Callable[[], object]) -> Iterator[None]:
    """Restore what a case changed, whatever its result."""
    try:
        yield
    finally:
        for act in acts:
            with suppress(Ended):
                act()
