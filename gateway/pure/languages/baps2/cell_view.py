"""A cell as BAPS2 programs see it: its robots, inputs, belts and positions.  Pure."""

from collections.abc import Sequence

from gateway.pure.image.records.interpreter import FAST, FIRST_FAST, FIRST_MULTI, FIRST_REAL, MULTI, REALS
from gateway.pure.languages.baps2.cell_belts import CellBelts, CellSetup
from gateway.pure.languages.baps2.control import Control
from gateway.pure.languages.baps2.errors import TEXTS, fault
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Lane, Task, size_of
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.requests import Ns, RuntimeFault
from motion.program.passing import Presets

FIRST_INPUT, USER = 464, 120  # RC input of user input 1
FIRST_INTEGER, INTEGERS = 401, 8
RUN_ON = range(710, 800, 10)  # probes of the modified MOVE UNTIL, of boards 1 to 9
EARLY = 1_000  # the same inputs, read while the block is prepared


class CellView(Control):
    """Robots by number and name, inputs as the control has them, positions as the axes have them."""

    def __init__(self, library: Library, memory: Memory, port: Port, robots: Sequence[CellRobot], p5: Ns, setup: CellSetup) -> None:
        super().__init__(library, memory, Feed(p5=p5, belts={}))
        self.port, self.robots, self.setup = port, tuple(robots), setup
        self.belts = CellBelts(setup.belts, port)

    def robot(self, number: int) -> CellRobot:
        """By its number; a runtime error where the cell has none."""
        if not 1 <= number <= len(self.robots):
            raise fault(220, f"{number}; this cell has {len(self.robots)} with a model")
        return self.robots[number - 1]

    def robot_of(self, kinematic: str) -> CellRobot:
        """As programs name it."""
        return self.robots[self.lanes.numbers.get(kinematic, 1) - 1]

    def lane_of(self, task: Task, number: object) -> tuple[str, Lane]:
        """A kinematic of the program by its number."""
        return self.specials.lane_of(task, number)

    def lane(self, kinematic: str, size: int = 0) -> Lane:
        """A kinematic, at the position of its axes."""
        lane = self.lanes.get(kinematic)
        if lane is None:
            lane = self.lanes.renamed(kinematic) or Lane(self.robot_of(kinematic).own(self.port.view.set))
            self.lanes[kinematic] = lane
        return lane

    def _presets(self, robot: int) -> Presets:
        """P212 to P214 of a kinematic."""
        return self.setup.presets[robot - 1] if robot <= len(self.setup.presets) else Presets()

    def signal(self, channel: int, now: int) -> int | float:
        """Value of an input as the control has it; a runtime error where there is none."""
        number, seen = channel % EARLY, self.port.view.channels
        if number in RUN_ON:
            number -= 100  # the probe of the same board
        if 1 <= number <= USER:
            bit = FIRST_INPUT + number - 1
            return seen.inputs[bit >> 3] >> (bit & 7) & 1
        if FIRST_INTEGER <= number < FIRST_INTEGER + INTEGERS:
            return seen.integers[number - FIRST_INTEGER]
        if 0 <= number - FIRST_REAL < REALS and seen.reals_given >> number - FIRST_REAL & 1:
            return seen.reals[number - FIRST_REAL]
        place = number - FIRST_FAST
        if 0 <= place < FAST and seen.fast_given >> place & 1:
            return seen.fast >> place & 1
        if (wire := self.setup.wires.get(number, -1)) >= 0:
            return seen.inputs[wire >> 3] >> (wire & 7) & 1
        if FIRST_MULTI <= number < FIRST_MULTI + MULTI and seen.multi is not None:
            return seen.multi >> (number - FIRST_MULTI) & 1
        raise RuntimeFault(206, f"{TEXTS[206]}: {channel}")

    def image(self, letter: str, bit: int) -> int:
        """A signal of the interface, as the PIC names it: O its outputs (RC inputs), I its inputs (RC outputs)."""
        if letter == "M":
            raise fault(206)
        seen = self.port.view.channels
        octets = seen.inputs if letter == "O" else seen.outputs
        return octets[bit >> 3] >> (bit & 7) & 1 if bit >> 3 < len(octets) else 0

    def belt(self, channel: int) -> float:
        """Counter of a belt."""
        return self.belts.counter(self.belts.number(channel))

    def set_belt(self, channel: int, value: float) -> None:
        """The cycle sets counters."""

    def where(self, kinematic: str) -> tuple[float, ...]:
        """Set joints of a kinematic now."""
        return self.robot_of(kinematic).own(self.port.view.set)

    def with_belts(self, unit: Unit, kinematic: str) -> tuple[float, ...]:
        """Return set joints, followed by the counters of belts that the program names as components."""
        robot = self.robot_of(kinematic)
        return (*self.where(kinematic), *self.belts.values(robot.number, max(0, size_of(unit, kinematic) - robot.size)))

    def measuring_system(self, unit: Unit, number: int) -> float:
        """The axes of the cell in its order, then its belts."""
        found = (*self.port.view.set, *self.port.view.belts)
        if not 1 <= number <= len(found):
            raise fault(91, str(number))
        return found[number - 1]

    def actual(self, kinematic: str) -> tuple[float, ...]:
        """As its drives report."""
        return self.robot_of(kinematic).own(self.port.view.actual)

    def position(self, task: Task, kinematic: str, name: str) -> tuple[float, ...]:
        """POS, @POS, @MPOS now."""
        robot = self.robot_of(kinematic)
        if name == "@MPOS":
            flying = self.lane(kinematic).measured
            if flying is not None:
                return flying
            found = self.port.view.measured[robot.first : robot.first + robot.size]
            if any(each is None for each in found):
                raise fault(200)
            return tuple(each for each in found if each is not None)
        joints = self.where(kinematic)
        belts = self.belts.values(robot.number, max(0, size_of(task.unit, kinematic) - robot.size))
        place = to_workpiece(self.lane(kinematic).frame, robot.world(joints)) if name == "POS" else joints
        return (*place, *belts)

    def world(self, kinematic: str, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Return world coordinates of joints; the belt values after them are kept."""
        robot = self.robot_of(kinematic)
        return (*robot.world(joints[: robot.size]), *joints[robot.size :])

    def joints(self, kinematic: str, world: tuple[float, ...]) -> tuple[float, ...]:
        """Return joints of world coordinates, near the present ones; the belt values after them are kept."""
        robot = self.robot_of(kinematic)
        return (*robot.joints(world[: robot.size], self.where(kinematic)), *world[robot.size :])
