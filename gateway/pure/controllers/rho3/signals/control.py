"""The old controller as its PLC sees it: signals, functions and processes on one image, once per cycle of the services.  Pure.

The command sources bring the RC inputs, the cycle what the axes do; outputs and flags go back to the command sources, commands of the
axes through the dispatcher.  A restart of services counts as a start of the control (AX-332): signals already set start nothing.
"""

from collections.abc import Mapping

from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.functions.plc import Functions
from gateway.pure.controllers.rho3.functions.processes import Kind, Process, ProcessTable, Program, State
from gateway.pure.controllers.rho3.pendant.panel import Panel
from gateway.pure.controllers.rho3.pendant.screen2000 import Screen2000
from gateway.pure.controllers.rho3.pendant.user_memory import UserMemory
from gateway.pure.controllers.rho3.signals.analog import AnalogChannels
from gateway.pure.controllers.rho3.signals.codes import EMERGENCY_STOP, PIC_TIMER, code_text
from gateway.pure.controllers.rho3.signals.commands import AxisCommands
from gateway.pure.controllers.rho3.signals.control_pendant import ControlPendant
from gateway.pure.controllers.rho3.signals.control_state import ControlState
from gateway.pure.controllers.rho3.signals.control_values import ControlValues
from gateway.pure.controllers.rho3.signals.coupling import Coupled
from gateway.pure.controllers.rho3.signals.drives import DriveOn
from gateway.pure.controllers.rho3.signals.errors import RHO3
from gateway.pure.controllers.rho3.signals.fast_io import Channels
from gateway.pure.controllers.rho3.signals.hosted import INTERPRETER_GONE, HostedPrograms
from gateway.pure.controllers.rho3.signals.modes import TEST_MN, OperatingModes
from gateway.pure.controllers.rho3.signals.pic import PicLink
from gateway.pure.controllers.rho3.signals.program_moves import ProgramMoves
from gateway.pure.controllers.rho3.signals.setup import Setup
from gateway.pure.controllers.rho3.signals.steps import Step, body_maker, fault_of
from gateway.pure.controllers.rho3.signals.watches import Watches
from gateway.pure.controllers.rho3.signals.whole import Seen, SignalInterface
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records import interpreter
from gateway.pure.image.records.cell import RC_BYTES, CellState, InputImage, Permit, get_bit, set_bit
from motion.program.factors import FactorTable, Operation
from protocols.base.machine import Ns

STARTUP = 107  # RC output: run-up finished (rho3 L728-732)
KEEP_PERMANENT = 61  # RC input (L2620)
RESET_MODE = "11.1"  # mode of the panel that resets (L3059)


