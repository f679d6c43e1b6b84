"""The interpreter process: programs of the old controller (AX-860).  Orders arrive by a ring, inputs by a region; outputs and motion
requests leave by a ring, blocks to the planner by another.

It may die between any two writes: the axes stop at the end of what the planner has, its processes are gone, and nothing restarts
automatically. Two times are its own: a turn, in which programs read each input once, and the longest time between two signs of life.
"""

import argparse
import select
import signal
import time
from collections.abc import Mapping, Sequence

from gateway.assembly.contact_regions import COUNTERS_LAYOUT, OFFSETS
from gateway.assembly.run import RunPlan, load_plan
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, AxisFlag, CellState, Permit, unpack_cell_state
from gateway.pure.image.records.correction import CORRECTION_LAYOUT
from gateway.pure.image.records.interpreter import (
    REPORT_LAYOUT,
    SEEN_LAYOUT,
    TEXT_LAYOUT,
    Channels,
    Fact,
    pack_facts,
    pack_report,
    unpack_channels,
    unpack_facts,
)
from gateway.pure.image.records.planner import SAY_LAYOUT, BlockRecord, PlannerState, Say, pack_block, unpack_planner
from gateway.pure.languages.base.hosting import PathState, View, as_reported, paths_of
from gateway.pure.languages.base.lost_files import LostFiles
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.planning.ahead import StatementsAhead
from gateway.registry import language_in
from gateway.runtime.journal import Journal
from gateway.runtime.realtime import Timerfd, die_with_parent, go_ahead
from gateway.runtime.record_reader import RecordReader
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter, fds_from_text
from motion.geometry.units import from_si

WORKING_NS = 2_000_000  # of a turn for programs that compute
REPORTS_NS = 50_000_000
TAKEN = 64


class CellPort:
    """Inputs and outputs of programs, through regions and rings."""

    def __init__(self, plan: RunPlan, fds: Mapping[str, int], journal: Journal, run_id: int) -> None:
        self.view = View()
        self.run_id = run_id
        self._journal = journal
        self._units = [axis.unit for axis in plan.cell.axis]
        self._axes = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT)
        self._planner = RecordReader(RegionReader(fds["planner"], "planner"), unpack_planner, PlannerState())
        self._channels = RegionReader(fds["channels"], "channels", SEEN_LAYOUT)
        self._counters = RegionReader(fds["belt_counters"], "belt_counters", COUNTERS_LAYOUT) if "belt_counters" in fds else None
        self._belt_units = [belt.unit for belt in plan.cell.belt]
        self._ahead, self._said = StatementsAhead(), PlannerState()
        self._says = RingWriter(fds["program-says"], "program-says", TEXT_LAYOUT)
        self._lines = RingWriter(fds["lines"], "lines", SAY_LAYOUT)
        self._correction = RegionWriter(fds["correction"], "correction", CORRECTION_LAYOUT) if "correction" in fds else None
        self.lost_files = LostFiles()

    def look(self) -> None:
        """The cell in a new turn."""
        payload, seen = self._axes.read(), self._channels.read()
        state = CellState() if payload is None else unpack_cell_state(payload)
        self._said = planner = self._planner.read()
        axes = list(zip(self._units, state.axes, strict=False))
        self.view = View(
            Channels() if seen is None else unpack_channels(seen),
            tuple(from_si(axis.set, unit) for unit, axis in axes),
            tuple(from_si(axis.measured, unit) if state.measured_mask >> n & 1 else None for n, (unit, axis) in enumerate(axes)),
            paths_of(planner, state) or (PathState(),),
            tuple(from_si(axis.actual, unit) for unit, axis in axes),
            sum(1 << n for n, (_, axis) in enumerate(axes) if axis.flags & AxisFlag.ENABLED),
            state.motion,
            state.override,
            not state.emergency and bool(state.permits & Permit.CHAIN),
            self._belts(),
            tuple(kind for kind, _ in planner.types),
            tuple(axis.torque for _, axis in axes),
        )

    def _belts(self) -> tuple[float, ...]:
        """Counters in the units of the belts."""
        payload = self._counters.read() if self._counters is not None else None
        counters = OFFSETS.unpack(payload) if payload is not None else ()
        return tuple(from_si(value, unit) for value, unit in zip(counters, self._belt_units, strict=False))

    def say(self, what: str, **facts: Fact) -> None:
        """To the services."""
        self._says.put(pack_facts({"say": what, "id": self.run_id, **facts}))

    def output(self, channel: int, value: float) -> None:
        """Sets an output."""
        self.say("output", channel=channel, value=value)

    def ask_path(self, ticket: int, program: str, robot: int) -> None:
        """A robot is to move for a program."""
        self.say("path", ticket=ticket, program=program, robot=robot)

    def _line(self, say: Say, job: int, text: str = "") -> None:
        record = self._ahead.passed(BlockRecord(say, job, text), self._said)
        if record is not None:
            self._lines.put(pack_block(record))

    def line(self, job: int, text: str) -> None:
        """A statement for the planner."""
        self._line(Say.LINE, job, text)

    def whole(self, job: int) -> None:
        """The lines that follow are read when `end` has come."""
        self._line(Say.WHOLE, job)

    def finish(self, job: int) -> None:
        """Nothing follows for the time being."""
        self._line(Say.FINISH, job)

    def end(self, job: int) -> None:
        """No blocks follow."""
        self._line(Say.END, job)

    def started(self, run: int, program: str, kind: str, parent: int) -> None:
        """A program has started another one."""
        self.say("started", run=run, program=program, kind=kind, parent=parent)

    def over(self, run: int, how: str, fault: RuntimeFault | None, place: str) -> None:
        """A process is over."""
        code, text = (fault.code, fault.text) if fault is not None else (0, "")
        self.say("over", run=run, how=how, code=code, text=text, place=place)
        self.lost_files.over(run)

    def report(self, program: str, line: int, text: str) -> None:
        """Report to the operator."""
        self._journal.write("program", f"{program} line {line}: {text}" if line else f"{program}: {text}")

    def correct(self, record: bytes) -> None:
        """To the cycle, which applies it in its next period."""
        if self._correction is not None:
            self._correction.write(record, time.monotonic_ns())

    def panel(self, text: str) -> None:
        """Characters for the hand-held panel."""
        self.say("panel", text=text)

    def send(self, what: str, **facts: Fact) -> None:
        """A message of the language's own."""
        self.say(what, **facts)


