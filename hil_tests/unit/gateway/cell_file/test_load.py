"""The cell file: what is valid becomes data with sources, what is not is named whole, in one run (users.md 3.4, 3.5; design.md 5)."""

import pathlib
import re
from dataclasses import replace

import pytest

from gateway.cell_file.load import CellFaults, Fault, load_cell
from gateway.checks.playable import not_playable
from gateway.files.find import find_config, names_in, read_text
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.simulated_ports import unused_ports

SHIPPED = ("demo", "s5-rk512", "rho3-servodyn")


def text_of(name: str) -> str:
    return read_text(find_config(name, "cells"))


def edited(name: str, *edits: tuple[str, str]) -> str:
    """A shipped cell with some words replaced; every edit has to hit."""
    text = text_of(name)
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def faults_of(text: str) -> tuple[Fault, ...]:
    try:
        load_cell("cell.toml", text)
    except CellFaults as found:
        return found.faults
    return ()


def keys(faults: tuple[Fault, ...]) -> list[str]:
    return [fault.key for fault in faults]


# ---------------------------------------------------------------------------------------------------------- what is valid


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_cells_are_valid(name: str) -> None:
    assert keys(faults_of(text_of(name))) == []
    assert load_cell(name).file.endswith(f"{name}.toml")


def test_the_demo_cell_plays_and_the_examples_say_what_does_not() -> None:
    assert not_playable(load_cell("demo")) == []
    assert not_playable(load_cell("s5-rk512")) == []
    assert not_playable(load_cell("rho3-servodyn")) == []


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (('port     = "sim"                     # a simulated', 'port     = "COM5" #'), "line.plc1.port = COM5"),
        (('to = "cell.reset", ', 'to = "cell.safety_ok", '), "db.10[D 0.2] = cell.safety_ok"),
        (('to = "axis.*.reference",', 'to = "axis.A1.reference",'), "db.10[D 0.3] = axis.A1.reference"),
    ],
)
def test_what_the_shape_allows_but_nothing_plays_is_named(edit: tuple[str, str], reason: str) -> None:
    cell = load_cell("c", edited("demo", edit))
    assert not_playable(cell) == [reason]
    assert cell.notes[-1].text == f"not playable yet: {reason}"


def test_the_s5_example_is_reported_as_written_in_the_users_chapter() -> None:
    said = [f"{notice.level:<9}{notice.where}: {notice.text}" for notice in load_cell("s5-rk512").notices]
    assert said[:4] == [
        "note     db 10, DW 2 (KF, 0.1 mm): largest value 3276.7 mm; axis X goes to 2405.0 mm: fits",
        "warning  line plc: profile QVZ 2000 ms x 6 attempts = 12 s; on_loss acts after 1.0 s by life word: good; also wire feed hold",
        "note     bus can0: 745 us of 4000 us worst case (19 %); + 1 SDO pair 25 %; node 20 I/O event-driven",
        "warning  line plc: SEND 32 words 103 ms + FETCH 32 words 103 ms at 9600 Bd: "
        "your 100 ms polling is not reachable; expect 210..260 ms",
    ]
    assert said[4].startswith("warning  rc_inputs: assumed as 1, not wired here: ")
    assert "note     bus can0: 28 % with second TPDOs, heartbeats and I/O; each frame: axisgate bus load" in said[5:]
    assert any(each.startswith("note     axis X, Y, Z: drives/maker_x.eds: no such EDS file") for each in said[5:]) and len(said) == 8


def test_ports_that_a_simulated_cell_does_not_open_are_named() -> None:
    cell = load_cell("s5-rk512")
    (said,) = [str(notice.text) for notice in cell.warnings if notice.where == "cell"]
    line = "line plc (/dev/serial/by-id/usb-isolated-converter-if00)"
    assert (
        said
        == f'target = "simulation": everything is simulated, not used: {line}, bus can0 (socketcan:can0); to use them: target = "machine"'
    )
    assert unused_ports(cell, bus=False).endswith(f"not used: {line}"), "--bus gives the run another bus"
    assert unused_ports(load_cell("demo")) == "" and unused_ports(replace(cell, cell=replace(cell.cell, target="machine"))) == ""


