"""What `axisgate check` says about [[telegram]]; each fault with its key, its line and a hint."""

import pytest

from gateway.cell_file.load import load_cell
from gateway.checks.playable import not_playable
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults, Fault

HEAD = """format = 1
[cell]
name = "Telegrams"
[[line]]
name = "V24_1"
port = "sim"
profile = "rho3"
layer = "telegrams"
byte_order = "little"
"""
ORDER = """
[[telegram]]
line   = "V24_1"
name   = "ORDER"
match  = [ { byte = 0, hex = "00 00" }, { byte = 2, text = "OR" } ]
length = 18
fields = [
  { byte = 4,  type = "INTEGER", to = "order.number" },
  { byte = 8,  type = "INTEGER", to = "order.pallet" },
  { byte = 12, type = "REAL",    to = "order.height", unit = "mm" },
  { byte = 16, type = "CHARACTER", to = "order.pattern", count = 2 },
]
then   = "signal order.new"
"""
DONE = """
[[telegram]]
line   = "V24_1"
name   = "DONE"
when   = "rising order.done"
build  = [ { hex = "00 00" }, { text = "DN" },
           { type = "INTEGER", from = "order.number" },
           { type = "INTEGER", from = "error.first.code" } ]
"""


def faults_of(text: str) -> tuple[Fault, ...]:
    try:
        load_cell("cell.toml", text)
    except CellFaults as found:
        return found.faults
    return ()


def cell_of(text: str) -> Cell:
    return load_cell("cell.toml", text)


def test_the_example_of_users_md_is_sound_and_playable() -> None:
    cell = cell_of(HEAD + ORDER + DONE)
    assert not_playable(cell) == []
    assert cell.line[0].supervision.max_silence_ms == 0
    assert [notice.text for notice in cell.notices if notice.where == "telegram DONE"] == [
        "nothing in this file writes order.done: a program must write it, or `axisgate var order.done --set 1` in a simulated run"
    ]


def replaced(old: str, new: str) -> str:
    text = HEAD + ORDER + DONE
    assert old in text
    return text.replace(old, new, 1)


SECOND = '\n[[telegram]]\nline = "V24_1"\nname = "{name}"\n{rest}\n'


@pytest.mark.parametrize(
    "text, key, words",
    [
        (replaced('byte = 8,  type = "INTEGER"', 'byte = 6,  type = "INTEGER"'), "telegram.ORDER.fields[1]", "overlaps order.number"),
        (replaced("length = 18", "length = 17"), "telegram.ORDER.fields[3]", "beyond the length: bytes 0..16"),
        (
            replaced('"INTEGER", to = "order.number"', '"INTEGRE", to = "order.number"'),
            "telegram.ORDER.fields[0].type",
            "did you mean INTEGER?",
        ),
        (replaced("length = 18", "length = 139"), "telegram.ORDER.length", "profile has 1..138"),
        (replaced("length = 18", "length = 4001"), "telegram.ORDER.length", "allowed 1..4000 bytes"),
        (replaced("count = 2", 'count = 2, unit = "mm", scale = 2.0'), "telegram.ORDER.fields[3]", "CHARACTER has no scale"),
        (replaced('unit = "mm"', 'unit = "0.1 mm", scale = 0.1'), "telegram.ORDER.fields[2]", "sets the same"),
        (replaced('unit = "mm"', 'unit = "0 mm"'), "telegram.ORDER.fields[2]", "must be greater than 0"),
        (replaced('hex = "00 00" }, { byte', 'hex = "00 0" }, { byte'), "telegram.ORDER.match[0].hex", "two hex digits a byte"),
        (replaced('byte = 2, text = "OR"', 'byte = 2, text = "OR", hex = "4F"'), "telegram.ORDER.match[1]", "exactly one of hex, text"),
        (replaced('"order.height"', '"axis.A1.actual"'), "telegram.ORDER.fields[2]", "this name is reserved for axisgate"),
        (replaced('"order.height"', '"order.new"'), "telegram.ORDER.then", "a signal needs a name of its own"),
        (replaced('"signal order.new"', '"order.new"'), "telegram.ORDER.then", '"signal order.new"'),
        (replaced('"rising order.done"', '"order.done"'), "telegram.DONE.when", '"rising order.done"'),
        (replaced("rising order.done", "falling order.new"), "telegram.DONE.when", "a signal can only be received: rising"),
        (replaced('"order.height"', '"telegram.DONE.sent"'), "telegram.ORDER.fields[2]", "this name is reserved for axisgate"),
        (replaced('from = "order.number"', 'from = "order.numbr"'), "telegram.DONE.build[2]", "did you mean order.number?"),
        (replaced('from = "error.first.code"', 'from = "axis.Q.actual"'), "telegram.DONE.build[3]", "no such axis"),
        (
            replaced('from = "error.first.code"', 'from = "order.pattern"'),
            "telegram.DONE.build[3]",
            "ORDER writes order.pattern as CHARACTER",
        ),
        (replaced('from = "order.number"', 'count = 2, from = "order.number"'), "telegram.DONE.build[2]", "writes 1 values"),
        (
            replaced('{ text = "DN" }', '{ text = "DN", type = "BYTE" }'),
            "telegram.DONE.build[1]",
            "exactly one of hex, text, type with from",
        ),
        (replaced('{ text = "DN" }', '{ type = "BYTE" }'), "telegram.DONE.build[1]", "a value has type and from"),
        (replaced('when   = "rising order.done"\n', ""), "telegram.DONE.when", "what sends it?"),
        (
            replaced('when   = "rising order.done"\n', 'when = "rising order.done"\nlength = 3\n'),
            "telegram.DONE.length",
            "that of its parts",
        ),
        (replaced('layer = "telegrams"', 'layer = "program"'), "telegram.ORDER.line", 'layer "program" carries no telegrams'),
        (replaced('line   = "V24_1"\nname   = "DONE"', 'line = "V24_2"\nname = "DONE"'), "telegram.DONE.line", "no such line"),
        (
            HEAD + ORDER + DONE + SECOND.format(name="DONE", rest='match = [{ byte = 0, hex = "01" }]'),
            "telegram.DONE.name",
            "is used twice",
        ),
        (HEAD + SECOND.format(name="T", rest=""), "telegram.T", "neither match nor build"),
        (HEAD + SECOND.format(name="T", rest='when = "rising cell.error"'), "telegram.T.build", "what is sent?"),
        (
            HEAD + SECOND.format(name="T", rest='match = [{ byte = 0, hex = "01" }]\nbuild = [{ hex = "01" }]\nwhen = "rising cell.error"'),
            "telegram.T",
            "one direction",
        ),
        (
            HEAD + ORDER + SECOND.format(name="T", rest='match = [{ byte = 2, text = "O" }]'),
            "telegram.T.match",
            "ORDER matches the same bytes: a block that begins 00 00 4F 52 would match both",
        ),
        (
            HEAD + SECOND.format(name="T", rest='when = "rising cell.error"\nbuild = [{ type = "TEXT", from = "cell.x" }]'),
            "telegram.T.build[0]",
            "",
        ),
        (
            HEAD
            + SECOND.format(
                name="T", rest='when = "rising cell.error"\nbuild = [{ type = "REAL", count = 35, from = "error.first.code" }]'
            ),
            "telegram.T.build",
            "140 bytes; a block has 1..138",
        ),
        (HEAD + "[line.supervision]\nmax_silence_ms = 20\n" + ORDER, "line.V24_1.supervision.max_silence_ms", "allowed 50..60000 ms"),
    ],
)
def test_what_is_wrong_is_said_at_its_key(text: str, key: str, words: str) -> None:
    found = {fault.key: fault for fault in faults_of(text)}
    assert key in found, "\n".join(map(str, found.values()))
    assert words in str(found[key]) and found[key].line is not None


