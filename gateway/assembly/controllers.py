"""From [controller] and [rho3] of a cell to the control its PLC sees: parameters, DAT files, signals where this cell has them."""

import pathlib
from collections.abc import Mapping
from dataclasses import dataclass

from gateway.assembly.axis_signals import OUTPUT_SIGNALS, assumed_permits, rc_numbers
from gateway.assembly.data_block_signals import signals_of
from gateway.files.dat import DatTables, read_tables
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.controller import Controller, ControllerPoint, ControllerProcess, ProcessStep
from gateway.pure.cell.rho3 import COUPLED
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.control import ReisControl, ReisSetup
from gateway.pure.controllers.reis.regulator import Reference
from gateway.pure.controllers.rho3.functions.addresses import STROBE_TIME, Places
from gateway.pure.controllers.rho3.functions.plc import Settings
from gateway.pure.controllers.rho3.pendant.infos import SIGNALS
from gateway.pure.controllers.rho3.pendant.operation import PhgError, operation
from gateway.pure.controllers.rho3.pendant.user_memory import SIZES
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.coupling import Coupling, Ranges
from gateway.pure.controllers.rho3.signals.drives import AXES as SIGNALLED
from gateway.pure.controllers.rho3.signals.fast_io import Configured, FastParts
from gateway.pure.controllers.rho3.signals.numbers import numbers_of
from gateway.pure.controllers.rho3.signals.panel_view import TEST_MN
from gateway.pure.controllers.rho3.signals.setup import Declared, Setup
from gateway.pure.controllers.rho3.signals.steps import Step
from gateway.pure.controllers.rho3.signals.supervision import has_grace
from gateway.pure.controllers.rho3.signals.timers import unit_of
from gateway.pure.controllers.rho3.signals.user import OUTPUTS
from gateway.pure.controllers.rho3.signals.whole import Installation
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.controllers.val3.io.system import Board, Point
from gateway.pure.cycle.enabling_inputs import SIGNAL_AXES
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import RC_BYTES, Permit, set_bit
from gateway.pure.image.signals import SignalList
from gateway.registry import CONTROLLERS
from motion.errors import MotionError
from motion.geometry.units import from_si
from motion.program.factors import option_byte
from protocols.base.machine import Ns, ms

