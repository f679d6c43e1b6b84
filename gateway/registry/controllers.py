"""Old controllers as their PLC sees them: `kind` of [controller]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.registry.rows import table

if TYPE_CHECKING:
    from gateway.assembly.controllers import ControllerPlan
    from gateway.pure.arbitration.dispatcher import CommandDispatcher
    from gateway.pure.cell.cell import Cell
    from gateway.pure.controllers.control import Control
    from gateway.services.controller_host import Panel


@dataclass(frozen=True, slots=True)
class ControllerKind:
    """An old controller as its PLC sees it."""

    name: str
    words: str
    make: "Callable[[ControllerPlan], tuple[Control, list[str]]]"  # the control, and the faults of its files
    flags: str = ""  # name of its flags in the retained data; "": it has none
    counters: bool = False
    parameters: bool = False  # machine parameters of [rho3] apply to it: processes, pendant, measuring inputs of its boards
    points: bool = False  # [[controller.point]]
    markers: bool = False  # bytes of the PLC and of the robot that may not overlap
    little: bool = False  # low byte first in operands
    plc: bool = False  # [controller.plc]: an integrated PLC
    memory: str = ""  # language of the programs in its memory
    resumes: bool = False  # a stopped program keeps its path for the next START
    panel: "Callable[[Cell, Control, CommandDispatcher], Panel] | None" = None  # its hand-held unit
    codes: bool = False  # code_words and pin of [controller] open it


def _make_rho3(plan: "ControllerPlan") -> "tuple[Control, list[str]]":
    from gateway.assembly.controllers import make_rho3

    return make_rho3(plan)


def _make_reis(plan: "ControllerPlan") -> "tuple[Control, list[str]]":
    from gateway.assembly.controllers import make_reis

    return make_reis(plan)


def _make_val3(plan: "ControllerPlan") -> "tuple[Control, list[str]]":
    from gateway.assembly.controllers import make_val3

    return make_val3(plan)


def _rho3_panel(cell: "Cell", control: "Control", dispatcher: "CommandDispatcher") -> "Panel":
    from gateway.pure.controllers.rho3.signals.control import RhoControl
    from gateway.services.rho3_panel import Rho3Panel

    assert isinstance(control, RhoControl)  # as `_make_rho3` makes it
    return Rho3Panel(control, dispatcher)


def _reis_panel(cell: "Cell", control: "Control", dispatcher: "CommandDispatcher") -> "Panel":
    from gateway.services.reis_panel import reis_panel

    return reis_panel(cell, control, dispatcher)


CONTROLLERS = table(
    ControllerKind("rho3", "rho 3", _make_rho3, flags="flags", counters=True, parameters=True, memory="baps2", panel=_rho3_panel),
    ControllerKind(
        "reis",
        "Reis",
        _make_reis,
        flags="markers",
        markers=True,
        little=True,
        plc=True,
        memory="robotstar",
        resumes=True,
        panel=_reis_panel,
        codes=True,
    ),
    ControllerKind("val3", "VAL 3", _make_val3, points=True),
)
