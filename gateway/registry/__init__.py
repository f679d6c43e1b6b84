"""Registry: kinds that a cell file may name, processes, languages and suites, one row each.

A row is data and functions that import inside, so reading the registry loads nothing. Code reads the properties of a row
(`LINE_LAYERS[line.layer].blocks`) and never compares names: a new kind is its own folder and a row in the module of its table.
docs/adding.md lists the tables.
"""

from collections.abc import Mapping

from gateway.registry.checks import CELL_CHECKS
from gateway.registry.controllers import CONTROLLERS
from gateway.registry.drives import BUS_PROTOCOLS, DRIVE_FAMILIES
from gateway.registry.languages import CELL_LANGUAGES, NO_PROGRAMS, language_in
from gateway.registry.lines import LINE_LAYERS, LineLayer, layer_spoken
from gateway.registry.modbus_views import MODBUS_VIEWS

__all__ = [
    "BUS_PROTOCOLS",
    "CELL_CHECKS",
    "CELL_LANGUAGES",
    "CONTROLLERS",
    "DRIVE_FAMILIES",
    "LINE_LAYERS",
    "MODBUS_VIEWS",
    "NAMES",
    "NO_PROGRAMS",
    "LineLayer",
    "language_in",
    "layer_spoken",
]

NAMES: Mapping[str, Mapping[str, object]] = {  # in the form used by gateway.pure.cell.marks.Registered
    "line layers": LINE_LAYERS,
    "drive families": DRIVE_FAMILIES,
    "bus protocols": BUS_PROTOCOLS,
    "controllers": CONTROLLERS,
    "Modbus views": MODBUS_VIEWS,
}
