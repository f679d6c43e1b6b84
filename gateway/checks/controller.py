"""Cross checks of [controller]: parameters, processes, points, files; faults of the DAT files line by line.

Controls and languages are imported only for a cell that has one: loading them takes a third of a check's time, and every start of a run
checks.
"""

import pathlib
from collections.abc import Iterator

from gateway.assembly.data_block_signals import signals_of
from gateway.assembly.pic import pic_bytes
from gateway.assembly.program_memory import memory_folder, plc_folder
from gateway.checks.context import Context, number, program_lines
from gateway.pure.cell.cell import Cell, Notice
from gateway.pure.cell.controller import Controller, ControllerPoint, ProcessStep
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.rho3.pendant.catalogue import PREFIX
from gateway.registry import CONTROLLERS

STEP_KEYS = ("to", "program", "output", "input", "wait_ms")


def trial(cell: Cell) -> Control | None:
    """The control of the cell, driving nothing, None where it has none; ValueError: a parameter does not fit."""
    if cell.controller is None:
        return None
    from gateway.assembly.controllers import make_control
    from gateway.pure.arbitration.dispatcher import CommandDispatcher
    from gateway.pure.image.error_list import ErrorList

    return make_control(cell, {}, {}, CommandDispatcher((), lambda *_: b"", 1), ErrorList(), 0)[0]


def names_of(cell: Cell) -> frozenset[str]:
    """Values that the control of this cell has in addition to signals and flags."""
    try:
        control = trial(cell)
    except ValueError:
        return frozenset()
    return frozenset(control.names() if control is not None else ())


def wired(cell: Cell, name: str) -> bool:
    """Whether a route may write this value of the control: an input that is wired to it."""
    if name not in names_of(cell):
        return False
    control = trial(cell)
    assert control is not None  # it has names
    try:
        control.put(name, 0.0)
    except KeyError:
        return False
    return True


def phg_fault(cell: Cell, name: str) -> str:
    """Fault of a variable of the PHG to be shown as a number; "" for other names and for an existing one."""
    if not name.startswith(PREFIX):
        return ""
    only = 'variables of the PHG need [controller] with kind = "rho3"'
    if cell.controller is None:
        return only
    from gateway.pure.controllers.rho3.functions.system_variables import VariableError
    from gateway.pure.controllers.rho3.signals.control import RhoControl

    try:
        control = trial(cell)
        if not isinstance(control, RhoControl):
            return only
        control.pendant.phg.number(name)
    except KeyError:
        return "phg.CODE, phg.CODE.INDEX or phg.CODE.KINEMATIC.AXIS is expected, e.g. phg.33282.1.2"
    except (VariableError, ValueError) as fault:
        return str(fault)
    return ""


def controller(check: Context) -> None:
    """Everything that makes the control refuse to start."""
    table = check.cell.controller
    if table is None:
        return
    if table.files and not (pathlib.Path(check.cell.file).parent / table.files).is_dir():
        check.fault("controller.files", table.files, "no such folder (looked for in the folder of the cell file)")
    if table.process and not CONTROLLERS[table.kind].parameters:
        check.fault("controller.process", table.process[0].name, 'processes belong to kind = "rho3"')
    _codes(check, table)
    if table.point and not CONTROLLERS[table.kind].points:
        check.fault("controller.point", table.point[0].name, 'points belong to kind = "val3"')
    if table.command_source and table.command_source not in (check.known["line"] - program_lines(check.cell)) | check.known["modbus"]:
        check.fault("controller.command_source", table.command_source, "no such command source")
    _stations(check, table)
    _memory(check, table)
    _passing(check)
    _plc(check, table)
    _pic(check, table)
    sound = [_process(check, table, index) for index in range(len(table.process))]
    sound += [_point(check, table, point) for point in table.point]
    if CONTROLLERS[table.kind].markers:
        _overlap(check, table)
    if not all(sound):
        return
    try:
        trial(check.cell)
    except ValueError as error:
        check.fault("controller" if check.cell.rho3 is None else "rho3", table.kind, str(error))


