"""A whole run as real processes: `axisgate run CELL --sim` in a runtime folder of its own, PLC 2 that commands it, and its witnesses."""

import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any

from drivers.emulator.servo.record import Record
from drivers.emulator.servo.record import read as read_record
from drivers.ports.base import PortError
from gateway.cell_file.load import load_cell
from gateway.commands.run import SLOW_P5
from gateway.pure.image.records.cell import CellState, unpack_cell_state
from gateway.runtime.realtime import realtime_allowed
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask, wait_up
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.judges.judge import Judge, Move
from hil_tests.lab.partners.plc2 import (
    ABORTED,
    ACCEPTED,
    AXES,
    COMMAND_AT,
    DONE,
    ENABLE,
    OVERRIDE,
    PTP,
    REFERENCE,
    REFUSED,
    REQUEST,
    RESET,
    RUNNING,
    ModbusPlc,
    Status,
)

ALL = 0x3F
REALTIME = realtime_allowed()
# Every rule under test counts in P5; a shared machine steals 5 ms now and then, which two of these forgive.  Slower where a run is
# played again (hil_tests/host.py).
P5_MS = int(os.environ.get("AXISGATE_TEST_P5", "8" if REALTIME else "10"))
P5_NS = P5_MS * 1_000_000
HOME = (10.0, 10.0, 5.0, 0.0, 0.0, 0.0)  # mm and deg: where referencing ends
TARGET = (70.0, 70.0, 33.0, 8.0, 8.0, 8.0)  # near it, so that referencing again is short
SETTLE_S = 0.3  # ten time constants of the position loops and more
PLC_PRIORITY = 10  # below the line process
SPARE = 6  # repetitions of one run that a busy machine may spoil
COMES_UP_S = 60.0
DRIVES_OFF, RESYNCHRONISED, LINK_LOST, INPUT_LOST = 2, 20, 21, 26  # reasons; the last three: PLC 2 was not served in time
KEPT_ROWS = 500
STOLEN = (16, 17, 18, 27, 44)  # reasons: drive fault, drive lost, following error, overrun, machine late


class Disturbed(Exception):
    """The machine took the processor away before the test did anything: this repetition proves nothing and is repeated."""


