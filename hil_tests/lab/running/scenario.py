"""The scenario of `axisgate demo`: what both PLC programs do, in order, and when they did it; the verdicts come from elsewhere."""

import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from drivers.ports.base import PortError
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.image.reasons import Reason
from gateway.runtime.supervisor_client import ask, wait_up
from gateway.simulation.line.control import LineControl
from gateway.tools.command_support import BANNER
from hil_tests.lab.judges.judge import Move, Verdict
from hil_tests.lab.judges.verdicts import Story, machine_late, run_says_late, verdicts_of
from hil_tests.lab.partners import plc2 as modbus
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.partners.plc2 import ModbusPlc
from hil_tests.lab.running.show import Show

ALL = 0x3F
SETTLE_S = 0.4  # ten time constants of the position loops: what "at the target" means
KG_1200_5 = bytes.fromhex("0B4B0800")  # 1200.5 as S5 float


class ScenarioFailed(Exception):
    """The scenario could not be completed."""

    def __init__(self, text: str, code: int = 1, late: str = "") -> None:
        super().__init__(text)
        self.code = code
        self.late = late  # how the machine let the bus (by its log) or the cycle down, "" when it did not


class CycleLate(TimeoutError):
    """A move ended for a reason that nothing in this scenario gives but a machine that is too slow for its clock."""


def ended(text: str, reason: int) -> TimeoutError:
    return CycleLate(text) if reason in (Reason.DRIVE_LOST, Reason.OVERRUN) else TimeoutError(text)