def _codes(check: Context, table: Controller) -> None:
    """Each code word leads to one access level."""
    given = [*table.code_words, *([table.pin] if table.pin else [])]
    if given and not CONTROLLERS[table.kind].codes:
        check.fault("controller.code_words" if table.code_words else "controller.pin", given[0], 'code words belong to kind = "reis"')
    if "" in table.code_words:
        check.fault("controller.code_words", "", "a code word has at least one letter or digit; omit it to have none")
    if len({word.upper() for word in given}) < len(given):
        check.fault("controller.code_words", given[-1], "two access levels have the same code; upper and lower case are the same")


def _stations(check: Context, table: Controller) -> None:
    """Frames of a Reis' programs."""
    numbers = [station.number for station in table.station]
    if numbers and not CONTROLLERS[table.kind].markers:
        check.fault("controller.station", str(numbers[0]), 'stations belong to kind = "reis"')
    for double in sorted({each for each in numbers if numbers.count(each) > 1}):
        check.fault("controller.station", str(double), "two stations have this number")


def _eeprom(check: Context, table: Controller) -> None:
    """The files of modes 9.4.2 and 9.6 to 9.8 (AX-1041, AX-1755, AX-1756)."""
    for key, file in (("eeprom", table.eeprom), ("printer", table.printer), ("sram_card", table.sram_card)):
        path = pathlib.Path(check.cell.file).parent / file
        if file and (not table.memory or not CONTROLLERS[table.kind].parameters):
            check.fault(f"controller.{key}", file, "it keeps the memory of a rho3; [controller] has none")
        elif file and (path.is_dir() or not path.parent.is_dir()):
            check.fault(
                f"controller.{key}", file, "no such folder (looked for in the folder of the cell file)", "the folder of the file must exist"
            )


def _memory(check: Context, table: Controller) -> None:
    """The programs of the interpreter (AX-860)."""
    _eeprom(check, table)
    if table.phg_unit and any(unit.device == table.phg_unit for line in check.cell.line for unit in line.program):
        check.fault("controller.phg_unit", table.phg_unit, "this unit is on a line of the cell")
    folder = memory_folder(check.cell)
    if folder is None:
        return
    if not CONTROLLERS[table.kind].memory:
        kinds = " and ".join(f'kind = "{row.name}"' for row in CONTROLLERS.values() if row.memory)
        check.fault("controller.memory", table.memory, f"programs belong to {kinds}")
    elif not folder.is_dir():
        check.fault("controller.memory", table.memory, "no such folder (looked for in the folder of the cell file)")
    elif not check.cell.robot or not all(robot.model for robot in check.cell.robot):
        check.fault("controller.memory", table.memory, "programs need the kinematics of a [robot] with a model")
    elif CONTROLLERS[table.kind].parameters and table.kinematics < len(check.cell.robot):
        count = len(check.cell.robot)
        check.fault("controller.kinematics", str(table.kinematics), f"programs move the {count} robots of the cell", f"{count}..10")
    elif CONTROLLERS[table.kind].markers:
        from gateway.checks.applications.robotstar import unreadable

        if why := unreadable(folder):
            check.fault("controller.memory", table.memory, why)
    else:
        programs = {path.stem.upper() for path in folder.iterdir() if path.suffix.upper() == ".QLL"}
        for process in table.process:
            if process.name.upper() in programs:
                check.fault(f"controller.process.{process.name}", process.name, f"{table.memory} has a program of this name")


def _passing(check: Context) -> None:
    """P212 to P214: a radius or distance below 0, a factor out of its range."""
    others = check.cell.rho3.others if check.cell.rho3 else {}
    if not {"P212", "P213", "P214"} & others.keys():
        return
    from gateway.assembly.interpreter import presets_of
    from motion.errors import MotionError

    try:
        presets_of(check.cell)
    except MotionError as error:
        check.fault(f"rho3.{str(error).split()[0]}", others.get(str(error).split()[0], ""), str(error))


