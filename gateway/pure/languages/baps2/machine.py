"""The machine as its parts see it: programs, processes, kinematics, devices, files."""

from collections.abc import Mapping
from typing import Protocol

from gateway.pure.languages.baps2.demands import Condition, MoveTo
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.filing import Filing
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.tasks import Lane, Lanes, Task
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.units import Device
from gateway.pure.languages.baps2.values import Shared
from gateway.pure.languages.base.scheduler import Scheduler


class Units(Protocol):
    """What programs look up of devices and files."""

    def at_end(self, task: Task, unit: str) -> bool:
        """END_OF_FILE."""

    def condition(self, task: Task, request: Condition) -> int:
        """CONDITION."""

    def place(self, task: Task, unit: str) -> tuple[str, bool]:
        """Name of the device or file of a unit, and whether it is a device."""


class Machine(Protocol):
    """Host of the processes."""

    library: Library
    memory: Memory
    feed: Feed
    filing: Filing
    tasks: dict[int, Task]
    lanes: Lanes
    outputs: dict[int, int | float]
    devices: dict[str, Device]
    now: int
    scheduler: Scheduler

    @property
    def units(self) -> Units:
        """Devices and files."""

    def library_of(self, task: Task | None) -> Library:
        """The programs as this process runs them."""

    def lane(self, kinematic: str, size: int = 0) -> Lane:
        """A kinematic."""

    def input(self, channel: int) -> int | float:
        """Value of an input now."""

    def image(self, letter: str, bit: int) -> int:
        """A signal of the interface: I or O of the PIC."""

    def signal(self, channel: int, now: int) -> int | float:
        """Value of an input as the feed has it."""

    def where(self, kinematic: str) -> tuple[float, ...]:
        """Joints of a kinematic now."""

    def actual(self, kinematic: str) -> tuple[float, ...]:
        """Joints of a kinematic as they are measured now."""

    def with_belts(self, unit: Unit, kinematic: str) -> tuple[float, ...]:
        """Return the present joints of a kinematic, followed by the counters of belts that the program names as its components."""

    def measuring_system(self, unit: Unit, number: int) -> float:
        """Return the value of a measuring system: axes of all kinematics, then belts, from 1.  Raise a runtime error for an unknown one."""

    def belt(self, channel: int) -> float:
        """Counter of a belt in mm."""

    def position(self, task: Task, kinematic: str, name: str) -> tuple[float, ...]:
        """POS, @POS, @MPOS now."""

    def world(self, kinematic: str, joints: tuple[float, ...]) -> tuple[float, ...]:
        """World coordinates of joints, in original coordinates."""

    def joints(self, kinematic: str, world: tuple[float, ...]) -> tuple[float, ...]:
        """Joints of world coordinates."""

    def point_selected(self, program: str, point: str, points: Mapping[str, tuple[float, ...]]) -> None:
        """Special function 16 has chosen a point file, and a point of it ("": the first one), for the pendant."""

    def keep(self, program: str, name: str, value: tuple[float, ...]) -> None:
        """A teach point was assigned to: it stays when the program ends."""

    def taught(self, program: str, name: str) -> tuple[float, ...] | None:
        """A point at the start of a program."""

    def file_changed(self, name: str) -> None:
        """A file of the memory was replaced or deleted."""

    def shared(self, program: str) -> Shared:
        """The PUBLIC variables of a program."""

    def move(self, task: Task, request: MoveTo) -> object:
        """Prepares a block."""

    def start(self, program: str, starter: Task | None) -> Task:
        """Starts a program as a process."""

    def stop_named(self, task: Task, program: str) -> object:
        """STOP."""

    def event(self, task: Task, event: str, line: int, **facts: object) -> None:
        """One event of the trace."""