def test_values_are_under_their_keys() -> None:
    cell = load_cell("demo")
    assert [axis.name for axis in cell.axis] == ["A1", "A2", "A3", "A4", "A5", "A6"]
    axis = cell.axis_named("A3")
    assert (axis.unit, axis.drive.module, axis.mechanics.ratio, axis.mechanics.vertical) == ("mm", 3, 5.0, True)
    assert cell.line[0].supervision.life_word == "DB10.DW31"
    assert cell.line[0].baud == 9600
    assert cell.db[0].entries[6].at == "DR 1" and cell.db[0].entries[6].max == 100
    assert cell.db[1].entries[0].from_ == "cell.ready" and cell.db[1].entries[0].to is None
    assert cell.rc_inputs.owner == {3: "plc2"}
    assert cell.plant is not None and cell.plant.axis["A1"].settings["kv_per_s"] == 80.0
    assert (cell.modbus[0].host, cell.modbus[0].port, cell.modbus[0].command_block) == ("127.0.0.1", 1502, True)
    assert cell.cycle_ms == 4


def test_p_numbers_become_axes_with_their_source() -> None:
    cell = load_cell("rho3-servodyn")
    first, second = cell.axis[0], cell.axis[1]
    assert (first.limits.min, first.limits.max, first.limits.speed, first.limits.accel) == (-165.0, 165.0, 120.0, 300.0)
    assert (first.home.speed, first.home.slow_speed, first.home.mode, first.mechanics.ratio) == (10.0, 2.0, 1, 121.0)
    assert (first.mechanics.direction, second.mechanics.direction) == ("+", "-")
    assert second.home.position == 90.0
    assert cell.cycle_ms == 8 and cell.bus[0].cycle_ms == 8 and cell.bus[1].bitrate == "500 kbit/s"
    assert cell.sources["axis.1.limits.speed"].text == "rho3.P103[1]"
    line = cell.sources["axis.1.limits.speed"].line
    assert line is not None and text_of("rho3-servodyn").splitlines()[line - 1].startswith("P103")
    assert first.limits.jerk == 3000.0 and "AX-123" in cell.sources["axis.1.limits.jerk"].text


def test_defaults_reach_every_axis_that_does_not_say_otherwise() -> None:
    text = edited(
        "demo", ('brake            = "drive"', 'brake            = "none"'), ('name   = "A2" ', 'brake  = "gateway"\nname   = "A2" ')
    )
    cell = load_cell("cell.toml", text)
    assert [axis.brake for axis in cell.axis] == ["none", "gateway", "none", "none", "none", "none"]
    assert "[defaults.axis]" in cell.sources["axis.A1.brake"].text


def test_a_name_that_is_none_is_judged_as_a_name_and_not_as_its_value() -> None:
    with pytest.raises(CellFaults) as found:
        load_cell("cell.toml", edited("demo", ('owner = { "3" = ', "owner = { 3x = ")) + '\n[signals]\n"K 01" = 3\n')
    assert [(fault.key, fault.range) for fault in found.value.faults[:2]] == [
        ("rc_inputs.owner.3x", "a whole number"),
        ("signals.K 01", "letters, digits, _ and -"),
    ]


# ------------------------------------------------------------------------------------------------------ what is not valid

MANY = """
format = 1
[cell]
name = "x"
target = "maschine"
colour = "red"
[[line]]
name = "old"
port = "sim"
protocol = "plain"
max_silence_ms = 5
[[line]]
name = "plc"
port = "sim"
profile = "siemens-cp526"
[line.supervision]
life_word = "DB10.DW40"
[[db]]
number = 10
words = 16
writer = "plc"
line = "plc"
entries = [
  { at = "D 0.0", type = "bit", to = "drives.onn" },
  { at = "DW 0", type = "KF", to = "move.Y.target", unit = "0.01 mm" },
  { at = "DW 15", to = "move.speed" },
]
[[bus]]
name = "b"
port = "sim"
protocol = "servodyn"
[[axis]]
name = "X"
unit = "mm"
drive = { type = "servodyn", bus = "b", module = 1 }
limits = { min = -5, max = 2405.0, speed = 0, accel = 3000 }
[[axis]]
name = "Y"
unit = "mm"
drive = { type = "servodyn", bus = "b", module = 1 }
limits = { min = -5, max = 2405.0, speed = 10, accel = 3000 }
home = { speed = 20 }
"""


