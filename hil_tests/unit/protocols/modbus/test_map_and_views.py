"""`axisgate map` says what the command sources do: each row is tried at the view it describes.  And what stands beside the view."""

import csv
import dataclasses
import json
import pathlib

import pytest

import gateway
from gateway.cell_file.load import load_cell
from gateway.checks.modbus import modbus as _checked
from gateway.checks.playable import not_playable
from gateway.commands.map import main
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.records.cell import RC_BYTES, InputImage
from gateway.pure.modbus.registers import Placed, Registers, RegistersView
from gateway.pure.modbus.rho3_view import BlockFiles, RhoView
from gateway.pure.reports.tables import Sheet, render
from gateway.services.modbus_clients import blocks_of, pdu_of
from gateway.services.sources.modbus import placed, spans
from gateway.tools.address_map import modbus_sheets, signal_sheets
from gateway.tools.address_map_views import reference
from protocols.modbus.answering import answer
from protocols.modbus.view import ExceptionCode, Kind

MISSING, FAILED = ExceptionCode.ILLEGAL_DATA_ADDRESS, ExceptionCode.SERVER_DEVICE_FAILURE
KINDS = {
    "coil": Kind.COILS,
    "discrete input": Kind.DISCRETE_INPUTS,
    "holding register": Kind.HOLDING_REGISTERS,
    "input register": Kind.INPUT_REGISTERS,
}


def demo(more: str = "") -> Cell:
    text = (pathlib.Path(gateway.__file__).parents[1] / "configs/cells/demo.toml").read_text()
    return load_cell("demo.toml", text + more)


def view_of(cell: Cell) -> RhoView:
    """As the command source makes it; values are 1.5 for every name."""
    settings = cell.modbus[0]
    owned = [octet for octet, owner in cell.rc_inputs.owner.items() if owner == settings.name]
    registers = Registers(placed(settings, [axis.name for axis in cell.axis]), lambda name: 1.5, settings.float)
    return RhoView(InputImage(), owned, lambda octets: None, lambda first, values: None, registers)


# ------------------------------------------------------------------------------------------------------------------ map


def test_every_row_of_the_map_is_true_of_the_view() -> None:
    cell = load_cell("demo")
    view, tried = view_of(cell), 0
    for sheet in modbus_sheets(cell):
        for table, address, _, size, type_, access, _, _ in sheet.rows:
            kind, at, count = KINDS[str(table)], int(str(address)), int(str(size))
            read = view.read_bits(kind, at, count) if type_ == "bit" else view.read_words(kind, at, count)
            assert not isinstance(read, ExceptionCode), (table, address)
            if kind is Kind.COILS:
                assert (view.write_bits(at, [False]) is None) is (access == "R/W"), (table, address)
            elif kind is Kind.HOLDING_REGISTERS:
                assert (view.write_words(at, [0] * count) is None) is (access == "R/W"), (table, address)
            else:
                assert access == "R"
            tried += 1
    assert tried > 300


def test_references_count_from_one_and_have_six_digits_beyond_9999() -> None:
    assert [reference("holding register", at) for at in (0, 1000, 9998, 9999, 65535)] == ["40001", "41001", "49999", "410000", "465536"]
    assert [reference("coil", at) for at in (0, 9998, 9999)] == ["00001", "09999", "010000"]


def test_the_four_addresses_of_a_signal_are_beside_each_other() -> None:
    rows = {row[0]: row for sheet in signal_sheets(load_cell("demo")) for row in sheet.rows}
    assert rows["EMSTOP_OK_RCI"][1:5] == (24, "O3.0", "O2.0", "2.1") and rows["EMSTOP_OK_RCI"][7] == "plc2"