class InterpreterProcess:
    """One run's interpreter."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        self.plan = plan
        self.journal = Journal(plan.journal, "interpreter")
        row = language_in(plan.cell)
        assert row is not None  # this process exists only with a language
        self.period_ns = (row.turn_ms or plan.p5_ms) * 1_000_000
        self.region = RegionWriter(fds["interpreter"], "interpreter", REPORT_LAYOUT)
        self.orders = RingReader(fds["program-orders"], "program-orders", TEXT_LAYOUT)
        self.run_id = time.monotonic_ns()
        self.port = CellPort(plan, fds, self.journal, self.run_id)
        self._alive()
        self.port.look()
        self.programs = row.programs(plan, self.port)
        self.language = self.programs.language
        self._catalogue: list[dict[str, object]] = []
        self._reported, self._shown = 0, b""
        self._fresh = self.region.latest() is None  # the first of its run, and nothing has been started: an autostart may be
        self._heard = False  # the services have begun
        self._stop = False
        self._phase = 0  # of the timer in its period
        self._have_read(self.programs.read(self._alive))

    def _alive(self) -> None:
        self.region.beat(time.monotonic_ns())

    def _have_read(self, faults: Sequence[str]) -> None:
        for fault in faults:
            self.journal.write("program", fault)
        self._catalogue = [as_reported(row) for row in self.language.catalogue()]

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._on_signal)
        timer = Timerfd()
        first = time.monotonic_ns() + self.period_ns
        self._phase = first % self.period_ns
        timer.set(first, self.period_ns)
        while not self._stop:
            select.select([timer], (), ())
            if timer.expired():
                self.turn()
        timer.close()
        self.language.stop_all(time.monotonic_ns())  # values written rarely while programs run are written now
        self._write_back()
        self.journal.close()

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def turn(self) -> None:
        """Orders, programs, files, published state."""
        began = time.monotonic_ns()
        now = began - (began - self._phase) % self.period_ns  # that of the timer: how late this turn is must not move the next ones
        self.port.look()
        for _, data in self.orders.take(TAKEN):
            self._obey(unpack_facts(data), now)
        while self.language.turn(now) and time.monotonic_ns() - began < WORKING_NS:
            pass
        self._write_back()
        self._report(began)
        self._alive()

    def _obey(self, order: dict[str, Fact], now: int) -> None:
        match order["do"]:
            case "hello":  # services have begun: for the control this is a start, and nothing runs (AX-332)
                self.language.stop_all(now)
                self._fresh, self._heard = self._fresh and not self._heard, True
            case "start":
                self._fresh = False
                if (faults := self.programs.refresh(self._alive)) is not None:
                    self._have_read(faults)
                self.port.lost_files.begins(int(order["run"]))
                self.language.start_run(str(order["program"]), int(order["run"]), now)
            case "select":
                if (faults := self.programs.refresh(self._alive)) is not None:
                    self._have_read(faults)
                self.language.hear(order, now)
            case "stop":
                self.language.stop_run(int(order["run"]), now)
            case "fail":
                self.language.stop_run(int(order["run"]), now, RuntimeFault(int(order["code"]), str(order["text"])))
            case "given" | "over" if order["id"] != self.run_id:
                pass  # meant for the interpreter before this one
            case "given":
                self.language.path_given(int(order["ticket"]), int(order["job"]))
            case "over":
                code = int(order["code"])
                self.language.path_over(int(order["ticket"]), RuntimeFault(code, str(order["text"])) if code else None, now)
            case _:
                self.language.hear(order, now)

    def _write_back(self) -> None:
        faults = self.programs.write_back()
        for fault in faults:
            self.journal.write("alarm", fault)
        for run, lost in self.port.lost_files.written(faults):
            self.port.say("kept", run=run, text="\n".join(lost))

    def _report(self, now: int) -> None:
        if now - self._reported < REPORTS_NS:
            return
        self._reported = now
        rows = [as_reported(row) for row in self.language.rows()]
        report: dict[str, object] = {"id": self.run_id, "fresh": self._fresh, "programs": self._catalogue, "processes": rows}
        report.update(self.programs.seen(now))
        payload = pack_report(report)
        if payload != self._shown:
            self._shown = payload
            self.region.write(payload, now)


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate interpreter", description="the interpreter process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    go_ahead()  # like the planner: synchronous tasks begin with the period, whatever else needs the processor
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    plan = load_plan(arguments.plan)
    try:
        InterpreterProcess(plan, fds_from_text(arguments.fds)).run()
    except KeyboardInterrupt:
        return 0
    except OSError as error:
        print(f"{error.filename or 'programs'} cannot be read: {error.strerror}; it is tried again")
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