def test_all_field_faults_then_all_cross_faults_in_one_run() -> None:
    faults = faults_of(MANY)
    crossed = [fault.kind == "cross" for fault in faults]
    assert crossed == sorted(crossed)
    assert keys(faults) == [
        "cell.target",
        "cell.colour",
        "line.old.protocol",
        "line.old.max_silence_ms",
        "db.10.entries[DW 15].type",
        "axis.X.limits.speed",
        "line.plc.profile",
        "line.plc.supervision.life_word",
        "db.10[D 0.0]",
        "db.10[DW 0]",
        "db.10[DW 0]",
        "axis.Y.home.speed",
    ]
    lines = MANY.splitlines()
    for fault in faults:
        word = re.split(r"[.\[]", fault.key)[-1].strip("]")
        assert fault.line is not None and (word in lines[fault.line - 1] or fault.key.endswith(".type")), fault


def test_a_fault_reports_file_key_value_range_unit_and_hint() -> None:
    faults = {fault.key: fault for fault in faults_of(MANY)}
    target, speed = faults["cell.target"], faults["axis.X.limits.speed"]
    assert (target.file, target.value, target.range, target.hint) == (
        "cell.toml",
        '"maschine"',
        "machine | simulation",
        "did you mean machine?",
    )
    assert (speed.value, speed.range, speed.unit) == ("0", "> 0", "mm/s")
    assert "reserved for a later version" in faults["line.old.protocol"].hint
    assert "belongs in supervision" in faults["line.old.max_silence_ms"].hint
    assert "types are bit, KF, DH, KH, KM, KY, KC, KT, KZ, KG, REAL, BCD" in faults["db.10.entries[DW 15].type"].hint
    assert str(target) == 'cell.toml:5: cell.target = "maschine": allowed machine | simulation: did you mean machine?'


AXIS_X = 'feed_per_turn = 200.0, gear = "10:1", direction = "+"'
FIELD = [  # cell, edit, key, part of what is said
    ("demo", ("cycle_ms = 4 ", "cycle_ms = 1 "), "bus.drives.cycle_ms", "allowed 2..32 ms"),
    ("demo", ("cycle_ms = 4 ", "cycle_ms = 33 "), "bus.drives.cycle_ms", "allowed 2..32 ms"),
    ("demo", ("words   = 32", 'words   = "32"'), "db.10.words", "a whole number"),
    ("demo", ("words   = 32", "wrods   = 32"), "db.10.wrods", "did you mean words?"),
    ("demo", ("seed = 1", "seed = true"), "plant.seed", "a whole number"),
    ("demo", ('gear = "5:1"', 'gear = "0:1"'), "axis.A1.mechanics.gear", "10:1"),
    ("demo", ("warn = 12.5", "warn = nan"), "axis.A1.following_error.warn", "finite"),
    ("demo", ("motor_inertia_kgm2   = 0.0012", "motor_inertia_kgm2   = -1"), "plant.axis.A1.motor_inertia_kgm2", "rotor inertia"),
    ("demo", ("motor_inertia_kgm2 ", "motor_inertia "), "plant.axis.A1.motor_inertia", "did you mean motor_inertia_kgm2?"),
    ("demo", ('format   = "9600 8E1"', 'format   = "9601 8E1"'), "line.plc1.format", "baud, bits, parity, stop"),
    ("demo", ("format = 1", "format = 2"), "format", "allowed 1"),
    ("demo", ('name             = "axisgate demo: gantry with wrist"', 'name = ""'), "cell.name", "must not be empty"),
    ("demo", ('layer    = "rk512"', 'layer    = "plain"'), "line.plc1.layer", "reserved for a later version"),
    ("demo", ('type = "bit", to = "drives.on"', 'type = "REAAL", to = "drives.on"'), "db.10.entries[D 0.0].type", "did you mean REAL?"),
    ("demo", ("[[line]]", "[line]"), "line", "double brackets"),
    ("demo", ('name     = "plc1"', "name     = []"), "line[0].name", "a text"),
    ("rho3-servodyn", ("P2   = 3", "P2   = 16"), "rho3.P2", "allowed 0..15"),
    ("rho3-servodyn", ("P2   = 3", "P777 = 3"), "rho3.P777", "unknown key"),
    ("rho3-servodyn", ("P103 = [ 120.0,", "P103 = ["), "rho3.P103", "6 axes need 6 values"),
]


