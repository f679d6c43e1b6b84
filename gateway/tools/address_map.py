"""`axisgate map`: addresses at the command sources of a cell, made from the cell itself, so that table and running gateway
cannot differ."""

from collections.abc import Callable, Iterator, Sequence

from gateway.assembly.routes import routed_values
from gateway.files.find import read_signals
from gateway.pure.arbitration.command_block import COMMAND_WORDS, STATUS_WORDS
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.modbus import Modbus, ModbusValue
from gateway.pure.image.addresses import AddressFault, Direction, RcBit, cl300, pic, rc
from gateway.pure.image.records.cell import RC_BYTES
from gateway.pure.image.signals import Signal, SignalList, from_tables
from gateway.pure.modbus.rho3_view import BLOCK_AT, ERRORS_AT, RC_WORDS
from gateway.pure.reports.tables import Cell as Field
from gateway.pure.reports.tables import Sheet
from gateway.registry import MODBUS_VIEWS
from gateway.services.sources.modbus import placed
from gateway.tools.address_map_views import reference

COMMAND_HEAD = ("bit 15 toggle, bits 0-7 code", "axis mask", "velocity, 0.01 %", "acceleration, 0.01 %")
STATUS_HEAD = (
    *("bit 15 acknowledged toggle, bits 0-7 state", "reason", "mask: enabled", "mask: in position", "mask: referenced", "mask: fault"),
    *("override, 0.01 %", "life counter", "owner of the control", "reserved"),
)
MODBUS_COLUMNS = ("table", "address (base 0)", "reference (base 1)", "words or bits", "type", "access", "value", "text")


def signals_of(cell: Cell) -> SignalList:
    """The numbered signals as this cell has them, for the axes it has."""
    named = from_tables(read_signals(), {"axis": max(len(cell.axis), 1)})
    return named.moved({name: bit for name, bit in cell.signals.items() if named.named(name) is not None})


# --------------------------------------------------------------------------------------------------------------- Modbus


def modbus_sheets(cell: Cell) -> list[Sheet]:
    """One table for each unit of each server and for each client."""
    sheets = []
    for server in cell.modbus:
        if server.role == "client":
            sheets.append(_client(server, routed_values(cell).get(server.name, ())))
            continue
        where = server.port_ or server.bind
        for unit, view in ((server.unit, server.view), *((each.unit, each.view) for each in server.units)):
            rows = tuple(_server_rows(cell, server, view))
            title = f"Modbus server {server.name}, unit {unit}, {where}"
            sheets.append(Sheet(title, MODBUS_COLUMNS, rows, _note(cell, server, view)))
    return sheets


def _note(cell: Cell, server: Modbus, view: str) -> str:
    writers = ", ".join((*server.allow, *(writer.from_ for writer in server.writers)))
    roles = ", ".join(role.role for role in server.roles if role.write)
    who = f"written from {writers} only" if writers else f"written by {roles} only" if roles else "writable by every client"
    files = ", ".join(str(block.number) for block in cell.db if block.writer == server.name)
    also = f"; FC 7: RC outputs 64..71; FC 20: file N is DB N; {f'FC 21: files {files}; ' if files else ''}"
    also = f"{also}FC 24 at {ERRORS_AT}: numbers of the pending errors" if MODBUS_VIEWS[view].signals else ""
    return f"REAL and other wide values {server.float}; {who}{also}"


def _server_rows(cell: Cell, server: Modbus, view: str) -> Iterator[tuple[Field, ...]]:
    row = MODBUS_VIEWS[view]
    if row.signals:
        yield from _signal_rows(cell, server)
        if server.command_block:
            yield from _block_rows(cell)
    elif row.rows is not None:
        yield from row.rows(cell, server)
    for each in placed(server, [axis.name for axis in cell.axis]):
        for table in ("holding register", "input register"):
            yield (table, each.at, reference(table, each.at), each.words, each.type, "R", each.name, "")


def _signal_rows(cell: Cell, server: Modbus) -> Iterator[tuple[Field, ...]]:
    """Each named signal as a bit, each PIC byte pair as a register."""
    known, language = signals_of(cell), cell.cell.language
    owned = {octet for octet, owner in cell.rc_inputs.owner.items() if owner == server.name}
    for table, direction in (("coil", Direction.INPUT), ("discrete input", Direction.OUTPUT)):
        for number in range(8 * RC_BYTES):
            signal = known.at(RcBit(direction, number))
            if signal is not None:
                access = "R/W" if direction is Direction.INPUT and number // 8 in owned else "R"
                yield (table, number, reference(table, number), 1, "bit", access, signal.name, signal.text(language))
    for table, letter in (("holding register", "I"), ("input register", "O")):
        for word in range(RC_WORDS):
            mine = table == "holding register" and {2 * word, 2 * word + 1} <= owned
            value = f"{letter}{2 * word}, {letter}{2 * word + 1}"
            yield (table, word, reference(table, word), 1, "UINT16", "R/W" if mine else "R", value, "first byte high (AX-010)")