class RhoControl:
    """Call `step` once per cycle of the services."""

    def __init__(self, setup: Setup, dispatcher: CommandDispatcher, errors: ErrorList, now: Ns) -> None:
        """ValueError: a parameter out of its range."""
        self.image = PicImage()
        self.interface = SignalInterface(self.image, setup.installation, setup.numbers, errors, pic=setup.pic)
        self.processes = ProcessTable(self._programs(setup))
        self.functions = Functions(setup.functions, errors, self.processes)
        occupied = {bit >> 3 for bit in range(8 * RC_BYTES) if get_bit(setup.of_cycle, bit)}
        self.channels = Channels(setup.fast, self.interface.user, occupied)
        self.hosted: HostedPrograms | None = None  # programs of the interpreter
        self._commands = AxisCommands(dispatcher, setup.sets_override)
        self._drive_on = DriveOn(len(setup.axes), lambda byte: setup.owners.get(byte, 0))
        self._watches = Watches(setup, self.interface.faults, now)
        self._keep = int.from_bytes(setup.of_cycle, "little") ^ (1 << 8 * RC_BYTES) - 1
        self._last = now  # cycle
        table = FactorTable(setup.installation.kinematics, setup.option)
        modes, user = self.interface.modes, self.interface.user
        self.view = ControlState(setup, errors, self.image, modes, user, self.processes, self.channels, table, now)
        self.view.screen.p35 = setup.p35
        self.pendant = ControlPendant(self.view, self.functions)
        self.moves = ProgramMoves(self.view, self._commands, lambda: self.hosted)
        self.values = ControlValues(user, self.channels, self.pic, board=bool(setup.coupling))

    @property
    def now(self) -> Ns:
        """Of the last cycle."""
        return self.view.now

    @property
    def setup(self) -> Setup:
        """As the cell has it."""
        return self.view.setup

    @property
    def errors(self) -> ErrorList:
        """Of the cell."""
        return self.view.errors

    @property
    def modes(self) -> OperatingModes:
        """Of its interface."""
        return self.interface.modes

    @property
    def factor_table(self) -> FactorTable:
        """Factors of speed and acceleration."""
        return self.view.factor_table

    @property
    def panel(self) -> Panel:
        """Of its pendant."""
        return self.pendant.panel

    @property
    def outputs(self) -> bytes:
        """RC outputs of the cycle and of the control."""
        return bytes(self.image.outputs)

    @property
    def coupled(self) -> Coupled | None:
        """Its bit coupling; None: P20 has none."""
        coupling = self.setup.coupling
        return None if coupling is None else Coupled(coupling, self.image, self.values.board_in, self.values.board_out)

    # ---- one cycle -----------------------------------------------------------------------------------------------------
    def step(self, inputs: InputImage, cycle: bytes, state: CellState, now: Ns, *, heard: bool = False) -> list[str]:
        """`cycle`: RC outputs as the cycle published them; `heard`: the PLC has transmitted since.  Return messages for the operator."""
        self.view.now, self.view.cell = now, state
        if self.pic is not None and self.pic.stopped:
            self.image.clear()
            return self._halt(now, first=self.pic.fails())
        texts: list[str] = []
        before = self.halted
        self._watches.run(self.image, now, lambda: texts.extend(self._cycle(inputs, cycle, state, now, heard=heard)))
        return self._halt(now, first=not before) if self._watches.guarded and self.halted else texts

    @property
    def pic(self) -> PicLink | None:
        """The PIC program of the interpreter, where the cell has one."""
        return self.interface.pic

    @property
    def screen(self) -> Screen2000:
        """Of its PHG 2000."""
        return self.view.screen

    @property
    def memory(self) -> UserMemory:
        """The user memory as the pendant sees it."""
        return self.view.memory

    @property
    def halted(self) -> bool:
        """The PIC's timer has failed: inputs and outputs stay 0 and READY stays open until a restart."""
        return self._watches.stopped or (self.pic is not None and self.pic.stopped)

    def _halt(self, now: Ns, *, first: bool) -> list[str]:
        """Prevent motion and drive-on: keep READY open against every fault reset."""
        self._commands.bar((1 << len(self.setup.axes)) - 1)
        if self.view.cell.generation and not self.view.cell.emergency:
            self._commands.open_ready()
        if not first:
            return []
        self.interface.faults.came(PIC_TIMER, active=True, now=now)
        return [f"{code_text(PIC_TIMER, self.setup.functions.language)} ({PIC_TIMER})"]

    def _cycle(self, inputs: InputImage, cycle: bytes, state: CellState, now: Ns, *, heard: bool) -> list[str]:
        self._look(inputs, cycle, state)
        self._watches.look(state, now, heard=heard)
        image, setup = self.image, self.setup
        panel_reset = self.functions.phg.mode == RESET_MODE
        emergency = image.input(setup.emergency_op)
        seen = self.interface.step(now - self._last, self.pendant.used, emergency, panel_reset, now)
        self._last = now
        texts = self._react(seen)
        if self.hosted is not None and self.hosted.gone:
            self.hosted.gone = False
            self.interface.faults.came(INTERPRETER_GONE, now=now)
        texts += [refusal.text(setup.functions.language) for refusal in self.functions.step(inputs, image.outputs, now)]
        self.pendant.step(now)
        if self.pendant.view.memory_done():
            self._start_up()
        self._look_at_memory(now)
        self.processes.take_stopped()
        self.moves.end(now)
        self._commands.drives(self._drive_on.look(image), self._drive_on.wanted, seen.disabled, now)
        self._commands.bar(seen.disabled)
        self._commands.settle(now)
        self.channels.step(image)
        image.put(STARTUP, bool(state.generation))
        if self.pic is not None:
            self.pic.overlay()
        self._overlay(cycle)
        return texts

    def _look(self, inputs: InputImage, cycle: bytes, state: CellState) -> None:
        """The image as the control sees it: command sources, inputs that are not wired, the chain as the cycle latched it (AX-335)."""
        image, view = self.image, self.view
        image.take(inputs)
        for bit in self.setup.assumed:
            set_bit(image.inputs, bit, True)
        if state.generation:
            view.closed = not state.emergency or bool(state.permits & Permit.CHAIN)
            if not state.emergency:
                self.interface.faults.forget(EMERGENCY_STOP)  # released by another command source's fault reset
        set_bit(image.inputs, self.setup.numbers.chain, view.closed)
        view.hosted = self.hosted
        self._overlay(cycle)

    def _overlay(self, cycle: bytes) -> None:
        merged = int.from_bytes(self.image.outputs, "little") & self._keep | int.from_bytes(cycle, "little") & ~self._keep
        self.image.outputs[:] = (merged & (1 << 8 * RC_BYTES) - 1).to_bytes(RC_BYTES, "little")

    def _look_at_memory(self, now: Ns) -> None:
        """Where the SRAM card is gone (L11431-11436), no program runs until a restart."""
        code = self.memory.error_code
        if code and code not in (each.code for each in self.errors.records):
            self.interface.faults.came(code, active=True, now=now)
        if code and self.processes.processes:
            self.processes.control_reset(keep_permanent=False)

    def _start_up(self) -> None:
        """After the user memory was saved, loaded or put on a card (L4881, L4905, L11472)."""
        self.view.memory.ordered = "", 0
        self.processes.control_reset(keep_permanent=False)
        self.factor_table.happened(Operation.CONTROL_RESET)
        if self.hosted is not None:
            self.hosted.orders.append({"do": "hello"})
        self.panel.enter(())

    # ---- programs ------------------------------------------------------------------------------------------------------
    def _programs(self, setup: Setup) -> dict[str, Program]:
        language = setup.functions.language
        return {
            each.name.upper(): Program(
                body_maker(each.name.upper(), each.steps, each.kinematics, self, repeat=each.repeat, language=language),
                Kind.PERMANENT if each.permanent else Kind.NORMAL,
                each.priority,
                sum(1 << number - 1 for number in each.kinematics),
            )
            for each in setup.programs
        }

    def move(self, program: str, step: Step, now: Ns) -> Job:
        """What a program moves; refused as any other command of that command source."""
        return self.moves.begin(program, step, now)

    def open_path(self, program: str, robot: int, now: Ns) -> Job:
        """A program of the interpreter moves a robot from now on; refused as any other command of its command source.  ProcessFault."""
        return self.moves.open_path(program, robot)

    def open_reference(self, program: str, robot: int, now: Ns) -> Job:
        """REF_PNT: a program references a robot, as its command source would."""
        return self.moves.open_reference(program, robot, now)

    def slow(self, move: Job, share: float) -> None:
        """POTI_MODIFY: what the program moves goes at this share, 0 .. 1, of the speed it was planned with."""
        self._commands.slow(move, share)

    def run_on(self, robot: int, distance: float) -> None:
        """MOVE_DIST: m or rad that a robot continues after an edge."""
        self._commands.run_on(self.setup.robot_masks[robot - 1], distance)

    def test_allowed(self) -> bool:
        """Whether the PLC has selected the test; where no command source writes its signal, it always is."""
        return TEST_MN >> 3 not in self.setup.owners or self.image.input(TEST_MN)

    def path_closed(self, program: str, robot: int) -> None:
        """Its order is over."""
        self.moves.closed(program, robot)

    @property
    def analog(self) -> AnalogChannels | None:
        """Channels that carry numbers; None: the cell runs no BAPS2 programs."""
        return self.channels.analog

    def panel_text(self, written: str) -> None:
        """WRITE PHG."""
        self.pendant.written.write(written)

    def seen(self) -> interpreter.Channels:
        """The interface as programs of the interpreter see it."""
        fast = self.channels.fast
        given = [channel for channel in fast.channels() if channel < interpreter.FIRST_FAST + interpreter.FAST]
        values = sum(fast.read(channel) << channel - interpreter.FIRST_FAST for channel in given)
        multi = self.channels.multi
        first = interpreter.FIRST_MULTI
        inputs = None if multi is None else sum(multi.read(first + n) << n for n in range(interpreter.MULTI))
        factors = self.factor_table.global_factors()
        integers = bytes(self.interface.user.integer(401 + n) & 0xFF for n in range(8))
        reals = (0, (0.0,) * interpreter.REALS) if self.analog is None else self.analog.seen
        return interpreter.Channels(
            bytes(self.image.inputs),
            bytes(self.image.outputs),
            integers,
            values,
            sum(1 << channel - interpreter.FIRST_FAST for channel in given),
            inputs,
            0 if multi is None else multi.outputs,
            (factors.velocity, factors.acceleration, factors.deceleration),
            reals_given=reals[0],
            reals=reals[1],
        )

    def start(self, name: str) -> Process:
        """From the panel or a tool; raises ProcessFault."""
        return self.processes.start(name)

    def _react(self, seen: Seen) -> list[str]:
        texts = []
        for fault in seen.switched:
            process = self.processes.named(fault.program)
            if process is not None:
                reason = fault_of(fault)
                process.state, process.error, process.error_text = State.FAULTY, reason.code, reason.text
                self.interface.faults.came(reason.code, where=process.name, now=self.now)
                texts.append(f"{process.name}: {reason.text}")
        if seen.outcome.processes_end:
            self.factor_table.happened(Operation.CONTROL_RESET)
            gone = self.processes.control_reset(keep_permanent=self.image.input(KEEP_PERMANENT))
            texts += [f"{name}: ended by Control reset" for name in gone]
        for process in self.processes.processes:
            if process.state is State.FAULTY and process.error in seen.outcome.cleared:
                self.processes.stop(process.number)
        return texts

    # ---- what others see -----------------------------------------------------------------------------------------------
    def flag_bytes(self) -> bytes:
        """M 0.. of the PIC."""
        return bytes(self.image.flags)

    def write_flags(self, first: int, data: bytes) -> bool:
        """Write flag bytes from `first` on, as the program of the PIC would; False: beyond the last flag."""
        if first + len(data) > len(self.image.flags):
            return False
        self.image.flags[first : first + len(data)] = data
        if self.pic is not None:
            self.pic.write_flags(first, data)
        return True

    def retained(self) -> bytes:
        """All flags."""
        return bytes(self.image.flags)

    def restore(self, flags: bytes, counters: Mapping[int, int]) -> None:
        """Flags and counters as they were kept; a decrement flag already set counts nothing."""
        self.image.flags[: len(flags)] = flags
        for number, value in counters.items():
            if number < len(self.interface.timers.counters):
                self.interface.timers.counters[number] = value

    def timer(self, number: int) -> int | None:
        """Rest of timer `number` in ms; None: there is none."""
        left = self.interface.timers.left
        return left[number] // 1_000_000 if number < len(left) else None

    def counter(self, number: int) -> int | None:
        """Counter `number`."""
        counters = self.interface.timers.counters
        return counters[number] if number < len(counters) else None

    def names(self) -> list[str]:
        """Return the values other than signals."""
        return list(self.values.names)

    def value(self, name: str) -> float:
        """One of them; KeyError."""
        return self.values.value(name)

    def put(self, name: str, value: float) -> None:
        """What is wired; KeyError for anything else, ValueError out of range."""
        self.values.put(name, value)

    def status(self) -> dict[str, object]:
        """For tools and pages."""
        language = self.setup.functions.language
        errors = [
            {"code": each.code, "where": each.where, "text": code_text(each.code, language), "active": each.active, "count": each.count}
            for each in self.errors.records
            if each.source == RHO3
        ]
        processes = [
            {
                "name": each.name,
                "kind": each.kind.name,
                "state": each.state.name,
                "error": each.error,
                "why": each.error_text,
                "line": each.line,
            }
            for each in self.processes.processes
        ]  # fmt: skip
        automatic = [self.modes.automatic(number + 1) for number in range(self.setup.installation.kinematics)]
        return {
            "kind": "rho3", "automatic": automatic, "mode": self.functions.phg.mode,
            "screen": list(self.functions.display.screen()), "processes": processes[:20], "errors": errors[:16],
        }  # fmt: skip