@pytest.mark.parametrize("form", ["md", "csv", "json", "html"])
@pytest.mark.parametrize("what", ["modbus", "db", "signals", "wiring"])
def test_each_map_in_each_form_has_every_row(what: str, form: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", f"--{what}", "--format", "json"]) == 0
    sheets = json.loads(capsys.readouterr().out)["sheets"]
    rows = sum(len(sheet["rows"]) for sheet in sheets)
    file = tmp_path / "map"
    assert main(["demo", f"--{what}", "--format", form, "-o", str(file)]) == 0
    text = file.read_text(encoding="utf-8")
    counted = {
        "md": text.count("\n| ") - text.count("|---|\n"),
        "csv": sum(len(line) > 1 for line in csv.reader(text.splitlines(), delimiter=";")) - len(sheets),
        "json": rows,
        "html": text.count("<tr>") - text.count("<thead>"),
    }
    assert counted[form] == rows > 0


def test_csv_is_what_a_german_spreadsheet_opens() -> None:
    text = render("n", [Sheet("t", ("a", "b"), ((0.5, 'x;"y"'), (None, 3)))], "csv")
    assert text == '\ufefft\r\na;b\r\n0,5;"x;""y"""\r\n;3\r\n\r\n'


def test_a_map_of_nothing_is_a_usage_fault_and_of_what_is_not_there_a_finding(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["demo"])
    assert stopped.value.code == 2
    assert main(["nowhere", "--db"]) == 2
    assert main(["demo-402", "--db", "-o", "/nowhere/at/all"]) in (1, 3)


# ------------------------------------------------------------------------------------------------ registers beside a view

REGISTERS = """
[[modbus]]
name = "second"
bind = "127.0.0.1:1503"
float = "CDAB"
[[modbus.registers]]
at = 2000
from = "axis.*.actual"
[[modbus.registers]]
at = 2100
from = "error.first.code"
"""


def test_registers_of_the_cell_are_where_it_says_in_its_order() -> None:
    cell = demo(REGISTERS)
    settings = cell.modbus[1]
    extras = placed(settings, [axis.name for axis in cell.axis])
    assert [(each.at, each.name) for each in extras[:2]] == [(2000, "axis.A1.actual"), (2002, "axis.A2.actual")]
    values = {each.name: 10.1 for each in extras} | {"error.first.code": 513.0}
    view = RhoView(InputImage(), (), lambda octets: None, None, Registers(extras, values.__getitem__, settings.float))
    for kind in (Kind.HOLDING_REGISTERS, Kind.INPUT_REGISTERS):
        assert view.read_words(kind, 2000, 4) == [0x999A, 0x4121, 0x999A, 0x4121]
        assert view.read_words(kind, 2011, 1) == [0x4121] and view.read_words(kind, 2100, 1) == [513]
        assert view.read_words(kind, 2011, 2) is MISSING, "a gap is not there"
        values["error.first.code"] = 70000.0
        assert view.read_words(kind, 2100, 1) is FAILED, "a number that does not fit is never shown wrong"
        values["error.first.code"] = 513.0
    assert view.write_words(2000, [1]) is MISSING
    bare = RegistersView(Registers([Placed(5, "a", "UINT16")], lambda name: 7.0))
    assert (bare.read_words(Kind.HOLDING_REGISTERS, 5, 1), bare.read_bits(Kind.COILS, 0, 1), bare.write_words(5, [1])) == (
        [7],
        MISSING,
        MISSING,
    )


def test_status_files_and_queue_of_the_rho3_view() -> None:
    """AX-342."""
    errors = [1, 70000, 3]
    block = {10: bytes(range(8))}
    view = RhoView(InputImage(), (), lambda octets: None, None, None, lambda: errors, BlockFiles(block.get))
    view.outputs = bytes((0,) * 8 + (0x25,) + (0,) * (RC_BYTES - 9))
    assert answer(b"\x07", view) == b"\x07\x25"
    assert answer(bytes.fromhex("14 07 06 000A 0001 0002"), view).hex() == "1406050602030405"
    assert answer(bytes.fromhex("14 07 06 000A 0003 0002"), view) == answer(bytes.fromhex("14 07 06 000B 0000 0001"), view) == b"\x94\x02"
    assert answer(bytes.fromhex("15 09 06 000A 0001 0001 0000"), view) == b"\x95\x02"
    assert answer(bytes.fromhex("18 07D0"), view).hex() == "18000800030001" + "11700003"
    errors[:] = range(40)
    assert len(answer(bytes.fromhex("18 07D0"), view)) == 5 + 2 * 31


def test_files_of_this_source_are_written_whole_or_not_at_all() -> None:
    """AX-479, V1.1b3, 6.15."""
    blocks = {10: bytearray(8), 11: bytearray(8)}

    def block(number: int) -> bytes | None:
        return bytes(blocks[number]) if number in blocks else None

    def write(number: int, word: int, data: bytes) -> None:
        blocks[number][2 * word : 2 * word + len(data)] = data

    view = RhoView(InputImage(), (), lambda octets: None, None, None, tuple, BlockFiles(block, (10, 12), write))
    both = bytes.fromhex("15 0B 06 000A 0002 0002 1234 5678")
    assert answer(both, view) == both and answer(bytes.fromhex("14 07 06 000A 0001 0003"), view).hex() == "14080706000012345678"
    before = {number: bytes(data) for number, data in blocks.items()}
    for second in ("06 000B 0000 0001 FFFF", "06 000A 0003 0002 FFFF FFFF", "06 000C 0000 0001 FFFF", "06 0063 0000 0001 FFFF"):
        groups = bytes.fromhex("06 000A 0000 0001 FFFF" + second)
        assert answer(bytes((21, len(groups))) + groups, view) == b"\x95\x02", second
        assert blocks == before, "a refused request writes nothing"
    assert answer(both, view, may_write=False) == b"\x95\x01"
    assert answer(both[:-1], view) == b"\x95\x03" and blocks == before


@pytest.mark.parametrize(
    ("more", "word"),
    [
        ('writer = "second"', ""),
        ('writer = "secand"', "a Modbus server (plc2, second)"),
        ('writer = "second"\nentries = [ { at = "DW 0", type = "KF", from = "cell.override" } ]', "has no entries"),
    ],
)
def test_check_knows_who_may_write_a_block(more: str, word: str) -> None:
    text = f"{REGISTERS}\n[[db]]\nnumber = 40\nwords = 8\n{more}\n"
    faults: tuple[str, ...] = ()
    try:
        cell = demo(text)
    except CellFaults as refused:
        faults = tuple(str(fault) for fault in refused.faults)
    else:
        sheet = next(sheet for sheet in modbus_sheets(cell) if "second" in sheet.title)
        assert "FC 21: files 40;" in sheet.note
    assert len(faults) == bool(word) and all(word in fault for fault in faults), faults


# --------------------------------------------------------------------------------------------------------------- checks

CLIENT = """
[[modbus]]
name = "coupler"
role = "client"
port = "tcp://10.0.0.7:502"
[[modbus.device]]
name = "tank"
order = "CDAB"
[[modbus.value]]
device = "tank"
table = "input"
at = 0
type = "REAL"
to = "tank.level"
[[modbus.value]]
device = "tank"
table = "input"
at = 2
type = "INT16"
to = "tank.heat"
[[modbus.value]]
device = "tank"
table = "coil"
at = 9
type = "bit"
from = "tank.pump"
"""


@pytest.mark.parametrize(
    "more, old, new, fault",
    [
        (CLIENT, 'port = "tcp://10.0.0.7:502"\n', "", "modbus.coupler.port"),
        (
            CLIENT,
            'port = "tcp',
            'tls = { certificate = "a", key = "b", ca = "c" }\nframing = "rtu"\nport = "tcp',
            "TLS carries Modbus TCP only",
        ),
        (CLIENT, 'port = "tcp', 'tls = { certificate = "a", key = "b", ca = "c" }\nport = "tcp', ""),
        (CLIENT, 'device = "tank"\ntable = "coil"', 'device = "tonk"\ntable = "coil"', "did you mean tank"),
        (CLIENT, 'to = "tank.heat"', 'to = "tank.heat"\nfrom = "tank.heat"', "exactly one of"),
        (CLIENT, 'type = "bit"', 'type = "REAL"', "do not fit"),
        (CLIENT, 'table = "coil"', 'table = "discrete"', "can only be read"),
        (CLIENT, "at = 2\n", "at = 65535\nscale = 0.0\n", "scale must not be 0"),
        (CLIENT, 'type = "REAL"', 'type = "LREAL"', ""),
        (REGISTERS, "at = 2100", "at = 2011", "taken by axis.A6.actual"),
        (REGISTERS, "at = 2000", "at = 60", "RC signals of the view"),
        (REGISTERS, "at = 2100", "at = 65536", "65535"),
        (REGISTERS, "axis.*.actual", "axis.Q.actual", "axis"),
        (REGISTERS, 'float = "CDAB"', 'allow = ["10.0.0"]', "an address or a network"),
        (REGISTERS, 'float = "CDAB"', 'tls = { certificate = "a", key = "b", ca = "c" }', "no client has any right"),
        (REGISTERS, 'float = "CDAB"', 'port = "/dev/ttyS0"', 'framing = "rtu"'),
        (REGISTERS, 'float = "CDAB"', 'units = [ { unit = 1, view = "rho3" } ]', "is used twice"),
        (REGISTERS, 'bind = "127.0.0.1:1503"', 'bind = "127.0.0.1:1502"', "already listens there"),
        (REGISTERS, 'float = "CDAB"', 'allow = ["10.0.0.5"]\nwriters = [ { from = "10.0.0.5" } ]', "keep one of them"),
    ],
)
def test_what_does_not_fit_is_named(more: str, old: str, new: str, fault: str) -> None:
    assert more.count(old) == 1
    text = more.replace(old, new)
    if not fault:
        demo(text)
        return
    with pytest.raises(CellFaults) as found:
        demo(text)
    assert fault in str(found.value), found.value


def test_both_good_and_playable() -> None:
    assert not_playable(demo(CLIENT + REGISTERS)) == [] and _checked is not None


def test_neighbours_are_read_together_and_written_in_the_devices_order() -> None:
    client = demo(CLIENT).modbus[1]
    assert [(block.table, block.first, block.end, len(block.values)) for block in blocks_of(client.value)] == [("input", 0, 3, 2)]
    assert pdu_of(client.value[2], 1.0, "CDAB").hex() == "050009ff00"
    written = dataclasses.replace(client.value[0], table="holding", to="", from_="tank.set", scale=0.5)
    assert pdu_of(written, 5.05, "CDAB").hex() == "10000000020" + "4999a4121"


def test_spans() -> None:
    assert spans(["0..63", "7"]) == ((0, 63), (7, 7))
