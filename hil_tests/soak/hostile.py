"""`python -m hil_tests.soak.hostile [SECONDS [SEED]]`: a demo cell with page, Modbus server, 3964R line under everything hostile at once.

A flood on the bus, half requests, wrong passwords, floods of good ones, a full disk, cables pulled, processes killed.  Meanwhile the axes
move, and every few seconds they are stopped by the page, a tool or the PLC.  Afterwards the cell has to come back: drives on, a move that
ends where it should, the line served, the page open to its user, the journal written.  Exit code 1 when it did not.
"""

import contextlib
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from http.client import HTTPException

from pymodbus.exceptions import ModbusException

from drivers.ports.base import PortError
from gateway.pure.image.records.cell import Motion
from gateway.simulation.line.control import LineControl
from gateway.tools.client import ToolClient, ToolError
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.partners.plc2 import ABANDON, PTP, REQUEST, STOP
from hil_tests.lab.running.cell_running import ALL, HOME, P5_MS, TARGET, CellRun, Disturbed, free_port, running_cell
from hil_tests.lab.running.web_running import WebAsk

NAME = "hostile"
DISK_BYTES = 24 << 20
FULL_S = 4.0  # the disk is full for so long
KILLED = ("services", "line-plc1", "web", "services", "broker-drives", "web", "emulator-drives", "cycle")
KILL_EVERY_S, FULL_EVERY_S, STOP_EVERY_S = 14.0, 30.0, 6.0
STOPS_S = 4.0  # from the order to rest, without the time in which the machine gave no processor
ON_THE_WAY = ("this program", "web", "services", "cycle")  # of a stop
LATE_S = 0.5  # a stop that is reported as late
BACK_S = 90.0
LOADED_S, GROWTH_KB = 20.0, 40_000  # of one process, from then on
TROUBLE = (AssertionError, Disturbed, PortError, ToolError, ModbusException, HTTPException, OSError, ValueError, KeyError)


@dataclass
class Outcome:
    """What was found."""

    stops: dict[str, list[tuple[float, float]]] = field(default_factory=dict)  # way -> s until rest, s of it the machine's
    back: dict[str, float] = field(default_factory=dict)  # what came back afterwards -> s
    starved: Counter[str] = field(default_factory=Counter)  # process -> ms it wanted a processor and had none
    stolen_s: float = 0.0  # the host gave the processors to others
    wrong: list[str] = field(default_factory=list)
    did: Counter[str] = field(default_factory=Counter)
    killed: Counter[str] = field(default_factory=Counter)
    kept_from: Counter[str] = field(default_factory=Counter)  # moving, by what
    status_s: list[float] = field(default_factory=list)


