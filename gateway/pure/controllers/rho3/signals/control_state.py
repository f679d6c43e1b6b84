"""State of a control that its views (pendant, variables of the PHG) read; RhoControl owns it and brings it up to date."""

from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.functions.processes import ProcessTable
from gateway.pure.controllers.rho3.pendant.screen2000 import Screen2000
from gateway.pure.controllers.rho3.pendant.user_memory import UserMemory
from gateway.pure.controllers.rho3.signals.fast_io import Channels
from gateway.pure.controllers.rho3.signals.modes import OperatingModes
from gateway.pure.controllers.rho3.signals.setup import Setup
from gateway.pure.controllers.rho3.signals.user import UserPorts
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import CellState
from gateway.pure.image.records.interpreter import Fact
from motion.program.factors import FactorTable
from protocols.base.machine import Ns


class HostedOrders(Protocol):
    """The interpreter, as the pendant orders."""

    answers: dict[int, str]
    shown: dict[str, object]
    rows: list[dict[str, object]]
    programs: list[dict[str, object]]

    def order(self, what: str, **facts: Fact) -> int:
        """A ticket, under which `answers` has what became of it."""


@dataclass(slots=True)
class ControlState:
    """One control's parts; `cell` and `now` are those of its last cycle."""

    setup: Setup
    errors: ErrorList
    image: PicImage
    modes: OperatingModes
    user: UserPorts
    processes: ProcessTable
    channels: Channels
    factor_table: FactorTable
    now: Ns
    closed: bool = True  # the emergency-stop chain
    hosted: HostedOrders | None = None  # programs of the interpreter
    screen: Screen2000 = field(default_factory=Screen2000)
    memory: UserMemory = field(default_factory=UserMemory)
    cell: CellState = field(default_factory=CellState)

    def set_factor(self, which: str, value: float, kinematic: int = 0) -> None:
        """A speed or acceleration factor, of one kinematic or of all (0)."""
        if kinematic:
            self.factor_table.set_kinematic(kinematic, **{which: value})
        else:
            self.factor_table.set_global(**{which: value})
