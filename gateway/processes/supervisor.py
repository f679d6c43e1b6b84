"""The supervisor: creates the regions, starts, watches and restarts the processes (design: section 4).

Restart: at once, then after 1, 2, 5 s; six failures in a minute: the journal reports it, the cycle stays down, every other process is tried
again every 10 s (AX-621).  Tools send it requests: status, regions (fds by SCM_RIGHTS), hold, release, stop.
"""

import contextlib
import json
import os
import pathlib
import pickle
import selectors
import signal
import socket
import subprocess
from dataclasses import dataclass, field

from drivers.ports.base import runtime_dir
from gateway.assembly.run import Child, RunPlan, make_regions
from gateway.processes.child_start import Starter
from gateway.processes.tool_requests import ToolRequests
from gateway.pure.image.life_watch import LifeWatch, Load
from gateway.runtime.clock import now_ns
from gateway.runtime.journal import Journal
from gateway.runtime.realtime import processor_ns, survive_terminal, wants_processor
from gateway.runtime.regions import ImageError, RegionReader, send_fds
from gateway.runtime.spare import Spare
from gateway.runtime.start_watch import StartWatch

WAITS_NS = (0, 1_000_000_000, 2_000_000_000, 5_000_000_000)
WINDOW_NS = 60_000_000_000
TOO_MANY = 6
SLOW_NS = 10_000_000_000  # between two starts of a process that died that often
STAYS_DOWN = "cycle"  # moves axes: after so many deaths the operator must check first
END_S = 0.1  # patience with the death of a process that was ended; one that hangs in the kernel is buried later
BUSY_REPORT_NS = 10_000_000_000  # report interval for a process that gets no processor time
POLL_S = 0.01
SPARE_NS = 200_000_000  # after a start: loading the copy then costs the new process no processor time (AX-1740)
SPARE_AGAIN_NS = 1_500_000_000  # between two spares: one that died is not replaced at once
GOES_ON = "; the run continues; to end it: axisgate stop {slug}"
SAID_ONCE = {  # signals of a terminal that end or suspend nothing
    signal.SIGHUP: "the terminal or session has ended (SIGHUP)" + GOES_ON,
    # Suspended, it would restart nothing and end no hung process, while the cycle moves axes
    signal.SIGTSTP: "Ctrl-Z (SIGTSTP) does not suspend a run, because its processes would go on unwatched" + GOES_ON + ", or Ctrl-C",
}


@dataclass(slots=True)
class Running:
    """One child and its history."""

    child: Child
    process: subprocess.Popen[bytes] | None = None
    spare: Spare | None = None
    deaths: list[int] = field(default_factory=list)
    restarts: int = 0
    start_at: int | None = None  # when to start it again; None: running, not yet started, or down
    down: bool = False  # died too often, or held: it stays down
    alarm: str = ""  # why it stays down
    start: StartWatch = field(default_factory=lambda: StartWatch(0))
    ready: bool = False
    reader: RegionReader | None = None
    last_life: int = 0
    watch: LifeWatch | None = None
    ending: str = ""  # it was ended for this reason and is not yet dead
    busy: int = 0  # how often a busy computer kept it from showing life
    busy_reported: int = 0
    output: bytes = b""
    spare_at: int = 0  # not before: a spare that died is not replaced at once


