"""State of a control that its views (pendant, variables of the PHG) read; RhoControl owns it and brings it up to date."""

from dataclasses import dataclass, field

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.functions.processes import ProcessTable
from gateway.pure.controllers.rho3.signals.fast_io import Channels
from gateway.pure.controllers.rho3.signals.modes import OperatingModes
from gateway.pure.controllers.rho3.signals.setup import Setup
from gateway.pure.controllers.rho3.signals.user import UserPorts
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import CellState
from motion.program.factors import FactorTable
from protocols.base.machine import Ns


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
    cell: CellState = field(default_factory=CellState)

    def set_factor(self, which: str, value: float, kinematic: int = 0) -> None:
        """A speed or acceleration factor, of one kinematic or of all (0)."""
        if kinematic:
            self.factor_table.set_kinematic(kinematic, **{which: value})
        else:
            self.factor_table.set_global(**{which: value})