@pytest.mark.parametrize(("name", "edit", "key", "said"), FIELD, ids=[f"{row[2]}-{row[1][1][-12:]}" for row in FIELD])
def test_field_faults(name: str, edit: tuple[str, str], key: str, said: str) -> None:
    faults = [fault for fault in faults_of(edited(name, edit)) if fault.key == key]
    assert faults and said in str(faults[0]) and faults[0].kind in ("field", "syntax")


CROSS = [
    ("demo", ('at = "DW 3",   type = "KF",  to', 'at = "DW 2",   type = "KF",  to'), "db.10[DW 2]", "two entries at one address"),
    ("demo", ('"DR 1", ', '"DR 0", '), "db.10[DR 0]", "overlaps"),
    ("demo", ('at = "DD 2", ', 'at = "DD 1", '), "db.12[DD 1]", "overlaps DD 0"),
    ("demo", ('at = "DW 31",  type = "KF",  to', 'at = "DW 32",  type = "KF",  to'), "db.10[DW 32]", "32 words"),
    ("demo", ('to = "drives.on" ', 'from = "cell.ready" '), "db.10[D 0.0]", "two writers in one word"),
    ("demo", ('to = "drives.on" ', 'to = "move.start" '), "db.10[D 0.8]", "writes it already"),
    ("demo", ('to = "drives.on" ', 'to = "drive.on" '), "db.10[D 0.0]", "did you mean drives.on?"),
    ("demo", ('to = "drives.on" ', 'to = "FEED_ALLOW_RCI" '), "db.10[D 0.0]", "two writers in RC input byte 3"),
    ("demo", ('to = "drives.on" ', 'to = "READY_RCO" '), "db.10[D 0.0]", "RC output is read"),
    ("demo", ('to = "drives.on" ', 'to = "cell.ready" '), "db.10[D 0.0]", "only read"),
    ("demo", ('to = "move.A1.target",   unit', 'to = "move.A7.target",   unit'), "db.10[DW 2]", "no such axis; there is A1"),
    ("demo", ('to = "move.A1.target",   unit', 'to = "move.*.target",   unit'), "db.10[DW 2]", "one address holds one axis"),
    ("demo", ('to = "move.A1.target",   unit = "0.1 mm"', 'to = "move.A1.target",   unit = "0.1 deg"'), "db.10[DW 2]", "axis A1 is in mm"),
    ("demo", ('to = "move.A1.target",   unit = "0.1 mm"', 'to = "move.A1.target",   unit = "0.01 mm"'), "db.10[DW 2]", "-327.68..327.67"),
    ("demo", ('"DW 8",   type = "KF"', '"DW 8",   type = "KG"'), "db.10[DW 8]", "KG needs an address of DD"),
    ("demo", ('at = "D 0.8",  type = "bit", to', 'at = "DW 9",  type = "bit", to'), "db.10[DW 9]", "a bit has the address"),
    ("demo", ("min = 0, max = 100 }", "min = 0, max = 300 }"), "db.10[DR 1]", "cannot hold it"),
    ("demo", ('unit = "1 %", min = 1, max = 100', 'unit = "1 %", min = 100, max = 1'), "db.10[DW 8]", "below max"),
    ("demo", ('= "DB10.DW31"', '= "DB10.DW30"'), "line.plc1.supervision.life_word", 'at = "DW 30"'),
    ("demo", ('= "DB10.DW31"', '= "DB9.DW31"'), "line.plc1.supervision.life_word", "no such db"),
    ("demo", ('start    = "DB10.D0.8"', 'start    = "DB10.D0.9"'), "handshake.move.start", 'no entry at "D 0.9"'),
    ("demo", ('start    = "DB10.D0.8"', 'start    = "DB10.DW8"'), "handshake.move.start", "a bit of a data block"),
    ("demo", ('busy     = "DB11.D0.8"', 'busy     = "DB10.D0.8"'), "handshake.move.busy", 'writer = "plc"'),
    ("demo", ('line    = "plc1"', 'line    = "plc9"'), "db.10.line", "did you mean plc1?"),
    ("demo", ("number  = 11", "number  = 10"), "db.10.number", "is defined twice"),
    ("demo", ('name           = "plc2"', 'name           = "plc1"'), "modbus.plc1.name", "is used twice"),
    ("demo", ('name   = "A2" ', 'name   = "A1" '), "axis.A1.name", "is used twice"),
    ("demo", ("module = 2,", "module = 1,"), "axis.A2.drive.module", "axis A1 has module 1"),
    ("demo", ('axes     = "1..6"', 'axes     = "1..5"'), "axis.A6.drive.module", '"1..5"'),
    ("demo", ('protocol = "servodyn"', 'protocol = "canopen"'), "axis.A1.drive.type", 'needs protocol = "servodyn"'),
    ("demo", ('bus = "drives", module = 1', 'bus = "drive", module = 1'), "axis.A1.drive.bus", "did you mean drives?"),
    ("demo", ("cycle_ms = 4 ", 'bitrate = "500 kbit/s"\ncycle_ms = 4 '), "bus.drives.bitrate", "1 Mbit/s"),
    ("demo", ('"servodyn_gc.dbc"', '"other.dbc"'), "bus.drives.layout", "looked for"),
    ("demo", ("min = -5.0, max = 1500.0", "min = 1500.0, max = -5.0"), "axis.A1.limits.min", "below max"),
    ("demo", ("warn = 12.5, trip = 16.0", "warn = 17, trip = 16.0"), "axis.A1.following_error.warn", "at most trip"),
    ("demo", ("mode = 0, speed = 100.0", "mode = 0, speed = 900.0"), "axis.A1.home.speed", "faster than the axis"),
    ("demo", ("slow_speed = 20.0", "slow_speed = 200.0"), "axis.A1.home.slow_speed", "P109"),
    ("demo", ("offset = 10.0", "offset = -10.0"), "axis.A1.home.offset", "outside the limits"),
    ("demo", ("from = -20.0, to = 10.0", "from = 10.0, to = -20.0"), "plant.axis.A1.reference_switch", "below to"),
    ("demo", ("from = -20.0, to = 10.0", "from = 200.0, to = 210.0"), "plant.axis.A1.start", "never reaches the switch"),
    ("demo", ("[plant.axis.A6]", "[plant.axis.A9]"), "plant.axis.A9", "no such axis"),
    ("demo", ('owner = { "3" = "plc2" }', 'owner = { "3" = "plc3" }'), "rc_inputs.owner", "did you mean plc"),
    ("demo", ('owner = { "3" = "plc2" }', 'assume = ["FEED_ALOW_RCI"]'), "rc_inputs.assume", "did you mean FEED_ALLOW_RCI?"),
    ("demo", ('profile  = "rho3"', 'profile  = "rho"'), "line.plc1.profile", "did you mean rho3?"),
    ("demo", ('format   = "9600 8E1"', 'format   = "9600 7E1"'), "line.plc1.format", "8 data bits"),
    ("demo", ('target           = "simulation"', 'target = "machine"'), "safety", "[safety]"),
    ("s5-rk512", ('target   = "simulation"', 'target   = "machine"'), "safety.sto_wired", 'target = "machine" needs it'),
    ("rho3-servodyn", ('target   = "simulation"', 'target   = "machine"'), "safety.guard", "needs it"),
    ("s5-rk512", ("{ X = 1250.0,", "{ X = 3250.0,"), "check_position.pin in fixture 1.at", "outside the axis' limits"),
    ("s5-rk512", ("input = 0 }", "output = 0 }"), "io.safety_ok.device", "is already this contact"),
    ("s5-rk512", ("node = 2, eds", "node = 1, eds"), "axis.Y.drive.node", "axis X has node 1"),
    ("s5-rk512", ('home        = { by = "drive", method = 4,', 'home        = { by = "drive",'), "axis.X.home.method", "homing method"),
    (
        "s5-rk512",
        ("cycle_ms = 4", 'cycle_ms = 4\n[[bus]]\nname = "can1"\nport = "socketcan:can0"\nprotocol = "canopen"\n'),
        "bus.can1.port",
        "already",
    ),
    ("rho3-servodyn", ('protocol = "servodyn"', 'protocol = "servodyn"\ncycle_ms = 4'), "bus.drives.cycle_ms", "rho3.P5"),
    ("rho3-servodyn", ('protocol = "rho3-io"', 'protocol = "rho3-io"\nbitrate = "250 kbit/s"'), "bus.io.bitrate", "rho3.P30[2].baud"),
    ("rho3-servodyn", ("output = -2", "output = 2"), "rho3.P401.2.output", "both negative"),
    ("rho3-servodyn", ("module = 2\n", "module = 1\n"), "rho3.P401.2.module", "another axis"),
    (
        "rho3-servodyn",
        ("{ inputs = 0, outputs = 0, baud = 0 }", "{ inputs = 1, outputs = 0, baud = 0 }"),
        "rho3.P30",
        "6 axes on bus 1 leave 0 bytes",
    ),
    ("rho3-servodyn", ("length = 8, id = 542 } ]", "length = 8, id = 541 } ]"), "rho3.P31", "twice"),
    ("rho3-servodyn", ("start = 96, length = 8, id = 542", "start = 92, length = 8, id = 542"), "rho3.P31", "byte 92 belongs to block 1"),
    ("rho3-servodyn", ("output_timeout = -1", 'output_timeout = -1\npriority = "high"'), "line.V24_1.priority", "output_timeout"),
    ("rho3-servodyn", ('profile  = "rho3" ', 'profile  = "rho4" '), "line.V24_1.profile", "did you mean rho3?"),
]


