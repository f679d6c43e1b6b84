"""The cycle's end of a recording: messages into a ring, while a recorder lives; no file, no waiting."""

from collections.abc import Callable, Mapping, Sequence

from gateway.cycle.bus_link import BusLink
from gateway.pure.buses.cia401 import CouplerFamily
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.aside import Aside
from gateway.pure.image.records.cell import Motion, unpack_order
from gateway.pure.recording.messages import (
    ASKED_LAYOUT,
    BEGIN,
    CHUNK_LAYOUT,
    NODE,
    RECORDER_GONE,
    STEP,
    Phase,
    What,
    chunks,
    pack,
    pack_frames,
    pack_shown,
)
from gateway.recording.states import Snapshots, Start, StateError
from gateway.runtime.regions import RegionReader, RingWriter
from protocols.base.machine import Frame, Ns

LOOK_EVERY = 16  # cycles between looks for a recorder while there is none


class CycleTap:
    """`on`: a recorder is active."""

    def __init__(self, core: CycleLogic, buses: Sequence[BusLink], fds: Mapping[str, int]) -> None:
        self.on = False
        self._core, self._buses = core, buses
        self._ring = RingWriter(fds["record"], "record", CHUNK_LAYOUT)
        self._asked = RegionReader(fds["recorder"], "recorder", ASKED_LAYOUT)
        self._answered = 0  # the last wish for a start that was met
        self._snapshots: Snapshots | None = None
        self._try(self._look_around)
        self._heap = bytearray()
        self._image = b""
        self._shown: dict[int, bytes] = {}
        self._phase = Phase.BEFORE

    def put(self, what: What, payload: bytes = b"") -> None:
        """One more call of this cycle."""
        self._heap += pack(what, payload)

    def note(self, what: What) -> None:
        """A call without arguments, when a recorder is active."""
        if self.on:
            self.put(what)

    def began(self, now: Ns, missed: int) -> None:
        """The cycle begins."""
        self._phase = Phase.BEFORE
        self.put(What.BEGIN, BEGIN.pack(now, missed))

    def node(self, kind: Aside, bus: int, node: int, data: bytes) -> None:
        """By request of the master."""
        if kind is Aside.RELEASE:
            self.put(What.RELEASE, NODE.pack(bus, node, data[0] if data else 0))
        elif kind is Aside.HOLD:
            self.put(What.HOLD, NODE.pack(bus, node, 0))

    def exchange(self, bus: int, *, there: bool) -> None:
        """Digital I/O of a bus."""
        if self.on:
            self.put(What.EXCHANGE, bytes((bus, there)))

    def sent(self, bus: int, frames: Sequence[Frame]) -> None:
        """The burst; frames from now on answer it."""
        self._phase = Phase.AFTER
        self.put(What.SENT, pack_frames(bus, 1, frames))

    def heard(self, bus: int, frames: Sequence[Frame]) -> None:
        """Taken from the port."""
        if frames:
            self.put(What.HEARD, pack_frames(bus, self._phase, frames))

    def orders(self, taken: Sequence[tuple[int, bytes]]) -> None:
        """Records of the command ring, those for a predecessor left out."""
        for _, record in taken:
            if unpack_order(record).generation == self._core.state.generation:
                self.put(What.ORDER, record)

    def image(self, payload: bytes) -> None:
        """RC inputs as they are judged from now on."""
        if payload is not self._image:
            self._image = payload
            if self.on:
                self.put(What.IMAGE, payload)

    def contacts(self) -> None:
        """Outputs sent to the couplers."""
        for number, bus in enumerate(self._buses if self.on else ()):
            if isinstance(bus.family, CouplerFamily):
                shown = pack_shown(number, bus.family.shown.items())
                if shown != self._shown.get(number):
                    self._shown[number] = shown
                    self.put(What.SHOWN, shown)

    def stepped(self, now: Ns, services_ns: Ns, missing: int) -> None:
        """The core is about to step."""
        if self.on:
            self.put(What.STEP, STEP.pack(self._core.state.cycle + 1, now, services_ns, missing))

    def turn(self, now: Ns) -> None:
        """At the end of a cycle, when all is published: pass it on, and check for a recorder."""
        cycle = self._core.state.cycle
        if self.on:
            self._hand_over(cycle)
        elif cycle % LOOK_EVERY and cycle > 1:
            return
        if not self._asked.published or now - self._asked.life[1] > RECORDER_GONE:
            self._switch(on=False)
        elif self._asked.published != self._answered and self._core.state.motion is Motion.IDLE:
            self._answered = self._asked.published
            self._try(lambda: self._start(cycle))

    def _try(self, act: Callable[[], None]) -> None:
        """A recording that is not possible must not cost the cell its cycle."""
        try:
            act()
        except StateError as error:
            print(f"cannot be recorded: {error}", flush=True)

    def _look_around(self) -> None:
        self._snapshots = Snapshots(self._core, [bus.family for bus in self._buses])

    def _start(self, cycle: int) -> None:
        if self._snapshots is None:
            raise StateError("the state since the start is not known")
        self._shown.clear()
        start = Start(
            self._core,
            [bus.family for bus in self._buses],
            [bus.late for bus in self._buses],
            [bus.sent_ns for bus in self._buses],
            [[bus.number, identifier, each.last, each.count] for bus in self._buses for identifier, each in bus.encoders.items()],
        )
        self.put(What.START, self._snapshots.take(start))
        if self._image:
            self.put(What.IMAGE, self._image)
        self._switch(on=True)
        self._hand_over(cycle)

    def _switch(self, *, on: bool) -> None:
        self.on = on
        for bus in self._buses:
            bus.tap = self if on else None

    def _hand_over(self, cycle: int) -> None:
        for record in chunks(cycle, self._heap):
            self._ring.put(record)
        self._heap.clear()
