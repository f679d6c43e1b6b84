"""[[program]]: numbers are there once, the robot fits the axes, every file is found and reads without a fault."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.drive_buses import DRIVE_PROTOCOLS, make_family
from gateway.assembly.fast_inputs import fast_wires
from gateway.assembly.programs import bnr_files, machines_of_cell, numbers_by_axis, numbers_of, robots_of, written_for
from gateway.checks.context import Context, twice
from gateway.files.eds_sheets import read_eds
from gateway.files.find import ConfigNotFound, beside, read_text
from gateway.pure.cell.belts import Measuring
from gateway.pure.cell.cell import Cell, Notice
from gateway.pure.cell.programs import Program
from gateway.pure.controllers.rho3.signals.fast_io import BOARDS, FastInputs
from gateway.pure.cycle.enabling_inputs import free_outputs
from gateway.registry import CONTROLLERS, DRIVE_FAMILIES

if TYPE_CHECKING:
    from motion.program.blocks import Block

ANALOG = 200


def programs(check: Context) -> None:
    """Reach and limits along the way are looked at by `axisgate motion check`, and before every run of a program."""
    cell = check.cell
    _measuring(check)
    _path_outputs(check)
    if not cell.program and not (cell.belt and cell.robot):
        return
    for number, _, _ in twice((each.number, str(n)) for n, each in enumerate(cell.program)):
        check.fault(f"program.{number}.number", number, "this number has a program already")
    if not cell.axis:
        return  # reported elsewhere, or removed with a fault of its own
    from motion.errors import MotionError

    try:
        machines_of_cell(cell)
    except MotionError as error:
        check.fault("robot.model" if cell.robot else "program", cell.robot[0].model if cell.robot else "", str(error))
        return
    names = {word for robot in cell.robot for word in (robot.name, robot.model)}
    for each in cell.program:
        if each.kinematics and each.kinematics not in names:
            check.fault(f"program.{each.number}.kinematics", each.kinematics, "no [robot] has this name")
        else:
            _read(check, f"program.{each.number}.file", each)


def _read(check: Context, key: str, table: Program) -> None:
    from gateway.pure.planning.team import machines_in
    from motion.errors import MotionError
    from motion.program.text.reader import read
    from motion.program.text.team import read_team, several

    file, cell = table.file, check.cell
    try:
        path = beside(cell.file, file, "programs")
        text = read_text(path)
        numbers = [1]
        if len(cell.robot) > 1 or several(text):
            by_axis = numbers_by_axis(cell)
            numbers = [by_axis.get(machine.limits[0].name, 1) for machine in machines_in(robots_of(cell, text, table.kinematics))]
        if several(text):
            rows = [
                [block for block in moves if block is not None] for moves in zip(*(s.moves for s in read_team(text).blocks), strict=True)
            ]
        else:
            program = read(text)
            rows = [list(program.blocks)]
            if len(cell.robot) == 1 and not written_for(program.robot, cell.robot[0].model):
                check.fault(key, file, f"is written for robot {program.robot}, this cell's is {cell.robot[0].model}")
    except (ConfigNotFound, OSError, UnicodeDecodeError) as error:
        check.fault(key, file, str(error))
        return
    except MotionError as error:
        check.fault(key, file, str(error).splitlines()[0])
        return
    for number, blocks in zip(numbers, rows, strict=False):  # a program of several kinematics may have no blocks
        _named(check, key, file, blocks, number)
        for name, data in bnr_files(str(path), blocks).items():
            if isinstance(data, MotionError):
                line = next(block.line for block in blocks if block.file is not None and block.file.name == name)
                check.fault(key, file, f"line {line}: move_file {data}")


def _named(check: Context, key: str, file: str, blocks: "Sequence[Block]", number: int) -> None:
    """Measuring inputs that blocks of one robot, by its number, name."""
    from motion.program.blocks import Flying, Latching

    latches = {each.latch for each in check.cell.measuring if each.latch and number in numbers_of(check.cell, each.robot)}
    there = {each.channel for each in check.cell.measuring if number in numbers_of(check.cell, each.robot)}
    for block in blocks:
        named = [asked.channel for asked in (block.until, block.wait) if asked is not None and asked.channel]
        named += [call.channel for call in block.functions if isinstance(call, Flying)]
        for call in block.functions:
            if isinstance(call, Latching) and call.name not in latches:
                check.fault(key, file, f"line {block.line}: {call.name} is in no [[measuring]] table (latch)")
        for channel in [each for each in named if each not in there]:
            check.fault(key, file, f"line {block.line}: channel {channel} is in no [[measuring]] table of the robot")


def _path_outputs(check: Context) -> None:
    """[[path_output]]: every function once, on outputs without another writer, a PPO on full bytes."""
    cell, taken = check.cell, set[int]()
    free = free_outputs(rc_numbers(cell), len(cell.axis))
    for word, _, _ in twice((f"{each.kind} {each.function}", str(n)) for n, each in enumerate(cell.path_output)):
        check.fault(f"path_output.{word}", word, "this function has an output already")
    for each in cell.path_output:
        key = f"path_output.{each.kind} {each.function}"
        bits = set(range(each.output, each.output + (each.bits if each.kind == "ppo" else 1)))
        if not bits <= free or bits & taken:
            check.fault(f"{key}.output", each.output, "axisgate itself, or another function, writes this output")
        if each.kind == "ppo" and each.output % each.bits:
            check.fault(f"{key}.output", each.output, f"the address of a {each.bits}-bit value must be a multiple of {each.bits}")
        if each.kind == "ppo" and (each.function > ANALOG) is (each.rated == 0.0):
            check.fault(f"{key}.rated", each.rated, "functions from 201 on are analog and have a rated value (P405), others have none")
        if each.volts not in (10.0, 13.3):
            check.fault(f"{key}.volts", each.volts, "", "10 or 13.3", "V")
        taken |= bits
    if cell.path_output and not cell.robot:
        check.fault("path_output", "", "the coordinates are those of a robot: [robot] with a model is missing")


def _measuring(check: Context) -> None:
    """[[measuring]]: every channel once, on existing axes, and with P11 only the channels it declares (L1257)."""
    cell = check.cell
    for channel, _, _ in twice((each.channel, str(n)) for n, each in enumerate(cell.measuring)):
        check.fault(f"measuring.{channel}.channel", channel, "another table has this channel")
    for each in cell.measuring:
        for axis in each.axes:
            check.unknown(f"measuring.{each.channel}.axes", axis, "axis")
        _probes(check, each)
    for name, _, _ in twice((each.latch, str(each.channel)) for each in cell.measuring if each.latch):
        check.fault("measuring.latch", name, "another table is this fast input already")
    for twofold, _, _ in twice((name, str(each.channel)) for each in cell.measuring for name in each.drives):
        check.fault("measuring.drives", twofold, "another table has the touch probe of this drive already")
    if not cell.measuring or cell.controller is None or not CONTROLLERS[cell.controller.kind].parameters or cell.rho3 is None:
        return
    from gateway.assembly.controllers import boards_of, p11_of

    try:
        fast = FastInputs([BOARDS[name] for name in boards_of(cell.controller)], p11_of(cell, cell.controller))
    except ValueError:
        return  # checks.controller reports faults of P11
    for each in cell.measuring:
        if fast.configured and each.channel not in fast.channels():
            given = ", ".join(map(str, fast.channels())) or "none"
            check.fault(f"measuring.{each.channel}.channel", each.channel, f"inadmissable input: P11 states {given}")


def _probes(check: Context, measuring: Measuring) -> None:
    """A wire leads to an RC input or to drives; only CiA 402 drives have touch probes, and those only replace a probe 6x0."""
    key = f"measuring.{measuring.channel}"
    if (measuring.input < 0) is (not measuring.drives):
        check.fault(f"{key}.input", measuring.input, "it is wired to an RC input (input) or to drives (drives): name one")
    if not measuring.drives:
        return
    if measuring.channel % 10:
        check.fault(f"{key}.drives", measuring.channel, "drives catch edges of a probe 6x0; an input 6xy needs its level: input")
    axes = {axis.name: axis for axis in check.cell.axis}
    for name in measuring.drives:
        if check.unknown(f"{key}.drives", name, "axis") or name not in axes:
            continue
        if measuring.axes and name not in measuring.axes:
            check.fault(f"{key}.drives", name, "is not among the axes of the board")
        if not DRIVE_FAMILIES[axes[name].drive.type].objects:
            check.fault(f"{key}.drives", name, "its drive has no touch probe (60B8h): wire it to an RC input")
            continue
        sheet = read_eds(check.cell, axes[name], simulated=False)
        if sheet is not None and sheet.dictionary.entry(0x60B8, 0) is None:
            check.fault(f"{key}.drives", name, f"{sheet.path.name} has no touch probe (60B8h): wire it to an RC input")


def wires(cell: Cell) -> Iterator[Notice]:
    """Report the path of each measuring input (AX-481)."""
    if not cell.measuring:
        return
    buses = {bus.name: make_family(cell, bus, cell.cycle_ms, simulated=True) for bus in cell.bus if bus.protocol in DRIVE_PROTOCOLS}
    fast = fast_wires(cell, buses)
    numbers = fast.numbers if fast is not None else frozenset()
    for each in cell.measuring:
        if each.drives:
            where = f"touch probe {each.probe} of {', '.join(each.drives)}"
            yield Notice("note", f"measuring.{each.channel}.drives", f"{where} measures, other axes at that instant (AX-569)")
            continue
        way = "is read in the cycle" if each.input in numbers else "passes through the services process, one or two cycles later"
        yield Notice("note", f"measuring.{each.channel}.input", f"RC input {each.input} {way} (AX-481)")


CHECKS = (programs,)
NOTES = (wires,)
