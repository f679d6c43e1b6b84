"""The process of a Reis' integrated PLC: a scan each interpolation period (AX-900).

Only this process writes its region: markers, timers and counters, outputs.  Writes of command sources and tools arrive by a ring and are
applied between two scans.  After a kill it restarts with the program copy that ran, its markers and its times; outputs are 0 until its
first complete scan.
"""

import argparse
import contextlib
import pathlib
import select
import signal
import threading
import time
import zlib
from dataclasses import replace

from gateway.assembly.integrated_plc import kept_file, start_program
from gateway.assembly.program_memory import plc_folder
from gateway.assembly.run import RunPlan, load_plan
from gateway.files.plc_programs import ProgramFileFault, read_programs
from gateway.files.safe_file import write_whole
from gateway.pure.controllers.reis.markers import ERROR_NUMBER, IN_ERROR, merged
from gateway.pure.image.records.cell import InputImage, Quality, unpack_inputs
from gateway.pure.image.records.interpreter import TEXT_LAYOUT, Fact, pack_facts, unpack_facts
from gateway.pure.image.records.plc import (
    AREA,
    MARKERS,
    PLC_LAYOUT,
    ROBOT_LAYOUT,
    SHOWN_LAYOUT,
    PlcReport,
    PlcShown,
    pack_plc,
    pack_shown,
    shown_of,
    unpack_plc,
    unpack_robot,
)
from gateway.pure.languages.plc.messages import Message
from gateway.pure.languages.plc.plc import TICK_NS, Plc, PlcState, Settings
from gateway.pure.languages.plc.state import TimeError
from gateway.runtime.journal import Journal
from gateway.runtime.realtime import Timerfd, die_with_parent
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter, fds_from_text

TAKEN = 256  # orders a period
GO_ON = 20_000  # commands a scan may run before the clock is read again
KEEP_NS = 500_000_000  # interval for writing changed retained data
SHOW_NS = 100_000_000  # the test display likewise


class Keeper:
    """Writes the newest retained data; a slow disk delays no other part."""

    def __init__(self, path: pathlib.Path | None, journal: Journal) -> None:
        self._path, self._journal = path, journal
        self._waiting: bytes | None = None
        self._change = threading.Condition()
        self._closing = self._failing = False
        self._thread = threading.Thread(target=self._work, name="keeper", daemon=True)
        if path is not None:
            self._thread.start()

    def read(self) -> bytes:
        """Data of the last run; b"": none."""
        if self._path is None:
            return b""
        try:
            return self._path.read_bytes()
        except FileNotFoundError:
            return b""
        except OSError as error:
            self._journal.write("alarm", f"{self._path}: {error.strerror}; markers of the PLC start at 0")
            return b""

    def keep(self, data: bytes) -> None:
        """The data as they are now."""
        with self._change:
            self._waiting = data
            self._change.notify()

    def close(self) -> None:
        """Write the waiting data."""
        with self._change:
            self._closing = True
            self._change.notify()
        if self._thread.is_alive():
            self._thread.join(5.0)

    def _work(self) -> None:
        while True:
            with self._change:
                while self._waiting is None and not self._closing:
                    self._change.wait()
                data, self._waiting = self._waiting, None
            if data is None:
                return
            self._write(data)

    def _write(self, data: bytes) -> None:
        assert self._path is not None
        try:
            write_whole(self._path, data)
        except OSError as error:
            if not self._failing:
                self._journal.write("alarm", f"{self._path}: {error.strerror}; markers of the PLC are not retained at power-off now")
            self._failing = True
            return
        if self._failing:
            self._journal.write("retain", f"{self._path}: markers of the PLC are kept again")
        self._failing = False