@pytest.mark.parametrize(("name", "edit", "key", "said"), CROSS, ids=[f"{number}-{row[2]}" for number, row in enumerate(CROSS)])
def test_cross_faults(name: str, edit: tuple[str, str], key: str, said: str) -> None:
    faults = faults_of(edited(name, edit))
    assert [fault for fault in faults if fault.key == key and said in str(fault) and fault.kind == "cross"], "\n".join(map(str, faults))


def test_a_name_with_a_field_fault_stays_known() -> None:
    faults = faults_of(edited("demo", ("speed = 800.0, accel", "speed = -800.0, accel")))
    assert keys(faults) == ["axis.A1.limits.speed"]


def test_p_and_own_name_for_one_thing_are_both_named() -> None:
    text = edited("rho3-servodyn", ("[robot]", '[[axis]]\nname = "J1"\nunit = "deg"\nlimits = { speed = 99.0 }\n[robot]'))
    said = next(str(fault) for fault in faults_of(text) if fault.key == "axis.J1.limits.speed")
    assert "99" in said and "rho3.P103[1]" in said


# ------------------------------------------------------------------------------------------------------- warnings, notes


def levels(cell: Cell, where: str) -> list[str]:
    return [f"{notice.level} {notice.text}" for notice in cell.notices if notice.where == where]


