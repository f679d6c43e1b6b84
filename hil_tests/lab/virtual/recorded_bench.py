"""A cell in virtual time whose cycles are recorded through the cycle's own tap and ring; no process."""

from types import SimpleNamespace
from typing import Any

from drivers.drives.family import Actual
from gateway.cycle.recording_tap import CycleTap
from gateway.pure.image.records.cell import pack_cell_state, pack_inputs, pack_order, unpack_cell_state
from gateway.pure.recording.messages import (
    ASKED,
    ASKED_LAYOUT,
    CHUNK_BYTES,
    CHUNK_LAYOUT,
    CHUNK_RECORDS,
    Assembly,
    Message,
    What,
    pack,
    unpack,
)
from gateway.runtime.regions import RegionWriter, RingReader, create_region, create_ring
from hil_tests.lab.virtual.cell_bench import CellBench
from motion.execution.pieces import record_size
from protocols.base.machine import Frame


class RecordedBench(CellBench):
    """`messages`: of all cycles since `record`, the START among them, with what was published after each."""

    def __init__(self, p5_ms: int = 4, **more: Any) -> None:
        super().__init__(p5_ms, **more)
        fds = {
            "record": create_ring("record", CHUNK_BYTES, CHUNK_RECORDS, CHUNK_LAYOUT),
            "recorder": create_region("recorder", ASKED.size, ASKED_LAYOUT),
        }
        self.bus: Any = SimpleNamespace(family=self.family, late=0, sent_ns=0, tap=None, number=0, encoders={})
        buses: list[Any] = [self.bus]
        self.tap = CycleTap(self.core, buses, fds)
        self._asked = RegionWriter(fds["recorder"], "recorder", ASKED_LAYOUT)
        self._ring = RingReader(fds["record"], "record", CHUNK_LAYOUT)
        self._assembly = Assembly()
        self.messages: list[Message] = []
        self.others: list[Frame] = []  # of the bus, besides the answers of drives: they come behind them
        self._image = b""

    def record(self) -> None:
        """From the next moment of rest on."""
        self._asked.write(ASKED.pack(1), self.now)
        self._asked.beat(self.now)

    def cycle(self, count: int = 1) -> None:
        """As the cycle does it, tap and all."""
        for _ in range(count):
            self._one()

    def _one(self) -> None:
        tap, core = self.tap, self.core
        self._asked.beat(self.now)
        stamped = [frame._replace(stamp_ns=self.now) for frame in self.burst]
        if tap.on:
            tap.began(self.now, 0)
        image = pack_inputs(self.inputs)
        if image != self._image:
            self._image = image
            tap.image(image)
        if tap.on:
            tap.sent(0, self.burst)
        self.bus.sent_ns = self.now
        self.slave.receive(stamped, self.now)
        actuals: list[Actual | None] = [None] * len(self.cell.axis)
        answers = [frame._replace(stamp_ns=self.now + 1) for frame in self.slave.take_output()]
        heard = [(frame, said) for frame in answers if (said := self.family.hear(frame)) is None or said.axis + 1 not in self.silent]
        if tap.on:
            tap.heard(0, [*(frame for frame, _ in heard), *self.others])
        for _, said in heard:
            if said is not None:
                actuals[said.axis] = said.actual
        self.services_ns = self.now if self.services_alive else self.services_ns
        orders, self.orders = self.orders, []
        missing = sum(actual is None for actual in actuals)
        core.state.incomplete += missing > 0
        if tap.on:
            tap.orders([(n, pack_order(order, record_size(len(self.cell.axis)))) for n, order in enumerate(orders)])
            tap.stepped(self.now, self.services_ns, missing)
        self.burst = self.family.burst(core.step(actuals, self.inputs, orders, self.services_ns, self.now))
        published = pack_cell_state(core.state) + bytes(core.outputs)
        was_on = tap.on
        tap.turn(self.now)
        self._keep(published, was_on)
        if self.services_alive:
            self.dispatcher.observe(unpack_cell_state(pack_cell_state(core.state)), self.now)
            self._hand_over()
        self.each()
        self.now += self.period_ns

    def _keep(self, published: bytes, was_on: bool) -> None:
        for _, record in self._ring.take(4096):
            whole = self._assembly.take(record)
            if whole is not None:
                self.messages += unpack(whole[1])
        if was_on:
            self.messages.append(Message(What.OUTPUTS, published))

    def octets(self) -> bytes:
        """The messages as a file keeps them, without the start."""
        return b"".join(pack(*message) for message in self.messages if message.what is not What.START)


def cycles_of(messages: list[Message]) -> list[list[Message]]:
    """One list for each cycle."""
    found: list[list[Message]] = []
    for message in messages:
        if message.what is What.BEGIN:
            found.append([])
        if found:
            found[-1].append(message)
    return found