class Scenario:
    """One run: start everything, play, stop everything, judge."""

    def __init__(self, folder: pathlib.Path, *, name: str, seed: int, p5_ms: int, bus: str | None, port: int | None, quiet: bool) -> None:
        self.folder, self.name, self.p5_ms, self.bus = folder, name, p5_ms, bus
        self.cell: Cell = load_cell("demo")
        self.port = port or free_port(self.cell.modbus[0].port)
        self.failed = False
        self._random = random.Random(seed)
        self._run: subprocess.Popen[bytes] | None = None
        self.story = Story()
        self._at = [axis.home.position + axis.home.offset for axis in self.cell.axis]
        self.show = Show(quiet=quiet)
        self._alarms, self._began_ns = pathlib.Path(), time.monotonic_ns()
        self._bus_clock_ns = 0  # add it to the bus log's stamps to get the monotonic clock
        self._candump: subprocess.Popen[bytes] | None = None
        self.plc1: S5Plc | None = None
        self.plc2: ModbusPlc | None = None

    def say(self, text: str) -> None:
        """Print one line of progress."""
        self.show.say(text)

    # ---- start and stop ----------------------------------------------------------------------------------------------
    def play(self) -> list[Verdict]:
        """Everything; ScenarioFailed when it cannot go on."""
        self.show.say(BANNER)
        self._start()
        try:
            for title, act in self._acts():
                self.show.step(title)
                act()
        except (TimeoutError, PortError, OSError, KeyError) as error:
            self.failed = True
            self._stop()
            late = self.machine_late() or (str(error) if isinstance(error, CycleLate) else "")
            raise ScenarioFailed(f"{self.show.title}: {error}\n{self._last_words()}", late=late) from error
        self.show.step("the records are judged")
        self._stop()
        verdicts = verdicts_of(self.cell, self.folder, self.story, self._bus_clock_ns)
        self.failed = not all(verdict.ok for verdict in verdicts)
        self.show.summary(verdicts)
        return verdicts

    def machine_late(self) -> str:
        """By the bus log, and by the run's own alarms: what the machine let be late, in words; empty: nothing."""
        return machine_late(self.folder / "bus-drives.log", self.p5_ms) or run_says_late(self._alarms, self._began_ns)

    def close(self) -> None:
        """End whatever is still running; twice does no harm."""
        self._stop()
        self.show.close()

    def _record_bus(self) -> None:
        """Record a kernel bus, which has no broker to keep a log, by Debian's candump (wall-clock stamps)."""
        if self.bus is None or not self.bus.startswith("socketcan:"):
            return
        if shutil.which("candump") is None:
            raise ScenarioFailed("candump is missing: install can-utils (make test and make demo do it as root)", 3)
        self._bus_clock_ns = time.monotonic_ns() - time.time_ns()
        self._log = (self.folder / "bus-drives.log").open("wb")
        command = ["candump", "-L", self.bus.partition(":")[2]]
        self._candump = subprocess.Popen(command, stdout=self._log, start_new_session=True)

    def _start(self) -> None:
        self._record_bus()
        command = [
            sys.executable,
            "-m",
            "gateway",
            "run",
            "demo",
            "--sim",
            "--die-with-parent",
            "--name",
            self.name,
            "--p5",
            str(self.p5_ms),
        ]
        command += ["--modbus-port", str(self.port), "--record", str(self.folder), *(("--bus", self.bus) if self.bus else ())]
        with (self.folder / "run.log").open("wb") as log:
            self._run = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        if not wait_up(self.name, 60.0):
            code = 3 if self._run.poll() is not None else 1
            raise ScenarioFailed("the run did not come up:\n" + self._last_words(), code)
        self._alarms = pathlib.Path(self._status()["journal"]).with_name("alarms.jsonl")
        self.plc1 = S5Plc(LineControl.path(f"{self.name}-plc1", "a"), [axis.name for axis in self.cell.axis])
        self.plc2 = ModbusPlc("127.0.0.1", self.port)
        self.show.watch(self.cell, self.plc1, self.plc2)
        self.plc1.start()
        self.plc2.start()

    def _stop(self) -> None:
        for plc in (self.plc1, self.plc2):
            if plc is not None:
                plc.stop()
        self.show.unwatch()
        dump, self._candump = self._candump, None
        if dump is not None:
            dump.terminate()
            dump.wait()
            self._log.close()
        run, self._run = self._run, None
        if run is None or run.poll() is not None:
            return
        run.terminate()
        try:
            run.wait(15)
        except subprocess.TimeoutExpired:
            run.kill()
            run.wait()

    def _last_words(self) -> str:
        with contextlib.suppress(OSError):
            return "\n".join((self.folder / "run.log").read_text(errors="replace").splitlines()[-15:])
        return ""

    # ---- the acts ----------------------------------------------------------------------------------------------------
    def _acts(self) -> list[tuple[str, Callable[[], None]]]:
        return [
            ("PLC 1 (3964R, RK512) and PLC 2 (Modbus TCP) connect", self._connect),
            ("both request control: PLC 1 gets it, PLC 2 is refused", self._both_ask),
            ("PLC 1 references six axes", self._reference),
            ("PLC 1 drives its path, targets in KF at 0.1 mm", self._path_1),
            ("the line is unplugged in the middle of a move, and plugged again", self._unplug),
            ("PLC 1 sends a KG number instead of REAL", self._wrong_format),
            ("PLC 1 releases control to PLC 2", self._hand_over),
            ("PLC 2 drives its path with the command block", self._path_2),
            ("PLC 2 stops on the path and resumes", self._stop_and_resume),
            ("PLC 2 changes the override in the middle of a move", self._override),
            ("services are killed while PLC 1's start bit is set", self._kill_services),
            ("PLC 1 requests control again, moves once more and switches off", self._again),
        ]

    @property
    def _one(self) -> S5Plc:
        assert self.plc1 is not None
        return self.plc1

    @property
    def _two(self) -> ModbusPlc:
        assert self.plc2 is not None
        return self.plc2

    def _connect(self) -> None:
        self._two.wait(lambda s: True, 10)
        self._two.synchronise()
        self._one.word(1, 100)  # override 100 %
        self._one.word(8, 100)  # speed 100 %
        self._one.wait(lambda s: s.bit(0, 0), 10, "cell ready")
        self._one.wait_cycles(2)

    def _both_ask(self) -> None:
        self._one.bit(0, 0, True)
        self._one.wait(lambda s: s.bit(0, 4), 10, "control")
        refused = self._two.command(modbus.REQUEST)
        self.story.facts["refused reason"], self.story.facts["owner"] = refused.reason, refused.owner
        self._one.wait(lambda s: s.bit(0, 3), 10, "drives on")

    def _reference(self) -> None:
        self._one.pulse(0, 3)
        self._one.wait(lambda s: s.bit(0, 1), 40, "all axes referenced")
        self._two.wait(lambda s: s.in_position == ALL, 10)
        time.sleep(SETTLE_S)

    def _path_1(self) -> None:
        for _ in range(3):
            self._move_1(self._target(0.1, 0.9), speed=100)

    def _move_1(self, target: list[float], *, speed: int) -> None:
        """One move by start, busy, done; the start bit falls when done was seen."""
        self._begin_1(target, speed)
        self._end_1(target)

    def _begin_1(self, target: list[float], speed: int) -> None:
        plc = self._one
        plc.bit(0, 8, False)
        plc.wait_cycles(2)  # the falling edge has to be on the line before the next rising one
        plc.wait(lambda s: not s.bit(0, 9) and not s.bit(0, 8), 10, "done and busy off")
        for n, value in enumerate(target):
            plc.word(2 + n, round(value * 10))
        plc.word(8, speed)
        self._start_ns = time.monotonic_ns()
        plc.bit(0, 8, True)
        plc.wait(lambda s: s.bit(0, 8) or s.bit(0, 9) or s.bit(0, 15), 10, "busy")

    def _end_1(self, target: list[float]) -> None:
        self._one.wait(lambda s: s.bit(0, 9) or s.bit(0, 15), 30, "done")
        if self._one.status.bit(0, 15):
            reason = self._one.status.word(1)
            raise ended(f"PLC 1's move was refused or aborted, reason {reason}", reason)
        self._arrived("plc1", target)

    def _arrived(self, who: str, target: list[float]) -> None:
        time.sleep(SETTLE_S)
        self.story.moves.append((who, Move(self._start_ns, time.monotonic_ns(), tuple(self._at), tuple(target))))
        self._at = list(target)

    def _unplug(self) -> None:
        target = self._far()
        self._begin_1(target, 15)
        time.sleep(0.6)
        with LineControl(f"{self.name}-plc1") as cable:
            self.story.events["unplug"] = cable.unplug()
            time.sleep(4.0)
            self.story.events["plug"] = cable.plug()
            cycles = self._one.cycles
            self._one.wait(lambda s: self._one.cycles >= cycles + 3, 10, "the line to work again")
            time.sleep(1.0)
            self.story.events["resume"] = time.monotonic_ns()
            cable.status()
        self._one.pulse(0, 5)
        self._end_1(target)

    def _wrong_format(self) -> None:
        plc = self._one
        plc.bit(0, 8, False)
        plc.wait(lambda s: not s.bit(0, 9), 10, "done off")
        before = time.monotonic_ns()
        start = (plc.word_value(0) | 0x0100).to_bytes(2, "big")
        plc.send((12, 0, KG_1200_5), (10, 0, start))  # the start bit alone: the targets stay as they stand
        plc.wait(lambda s: s.bit(0, 15), 10, "refused")
        self.story.facts["format reason"] = plc.status.word(1)
        self.story.events["format"], self.story.events["format end"] = before, time.monotonic_ns()
        journal = (pathlib.Path(self._status()["folder"]) / "journal.jsonl").read_text()
        self.story.facts["format words"] = float("looks like KG read as IEEE" in journal)
        plc.bit(0, 8, False)
        plc.wait_cycles(2)

    def _hand_over(self) -> None:
        self._one.bit(0, 0, False)
        self._one.wait(lambda s: not s.bit(0, 3) and not s.bit(0, 4), 10, "drives off and control given back")
        two = self._two
        for code, mask in ((modbus.REQUEST, 0), (modbus.OVERRIDE, 0), (modbus.ENABLE, ALL)):
            self._must(two.command(code, mask))
        self._at = [two.wait(lambda s: True, 5).actual[n] for n in range(6)]
        # The brake may have let the axes settle: the path is judged from where the set values start, so drive to known places first
        self._move_2(self._target(0.3, 0.4), judged=False)

    def _path_2(self) -> None:
        for _ in range(2):
            self._move_2(self._target(0.1, 0.9))

    def _move_2(self, target: list[float], *, judged: bool = True) -> None:
        self._start_ns = time.monotonic_ns()
        self._must(self._two.command(modbus.PTP, ALL, 1.0, target))
        if judged:
            self._arrived("plc2", target)
        else:
            time.sleep(SETTLE_S)
            self._at = list(target)

    def _stop_and_resume(self) -> None:
        target = self._far()
        self._start_ns = time.monotonic_ns()
        self._two.send(modbus.PTP, ALL, 0.8, target)
        time.sleep(0.7)
        self._must(self._two.command(modbus.STOP))
        self.story.events["stopped"] = time.monotonic_ns()
        time.sleep(0.5)
        self._must(self._two.command(modbus.RESUME))
        self._arrived("stop", target)

    def _override(self) -> None:
        target = self._far()
        self._start_ns = time.monotonic_ns()
        self._two.send(modbus.PTP, ALL, 1.0, target)
        for share in (0.3, 1.0, 0.55, 1.0):
            time.sleep(0.35)
            self._must(self._two.command(modbus.OVERRIDE, 0, share))
        self._two.wait(lambda s: s.in_position == ALL and abs(s.actual[0] - target[0]) < 0.5, 20)
        self._arrived("override", target)

    def _kill_services(self) -> None:
        two = self._two
        for code, mask in ((modbus.DISABLE, ALL), (modbus.RELEASE, 0)):
            self._must(two.command(code, mask))
        one = self._one
        one.bit(0, 0, True)
        one.wait(lambda s: s.bit(0, 3) and s.bit(0, 4), 10, "drives on and control")
        target = self._target(0.2, 0.8)
        self._begin_1(target, 60)
        one.wait(lambda s: s.bit(0, 9) or s.bit(0, 15), 30, "done")
        time.sleep(SETTLE_S)
        self._at = list(target)
        pid = self._pid("services")
        cycles = one.cycles
        self.story.events["kill"] = time.monotonic_ns()
        os.kill(pid, signal.SIGKILL)
        one.wait(lambda s: self._pid("services") not in (pid, 0), 20, "services to be started again")
        born = time.monotonic_ns()
        one.wait(lambda s: self._beaten_since("services", born), 20, "services to be back")
        back = time.monotonic_ns()
        one.wait(lambda s: one.cycles >= cycles + 2, 20, "the line to work again")
        two.wait(lambda s: True, 10)
        self.story.facts["services back"] = (back - self.story.events["kill"]) / 1e9
        self.story.facts["links back"] = (time.monotonic_ns() - back) / 1e9
        time.sleep(1.5)
        self.story.events["kill end"] = time.monotonic_ns()

    def _again(self) -> None:
        one = self._one
        one.bit(0, 0, False)
        one.wait_cycles(3)
        one.bit(0, 0, True)
        one.wait(lambda s: s.bit(0, 3) and s.bit(0, 4), 10, "drives on and control")
        self._move_1(self._target(0.1, 0.9), speed=100)
        one.bit(0, 8, False)
        one.bit(0, 0, False)
        one.wait(lambda s: not s.bit(0, 3), 10, "drives off")

    # ---- helpers -----------------------------------------------------------------------------------------------------
    def _target(self, low: float, high: float) -> list[float]:
        """Seeded targets on the 0.1 grid the KF numbers have."""
        return [round(a.limits.min + (a.limits.max - a.limits.min) * self._random.uniform(low, high), 1) for a in self.cell.axis]

    def _far(self) -> list[float]:
        """The far side of every axis, so that the move lasts."""
        middle = [(a.limits.min + a.limits.max) / 2 for a in self.cell.axis]
        low, high = self._target(0.05, 0.12), self._target(0.88, 0.95)
        return [low[n] if self._at[n] > middle[n] else high[n] for n in range(len(middle))]

    def _must(self, status: modbus.Status) -> None:
        if status.state != modbus.DONE:
            raise ended(f"PLC 2's command ended with state {status.state}, reason {status.reason}", status.reason)

    def _status(self) -> dict[str, Any]:
        connection = ask(self.name, "status")
        with connection:
            answer: dict[str, Any] = json.loads(connection.makefile().readline())
        return answer

    def _beaten_since(self, process: str, stamp_ns: int) -> bool:
        """Whether its life counter is younger than the stamp; the region still shows what the dead one wrote last."""
        now = time.monotonic_ns()
        found = next(p for p in self._status()["processes"] if p["name"] == process)
        return bool(found["life_age_ms"] * 1e6 < now - stamp_ns)

    def _pid(self, process: str) -> int:
        found = [p["pid"] for p in self._status()["processes"] if p["name"] == process]
        return int(found[0] or 0)


def free_port(preferred: int) -> int:
    """The cell's port where it is free, else any."""
    for port in (preferred, 0):
        with contextlib.suppress(OSError), socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(("127.0.0.1", port))
            number: int = probe.getsockname()[1]
            return number
    raise ScenarioFailed("no free TCP port on loopback", 3)
