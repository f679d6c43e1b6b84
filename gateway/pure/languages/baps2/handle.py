"""Direct calls of a translated program: queries and settings that take no time."""

from collections.abc import Generator, MutableMapping

from gateway.pure.languages.baps2.demands import Condition
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.frames import Frame, to_workpiece, to_world
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.tasks import Peek, Poke, Task
from gateway.pure.languages.baps2.values import KeptArray, Shared
from gateway.pure.languages.baps2.working_range import check_limits
from gateway.pure.languages.base.process import Place, Process
from gateway.pure.languages.base.requests import Request

MOST_CALLS = 100  # subroutines one in the other
RATIOS = ("VFACTOR", "AFACTOR", "DFACTOR", "R_PTP")


class Handle:
    """One running program's way to its machine."""

    def __init__(self, machine: Machine, task: Task | None) -> None:
        self._machine, self._task = machine, task
        self._external: dict[str, object] = {}

    @property
    def feed(self) -> Feed:
        """What the run is given."""
        return self._machine.feed

    def input(self, channel: int) -> int | float:
        """An input in a condition that is waited for."""
        return self._machine.input(channel)

    def output(self, channel: int) -> int | float:
        """What was last assigned to an output."""
        return self._machine.outputs.get(channel, 0)

    def belt(self, channel: int) -> float:
        """Counter of a belt."""
        return self._machine.belt(channel)

    def position(self, kinematic: str, name: str) -> tuple[float, ...]:
        """POS in a condition that is waited for."""
        if self._task is None:
            raise fault(200)
        return self._machine.position(self._task, kinematic, name)

    def factor(self, kinematic: str, name: str) -> float:
        """V, A, VFACTOR and the like; 1.0 where nothing was assigned, 0 for the radius."""
        return self._machine.lane(kinematic).factors.get(name, 0.0 if name in ("R", "R_PTP") else 1.0)

    def checked_factor(self, name: str, value: float) -> float:
        """A speed or factor that is not negative."""
        if value < 0:
            raise fault(218, f"{name} = {value:g}")
        return value

    def set_factor(self, kinematic: str, name: str, value: float) -> None:
        """Beyond the block."""
        self._machine.lane(kinematic).factors[name] = self.checked_factor(name, value)

    def limit(self, kinematic: str, name: str) -> tuple[float, ...] | None:
        """LIMIT_MIN, LIMIT_MAX."""
        return self._machine.lane(kinematic).limits.get(name)

    def set_limit(self, kinematic: str, name: str, value: tuple[float, ...]) -> None:
        """LIMIT_MIN, LIMIT_MAX."""
        lane = self._machine.lane(kinematic)
        check_limits({**lane.limits, name: value})
        lane.limits[name] = value

    def frame(self, kinematic: str) -> Frame:
        """WC_SYSTEM."""
        return self._machine.lane(kinematic).frame

    def set_frame(self, kinematic: str, value: Frame) -> None:
        """WC_SYSTEM; it stays when the program ends (L9015-9023)."""
        self._machine.lane(kinematic).frame = value

    def wc(self, kinematic: str, value: tuple[float, ...]) -> tuple[float, ...]:
        """Joints to world."""
        return to_workpiece(self._machine.lane(kinematic).frame, self._machine.world(kinematic, value))

    def jc(self, kinematic: str, value: tuple[float, ...]) -> tuple[float, ...]:
        """World to joints."""
        return self._machine.joints(kinematic, to_world(self._machine.lane(kinematic).frame, value))

    def at_end(self, process: Process, unit: str) -> bool:
        """END_OF_FILE."""
        return self._machine.units.at_end(self._machine.tasks[process.number], unit)

    def condition(self, process: Process, request: Condition) -> int:
        """CONDITION in a condition that is waited for."""
        return self._machine.units.condition(self._machine.tasks[process.number], request)

    def keep(self, program: str, name: str, value: tuple[float, ...]) -> tuple[float, ...]:
        """A teach point is assigned to: the value."""
        self._machine.keep(program, name, value)
        return value

    def taught(self, program: str, name: str) -> tuple[float, ...] | None:
        """A point at the start of the program."""
        return self._machine.taught(program, name)

    def taught_array(self, program: str, name: str, low: int, high: int) -> KeptArray:
        """An array of teach points at the start of the program: NAME[1] and so on of the point file."""

        def keep(index: int, value: tuple[float, ...]) -> None:
            self._machine.keep(program, f"{name}[{index}]", value)

        return KeptArray(low, [self._machine.taught(program, f"{name}[{index}]") for index in range(low, high + 1)], keep)

    def shared(self, program: str) -> Shared:
        """PUBLIC variables."""
        return self._machine.shared(program)

    def stops(self, process: Process, program: str, line: int, flags: MutableMapping[str, object]) -> bool:
        """Return whether the debugger holds the process before this line.  `flags`: b<line> of the program, see Debugger."""
        debugger = self._machine.scheduler.debugger
        if debugger is None:
            return False
        if debugger.stops(process, program, line, self._machine.tasks[process.number].depth):
            return True
        debugger.passes(flags, f"b{line}")
        return False

    def watched(self, program: str, peek: Peek, poke: Poke) -> None:
        """Access of a debugger to the variables of a program that runs."""
        if self._task is not None:
            self._task.watches[program] = peek, poke

    def deeper(self, process: Process) -> None:
        """A subroutine begins."""
        task = self._machine.tasks[process.number]
        task.depth += 1
        if task.depth > MOST_CALLS:
            raise fault(207)

    def back(self, process: Process) -> None:
        """A subroutine ends."""
        self._machine.tasks[process.number].depth -= 1

    def external(self, process: Process, program: str, values: tuple[object, ...]) -> Generator[Request, object, None]:
        """Runs an external subroutine, or a program as one, in this process."""
        unit, _ = self._machine.library_of(self._task).unit(program)
        if unit is None or unit.make is None:
            raise fault(1092, program)
        place, process.place = process.place, Place(process.line, f"{program.upper()}.QLL")
        self.deeper(process)
        yield from unit.make(self)(process, *values)
        self.back(process)
        process.place = place
