"""ROBOTstar programs in a cell: one program is selected, modes and keys are the control's, the way is the planner's (AX-940).  Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from gateway.pure.image.records.interpreter import Fact
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import Port, ProcessRow, ProgramRow
from gateway.pure.languages.base.path import Path, Stretch
from gateway.pure.languages.base.requests import Ns, RuntimeFault
from gateway.pure.languages.robotstar import kept
from gateway.pure.languages.robotstar.access import scalar, variable
from gateway.pure.languages.robotstar.ahead import Ahead, Block
from gateway.pure.languages.robotstar.arm import Arm, tool_values
from gateway.pure.languages.robotstar.cell_robot import BREAKPOINT, CellRobot, NoDrive
from gateway.pure.languages.robotstar.cell_world import CellWorld
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.faults import UNSET, StepFault
from gateway.pure.languages.robotstar.hand import Hand, Push
from gateway.pure.languages.robotstar.lines import head
from gateway.pure.languages.robotstar.machine import BitWait, KeyTest, Machine, NotYet, Wait
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.mouse import Mouse
from gateway.pure.languages.robotstar.operands import OperandFault, Ref, operand
from gateway.pure.languages.robotstar.program import Program
from gateway.pure.languages.robotstar.robot import MODES, Message, State, Stride
from gateway.pure.languages.robotstar.steps import build
from gateway.pure.languages.robotstar.system import DEFAULTS, KEPT, System
from gateway.pure.languages.robotstar.values import Array, Cell, Names, Structure, flat

WAITS = {Wait: "a time", BitWait: "a bit"}
RUNS = (State.RUNNING, State.WAITING)
LEFT = -1  # code of an order that ended because the rest of the path was given up
SYSTEM = "$SYSTEM"  # name of what the control itself keeps
STARTABLE = ("MPR", "SPR", "MAC")


class CellRun:
    """One control's interpreter."""

    def __init__(self, memory: Memory, port: Port, arm: Arm) -> None:
        self.port, self.arm = port, arm
        self.path = Path(port)
        self.mode = MODES["auto"]
        self.run = 0  # of the control, while the program runs
        self.selected: Program | None = None
        self.mouse = Mouse()
        self._take(memory)

    def _hand_speeds(self) -> tuple[float, float]:
        """_RVEL_KART and _RVEL_ORI."""
        found = (self.machine.system[name] for name in ("_RVEL_KART", "_RVEL_ORI"))
        along, about = (float(str(cell.value)) if isinstance(cell, Cell) else 0.0 for cell in found)
        return along, about

    def _mouse_in_hand(self) -> bool:
        """Bit 1 of _VERFAHR[3]."""
        field = self.machine.system["_VERFAHR"]
        cell = field.items[2] if isinstance(field, Array) else None
        return isinstance(cell, Cell) and isinstance(cell.value, int) and bool(cell.value >> 1 & 1)

    def _says_hand(self, text: str) -> None:
        self.port.send("hand", text=text)

    def _take(self, memory: Memory) -> None:
        self.memory = memory
        self.ahead = Ahead(self.path, self.arm, self._cursor, self._done)
        self.world = CellWorld(self.port, self.ahead)
        system = System(self.world, path_left=self.world.path_left)
        names = system.names()
        self.machine = Machine(memory, self.world, names, build)
        self._tool: Structure | None = None  # as the control knows it
        system.machine = self.world.machine = self.machine
        self.robot = CellRobot(self.machine, self.mode, NoDrive(), self._say, ahead=self.ahead, places=lambda: self.port.view.set)
        self.machine.mouse = self.mouse
        self.hand = Hand(
            self.path, self.arm, self._hand_speeds, lambda: self.machine.tool, self._mouse_in_hand, self._says_hand, self.mouse
        )
        self.faults = Faults()
        check(memory, self.faults, names)
        self.selected = None

    def _set_breaks(self, stops: Mapping[str, frozenset[int]]) -> None:
        """Breakpoints: key of a program -> numbers of its steps."""
        for key, steps in stops.items():
            found = self.memory.find(key)
            if found is not None and found.key == key:
                self.machine.set_breaks(found, steps)

    def _cursor(self) -> tuple[str, int]:
        return self.robot.cursor()

    def _done(self) -> tuple[str, int]:
        return self.machine.last_done()

    def replaced(self, memory: Memory) -> None:
        """The memory was read anew; the place where a program was interrupted is lost (L209)."""
        before, stops = self.values(), dict(self.machine.stops)
        self._leave()
        self._take(memory)
        self._set_breaks(stops)
        for name, text in before.items():
            self.restore(name, text)

    @property
    def runs(self) -> bool:
        """START is in force."""
        return self.robot.state in RUNS

    # ---- values ----------------------------------------------------------------------------------------------------------
    def _tables(self) -> dict[str, Names]:
        tables: dict[str, Names] = {}
        for program in self.memory.all():
            own = {name: self.memory.globals[name] for name, owner in self.memory.owners.items() if owner is program}
            tables[program.own_file] = {**own, **self.memory.locals.get(program.key, {})}
        return tables

    def values(self) -> dict[str, str]:
        """What outlives power-off: file of a program -> values of the variables it defines."""
        found = {file: text for file, table in self._tables().items() if (text := kept.written(table))}
        return found | {SYSTEM: kept.written(kept.system_values(self.machine.system, (*KEPT, *DEFAULTS)))}

    def restore(self, file: str, text: str) -> list[str]:
        """Values as they were kept; lines that fit no variable come back."""
        return kept.restore(text, self.machine.system if file == SYSTEM else self._tables().get(file, {}))

    def made(self) -> dict[str, str | None]:
        """What programs have made or changed: file -> its text, None: it is deleted."""
        gone: dict[str, str | None] = dict.fromkeys(self.memory.gone)
        return gone | {program.made: program.listing() for program in self.memory.all() if program.made}

    @property
    def effects(self) -> int:
        """Grows where values may have changed."""
        return self.machine.effects

    # ---- from outside ----------------------------------------------------------------------------------------------------
    def catalogue(self) -> list[ProgramRow]:
        """All programs of the memory."""
        return [self._row(program) for program in self.memory.all()]

    def _row(self, program: Program) -> ProgramRow:
        fault = f"{program.file} line {program.refused[0][0]}: {program.refused[0][1]}" if program.refused else ""
        return ProgramRow(program.key, program.kind, (1,), len(program.refused), 0, fault)

    def start_run(self, name: str, run: int, now: Ns) -> None:
        """START: of the program that is selected where it was stopped, of another one at its first step."""
        self._at(now)
        wrong = "a program runs: STOP first" if self.runs else self._choose(name)
        wrong = wrong or self.robot.start(now)
        if wrong:
            self.port.over(run, "aborted", RuntimeFault(0, f"START is refused: {wrong}"), name)
            return
        self.run = run
        if self.path.held_by(self) is not None:
            self.port.send("resume")

    def _choose(self, name: str) -> str:
        found = self.memory.find(name)
        if found is None:
            return f"program {name} not found"
        if found is self.selected:
            return ""
        if found.refused:
            return f"program {found.key} has faults: {found.refused[0][1]}"
        if found.kind not in STARTABLE:
            return f"program {found.key} is a pallet program; it is not executed"
        self._select(found)
        return ""

    def _leave(self) -> None:
        """Drop everything that was handed on."""
        if not self.path.release(self):
            self.port.send("leave")

    def _select(self, found: Program) -> None:
        self._leave()
        self.robot.select(found)
        self.selected = found
        self.port.send("selected", program=found.key)

    def stop_run(self, run: int, now: Ns, error: RuntimeFault | None = None) -> None:
        """STOP on the path; START continues from there.  error: the cause, if any."""
        self._at(now)
        if run != self.run or not run:
            return
        self.robot.stop(now)
        self._over(error)

    def stop_all(self, now: Ns) -> None:
        """Stop the program and drop its orders: the services have restarted."""
        self._at(now)
        self.robot.stop(now)
        if self.path.now is not None:
            self.ahead.left(self.path.now)
        self.path.drop()
        self.hand.forget()
        self.run = 0

    def file_changed(self, name: str) -> None:
        """Ignored: the memory is read as a whole, see `replaced`."""

    def hear(self, order: Mapping[str, Fact], now: Ns) -> None:
        """Mode, keys and acknowledgement as the control has them."""
        self._at(now)
        match order["do"]:
            case "mode":
                self.mode = MODES[str(order["mode"])]
                self.robot.set_mode(self.mode)
            case "stride" if not self.runs:
                self.robot.stride = Stride(str(order["how"]))
            case "key":
                self.robot.key(order["key"] == "F2")
            case "ack":
                self.robot.acknowledge()
            case "hand":
                self._by_hand(order)
            case "mouse":
                self.mouse.raw = tuple(float(word) for word in str(order["raw"]).split())
            case "change" if not self.runs:
                self._change()
            case "select" if not self.runs:
                self._select_step(str(order["program"]), int(order["step"]))
            case "look":
                self._show(str(order["name"]))
            case "breaks":
                self._set_breaks({str(order["program"]): frozenset(int(line) for line in str(order["lines"]).split())})
            case "forget" if not self.runs:
                self._leave()
                self.ahead.forget()
                self.selected = None

    def _by_hand(self, order: Mapping[str, Fact]) -> None:
        if not order["kind"]:
            self.hand.hear(Push())
            return
        ways = tuple(float(word) for word in str(order["ways"]).split())
        turned, moves, turns = float(order["turned"]), bool(order["moves"]), bool(order["turns"])
        self.hand.hear(Push(str(order["kind"]), str(order["frame"]), ways, turned, moves, turns))

    def _select_step(self, name: str, step: int) -> None:
        """Program and step as the operator chooses them: START begins there."""
        wrong = self._choose(name)
        if wrong:
            self._say(Message(wrong, None, name, step, "operating"))
            return
        self._leave()
        self.robot.to_step(step)

    def _show(self, name: str) -> None:
        """The value of a variable, global or of the program in work (L1354-1358)."""
        try:
            value = self._value(name)
        except NotYet:
            self.port.send("value", name=name, text="the cell is read where the position under way is reached")
        except (StepFault, OperandFault) as fault:
            self.port.send("value", name=name, text=getattr(fault, "text", str(fault)))
        else:
            self.port.send("value", name=name, value=value)

    def _value(self, name: str) -> Fact:
        """Return the value of a name; a structure with all elements in one text.  Without a program there are no local names."""
        if self.machine.frame is None:
            self.machine.names = {**self.machine.system, **self.memory.globals}
        meant = operand(name)
        found = variable(self.machine, meant) if isinstance(meant, Ref) and not meant.element else None
        if isinstance(found, Structure):
            words = "  ".join(f"{key.lstrip('.')} {value:g}" for key, value in flat("", found) if isinstance(value, int | float))
            if not words:
                raise StepFault(UNSET)
            return words
        return scalar(self.machine, meant)()

    def _change(self) -> None:
        """To the program named in _SNMIPRG (L2921)."""
        cell = self.machine.system["_SNMIPRG"]
        name = str(cell.value or "").strip() if isinstance(cell, Cell) else ""
        wrong = self._choose(name) if name else "_SNMIPRG names no program"
        if wrong:
            self._say(Message(wrong, None, name, 1, "operating"))

    def path_given(self, ticket: int, job: int) -> None:
        """The robot moves for the program from now on."""
        self.path.given(ticket, job)
        stretch = self.path.now
        if stretch is not None and stretch.job == job and stretch.ticket == ticket:
            for text in head(self.arm.units):
                self.port.line(job, text)

    def path_over(self, ticket: int, error: RuntimeFault | None, now: Ns) -> None:
        """It does not any more; the program stops on its path, with an error where the planner has refused a position."""
        self._at(now)
        block = self._refused(ticket)
        stretch = self.path.ended(ticket, error)
        if stretch is None:
            return
        if stretch.owner is self.hand:
            planned = self.port.view.path_of(stretch.robot).failed_job == stretch.job > 0
            self.hand.over(stretch, error.text if error is not None and error.code != LEFT else "", planned=planned)
            return
        self.ahead.look(self.port.view.set)
        self.ahead.left(stretch)
        if error is None or error.code == LEFT or not self.runs:
            return
        if block is not None:
            self.robot.fails(StepFault(error.text, 0, "path"), block.place)
            self._over(None)
            return
        self.robot.stop(now)
        self.robot.how = "aborted"
        self._say(Message(error.text, None, *self.robot.place(), "operating"))
        self._over(error)

    def _refused(self, ticket: int) -> Block | None:
        """The position the planner could not plan."""
        stretch: Stretch | None = self.path.now
        if stretch is None or stretch.ticket != ticket:
            return None
        path = self.port.view.path_of(stretch.robot)
        if path.failed_job != stretch.job or not stretch.job:
            return None
        blocks = [item for item in self.ahead.items if isinstance(item, Block)]
        return next((block for block in blocks if block.stretch is stretch and block.index >= path.fault_block), None)

    # ---- turns -----------------------------------------------------------------------------------------------------------
    def _at(self, now: Ns) -> None:
        self.world.now = now

    def turn(self, now: Ns) -> bool:
        """Continue the program; True: it could continue at once."""
        self._at(now)
        self.path.look()
        self.ahead.look(self.port.view.set)
        before = self.robot.cursor()
        self.robot.advance(now)
        self.world.report_progress(now)
        if self.machine.tool is not self._tool:
            self._tool = self.machine.tool
            self.port.send("tool", values=" ".join(f"{value:.10g}" for value in tool_values(self._tool)))
        if self.runs:
            name = self.selected.key if self.selected is not None else ""
            self.ahead.hand_on(self, name, self.port.view.set, one=self.robot.single)
            if self.robot.waits:
                self.ahead.settle()
        else:
            self._over(None)
            if not self.ahead.busy:
                self.path.release(self)  # others may move the axes
            self.hand.look(self.port.view.set, now)
        return self.runs and not self.robot.waits and not self.machine.idle and self.robot.cursor() != before

    def _over(self, error: RuntimeFault | None) -> None:
        """The run that has ended is reported."""
        if not self.run or self.runs:
            return
        run, self.run = self.run, 0
        program, step = self.robot.place()
        fault, message = error, self.robot.fault
        if message is not None:
            fault, (program, step) = RuntimeFault(message.number or 0, message.text), (message.program, message.step)
        self.port.over(run, self.robot.how or "stopped", fault, f"{program} step {step}")

    def _say(self, message: Message) -> None:
        facts: dict[str, Fact] = {"text": message.text, "number": message.number or 0, "program": message.program}
        self.port.send("message", **facts, step=message.step, kind=message.kind)

    def _key_of(self, name: str) -> str:
        """The key of a program in work: programs of two directories may have one name."""
        assert self.selected is not None
        frames = (frame.program for frame in reversed(self.machine.stack))
        found = next((program for program in frames if program.name == name), self.memory.find(name) if name else self.selected)
        return name if found is None else found.key

    def rows(self) -> Sequence[ProcessRow]:
        """The program that is selected."""
        if self.selected is None:
            return []
        program, step = self.robot.place()
        asked = self.machine.request
        state = self.robot.state.value
        keys = isinstance(asked, KeyTest) or (isinstance(asked, BitWait) and asked.keys)
        waits = "" if asked is None or self.ahead.busy else "F1 or F2" if keys else WAITS.get(type(asked), "")
        name, done = self.robot.done()
        row = ProcessRow(
            self.run,
            self._key_of(program),
            self.selected.kind,
            state,
            step,
            waits,
            done=done if name == program else 0,
            inquiry=self.robot.inquiry,
        )
        if self.runs:
            return [row]
        return [replace(row, waits="", state="held" if self.robot.how == BREAKPOINT else row.state)]