def test_a_real_bus_without_evidence_is_listen_only() -> None:
    text = edited("demo", ('port     = "sim"                     # the broker', 'port     = "socketcan:can0" #'))
    assert any("listen-only" in said and said.startswith("warning") for said in levels(load_cell("c", text), "bus drives"))
    assert not any("listen-only" in said for said in levels(load_cell("demo"), "bus drives"))


@pytest.mark.parametrize(
    ("port", "words"),
    [
        ("slcan:/dev/serial/by-id/usb-canable-if00@1000000", ""),
        ("socketcand:can0?host=10.0.0.5&port=29536", ""),
        ("nosuch:0", "python-can has no interface 'nosuch'"),
        ("slcan:/dev/ttyACM0@500000", "opens it at 500000 bit/s, but bus.drives.bitrate = 1 Mbit/s"),
        ("slcan:/dev/ttyACM0?sleep", "an option is NAME=VALUE"),
        ("socketcan:can 0", "socketcan:can0 | broker:NAME"),
    ],
)
def test_a_bus_takes_an_adapter_of_python_can_and_what_is_wrong_with_it_is_reported(port: str, words: str) -> None:
    text = edited("demo", ('port     = "sim"                     # the broker', f'port     = "{port}" #'))
    faults = faults_of(text)
    assert keys(faults) == ([] if not words else ["bus.drives.port"])
    assert words in " ".join(map(str, faults))


