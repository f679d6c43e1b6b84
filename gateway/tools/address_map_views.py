"""Rows of `axisgate map --modbus` for the views of a Reis and of a VAL 3 controller (AX-408)."""

from collections.abc import Collection, Iterator

from gateway.pure.cell.cell import Cell
from gateway.pure.cell.controller import Controller, ControllerPoint
from gateway.pure.cell.modbus import Modbus
from gateway.pure.controllers.reis.binary import BYTES
from gateway.pure.controllers.reis.markers import INPUTS, OUTPUTS, SIZE, SYSTEM
from gateway.pure.modbus.other_views import MARKER_BITS_AT, STATES_AT
from gateway.pure.modbus.rho3_view import FLAGS_AT
from gateway.pure.reports.tables import Cell as Field

Row = tuple[Field, ...]
REFERENCES = {"coil": 1, "discrete input": 10001, "input register": 30001, "holding register": 40001}


def reference(table: str, address: int) -> str:
    """As manuals count: 40001; six digits beyond 9999, where five do not reach."""
    first = REFERENCES[table]
    return f"{first + address:05d}" if address < 9999 else f"{first // 10000}{address + 1:05d}"


def owned_by(cell: Cell, server: Modbus) -> set[int]:
    """RC input bytes this command source may write."""
    return {octet for octet, owner in cell.rc_inputs.owner.items() if owner == server.name}


def reis_rows(cell: Cell, server: Modbus) -> Iterator[Row]:
    """Inputs and outputs bit by bit and in words, markers in words; system markers by their bits."""
    controller, owned = cell.controller or Controller(), owned_by(cell, server)
    first, robot_only = controller.first_byte, controller.robot_only
    for table, letter in (("coil", "E"), ("discrete input", "A")):
        for bit in range(8 * BYTES):
            mine = letter == "E" and first + bit // 8 in owned
            yield (table, bit, reference(table, bit), 1, "bit", "R/W" if mine else "R", f"{letter} {bit // 8}.{bit % 8}", "")
    for table, letter in (("holding register", "E"), ("input register", "A")):
        for word in range(BYTES // 2):
            mine = letter == "E" and {first + 2 * word, first + 2 * word + 1} <= owned
            value = f"{letter}B {2 * word}, {letter}B {2 * word + 1}"
            yield (table, word, reference(table, word), 1, "UINT16", "R/W" if mine else "R", value, "first byte high (AX-010)")
    for word in range(SIZE // 2):
        at, value = FLAGS_AT + word, f"MB {2 * word}, MB {2 * word + 1}"
        yield ("holding register", at, reference("holding register", at), 1, "UINT16", _access(word, robot_only), value, "")
        yield ("input register", at, reference("input register", at), 1, "UINT16", "R", value, "")
    for row in SYSTEM:
        if row.bit is not None:
            at = MARKER_BITS_AT + 8 * row.byte + row.bit
            yield ("discrete input", at, reference("discrete input", at), 1, "bit", "R", f"M {row.byte}.{row.bit}", row.writer)


def _access(word: int, robot_only: Collection[int]) -> str:
    """Words with a byte the robot alone writes are read; of mixed bytes the robot's bits stay."""
    robots = {byte for row in SYSTEM if row.writer == "robot" and row.bit is None for byte in range(row.byte, row.byte + row.bytes)}
    robots |= {OUTPUTS + byte for byte in robot_only}
    pair = {2 * word, 2 * word + 1}
    return "R" if pair & robots or any(INPUTS <= byte < OUTPUTS for byte in pair) else "R/W"


def val3_rows(cell: Cell, server: Modbus) -> Iterator[Row]:
    """Every point by its name, with board, module and address; its state."""
    points, owned = (cell.controller or Controller()).point, owned_by(cell, server)
    kinds: tuple[tuple[str, bool, bool], ...] = (
        ("coil", False, False), ("discrete input", True, False), ("holding register", False, True), ("input register", True, True),
    )  # fmt: skip
    for table, output, analog in kinds:
        for n, point in enumerate(each for each in points if each.output is output and bool(each.steps) is analog):
            at, size, form = (2 * n, 2, "REAL") if analog else (n, 1, "bit")
            access = "R/W" if not output and _bytes(point) <= owned else "R"
            yield (table, at, reference(table, at), size, form, access, point.name, f"{point.board}\\{point.module}\\{point.address}")
    for n, point in enumerate(points):
        at = STATES_AT + n
        yield ("input register", at, reference("input register", at), 1, "INT16", "R", f"{point.name}.status", "ioStatus")


def _bytes(point: ControllerPoint) -> set[int]:
    if point.steps:
        return {point.byte or 0, (point.byte or 0) + 1}
    return {(point.bit or 0) >> 3}
