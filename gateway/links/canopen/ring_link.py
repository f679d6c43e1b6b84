"""The services' end of the rings `acyclic` and `heard`: one link for each drive bus, for the python-can plug-in `cycle:`."""

import threading
import time
from collections import deque

from gateway.pure.buses.storms import Storms
from gateway.pure.image.records.aside import ASIDE_LAYOUT, Aside, AsideRecord, pack_aside, unpack_aside
from gateway.runtime.regions import RingReader, RingWriter
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid

KEPT = 4096  # unread frames of a bus
AT_ONCE, TURNS = 256, 32  # records read from the ring at once, and reads in one look: later ones wait for the next


class Rings:
    """Both rings and the waiting frames of each bus; callable from any thread."""

    def __init__(self, acyclic: int, heard: int, buses: int) -> None:
        """File descriptors of the rings and the number of drive buses; this process becomes the writer of `acyclic`."""
        self._out = RingWriter(acyclic, "acyclic", ASIDE_LAYOUT)
        self._in = RingReader(heard, "heard", ASIDE_LAYOUT)
        self._put_lock, self._take_lock = threading.Lock(), threading.Lock()  # a sender does not wait for a reader
        self._waiting: list[deque[Frame]] = [deque(maxlen=KEPT) for _ in range(buses)]
        self._storms = [Storms() for _ in range(buses)]
        self.links = [RingLink(self, number) for number in range(buses)]

    @property
    def gaps(self) -> int:
        """Records of the cycle that were lost because they were not read in time."""
        return self._in.gaps

    def put(self, record: AsideRecord) -> None:
        """One record to the cycle."""
        with self._put_lock:
            self._out.put(pack_aside(record))

    def take(self, bus: int) -> list[Frame]:
        """Waiting frames of one bus."""
        with self._take_lock:
            for _ in range(TURNS):
                records = self._in.take(AT_ONCE)
                for _, data in records:
                    record = unpack_aside(data)
                    if record.kind is Aside.FRAME and record.bus < len(self._waiting):
                        self._waiting[record.bus].append(Frame(record.identifier, record.data, record.stamp_ns))
                if len(records) < AT_ONCE:
                    break
            found = list(self._waiting[bus])
            self._waiting[bus].clear()
            return self._storms[bus].pass_on(found, time.monotonic_ns())

    def left_out(self, bus: int, identifier: int) -> int:
        """Frames of a storm that were not passed on since the last call."""
        with self._take_lock:
            return self._storms[bus].left_out(identifier)


class RingLink:
    """One bus (drivers.ports.can.cycle_bus.CycleLink)."""

    def __init__(self, rings: Rings, number: int) -> None:
        self._rings, self._number = rings, number
        self.sent = 0

    def send(self, identifier: int, data: bytes) -> bool:
        """Into the ring; the cycle sends it with one of its next bursts.  False: SYNC is the cycle's own."""
        if identifier == cobid.SYNC:
            return False
        self._rings.put(AsideRecord(Aside.FRAME, self._number, identifier, data))
        self.sent += 1
        return True

    def receive(self) -> list[Frame]:
        """Acyclic frames received by the cycle."""
        return self._rings.take(self._number)

    def left_out(self, identifier: int) -> int:
        """Frames of a storm of that identifier that `receive` has not passed on since the last call."""
        return self._rings.left_out(self._number, identifier)

    def release(self, node: int, mode: int) -> None:
        """This node is configured: the cycle may send to it."""
        self._rings.put(AsideRecord(Aside.RELEASE, self._number, node, bytes((mode & 0xFF,)), time.monotonic_ns()))

    def hold(self, node: int) -> None:
        """The cycle stops sending to it."""
        self._rings.put(AsideRecord(Aside.HOLD, self._number, node))