class PlcProcess:
    """One run's integrated PLC."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        controller, folder = plan.cell.controller, plc_folder(plan.cell)
        assert controller is not None and controller.plc is not None and folder is not None  # this process exists only with them
        self.plan, self.folder, self.table = plan, folder, controller.plc
        self.journal = Journal(plan.journal, "plc")
        self.region = RegionWriter(fds["plc"], "plc", PLC_LAYOUT)
        self.robot = RegionReader(fds["plc-robot"], "plc-robot", ROBOT_LAYOUT)
        self.shown = RegionWriter(fds["plc-shown"], "plc-shown", SHOWN_LAYOUT)
        self.inputs = RegionReader(fds["rc_in"], "rc_in")
        self.orders = RingReader(fds["plc-orders"], "plc-orders", TEXT_LAYOUT)
        self.says = RingWriter(fds["plc-says"], "plc-says", TEXT_LAYOUT)
        self.run_id = time.monotonic_ns()
        self.sources: dict[str, str] = {}
        self._scan_begun = 0
        self.plc = Plc(self.sources, Settings(self.table.load, self.table.watchdog, self._more))
        self._first, self._stop = controller.first_byte, False
        self._copy = plan.folder / "plc.copy"
        self._state = PlcState.STOP
        self.keeper = Keeper(kept_file(plan), self.journal)
        self._kept, self._kept_ns = b"", 0
        self._shown, self._shown_ns = PlcShown(), 0
        self.shown.write(pack_shown(self._shown), self.run_id)  # discard what an earlier process showed
        self._begin()

    # ---- start ---------------------------------------------------------------------------------------------------------
    def _begin(self) -> None:
        """After a death the copy that ran, with its markers; else the start program with the retained data."""
        last, now = self.region.latest(), time.monotonic_ns()
        before = None if last is None else unpack_plc(last)
        if before is not None:  # before anything slow
            gone = replace(before, id=self.run_id, running=False, outputs=bytes(AREA), written=bytes(AREA))
            self.region.write(pack_plc(gone), now)
        self._read_sources()
        if before is not None:
            self._come_back(before, now)
            return
        kept = self.keeper.read()
        if kept:
            try:
                self.plc.power_on(kept, now)
            except ValueError as error:
                self.journal.write("alarm", f"markers of the PLC: {error}; they start at 0")
        self._start(self._named())

    def _come_back(self, before: PlcReport, now: int) -> None:
        self.plc.data.memory[:MARKERS] = before.markers
        self.plc.data.cells.now = now
        self.plc.data.cells.restore(before.cells)
        if not before.running:
            return
        try:
            copy = self._copy.read_bytes()
        except OSError as error:
            self.journal.write("alarm", f"{self._copy}: {error.strerror}; the PLC stays stopped: start it again")
            return
        if not self.plc.start_copy(copy):
            self.journal.write("plc", "the PLC process had failed and continues with the program that ran")

    def _read_sources(self) -> None:
        """The programs as they are on the disk now; a folder that cannot be read leaves those of before."""
        try:
            found = read_programs(self.folder)
        except (ProgramFileFault, OSError) as error:
            self.journal.write("alarm", f"PLC programs: {error}")
            return
        self.sources.clear()
        self.sources.update(found)

    def _named(self) -> str:
        """The start program: _SPLC_PATH and _SSTARTPLC (L2371-2394); empty: there is to be none."""
        try:
            name = start_program(self.plan.cell)
        except (ValueError, OSError) as error:
            self.journal.write("alarm", f"PLC: _SPLC_PATH or _SSTARTPLC: {error}; {self.table.start} is started")
            return self.table.start
        if not name:
            self.journal.write("plc", "_SSTARTPLC begins with a blank: no PLC program is started")
        return name

    def _start(self, name: str) -> None:
        if not name or self.plc.start(name):
            return
        try:
            write_whole(self._copy, self.plc.copy(), 0o600)
        except OSError as error:
            self.journal.write("alarm", f"{self._copy}: {error.strerror}; the PLC would not restart after a failure of its process")

    # ---- periods -------------------------------------------------------------------------------------------------------
    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._on_signal)
        timer = Timerfd()
        period = self.plan.p5_ms * 1_000_000
        timer.set(time.monotonic_ns() + period, period)
        while not self._stop:
            select.select([timer], (), ())
            if timer.expired():
                self.turn()
        timer.close()
        self._keep(time.monotonic_ns())
        self.keeper.close()
        self.journal.close()

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def turn(self) -> None:
        """Orders, the robot's markers, one period, its results."""
        now = self._scan_begun = time.monotonic_ns()
        for _, data in self.orders.take(TAKEN):
            self._obey(unpack_facts(data))
        self._lay_in()
        self.plc.scan(now, self._read_inputs())
        self._report(now)
        self._show(now)
        if now - self._kept_ns >= KEEP_NS:
            self._keep(now)
        self.region.beat(time.monotonic_ns())

    def _more(self, routine: str, line: int) -> int:
        """A scan beyond its allowance continues while the watchdog allows it."""
        if time.monotonic_ns() - self._scan_begun >= self.table.watchdog * TICK_NS:
            raise TimeError(routine, line)
        return GO_ON

    def _obey(self, order: dict[str, Fact]) -> None:
        match order["do"]:
            case "write":
                for at, value in enumerate(bytes.fromhex(str(order["data"])), int(order["first"])):
                    self.plc.set_marker(at, value)
            case "bits":
                at, mask = int(order["byte"]), int(order["mask"])
                self.plc.set_marker(at, self.plc.data.memory[at] & ~mask | int(order["bits"]) & mask)
            case "output":
                self.plc.robot_output(int(order["byte"]), int(order["mask"]), int(order["bits"]))
            case "start":
                self._read_sources()
                self._start(str(order["name"]) or self._named())
            case "stop":
                self.plc.stop()
            case "ack":
                self.plc.acknowledge()
            case "watch":
                self.plc.watch(str(order["name"]))

    def _lay_in(self) -> None:
        """Markers of the system (robotstar 5.8), as the robot has them."""
        payload = self.robot.read()
        if payload is None:
            return
        side = unpack_robot(payload)
        memory, shown = self.plc.data.memory, self.plc.shown_message
        memory[:MARKERS] = merged(side.markers, bytes(memory[:MARKERS]))
        if shown is None or not shown.reaction:  # an error of the PLC's own is not covered by one of the robot
            byte, bit = IN_ERROR
            self.plc.set_bit(byte, bit, bool(side.markers[byte] >> bit & 1))
            memory[ERROR_NUMBER : ERROR_NUMBER + 4] = side.markers[ERROR_NUMBER : ERROR_NUMBER + 4]
        self.plc.drives = side.drives

    def _read_inputs(self) -> bytes:
        """The 40 bytes of the image; a byte without a living source reads 0."""
        payload = self.inputs.read()
        image = InputImage() if payload is None else unpack_inputs(payload)
        chosen = slice(self._first, self._first + AREA)
        pairs = zip(image.values[chosen], image.quality[chosen], strict=True)
        return bytes(0 if quality == Quality.BAD else value for value, quality in pairs)

    def _report(self, now: int) -> None:
        plc = self.plc
        for message in plc.take_messages():
            self._say(message)
        if plc.state is not self._state:
            self._state = plc.state
            self.journal.write("plc", f"PLC {plc.state.value}")
        report = PlcReport(
            self.run_id,
            plc.state is PlcState.RUN,
            plc.scans,
            bytes(plc.data.memory[:MARKERS]),
            plc.outputs,
            plc.outputs_written,
            plc.data.cells.kept(),
        )
        self.region.write(pack_plc(report), now)

    def _show(self, now: int) -> None:
        """Update the test display after a complete scan, a few times a second."""
        if now - self._shown_ns < SHOW_NS or (self.plc.scans == self._shown.scans and bool(self.plc.watched[0]) == bool(self._shown.name)):
            return
        steps = self.plc.display()
        name, text = self.plc.watched
        if name or self._shown.name:
            self._shown_ns = now
            self._shown = shown_of(name, zlib.crc32(text.encode()), self.plc.scans, steps)
            self.shown.write(pack_shown(self._shown), now)

    def _say(self, message: Message) -> None:
        facts: dict[str, Fact] = {"text": message.text, "number": message.number or 0, "reaction": message.reaction}
        self.says.put(pack_facts({**facts, "program": message.program, "step": message.step, "id": self.run_id}))

    def _keep(self, now: int) -> None:
        self._kept_ns = now
        data = self.plc.retained(now)
        if data != self._kept:
            self._kept = data
            self.keeper.keep(data)


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate plc process", description="the PLC process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(KeyboardInterrupt):
        PlcProcess(load_plan(arguments.plan), fds_from_text(arguments.fds)).run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