class Siege:
    """The cell, who moves and stops it, and who kills and fills."""

    def __init__(self, run: CellRun, web: WebAsk, disk: pathlib.Path | None, seed: int) -> None:
        self.run, self.web, self.disk = run, web, disk
        self.random = random.Random(seed)
        self.found = Outcome()
        self.journal = pathlib.Path(str(run.status()["journal"]))
        self._ways = 0
        self._goal = TARGET
        self._memory: dict[int, tuple[float, int]] = {}  # pid -> when it was first seen, KB
        self._pids: dict[str, int] = {"this program": os.getpid()}
        self._starved: dict[int, float] = {}  # pid -> s, as counted last
        self._stolen_s = stolen_s()

    # ---- what is done to it
    def kill(self) -> None:
        name = KILLED[sum(self.found.killed.values()) % len(KILLED)]
        with contextlib.suppress(*TROUBLE):
            self.run.kill(name)
            self.found.killed[name] += 1

    def full(self) -> Iterator[None]:
        """The disk has no room until the generator goes on; without a disk of its own the journal's place takes nothing."""
        self.found.did["full disk"] += 1
        filler = (self.disk or self.journal.parent) / "filler"
        if self.disk is not None:
            with contextlib.suppress(OSError), filler.open("wb") as file:
                while True:
                    file.write(bytes(1 << 16))
        else:
            aside = self.journal.with_suffix(".aside")
            self.journal.rename(aside)
            self.journal.symlink_to("/dev/full")
        yield
        if self.disk is not None:
            filler.unlink(missing_ok=True)
        else:
            self.journal.unlink()
            aside.rename(self.journal)

    # ---- what it still has to do
    def moving(self, patience_s: float) -> bool:
        """The axes are under way, however often they have to be made ready again for it."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            try:
                self.run.disturbed = 0
                if self.run.state().motion is not Motion.RUNNING and not self._goes():
                    self._at_rest()
                    self.run.ready()
                    self._goes()
                if self.run.state().motion is Motion.RUNNING:
                    return True
            except TROUBLE as error:
                self.found.kept_from[f"{type(error).__name__}: {str(error).splitlines()[0][:80] if str(error) else ''}"] += 1
            time.sleep(0.2)
        return False

    def _goes(self) -> bool:
        """A move to the other place; what a stop has left of the last one is abandoned."""
        self._goal = HOME if self._goal == TARGET else TARGET
        if self.run.state().motion is Motion.STOPPED:
            self._at_rest()
        self.run.plc.send(PTP, ALL, 0.03, self._goal)
        time.sleep(0.5)
        return self.run.state().motion is Motion.RUNNING

    def _at_rest(self) -> None:
        """PLC 2 is in control, and nothing waits that a stop has left."""
        self.run.command(REQUEST)
        if self.run.state().motion is Motion.STOPPED:
            self.run.command(ABANDON)

    def stop(self) -> None:
        """By the page, a tool or the PLC in turn; the time until the cycle reports that nothing moves."""
        way = ("page", "tool", "plc")[self._ways % 3]
        self._ways += 1
        before, machine = time.monotonic(), self._kept_back()
        try:
            {"page": self._by_page, "tool": self._by_tool, "plc": self._by_plc}[way]()
            while self.run.state().motion not in (Motion.IDLE, Motion.STOPPED):
                took = time.monotonic() - before
                if took > STOPS_S and took - (late := self._machine_s(machine)) > STOPS_S:
                    words = f"{took:.1f} s, {late:.1f} s of it the machine's"
                    self.found.wrong.append(f"stopped by {way}: still {self.run.state().motion.name} after {words}")
                    return
                time.sleep(0.02)
        except TROUBLE as error:
            self.found.did[f"no stop by {way}: {type(error).__name__}"] += 1  # its process is being started again
            if self.up():
                self.found.wrong.append(f"stop by {way} while all processes were up: {error}")
            return
        took = time.monotonic() - before
        self.found.stops.setdefault(way, []).append((took, min(took, max(0.0, self._machine_s(machine)))))

    def _kept_back(self) -> dict[str, float]:
        """Seconds of this machine so far: processes on the way of a stop wanted a processor and had none, or the host took it away."""
        found = {name: starved_s(self._pids[name]) for name in ON_THE_WAY if name in self._pids}
        return {**found, "host": stolen_s()}

    def _machine_s(self, before: dict[str, float]) -> float:
        """Since then, of the one that waited longest: what several waited at the same time does not count twice."""
        return max((now - before[name] for name, now in self._kept_back().items() if name in before), default=0.0)

    def _by_page(self) -> None:
        status, told = self.web.ask("POST", "/api/stop", x_axisgate="1")
        if status != 200:
            raise OSError(f"the page answered {status} {told}")

    def _by_tool(self) -> None:
        client = ToolClient(NAME)
        try:
            client.ask("tool", code="stop")
        finally:
            client.close()

    def _by_plc(self) -> None:
        self.run.plc.send(STOP)

    def up(self) -> bool:
        """Nothing is being started again; also a witness that the supervisor reports."""
        before = time.monotonic()
        try:
            rows = self.run.processes().values()
        except TROUBLE as error:
            self.found.wrong.append(f"the supervisor does not report: {error}")
            return False
        self.found.status_s.append(time.monotonic() - before)
        for row in rows:
            if row["pid"] is not None:
                self._pids[row["name"]] = row["pid"]
                self.weigh(row["name"], row["pid"])
                self.starve(row["name"], row["pid"])
        return all(row["state"] == "up" and (row["life_age_ms"] or 0) < 500 for row in rows)

    def starve(self, name: str, pid: int) -> None:
        """Adds up, over all its lives, how long it waited for a processor."""
        now = starved_s(pid)
        self.found.starved[name] += round(1000 * max(0.0, now - self._starved.get(pid, 0.0)))
        self._starved[pid] = now
        self.found.stolen_s = stolen_s() - self._stolen_s

    def weigh(self, name: str, pid: int) -> None:
        """No process grows without an end."""
        with contextlib.suppress(OSError, StopIteration):
            lines = pathlib.Path(f"/proc/{pid}/status").read_text().splitlines()
            now = int(next(line for line in lines if line.startswith("VmRSS")).split()[1])
            since, first = self._memory.setdefault(pid, (time.monotonic(), now))
            if time.monotonic() - since < LOADED_S:
                self._memory[pid] = since, max(first, now)  # its modules and first pages
            elif now - first > GROWTH_KB:
                self.found.wrong.append(f"{name} has grown from {first} to {now} KB")
                self._memory[pid] = since, now

    def hold(self, seconds: float) -> None:
        """Until the time is over."""
        start = time.monotonic()
        kill, full, emptied = start + 3.0, start + 8.0, None
        while (now := time.monotonic()) < start + seconds:
            if now > kill:
                self.kill()
                kill = now + KILL_EVERY_S
            if now > full:
                emptied = self.full() if emptied is None else emptied
                alive = next(emptied, "empty")
                full, emptied = (now + FULL_S, emptied) if alive is None else (now + FULL_EVERY_S, None)
            if self.moving(STOP_EVERY_S):
                self.stop()
            self.up()
        if emptied is not None:
            next(emptied, None)

    # ---- afterwards
    def comes_back(self, plc1: S5Plc, headers: dict[str, str]) -> None:
        """Wait for every part, each within BACK_S; report what is missing."""
        with contextlib.suppress(PortError), LineControl(f"{NAME}-plc1") as cable:
            cable.calm()
            cable.plug()
        self._until("all processes are up", self.up)
        cycles = plc1.cycles
        self._until("PLC 1 is served on its line", lambda: plc1.cycles > cycles + 3)
        # its inputs are lost, and the drives off, as long as PLC 1 is silent
        self._until("PLC 2 moves the axes to their target", self._moves)
        self._until("the page answers its user", lambda: self.web.ask("GET", "/api/axes", **headers)[0] in (200, 404))
        self._until("the page says that it is well", lambda: self.web.ask("GET", "/api/health")[0] == 200)
        size = self._size()
        with contextlib.suppress(*TROUBLE):
            self.run.kill("line-plc1")
            self.found.killed["line-plc1"] += 1
        self._until("the journal is written", lambda: self._size() > size)

    def _moves(self) -> bool:
        self.run.disturbed = 0
        self._at_rest()
        self.run.ready()
        self.run.command(PTP, ALL, 0.5, TARGET)
        self.run.arrived(TARGET)
        self.run.home_again()
        return True

    def _size(self) -> int:
        return self.journal.stat().st_size if self.journal.is_file() else 0

    def _until(self, what: str, holds: Callable[[], bool]) -> None:
        why, begun = "", time.monotonic()
        while time.monotonic() < begun + BACK_S:
            try:
                if holds():
                    self.found.back[what] = time.monotonic() - begun
                    return
            except TROUBLE as error:
                why = f": {str(error)[:300]}"
            time.sleep(0.3)
        self.found.wrong.append(f"not within {BACK_S:.0f} s: {what}{why}")

    def judge(self) -> None:
        """What the journal and the console keep of the time."""
        console = (self.run.folder / "run.log").read_text(errors="replace")
        if "Traceback" in console:
            tail = [line for line in console[console.index("Traceback") :].splitlines() if "site-packages" not in line]
            self.found.wrong.append("a traceback:\n" + "\n".join(tail[:60]))
        for line in console.splitlines():
            if "showed no life" in line or "ended with exit code" in line or "failures in a minute" in line:
                self.found.wrong.append(f"a process ended by itself: {line}")


def starved_s(pid: int) -> float:
    """Seconds that threads of this process wanted a processor and had none.  Source: Documentation/scheduler/sched-stats.rst, schedstat."""
    waited = 0
    with contextlib.suppress(OSError):
        for thread in os.listdir(f"/proc/{pid}/task"):
            with contextlib.suppress(OSError):
                waited += int(pathlib.Path(f"/proc/{pid}/task/{thread}/schedstat").read_text().split()[1])
    return waited / 1e9


def stolen_s() -> float:
    """Seconds in which the host of a virtual machine gave its processors to others.  Source: proc(5), steal of stat."""
    first = pathlib.Path("/proc/stat").read_text().splitlines()[0].split()
    return int(first[8]) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def own_disk() -> Iterator[pathlib.Path | None]:
    """A small one for the state, where this user may mount; the run's journal and the page's data are on it."""
    with tempfile.TemporaryDirectory(prefix="axg-state-", dir="/tmp") as folder:
        options = ["-t", "tmpfs", "-o", f"size={DISK_BYTES}", "tmpfs", folder]
        mounted = subprocess.run(["mount", *options], capture_output=True, check=False).returncode == 0 if os.geteuid() == 0 else False
        before = os.environ.get("AXISGATE_STATE")
        os.environ["AXISGATE_STATE"] = folder
        try:
            yield pathlib.Path(folder) if mounted else None
        finally:
            if before is None:
                del os.environ["AXISGATE_STATE"]
            else:
                os.environ["AXISGATE_STATE"] = before
            if mounted:
                subprocess.run(["umount", "-l", folder], check=False)


def siege(seconds: float, seed: int = 1) -> Outcome:
    """The whole of it."""
    port = free_port()
    with own_disk() as disk, running_cell("demo", NAME, p5_ms=max(P5_MS, 10), more=("--web", str(port))) as run:
        web = WebAsk(port)
        plc1 = S5Plc(LineControl.path(f"{NAME}-plc1", "a"), [axis.name for axis in run.demo.axis])
        plc1.start()
        try:
            run.ready()
            headers = web.headers()
            held = Siege(run, web, disk, seed)
            command = [sys.executable, "-m", "hil_tests.soak.hostile_acts", "--name", NAME, "--web", str(port), "--modbus", str(run.port)]
            command += ["--seconds", str(seconds), "--seed", str(seed)]
            acts = subprocess.Popen(["nice", "-n", "5", *command], stdout=subprocess.PIPE, text=True)
            try:
                held.hold(seconds)
                did = acts.communicate(timeout=60)[0]
            finally:
                acts.kill()
                acts.wait()
            held.found.did.update(json.loads(did or "{}"))
            held.comes_back(plc1, headers)
            held.judge()
            return held.found
        finally:
            plc1.stop()


def report(found: Outcome, seconds: float) -> list[str]:
    """In words."""
    orders = sum(len(times) for times in found.stops.values())
    lines = [
        f"asked: {seconds:.0f} s of everything at once; each stop at rest within {STOPS_S:g} s; no process ends by itself, none grows by"
        f" {GROWTH_KB // 1000} MB, no traceback; afterwards each part back within {BACK_S:g} s",
        f"done to it: {', '.join(f'{name} {count}' for name, count in sorted(found.did.items()))}",
        f"killed: {', '.join(f'{name} {count}' for name, count in sorted(found.killed.items()))}",
        f"kept from moving: {'; '.join(f'{count} x {why}' for why, count in found.kept_from.most_common(8)) or 'never'}",
    ]
    for way, times in sorted(found.stops.items()):
        ordered = sorted(times)
        took, machine = ordered[-1]
        own = max(each - late for each, late in times)
        lines.append(
            f"stopped by {way}: {len(times)} times, median {ordered[len(times) // 2][0]:.2f} s, longest {took:.2f} s"
            f" ({machine:.2f} s of it the machine's), longest without the machine {own:.2f} s"
        )
    late = [took for times in found.stops.values() for took, _ in times if took > LATE_S]
    lines.append(f"came late: {len(late)} of {orders} stops took longer than {LATE_S:g} s")
    if found.status_s:
        lines.append(f"the supervisor reported {len(found.status_s)} times, at the latest after {max(found.status_s):.2f} s")
    lines += [f"back: {', '.join(f'{what} after {took:.1f} s' for what, took in found.back.items())}"] if found.back else []
    waited = ", ".join(f"{name} {count / 1000:.1f} s" for name, count in found.starved.most_common(6))
    lines.append(f"this machine: waited for a processor: {waited or 'nothing'}; taken away by its host: {found.stolen_s:.1f} s")
    return [*lines, *(f"WRONG: {words}" for words in found.wrong), f"{len(found.wrong)} things wrong"]


def main() -> int:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 600.0
    found = siege(seconds, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    print("\n".join(report(found, seconds)))
    return 1 if found.wrong or len(found.stops) < 3 else 0


if __name__ == "__main__":
    sys.exit(main())
