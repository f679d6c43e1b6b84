"""Server for `axisgate var` and other tools: one JSON line each way on runtime_dir()/SLUG-services.sock.

get NAME|ADDRESS, set ADDRESS VALUE (only in a full simulation), names, status.
"""

import asyncio
import contextlib
import difflib
import json
import pathlib
from collections.abc import Callable, Sequence

from drivers.ports.base import runtime_dir
from gateway.assembly.data_block_signals import place_of
from gateway.pure.arbitration.block_keys import AREA_BYTES
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.web import PAGE_SOURCE
from gateway.pure.controllers.rho3.functions.system_variables import STOP_PROCESS, VariableError
from gateway.pure.controllers.rho3.pendant.catalogue import PREFIX, variable_of
from gateway.pure.image.addresses import (
    AddressFault,
    CellName,
    DataBit,
    DataWord,
    FlagBit,
    Operand,
    RcBit,
    Register,
    Table,
    parse_operand,
    pic,
)
from gateway.pure.image.addresses import Kind as OperandKind
from gateway.pure.image.addresses import Part as WordPart
from gateway.pure.image.names import Kind as NameKind
from gateway.pure.image.names import lookup
from gateway.pure.recording.messages import Source
from gateway.registry import CONTROLLERS, NO_PROGRAMS
from gateway.services.contacts import DigitalContacts
from gateway.services.controller_host import ControllerHost, Parameters
from gateway.services.page_interface import PageInterfaces
from gateway.services.part import Part
from gateway.services.part_context import PartContext
from gateway.services.plant_addresses import PlantAddresses, word_bytes
from gateway.services.tool_interface import TOOL_SOURCE
from protocols.base.errors import ProtocolError
from protocols.base.step5 import Step5Type, decode
from protocols.modbus.view import ExceptionCode, Kind

LONGEST = 4096
CLIENTS = 64  # connected at once; one more gets an answer and is sent away
NEVER_WRITTEN = "never written"  # value of a name that has none so far
MOST_ALIKE, ALIKE = 250, 3  # names compared with an unknown one; of more only those that share so many first characters
STOP = f"{PREFIX}{STOP_PROCESS}"  # is written and never read
ASKING = ("get", "names", "status", "axes", "job", "ticket", "alive")  # requests that change nothing
# of op "process", not while another tool has control
TESTING = ("start", "test", "breakpoints", "step", "movement", "variable", "teach", "define")
LOOKING = ("list", "show", "state", "status", "look", "outcome")  # of op "process" and "plc"
_KINDS = {
    Table.COIL: Kind.COILS,
    Table.DISCRETE: Kind.DISCRETE_INPUTS,
    Table.INPUT: Kind.INPUT_REGISTERS,
    Table.HOLDING: Kind.HOLDING_REGISTERS,
}