def test_two_lines_do_not_write_one_name() -> None:
    line = HEAD.partition("[[line]]")[2].replace("V24_1", "V24_2")
    other = ORDER.replace("V24_1", "V24_2").replace('"ORDER"', '"ORDER2"')
    faults = faults_of(HEAD + "[[line]]" + line + ORDER + other)
    assert {fault.key for fault in faults} == {
        f"telegram.ORDER2.{key}" for key in ("fields[0]", "fields[1]", "fields[2]", "fields[3]", "then")
    }
    assert all("line V24_1 writes it already" in fault.hint for fault in faults)


def test_a_fault_in_a_field_is_reported_at_its_own_line() -> None:
    text = replaced('byte = 8,  type = "INTEGER"', 'byte = 6,  type = "INTEGER"')
    (fault,) = faults_of(text)
    assert "order.pallet" in text.splitlines()[(fault.line or 1) - 1]


def test_a_rk512_line_keeps_its_supervision_and_a_line_without_telegrams_is_warned_about() -> None:
    faults = faults_of(HEAD.replace('layer = "telegrams"', 'layer = "rk512"') + "[line.supervision]\nmax_silence_ms = 0\n")
    assert [fault.hint for fault in faults] == ['0 (no supervision) only with layer = "telegrams"']
    assert any("every block is counted and dropped" in notice.text for notice in cell_of(HEAD).warnings)


def test_a_faulty_telegram_is_left_out_whole_and_the_names_it_writes_are_no_second_fault() -> None:
    faults = faults_of(replaced('"INTEGER", to = "order.number"', '"INTEGRE", to = "order.number"'))
    assert [fault.key for fault in faults] == ["telegram.ORDER.fields[0].type"]


def test_a_telegram_may_be_as_long_as_a_block_of_its_lines_profile() -> None:
    """CP 340: 1,024 characters both ways; the Linux discipline takes 4,000 and sends 256."""

    def told(profile: str, length: int, built: int) -> list[str]:
        text = HEAD.replace("rho3", profile) + ORDER.replace("length = 18", f"length = {length}")
        text += DONE.replace('{ text = "DN" }', f'{{ text = "{"D" * (built - 10)}" }}')
        return [fault.key for fault in faults_of(text)]

    assert told("siemens-cp340", 1024, 1024) == [] and told("linux", 4000, 256) == []
    assert told("siemens-cp340", 1025, 1025) == ["telegram.ORDER.length", "telegram.DONE.build"]
    assert told("linux", 18, 257) == ["telegram.DONE.build"] and told("rho3", 18, 139) == ["telegram.DONE.build"]
