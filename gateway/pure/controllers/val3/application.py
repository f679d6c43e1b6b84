"""The interpreter's application as seen by the control (AX-930): its command source, moves and outputs, start and stop by the PLC.

Pure.  Call `report` with the state published by the interpreter, `hear` with each of its records, `step` once a cycle of the services.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.run_results import RunResults
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.image.reasons import CommandState, Reason, text
from gateway.pure.image.records.cell import CellState, Motion
from gateway.pure.image.records.interpreter import Fact
from protocols.base.machine import Ns, ms

OWN_SOURCE = 92  # number of the command source that an application is
NOT_MOVED = 150
ORDERS = 200  # waiting for the interpreter
MOST_TEXT = 256
MODES = ("manual", "test", "local", "remote")
MOST_RATIO = 250.0
SEEN = ("val3", "variables", "shown", "popups", "screen")
PATIENCE = ms(1_000)  # between two requests for control that are refused
START_UP = ms(10_000)  # how long enablePower() waits for drives that do not answer yet
GONE = "the interpreter ended"


class Dispatcher(Protocol):
    """What the application asks of the cell."""

    cell: CellState | None

    @property
    def owner(self) -> int:
        """The command source in control; 0: none."""

    def command(self, source: int, command: Command, now: Ns) -> Job:
        """Judged as any other one."""

    def order_stream(self, source: int, robot: int, mask: int) -> Job:
        """Blocks that follow one by one."""


@dataclass(slots=True)
class _Path:
    """An order the application moves by."""

    ticket: int
    job: Job


@dataclass(slots=True, eq=False)
class HostedApplication:
    """mask: axes of the robot (bit n-1 = axis n).  own: the command source it moves as where no tool starts it."""

    control: Val3Control
    dispatcher: Dispatcher
    mask: int
    autostart: bool = False
    own: int = OWN_SOURCE
    language: str = "en"
    language_id: int = 0  # of the interpreter that runs
    orders: list[dict[str, Fact]] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    ending: list[int] = field(default_factory=list)
    programs: list[dict[str, object]] = field(default_factory=list)
    rows: list[dict[str, object]] = field(default_factory=list)
    results: RunResults = field(default_factory=RunResults)
    faults: list[str] = field(default_factory=list)  # active errors of the cell
    seen: dict[str, object] = field(default_factory=dict)  # for the dashboard
    run: int = 0  # under way
    source: int = 0  # command source it moves as
    _runs: int = 0
    _path: _Path | None = None
    _halted: bool = False  # by stopMove
    _held: bool = False  # by the PLC or a tool
    _drop: bool = False  # the rest of a move is to be given up as soon as it rests
    _stopped: bool = False  # by the application or its hold, and continued by them; after another stop only by val3.move
    _moves: bool = False  # the operator lets the arm move
    _leave: bool = False  # control goes back at rest
    _again: Ns = 0
    _power: Job | None = None  # the last request to switch on
    _power_until: Ns = 0  # enablePower() was called, and drives may still start
    _power_next: Ns = 0
    _refused: str = ""
    _control: bool | None = None  # as the interpreter knows it
    _states: dict[str, int] = field(default_factory=dict)

    # ---- what the interpreter publishes
    def report(self, report: Mapping[str, object], *, alive: bool) -> None:
        """Its region: identity, programs, processes."""
        found = report.get("id", 0)
        identity = found if isinstance(found, int) and alive else 0
        if identity != self.language_id:
            self._lost()
            self.language_id, self._control = identity, None
            self._states.clear()
            self.programs = _rows(report.get("programs"))
            if identity and self.autostart and report.get("fresh"):
                self._begin_by_itself()
        self.programs = _rows(report.get("programs")) if identity else []
        self.rows = _rows(report.get("processes")) if identity else []
        self.seen = {key: report[key] for key in SEEN if key in report} if identity else {}

    def act(self, request: Mapping[str, object]) -> dict[str, object]:
        """An operator's click, entry, answer, value; those of `do` = connect and hold are the PLC's too."""
        if not self.run:
            return {"error": "no application runs"}
        if len(self.orders) >= ORDERS:
            return {"error": "too many at once; try again"}
        wish = self.control.application
        match request.get("act"):
            case "connect":
                wish.move = True
            case "hold":
                wish.hold = bool(request.get("on"))
            case "event" | "enter" | "answer" | "key" | "set":
                facts = {key: str(request.get(key, ""))[:MOST_TEXT] for key in ("act", "what", "value", "attribute")}
                self.orders.append({"do": "act", **facts})
            case "mode" | "speed" | "ratio" as what:
                return self._key(what, str(request.get("value", ""))[:MOST_TEXT])
            case other:
                return {"error": f"act {other!r}; event, enter, answer, key, set, connect, hold, mode, speed, ratio are known"}
        return {"ok": True}

    def _key(self, what: str, value: str) -> dict[str, object]:
        """Mode, monitor speed in %, refresh ratio of user boards, as set at the pendant."""
        if what == "mode":
            if value not in MODES:
                return {"error": f"mode {value!r}: {', '.join(MODES)} are known"}
            self.orders.append({"do": "mode", "mode": value})
            return {"ok": True}
        low, high = (0.0, 100.0) if what == "speed" else (1.0, MOST_RATIO)
        try:
            number = float(value)
        except ValueError:
            number = -1.0
        if not low <= number <= high or (what == "ratio" and number != int(number)):
            return {"error": f"{what} {value!r}: {low:g} to {high:g} is expected"}
        self.orders.append({"do": what, "value": number})
        return {"ok": True}

    def _begin_by_itself(self) -> None:
        if self.programs:
            answer = self.start(str(self.programs[0]["name"]), 0)
            if "error" in answer:
                self.sentences.append(f"autostart: {answer['error']}")

    def _lost(self) -> None:
        """Handle the loss of its tasks: the arm stops on its path, and nothing starts unasked."""
        if self.run:
            self._over("lost", 0, GONE, "")
            self.sentences.append(f"{GONE}, and the application with it")
            self.faults = [f"{GONE} under the application; start it again"]
        if self._path is not None:
            if self._path.job.open:
                self.ending.append(self._path.job.id)
                self._drop = True
            self._path = None

    def _over(self, how: str, code: int, words: str, place: str) -> None:
        self.results.end(self.run, (how, code, words, place))
        self.run, self._leave, self._halted, self._moves = 0, True, False, False
        self.control.application.running = False

    # ---- its records
    def hear(self, said: Mapping[str, Fact], now: Ns) -> None:
        """One record of its ring."""
        if said["id"] != self.language_id:
            return
        match said["say"]:
            case "put":
                self._put(str(said["name"]), float(said["value"]))
            case "path":
                self._wants(int(said["ticket"]), now)
            case "power":
                self._switch(now, on=bool(said["on"]))
            case "speed":
                self._take(now)
                self._command(Command(Code.OVERRIDE, velocity=float(said["value"])), now)
            case "halt":
                self._halted = True
            case "go":
                self._halted = False
            case "drop":
                self._halted, self._drop = False, True
            case "faults":
                self.faults = [str(said["text"])] if said["text"] else []
            case "over" if said["run"] == self.run:
                code, words, place = int(said["code"]), str(said["text"]), str(said["place"])
                if words:
                    self.sentences.append(f"{place}: {code} {words}")
                self._over(str(said["how"]), code, words, place)
            case "kept":
                self.results.kept(said)

    def _put(self, name: str, value: float) -> None:
        try:
            self.control.assign(name, value)
        except (KeyError, ValueError) as fault:
            self.sentences.append(f"output {name}: {fault}")

    def _wants(self, ticket: int, now: Ns) -> None:
        self._take(now)
        job = self.dispatcher.order_stream(self.source, 1, self.mask)
        self._path = _Path(ticket, job)
        if job.open:
            self._answer("given", ticket, job=job.id)

    def _answer(self, what: str, ticket: int, **facts: Fact) -> None:
        self.orders.append({"do": what, "id": self.language_id, "ticket": ticket, **facts})

    def _switch(self, now: Ns, *, on: bool) -> None:
        self._power_until = now + START_UP if on else 0
        if not on:
            self._command(Command(Code.DISABLE, self.mask), now)
            return
        if not self._take(now):
            return
        cell = self.dispatcher.cell
        self._command(Command(Code.ENABLE, self.mask), now)
        if cell is not None and cell.override <= 0.0:
            self._command(Command(Code.OVERRIDE, velocity=1.0), now)

    def _power_again(self, now: Ns) -> None:
        """Drives that start later than the application are switched on when they answer (AX-1064)."""
        if now >= self._power_until:
            return
        job = self._power
        if not self.run or job is None or job.state is CommandState.DONE or (not job.open and job.reason is not Reason.DRIVE_LOST):
            self._power_until = 0
        elif not job.open and self.dispatcher.owner == self.source:
            if now >= self._power_next:
                self._power_next = now + PATIENCE
                self._command(Command(Code.ENABLE, self.mask), now)

    # ---- control of the kinematic
    def _take(self, now: Ns) -> bool:
        """Control is asked for; False: another command source has it."""
        if self.dispatcher.owner == self.source:
            return True
        self._leave = False
        return self._command(Command(Code.REQUEST_CONTROL), now)

    def _command(self, command: Command, now: Ns) -> bool:
        job = self.dispatcher.command(self.source or self.own, command, now)
        if command.code is Code.ENABLE:
            self._power = job
        if job.state is not CommandState.REFUSED:
            self._refused = ""
            return True
        words = f"{Code(command.code).name.lower()}: {text(job.reason, self.language, job.detail)}"
        if words != self._refused:
            self._refused = words
            self.sentences.append(words)
        return False

    # ---- start and stop
    def start(self, name: str, source: int) -> dict[str, object]:
        """As a tool or the PLC does; number of the run."""
        row = next((each for each in self.programs if str(each["name"]).lower() == name.lower()), None)
        if row is None:
            known = ", ".join(str(each["name"]) for each in self.programs)
            return {"error": f"{name}: no such application; " + (f"the cell has {known}" if known else "the interpreter does not run")}
        if row["fault"]:
            return {"error": f"{row['name']} has errors and does not run; the first: {row['fault']}"}
        if self.run:
            return {"error": f"{row['name']} runs already"}
        self._runs += 1
        self.run, self.source, self.faults, self._refused = self._runs, source or self.own, [], ""
        self._leave, self._drop = False, False
        self.control.application.running = True
        self.orders.append({"do": "start", "run": self.run, "program": str(row["name"])})
        return {"run": self.run}

    def stop(self, name: str) -> dict[str, object]:
        """stop() runs; a second time: all tasks end at once."""
        if not self.run or not any(str(row["name"]).lower() == name.lower() for row in self.programs):
            return {"error": f"{name} does not run"}
        self.orders.append({"do": "stop", "run": self.run})
        return {"ok": True}

    # ---- one cycle
    def step(self, now: Ns) -> None:
        """What became of its moves; who has control; what the PLC wants."""
        self._plc()
        cell = self.dispatcher.cell
        if cell is not None and self.source:
            self._move(cell, now)
            self._power_again(now)
        path = self._path
        if path is not None and not path.job.open:
            self._path = None
            done = path.job.state is CommandState.DONE
            words = "" if done else text(path.job.reason, self.language, path.job.detail)
            self._answer("over", path.ticket, code=0 if done else NOT_MOVED, text=words)
        held = bool(self.run) and self.dispatcher.owner in (0, self.source)
        if self.language_id and held != self._control:
            self._control = held
            self.orders.append({"do": "control", "held": held})
        if self.language_id:
            self._points()

    def _move(self, cell: CellState, now: Ns) -> None:
        """Stop, continue, abandon: each once the axes are in the required state."""
        stays = self._halted or self._held or self._drop
        if cell.motion in (Motion.IDLE, Motion.RUNNING):  # a permission is for the stop it follows, never for a later one
            self._moves = False
            self._stopped = self._stopped and (stays or now < self._again)  # a stop on its way is not yet seen
        if (stays and cell.motion is Motion.RUNNING and self._path is not None) or (self._drop and cell.motion is Motion.RUNNING):
            self._stopped = True
            self._once(Code.STOP, now)
        elif cell.motion is Motion.STOPPED and self._drop:
            self._once(Code.ABANDON, now)
        elif cell.motion is Motion.STOPPED and not stays and self._path is not None and (self._stopped or self._moves):
            self._stopped = self._moves = False
            self._once(Code.RESUME, now)
        elif self._drop and cell.motion is Motion.IDLE and (self._path is None or not self._path.job.open):
            self._drop = False
        if self._leave and not self._drop and self._path is None and cell.motion in (Motion.IDLE, Motion.STOPPED):
            self._leave = False
            if self.dispatcher.owner == self.source == self.own:
                self._command(Command(Code.RELEASE_CONTROL), now)

    def _once(self, code: Code, now: Ns) -> None:
        """A command is repeated only where it had no effect for a while."""
        if now >= self._again:
            self._again = now + PATIENCE // 10
            self._command(Command(code), now)

    def _plc(self) -> None:
        """Values val3.run, val3.hold, val3.move."""
        wish = self.control.application
        if wish.run is not None:
            name = str(self.programs[0]["name"]) if self.programs else ""
            if wish.run != bool(self.run):
                answer = self.start(name, 0) if wish.run else self.stop(name)
                if "error" in answer:
                    self.sentences.append(f"val3.run: {answer['error']}")
            wish.run = None
        if wish.hold != self._held:
            self._held = wish.hold
            self.orders.append({"do": "hold", "on": self._held})
        if wish.move:
            wish.move, self._moves = False, True
            self.orders.append({"do": "connect"})
        wish.fault = bool(self.faults)

    def _points(self) -> None:
        """ioStatus of points that have changed."""
        for name in self.control.points:
            status = int(self.control.system.status(name))
            if self._states.get(name, 0) != status:
                self._states[name] = status
                self.orders.append({"do": "io", "name": name, "status": status})


def _rows(found: object) -> list[dict[str, object]]:
    return [row for row in found if isinstance(row, dict)] if isinstance(found, list) else []
