"""Robot programs of the interpreter as a Reis control has them: modes, keys, START and STOP, the order to move, messages (AX-940).  Pure.

One program is selected at a time.  STOP, drives off and emergency stop leave the axes at rest on the path; START continues.  Nothing moves
again without a fresh START.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.reis.keys import Keys
from gateway.pure.controllers.reis.side import ReisSide
from gateway.pure.controllers.run_results import RunResults
from gateway.pure.image.reasons import CommandState, Reason, text
from gateway.pure.image.records.cell import AxisFlag, Motion
from gateway.pure.image.records.interpreter import Channels, Fact
from gateway.pure.languages.robotstar.arm import TOOL, Arm
from gateway.pure.languages.robotstar.cell_run import LEFT
from gateway.pure.languages.robotstar.robot import MODES, Stride
from gateway.pure.languages.robotstar.values import Structure
from protocols.base.machine import Ns

GONE = "the interpreter ended, and the program with it"
MOST_BREAKS = 100  # breakpoints of a program
STRIDES = tuple(each.value for each in Stride if each is not Stride.MODE)
MOUSE_NS: Ns = 20_000_000  # shortest time between two accepted mouse reports
HAND = ""
AT_REST = (Motion.IDLE, Motion.STOPPED)
CHANGE, BEGIN, END = (968, 0), (968, 1), (968, 2)  # markers: program change, Auto Start, Auto Stop (L2921-2923)
HOLD = (1020, 7)


@dataclass(slots=True)
class ReisPrograms:
    """Call `report` with the state published by the interpreter, `hear` with each of its records, `step` before and after a cycle of the
    control."""

    side: ReisSide
    dispatcher: CommandDispatcher
    arm: Arm  # the robot, on the first axes of the cell
    source: int  # command source that moves where no tool has started the program
    keys: Keys
    language: str = "en"
    language_id: int = 0  # of the interpreter that runs
    orders: list[dict[str, Fact]] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    ending: list[int] = field(default_factory=list)
    programs: list[dict[str, object]] = field(default_factory=list)
    rows: list[dict[str, object]] = field(default_factory=list)
    results: RunResults = field(default_factory=RunResults)
    run: int = 0  # under way
    tool: Structure | None = None  # in force, for the position in M1124
    progress: tuple[int, ...] = ()  # M1464 to M1479: way and time of the position under way, done and left
    refused: str = ""  # reason for refusing the last START key or manual movement; the pendant reads it
    looked: tuple[str, Fact | None, str] = ("", None, "")  # a variable: name, value or why there is none
    breaks: dict[str, list[int]] = field(default_factory=dict)  # breakpoints: program -> steps
    _runs: int = 0
    _name: str = ""  # of the program that was started last
    _called: set[str] = field(default_factory=set)  # programs that were in work since: each of them names it to STOP
    _mode: str | None = None
    _pushed: dict[str, Fact] = field(default_factory=dict)  # what the hand wanted last
    _mouse: str = ""  # coordinates as the interpreter knows them
    _mouse_ns: Ns = 0
    _let_go: bool = False  # START is released where positions are approached in dead man operation
    _mover: int = 0
    _job: Job | None = None
    _ticket: int = 0
    _leaving: bool = False  # the rest of the path is given up as soon as the axes rest; the interpreter hands it on anew
    _resume: bool = False  # continues as soon as the axes rest
    _seen: dict[tuple[int, int], bool] = field(default_factory=lambda: {CHANGE: True, BEGIN: True})  # a level at start is not an edge

    @property
    def axes(self) -> int:
        """Mask of the robot."""
        return (1 << self.arm.machine.axes) - 1

    def tcp(self, places: Sequence[float]) -> tuple[float, ...]:
        """X Y Z A B C of the tool where the axes are; () for a robot without geometry."""
        return self.arm.actual(self.arm.own(places), self.tool).pose

    # ---- modes -----------------------------------------------------------------------------------------------------------
    @property
    def mode(self) -> str:
        """Name of the mode; "" is HAND."""
        if self.side.automatic:
            return "auto"
        return f"test{self.keys.test}" if self.keys.test else HAND

    @property
    def code(self) -> int:
        """M1022; of Test 5 and 6, which have none, 0."""
        return MODES[self.mode].code if self.mode else self.keys.hand.code

    def _look_at_mode(self, now: Ns) -> None:
        mode = self.mode
        if mode == self._mode:
            return
        before, self._mode = self._mode, mode
        if before is not None:
            self.stop(now)
            self._leaving = self._job is not None
        if mode:
            self.orders.append({"do": "mode", "mode": mode})

    # ---- the interpreter -------------------------------------------------------------------------------------------------
    def report(self, report: Mapping[str, object], *, alive: bool) -> None:
        """What the interpreter publishes: identity, programs, the program selected."""
        found = report.get("id", 0)
        identity = found if isinstance(found, int) and alive else 0
        if identity != self.language_id:
            self._lost()
            self.breaks.clear()  # a new interpreter has none
            self.language_id, self._mode, self._mouse = identity, None, ""
        self.programs = _rows(report.get("programs")) if identity else []
        self.rows = _rows(report.get("processes")) if identity else []
        self._called.update(str(row["program"]).upper() for row in self.rows)

    def _lost(self) -> None:
        """The axes stop on the path, and its rest is given up."""
        if self.run:
            self.sentences.append(f"{self._name}: {GONE}")
            self._end("lost", 0, GONE, self._name)
        if self._job is not None:
            self._leaving = True
            self._say(Code.STOP, 0)
        self._ticket, self._name = 0, ""

    def hear(self, said: Mapping[str, Fact], now: Ns) -> None:
        """One record of its ring."""
        if said["id"] != self.language_id:
            return
        match said["say"]:
            case "write":
                self._wrong(self.side.robot_writes(int(said["first"]), bytes.fromhex(str(said["data"]))))
            case "bits":
                self._wrong(self.side.robot_sets(int(said["byte"]), int(said["mask"]), int(said["bits"])))
            case "tool":
                values = [float(word) for word in str(said["values"]).split()]
                self.tool = Structure("T", dict(zip(TOOL, values, strict=True)))
            case "progress":
                self.progress = tuple(int(word) for word in str(said["values"]).split())
            case "value":
                self.looked = str(said["name"]), said.get("value"), str(said.get("text", ""))
            case "hand":
                self.refused = str(said["text"])
                self.sentences.append(self.refused)
            case "path":
                self._wants(int(said["ticket"]))
            case "resume":
                self._resume = bool(self.run)
                self._go_on(now)
            case "leave":
                self._leaving = self._job is not None
            case "selected":
                self._name = str(said["program"])
            case "over" | "kept":
                self._of_run(said)
            case "message":
                place = f" ({said['program']} step {said['step']})" if said["program"] else ""
                self.sentences.append(f"{said['text']}{place}")
                self.side.message(int(said["number"]), f"{said['text']}{place}", now)

    def _of_run(self, said: Mapping[str, Fact]) -> None:
        """It is over, or all it has written was tried."""
        if said["say"] == "kept":
            self.results.kept(said)
        elif int(said["run"]) == self.run:
            self._end(str(said["how"]), int(said["code"]), str(said["text"]), str(said["place"]))

    def _wrong(self, words: str) -> None:
        if words:
            self.sentences.append(f"{self._name}: {words}")

    def _end(self, how: str, code: int, words: str, place: str) -> None:
        self.results.end(self.run, (how, code, words, place))
        self.run = 0

    def _wants(self, ticket: int) -> None:
        job = self.dispatcher.order_stream(self._mover, 1, self.axes, held=not self.mode)
        self._job, self._ticket, self._leaving = job, ticket, False
        if job.open:
            self._answer("given", job=job.id)

    def _answer(self, what: str, **facts: Fact) -> None:
        if self._ticket:
            self.orders.append({"do": what, "id": self.language_id, "ticket": self._ticket, **facts})

    # ---- START and STOP --------------------------------------------------------------------------------------------------
    @property
    def selected(self) -> str:
        """The program that START starts; "": none."""
        return self._name

    def select(self, name: str, step: int) -> str:
        """Program and step that START begins at; "" or why not."""
        if self.run:
            return f"{self._name} runs: stop it first"
        if all(row["name"] != name for row in self.programs):
            return f"no such program: {name}"
        self._name = name
        self.orders.append({"do": "select", "program": name, "step": step})
        return ""

    def moves_for(self, source: int) -> None:
        """The next START at the pendant moves as this command source; 0: as the one of the cell."""
        self._mover = source or self.source

    def start(self, name: str, source: int, how: str = "") -> str:
        """START, of the program selected (name "") or of another one; how: of a single step; "" or why it is refused."""
        in_auto = "single steps are made in Test 1 to 6, not in AUTO" if how and self.mode == "auto" else ""
        if wrong := self._refusal(name) or in_auto:
            return wrong
        self._runs, self._let_go = self._runs + 1, False
        self.run, self._name = self._runs, name or self._name
        self._called.clear()
        if source or not self._mover:
            self._mover = source or self.source
        self.orders.append({"do": "stride", "how": how or Stride.MODE.value})
        self.orders.append({"do": "start", "run": self.run, "program": self._name})
        return ""

    def _refusal(self, name: str) -> str:
        if not self.language_id:
            return "the interpreter does not run"
        if not self.mode:
            return "operating mode HAND: AUTO is RC input 23, reis.mode = 1 .. 6 are Test 1 .. 6"
        if self.run:
            return f"{self._name} runs: stop it first"
        if not name and not self._name:
            return "no program is selected"
        row = next((row for row in self.programs if row["name"] == (name or self._name)), None)
        if row is None:
            return f"no such program; the memory has {', '.join(str(each['name']) for each in self.programs) or 'none'}"
        if row["fault"]:
            return f"it has faults; the first: {row['fault']}"
        enabled = self.dispatcher.enabled_mask(AxisFlag.ENABLED)
        return "the drives are off" if self.axes & ~enabled else ""

    def stop(self, now: Ns) -> None:
        """STOP on the path; START continues from there."""
        self._resume = False
        if self.run:
            self.orders.append({"do": "stop", "run": self.run})
        if self._moving():
            self._say(Code.STOP, now)

    def _moving(self) -> bool:
        return self._job is not None and self._job.open and self.side.cell.motion is Motion.RUNNING

    def _say(self, code: Code, now: Ns) -> None:
        self.dispatcher.command(self._mover or self.source, Command(code), now)

    def _key(self, key: str, now: Ns, *, pressed: bool) -> None:
        executer = self.mode == "test5"
        if key == ("exec" if executer else "start"):
            if pressed:
                self._wrong_start(self.start("", 0))
            else:
                self._let_go = bool(self.run and self.mode and (MODES[self.mode].single or self.keys.middle))
        elif pressed and key == "stop":
            self.stop(now)
        elif pressed and key in ("f1", "f2"):
            self.orders.append({"do": "key", "key": key.upper()})
        elif pressed and key == "quit":
            self.acknowledge()

    def _wrong_start(self, words: str) -> None:
        if words:
            self.refused = f"START is refused: {words}"
            self.sentences.append(self.refused)

    def acknowledge(self) -> None:
        """The message is acknowledged."""
        self.orders.append({"do": "ack"})
        self.side.acknowledged()

    # ---- one cycle -------------------------------------------------------------------------------------------------------
    def step(self, now: Ns) -> None:
        """Before and after a cycle of the control."""
        if not self.language_id:
            self._follow(now)
            return
        self._look_at_mode(now)
        for key, pressed in self.keys.edges().items():
            self._key(key, now, pressed=pressed)
        self._dead_man(now)
        self._markers(now)
        self._move_by_hand(now)
        self._follow(now)

    def _dead_man(self, now: Ns) -> None:
        """Positions move only while START is held; other steps continue without it, also one that requests an entry (L1204-1219)."""
        ordered = self._let_go and self.run and self._job is not None and self._job.open
        if ordered and (self._moving() or not any(row["waits"] for row in self.rows)):
            self._let_go = False
            self.stop(now)

    def _move_by_hand(self, now: Ns) -> None:
        """Keys, wheel and mouse in HAND: dead man, the axes rest once nothing is wanted (L175-193)."""
        mouse = " ".join(f"{value:g}" for value in self.keys.hand.mouse)
        if mouse != self._mouse and now - self._mouse_ns >= MOUSE_NS:
            self._mouse, self._mouse_ns = mouse, now
            self.orders.append({"do": "mouse", "raw": mouse})
        push = self.keys.hand.push() if self.mode == HAND else {}
        if push == self._pushed:
            return
        before, self._pushed = self._pushed, push
        if not before.get("kind") and not push.get("kind"):
            return
        if before.get("kind") and {**before, "turned": 0} != {**push, "turned": 0}:
            self._leaving = self._job is not None
            if self._moving():
                self._say(Code.STOP, now)
        if push.get("kind") and not before.get("kind"):
            self._mover = self.dispatcher.owner or self.source
        self.orders.append({"do": "hand", **(push or {"kind": ""})})

    def _markers(self, now: Ns) -> None:
        """Requests of the PLC, in AUTO alone (L2921-2923)."""
        levels = {place: self.side.marker(*place) for place in (CHANGE, BEGIN)}
        if self.mode == "auto":
            if levels[CHANGE] and not self._seen[CHANGE] and not self.run:
                self.orders.append({"do": "change"})
            if levels[BEGIN] and not self._seen[BEGIN]:
                self._wrong_start(self.start("", 0))
            if self.side.marker(*END) and self.run:
                self.stop(now)
        self._seen = levels

    def _follow(self, now: Ns) -> None:
        job = self._job
        if job is None:
            self._leaving = False
            return
        if not job.open:
            self._job, self._leaving, self._resume = None, False, False
            done = job.state is CommandState.DONE
            words = "" if done else text(job.reason, self.language, job.detail) or "the order was ended"
            code = LEFT if job.reason is Reason.ABANDONED else int(job.reason) or 1
            self._answer("over", code=0 if done else code, text=words)
            return
        if self._leaving and self.side.cell.motion in AT_REST:
            self._leave(job, now)
        self._go_on(now)

    def _leave(self, job: Job, now: Ns) -> None:
        if self.side.cell.motion is Motion.STOPPED:
            self._leaving = False
            self._say(Code.ABANDON, now)
        else:
            self._leaving = False
            self.ending.append(job.id)

    def _go_on(self, now: Ns) -> None:
        """START after a STOP: the rest of the path, once the axes rest."""
        held = self._leaving or self.side.marker(*HOLD)
        if not self._resume or held or self.side.cell.motion is Motion.STOPPING:
            return
        self._resume = False
        if self._job is not None and self._job.open and self.side.cell.motion is Motion.STOPPED:
            self._say(Code.RESUME, now)

    # ---- tools -----------------------------------------------------------------------------------------------------------
    @property
    def hosted(self) -> "ReisPrograms":
        """Its programs."""
        return self

    def seen(self) -> Channels:
        """The control as programs see it."""
        return Channels(flags=self.side.flag_bytes())

    def faults(self) -> list[str]:
        """The control reports them itself."""
        return []

    def answer(self, request: Mapping[str, object], source: int) -> dict[str, object]:
        """`do`: list, start and stop (`name`), step (`name`, `how`), state (`run`).  `source`: that a program moves as, 0: the PLC's."""
        name = str(request.get("name", "")).upper()
        match request.get("do"):
            case "list":
                name, value, words = self.looked
                seen = {"name": name, "value": value, "text": words}
                return {"programs": self.programs, "processes": self.rows, "id": self.language_id, "breaks": self.breaks, "value": seen}
            case "breakpoints":
                return self._breakpoints(name, request.get("lines"))
            case "value":
                self.orders.append({"do": "look", "name": name})
                return {"ok": True}
            case "outcome":
                return {"over": True}
            case "start":
                return self._started(name, source)
            case "step":
                return self._started(name, source, str(request.get("how")))
            case "stop":
                return self._stopped(name)
            case "state":
                return self.results.answer(request.get("run"), self.rows, alive=bool(self.language_id))
        return {"error": f"do {request.get('do')!r}; list, start, stop, step, state, breakpoints, value are known"}

    def _started(self, name: str, source: int, how: str = "") -> dict[str, object]:
        wrong = self.start(name, source, how) if how in ("", *STRIDES) else f"how = {how!r}; {', '.join(STRIDES)} are known"
        return {"error": f"{name or self._name}: {wrong}"} if wrong else {"run": self.run}

    def _breakpoints(self, name: str, lines: object) -> dict[str, object]:
        """Set the steps before which the program stops; return the answer."""
        if not isinstance(lines, list) or not all(isinstance(line, int) for line in lines) or len(lines) > MOST_BREAKS:
            return {"error": f"breakpoints: lines = at most {MOST_BREAKS} numbers of lines"}
        if all(row["name"] != name for row in self.programs):
            return {"error": f"{name}: no such program"}
        self.breaks[name] = lines
        self.orders.append({"do": "breaks", "program": name, "lines": " ".join(str(line) for line in lines)})
        return {"ticket": 0}

    def _stopped(self, name: str) -> dict[str, object]:
        """A program that is stopped already is given up: START begins it at its first step."""
        if not self._name or name not in (self._name, *self._called):
            return {"error": f"{name}: no such process"}
        if self.run:
            self.stop(0)
        else:
            self.orders.append({"do": "forget"})
        return {"ok": True}


def _rows(found: object) -> list[dict[str, object]]:
    return [row for row in found if isinstance(row, dict)] if isinstance(found, list) else []
