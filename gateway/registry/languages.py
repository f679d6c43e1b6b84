"""Languages of programs of an old controller that the interpreter runs in a cell."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.registry.controllers import CONTROLLERS
from gateway.registry.rows import table

if TYPE_CHECKING:
    from gateway.assembly.listings import Listing
    from gateway.assembly.run import RunPlan
    from gateway.pure.arbitration.dispatcher import CommandDispatcher
    from gateway.pure.cell.cell import Cell
    from gateway.pure.controllers.control import Control
    from gateway.pure.languages.base.hosting import Port, Programs
    from gateway.services.program_host import ProgramsOfControl


NO_PROGRAMS = '[controller] with memory = "FOLDER" names their folder, [val3] an application'


@dataclass(frozen=True, slots=True)
class CellLanguage:
    """A language whose programs run in a cell: one part in the interpreter process, one in the services."""

    name: str
    words: str
    given: "Callable[[Cell], bool]"  # the cell has programs of it
    programs: "Callable[[RunPlan, Port], Programs]"  # in the interpreter
    host: "Callable[[Cell, Control, CommandDispatcher], ProgramsOfControl]"  # in the services
    turn_ms: int = 0  # of the interpreter; 0: P5
    listing: "Callable[[Cell, str], Listing | None] | None" = None  # of a program by its name, for the page


def _memory_of(language: str) -> "Callable[[Cell], bool]":
    def has(cell: "Cell") -> bool:
        return cell.controller is not None and bool(cell.controller.memory) and CONTROLLERS[cell.controller.kind].memory == language

    return has


def _baps2_programs(plan: "RunPlan", port: "Port") -> "Programs":
    if any(line.program for line in plan.cell.line):
        from gateway.processes.baps2_lines import LinePrograms

        return LinePrograms(plan, port)
    from gateway.assembly.interpreter import Baps2Programs

    return Baps2Programs(plan, port)


def _baps2_host(cell: "Cell", control: "Control", dispatcher: "CommandDispatcher") -> "ProgramsOfControl":
    from gateway.pure.controllers.rho3.signals.control import RhoControl
    from gateway.services.rho3_programs import Rho3Programs

    assert isinstance(control, RhoControl)  # as `check` has it
    return Rho3Programs(control, cell.cell.language)


def _baps2_listing(cell: "Cell", program: str) -> "Listing | None":
    from gateway.assembly.listings import baps2_listing

    return baps2_listing(cell, program)


def _robotstar_listing(cell: "Cell", program: str) -> "Listing | None":
    from gateway.assembly.listings import robotstar_listing

    return robotstar_listing(cell, program)


def _robotstar_programs(plan: "RunPlan", port: "Port") -> "Programs":
    from gateway.assembly.robotstar import RobotstarPrograms

    return RobotstarPrograms(plan, port)


def _robotstar_host(cell: "Cell", control: "Control", dispatcher: "CommandDispatcher") -> "ProgramsOfControl":
    from gateway.assembly.robotstar import programs_of_control

    return programs_of_control(cell, control, dispatcher)


def _val3_programs(plan: "RunPlan", port: "Port") -> "Programs":
    from gateway.processes.val3_application import Val3Programs

    return Val3Programs(plan, port)


def _val3_host(cell: "Cell", control: "Control", dispatcher: "CommandDispatcher") -> "ProgramsOfControl":
    from gateway.assembly.programs import machines_of_cell, mask_of
    from gateway.pure.controllers.val3.application import HostedApplication
    from gateway.pure.controllers.val3.io.control import Val3Control
    from gateway.services.val3_programs import Val3Programs

    assert isinstance(control, Val3Control) and cell.val3 is not None  # as `check` has it
    mask = mask_of(cell, machines_of_cell(cell)[0])
    return Val3Programs(control, HostedApplication(control, dispatcher, mask, cell.val3.autostart, language=cell.cell.language))


CELL_LANGUAGES = table(
    CellLanguage("baps2", "BAPS2", _memory_of("baps2"), _baps2_programs, _baps2_host, listing=_baps2_listing),
    CellLanguage("robotstar", "ROBOTstar", _memory_of("robotstar"), _robotstar_programs, _robotstar_host, listing=_robotstar_listing),
    CellLanguage("val3", "VAL 3", lambda cell: cell.val3 is not None, _val3_programs, _val3_host, turn_ms=4),
)


def language_in(cell: "Cell") -> CellLanguage | None:
    """The language of the programs of a cell; None: it has none."""
    return next((row for row in CELL_LANGUAGES.values() if row.given(cell)), None)