class Variables(Part):
    """Answers one request a line; a bad one gets {"error": ...}."""

    def __init__(
        self,
        context: PartContext,
        tools: PageInterfaces,
        contacts: DigitalContacts,
        host: ControllerHost,
        addresses: PlantAddresses,
        joined: Callable[[str], dict[str, object] | None],
        status: Callable[[], dict[str, object]],
    ) -> None:
        """`joined`: io.NAME and route.NAME; `status`: of the complete process."""
        self._run, self._image, self._values = context.run, context.image, context.values
        self._tools, self._contacts, self._host, self._joined, self._status = tools, contacts, host, joined, status
        self._addresses, self._operands = addresses, addresses.operands
        self._clients = 0
        self._turn = asyncio.Lock()
        self._failed = ""
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Answers at runtime_dir()/SLUG-services.sock."""
        self._server = await self.listen(runtime_dir() / f"{self._run.plan.slug}-services.sock")

    async def close(self) -> None:
        if self._server is not None:
            self._server.close()

    async def listen(self, path: pathlib.Path) -> asyncio.Server:
        """Start answering; a stale socket of a predecessor is replaced."""
        with contextlib.suppress(FileNotFoundError):
            path.unlink()
        return await asyncio.start_unix_server(self._serve, path, limit=LONGEST)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._clients += 1
        try:
            with contextlib.suppress(OSError, ValueError, asyncio.IncompleteReadError):
                if self._clients > CLIENTS:
                    writer.write(json.dumps({"error": f"{CLIENTS} tools are connected; end one of them"}).encode() + b"\n")
                    return
                while line := await _request(reader):
                    async with self._turn:
                        writer.write(self._reply(line, writer) + b"\n")
                        await asyncio.sleep(0)  # one request of all tools a turn: those that wait would be answered before anything else
                    await writer.drain()
        finally:
            self._clients -= 1
            self._tools.closed(writer)
            writer.close()

    def _reply(self, line: bytes, connection: object) -> bytes:
        """Whatever goes wrong: a sentence for the tool and the journal, the connection stays."""
        try:
            if len(line) > LONGEST:
                return json.dumps({"error": f"a request has at most {LONGEST} bytes"}).encode()
            return json.dumps(self.answer(line, connection)).encode()
        except Exception as fault:
            words = f"{type(fault).__name__}: {fault}"
            if words != self._failed:  # a tool repeats its request
                self._failed = words
                self._run.journal.write("alarm", f"a tool's request failed: {words}")
            return json.dumps({"error": f"the request failed: {words}"}).encode()

    def answer(self, line: bytes, connection: object = "") -> dict[str, object]:
        """Answer one request; a fault of it is returned in words.  `connection`: owner of a tool's control."""
        try:
            request = json.loads(line)
            if request.get("op") not in ASKING and request.get("do") not in LOOKING and not _looks(request):
                self._run.recorder.put(self._run.clock(), Source.TOOL, TOOL_SOURCE, line.strip())
            if request.get("op") in ("contacts", "force"):
                return self._contacts.answer(request)
            found = self._tools.answer(request, connection)
            if found is not None:
                return found
            match request.get("op"):
                case "get":
                    return self._get(str(request["address"]))
                case "set":
                    return self._set(str(request["address"]), str(request["value"]))
                case "names":
                    return {"names": self._values.names()}
                case "panel" | "plc" | "process" | "status" as op:
                    return self._controlled(op, request, connection)
            return {"error": f"op {request.get('op')!r}; get, set, names, panel, plc, process, status are known"}
        except (AddressFault, VariableError) as fault:
            return {"error": str(fault)}
        except (KeyError, ValueError, TypeError, AttributeError) as fault:
            return {"error": str(fault.args[0]) if fault.args else repr(fault)}

    def _panel(self, request: dict[str, object], connection: object) -> dict[str, object]:
        """Everybody may look, stop and let a key go."""
        page = request.get("source") == PAGE_SOURCE
        acts = not _looks(request) and "release" not in request and request.get("key") != "STOP"
        if acts and not page and self._tools.held_by_another(connection):
            return {"error": "not owner: another commissioning tool has control"}
        panel = self._host.panel
        if panel is None:
            kinds = " or ".join(f'"{kind.name}"' for kind in CONTROLLERS.values() if kind.panel is not None)
            return {"error": f"no panel: this cell has no [controller] of kind {kinds}"}
        answer = panel.answer(request, PAGE_SOURCE if page else TOOL_SOURCE, self._run.clock())
        if not _looks(request):
            self._image.pass_on()
        return answer

    def _controlled(self, op: str, request: dict[str, object], connection: object) -> dict[str, object]:
        match op:
            case "panel":
                return self._panel(request, connection)
            case "plc":
                return self._plc(request, connection)
            case "process":
                return self._process(request, connection)
        return self._status()

    def _plc(self, request: dict[str, object], connection: object) -> dict[str, object]:
        if self._host.plc is None:
            return {"error": "no PLC: this cell has no [controller.plc]"}
        if request.get("do") not in LOOKING and self._tools.held_by_another(connection):
            return {"error": "not owner: another commissioning tool has control"}
        return self._host.plc.order(request)

    def _process(self, request: dict[str, object], connection: object) -> dict[str, object]:
        """A program that a connection in control starts moves as the tool or the page, any other one as the PLC's command source."""
        page = request.get("source") == PAGE_SOURCE
        if request.get("do") in TESTING and not page and self._tools.held_by_another(connection):  # everybody may stop
            return {"error": "not owner: another commissioning tool has control"}
        if self._host.programs is None:
            return {"error": f"no programs: {NO_PROGRAMS}"}
        answer = self._host.programs.answer(request, self._tools.source_of(connection, page=page))
        self._image.pass_on()
        return answer

    # ---- reading -----------------------------------------------------------------------------------------------------
    def _get(self, text: str) -> dict[str, object]:
        place = parse_operand(text, self._addresses.symbols)
        match place:
            case Operand():
                return self._operands.get(text, place) or self._coordination(text, place)
            case RcBit():
                return {"address": text, "place": self._name_of(place), "value": self._addresses.bit(place)}
            case DataBit():
                line, data = self._values.serving(place.db)
                word = int.from_bytes(data[2 * place.word : 2 * place.word + 2], "big")
                return {"address": text, "place": str(place), "value": word >> place.bit & 1, "source": line.name}
            case DataWord():
                line, data = self._values.serving(place.db)
                size = 4 if place.part is WordPart.DOUBLE else 2
                raw = data[2 * place.word : 2 * place.word + size]
                if len(raw) < size:
                    return {"error": f"{place}: the block has {len(data) // 2} words"}
                unit = entry_unit(self._run.cell, line.name, place)
                return {"address": text, "place": str(place), "source": line.name, **_columns(raw, place.part), **unit}
            case CellName(name):
                return self._named(text, name)
            case Register():
                return self._register(text, place)
            case FlagBit():  # parse_operand has these as operands
                return self._flag(text, place)

    def _register(self, text: str, place: Register) -> dict[str, object]:
        """As a Modbus client would read it from the first server of the cell."""
        view = next(iter(self._values.views), None)
        if view is None:
            return {"error": f"{text}: this cell has no [[modbus]] server"}
        kind = _KINDS[place.table]
        bits = kind in (Kind.COILS, Kind.DISCRETE_INPUTS)
        found = view.read_bits(kind, place.address, 1) if bits else view.read_words(kind, place.address, 1)
        if isinstance(found, ExceptionCode):
            return {"error": f"{text}: {place.table.name.lower()} {place.address} does not exist; axisgate's map: AX-012"}
        value = int(found[0])
        columns: dict[str, object] = {"KH": f"{value:04X}"} if not bits else {}
        return {"address": text, "place": f"{place.table.name.lower()} {place.address}", "value": value, **columns}

    def _named(self, text: str, name: str) -> dict[str, object]:
        if name.startswith(PREFIX):
            variable, _ = variable_of(name)
            return {"address": text, "place": f"{name} ({variable.name})", "value": self._phg().read(name)}
        joined = self._joined(name)
        if joined is not None:
            return {"address": text, "place": name, **joined}
        named, control = self._values.named, self._image.control
        if control is not None and name in control.names():
            return {"address": text, "place": name, "value": control.value(name)}
        if name in named:
            sample = named.sample(name)
            age_ms = (self._run.clock() - sample.stamp_ns) / 1e6 if sample.stamp_ns else None
            value = NEVER_WRITTEN if sample.value is None else sample.value
            return {
                "address": text,
                "place": name,
                "value": value,
                "quality": sample.quality.name,
                "age_ms": age_ms,
                "source": sample.source,
            }
        try:
            return {"address": text, "place": name, "value": self._values.read(name), **name_unit(self._run.cell, name)}
        except KeyError:
            names = self._values.names()
            if name in names:  # of a part that has no value yet
                return {"address": text, "place": name, "value": NEVER_WRITTEN, **name_unit(self._run.cell, name)}
            return {"error": f"{name}: no such name{_meant(name, names)}; axisgate var lists them"}

    def _phg(self) -> Parameters:
        """Variables of the PHG 2000; KeyError: this cell has none."""
        if self._host.parameters is None:
            raise KeyError('phg: variables of the PHG need a cell with [controller] of kind "rho3"')
        return self._host.parameters

    def _coordination(self, text: str, place: Operand) -> dict[str, object]:
        """A flag of a cell without a control of its own: the partner's."""
        if place.kind is not OperandKind.FLAG or place.bit is None or place.number >= AREA_BYTES:
            return {
                "error": f"{text}: this cell has no flags, timers and counters except coordination flags M 0.0..M 255.7; [controller] has"
            }
        return self._flag(text, FlagBit(place.number, place.bit))

    def _flag(self, text: str, place: FlagBit) -> dict[str, object]:
        """A coordination flag, of whichever line has it set; 0 while none has."""
        holders = [
            line for line in self._values.lines if any(byte >> place.bit & 1 for byte in line.flag_bytes()[place.byte : place.byte + 1])
        ]
        return {"address": text, "place": str(place), "value": int(bool(holders)), "source": ", ".join(line.name for line in holders)}

    def _reset_flag(self, text: str, place: FlagBit, value: str) -> dict[str, object]:
        """A program has used the data; only a partner sets the flag."""
        if value != "0":
            return {"error": f"{text} = {value}: a coordination flag is set by the partner's job; it is reset with 0"}
        for line in self._values.lines:
            line.reset_flag(place.byte, place.bit)
        return self._flag(text, place)

    def _name_of(self, place: RcBit) -> str:
        """RC output 64 (E8.0, READY_RCO): the number, the PLC's address and the signal's name if it has one."""
        signal = self._addresses.signals.at(place)
        return f"{place.direction.value} {place.number} ({pic(place)}{', ' + signal.name if signal else ''})"

    # ---- writing -----------------------------------------------------------------------------------------------------
    def _set(self, text: str, value: str) -> dict[str, object]:
        if not self._run.plan.simulated:
            return {"error": f"{text}: values are set only in a simulated run (axisgate run CELL --sim); here the PLC writes them"}
        place = parse_operand(text, self._addresses.symbols)
        control = self._image.control
        if isinstance(place, CellName) and place.name.startswith(PREFIX):
            typed = _typed(value)
            self._phg().write(place.name, int(typed) if isinstance(typed, bool) else typed)
            return {"address": text, "place": place.name, "value": typed} if place.name == STOP else self._get(text)
        if isinstance(place, CellName) and control is not None and place.name in control.names():
            control.put(place.name, float(value))
            return self._get(text)
        if isinstance(place, Operand) and self._operands.there(place):
            return self._operands.put(text, place, value) or self._get(text)
        if isinstance(place, Operand) and place.kind is OperandKind.FLAG and place.bit is not None and place.number < AREA_BYTES:
            return self._reset_flag(text, FlagBit(place.number, place.bit), value)
        if isinstance(place, CellName) and place.name in self._values.named:
            self._values.write(place.name, _typed(value), self._run.clock(), "var")
            return self._get(text)
        if not isinstance(place, DataWord | DataBit):
            return {"error": f"{text}: a data word or bit a PLC writes is expected, e.g. DB10.DW2 or DB10.D0.8"}
        line, data = self._values.serving(place.db)
        word = int.from_bytes(data[2 * place.word : 2 * place.word + 2], "big")
        number = _whole(value)
        if number is None:
            return {"error": f"{text} = {value!r}: a whole number is expected, e.g. 1200, -5 or 0x04B0"}
        raw = word_bytes(place, word, number)
        if raw is None:
            return {"error": f"{text} = {value}: a DW takes -32768..65535, a DD -2147483648..4294967295, DL and DR 0..255, a bit 0 or 1"}
        refused = line.write_as_plc(place.db, place.word, raw)
        return {"error": refused} if refused else self._get(text)