def _block_rows(cell: Cell) -> Iterator[tuple[Field, ...]]:
    """AX-011."""

    def row(table: str, word: int, size: int, type_: str, value: str) -> tuple[Field, ...]:
        access = "R/W" if table == "holding register" else "R"
        return (table, BLOCK_AT + word, reference(table, BLOCK_AT + word), size, type_, access, value, "")

    for word, value in enumerate(COMMAND_HEAD):
        yield row("holding register", word, 1, "UINT16", f"command W{word}: {value}")
    for n, word in enumerate(range(len(COMMAND_HEAD), COMMAND_WORDS, 2)):
        if n < len(cell.axis):
            yield row("holding register", word, 2, "REAL", f"command: target {cell.axis[n].name}, {cell.axis[n].unit}")
    for word, value in enumerate(STATUS_HEAD):
        yield row("input register", word, 1, "UINT16", f"status W{word}: {value}")
    for n, word in enumerate(range(len(STATUS_HEAD), STATUS_WORDS, 4)):
        if n < len(cell.axis):
            axis = cell.axis[n]
            yield row("input register", word, 2, "REAL", f"status: actual {axis.name}, {axis.unit}")
            yield row("input register", word + 2, 2, "REAL", f"status: lag {axis.name}, {axis.unit}")


def _client(client: Modbus, routed: Sequence[ModbusValue]) -> Sheet:
    tables = {"coil": "coil", "discrete": "discrete input", "input": "input register", "holding": "holding register"}
    rows = tuple(
        (each.device, tables[each.table], each.at, reference(tables[each.table], each.at), each.type, each.to, each.from_, each.every_ms)
        for each in (*client.value, *routed)
    )
    columns = ("device", "table", "address (base 0)", "reference (base 1)", "type", "read into", "written from", "every ms")
    units = ", ".join(f"{device.name} = unit {device.unit} {device.order}" for device in client.device)
    return Sheet(f"Modbus client {client.name}, {client.port_}", columns, rows, units)


# ------------------------------------------------------------------------------------------------- blocks, signals, wiring


def db_sheets(cell: Cell) -> list[Sheet]:
    """One table for each data block."""
    columns = ("at", "type", "unit", "way", "value", "min", "max", "edge", "comment")
    sheets = []
    for db in cell.db:
        rows = tuple(
            (e.at, e.type, e.unit, "PLC -> axisgate" if e.to else "axisgate -> PLC", e.signal, e.min, e.max, e.edge, e.comment)
            for e in db.entries
        )
        title = f"{'DX' if db.kind == 'X' else 'DB' if db.kind == 'D' else db.kind} {db.number}, line {db.line}, {db.words} words"
        sheets.append(Sheet(title, columns, rows, f"written by {db.writer}. {db.comment}".strip()))
    return sheets


def signal_sheets(cell: Cell) -> list[Sheet]:
    """All numbered signals by their four addresses."""
    columns = ("signal", "number", "PIC", "CL300", "RC", "text", "number from", "command source")
    sheets = []
    for direction, title in ((Direction.INPUT, "RC inputs (PLC -> control)"), (Direction.OUTPUT, "RC outputs (control -> PLC)")):
        found = sorted((s for s in signals_of(cell).all if s.at.direction is direction and not s.until), key=lambda s: s.at.number)
        sheets.append(Sheet(title, columns, tuple(_signal(cell, signal) for signal in found)))
    return sheets


def _signal(cell: Cell, signal: Signal) -> tuple[Field, ...]:
    def address(way: Callable[[RcBit], str]) -> str:
        try:
            return way(signal.at)
        except AddressFault:
            return ""  # this world does not reach it

    owner = cell.rc_inputs.owner.get(signal.at.number // 8, "") if signal.at.direction is Direction.INPUT else ""
    source = signal.source if signal.source != "axisgate" else "axisgate (AX-002)"
    return (signal.name, signal.at.number, address(pic), address(cl300), address(rc), signal.text(cell.cell.language), source, owner)


def wiring_sheets(cell: Cell) -> list[Sheet]:
    """Connections to wire, and hardware functions that the plant guarantees."""
    columns = ("from", "to", "how", "carries")
    rows: list[tuple[Field, ...]] = [
        (f"line {line.name}", line.port, f"{line.format} {line.wiring}".strip(), f"{line.protocol} {line.layer}, priority {line.priority}")
        for line in cell.line
    ]
    for modbus in cell.modbus:
        how = modbus.format if modbus.serial else "TLS, certificates on both sides" if modbus.tls else "Ethernet"
        rows.append(
            (
                f"Modbus {modbus.role} {modbus.name}",
                modbus.port_ or modbus.bind,
                how,
                f"Modbus {modbus.framing.upper()}, unit {modbus.unit}",
            )
        )
    rows += [(f"bus {bus.name}", bus.port, f"{bus.bitrate}, 120 ohm at both ends", bus.protocol) for bus in cell.bus]
    rows += [
        (f"axis {axis.name}", f"bus {axis.drive.bus}", f"address {axis.drive.node or axis.drive.module}", axis.drive.type)
        for axis in cell.axis
    ]
    for io in cell.io:
        device = io.device
        place = " ".join(str(part) for part in (device.bus, device.url, device.chip, device.node) if part)
        channel = f"input {device.input}" if device.input is not None else f"output {device.output}"
        rows.append((f"contact {io.name}", f"{device.type} {place}", channel, io.signal))
    sheets = [Sheet("Connections", columns, tuple(rows))]
    if cell.safety is not None:
        guarantees = tuple((name, str(getattr(cell.safety, name) or "")) for name in type(cell.safety).__dataclass_fields__)
        sheets.append(Sheet("Guaranteed by the plant, in hardware that works without axisgate", ("what", "how"), guarantees))
    return sheets


SHEETS: dict[str, Callable[[Cell], list[Sheet]]] = {
    "modbus": modbus_sheets,
    "db": db_sheets,
    "signals": signal_sheets,
    "wiring": wiring_sheets,
}
