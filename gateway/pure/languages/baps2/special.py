"""Special functions on the dry run (spec 5.7, 4.3-4.16).  17 and 27 are only named: they are options that are not there (AX-693)."""

import re
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from gateway.pure.languages.baps2 import demands
from gateway.pure.languages.baps2.compiling import compile_program
from gateway.pure.languages.baps2.dry_outputs import DryOutputs
from gateway.pure.languages.baps2.errors import TEXTS, fault
from gateway.pure.languages.baps2.filing import file_name
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.tasks import MOST_PREPARED, Lane, Task
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.values import MOST_REAL, Ref, point
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.requests import PENDING, RuntimeFault

COPIES = {"QLL": ("QLL", "ERR", "DAT"), "DAT": ("QLL", "ERR", "DAT"), "PKT": ("PKT",), "SYM": ("SYM",), "IRD": ("IRD",)}
PROBES = range(610, 700, 10)
MOST_ENTRIES = 50  # of a recorded path (L5257)
_POINT_NAME = re.compile(r"(@?[A-Z]\w*)(\[-?\d+\])?", re.ASCII)
WRONG_DIRECTION = 928  # of kinematic 1 (L6116-6128)
HEADER, VERSION = 24, 500  # of a MOVE_FILE: bytes of its fields, version of TO05 (L6975-7005)


def _whole(value: object) -> int:
    return int(value) if isinstance(value, int | float) else 0


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


def _get(value: object) -> object:
    return value.get() if isinstance(value, Ref) else value


def _set(target: object, value: object) -> None:
    if isinstance(target, Ref):
        target.set(value)


def _no_point(wanted: str, points: Iterable[str]) -> int:
    """Why a point file has no such point: a name that is none, an index its array has not, a name it has not (L10799-10813)."""
    found = _POINT_NAME.fullmatch(wanted)
    if found is None:
        return 11
    return 13 if found[2] and any(each.startswith(f"{found[1]}[") for each in points) else 12


@dataclass(slots=True)
class _Measuring:
    """A probe that measures in flight."""

    kinematic: str
    edge: int
    was: int
    done: bool = False


@dataclass(slots=True)
class _Record:
    """A recorded path."""

    unit: Unit
    system: int
    distance: float
    running: bool = True
    last: float = 0.0
    points: list[tuple[float, ...]] = field(default_factory=list)