def spare_of(times: int) -> int:
    """So many repetitions more may be spoilt."""
    return max(SPARE, times // 5)


def patience_s(repetition_s: float, times: int = 1) -> float:
    """Time-out of a test that repeats: the run comes up, all that count and all that may be spoilt last so long, getting ready again
    included.  So a busy machine ends in the words of `_spoilt` or in a good repetition."""
    return COMES_UP_S + repetition_s * (1 + times + spare_of(times))  # 1: `ready` before the first


class CyclicPlc(ModbusPlc):
    """Writes its whole command block in every cycle, as a PLC with a cyclic image does: whatever it commanded last goes on standing."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._standing: list[int] = []
        self.polls = threading.Event()
        self.polls.set()
        self.running = False

    @property
    def toggle(self) -> bool:
        """Of the last command sent."""
        return self._toggle

    def start(self) -> None:
        self.running = True
        super().start()

    def _run(self) -> None:
        """A PLC is a machine of its own: what else runs on this one does not make it silent."""
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(PLC_PRIORITY))  # this thread alone
        super()._run()

    def _cycle(self) -> None:
        if not self.polls.wait(0.1):
            self.status = None
            return
        if self._standing and self._client.connected:
            self._client.write_registers(COMMAND_AT, self._standing)
        super()._cycle()

    def send(
        self, code: int, mask: int = 0, velocity: float = 1.0, targets: Sequence[float] | bytes = (), acceleration: float = 1.0
    ) -> None:
        self._standing = []  # or the old block, its toggle now the other one, would be a fresh command
        super().send(code, mask, velocity, targets, acceleration)
        with self._lock:
            answer = self._client.read_holding_registers(COMMAND_AT, count=4 + 2 * AXES)
        if not answer.isError():
            self._standing = list(answer.registers)


def free_port() -> int:
    """A TCP port of loopback that nobody has now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        number: int = probe.getsockname()[1]
        return number


class CellRun:
    """One run; made by `running_cell`."""

    def __init__(self, folder: pathlib.Path, cell: str, name: str, p5_ms: int | None = P5_MS, more: Sequence[str] = ()) -> None:
        """`p5_ms` None: the product's choice, where simulated time waits for a late machine (AX-681, AX-915)."""
        self.folder, self.cell, self.name = folder, cell, name
        self.demo = load_cell(cell)
        self.p5_ms = p5_ms or (self.demo.cycle_ms if REALTIME else max(SLOW_P5, self.demo.cycle_ms))
        self.more = more if p5_ms is None else ("--p5", str(p5_ms), *more)
        self.port = free_port()
        self.process = self._start()
        self._log_at = self._record_from = 0
        self._log: list[buslog.Logged | buslog.Remark] = []
        self.plc = CyclicPlc("127.0.0.1", self.port)
        self.disturbed = 0

    def _start(self) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", "gateway", "run", self.cell, "--sim", "--name", self.name]
        command += ["--modbus-port", str(self.port), "--record", str(self.folder), "--die-with-parent", *self.more]
        with (self.folder / "run.log").open("ab") as log:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        until = time.monotonic() + COMES_UP_S
        try:
            while not wait_up(self.name, 1.0):
                if process.poll() is not None or time.monotonic() > until or self._dies_again():
                    raise AssertionError(f"the run did not come up:\n{self.words()}")
        except BaseException:  # a run left behind would take its processor from all tests that follow
            process.kill()
            process.wait()
            raise
        return process

    def _dies_again(self) -> bool:
        with contextlib.suppress(PortError, TimeoutError):  # on a busy machine its answer takes longer than its socket waits
            return any(process["restarts"] > 1 for process in self.processes().values())
        return False

    def stop(self, number: int = signal.SIGTERM) -> int:
        """Orderly; its exit code."""
        if self.plc.running:
            self.plc.running = False
            self.plc.stop()
        if self.process.poll() is None:
            self.process.send_signal(number)
            try:
                self.process.wait(15)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
                raise AssertionError(f"the run did not end:\n{self.words()}") from None
        return self.process.returncode

    # ---- what its tools see ------------------------------------------------------------------------------------------
    def words(self) -> str:
        """The last lines it printed."""
        return "\n".join((self.folder / "run.log").read_text(errors="replace").splitlines()[-25:])

    def status(self) -> dict[str, Any]:
        with ask(self.name, "status") as connection:
            found: dict[str, Any] = json.loads(connection.makefile().readline())
            return found

    def processes(self) -> dict[str, dict[str, Any]]:
        """Name -> pid, state, restarts, spare, life_age_ms."""
        return {process["name"]: process for process in self.status()["processes"]}

    def pid(self, process: str) -> int:
        pid = self.processes()[process]["pid"]
        assert isinstance(pid, int), f"{process} is not up\n{self.words()}"
        return pid

    def journal(self, kind: str | None = None) -> list[dict[str, Any]]:
        lines = pathlib.Path(self.status()["folder"], "journal.jsonl").read_text().splitlines()
        entries = [json.loads(line) for line in lines]
        return [entry for entry in entries if kind in (None, entry["kind"])]

    def state(self) -> CellState:
        """What the cycle published last."""
        fds: dict[str, int] = {}
        try:
            with ask(self.name, "regions") as connection:
                fds = recv_fds(connection)
            payload = RegionReader(fds["axes"], "axes").read()
            assert payload is not None
            return unpack_cell_state(payload)
        finally:
            for fd in fds.values():
                os.close(fd)

    # ---- deaths ------------------------------------------------------------------------------------------------------
    def kill(self, process: str, number: int = signal.SIGKILL) -> tuple[int, int]:
        """(pid, stamp just before)."""
        pid, stamp = self.pid(process), time.monotonic_ns()
        os.kill(pid, number)
        return pid, stamp

    def back(self, process: str, dead: int, timeout_s: float = 10.0) -> int:
        """Stamp when it is up again with another pid and, if it has one, a fresh life."""
        until, seen = time.monotonic() + timeout_s, 0
        while time.monotonic() < until:
            found = self.processes()[process]
            age = found["life_age_ms"]
            if found["state"] == "up" and found["pid"] != dead:
                now = time.monotonic_ns()
                seen = seen or now
                if age is None or now - age * 1e6 > seen:  # a beat of the new one, not the last of the old
                    return now
            time.sleep(0.02)
        raise AssertionError(f"{process} did not come back within {timeout_s} s\n{self.words()}")

    def spare(self, process: str, not_these: Collection[int] = (), timeout_s: float = 30.0) -> int:
        """Pid of what stands by for it, as soon as there is one."""
        until = time.monotonic() + timeout_s
        while time.monotonic() < until:
            found = self.processes()[process]["spare"]
            if found is not None and found not in not_these:
                return int(found)
            time.sleep(0.02)
        raise AssertionError(f"no spare of {process} within {timeout_s} s\n{self.words()}")

    def hold(self, process: str) -> None:
        """It is ended and stays away until it is forgiven."""
        self._say("hold", process)

    def forgive(self, process: str) -> None:
        """Its deaths are forgotten, as after a repair: the next one is the first one again."""
        self._say("release", process)

    def _say(self, op: str, process: str) -> None:
        with ask(self.name, op, process=process) as connection:
            assert json.loads(connection.makefile().readline()) == {"ok": True}

    # ---- witnesses ---------------------------------------------------------------------------------------------------
    def record(self) -> Record:
        """What the emulated axes really did, up to now."""
        with contextlib.suppress(PortError):  # it is not up: then nothing waits
            control = EmulatorControl(f"{self.name}-drives")
            control.ask("flush")
            control.close()
        with (self.folder / "emulator-drives.rec").open("rb") as file:
            head = file.readline()
            file.seek(len(head) + self._record_from)
            return read_record(head + file.read())

    def forget(self) -> None:
        """What the witnesses saw up to here is not read again, but for the last rows of the record: reading minutes of it takes so
        long that PLC 2, a thread of this process, would be silent meanwhile."""
        self._log = [entry for entry in self.bus() if isinstance(entry, buslog.Remark)]
        with (self.folder / "emulator-drives.rec").open("rb") as file:
            head = file.readline()
            whole = (os.fstat(file.fileno()).st_size - len(head)) // (size := json.loads(head)["row_bytes"])
        self._record_from = max(0, whole - KEPT_ROWS) * size

    def bus(self) -> list[buslog.Logged | buslog.Remark]:
        """The broker's log, as far as it is written (it hands over batches: some frames may be on their way)."""
        data = (self.folder / "bus-drives.log").read_bytes()[self._log_at :]
        whole = data[: data.rfind(b"\n") + 1]
        self._log_at += len(whole)
        self._log += buslog.read(whole.decode().splitlines(keepends=True))
        return self._log

    # ---- PLC 2 -------------------------------------------------------------------------------------------------------
    def command(self, code: int, mask: int = 0, velocity: float = 1.0, targets: Sequence[float] = ()) -> Status:
        """A command that is to be done; Disturbed when a drive or the clock gave up by itself meanwhile."""
        self.plc.send(code, mask, velocity, targets)
        ends = (DONE, REFUSED, ABORTED)
        status = self.plc.wait(lambda s: s.toggle == self.plc.toggle and (s.state in ends or s.reason == RESYNCHRONISED), 20.0)
        self._stolen(status)
        assert status.state == DONE, f"code {code}: {status}\n{self.words()}"
        return status

    def ready(self) -> None:
        """From whatever stands: control, drives on, referenced, override 100 %; again when the machine spoilt it."""
        while True:
            try:
                for code, mask in ((REQUEST, 0), (RESET, 0), (ENABLE, ALL), (REFERENCE, ALL), (OVERRIDE, 0)):
                    self.command(code, mask)
                self.plc.wait(lambda s: s.in_position == ALL, 10)
            except Disturbed as why:
                self._spoilt(why)
            else:
                return

    def under_way(self, velocity: float) -> int:
        """In the middle of the move from HOME to TARGET; stamp of its beginning."""
        start = time.monotonic_ns()
        self.plc.send(PTP, ALL, velocity, TARGET)
        time.sleep(0.4)
        status = self.plc.wait(lambda s: True, 2)
        self._stolen(status)
        assert status.state in (ACCEPTED, RUNNING), f"{status}\n{self.words()}"
        return start

    def _stolen(self, status: Status) -> None:
        """Disturbed when a drive or the clock gave up by itself: during this command, or after the one before."""
        if status.state in (ABORTED, REFUSED) and status.reason in STOLEN:
            raise Disturbed(f"the command ended by itself, reason {status.reason}")
        if status.reason == RESYNCHRONISED:
            raise Disturbed("PLC 2 itself was silent for so long that its link counted as lost")
        if status.reason == DRIVES_OFF and (cause := self.state().stop_cause) in (*STOLEN, LINK_LOST, INPUT_LOST):
            raise Disturbed(f"the drives went off since the command before, stop cause {cause}")

    def home_again(self) -> None:
        """A fresh move works, and it ends where it should: by the emulator's record."""
        self.command(PTP, ALL, 0.5, HOME)
        self.arrived(HOME)

    def arrived(self, target: tuple[float, ...]) -> None:
        """Return whether the mechanics are at the target."""
        time.sleep(SETTLE_S)
        now = time.monotonic_ns()
        missed = Judge(self.demo, self.record()).missed_by(Move(now, now, target, target))
        assert missed <= 2.0, f"{missed} increments beside the target"

    def repeat(self, times: int, body: Callable[[int], None], again: Callable[[], None]) -> None:
        """`times` repetitions that count; `again` brings the cell back to where body begins."""
        counted = self.disturbed = 0
        while counted < times:
            try:
                body(counted)
                counted += 1
            except Disturbed as why:
                self._spoilt(why, spare_of(times))
                again()

    def _spoilt(self, why: Disturbed, spare: int = SPARE) -> None:
        self.disturbed += 1
        if self.disturbed > spare:
            raise AssertionError(f"{self.disturbed} repetitions were spoilt by a busy machine, the last one by: {why}") from why


def left_over(folder: pathlib.Path) -> dict[int, str]:
    """Processes whose runtime folder lies in `folder`: pid -> command line.  Zombies and whoever asks are none."""
    wanted = f"AXISGATE_RUNTIME={folder}/run".encode()
    found = {}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if wanted in (process / "environ").read_bytes().split(b"\0"):
                found[int(process.name)] = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    return found


def gone(folder: pathlib.Path, timeout_s: float = 3.0) -> None:
    """No process of the run is left within that time, and with them no memory: a memfd lives as long as somebody holds it."""
    until = time.monotonic() + timeout_s
    while left := left_over(folder):
        assert time.monotonic() < until, f"left behind: {left}"
        time.sleep(0.02)


def special_files(folder: pathlib.Path) -> list[str]:
    """Sockets and links in the runtime folder."""
    return [path.name for path in sorted((folder / "run").rglob("*")) if path.is_socket() or path.is_symlink()]


@contextlib.contextmanager
def runtime_folder() -> Iterator[pathlib.Path]:
    """$AXISGATE_RUNTIME in a short temporary folder (a socket's path has 107 bytes), so that no two runs ever meet."""
    before = os.environ.get("AXISGATE_RUNTIME")
    with tempfile.TemporaryDirectory(prefix="axg-", dir="/tmp") as folder:
        os.environ["AXISGATE_RUNTIME"] = f"{folder}/run"
        try:
            yield pathlib.Path(folder)
        finally:
            if before is None:
                del os.environ["AXISGATE_RUNTIME"]
            else:
                os.environ["AXISGATE_RUNTIME"] = before


@contextlib.contextmanager
def running_cell(
    cell: str = "demo", name: str = "death", *, plc: bool = True, p5_ms: int | None = P5_MS, more: Sequence[str] = ()
) -> Iterator[CellRun]:
    """A run with PLC 2 polling (and synchronised), started with `more` options; ended in order afterwards."""
    with runtime_folder() as folder:
        run = CellRun(folder, cell, name, p5_ms, more)
        try:
            if plc:
                run.plc.start()
                run.plc.wait(lambda status: True, 10)
                run.plc.synchronise()
            yield run
        finally:
            code = run.stop()
        assert code in (0, -signal.SIGKILL), f"exit code {code}:\n{run.words()}"
