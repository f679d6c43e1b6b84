"""Tables of the cell file that are checked against one another."""

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from gateway.registry.rows import table

if TYPE_CHECKING:
    from types import ModuleType


@dataclass(frozen=True, slots=True)
class CellCheck:
    """Cross checks of a part of the cell file, in the order of a reader's questions; notes: warnings and notes of a sound cell."""

    name: str  # of the module in gateway.checks, with CHECKS and NOTES
    tables: tuple[str, ...]  # of the cell file
    notes: int = 0  # place of its notes among those of the others

    def module(self) -> "ModuleType":
        return import_module(f"gateway.checks.{self.name}")


CELL_CHECKS = table(
    CellCheck("command_sources", ("cell", "rc_inputs", "signals", "safety")),
    CellCheck("lines", ("line",), notes=2),
    CellCheck("modbus", ("modbus",)),
    CellCheck("blocks", ("db", "handshake", "position")),
    CellCheck("buses", ("bus",)),
    CellCheck("rho3_can", ("rho3",), notes=3),
    CellCheck("unused_parameters", (), notes=3),
    CellCheck("notes", (), notes=4),
    CellCheck("canopen", (), notes=5),
    CellCheck("jog", ()),
    CellCheck("axes", ("axis", "defaults", "plant")),
    CellCheck("telegrams", ("telegram",), notes=1),
    CellCheck("robots", ("robot", "check_position")),
    CellCheck("programs", ("program", "measuring", "path_output"), notes=8),
    CellCheck("belts", ("belt",)),
    CellCheck("alter", ("alter",)),
    CellCheck("shared", ("shared_output",)),
    CellCheck("web", ("web",)),
    CellCheck("northbound", ("northbound",)),
    CellCheck("controller", ("controller",), notes=7),
    CellCheck("routes", ("route",), notes=6),
    CellCheck("contacts", ("io",)),
    CellCheck("retain", ("retain",), notes=9),
    CellCheck("val3", ("val3",), notes=10),
)
