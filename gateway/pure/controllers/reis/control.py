"""A Reis ROBOTstar V as its PLC sees it: inputs, outputs and markers on the image, once per cycle of the services.  Pure.

Source: robotstar 4, 5.8, 5.9, 8.1; AX-336.  Command sources write markers as the integrated PLC's program did; the state of the axes is
in the
system markers.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from drivers.drives.servodyn_words import fault as booster_fault
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.reis.analog import ana_inp, output_volts
from gateway.pure.controllers.reis.binary import FIRST_BYTE, Area, BinaryIo, IoFault, SharedOutputs
from gateway.pure.controllers.reis.integrated import DRIVES_OFF, STOPS, IntegratedPlc
from gateway.pure.controllers.reis.keys import Keys
from gateway.pure.controllers.reis.markers import (
    ACKNOWLEDGED,
    ERROR_NUMBER,
    IN_ERROR,
    INPUTS,
    MODE,
    OUTPUTS,
    SIZE,
    STARTED,
    SYNCHRONOUS,
    SYSTEM,
    Markers,
)
from gateway.pure.controllers.reis.references import References
from gateway.pure.controllers.reis.regulator import Message, Reference, regulator_error, start
from gateway.pure.controllers.reis.robot_part import RobotPart
from gateway.pure.image.records.cell import AxisFlag, CellState, InputImage, Motion
from protocols.base.machine import Ns

HOLD, MOVES, PLUS, MINUS = (1020, 7), (1021, 5), (1021, 3), (1021, 4)
INQUIRY, OVERRIDE, ACTUAL, TCP, TCP_VALID, PATH = 996, 1436, 1024, 1124, (1120, 0), 1464
AUTO, HAND = 0x0300, 0x0101  # operating mode codes (robotstar 5.9)
MULTIPLIED = (AUTO, 0x0202, 0x0204)  # modes in which M1436 counts
AUTO_MN = 23  # RC input that selects it
OUTPUT_BYTES = 40
ACKNOWLEDGE = 62  # RC input: error acknowledgement
WATCHDOG, LAG, POWER = 667, 647, 654
LAST_OF_BOOSTERS = 0xFF  # one byte of the booster's telegram; a drive of CiA 402 begins at 1000h
FAULTS = (  # first fault code of CiA 402 -> regulator error, the last that is not above it counts (AX-337)
    (0x0000, POWER), (0x2300, 657), (0x2400, POWER), (0x3100, 653), (0x3400, POWER), (0x4200, 656), (0x4300, 656), (0x4310, 656),
    (0x4400, 658), (0x4500, POWER), (0x7300, 662), (0x7400, POWER), (0x8100, WATCHDOG), (0x8400, 671), (0x8600, LAG), (0x8700, POWER),
)  # fmt: skip
_ROBOTS = [(row.byte, row.bytes) for row in SYSTEM if row.writer == "robot" and row.bit is None]
_ROBOTS_BITS = {  # byte -> bits of it that are the robot's
    byte: sum(1 << row.bit for row in SYSTEM if row.writer == "robot" and row.byte == byte and row.bit is not None)
    for byte in {row.byte for row in SYSTEM if row.bit is not None}
}


def regulator_number(fault_code: int) -> int:
    """The regulator error for a drive's fault; faults without a number in the manual are "error of the power pack"."""
    if fault_code <= LAST_OF_BOOSTERS:
        return booster_fault(fault_code).number or POWER
    return next((number for first, number in reversed(FAULTS) if fault_code >= first), POWER)


@dataclass(frozen=True, slots=True)
class ReisSetup:
    """Settings from the cell."""

    axes: tuple[str, ...] = ()
    source: int = 0  # commands of markers come from it
    first_byte: int = FIRST_BYTE
    plc_only: Collection[int] = ()
    robot_only: Collection[int] = ()
    references: Mapping[int, Reference] = field(default_factory=dict)  # of the axes, 1..
    unit_per_si: tuple[float, ...] = ()  # mm or deg for each m or rad
    programs: bool = False  # the interpreter runs the robot's programs


