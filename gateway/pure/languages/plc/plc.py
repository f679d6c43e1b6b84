"""The integrated PLC of the ROBOTstar V: start, scan, errors, messages, retention, test display.  Source: robotstar 5."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.plc.cells import CELLS, KEPT
from gateway.pure.languages.plc.commands import Program
from gateway.pure.languages.plc.copies import DamagedCopy, from_bytes, to_bytes
from gateway.pure.languages.plc.generated import Generated
from gateway.pure.languages.plc.interpreter import Interpreter, More, Shown
from gateway.pure.languages.plc.messages import (
    DRIVES_OFF,
    MEMORY,
    NOTE,
    OVERLOAD,
    STOPS,
    TEXT_PROGRAM,
    TIME,
    Message,
    Text,
    ordered,
    read_texts,
    runtime_error,
)
from gateway.pure.languages.plc.state import Layout, State, TimeError
from gateway.pure.languages.plc.steps import AREA, INPUTS, OUTPUTS, SIZE
from gateway.pure.languages.plc.translation import Translation, key_of

LAYOUT = Layout(SIZE, INPUTS, OUTPUTS, AREA, (1020, 1 << 5))
ERROR_NUMBER, ORDER, PARAMETERS = 944, 948, (952, 956, 960, 964)
POWER_ON, IN_ERROR, ACKNOWLEDGED, INITIALISED, DISPLAY = (1020, 4), (1021, 0), (1021, 1), (1021, 2), (1021, 6)
COMMANDS_PER_TICK = 10_000  # of a scan without an end: 1 us each (AX-745)
TICK_NS = 10_000_000
UNBOUNDED = 1 << 62


class PlcState(Enum):
    """Whether the program is in cyclic treatment."""

    RUN = "RUN"
    STOP = "STOP"


@dataclass(frozen=True, slots=True)
class Settings:
    """`load`: commands a period (IPLC_LOAD), None: a complete scan, 0: the PLC is off; `watchdog`: _ITIME_PLC in 1/100 s."""

    load: int | None = None
    watchdog: int = 30
    more: More | None = None  # asked once a scan has used its allowance of commands; without it the scan is too long


@dataclass(slots=True)
class Plc:
    """One integrated PLC.  `sources` is live: programs by name, read again at each start and nowhere else but for the test display."""

    sources: Mapping[str, str]
    settings: Settings = field(default_factory=Settings)
    drives: bool = True
    state: PlcState = PlcState.STOP
    scans: int = 0  # complete ones
    data: State = field(default_factory=lambda: State(LAYOUT))
    program: Program | None = None
    shown_message: Message | None = None  # until it is acknowledged
    _texts: Mapping[int, Text] = field(default_factory=dict)
    _copy: Mapping[str, str] = field(default_factory=dict)
    _interpreter: Interpreter | None = None
    _generated: Generated | None = None
    _messages: list[Message] = field(default_factory=list)
    _outputs: bytes = bytes(AREA)
    _begun_ns: int | None = None
    _watched: str = ""

    def __post_init__(self) -> None:
        self.set_bit(*POWER_ON, True)
        self.set_bit(*INITIALISED, True)

    def start(self, name: str) -> list[Message]:
        """Start PLC: translate and adopt the copy.  Return the messages of a refused start, which leaves the running program unchanged."""
        translation = Translation({key: text for key, text in self.sources.items() if key_of(key) != TEXT_PROGRAM})
        program = translation.run(name)
        texts = read_texts(self._text_program(), translation.faults)
        if program is None or translation.faults.errors:
            refused = self._refusals(translation)
            self._messages += refused
            return refused
        self._copy = {key_of(key): text for key, text in self.sources.items() if key_of(key) in program.routines}
        self._take(program, texts)
        return []

    def copy(self) -> bytes:
        """The program that runs, to come back with after the process was killed.  ValueError: none was started."""
        if self.program is None:
            raise ValueError("no PLC program was started")
        return to_bytes(self.program)

    def start_copy(self, copy: bytes) -> list[Message]:
        """Start a result of `copy`; outputs are 0 until its first complete scan.  Return the message of a copy that cannot run: 7003 or
        7004.
        """
        try:
            program = from_bytes(copy)
        except DamagedCopy as damaged:
            message = runtime_error(damaged.number)
            self._fail(message)
            return [message]
        self._outputs = bytes(AREA)
        self._take(program, read_texts(self._text_program(), Faults()))
        return []

    def overload(self) -> None:
        """The load does not fit into the interpolation cycle (L2243): system error 1052, the PLC stops."""
        self._fail(Message(f"System error {OVERLOAD}", OVERLOAD, DRIVES_OFF))

    def stop(self) -> None:
        """Ends the cyclic treatment; all outputs are 0."""
        self.state, self._begun_ns = PlcState.STOP, None
        self.data.memory[OUTPUTS : OUTPUTS + AREA] = bytes(AREA)
        self._outputs = bytes(AREA)

    def scan(self, now_ns: int, inputs: bytes) -> bytes:
        """Run one period: read the inputs at the beginning of a scan, return the outputs of the last complete scan.  ValueError: not 40
        bytes.
        """
        if len(inputs) != AREA:
            raise ValueError(f"{len(inputs)} bytes of inputs, {AREA} expected")
        self.data.cells.now = now_ns
        if self.state is PlcState.STOP or self.settings.load == 0:
            self.data.memory[INPUTS : INPUTS + AREA] = inputs
            return self._outputs
        try:
            if self._period(now_ns, inputs):
                self._end_of_scan()
        except TimeError as error:
            self._fail(runtime_error(TIME, error.routine, error.line))
        except MemoryError:
            self._fail(runtime_error(MEMORY))
        return self._outputs

    def acknowledge(self) -> None:
        """The operator has acknowledged the message."""
        if self.shown_message is not None:
            self.shown_message = None
            self.set_bit(*IN_ERROR, False)
            self.set_number(ERROR_NUMBER, 0)
            self.set_bit(*ACKNOWLEDGED, True)

    def show(self, message: Message) -> None:
        """A message of the control comes up; one that is there already is not repeated."""
        if message == self.shown_message:
            return
        self.shown_message = message
        self._messages.append(message)
        self.set_bit(*ACKNOWLEDGED, False)
        if message.reaction != NOTE:
            self.set_bit(*IN_ERROR, True)
            self.set_number(ERROR_NUMBER, message.number or 0)
        if message.reaction == DRIVES_OFF:
            self.drives = False

    def take_messages(self) -> list[Message]:
        """Messages since the last call."""
        found, self._messages = self._messages, []
        return found

    @property
    def outputs(self) -> bytes:
        """Outputs of the last complete scan; all 0 while the PLC is stopped."""
        return self._outputs

    @property
    def outputs_written(self) -> bytes:
        """Mask of the output bits that the last scan wrote; the others are the robot program's (L2274)."""
        return bytes(self.data.written)

    def robot_output(self, byte: int, mask: int, bits: int) -> None:
        """Output bits as the robot program wrote them; those of the last scan remain the PLC's (L2274)."""
        mask &= ~self.data.written[byte]
        memory, at = self.data.memory, OUTPUTS + byte
        memory[at] = memory[at] & ~mask & 0xFF | bits & mask

    def marker(self, byte: int) -> int:
        """M `byte`."""
        return self.data.memory[_checked(byte, 1)]

    def set_marker(self, byte: int, value: int) -> None:
        """M `byte` = value, cut to 8 bits."""
        self.data.memory[_checked(byte, 1)] = value & 0xFF

    def bit(self, byte: int, bit: int) -> bool:
        """M byte.bit."""
        return bool(self.marker(byte) >> _bit(bit) & 1)

    def set_bit(self, byte: int, bit: int, value: bool) -> None:
        """M byte.bit = value."""
        kept = self.marker(byte) & ~(1 << _bit(bit))
        self.set_marker(byte, kept | value << bit)

    def number(self, byte: int) -> int:
        """Double word M byte to byte+3, the lowest byte first, signed."""
        return int.from_bytes(self.data.memory[_checked(byte, 4) : byte + 4], "little", signed=True)

    def set_number(self, byte: int, value: int) -> None:
        """The reverse of `number`; the value is cut to 32 bits."""
        self.data.memory[_checked(byte, 4) : byte + 4] = (value & 0xFFFFFFFF).to_bytes(4, "little")

    def retained(self, now_ns: int) -> bytes:
        """What outlives power-off: markers without the images of inputs and outputs, timers with their remaining times, counters."""
        self.data.cells.now = now_ns
        return bytes(self.data.memory[:INPUTS]) + self.data.cells.kept()

    def power_on(self, kept: bytes, now_ns: int) -> None:
        """Takes the retained data back and sets the power-on bit.  ValueError: damaged, nothing is changed."""
        if len(kept) != INPUTS + KEPT.size * CELLS:
            raise ValueError(f"{len(kept)} bytes of retained data, {INPUTS + KEPT.size * CELLS} expected")
        self.data.cells.now = now_ns
        self.data.cells.restore(kept[INPUTS:])
        self.data.memory[:INPUTS] = kept[:INPUTS]
        self.stop()
        self.shown_message = None
        for place, value in ((POWER_ON, True), (INITIALISED, True), (IN_ERROR, False), (ACKNOWLEDGED, False)):
            self.set_bit(*place, value)
        self.set_number(ERROR_NUMBER, 0)

    def watch(self, name: str) -> bool:
        """Test display for a program, from its next scan on; an empty name switches it off.  False: it does not run, or was edited."""
        self._watched = key_of(name) if name and self._coincides(key_of(name)) else ""
        self.set_bit(*DISPLAY, bool(self._watched))
        return bool(self._watched)

    @property
    def watched(self) -> tuple[str, str]:
        """Program of the test display and the source that runs; empty: it is off."""
        return self._watched, self._copy.get(self._watched, "")

    def display(self) -> Mapping[int, Shown]:
        """State, result and accumulators after each step of the last scan; a missing step was not executed (NOP, red)."""
        if self._watched and not self._coincides(self._watched):
            self.watch("")
        if not self._watched or self.program is None or self._interpreter is None:
            return {}
        commands = self.program.routines[self._watched].commands
        return {commands[at].line: shown for at, shown in sorted(self._interpreter.shown.items())}

    def _coincides(self, key: str) -> bool:
        text = next((text for name, text in self.sources.items() if key_of(name) == key), None)
        return text is not None and self._copy.get(key) == text

    def _text_program(self) -> str:
        return next((text for name, text in self.sources.items() if key_of(name) == TEXT_PROGRAM), "END")

    def _refusals(self, translation: Translation) -> list[Message]:
        """One message for each fault, with program and step."""
        found: list[Message] = []
        for fault in translation.faults:
            place = fault.position
            steps = {line: step for step, line in translation.lines.get(place.file, {}).items()}
            text = fault.text
            found.append(Message(text, None, STOPS, place.file, steps.get(place.line, place.line)))
        return found

    def _take(self, program: Program, texts: Mapping[int, Text]) -> None:
        more = self.settings.more or _too_long
        try:
            self._generated = Generated(program, self.data, more)
        except MemoryError:
            self._fail(runtime_error(MEMORY, program.start, 1))
            return
        self._interpreter = Interpreter(program, self.data, more)
        self.program, self._texts, self._begun_ns = program, texts, None
        self.state = PlcState.RUN if self.settings.load != 0 else PlcState.STOP

    def _period(self, now_ns: int, inputs: bytes) -> bool:
        """Runs what this period allows; True: the scan has ended."""
        assert self._interpreter is not None and self._generated is not None
        interpreted = self.settings.load is not None or bool(self._watched)
        allowance = self.settings.watchdog * COMMANDS_PER_TICK if self.settings.load is None else UNBOUNDED
        if self._begun_ns is None:
            self.data.memory[INPUTS : INPUTS + AREA] = inputs
            self.data.written[:] = bytes(AREA)
            if not interpreted:
                self._generated.scan(allowance)
                return True
            self._begun_ns = now_ns
            self._interpreter.watched = self._watched
            self._interpreter.begin(allowance)
        elif now_ns - self._begun_ns >= self.settings.watchdog * TICK_NS:
            raise TimeError(*self._interpreter.place)
        return self._interpreter.run(self.settings.load)

    def _end_of_scan(self) -> None:
        self.scans += 1
        self._begun_ns = None
        self._outputs = bytes(self.data.memory[OUTPUTS : OUTPUTS + AREA])
        order = self.number(ORDER)
        if order:
            message = ordered(order, self._texts, [self.number(at) for at in PARAMETERS], self.drives)
            self.set_number(ORDER, 0)
            if message is not None and self.program is not None:
                start = self.program.start  # its END is where the message comes up (L2857)
                self.show(replace(message, program=start, step=self.program.routines[start].last))

    def _fail(self, message: Message) -> None:
        self.stop()
        self.show(message)


def _too_long(routine: str, line: int) -> int:
    raise TimeError(routine, line)


def _checked(byte: int, size: int) -> int:
    if not 0 <= byte <= SIZE - size:
        raise ValueError(f"M{byte}: markers are M0 to M{SIZE - size}")
    return byte


def _bit(bit: int) -> int:
    if not 0 <= bit <= 7:
        raise ValueError(f"bit {bit}: bits are 0 to 7")
    return bit
