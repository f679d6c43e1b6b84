"""Views of a Modbus server: `view` of [[modbus]]."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.registry.rows import table

if TYPE_CHECKING:
    from gateway.assembly.modbus_views import OtherView
    from gateway.pure.cell.cell import Cell
    from gateway.pure.cell.controller import Controller
    from gateway.pure.cell.modbus import Modbus
    from gateway.pure.modbus.other_views import Image
    from gateway.pure.modbus.registers import Registers
    from gateway.pure.reports.tables import Cell as Field


@dataclass(frozen=True, slots=True)
class ModbusViewKind:
    """View of a Modbus server."""

    name: str
    words: str  # whose its registers are
    registers: "Callable[[Controller | None], list[int]]"  # its own registers
    controller: str = ""  # kind of [controller] it is of; "": any, or none
    signals: bool = False  # bits are RC signals; data blocks as files, the command block
    rows: "Callable[[Cell, Modbus], Iterable[tuple[Field, ...]]] | None" = None  # of its address map
    make: "Callable[[Controller, Image, Registers | None, str], OtherView] | None" = None  # a view of the controller's own


SIGNAL_REGISTERS = 64  # 1024 RC signals


def _signal_registers(controller: "Controller | None") -> list[int]:
    return list(range(SIGNAL_REGISTERS))


def _reis_registers(controller: "Controller | None") -> list[int]:
    from gateway.assembly.modbus_views import reis_registers

    return reis_registers()


def _val3_registers(controller: "Controller | None") -> list[int]:
    from gateway.assembly.modbus_views import val3_registers

    return val3_registers(controller)


def _reis_view(controller: "Controller", image: "Image", registers: "Registers | None", order: str) -> "OtherView":
    from gateway.assembly.modbus_views import reis_view

    return reis_view(controller, image, registers)


def _val3_view(controller: "Controller", image: "Image", registers: "Registers | None", order: str) -> "OtherView":
    from gateway.assembly.modbus_views import val3_view

    return val3_view(controller, image, registers, order)


def _reis_rows(cell: "Cell", server: "Modbus") -> "Iterable[tuple[Field, ...]]":
    from gateway.tools.address_map_views import reis_rows

    return reis_rows(cell, server)


def _val3_rows(cell: "Cell", server: "Modbus") -> "Iterable[tuple[Field, ...]]":
    from gateway.tools.address_map_views import val3_rows

    return val3_rows(cell, server)


MODBUS_VIEWS = table(
    ModbusViewKind("rho3", "RC signals of the view", _signal_registers, signals=True),
    ModbusViewKind("registers", "the view registers", lambda _: []),
    ModbusViewKind("reis", "the view reis", _reis_registers, controller="reis", rows=_reis_rows, make=_reis_view),
    ModbusViewKind("val3", "the view val3", _val3_registers, controller="val3", rows=_val3_rows, make=_val3_view),
)
