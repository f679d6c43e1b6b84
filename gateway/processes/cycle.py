"""The cycle: one thread, one absolute grid.  SYNC and set values leave only from here, and only from a completed cycle.

Order of one cycle (AX-001): at the grid instant SYNC and the set values for the next SYNC in one burst; drives answer with what they
latched; then the core thinks, and what it decided is published.  A grid instant that was missed is counted and never made up for.
"""

import argparse
import select
import signal
import time
from collections.abc import Sequence

from drivers.ports.base import CanPort, PortError
from drivers.ports.can import open_can
from gateway.assembly import RunPlan, load_plan
from gateway.axes import assumed_permits, core_axes, rc_numbers
from gateway.dbcfile import load_servodyn
from gateway.files import beside
from gateway.image import RegionReader, RegionWriter, RingReader, RingWriter, fds_from_text
from gateway.pure.core import Core
from gateway.pure.records import TRACE_LAYOUT, InputImage, OrderRecord, pack_cell_state, pack_trace, unpack_inputs, unpack_order
from gateway.realtime import die_with_parent, go_realtime, sleep_until
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame
from protocols.servodyn.codec import SYNC, ActualValue, Codec, SetValue

PRIORITY = 40  # broker 30, emulator 20, line process 15: all below the cycle
SPIN_NS = 100_000
THINKING_NS, THINKING_SHARE = 3_000_000, 0.4  # kept free for the core at the end of a cycle: the smaller of both (AX-149)
REOPEN_NS = 200_000_000


def patience_ns(period_ns: int) -> int:
    """How long after the grid instant an actual value is waited for; what is not here by then is missing (AX-149)."""
    return period_ns - min(THINKING_NS, int(THINKING_SHARE * period_ns))


class BusLink:
    """One drive bus: its port, its codec and which axes hang on it."""

    def __init__(self, url: str, codec: Codec, axes: Sequence[tuple[int, int]]) -> None:
        """`axes`: (index in the cell, module on this bus)."""
        self.url, self.codec = url, codec
        self.port: CanPort | None = None
        self.refused = 0  # frames the port did not take: never silent
        self.foreign = 0
        self.last_error = ""
        self._modules = {module: index for index, module in axes}
        self._axes = tuple(axes)
        self._retry_ns = 0
        self._burst: list[Frame] = [SYNC]

    def prepare(self, values: Sequence[SetValue]) -> None:
        """Set values for the next burst."""
        self._burst = [SYNC, *(self.codec.encode_set(module, values[index]) for index, module in self._axes)]

    def send(self, now: int) -> bool:
        """The burst; False when the bus is not there."""
        if self.port is None and not self._open(now):
            return False
        assert self.port is not None
        try:
            self.refused += len(self._burst) - self.port.send(self._burst)
        except PortError as error:
            self._lose(error)
            return False
        return True

    def receive(self, actuals: list[ActualValue | None], *, late: bool = False) -> int:
        """Take what came; how many axes answered for the first time in this cycle.  `late`: it belongs to a cycle that is over."""
        if self.port is None:
            return 0
        try:
            frames = self.port.receive()
        except PortError as error:
            self._lose(error)
            return 0
        fresh = 0
        for frame in frames:
            try:
                module, actual = self.codec.decode_actual(frame)
            except DecodeError:
                self.foreign += 1
                continue
            index = self._modules.get(module)
            if index is None or late:
                fresh += index is not None
                continue
            fresh += actuals[index] is None
            actuals[index] = actual
        return fresh

    def close(self) -> None:
        if self.port is not None:
            self.port.close()
            self.port = None

    def _open(self, now: int) -> bool:
        if now < self._retry_ns:
            return False
        self._retry_ns = now + REOPEN_NS
        try:
            self.port = open_can(self.url)
        except PortError as error:
            self._say(error)
            return False
        self.last_error = ""
        print(f"{self.url}: open", flush=True)
        return True

    def _lose(self, error: PortError) -> None:
        self.close()
        self._say(error)

    def _say(self, error: PortError) -> None:
        if str(error) != self.last_error:
            self.last_error = str(error)
            print(self.last_error, flush=True)