def _plc(check: Context, table: Controller) -> None:
    """The integrated PLC (AX-900): its folder and its start program."""
    folder = plc_folder(check.cell)
    if table.plc is None or folder is None:
        return
    key = "controller.plc"
    if not CONTROLLERS[table.kind].plc:
        check.fault(key, table.plc.start, 'the integrated PLC belongs to kind = "reis"')
        return
    from gateway.files.plc_programs import ProgramFileFault, read_programs
    from gateway.pure.languages.plc.translation import key_of

    try:
        programs = read_programs(folder)
    except (ProgramFileFault, OSError) as error:
        check.fault(f"{key}.path", table.plc.path, f"{error} (looked for in the folder of the cell file)")
        return
    if key_of(table.plc.start) not in {key_of(name) for name in programs}:
        check.fault(f"{key}.start", table.plc.start, f"no such program; {table.plc.path} has {', '.join(sorted(programs)) or 'none'}")


def _pic(check: Context, table: Controller) -> None:
    """The PIC program (AX-981): it can be scanned, and writes only bytes of its own."""
    folder = memory_folder(check.cell)
    if not table.pic:
        return
    if not CONTROLLERS[table.kind].parameters:
        check.fault("controller.pic", table.pic, 'a PIC belongs to kind = "rho3"')
        return
    if folder is None or not folder.is_dir():
        check.fault("controller.pic", table.pic, f'memory = "FOLDER" with {table.pic}.QLS is needed')
        return
    from gateway.files.program_memory import folder_memory
    from gateway.pure.languages.base.faults import Faults
    from gateway.pure.languages.pic.cell_pic import read_pic
    from gateway.pure.languages.pic.symbols import named_in

    memory, faults, name = folder_memory(folder), Faults(), table.pic.upper()
    if memory.text(f"{name}.QLS") is None:
        check.fault("controller.pic", table.pic, f"{table.memory} has no {name}.QLS")
        return
    program = read_pic(memory, name, named_in(signals_of(check.cell)), faults)
    first = next(iter(faults), None)
    if program is None or first is not None:
        check.fault("controller.pic", table.pic, f"{faults.errors} errors: axisgate program check names them; the first: {first}")
        return
    own = pic_bytes(check.cell)
    for byte, place in sorted(program.outputs.items()):
        if byte not in own:
            owner, entry = check.cell.rc_inputs.owner.get(byte), f'"{byte}" = "pic"'
            where, what = "controller.pic", f"O{byte} in {place}"
            if owner:
                check.fault(where, what, f"it is the byte of {owner}; give it to the PIC: {entry} in [rc_inputs] owner")
            else:
                check.fault(where, what, f"it has no owner; give it to the PIC: {entry} in [rc_inputs] owner")


def _process(check: Context, table: Controller, index: int) -> bool:
    process = table.process[index]
    before = len(check.faults)
    key = f"controller.process.{process.name}"
    if any(each.name.upper() == process.name.upper() for each in table.process[:index]):
        check.fault(key, process.name, "two processes of one name")
    if any(kinematic > table.kinematics for kinematic in process.kinematics):
        check.fault(key, str(list(process.kinematics)), f"kinematics = {table.kinematics}", f"1..{table.kinematics}")
    for count, step in enumerate(process.steps):
        _step(check, f"{key}.steps[{count}]", step)
    return len(check.faults) == before


def inputs(cell: Cell) -> Iterator[Notice]:
    """Channels that would end their program: P11 does not have them."""
    table = cell.controller
    if table is None or not table.process:
        return
    from gateway.pure.controllers.rho3.signals.control import RhoControl
    from gateway.pure.controllers.rho3.signals.fast_io import InputFault

    control = trial(cell)
    if not isinstance(control, RhoControl):
        return
    for process in table.process:
        for count, step in enumerate(process.steps):
            if step.input is None:
                continue
            try:
                control.channels.read(step.input)
            except InputFault as fault:
                yield Notice("warning", f"controller.process.{process.name}.steps[{count}]", f"{fault}: it is not in P11")


def _step(check: Context, key: str, step: ProcessStep) -> None:
    given = [name for name in STEP_KEYS if getattr(step, name) not in ({}, None)]
    if len(given) != 1:
        check.fault(key, ", ".join(given), f"exactly one of {', '.join(STEP_KEYS)}")
    if step.program is not None and step.program not in {each.number for each in check.cell.program}:
        check.fault(key, step.program, "no [[program]] of that number")
    axes = {axis.name: axis for axis in check.cell.axis}
    for name, target in step.to.items():
        if check.unknown(key, name, "axis") or name not in axes:
            continue
        limits = axes[name].limits
        if not limits.min <= target <= limits.max:
            check.fault(key, f"{name} = {number(target)}", "", f"{number(limits.min)}..{number(limits.max)}", axes[name].unit)