def test_enabling_inputs_nobody_writes_are_reported() -> None:
    without = load_cell("c", edited("demo", ('owner = { "3" = "plc2" }', "")))
    assert any("feed_allow" in said and said.startswith("warning") for said in levels(without, "rc_inputs"))
    text = edited("demo", ('owner = { "3" = "plc2" }', 'assume = ["FEED_ALLOW_RCI"]'))
    said = levels(load_cell("c", text), "rc_inputs")
    assert "assumed as 1" in said[0] and "feed_allow" not in said[1] and "travel_allow" in said[1]
    assert levels(load_cell("demo"), "rc_inputs") == []


def test_a_lag_limit_below_v_over_kv_is_reported() -> None:
    text = edited("demo", ("warn = 12.5, trip = 16.0", "warn = 9.0, trip = 16.0"))
    assert any("speed / Kv = 10 mm" in said for said in levels(load_cell("c", text), "axis A1"))


def test_a_full_bus_and_a_short_silence_are_reported() -> None:
    text = edited("demo", ("cycle_ms = 4 ", "cycle_ms = 2 "), ("max_silence_ms = 1000", "max_silence_ms = 500"))
    cell = load_cell("c", text)
    assert any("(84 %): too full" in said for said in levels(cell, "bus drives"))
    assert any("three rounds" in said for said in levels(cell, "line plc1"))


@pytest.mark.parametrize(
    ("profile", "kind", "words"),
    [("rho3", "warning", 'profile = "rho3-tcp" adds 500 ms'), ("rho3-tcp", "note", "QVZ 1050 ms, ZVZ 720 ms")],
)
def test_a_line_behind_a_serial_server_is_reported_with_its_times_and_how_to_pack(profile: str, kind: str, words: str) -> None:
    edits = (
        ('port     = "sim"                     # a simulated', 'port     = "rfc2217://10.0.0.7:4001" #'),
        ('profile  = "rho3"', f'profile = "{profile}"'),
    )
    cell = load_cell("c", edited("demo", *edits))
    (found,) = [note for note in (*cell.warnings, *cell.notes) if "no delimiter character" in note.text]
    assert found.level == kind and words in found.text and not_playable(cell) == []


# ---------------------------------------------------------------------------------------------------------- files beside it


def portal_with(program: str, folder: pathlib.Path) -> str:
    cell = folder / "cell.toml"
    cell.write_text(edited("portal", ('file   = "portal-u-cycle"', f'file   = "{program}"')))
    return str(cell)


def test_a_program_that_is_not_there_is_reported_with_the_places_looked_in(tmp_path: pathlib.Path) -> None:
    with pytest.raises(CellFaults) as found:
        load_cell(portal_with("nowhere", tmp_path))
    assert keys(found.value.faults) == ["program.1.file"]
    assert f"no such file; looked for {tmp_path}/nowhere, {tmp_path}/nowhere.txt" in str(found.value.faults[0])


@pytest.mark.parametrize("name", ["own", "own.txt"])
def test_a_program_beside_the_cell_is_found_with_and_without_its_suffix(name: str, tmp_path: pathlib.Path) -> None:
    (tmp_path / "own.txt").write_text(read_text(find_config("portal-u-cycle", "programs")))
    assert load_cell(portal_with(name, tmp_path)).program[0].file == name


@pytest.mark.parametrize("name", names_in("cells"))
def test_no_shipped_cell_says_for_its_owner_what_the_plant_guarantees(name: str) -> None:
    safety = load_cell(name).safety
    assert safety is None or not any(getattr(safety, field) for field in safety.__slots__), safety
