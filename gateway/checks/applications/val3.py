"""Cross checks of [val3]: the application with its files and programs, its arm, the links of its data (AX-930)."""

from collections.abc import Iterator

from gateway.assembly.controllers import points_of
from gateway.assembly.program_memory import disk_folder
from gateway.assembly.programs import machines_of_cell
from gateway.assembly.val3_application import application_place, channel_of, setup_of
from gateway.checks.context import Context
from gateway.files.val3_disk import DiskUnreadable, read_disk
from gateway.pure.cell.cell import Cell, Notice
from gateway.pure.cell.val3 import Val3
from gateway.pure.controllers.val3.sio.channel import channel_named
from gateway.pure.languages.val3.cell_io import found
from gateway.pure.languages.val3.links import links_of_files
from gateway.pure.languages.val3.loader import Loaded, Loader, family_of_arm
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.values import SioV
from gateway.pure.languages.val3.virtual import links_of, values_of
from gateway.registry import CONTROLLERS
from motion.errors import MotionError

MOST = 20  # faults of programs that are listed
FAMILY = "val3-family"


def application(check: Context) -> None:
    """All that keeps the application from its start."""
    cell, table = check.cell, check.cell.val3
    if table is None:
        return
    if cell.controller is None or not CONTROLLERS[cell.controller.kind].points:
        check.fault("val3", table.application, 'an application needs [controller] with kind = "val3", whose points dio and aio link to')
        return
    if len(cell.robot) != 1:
        check.fault("val3", table.application, f"an application needs a cell of one [robot], this one has {len(cell.robot) or 'none'}")
        return
    _channels(check, table)
    _data(check, table)
    try:
        machines_of_cell(cell)
    except MotionError as error:
        check.fault("val3", table.application, str(error))
        return
    try:
        loaded = _loaded(cell, table)
    except DiskUnreadable as error:
        check.fault("val3.application", table.application, str(error))
        return
    _programs(check, table, loaded)


def _channels(check: Context, table: Val3) -> None:
    for index, row in enumerate(table.channel):
        for fault in channel_of(row).faults():
            check.fault(f"val3.channel.{row.name}", row.kind, fault)
        if any(other.name == row.name for other in table.channel[:index]):
            check.fault(f"val3.channel.{row.name}", row.name, "two channels of one name")


def _data(check: Context, table: Val3) -> None:
    """Boards, brakes, profiles and references are those of this cell."""
    assert check.cell.controller is not None
    known = sorted({point.board.name.lower() for point in points_of(check.cell.controller)})
    for board in table.board:
        if board.name.lower() not in known:
            check.fault(f"val3.board.{board.name}", board.name, f"no [[controller.point]] is on this board; there are {', '.join(known)}")
    axes = _axes(check.cell)
    for key, values in (("service.brakes", table.service.brakes), ("service.brake_position", table.service.brake_position)):
        if values and len(values) != axes:
            check.fault(f"val3.{key}", str(len(values)), f"one value for each of {axes} axes of the robot is expected")
    for row in table.reference:
        if len(row.joints) != axes:
            check.fault(f"val3.reference.{row.name}", str(len(row.joints)), f"one value for each of {axes} axes of the robot is expected")
    names = {"default", "staubli", *(row.name for row in table.profile)}
    if table.current_profile not in names:
        check.fault(
            "val3.current_profile", table.current_profile, f"no [[val3.profile]] has this name; there are {', '.join(sorted(names))}"
        )


def _axes(cell: Cell) -> int:
    """Axes of the one robot; 0 where it cannot be made."""
    try:
        return machines_of_cell(cell)[0].axes
    except MotionError:
        return 0


def _loaded(cell: Cell, table: Val3) -> Loaded:
    """DiskUnreadable."""
    folder, name = application_place(cell, table)
    axes = machines_of_cell(cell)[0].axes
    disk = read_disk(disk_folder(cell, table))
    loaded = Loader(disk, axes, family=family_of_arm(axes), strict=table.strict_priorities).load(folder, name)
    if loaded is None:
        raise DiskUnreadable(f"{name}.pjx cannot be read")
    return loaded


def _programs(check: Context, table: Val3, loaded: Loaded) -> None:
    wrong = [fault for fault in loaded.faults if fault.severity.value == "error" or (fault.id == FAMILY and _of_another_arm(loaded))]
    for fault in wrong[:MOST]:
        check.fault("val3.application", table.application, loaded.logged(fault))
    if len(wrong) > MOST:
        check.fault("val3.application", table.application, f"{len(wrong) - MOST} more: axisgate val3 check names them")
    missing = [name for name in ("start", "stop") if name not in loaded.app.programs]
    if missing:
        what = f"{loaded.app.name} has no {' and no '.join(f'{name}()' for name in missing)}: it serves as a library only"
        check.fault("val3.application", table.application, what)
    if not wrong and not missing:
        _links(check, table)
    elif wrong:
        _links_of_its_files(check, table, loaded)


def _links_of_its_files(check: Context, table: Val3, loaded: Loaded) -> None:
    """The same for an application that cannot be loaded yet: one run names all its faults."""
    assert check.cell.controller is not None
    points, channels, name = points_of(check.cell.controller), [channel_of(row) for row in table.channel], loaded.app.name
    ends, sockets = links_of_files([loaded.app])
    for variable, path in dict.fromkeys((end.variable, end.path) for end in ends):
        if found(points, path) is None:
            check.fault("controller.point", path, f"{name}, {variable}: no [[controller.point]] is {path}")
    for path in sockets:
        if channel_named(channels, path) is None:
            check.fault("val3.channel", path, f"{name}: no [[val3.channel]] is {path}")


def _of_another_arm(loaded: Loaded) -> bool:
    """Nothing of its data that names a family of arms is for this one."""
    families = {declared.family for declared in loaded.app.data.values() if declared.family}
    wrong = sum(fault.id == FAMILY for fault in loaded.faults)
    return wrong > 0 and len(families) == 1


def _links(check: Context, table: Val3) -> None:
    """Data of the application and its libraries that are linked to names missing in this cell."""
    cell = check.cell
    assert cell.controller is not None
    points, channels = points_of(cell.controller), [channel_of(row) for row in table.channel]
    setup = setup_of(cell, table)
    machine = Machine(read_disk(disk_folder(cell, table)), Moves(setup.robot), strict=setup.strict)
    machine.instance(setup.folder, setup.name, "")
    for instance in machine.shared.values():
        for name, container in instance.data.items():
            for value in values_of(container):
                for link in links_of(value):
                    if found(points, link) is None:
                        check.fault("controller.point", link, f"{instance.loaded.app.name}, {name}: no [[controller.point]] is {link}")
                if isinstance(value, SioV) and value.link and channel_named(channels, value.link) is None:
                    what = f"{instance.loaded.app.name}, {name}: no [[val3.channel]] is {value.link}"
                    check.fault("val3.channel", value.link, what)


def warnings(cell: Cell) -> Iterator[Notice]:
    """Warnings of the application."""
    if cell.val3 is None:
        return
    try:
        loaded = _loaded(cell, cell.val3)
    except (DiskUnreadable, MotionError):
        return  # refused by `application`
    another = _of_another_arm(loaded)
    for fault in loaded.faults:
        if fault.severity.value == "warning" and not (another and fault.id == FAMILY):
            yield Notice("warning", "val3.application", loaded.logged(fault))
