"""The plant as programs see it: axes, inputs, belts.  A dry run (AX-696) and a cell each provide it.  Pure."""

from abc import ABC, abstractmethod

from gateway.pure.languages.baps2.tasks import Block, Lane, Task
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.waiting import Wait
from gateway.pure.languages.base.requests import PENDING, Request


class Plant(ABC):
    """What a dry run and a cell do differently."""

    @abstractmethod
    def event(self, task: Task, event: str, line: int, **facts: object) -> None:
        """An event for a trace or a journal."""

    @abstractmethod
    def _moves_on(self, task: Task, block: Block) -> bool:
        """Begin or continue a block; True: it is over."""

    @abstractmethod
    def _halted(self, task: Task, lane: Lane) -> None:
        """The process that had this kinematic has ended; the lane gets the position at which the axes rest."""

    @abstractmethod
    def kinematic_wait(self, task: Task) -> Wait | None:
        """The kinematic that the next block of this process, or its SYNCHRON, waits for."""

    def _on_belt(self, task: Task, request: Request) -> object:
        """SYNC, SYNCHRON and SYNCHRON_END of a dry run; a cell passes them to its planner."""
        return PENDING

    @abstractmethod
    def prepared(self, task: Task) -> bool:
        """Whether motion is so far that inputs and positions are read."""

    @abstractmethod
    def signal(self, channel: int, now: int) -> int | float:
        """Value of an input."""

    @abstractmethod
    def image(self, letter: str, bit: int) -> int:
        """A signal of the interface: I or O of the PIC."""

    @abstractmethod
    def belt(self, channel: int) -> float:
        """Counter of a belt in mm."""

    @abstractmethod
    def set_belt(self, channel: int, value: float) -> None:
        """Sets the counter of a belt."""

    @abstractmethod
    def position(self, task: Task, kinematic: str, name: str) -> tuple[float, ...]:
        """POS, @POS, @MPOS now."""

    @abstractmethod
    def where(self, kinematic: str) -> tuple[float, ...]:
        """Joints of a kinematic now."""

    def with_belts(self, unit: Unit, kinematic: str) -> tuple[float, ...]:
        """Return joints, followed by the counters of belts."""
        return self.where(kinematic)

    @abstractmethod
    def measuring_system(self, unit: Unit, number: int) -> float:
        """Return the value of a measuring system.  Raise a runtime error for an unknown one."""

    def actual(self, kinematic: str) -> tuple[float, ...]:
        """Without a lag, unless drives report it."""
        return self.where(kinematic)

    @abstractmethod
    def world(self, kinematic: str, joints: tuple[float, ...]) -> tuple[float, ...]:
        """World coordinates of joints, in original coordinates."""

    @abstractmethod
    def joints(self, kinematic: str, world: tuple[float, ...]) -> tuple[float, ...]:
        """Joints of world coordinates."""