class Specials:
    """State of the special functions."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._resets: dict[int, float] = {}
        self._belt_types: dict[int, int] = {}
        self.functions = DryOutputs(machine)  # of a dry run
        self._measuring: dict[int, _Measuring] = {}  # channel of the probe
        self._records: dict[str, _Record] = {}
        self._compiler: Task | None = None  # whose program is being translated

    def call(self, task: Task, number: int, values: tuple[object, ...]) -> object:
        """Runs a special function; PENDING where it waits for the motion of the process."""
        if number in (3, 43, 44) and task.queue:
            return PENDING
        match number:
            case 1 | 2:
                name, lane = self.lane_of(task, values[1])
                self.functions.call(task, number, name, len(lane.position), values)
            case 3:
                self._machine_position(task, values)
            case 4:
                return self._command(task, values)
            case 15:
                self._belt(_whole(values[0]))
            case 16:
                self._select(values)
            case 21:
                self._belt_type(_whole(values[0]), _whole(values[1]))
            case 28:
                self._resets[self._belt(_whole(values[0]))] = _number(values[1])
            case 45:
                return self._move_file(task, values)
            case _:
                self._motion(task, number, values)
        return None

    def _motion(self, task: Task, number: int, values: tuple[object, ...]) -> None:
        """Functions about one kinematic."""
        match number:
            case 41:
                lane, factor = self.lane_of(task, values[0])[1], _number(values[1])
                if factor <= 0:
                    raise fault(218, f"VFACTOR = {factor:g}")
                lane.factors["VFACTOR"] = factor
            case 42:
                self.lane_of(task, values[0])[1].distance = _number(values[1])
            case 43:
                self._measure_on(task, values)
            case 44:
                self._measuring.pop(_whole(values[-1]), None)
            case 29 | 30 | 31:
                self._record(task, number, values)
            case 46:
                self._block_search(task, values)
            case _:
                raise RuntimeFault(204, f"{TEXTS[204]}: special function {number} is only named in the manual")

    def _measure_on(self, task: Task, values: tuple[object, ...]) -> None:
        """MEASURE_ON: at an edge 0 or 1 of the probe of a servo board (L7594-7635)."""
        name, lane = self.lane_of(task, values[0])
        edge, channel = _whole(values[1]), _whole(values[2])
        if edge not in (0, 1):
            raise fault(218, f"edge {edge}")
        if channel not in PROBES:
            raise fault(206, str(channel))
        lane.measured = None
        self._measuring[channel] = _Measuring(name, edge, int(self._machine.signal(channel, self._machine.now)))

    def lane_of(self, task: Task, number: object) -> tuple[str, Lane]:
        """A kinematic by its number."""
        head = task.unit.program.head
        name = next((name for name, each in head.kinematics.items() if each == _whole(number)), None)
        if name is None and (head.kinematics or _whole(number) != 1):
            raise fault(220, str(number))
        return name or "", self._machine.lane(name or "")

    def measured(self, channel: int) -> int | None:
        """1 once a probe that measures in flight has measured (L7594-7679); None: it does not measure."""
        found = self._measuring.get(channel)
        return None if found is None else int(found.done)

    def measure(self) -> None:
        """Stores positions at the edges of probes, and points of recorded paths."""
        for channel, each in self._measuring.items():
            value = int(self._machine.signal(channel, self._machine.now))
            if not each.done and value != each.was and value == each.edge:
                each.done = True
                self._machine.lane(each.kinematic).measured = self._machine.actual(each.kinematic)
            each.was = value
        for kinematic, record in self._records.items():
            if record.running:
                self._store(record, self._machine.with_belts(record.unit, kinematic))
        self.functions.step()

    @property
    def records(self) -> bool:
        """A path is being recorded, or a function waits for its place."""
        return self.functions.on or any(record.running for record in self._records.values())

    def _store(self, record: _Record, joints: tuple[float, ...]) -> None:
        """One entry each DISTANCE of a measuring system; the newest are kept (L5198-5255)."""
        now = self._machine.measuring_system(record.unit, record.system)
        if not record.points or abs(now - record.last) >= record.distance:
            record.points, record.last = [*record.points, joints][-MOST_ENTRIES:], now

    def _record(self, task: Task, number: int, values: tuple[object, ...]) -> None:
        """Records a path (29), ends that (30), reads an entry, 1 the newest (31)."""
        name, lane = self.lane_of(task, values[0])
        if number == 29:
            system = _whole(values[1])
            self._machine.measuring_system(task.unit, system)  # a runtime error where it is none
            self._records[name] = _Record(task.unit, system, _number(values[2]))
            return
        record = self._records.get(name)
        if number == 30:
            if record is not None:
                record.running = False
            _set(values[1], 0 if record is None else len(record.points))
            return
        index = _whole(values[1])
        if record is None or not 1 <= index <= len(record.points):
            raise fault(90, str(index))
        joints = record.points[-index]
        _set(values[2], joints)
        _set(values[3], to_workpiece(lane.frame, self._machine.world(name, joints)))

    def _machine_position(self, task: Task, values: tuple[object, ...]) -> None:
        """Belts in the point are not set (L4119-4208)."""
        _, lane = self.lane_of(task, values[0])
        lane.position = lane.planned = point(_get(values[1]))
        if lane.measured is not None:
            lane.measured = lane.position

    # ---- belts

    def _belt(self, number: int) -> int:
        if number not in self._machine.feed.belts:
            raise fault(93, str(number))
        return number

    def _belt_type(self, number: int, kind: int) -> None:
        self._belt(number)
        if kind != 1 and not (kind % 10 in (2, 3) and 0 <= kind // 10 <= 12):
            raise fault(92, str(kind))
        self._belt_types[number] = kind % 10

    def reset_value(self, channel: int) -> float:
        """What SYNC sets the counter to."""
        return self._resets.get(channel % 500, 0.0)

    def check_synchronous(self, task: Task, lane: Lane, request: demands.MoveTo) -> None:
        """What belt types 2 and 3 forbid (L6114-6128, 6319-6341)."""
        kind = self._belt_types.get(lane.belt % 500, 1)
        if kind == 1:
            return
        if request.way == "ptp":
            raise fault(23)
        if request.way == "circular" and kind == 3:
            raise fault(20)
        way = (request.target[-1] or 0.0) - (0.0 if request.relative else lane.planned[-1])
        if way == 0:
            raise fault(89)
        if lane.belt_way * way < 0:
            number = task.unit.program.head.kinematics.get(request.kinematic, 1)
            raise fault(WRONG_DIRECTION + number - 1)
        lane.belt_way = way

    # ---- files

    def _command(self, task: Task, values: tuple[object, ...]) -> object:
        """COMMAND (L5795-5996): statuses 1..7 are negative (D-22)."""
        source, target = str(_get(values[1])).rstrip(), str(_get(values[2])).rstrip()
        actions: dict[int, Callable[[Task, str, str], int | None]]
        actions = {1: self._compile, 2: self._copy, 3: self._delete, 4: self._start, 5: self._stop}
        action = actions.get(_whole(values[0]))
        status = -1 if action is None else action(task, source, target)
        if status is None:
            return PENDING
        _set(values[3], status)
        return None

    def _compile(self, task: Task, source: str, target: str) -> int | None:
        """Takes a P5, in which no other process may call the compiler (L5992-5996); None: not over yet."""
        if not source.upper().endswith(".QLL"):
            return -3 if "." in source else -2
        name, now = source.upper().removesuffix(".QLL"), self._machine.now
        if self._compiler is not task or task.began is None:
            if source.upper() not in self._machine.filing.files:
                return -4
            if self._compiler is not None and self._compiler is not task and not self._compiler.process.over:
                return -7
            self._compiler = task
            task.began = now
        if now < task.began + self._machine.feed.p5:
            return None
        self._compiler = None
        return len(compile_program(self._machine.library, self._machine.memory, name).faults)

    def _copy(self, task: Task, source: str, target: str) -> int:
        files = self._machine.filing
        one, other = file_name(source), file_name(target)
        if other is None:
            return -2
        if one is None or one not in files.files:
            return -6
        if other.rpartition(".")[2] not in COPIES.get(one.rpartition(".")[2], ()):
            return -2
        if files.is_open(other):  # the source may be (L5893-5900)
            return -5
        files.files[other] = files.files[one]
        self._machine.file_changed(other)
        return 0

    def _delete(self, task: Task, source: str, target: str) -> int:
        name = file_name(source)
        if name is not None and self._machine.filing.is_open(name):
            return -5  # a new one, which nothing has closed yet, too
        if name is None or name not in self._machine.filing.files:
            return -2
        del self._machine.filing.files[name]
        self._machine.file_changed(name)
        return 0

    def _start(self, task: Task, source: str, target: str) -> int:
        try:
            self._machine.start(source, task)
        except RuntimeFault as error:
            return error.code
        return 0

    def _stop(self, task: Task, source: str, target: str) -> int:
        try:
            self._machine.stop_named(task, source)
        except RuntimeFault as error:
            return error.code
        return 0

    def _select(self, values: tuple[object, ...]) -> None:
        """PNT_SELECT (L10776-10833)."""
        name, wanted = str(_get(values[0])).strip(), str(_get(values[1])).strip().upper()
        base, _, extension = name.partition(".")
        if not base or file_name(base) is None:
            code = 1
        elif extension != "PKT":
            code = 2
        elif name not in self._machine.filing.files:
            code = 3
        else:
            points = self._machine.memory.points(base, Faults())
            code = 5 if not points else 0 if wanted in ("", *points) else _no_point(wanted, points)
            if code == 0:
                self._machine.point_selected(base, wanted, points)
        _set(values[2], code)

    def _move_file(self, task: Task, values: tuple[object, ...]) -> object:
        """MOVE_FILE: the header is compared, then one block to the last point (L6956-7212)."""
        name, lane = self.lane_of(task, values[0])
        file, _ = self._machine.units.place(task, str(values[1]))
        opened = self._machine.filing.opened(file, [task.process.number, task.main.process.number], writing=False)
        if opened is None:
            raise fault(63)
        rows = self._checked(bytes(opened.data), opened.place, lane, _whole(values[2]), _get(values[3]), len(lane.position))
        if len([each for each in task.blocks(name) if each.began is None]) >= lane.most:
            return PENDING
        return self._machine.move(task, demands.MoveTo(name, "ptp", False, True, False, rows[-1]))

    def _checked(self, data: bytes, place: int, lane: Lane, base: int, flag: object, axes: int) -> list[tuple[float, ...]]:
        if len(data) < HEADER:
            raise fault(100)
        header, file_base, time_base, file_axes, version, unchecked = struct.unpack("<6i", data[:HEADER])
        axes = axes or file_axes
        if version != VERSION:
            raise fault(95)
        if file_axes != axes or axes <= 0:
            raise fault(96)
        if place < header:
            raise fault(97)
        if unchecked != 1 and time_base != (self._machine.feed.p5 // 1_000 if file_base == 1 else time_base):
            raise fault(98)
        if unchecked != 1 and file_base != base:
            raise fault(99)
        if (len(data) - place) % (4 * axes) or (place - header) % (4 * axes) or place >= len(data):
            raise fault(100)
        if not isinstance(flag, tuple) or any(value is None for value in flag):
            raise fault(101)
        rows = [struct.unpack(f"<{axes}f", data[at : at + 4 * axes]) for at in range(place, len(data), 4 * axes)]
        if any(not abs(value) <= MOST_REAL for row in (rows[0], rows[-1]) for value in row):
            raise fault(38)
        return rows

    def _block_search(self, task: Task, values: tuple[object, ...]) -> None:
        count = _whole(values[1])
        if not 1 <= count <= MOST_PREPARED:
            raise fault(218, f"{count} is not in 1..{MOST_PREPARED}")
        self.lane_of(task, values[0])[1].most = count