class ReisControl:
    """Call `step` once per cycle of the services."""

    def __init__(self, setup: ReisSetup, dispatcher: CommandDispatcher) -> None:
        """IoFault: the 40 bytes do not fit."""
        self.setup, self._dispatcher = setup, dispatcher
        self.image = PicImage()
        self.io = BinaryIo(self.image, setup.first_byte)
        self.shared = SharedOutputs(self.io, setup.plc_only, setup.robot_only)
        self.markers = Markers(self.io)
        self.plc: IntegratedPlc | None = None  # a process of its own, where the cell has [controller.plc]
        self.robot = RobotPart()
        self.messages: list[Message] = []
        self._references = References(setup.references)
        self.was_synchronised(setup.references)
        self._active: dict[tuple[int, int], str] = {}  # regulator error, axis -> words
        # None: M1436 was never written and does not scale the speed (AX-1000)
        self._percent: int | None = self.markers.number(OVERRIDE) or None
        self._hold = True  # a hold that is set at start has stopped nothing
        self._stopped = False
        self._keep = slice(setup.first_byte, setup.first_byte + 40)

    @property
    def outputs(self) -> bytes:
        """RC outputs, the cycle's and the robot's."""
        return bytes(self.image.outputs)

    def was_synchronised(self, known: Mapping[int, Reference]) -> None:
        """Before the first step: what each axis was synchronised with when the control was last alive (677, 678, 679)."""
        self.messages = start(self.markers, known, self.setup.references)
        self._references.known(known, {message.axis for message in self.messages})

    @property
    def synchronised(self) -> Mapping[int, Reference]:
        """Axis -> machine data it was synchronised with last; kept over power-off."""
        return self._references.synchronised

    # ---- one cycle -----------------------------------------------------------------------------------------------------
    def step(self, inputs: InputImage, cycle: bytes, state: CellState, now: Ns, *, heard: bool = False) -> list[str]:
        """`cycle`: RC outputs as the cycle published them.  What a person should read."""
        self.image.take(inputs)
        own = bytes(self.image.outputs[self._keep])
        self.image.outputs[:] = cycle
        self.image.outputs[self._keep] = own
        if self.plc is not None:
            self._take_plc(self.plc)
        self.shared.end_of_cycle()
        texts = [message.text for message in self.messages]
        self.messages = []
        if state.generation:
            texts += self._errors(state)
            texts += self._look_at_drives(state, now)
            self._publish(state)
            self._obey(state, now)
            if self.plc is not None:
                self._react(self.plc, state, now)
        self._acknowledge()
        return texts

    # ---- the integrated PLC --------------------------------------------------------------------------------------------
    def _take_plc(self, plc: IntegratedPlc) -> None:
        """Adopt markers and outputs after its last scan; all outputs are 0 where it has stopped or is gone."""
        if plc.fresh:
            plc.fresh = False
            if plc.report.id:
                self.markers.by_plc(plc.report.markers)
        outputs = {(byte, bit): False for byte in range(OUTPUT_BYTES) for bit in range(8)} if plc.released() else plc.outputs()
        for (byte, bit), level in outputs.items():
            if byte not in self.setup.robot_only:
                self.shared.by_plc(level, byte, bit)

    def _react(self, plc: IntegratedPlc, state: CellState, now: Ns) -> None:
        """Red messages stop the robot, those of class 7 switch the drives off; input 62 acknowledges."""
        reactions = [int(message["reaction"]) & 0xFF for message in plc.messages]
        plc.messages = []
        if any(reaction >= STOPS for reaction in reactions):
            if self.robot.programs is not None:
                self.robot.programs.stop(now)
            if state.motion is not Motion.IDLE:
                self._say(Command(Code.STOP), now)
        plc.drives_off = plc.drives_off or any(reaction >= DRIVES_OFF for reaction in reactions)
        enabled = any(axis.flags & AxisFlag.ENABLED for axis in state.axes[: len(self.setup.axes)])
        if plc.drives_off and not enabled:
            plc.drives_off = False
        elif plc.drives_off and state.motion in (Motion.STOPPED, Motion.IDLE):
            self._dispatcher.command(
                self._dispatcher.owner or self.setup.source, Command(Code.DISABLE, (1 << len(self.setup.axes)) - 1), now
            )

    def _acknowledge(self) -> None:
        level = self.image.input(ACKNOWLEDGE)
        if level and not self.robot.acknowledged:
            if self.plc is not None:
                self.plc.acknowledge()
            if self.robot.programs is not None:
                self.robot.programs.acknowledge()
        self.robot.acknowledged = level

    # ---- programs of the interpreter -----------------------------------------------------------------------------------
    @property
    def cell(self) -> CellState:
        """As the cycle published it last."""
        return self._dispatcher.cell or CellState()

    @property
    def automatic(self) -> bool:
        """RC input 23."""
        return self.image.input(AUTO_MN)

    def marker(self, byte: int, bit: int) -> bool:
        """M byte.bit, as the integrated PLC has it where there is one."""
        if self.plc is not None and self.plc.report.id and byte < INPUTS:
            return bool(self.plc.report.markers[byte] >> bit & 1)
        return self.markers.bit(byte, bit)

    def robot_writes(self, first: int, data: bytes) -> str:
        """Markers and outputs as the robot program writes them; why it may not, or ""."""
        if first < INPUTS and self.plc is not None:
            self.plc.write(first, data)
            return ""
        return next((wrong for at, value in enumerate(data, first) if (wrong := self.robot_sets(at, 0xFF, value))), "")

    def robot_sets(self, byte: int, mask: int, bits: int) -> str:
        """The same for single bits of a byte; where robot and PLC write an output, it has the PLC's value (L2274)."""
        try:
            if byte >= OUTPUTS:
                for bit in (bit for bit in range(8) if mask >> bit & 1):
                    self.shared.by_robot(bool(bits >> bit & 1), byte - OUTPUTS, bit)
                if self.plc is not None:
                    self.plc.robot_output(byte - OUTPUTS, mask, bits)
            elif self.plc is not None:
                self.plc.write_bits(byte, mask, bits)
            else:
                mask &= ~_ROBOTS_BITS.get(byte, 0) if not _of_robot(byte) else 0
                self.markers.set_byte(byte, self.markers.byte(byte) & ~mask | bits & mask)
        except IoFault as fault:
            return str(fault)
        return ""

    def robot_puts(self, byte: int, bit: int, level: bool) -> None:
        """One output; IoFault where it is the PLC's, or there is none."""
        self.shared.by_robot(level, byte, bit)
        if self.plc is not None:
            self.plc.robot_output(byte, 1 << bit, level << bit)

    def message(self, number: int, words: str, now: Ns) -> None:
        """An error of the robot program: in the list, in M944 and M1021.0."""
        self.markers.set_number(ERROR_NUMBER, number)
        self.markers.set_bit(*IN_ERROR, True)
        self.markers.set_bit(*ACKNOWLEDGED, False)
        self.robot.report(number, words, now)

    def acknowledged(self) -> None:
        """It is acknowledged."""
        if not self.robot.shown:
            return
        self.robot.clear()
        self.markers.set_bit(*ACKNOWLEDGED, True)
        if not self._active and not self._references.asynchronous:
            self.markers.set_bit(*IN_ERROR, False)
            self.markers.set_number(ERROR_NUMBER, 0)

    def _errors(self, state: CellState) -> list[str]:
        seen: dict[tuple[int, int], None] = {}
        for number in range(1, len(self.setup.axes) + 1):
            axis = state.axes[number - 1]
            if axis.flags & AxisFlag.FAULT:
                seen[regulator_number(axis.fault_code), number] = None
            elif axis.flags & AxisFlag.LOST:
                seen[WATCHDOG, number] = None
            elif axis.finding:
                seen[axis.finding, number] = None
        texts, active = [], {}
        for error in seen:
            active[error] = self._active.get(error, "")
            if error not in self._active:
                message = regulator_error(self.markers, *error)
                active[error] = f"{message.text}, axis {self.setup.axes[message.axis - 1]}"
                texts.append(active[error])
        if self._active and not seen and not self._references.asynchronous:
            self.markers.set_bit(*IN_ERROR, False)
            self.markers.set_number(ERROR_NUMBER, 0)
        if texts:
            self.markers.set_bit(*ACKNOWLEDGED, False)
        self._active = active
        return [] if self.robot.suppressed else texts

    def _look_at_drives(self, state: CellState, now: Ns) -> list[str]:
        """Err Enab ends where the drives are switched on (L1359): errors that are still active are shown again."""
        axes = state.axes[: len(self.setup.axes)]
        before, self.robot.drives_on = self.robot.drives_on, bool(axes) and all(axis.flags & AxisFlag.ENABLED for axis in axes)
        if before or not self.robot.drives_on or not self.robot.suppressed:
            return []
        self.robot.show_again(now)
        return list(self._active.values())

    def shown(self) -> list[str]:
        """Messages as they are displayed, the newest last."""
        return [] if self.robot.suppressed else [*self._active.values(), *(words for _, words in self.robot.shown)]

    def _publish(self, state: CellState) -> None:
        markers = self.markers
        axes = state.axes[: len(self.setup.axes)]
        markers.set_bit(*STARTED, True)
        markers.set_bit(*MOVES, state.motion in (Motion.RUNNING, Motion.STOPPING, Motion.REFERENCING))
        self._note_references(state)
        markers.set_bit(*SYNCHRONOUS, not self._references.asynchronous and all(axis.flags & AxisFlag.REFERENCED for axis in axes))
        mode = AUTO if self.automatic else HAND
        if self.robot.programs is not None:
            mode = self.robot.programs.code
            markers.set_bit(*PLUS, self.robot.keys.hand.plus)
            markers.set_bit(*MINUS, self.robot.keys.hand.minus)
            markers.set_number(INQUIRY, next((int(str(row["inquiry"])) for row in self.robot.programs.rows), 0))
            for number, hundredths in enumerate(self.robot.programs.progress):
                markers.set_number(PATH + 4 * number, hundredths)
        markers.set_number(MODE, int.from_bytes(mode.to_bytes(2, "big"), "little"), 2)
        places = tuple(axis.actual * factor for axis, factor in zip(axes, self.setup.unit_per_si, strict=False))
        for number, place in enumerate(places):
            markers.set_number(ACTUAL + 4 * number, round(place * 100.0))
        pose = self.robot.programs.tcp(places) if self.robot.programs is not None else ()
        markers.set_bit(*TCP_VALID, bool(pose))
        for number, value in enumerate(pose):
            markers.set_number(TCP + 4 * number, round(value * 100.0))

    def _note_references(self, state: CellState) -> None:
        """The last asynchronous axis that is referenced ends the error."""
        if self._references.look(state.axes[: len(self.setup.axes)]) and not self._active:
            self.markers.set_bit(*IN_ERROR, False)
            self.markers.set_number(ERROR_NUMBER, 0)

    def _obey(self, state: CellState, now: Ns) -> None:
        """Factor on the override, hold motion while it is set (robotstar 5.8, M1436, M1020.7)."""
        self._dispatcher.multiply_override(self._factor())
        hold = self.markers.bit(*HOLD)
        if hold and not self._hold and state.motion is Motion.RUNNING:
            self._say(Command(Code.STOP), now)
            self._stopped = True
        elif not hold and self._stopped and state.motion in (Motion.STOPPED, Motion.IDLE):
            self._stopped = False
            if state.motion is Motion.STOPPED and (self.robot.programs is None or self.robot.programs.run):
                self._say(Command(Code.RESUME), now)
        self._hold = hold

    def _factor(self) -> float:
        """M1436, in AUTO, TEST2 and TEST4 (L2967)."""
        percent = self.markers.number(OVERRIDE)
        if percent or self._percent is not None:
            self._percent = percent
        mode = self.robot.programs.code if self.robot.programs is not None else AUTO if self.automatic else None
        return min(max(percent, 0), 100) / 100.0 if self._percent is not None and mode in MULTIPLIED else 1.0

    def _say(self, command: Command, now: Ns) -> None:
        """As the command source in control: the stop of another one would abort its movement."""
        self._dispatcher.command(self._dispatcher.owner or self.setup.source, command, now)

    # ---- what others see -----------------------------------------------------------------------------------------------
    def flag_bytes(self) -> bytes:
        """M0..M2047."""
        if self.plc is not None and self.plc.report.id:
            return self.plc.report.markers + self.markers.content()[INPUTS:]
        return self.markers.content()

    def write_flags(self, first: int, data: bytes) -> bool:
        """Markers from `first` on, as the PLC's program would; False, and nothing is written, where a byte is not the PLC's.

        Of a byte both write, the robot's bits stay.
        """
        if first + len(data) > SIZE or any(_of_robot(byte) for byte in range(first, first + len(data))):
            return False
        if any(byte >= OUTPUTS and byte - OUTPUTS in self.setup.robot_only for byte in range(first, first + len(data))):
            return False
        if self.plc is not None:
            return self.plc.write(first, data)
        for byte, value in enumerate(data, first):
            if byte < OUTPUTS:
                kept = _ROBOTS_BITS.get(byte, 0)
                self.markers.set_byte(byte, value & ~kept | self.markers.byte(byte) & kept)
                continue
            for bit in range(8):
                self.shared.by_plc(bool(value >> bit & 1), byte - OUTPUTS, bit)
        self.shared.end_of_cycle()
        return True

    def retained(self) -> bytes:
        """Markers without those that the robot sets anew at every start; binary inputs and outputs read 0."""
        kept = bytearray(self.markers.retained())
        for first, size in _ROBOTS:
            if first < len(kept):
                kept[first : first + size] = bytes(size)
        return bytes(kept).ljust(SIZE, b"\0")

    def restore(self, flags: bytes, counters: Mapping[int, int]) -> None:
        """Markers as they were kept; their contents then command nothing."""
        if flags:
            self.markers.power_on(flags[:INPUTS])
            self._percent = self.markers.number(OVERRIDE) or None

    def timer(self, number: int) -> int | None:
        """Of the integrated PLC, where the cell has one."""
        return None if self.plc is None else self.plc.timer(number)

    def counter(self, number: int) -> int | None:
        """Of the integrated PLC, where the cell has one."""
        return None if self.plc is None else self.plc.counter(number)

    def names(self) -> list[str]:
        """Return the values other than markers."""
        elements = [f"reis.ibin_{way}.{n}" for way in ("in", "out") for n in range(1, 11)]
        analog = [f"reis.analog.{way}.{n}" for way in ("input", "output") for n in range(1, 25)]
        keys = [f"reis.{name}" for name in Keys.names()] if self.setup.programs else []
        return ["reis.err_enab"] + elements + analog + [f"reis.output.{byte}.{bit}" for byte in range(40) for bit in range(8)] + keys

    def value(self, name: str) -> float:
        """One of them; KeyError."""
        match name.split("."):
            case ["reis", "ibin_in" | "ibin_out" as which, number]:
                return float(self.io.element(Area.INPUT if which == "ibin_in" else Area.OUTPUT, _number(name, number)))
            case ["reis", "analog", "input", number]:
                return ana_inp(self.markers, _number(name, number))
            case ["reis", "analog", "output", number]:
                return output_volts(self.markers, _number(name, number))
            case ["reis", "err_enab"]:
                return float(self.robot.suppressed)
            case ["reis", "output", byte, bit]:
                return float(self.io.read_bit(Area.OUTPUT, _number(name, byte), _number(name, bit)))
            case ["reis", *rest] if self.setup.programs:
                return self.robot.keys.value(".".join(rest))
        raise KeyError(name)

    def put(self, name: str, value: float) -> None:
        """WRITE_BIT of the robot's program, a key or the mode; KeyError for anything else, ValueError where the value does not fit."""
        match name.split("."):
            case ["reis", "output", byte, bit]:
                self.robot_puts(_number(name, byte), _number(name, bit), bool(value))
            case ["reis", "err_enab"]:
                if value:
                    self.robot.suppress()  # only the drives end it
            case ["reis", *rest] if self.setup.programs:
                self.robot.keys.put(".".join(rest), value)
            case _:
                raise KeyError(name)

    def status(self) -> dict[str, object]:
        """For tools and pages."""
        markers = self.markers
        return {
            "kind": "reis", "error": markers.number(ERROR_NUMBER), "in_error": markers.bit(*IN_ERROR),
            "synchronous": markers.bit(*SYNCHRONOUS), "mode": f"{markers.byte(MODE):02X}{markers.byte(MODE + 1):02X}",
            **({"plc": self.plc.status()} if self.plc is not None else {}),
            "message": next(reversed(self.shown()), ""),
        }  # fmt: skip


def _of_robot(byte: int) -> bool:
    """Whether the system alone writes this byte: all of it, or binary inputs."""
    return INPUTS <= byte < OUTPUTS or any(first <= byte < first + size for first, size in _ROBOTS)


def _number(name: str, text: str) -> int:
    if not text.isdecimal():
        raise KeyError(name)
    return int(text)
