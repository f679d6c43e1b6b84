"""[val3] of a cell: where its application is, its channels (AX-930)."""

import datetime
import math
import time

from gateway.assembly.controllers import points_of
from gateway.assembly.limits import limits_of
from gateway.assembly.program_memory import disk_folder
from gateway.assembly.programs import machines_of_cell, mask_of
from gateway.files.find import beside
from gateway.files.robots import load_robot
from gateway.files.val3_disk import place_of
from gateway.files.val3_texts import val3_language, val3_texts
from gateway.pure.cell.cell import Axis, Cell
from gateway.pure.cell.val3 import MODES, Val3, Val3Channel, Val3UserIo
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.languages.val3.boards import UserBoards, user_boards
from gateway.pure.languages.val3.cell_alter import AlterPlace
from gateway.pure.languages.val3.cell_run import Setup
from gateway.pure.languages.val3.dates import START
from gateway.pure.languages.val3.robot_state import NO_DATA, Service
from motion.geometry.units import to_si
from motion.robot import with_limits

KINDS = {"serial": Kind.SERIAL, "client": Kind.TCP_CLIENT, "server": Kind.TCP_SERVER, "udp": Kind.UDP}


def application_place(cell: Cell, table: Val3) -> tuple[str, str]:
    """Folder of the application on its disk, and its name.  DiskUnreadable: one sentence."""
    disk = disk_folder(cell, table)
    _, folder, name = place_of(disk / table.application, disk)
    return folder, name


def channel_of(row: Val3Channel) -> Channel:
    """A channel as the sio core has it."""
    address = "" if row.kind == "serial" else row.address
    device = row.address if row.kind == "serial" else ""
    return Channel(
        row.name, KINDS[row.kind], row.description, address or "0.0.0.0", row.port, row.bind, row.clients, row.end_of_string, row.timeout_s,
        row.nagle, device, row.baud_rate, row.parity, row.bits, row.stop_bits, flow_control=row.flow_control,
    )  # fmt: skip


def alter_place(cell: Cell) -> AlterPlace | None:
    """Where its correction and the answer are in the image; None: the option is not there."""
    table = cell.alter
    if table is None or table.source != "application" or table.status is None:
        return None
    return AlterPlace(table.input >> 3, table.status >> 3)


def boards_of(table: Val3) -> UserBoards | None:
    """None: inputs and outputs act at once."""
    if table.user_io is None and not table.board:
        return None
    refresh = table.user_io or Val3UserIo()
    return user_boards(refresh.mode, max(refresh.ratio, 1), {board.name: board.refresh_us for board in table.board})


def service_of(table: Val3) -> Service:
    """No brakes of a cell are tested automatically: without data brakeTest returns -14."""
    given = table.service
    return Service(given.brakes or (NO_DATA,), given.brake_position, given.hibernate, given.wake)


def rated_force(axis: Axis) -> float:
    """Force or torque of the joint at the rated torque of its motor, Nm or N; 0 if unknown."""
    mechanics = axis.mechanics
    way = to_si(mechanics.feed_per_turn, axis.unit) / (2.0 * math.pi)  # rad or m of the axis per rad after the gear
    return (axis.drive.rated_torque or 0.0) * mechanics.ratio / (way if mechanics.direction == "+" else -way)


def setup_of(cell: Cell, table: Val3) -> Setup:
    """All that the interpreter needs; MotionError, DiskUnreadable: `check` has refused it before."""
    folder, name = application_place(cell, table)
    (machine,) = machines_of_cell(cell)
    axes = cell.axis[: machine.axes]
    written = load_robot(str(beside(cell.file, cell.robot[0].model, "robots")))
    largest = tuple(axis.following_error.trip if axis.following_error is not None else 1.0 for axis in axes)
    since = datetime.datetime.now() - START
    epoch = time.monotonic_ns() - since // datetime.timedelta(microseconds=1) * 1000
    return Setup(
        folder, name, with_limits(written, [limits_of(axis) for axis in axes]), machine, mask_of(cell, machine), largest,
        tuple(points_of(cell.controller)) if cell.controller is not None else (), MODES.index(table.mode) + 1, table.system,
        table.strict_priorities, table.auto_connect, epoch, round(table.watchdog_s * 1e9), table.prompts == "page",
        alter_place(cell), boards_of(table), service_of(table), table.current_profile, {each.name: each.password for each in table.profile},
        {each.name: each.joints for each in table.reference}, {each.name: each.text for each in table.licence}, table.options,
        tuple(map(rated_force, axes)), val3_language(cell.cell.language), val3_texts(),
    )  # fmt: skip