PERMIT_BITS = (("chain", Permit.CHAIN), ("control", Permit.CONTROL), ("feed", Permit.FEED), ("run", Permit.RUN), ("travel", Permit.TRAVEL))
MOVABLE = {  # field of Places -> signal of ours, or of the manual with two numbers
    "select_strobe": "STBEXPA_RCI", "selected": "PROGSEL_RCO", "select_error": "SELERR_RCO", "msd_open": "MSD_ACTI_RCO",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Parameters:
    """The P numbers the interface needs, where they are the kind of number they should be.  ValueError otherwise."""

    cell: Cell

    def number(self, name: str, default: int) -> int:
        """A single integer among those kept as typed."""
        value = self.cell.rho3.others.get(name, default) if self.cell.rho3 else default
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError(f"{name} = {value!r}: a whole number is expected")
        return value

    def row(self, name: str) -> tuple[int, ...]:
        """A list of integers; () if it is missing."""
        value = self.cell.rho3.others.get(name, ()) if self.cell.rho3 else ()
        if not isinstance(value, tuple | list) or any(isinstance(each, bool) or not isinstance(each, int) for each in value):
            raise ValueError(f"{name} = {value!r}: a list of whole numbers is expected")
        return tuple(each for each in value if isinstance(each, int))


@dataclass(frozen=True, slots=True)
class ControllerPlan:
    """Parts of a control."""

    cell: Cell
    controller: Controller
    owners: Mapping[int, int]  # RC input byte -> number of its command source
    sources: Mapping[str, int]  # name of a command source -> its number
    dispatcher: CommandDispatcher
    errors: ErrorList
    now: Ns


def make_control(
    cell: Cell, owners: Mapping[int, int], sources: Mapping[str, int], dispatcher: CommandDispatcher, errors: ErrorList, now: Ns
) -> tuple[Control | None, list[str]]:
    """The control of a cell and the faults of its files, line by line; None without [controller].

    `owners`: RC input byte -> number of its command source; `doors`: name -> number.  ValueError: `check` has refused it before.
    """
    controller = cell.controller
    if controller is None:
        return None, []
    return CONTROLLERS[controller.kind].make(ControllerPlan(cell, controller, owners, sources, dispatcher, errors, now))


def make_reis(plan: ControllerPlan) -> tuple[Control, list[str]]:
    """Markers and binary channels of a ROBOTstar."""
    control = ReisControl(reis_setup(plan.cell, plan.controller, plan.sources), plan.dispatcher)
    control.robot.errors = plan.errors
    return control, []


def make_val3(plan: ControllerPlan) -> tuple[Control, list[str]]:
    """Points of a VAL 3 controller."""
    return Val3Control(points_of(plan.controller), plan.owners, hosts=plan.cell.val3 is not None), []


def make_rho3(plan: ControllerPlan) -> tuple[Control, list[str]]:
    """The interface of a rho 3, with its DAT files."""
    tables = dat_tables(plan.cell, plan.controller)
    language = plan.cell.cell.language
    setup = rho_setup(plan.cell, plan.controller, tables, plan.owners)
    return RhoControl(setup, plan.dispatcher, plan.errors, plan.now), [fault.text(language) for fault in tables.faults]


def dat_tables(cell: Cell, controller: Controller) -> DatTables:
    """The DAT files of the cell's folder; none where it names no folder."""
    if not controller.files:
        return DatTables()
    return read_tables(pathlib.Path(cell.file).parent / controller.files, cell.cell.language, controller.code_page)


def rho_setup(cell: Cell, controller: Controller, tables: DatTables, owners: Mapping[int, int]) -> Setup:
    """All that the rho 3 side needs; ValueError: a parameter out of its range."""
    signals, rho3 = signals_of(cell), cell.rho3
    emergency = signals.named("EMERGOP_RCI")
    assumed, numbers = assumed_permits(cell), rc_numbers(cell)
    names = [axis.name for axis in cell.axis]
    return Setup(
        installation=installation(cell, controller),
        numbers=numbers_of(signals),
        functions=Settings(
            STROBE_TIME if rho3 is None else ms(rho3.P9), cell.cell.language, controller.phg_option, places_of(signals),
            tables.msd, tables.texts, tables.programs, tables.modes,
        ),
        programs=tuple(declared(each, names) for each in controller.process),
        axes=tuple(names),
        owners=owners,
        assumed=tuple(getattr(numbers, name) for name, permit in PERMIT_BITS if assumed & permit),
        of_cycle=of_cycle(cell),
        emergency_op=140 if emergency is None else emergency.at.number,
        fast=FastParts(boards_of(controller), p11_of(cell, controller), multi_function(cell, controller), bool(controller.memory)),
        coupling=coupling_of(cell),
        plc_silence=ms(controller.plc_silence_ms),
        pic_timeout=ms(controller.pic_timeout_ms),
        plc_grace=not cell.cell.software or has_grace(cell.cell.software, controller.remote),
        sets_override=not any(entry.to == "cell.override" for block in cell.db for entry in block.entries),
        units=tuple((axis.unit, from_si(1.0, axis.unit)) for axis in cell.axis),
        limits=tuple((axis.limits.min, axis.limits.max) for axis in cell.axis),
        info_bits={
            name: found.at.number for name in (TEST_MN, *(row[1] for row in SIGNALS)) if (found := signals.named(name)) is not None
        },
        option=option_of(cell),
        p35=p35_of(cell),
        memory=SIZES[controller.hardware] if controller.memory else 0,
        parameters=parameters_of(cell),
        password=controller.password,
        pic=bool(controller.pic),
        robot_masks=robot_masks(cell) if controller.memory else (),
    )  # fmt: skip


def parameters_of(cell: Cell) -> tuple[tuple[str, str], ...]:
    """The machine parameters of a cell by number, as the pendant shows them."""
    given = cell.rho3.others if cell.rho3 is not None else {}
    names = sorted((name for name in given if name[1:].isdecimal()), key=lambda name: int(name[1:]))
    return tuple((name, " ".join(map(str, value)) if isinstance(value := given[name], tuple | list) else str(value)) for name in names)


def p35_of(cell: Cell) -> int:
    """P35, the mode of the PHG 2000.  ValueError."""
    try:
        return operation(Parameters(cell).number("P35", 0)).mode.value
    except PhgError as error:
        raise ValueError(str(error)) from error


def robot_masks(cell: Cell) -> tuple[int, ...]:
    """Axes of each robot, for programs of the interpreter."""
    from gateway.assembly.programs import machines_of_cell, mask_of

    try:
        return tuple(mask_of(cell, machine) for machine in machines_of_cell(cell))
    except MotionError:  # a robot that does not fit: its own check reports it
        return ()


def option_of(cell: Cell) -> int:
    """P25: which operation resets which factors; ValueError: not eight entries of 0 and 1."""
    row = Parameters(cell).row("P25")
    try:
        return option_byte(row) if row else 0
    except MotionError as error:
        raise ValueError(str(error)) from error


def installation(cell: Cell, controller: Controller) -> Installation:
    """Machine parameters of the interface."""
    given, rho3 = Parameters(cell), cell.rho3
    p24 = rho3.P24 if rho3 else "all"
    return Installation(
        axes=min(len(cell.axis), SIGNALLED),
        kinematics=controller.kinematics,
        p2=rho3.P2 if rho3 else 0,
        p3=given.number("P3", 8),
        p13=given.row("P13"),
        p14=given.row("P14"),
        p24=p24 if isinstance(p24, int) else OUTPUTS,
        p27=given.number("P27", 0),
        unit=unit_of(controller.hardware, ms(cell.cycle_ms)),
    )


def multi_function(cell: Cell, controller: Controller) -> tuple[int, int] | None:
    """P36, inputs and outputs; only a rho 3.0 has the terminals."""
    if controller.hardware != "rho3.0":
        return None
    places = Parameters(cell).row("P36") or (0, 0)
    if len(places) != 2:
        raise ValueError(f"P36 = {places}: two numbers, inputs and outputs")
    return places[0], places[1]


def boards_of(controller: Controller) -> tuple[str, ...]:
    """Servo boards the cell names; a rho 3.0 has its four inputs and outputs at X21."""
    if controller.hardware != "rho3.0":
        return controller.boards
    if controller.boards:
        raise ValueError(f"boards = {list(controller.boards)}: a rho3.0 has its own inputs and no such board")
    return ("rho3.0",)


def p11_of(cell: Cell, controller: Controller) -> tuple[Configured, ...]:
    """P11: probe and high-speed inputs of each board in turn; of a rho 3.0 probe, inputs and outputs."""
    numbers = Parameters(cell).row("P11")
    each = 3 if controller.hardware == "rho3.0" else 2
    boards = 1 if each == 3 else 3
    if len(numbers) % each or len(numbers) > each * boards or any(number < 0 for number in numbers):
        parts = "probe, inputs, outputs" if each == 3 else "probe and inputs for each of at most three boards"
        raise ValueError(f"P11 = {list(numbers)}: {parts}")
    return tuple(Configured(*numbers[at : at + each]) for at in range(0, len(numbers), each))


def coupling_of(cell: Cell) -> Coupling | None:
    """Ranges in the PLC; None where P20 names no bit coupling.  CouplingFault (a ValueError) where P21 does not fit."""
    rho3 = cell.rho3
    if rho3 is None or rho3.P20 not in COUPLED:
        return None
    if rho3.P21 and len(rho3.P21) != 4:
        raise ValueError(f"P21 = {rho3.P21}: four numbers, I.START, I.END, O.START, O.END")
    return Coupling(rho3.P20, Ranges(*rho3.P21) if rho3.P21 else None)


def places_of(signals: SignalList) -> Places:
    """Where the functions' signals are in this cell."""
    found = {field: signal.at.number for field, name in MOVABLE.items() if (signal := signals.named(name)) is not None}
    return Places(**found)


def of_cycle(cell: Cell) -> bytes:
    """RC output bits the cycle writes: its own signals, and the inputs of CAN I/O blocks."""
    image, numbers = bytearray(RC_BYTES), rc_numbers(cell)
    for field in OUTPUT_SIGNALS.values():
        first = getattr(numbers, field)
        for step in range(min(len(cell.axis), SIGNAL_AXES) if field in ("in_position", "referenced") else 1):
            set_bit(image, first + step, True)
    for block in cell.rho3.P31 if cell.rho3 else ():
        image[block.start : block.start + block.length] = b"\xff" * block.length
    return bytes(image[:RC_BYTES])


def declared(process: ControllerProcess, axes: list[str]) -> Declared:
    """[[controller.process]] with its axes counted."""
    steps = tuple(_step(step, axes) for step in process.steps)
    return Declared(process.name.upper(), steps, process.kind == "permanent", process.priority, process.kinematics, process.repeat)


def _step(step: ProcessStep, axes: list[str]) -> Step:
    return Step(
        {axes.index(name): target for name, target in step.to.items()},
        step.program,
        float(step.speed.rstrip(" %")) / 100.0,
        step.output or 0,
        step.input or 0,
        step.value,
        ms(step.wait_ms or 0),
    )


def reis_setup(cell: Cell, controller: Controller, sources: Mapping[str, int]) -> ReisSetup:
    """A Reis: its axes, the command source that its markers command, and the source of its synchronism."""
    references = {
        number: Reference(axis.home.position, round(axis.home.offset * 1000), -1 if axis.mechanics.direction == "-" else 1)
        for number, axis in enumerate(cell.axis, 1)
    }
    source = sources.get(controller.command_source, next(iter(sources.values()), 0))
    factors = tuple(1000.0 if axis.unit == "mm" else 57.29577951308232 for axis in cell.axis)
    names = tuple(axis.name for axis in cell.axis)
    given = controller.first_byte, controller.plc_only, controller.robot_only
    return ReisSetup(names, source, *given, references, factors, bool(controller.memory))


def points_of(controller: Controller) -> list[Point]:
    """System inputs and outputs; points of one board share it."""
    boards = {point.board: Board(point.board) for point in controller.point}
    return [point_of(point, boards[point.board]) for point in controller.point]


def point_of(point: ControllerPoint, board: Board) -> Point:
    """One of them."""
    return Point(
        point.name, board, point.module, point.address, point.output, point.bit or 0, point.byte or 0,
        point.steps, point.min, point.max, point.integer, point.description,
    )  # fmt: skip