async def _request(reader: asyncio.StreamReader) -> bytes:
    """One line; for one longer than LONGEST a fault; b"": the tool is gone."""
    long = False
    while True:
        try:
            line = await reader.readuntil(b"\n")
            return line if not long else bytes(LONGEST + 1)
        except asyncio.LimitOverrunError as fault:
            long = True
            await reader.readexactly(fault.consumed)
        except asyncio.IncompleteReadError as fault:
            return fault.partial if not long else b""


def _meant(name: str, names: Sequence[str]) -> str:
    """The name probably meant; comparing all of a large cell takes longer than a turn may last."""
    alike = names if len(names) <= MOST_ALIKE else [each for each in names if each[:ALIKE] == name[:ALIKE]][:MOST_ALIKE]
    close = difflib.get_close_matches(name, alike, n=1)
    return f", did you mean {close[0]}?" if close else ""


def _looks(request: dict[str, object]) -> bool:
    """A panel that is only looked at."""
    return request.get("op") == "panel" and not {"key", "mode", "hold", "release"} & request.keys()


def _typed(text: str) -> bool | int | float | str:
    """A number if the text reads like one, else the text."""
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def _whole(text: str) -> int | None:
    """Decimal, or hexadecimal with 0x; None: not an integer."""
    with contextlib.suppress(ValueError):
        return int(text, 0)
    return None


