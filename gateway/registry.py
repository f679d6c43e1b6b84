"""What exists: kinds a cell file may name, processes, languages and suites, one row each.

A row is data and functions that import inside, so reading the registry loads nothing. Code asks a row for what it needs to know
(`LINE_LAYERS[line.layer].blocks`) and never compares names: a new kind is its own folder and a row here. docs/adding.md lists the rows.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    from types import ModuleType

    from drivers.drives.family import BusFamily, DriveMaker
    from gateway.assembly.controllers import ControllerPlan
    from gateway.assembly.listings import Listing
    from gateway.assembly.modbus_views import OtherView
    from gateway.assembly.run import RunPlan
    from gateway.pure.arbitration.dispatcher import CommandDispatcher
    from gateway.pure.buses.load import Traffic
    from gateway.pure.cell.axes import Axis
    from gateway.pure.cell.cell import Bus, Cell, Line
    from gateway.pure.cell.controller import Controller
    from gateway.pure.cell.modbus import Modbus
    from gateway.pure.controllers.control import Control
    from gateway.pure.languages.base.hosting import Port, Programs
    from gateway.pure.lines.decoder import Decoder
    from gateway.pure.modbus.other_views import Image
    from gateway.pure.modbus.registers import Registers
    from gateway.pure.reports.tables import Cell as Field
    from gateway.services.controller_host import Panel
    from gateway.services.program_host import ProgramsOfControl
    from gateway.services.sources.base import BaseSource
    from protocols.rk512.active import Denied, Failed
    from protocols.rk512.dialects import Dialect


class Row(Protocol):
    """Every row has a name."""

    @property
    def name(self) -> str: ...


R = TypeVar("R", bound=Row)


def _table(*rows: R) -> Mapping[str, R]:
    return {row.name: row for row in rows}


# ---- layers of a serial line: `layer` of [[line]] ---------------------------------------------------------------------


def _procedure_decoder(line: "Line") -> "Decoder":
    from gateway.pure.lines.decoder import LineDecoder

    return LineDecoder(both=True, block_check=line.protocol == "3964R")


@dataclass(frozen=True, slots=True)
class LineLayer:
    """What rides on the link of a [[line]]."""

    name: str
    words: str  # as texts call it
    source: "Callable[[], Callable[..., BaseSource]]"  # its command source
    commands: bool = True  # it is a command source
    blocks: bool = False  # [[db]] are served by number, with jobs of RK512
    first: bool = False  # the usual one: blocks without a line are of the only line of this layer, else of the only one that serves any
    telegrams: bool = False  # [[telegram]] belong to it; a quiet partner is no loss
    shadowed: bool = False  # a shadow understands it
    kinds: str = "DXEAMTZ"  # of blocks that it carries
    profile: str = ""  # a station of this profile speaks it whatever the layer says
    dialect: "Callable[[Line], Dialect] | None" = None  # of its blocks
    failure: "Callable[[Failed | Denied], object] | None" = None  # what the partner shows where our own job failed
    decoder: "Callable[[Line], Decoder]" = _procedure_decoder  # decodes the line for page and monitor


def _blocks_source() -> "Callable[..., BaseSource]":
    from gateway.services.sources.rk512 import Rk512Source

    return Rk512Source


def _telegram_source() -> "Callable[..., BaseSource]":
    from gateway.services.sources.telegrams import TelegramSource

    return TelegramSource


def _rk512_dialect(line: "Line") -> "Dialect":
    from protocols.rk512.dialects import dialect_of

    return dialect_of(line.profile)


def _buep64_dialect(line: "Line") -> "Dialect":
    from gateway.pure.lines.buep64 import buep64_dialect
    from protocols.buep64.form import Form

    return buep64_dialect(Form())


def _buep64_failure(event: "Failed | Denied") -> object:
    from gateway.pure.lines.buep64 import buep64_fault

    return buep64_fault(event)


LINE_LAYERS = _table(
    LineLayer("rk512", "RK512", _blocks_source, blocks=True, first=True, shadowed=True, dialect=_rk512_dialect),
    LineLayer("telegrams", "telegrams", _telegram_source, telegrams=True),
    LineLayer(
        "buep64", "BUEP64", _blocks_source, blocks=True, kinds="D", profile="bosch-buep64", dialect=_buep64_dialect, failure=_buep64_failure
    ),
    LineLayer("program", "program", _blocks_source, commands=False),  # programs of the old control own the line
)


def layer_spoken(line: "Line") -> LineLayer:
    """The layer of a line as its station speaks it."""
    station = line.profile.removesuffix("-tcp")
    return next((layer for layer in LINE_LAYERS.values() if layer.profile and layer.profile == station), LINE_LAYERS[line.layer])


# ---- drives: `type` of a [[axis]] drive, `protocol` of a [[bus]] --------------------------------------------------------


@dataclass(frozen=True, slots=True)
class DriveFamily:
    """What the drive of an axis is."""

    name: str
    words: str
    protocol: str  # of its bus
    address: str  # key of its number on the bus
    settings: "Callable[[Axis, int, float], DriveMaker]"  # axis, largest step of one cycle in increments, cycle in ms
    sentence: Callable[[int, str], str]  # fault code, language
    objects: bool = False  # an object dictionary: data sheet, SDO, serial number, stop option, touch probe
    boosted: bool = False  # a SERVODYN booster: machine parameters of the rho 3 reach it, its bus' layout is its data sheet
    homes: bool = False  # references itself where home.by = "drive"


def _cia402_settings(axis: "Axis", step_inc: int, p5_ms: float) -> "DriveMaker":
    from drivers.drives.cia402 import Cia402Settings

    return Cia402Settings(
        jump_inc=axis.drive.inc_per_turn // 2,
        step_inc=step_inc,
        timeout_cycles=round(5000 / p5_ms),
        homing_cycles=round(axis.home.timeout_s * 1000 / p5_ms),
        mode_cycles=round(2000 / p5_ms),
    )


def _servodyn_settings(axis: "Axis", step_inc: int, p5_ms: float) -> "DriveMaker":
    from drivers.drives.servodyn import DriveSettings

    return DriveSettings(step_inc=step_inc, timeout_cycles=round(5000 / p5_ms), brake=axis.brake != "none")


def _cia402_sentence(code: int, language: str) -> str:
    from drivers.drives import cia402_words

    return cia402_words.sentence(code, language)


def _servodyn_sentence(code: int, language: str) -> str:
    from drivers.drives import servodyn_words

    return servodyn_words.sentence(code, language)


DRIVE_FAMILIES = _table(
    DriveFamily("servodyn", "SERVODYN", "servodyn", "module", _servodyn_settings, _servodyn_sentence, boosted=True),
    DriveFamily("cia402", "CiA 402", "canopen", "node", _cia402_settings, _cia402_sentence, objects=True, homes=True),
)


@dataclass(frozen=True, slots=True)
class BusProtocol:
    """What is spoken on a CAN bus."""

    name: str
    axis_bytes: int  # of one frame of an axis
    family: "Callable[[Cell, Bus, int], BusFamily]"  # cell, bus, cycle in ms
    traffic: "Callable[[Cell, Bus], list[Traffic]]"
    clocked: bool = True  # its cycle is the clock of the cell
    nodes: bool = False  # CANopen: nodes, heartbeats, SDO
    boosted: bool = False  # SERVODYN: the layout is axisgate's own and wants evidence; P5 is its cycle
    blocks: bool = False  # nothing but I/O blocks of the rho 3 (P30)


def _canopen_family(cell: "Cell", bus: "Bus", p5_ms: int) -> "BusFamily":
    from gateway.assembly.drive_buses import canopen_family

    return canopen_family(cell, bus, p5_ms)


def _servodyn_family(cell: "Cell", bus: "Bus", p5_ms: int) -> "BusFamily":
    from gateway.assembly.drive_buses import servodyn_family

    return servodyn_family(cell, bus)


def _block_family(cell: "Cell", bus: "Bus", p5_ms: int) -> "BusFamily":
    from gateway.assembly.rho3_buses import with_rho3

    return with_rho3(cell, bus, None)


def _canopen_traffic(cell: "Cell", bus: "Bus") -> "list[Traffic]":
    from gateway.assembly.bus_frames import canopen_traffic

    return canopen_traffic(cell, bus)


def _servodyn_traffic(cell: "Cell", bus: "Bus") -> "list[Traffic]":
    from gateway.assembly.bus_frames import servodyn_traffic

    return servodyn_traffic(cell, bus)


def _block_traffic(cell: "Cell", bus: "Bus") -> "list[Traffic]":
    from gateway.assembly.bus_frames import block_traffic

    return block_traffic(cell, bus)


BUS_PROTOCOLS = _table(
    BusProtocol("servodyn", 8, _servodyn_family, _servodyn_traffic, boosted=True),
    BusProtocol("canopen", 6, _canopen_family, _canopen_traffic, nodes=True),  # controlword + position, statusword + position
    BusProtocol("rho3-io", 6, _block_family, _block_traffic, clocked=False, blocks=True),
)


# ---- controllers: `kind` of [controller]; Modbus views: `view` of [[modbus]] --------------------------------------------


@dataclass(frozen=True, slots=True)
class ControllerKind:
    """An old control as its PLC sees it."""

    name: str
    words: str
    make: "Callable[[ControllerPlan], tuple[Control, list[str]]]"  # the control, and what its files have wrong
    flags: str = ""  # what its flags are called where they outlive power-off; "": it has none
    counters: bool = False
    parameters: bool = False  # machine parameters of [rho3] act in it: processes, pendant, measuring inputs of its boards
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


CONTROLLERS = _table(
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


# ---- languages: programs of an old control that the interpreter runs in a cell -------------------------------------------


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


CELL_LANGUAGES = _table(
    CellLanguage("baps2", "BAPS2", _memory_of("baps2"), _baps2_programs, _baps2_host, listing=_baps2_listing),
    CellLanguage("robotstar", "ROBOTstar", _memory_of("robotstar"), _robotstar_programs, _robotstar_host, listing=_robotstar_listing),
    CellLanguage("val3", "VAL 3", lambda cell: cell.val3 is not None, _val3_programs, _val3_host, turn_ms=4),
)


def language_in(cell: "Cell") -> CellLanguage | None:
    """The language of the programs of a cell; None: it has none."""
    return next((row for row in CELL_LANGUAGES.values() if row.given(cell)), None)


@dataclass(frozen=True, slots=True)
class ModbusViewKind:
    """What a Modbus server shows."""

    name: str
    words: str  # whose its registers are
    registers: "Callable[[Controller | None], list[int]]"  # that it has of its own
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


MODBUS_VIEWS = _table(
    ModbusViewKind("rho3", "RC signals of the view", _signal_registers, signals=True),
    ModbusViewKind("registers", "the view registers", lambda _: []),
    ModbusViewKind("reis", "the view reis", _reis_registers, controller="reis", rows=_reis_rows, make=_reis_view),
    ModbusViewKind("val3", "the view val3", _val3_registers, controller="val3", rows=_val3_rows, make=_val3_view),
)


# ---- tables of the cell file that are judged against one another ---------------------------------------------------------


@dataclass(frozen=True, slots=True)
class CellCheck:
    """Cross checks of a part of the cell file, in the order of a reader's questions; notes: warnings and notes of a sound cell."""

    name: str  # of the module in gateway.checks, with CHECKS and NOTES
    tables: tuple[str, ...]  # of the cell file
    notes: int = 0  # place of its notes among those of the others

    def module(self) -> "ModuleType":
        return import_module(f"gateway.checks.{self.name}")


CELL_CHECKS = _table(
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


# ---- names that the tables of the cell file may use ----------------------------------------------------------------------


NAMES: Mapping[str, Mapping[str, object]] = {  # as gateway.pure.cell.marks.Registered asks
    "line layers": LINE_LAYERS,
    "drive families": DRIVE_FAMILIES,
    "bus protocols": BUS_PROTOCOLS,
    "controllers": CONTROLLERS,
    "Modbus views": MODBUS_VIEWS,
}
