"""A cell in virtual time: inputs, outputs, markers, a robot that follows its commands, a script of orders, and what happened.

Pure: only virtual time passes, so the same input produces the same events.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.robotstar.faults import INPUT_WRITTEN, StepFault
from gateway.pure.languages.robotstar.initial import initialise
from gateway.pure.languages.robotstar.machine import Go, Machine
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.operands import signed
from gateway.pure.languages.robotstar.path import Target, between
from gateway.pure.languages.robotstar.program import Program
from gateway.pure.languages.robotstar.progress import FIRST, Progress, length_of
from gateway.pure.languages.robotstar.robot import Message, Mode, Robot, State
from gateway.pure.languages.robotstar.script import NS, VALUES, Order
from gateway.pure.languages.robotstar.steps import build
from gateway.pure.languages.robotstar.system import System
from gateway.pure.languages.robotstar.values import Cell, Structure, flat

BASES = {"INPUT": 1968, "OUTPUT": 2008, "MARKER": 0}  # markers that mirror the inputs and outputs (L2985-2986)
ANALOG_INPUTS, ANALOG_OUTPUTS, SCALE = 1872, 1920, (2**15 - 1) / 10
POWER_ON, HOLD, REQUESTS, FACTOR, MODE_CODE, MOVES = (1020, 4), (1020, 7), 968, 1436, 1022, (1021, 5)
INQUIRY = 996  # the input that is waited for (L2937)
ERROR_NUMBER, IN_ERROR, ACKNOWLEDGED = 944, (1021, 0), (1021, 1)
DEFAULT_UNTIL = 600 * NS
AFTER = NS  # the PLC still scans once the program has stopped
Event = dict[str, object]


class Plc(Protocol):
    """The integrated PLC: scans the marker image."""

    def power_on(self, cell: "VirtualCell") -> None:
        """Starts, or refuses with the reason."""

    def scan(self, cell: "VirtualCell", now: Ns) -> Ns:
        """One look; when the next is due."""

    def acknowledge(self, cell: "VirtualCell") -> None:
        """The operator has acknowledged."""

    def owned(self, number: int) -> int:
        """The bits of an output byte that its last scan wrote."""


# ---- cell ------------------------------------------------------------------------------------------------------------------
@dataclass(slots=True)
class VirtualCell:
    """One control with its cell."""

    memory: Memory
    mode: Mode
    plc: Plc | None = None
    start_pose: Target = field(default_factory=lambda: Target((0.0,) * 6))
    reaches: Callable[[Target, Structure | None], str] = lambda target, tool: ""  # with this tool; "" or why not
    paused: Callable[[], bool] = lambda: False  # a debugger holds the program, and time with it
    events: list[Event] = field(default_factory=list)
    image: bytearray = field(default_factory=lambda: bytearray(2048))
    drives: bool = True
    now: Ns = 0
    robot: Robot = field(init=False)
    system: System = field(init=False)
    _volts: dict[int, tuple[int, float]] = field(default_factory=dict)
    _from: Target = field(default_factory=Target)
    _at: Target = field(default_factory=Target)
    _to: Target | None = None
    _progress: Progress = field(default_factory=Progress)
    _seen: tuple[bool, bool] = (False, False)  # of M968.0 and .1
    _plc_due: Ns | None = None

    def __post_init__(self) -> None:
        self.system = System(self, path_left=lambda number: self._progress.values()[number - 1])
        machine = Machine(self.memory, self, self.system.names(), build)
        self.system.machine = machine
        self.robot = Robot(machine, self.mode, self, self.say)
        self._at = self._from = self.start_pose
        self.image[FACTOR : FACTOR + 4] = (100).to_bytes(4, "little")

    # ---- what programs see (Surroundings) --------------------------------------------------------------------------------
    def byte(self, area: str, number: int) -> int:
        """A byte of an area."""
        return self.image[BASES[area] + number]

    def set_bit(self, area: str, number: int, bit: int, level: bool) -> None:
        """One bit of an area."""
        self._put(BASES[area] + number, _with_bit(self.byte(area, number), bit, level))

    def element(self, area: str, number: int) -> int:
        """Four bytes, the lowest first."""
        place = BASES[area] + number
        return signed(int.from_bytes(self.image[place : place + 4], "little"))

    def set_element(self, area: str, number: int, value: int) -> None:
        """Writes four bytes."""
        for at, byte in enumerate((value & 0xFFFFFFFF).to_bytes(4, "little")):
            self._put(BASES[area] + number + at, byte)

    def _put(self, marker: int, value: int) -> None:
        """A byte as the robot program writes it: output bits of the PLC keep its value (L2274)."""
        if BASES["INPUT"] <= marker < BASES["OUTPUT"]:
            raise StepFault(INPUT_WRITTEN)
        if self.plc is not None and marker >= BASES["OUTPUT"]:
            own = self.plc.owned(marker - BASES["OUTPUT"])
            value = self.image[marker] & own | value & ~own
        self.set_byte(marker, value)

    def set_byte(self, marker: int, value: int) -> None:
        """Writes a marker byte; a change is an event."""
        if self.image[marker] != value:
            self.image[marker] = value
            if marker >= BASES["OUTPUT"]:
                self._event(f"A{marker - BASES['OUTPUT']}", value)
            elif marker < BASES["INPUT"]:
                self._event(f"M{marker}", value)

    def analog_input(self, channel: int) -> float:
        """Volts; as given by the script while its marker keeps the value."""
        place = ANALOG_INPUTS + 2 * (channel - 1)
        raw = int.from_bytes(self.image[place : place + 2], "little", signed=True)
        kept, volts = self._volts.get(channel, (0, 0.0))
        return volts if raw == kept else raw / SCALE

    def set_analog_output(self, channel: int, volts: float) -> None:
        """Volts into the marker."""
        place = ANALOG_OUTPUTS + 2 * (channel - 1)
        for at, byte in enumerate(round(volts * SCALE).to_bytes(2, "little", signed=True)):
            self.set_byte(place + at, byte)

    def actual(self) -> Target:
        """Where the robot is."""
        return self._at

    def based(self, target: Target) -> Target:
        """As it is: a virtual robot has no stations."""
        return target

    def seen_from(self, frame: int, target: Target) -> Target:
        """As it is."""
        del frame
        return target

    def planned(self) -> Target:
        """The same: nothing runs ahead here."""
        return self._at

    # ---- the robot (Drive) -----------------------------------------------------------------------------------------------
    def begin(self, target: Target, now: Ns) -> str:
        """A way begins where the robot is."""
        del now
        self._from, self._to = self._at, target
        request = self.robot.machine.request
        self._progress = Progress(length_of(self._at, target), request.whole / NS if isinstance(request, Go) else 0.0, 0.0)
        return self.reaches(target, self.robot.machine.tool)

    def way(self, part: float) -> None:
        """The robot is at `part` of its way."""
        if self._to is not None:
            self._at = between(self._from, self._to, part)
            self._progress = replace(self._progress, share=part)

    def arrived(self, target: Target, mode: str, now: Ns) -> None:
        """The position as gone to."""
        self._at, self._to = target, None
        self._progress = replace(self._progress, share=1.0)
        self.events.append({"at": _seconds(now), "what": "target", "mode": mode, "value": target.values()})

    def factor(self) -> float:
        """Override of M1436 in AUTO, Test 2 and Test 4 (L2967); M1020.7 holds (L2946)."""
        if self._bit(HOLD):
            return 0.0
        if self.mode.name not in ("auto", "test2", "test4"):
            return 1.0
        return min(max(signed(int.from_bytes(self.image[FACTOR : FACTOR + 4], "little")), 0), 100) / 100

    # ---- events ----------------------------------------------------------------------------------------------------------
    def _event(self, what: str, value: object) -> None:
        self.events.append({"at": _seconds(self.now), "what": what, "value": value})

    def state_event(self, value: str) -> None:
        """RUN or STOP of the PLC."""
        self._event("state", value)

    def say(self, message: Message) -> None:
        """A message of the control."""
        self.events.append(
            {
                "at": _seconds(self.now),
                "what": "message",
                "value": message.text,
                "number": message.number,
                "text": message.text,
                "program": message.program,
                "step": message.step,
                "class": message.kind,
            }
        )

    def refuse(self, text: str, program: str, step: int = 1, number: int | None = None) -> None:
        """A refused order."""
        self.say(Message(text, number, program, step, "operating"))

    def set_drives(self, on: bool) -> None:
        """Drives on or off; off stops the program."""
        if on != self.drives:
            self.drives = on
            self._event("drives", "ON" if on else "OFF")
        if not on:
            self.robot.stop(self.now)

    # ---- orders ----------------------------------------------------------------------------------------------------------
    def obey(self, order: Order) -> None:
        """One order of the script."""
        acts: Mapping[str, Callable[[], None]] = {
            "START": lambda: self.start(order.program),
            "EXEC": lambda: self.start(""),
            "STOP": lambda: self.robot.stop(self.now),
            "F1": lambda: self.robot.key(False),
            "F2": lambda: self.robot.key(True),
            "ACK": self.acknowledge,
            "POWER": self.power,
            "DRIVES": lambda: self.set_drives(bool(order.value)),
        }
        if order.what in acts:
            acts[order.what]()
        elif order.what == "EA":
            raw, place = round(order.value * SCALE), ANALOG_INPUTS + 2 * (order.place[0] - 1)
            self._volts[order.place[0]] = raw, order.value
            self.image[place : place + 2] = raw.to_bytes(2, "little", signed=True)
        else:
            number, bit = order.place
            area = "INPUT" if order.what == "E" else "MARKER"
            if bit is None:
                self.set_byte(BASES[area] + number, int(order.value))
            else:
                self.set_byte(BASES[area] + number, _with_bit(self.byte(area, number), bit, bool(order.value)))

    def start(self, name: str) -> None:
        """START, of the program selected or of another."""
        self.robot.advance(self.now)
        if name and not self.select(name):
            return
        program, step = self.robot.place()
        if not self.drives:
            self.refuse("START is refused: the drives are off", program, step)
            return
        wrong = self.robot.start(self.now)
        if wrong:
            self.refuse(f"START is refused: {wrong}", program, step)

    def select(self, name: str) -> bool:
        """Chooses a program by name; a message where it cannot run."""
        found = self.memory.find(name)
        if found is None:
            self.refuse(f"program {name} not found", name)
            return False
        if found.refused:
            self.refuse(found.refused[0][1], found.name, _step_of(found))
            return False
        if found.kind == "PAL":
            self.refuse(f"program {found.name} is a pallet program; it is not executed", found.name)
            return False
        self.robot.select(found)
        return True

    def acknowledge(self) -> None:
        """Quit."""
        shown = self.robot.failure is not None
        self.robot.acknowledge()
        if self.plc is not None:
            self.plc.acknowledge(self)
        if shown:
            self._set(ACKNOWLEDGED, True)

    def power(self) -> None:
        """Power off and on: values and markers are kept, outputs fall, the program is at its first step."""
        for number in range(40):
            self.set_byte(BASES["OUTPUT"] + number, 0)
        stack = self.robot.machine.stack
        self.robot.acknowledge()
        self.robot.stop(self.now)
        self.drives = True
        self._powered()
        if stack:
            self.robot.select(stack[0].program)

    def _powered(self) -> None:
        wrong, step, program = initialise(self.robot.machine)
        if wrong:
            self.say(Message(wrong, None, program, step, "programming"))
        self.image[POWER_ON[0]] |= 1 << POWER_ON[1]
        if self.plc is not None:
            self.plc.power_on(self)
            self._plc_due = self.now

    # ---- time ------------------------------------------------------------------------------------------------------------
    def run(self, script: Iterable[Order], until: Ns | None, program: str) -> None:
        """From power-on with START at 0 until the time is over or nothing can happen any more."""
        for _ in self.turns(script, until, program):
            pass

    def turns(self, script: Iterable[Order], until: Ns | None, program: str) -> Iterator[None]:
        """The same, moment by moment."""
        waiting = sorted(script, key=lambda order: order.at > 0 or order.what not in VALUES)
        end = DEFAULT_UNTIL if until is None else until
        while waiting and waiting[0].at <= 0 and waiting[0].what in VALUES:
            self.obey(waiting.pop(0))  # the program meets it as it begins
        self._powered()
        self._scan()
        self.start(program)
        while True:
            while waiting and waiting[0].at <= self.now:
                self.robot.advance(self.now)
                self.obey(waiting.pop(0))
            self._scan()
            self._requests()
            due = self.robot.advance(self.now)
            while self.paused():
                yield
                due = self.robot.advance(self.now)
            self._requests()
            self._fill()
            moments = [moment for moment in (due, self._plc_due, waiting[0].at if waiting else None) if moment is not None]
            if until is None and not waiting and self.robot.state in (State.STOPPED, State.ERROR):
                end = min(end, self.now + AFTER)
                until = end
            if not moments or min(moments) > end:
                self._last(end)
                return
            self.now = max(min(moments), self.now)
            yield

    def _last(self, end: Ns) -> None:
        """What is left of a way or a wait counts up to the end of the time."""
        if self.robot.state in (State.RUNNING, State.WAITING) and end > self.now:
            self.now = end
            self.robot.advance(end)

    def _scan(self) -> None:
        if self.plc is not None and self._plc_due is not None and self._plc_due <= self.now:
            self._fill()
            self._plc_due = self.plc.scan(self, self.now)

    def _requests(self) -> None:
        """Orders by markers (L2921-2923), in AUTO alone."""
        change, begins, stops = (bool(self.image[REQUESTS] >> bit & 1) for bit in range(3))
        if self.mode.name == "auto":
            if change and not self._seen[0]:
                self._change()
            if begins and not self._seen[1]:
                self.start("")
            if stops:
                self.robot.stop(self.now)
        self._seen = change, begins

    def _change(self) -> None:
        cell = self.robot.machine.system.get("_SNMIPRG")
        name = str(cell.value or "").strip() if isinstance(cell, Cell) else ""
        if name:
            self.select(name)

    def _fill(self) -> None:
        """System markers the robot fills (L2943-2963)."""
        self.image[MODE_CODE : MODE_CODE + 2] = self.mode.code.to_bytes(2, "little")
        self._set(MOVES, self.robot.moving and self.factor() > 0)  # held by M1020.7, or with an override of 0, it is at rest
        self._set((1020, 6), True)
        self._set((1021, 2), True)
        self._set(IN_ERROR, self.robot.failure is not None)
        number = 0
        if self.robot.failure is not None:
            number = self.robot.failure.number or 0
            self._set(ACKNOWLEDGED, False)
        self.image[ERROR_NUMBER : ERROR_NUMBER + 4] = number.to_bytes(4, "little")
        self.image[INQUIRY : INQUIRY + 4] = self.robot.inquiry.to_bytes(4, "little")
        for at, number in enumerate(self._progress.numbers()):
            self.image[FIRST + 4 * at : FIRST + 4 + 4 * at] = number.to_bytes(4, "little")
        pose = self._at.pose
        self._set((1120, 0), bool(pose))
        for at, value in enumerate(pose):
            self.image[1124 + 4 * at : 1128 + 4 * at] = (round(value * 100) & 0xFFFFFFFF).to_bytes(4, "little")

    def _bit(self, place: tuple[int, int]) -> bool:
        return bool(self.image[place[0]] >> place[1] & 1)

    def _set(self, place: tuple[int, int], level: bool) -> None:
        mask = 1 << place[1]
        self.image[place[0]] = self.image[place[0]] | mask if level else self.image[place[0]] & ~mask

    # ---- result ----------------------------------------------------------------------------------------------------------
    def end(self, program: str) -> dict[str, object]:
        """State, program, step and the global variables."""
        name, step = self.robot.place()
        refused = not name and any(event["what"] == "message" for event in self.events)
        variables = {key: value for name_, variable in sorted(self.memory.globals.items()) for key, value in flat(name_, variable)}
        return {
            "state": State.ERROR.value if refused else self.robot.state.value,
            "program": name or program,
            "step": step or 1,
            "variables": variables,
        }


def _with_bit(byte: int, bit: int, level: bool) -> int:
    return byte | 1 << bit if level else byte & ~(1 << bit)


def _seconds(now: Ns) -> float:
    return round(now / NS, 6)


def _step_of(program: Program) -> int:
    """The step of the first fault."""
    line = program.refused[0][0]
    return next((step.number for step in program.steps if step.line == line), 1)