class Cycle:
    """The loop around the core."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        cell = plan.cell
        self.period_ns = plan.p5_ms * 1_000_000
        axes = core_axes(cell, plan.p5_ms)
        self.core = Core(
            axes,
            plan.p5_ms / 1000.0,
            time.monotonic_ns(),
            numbers=rc_numbers(cell),
            assumed=assumed_permits(cell),
            finish_without_services=cell.cell.on_services_loss == "finish_move",
        )
        self.buses = []
        for bus in cell.bus:
            if bus.name in plan.buses:
                places = [(n, a.drive.module) for n, a in enumerate(cell.axis) if a.drive.bus == bus.name and a.drive.module is not None]
                self.buses.append(BusLink(plan.buses[bus.name], load_servodyn(beside(cell.file, bus.layout, "drives")), places))
        self.inputs = RegionReader(fds["rc_in"], "rc_in")
        self.links = RegionReader(fds["links"], "links")
        self.orders = RingReader(fds["orders"], "orders")
        self.axes = RegionWriter(fds["axes"], "axes")
        self.outputs = RegionWriter(fds["rc_out"], "rc_out")
        self.trace = RingWriter(fds["trace"], "trace", TRACE_LAYOUT)
        self._image = InputImage()
        self._image_index = -1
        self._services_pid = self.links.writer_pid
        self._stop = False

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._on_signal)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the supervisor's business
        self._prepare([SetValue() for _ in self.core.state.axes[: len(self.core.plans)]])
        due = time.monotonic_ns() + self.period_ns
        while not self._stop:
            now = sleep_until(due, SPIN_NS)
            missed = (now - due) // self.period_ns
            if missed > 0:
                self.core.skipped(missed)
                due += missed * self.period_ns
            self._cycle(due, now)
            due += self.period_ns
        for bus in self.buses:
            bus.close()

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def _cycle(self, due: int, now: int) -> None:
        core = self.core
        actuals: list[ActualValue | None] = [None] * len(core.plans)
        for bus in self.buses:
            core.state.late += bus.receive(actuals, late=True)
        up = [bus for bus in self.buses if bus.send(now)]
        sent = time.monotonic_ns()
        if len(up) < len(self.buses):
            core.drives_lost()
        missing = self._collect(up, actuals, due + patience_ns(self.period_ns))
        got = time.monotonic_ns()
        core.state.incomplete += missing > 0
        self._watch_services()
        values = core.step(actuals, self._inputs(), self._take_orders(), self.links.life[1], now)
        self._prepare(values)
        ready = time.monotonic_ns()
        core.state.compute_ns = ready - got
        self.axes.write(pack_cell_state(core.state), now)
        self.outputs.write(core.outputs, now)
        self.axes.beat(now)
        self.trace.put(pack_trace(core.state.cycle, due, sent, got, ready, missing))

    def _prepare(self, values: Sequence[SetValue]) -> None:
        for bus in self.buses:
            bus.prepare(values)

    def _collect(self, up: Sequence[BusLink], actuals: list[ActualValue | None], until: int) -> int:
        """Wait for all actual values, at most to `until`; how many are missing."""
        missing = len(actuals)
        ports = [bus.port for bus in up if bus.port is not None]
        while missing and ports:
            left = until - time.monotonic_ns()
            if left <= 0 or not select.select(ports, (), (), left / 1e9)[0]:
                break
            missing -= sum(bus.receive(actuals) for bus in up)
            ports = [bus.port for bus in up if bus.port is not None]
        return missing

    def _watch_services(self) -> None:
        """A successor may be quicker than the life counter's limit: then only the writer's pid tells of the death."""
        pid = self.links.writer_pid
        if pid != self._services_pid and pid:
            if self._services_pid:
                self.core.services_lost()
            self._services_pid = pid

    def _inputs(self) -> InputImage:
        payload = self.inputs.read()
        if payload is not None and self.inputs.index != self._image_index:
            self._image_index, self._image = self.inputs.index, unpack_inputs(payload)
        return self._image

    def _take_orders(self) -> list[OrderRecord]:
        """Orders meant for this very process: an older generation's are dropped (a command is taken once)."""
        records = [unpack_order(record) for _, record in self.orders.take(8)]
        return [record for record in records if record.generation == self.core.state.generation]


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate cycle", description="the cycle process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    plan = load_plan(arguments.plan)
    cycle = Cycle(plan, fds_from_text(arguments.fds))
    for warning in go_realtime(PRIORITY):
        print(warning, flush=True)
    cycle.run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