class Supervisor:
    """Owns every process of one run."""

    def __init__(self, plan: RunPlan, *, echo: bool = True) -> None:
        self.plan = plan
        self.journal = Journal(plan.journal, "supervisor", echo=echo)
        self.fds = make_regions(plan)
        self._plan_fd = os.memfd_create("axisgate-plan", os.MFD_CLOEXEC)
        os.write(self._plan_fd, pickle.dumps(plan))
        self._starter = Starter(self.fds, self._plan_fd, plan.children)
        self._running = [Running(child) for child in plan.children]
        for running in self._running:
            if running.child.life:
                running.reader = RegionReader(self.fds[running.child.life], running.child.life)
        self._selector = selectors.DefaultSelector()
        self._stop = False
        self._noted: list[signal.Signals] = []  # of SAID_ONCE, in the order they came
        self._said: set[signal.Signals] = set()
        self._requests = ToolRequests(plan.slug, self._selector, self._answer)

    # ---- life --------------------------------------------------------------------------------------------------------
    def run(self) -> int:
        """Until SIGINT, SIGTERM or a stop request; exit code 0, or 3 when a process never came up."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)
        survive_terminal()
        for number in SAID_ONCE:
            signal.signal(number, self._on_terminal)
        try:
            code = self._start_all()
            while code == 0 and not self._stop:
                self._turn()
            return code
        finally:
            self._end_all()

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def _on_terminal(self, number: int, frame: object) -> None:
        if number not in self._said:
            self._noted.append(signal.Signals(number))

    def _turn(self) -> None:
        for key, _ in self._selector.select(POLL_S):
            key.data(key.fileobj)
        while self._noted:
            number = self._noted.pop(0)
            if number not in self._said:
                self._said.add(number)
                self.journal.write("process", SAID_ONCE[number].format(slug=self.plan.slug))
        for running in self._running:
            self._look_after(running)
        self._requests.send_away()

    def _start_all(self) -> int:
        """In order; each announcing process is waited for, because the next one needs it."""
        for running in self._running:
            self._start(running)
            while running.child.announces and not running.ready:
                self._turn()
                if self._stop:
                    return 0
                if running.start.due(now_ns(), _pid(running)) or running.down or len(running.deaths) > 1:
                    self.journal.write("process", f"{running.child.name} did not start; its output is above")
                    return 3
        return 0

    def _start(self, running: Running) -> None:
        child = running.child
        spare, running.spare = running.spare, None
        if spare is not None and spare.call():
            running.process = spare.process
        else:
            if spare is not None:
                spare.end()
            try:
                running.process = self._starter.start(child, again=running.restarts > 0)
            except (OSError, subprocess.SubprocessError) as error:  # no memory, no more processes, no program: tried again like a death
                self._buried(running, f"could not be started ({error})")
                return
        running.start, running.start_at, running.ready, running.output = StartWatch(now_ns()), None, False, b""
        running.last_life = running.reader.life[0] if running.reader else 0
        running.watch, running.ending = LifeWatch(child.life_limit_ns), ""
        assert running.process.stdout is not None
        os.set_blocking(running.process.stdout.fileno(), False)
        self._selector.register(running.process.stdout, selectors.EVENT_READ, lambda _: self._hear(running))
        self.journal.write("process", f"{child.name} started, pid {running.process.pid}", pid=running.process.pid, child=child.name)

    def _hear(self, running: Running) -> None:
        """Copy the output of a child to the journal."""
        if running.process is None or running.process.stdout is None or running.process.stdout.closed:
            return  # buried in this very turn
        data = os.read(running.process.stdout.fileno(), 65536)
        if not data:
            self._selector.unregister(running.process.stdout)
            running.process.stdout.close()
            return
        *lines, running.output = (running.output + data)[-1_000_000:].split(b"\n")
        for line in lines:
            words = line.decode(errors="replace").rstrip()
            if words == "ready":
                running.ready = True
            elif words and "leaked" not in words and "nanobind" not in words:
                self.journal.write("output", f"{running.child.name}: {words}")

    def _look_after(self, running: Running) -> None:
        process = running.process
        if process is None:
            if running.start_at is not None and now_ns() >= running.start_at:
                running.restarts += 1
                self._start(running)
            return
        if process.poll() is not None:
            self._buried(running, running.ending or f"ended with {_how(process.returncode)}")
        elif running.reader is not None and not running.ending:
            self._check_life(running)
            if running.child.spare and running.process is not None:
                self._keep_spare(running)
        if running.alarm and running.process is not None and not running.ending and now_ns() - running.start.started_ns > WINDOW_NS:
            self.journal.write("process", f"{running.child.name} has been running again for a minute", child=running.child.name)
            running.alarm = ""

    def _keep_spare(self, running: Running) -> None:
        if running.spare is not None and not running.spare.is_standby:
            running.spare.end()
            running.spare, running.spare_at = None, now_ns() + SPARE_AGAIN_NS
        if running.spare is None and now_ns() > max(running.start.started_ns + SPARE_NS, running.spare_at):
            running.spare_at = now_ns() + SPARE_AGAIN_NS
            with contextlib.suppress(OSError, subprocess.SubprocessError):  # tried again soon; without a spare a start takes longer
                running.spare = Spare(self._starter.start(running.child, spare=True))

    def _check_life(self, running: Running) -> None:
        assert running.reader is not None and running.process is not None
        count, stamp = running.reader.life
        now = now_ns()
        if count == running.last_life:
            if not running.start.due(now, _pid(running)):
                return  # a process that has not shown life yet is still starting
            stamp = running.start.started_ns  # its silence is counted from its start, not from that of the computer
        running.ready = True
        assert running.watch is not None
        alive = running.watch.look(now, count, stamp, self._load(running, now, count, stamp))
        if not alive and now - running.start.started_ns > running.child.life_limit_ns:
            running.ending = f"showed no life for {(now - stamp) / 1e6:.0f} ms and was ended"
            running.process.kill()
            with contextlib.suppress(subprocess.TimeoutExpired):  # a process inside the kernel must not hold up the watch on the others
                running.process.wait(END_S)
                self._buried(running, running.ending)
        elif alive and now - stamp > running.child.life_limit_ns and now - running.busy_reported > BUSY_REPORT_NS:
            running.busy, running.busy_reported = running.busy + 1, now
            words = f"{running.child.name} gets no processor time: the machine is busy, no sign of life for {(now - stamp) / 1e6:.0f} ms"
            self.journal.write("process", f"{words}; it is not ended", child=running.child.name)

    @staticmethod
    def _load(running: Running, now: int, count: int, stamp: int) -> Load | None:
        assert running.watch is not None and running.process is not None
        if not running.watch.wants_load(now, count, stamp):
            return None
        with contextlib.suppress(OSError):
            pid = running.process.pid
            return Load(processor_ns(pid), wants_processor(pid))
        return None

    def _buried(self, running: Running, how: str) -> None:
        now = now_ns()
        if running.process is not None and running.process.stdout is not None and not running.process.stdout.closed:
            with contextlib.suppress(OSError):
                self._hear(running)
            with contextlib.suppress(KeyError, ValueError):
                self._selector.unregister(running.process.stdout)
            running.process.stdout.close()
        running.process = None
        running.deaths = [at for at in running.deaths if now - at < WINDOW_NS] + [now]
        deaths = len(running.deaths)
        if running.alarm:  # tried again slowly: the alarm stays, and the journal does not fill with it
            running.start_at = now + SLOW_NS
            return
        if deaths >= TOO_MANY:
            running.down = running.child.name == STAYS_DOWN
            running.start_at = None if running.down else now + SLOW_NS
            then = "it stays down" if running.down else f"it is started again every {SLOW_NS // 1_000_000_000} s"
            running.alarm = f"{running.child.name} {how}; {deaths} failures in a minute: {then}"
            self.journal.write("alarm", running.alarm, child=running.child.name)
            return
        wait = WAITS_NS[min(deaths - 1, len(WAITS_NS) - 1)]
        running.start_at = now + wait
        self.journal.write("process", f"{running.child.name} {how}; restart in {wait / 1e9:.0f} s", child=running.child.name)

    def _end_all(self) -> None:
        """Services and cycle first, simulation last; SIGTERM, then SIGKILL after 2 s."""
        for running in self._running:
            if running.spare is not None:
                running.spare.end()
        for running in reversed(self._running):
            process = running.process
            if process is None or process.poll() is not None:
                continue
            process.terminate()
            process.send_signal(signal.SIGCONT)
            try:
                process.wait(2)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._requests.close()
        with contextlib.suppress(OSError):  # killed services could not remove theirs
            (runtime_dir() / f"{self.plan.slug}-services.sock").unlink(missing_ok=True)
        self._selector.close()
        for fd in (*self.fds.values(), self._plan_fd):
            os.close(fd)
        self.journal.write("process", "all processes ended")
        self.journal.close()

    # ---- requests ----------------------------------------------------------------------------------------------------
    def _answer(self, connection: socket.socket, request: dict[str, object]) -> None:
        match request.get("op"):
            case "status":
                connection.sendall(json.dumps(self.status()).encode() + b"\n")
            case "regions":
                with contextlib.suppress(ImageError):
                    send_fds(connection, self.fds)
            case "hold" | "release" as op:
                held = self._hold(str(request.get("process")), hold=op == "hold")
                connection.sendall(json.dumps({"ok": held}).encode() + b"\n")
            case "stop":
                self._stop = True
                connection.sendall(b'{"ok": true}\n')
            case other:
                connection.sendall(json.dumps({"error": f"op {other!r}; status, regions, hold, release, stop are known"}).encode() + b"\n")

    def _hold(self, name: str, *, hold: bool) -> bool:
        """Take one process out of the run on purpose (a bench, a repair), or start it again with its deaths forgotten; False: unknown."""
        for running in self._running:
            if running.child.name != name:
                continue
            process = running.process
            if hold and process is not None:
                process.terminate()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(2)
                process.kill()
                process.wait()
                self._buried(running, "was held")
            running.deaths.clear()
            running.alarm = ""
            running.start_at, running.down = (None, True) if hold else (now_ns() if running.process is None else None, False)
            return True
        return False

    def status(self) -> dict[str, object]:
        """Processes with pid, restarts and life for `axisgate` tools."""
        now = now_ns()
        return {
            "cell": self.plan.cell.cell.name,
            "file": str(pathlib.Path(self.plan.cell.file).resolve()),
            "folder": str(self.plan.folder),
            "journal": str(self.plan.journal),
            "simulated": self.plan.simulated,
            "p5_ms": self.plan.p5_ms,
            "listening": list(self.plan.listening),  # buses nothing is sent on
            "alarms": [running.alarm for running in self._running if running.alarm],
            "processes": [
                {
                    "name": r.child.name,
                    "command": [r.child.module, *r.child.arguments],
                    "pid": r.process.pid if r.process else None,
                    "state": "up" if r.process else "down" if r.down else "waiting",
                    "restarts": r.restarts,
                    "busy": r.busy,
                    "spare": r.spare.process.pid if r.spare else None,
                    "life_age_ms": round((now - r.reader.life[1]) / 1e6, 1) if r.reader else None,
                }
                for r in self._running
            ],
        }


def _pid(running: Running) -> int | None:
    return None if running.process is None else running.process.pid


def _how(code: int) -> str:
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