def _columns(raw: bytes, part: WordPart) -> dict[str, object]:
    """The same bytes in the number formats an S5 programmer looks for."""
    if part is WordPart.LEFT:
        return {"KH": raw[:1].hex().upper(), "value": raw[0]}
    if part is WordPart.RIGHT:
        return {"KH": raw[1:].hex().upper(), "value": raw[1]}
    signed = int.from_bytes(raw, "big", signed=True)
    columns: dict[str, object] = {"value": signed, "KF" if len(raw) == 2 else "DH": signed, "KH": raw.hex().upper()}
    if len(raw) == 2:
        columns["KM"] = f"{int.from_bytes(raw, 'big'):016b}"
    else:
        columns.update(_floats(raw))
    return columns


def _floats(raw: bytes) -> dict[str, object]:
    found: dict[str, object] = {}
    for kind in (Step5Type.KG, Step5Type.REAL):
        with contextlib.suppress(ProtocolError):
            found[kind.name] = decode(kind, raw)
    return found


def name_unit(cell: Cell, name: str) -> dict[str, object]:
    """Unit of a name of the cell; nothing for bits, counters and codes."""
    found = lookup(name)
    if found is None:
        return {}
    if found.name.kind is NameKind.PERCENT:
        return {"unit": "%"}
    axis = next((axis for axis in cell.axis if axis.name == found.which), None)
    return {"unit": axis.unit} if axis is not None and found.name.kind is NameKind.WAY else {}


def entry_unit(cell: Cell, line: str, place: DataWord) -> dict[str, object]:
    """Value of one step of that word, if an entry of the cell names it: 0.1 mm."""
    for block in cell.db:
        if block.number == place.db and block.line == line:
            return next(
                ({"unit": entry.unit} for entry in block.entries if entry.unit not in ("", "1") and place_of(block, entry) == place), {}
            )
    return {}