def _point(check: Context, table: Controller, point: ControllerPoint) -> bool:
    key, before = f"controller.point.{point.name}", len(check.faults)
    if sum(each.name == point.name for each in table.point) > 1:
        check.fault(key, point.name, "two points of one name")
    if (point.bit is None) is (point.byte is None) or (point.byte is None) is not (point.steps == 0):
        check.fault(key, point.name, "a digital point has bit = N, an analog one byte = N and steps = the number of steps per unit")
    elif point.steps and (point.min >= point.max or max(abs(point.min), abs(point.max)) * point.steps > 32767):
        check.fault(key, f"{number(point.min)}..{number(point.max)}", "min below max, and both times steps within 16 bits")
    return len(check.faults) == before


def _overlap(check: Context, table: Controller) -> None:
    """AX-515: CAN I/O blocks of the rho 3 may not share the bytes."""
    own = set(range(table.first_byte, table.first_byte + 40))
    rho3 = check.cell.rho3
    for block in (*rho3.P31, *rho3.P32) if rho3 else ():
        shared = own & set(range(block.start, block.start + block.length))
        if shared:
            check.fault("controller.first_byte", table.first_byte, f"CAN I/O block {block.id} is in byte {min(shared)} (AX-515)")


def plc_programs(cell: Cell) -> Iterator[Notice]:
    """Faults with which the integrated PLC refuses its start."""
    folder, table = plc_folder(cell), cell.controller
    if folder is None or table is None or table.plc is None:
        return
    from gateway.files.plc_programs import ProgramFileFault, read_programs
    from gateway.pure.languages.plc.plc import Plc

    try:
        refused = Plc(read_programs(folder)).start(table.plc.start)
    except (ProgramFileFault, OSError):
        return  # refused by `controller`
    for message in refused:
        place = f"{message.program} step {message.step}: " if message.program else ""
        yield Notice("warning", f"{table.plc.path}/{table.plc.start}", f"{place}{message.text}; the PLC does not start")


def files(cell: Cell) -> Iterator[Notice]:
    """Lines the DAT files lose, and undeclared programs."""
    table = cell.controller
    if table is None or not CONTROLLERS[table.kind].parameters:
        return
    from gateway.assembly.controllers import dat_tables

    tables = dat_tables(cell, table)
    for fault in tables.faults:
        yield Notice("warning", f"{table.files}/{fault.file}", f"line {fault.line}: {fault.why.text(cell.cell.language)}; not used")
    known = {process.name.upper() for process in table.process}
    folder = memory_folder(cell)
    if folder is not None and folder.is_dir():
        from gateway.files.program_memory import baps2_words, folder_memory
        from gateway.pure.languages.baps2.library import Library

        library = Library(baps2_words(), folder_memory(folder))
        known |= set(library.names())
        for name in sorted(library.names()):
            if found := library.unit(name)[1].errors:
                yield Notice(
                    "warning",
                    f"{table.memory}/{name}.QLL",
                    f"{found} error{'s' * (found > 1)}, it does not run: axisgate program check names them",
                )
    for code, name in sorted((tables.programs.entries if tables.programs else {}).items()):
        if name not in known:
            undeclared = "which no [[controller.process]] declares" if folder is None else "which is not a program of the memory"
            yield Notice("note", f"{table.files}/EXPROG.DAT", f"code {code:02X} selects {name}, {undeclared}")


def robotstar_programs(cell: Cell) -> Iterator[Notice]:
    """Programs of a Reis with errors."""
    table, folder = cell.controller, memory_folder(cell)
    if table is not None and folder is not None and CONTROLLERS[table.kind].markers:
        from gateway.checks.applications.robotstar import programs_with_errors

        yield from programs_with_errors(folder, table.memory)


CHECKS = (controller,)
NOTES = (files, inputs, plc_programs, robotstar_programs)
