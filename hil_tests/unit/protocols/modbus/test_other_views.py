"""AX-408: the pictures of a Reis and of a VAL 3 controller as Modbus units, over the controls themselves; each row of their map is true."""

import struct

import pytest

from gateway.assembly.modbus_views import join, view_of
from gateway.cell_file.load import CellFaults, load_cell
from gateway.checks.controller import trial
from gateway.files.find import find_config, read_text
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.image.records.cell import RC_BYTES, CellState, InputImage, Quality
from gateway.pure.modbus.other_views import ReisView, Val3View
from gateway.tools.address_map import modbus_sheets
from protocols.modbus.answering import answer
from protocols.modbus.view import ExceptionCode, Kind

DEMO = read_text(find_config("demo", "cells"))
MISSING, FAILED, VALUE = ExceptionCode.ILLEGAL_DATA_ADDRESS, ExceptionCode.SERVER_DEVICE_FAILURE, ExceptionCode.ILLEGAL_DATA_VALUE
COILS, DISCRETE, HOLDING, INPUT = Kind.COILS, Kind.DISCRETE_INPUTS, Kind.HOLDING_REGISTERS, Kind.INPUT_REGISTERS
KINDS = {"coil": COILS, "discrete input": DISCRETE, "holding register": HOLDING, "input register": INPUT}
REIS = """
[controller]
kind = "reis"
robot_only = [7]
"""
SPEED = "byte = 102\nsteps = 10\nmin = -20.0\nmax = 20.0\noutput = true"
VAL3 = """
[controller]
kind = "val3"
""" + "".join(
    f"""
[[controller.point]]
name = "{name}"
board = "B"
module = "M"
address = "%{name}"
{where}
"""
    for name, where in (
        ("start", "bit = 704"), ("open", "bit = 705"), ("foreign", "bit = 760"), ("lamp", "bit = 704\noutput = true"),
        ("level", "byte = 100\nsteps = 100\nmin = -10.0\nmax = 10.0"), ("speed", SPEED),
    )
)  # fmt: skip


def cell(more: str, view: str, *owned: int) -> Cell:
    """The demo with another control, whose picture PLC 2 has as unit 5."""
    text = DEMO.replace('owner = { "3" = "plc2"', 'owner = { "3" = "plc2"' + "".join(f', "{byte}" = "plc2"' for byte in owned))
    return load_cell("c.toml", text.replace("[[modbus]]", f'[[modbus]]\nunits = [ {{ unit = 5, view = "{view}" }} ]', 1) + more)


def second(view: str, at: int) -> str:
    """A server whose own register lies in the picture."""
    return f'[[modbus]]\nname = "b"\nbind = "127.0.0.1:1503"\nview = "{view}"\nregisters = [ {{ at = {at}, from = "cell.life" }} ]\n'


class Running:
    """The control of the cell, stepped as the services do, and its view."""

    def __init__(self, made: Cell) -> None:
        control = trial(made)
        assert control is not None and made.controller is not None
        self.control: Control = control
        self.inputs, self.steps = InputImage(), True
        owned = {octet for octet, owner in made.rc_inputs.owner.items() if owner == made.modbus[0].name}
        self.view = view_of(made.controller, self.inputs, owned, self.written, None, "ABCD")
        join(self.view, control)
        self.step()

    def written(self, octets: object) -> None:
        if self.steps:
            self.step()

    def step(self) -> None:
        self.inputs.quality[:] = bytes((Quality.GOOD,)) * RC_BYTES
        self.control.step(self.inputs, bytes(RC_BYTES), CellState(generation=1), 0)
        self.view.image.outputs = self.control.outputs


def reis() -> tuple[ReisView, ReisControl]:
    running = Running(cell(REIS, "reis", 88, 89, 127))
    assert isinstance(running.view, ReisView) and isinstance(running.control, ReisControl)
    return running.view, running.control


def val3() -> tuple[Val3View, Val3Control]:
    running = Running(cell(VAL3, "val3", 88, 100, 101))
    assert isinstance(running.view, Val3View) and isinstance(running.control, Val3Control)
    return running.view, running.control


@pytest.mark.parametrize(("more", "kind", "owned", "least"), [(REIS, "reis", (88, 89, 127), 2700), (VAL3, "val3", (88, 100, 101), 11)])
def test_every_row_of_the_map_is_true_of_the_picture(more: str, kind: str, owned: tuple[int, ...], least: int) -> None:
    made = cell(more, kind, *owned)
    running = Running(made)
    running.steps = False
    view, sheet = running.view, next(sheet for sheet in modbus_sheets(made) if "unit 5" in sheet.title)
    for table, address, _, size, type_, access, value, _ in sheet.rows:
        table_kind, at, count = KINDS[str(table)], int(str(address)), int(str(size))
        read = view.read_bits(table_kind, at, count) if type_ == "bit" else view.read_words(table_kind, at, count)
        assert not isinstance(read, ExceptionCode), (table, address)
        if table_kind is COILS:
            assert (view.write_bits(at, [False]) is None) is (access == "R/W"), (table, address, value)
        elif table_kind is HOLDING:
            assert (view.write_words(at, [0] * count) is None) is (access == "R/W"), (table, address, value)
        else:
            assert access == "R"
    assert len(sheet.rows) > least


def test_a_plc_gives_inputs_and_reads_outputs_and_elements_of_the_reis_over_modbus() -> None:
    view, control = reis()
    assert view.write_bits(9, [True, False, True]) is None, "E 1.1 and E 1.3"
    assert control.value("reis.ibin_in.1") == 0x0A00 and view.read_bits(COILS, 8, 4) == [False, True, False, True]
    assert view.write_words(0, [0x1234]) is None and control.value("reis.ibin_in.1") == 0x3412
    assert view.read_words(HOLDING, 0, 2) == [0x1234, 0]
    control.put("reis.output.39.7", 1.0)
    control.shared.end_of_cycle()
    view.image.outputs = control.outputs
    assert view.read_bits(DISCRETE, 318, 2) == [False, True] and view.read_words(INPUT, 19, 1) == [0x0080]
    assert view.write_bits(16, [True]) is MISSING, "byte 2 is another command source's" and view.write_words(0, [1, 1]) is MISSING
    assert view.read_bits(COILS, 319, 2) is MISSING and view.read_words(INPUT, 19, 2) is MISSING


def test_markers_are_bits_and_words_and_the_robots_stay_the_robots() -> None:
    view, control = reis()
    assert view.write_words(3000 + 50, [0x0708]) is None and control.flag_bytes()[100:102] == b"\x07\x08"
    assert view.read_words(INPUT, 3050, 1) == [0x0708] and view.read_bits(DISCRETE, 10_000 + 8 * 101 + 3, 1) == [True]
    assert view.write_bits(10_000 + 8 * 100 + 6, [True] * 4) is None and control.flag_bytes()[100:102] == b"\xc7\x0b"
    assert view.write_words(3000 + 472, [1]) is MISSING, "M944"
    before = view.read_bits(COILS, 10_000 + 8 * 1020, 16)
    assert view.write_bits(10_000 + 8 * 1020 + 7, [True]) is None
    after = view.read_bits(COILS, 10_000 + 8 * 1020, 16)
    assert not isinstance(before, ExceptionCode) and not isinstance(after, ExceptionCode)
    assert [n for n in range(16) if before[n] != after[n]] == [7], "hold motion is the PLC's, power-on beside it is not"
    assert view.read_words(HOLDING, 3000 + 1023, 2) is MISSING and view.write_bits(10_000 + 8 * 2048 - 1, [True, True]) is MISSING
    assert view.write_bits(10_000 + 8 * (2008 + 7), [True]) is MISSING, "output byte 7 belongs to the robot alone"
    assert answer(bytes.fromhex("0100010001"), view) == bytes.fromhex("010100")


def test_points_of_val3_are_counted_by_kind_and_show_their_state() -> None:
    view, control = val3()
    assert view.write_bits(0, [True, True]) is None and control.value("dio.start") == control.value("dio.open") == 1.0
    assert (
        view.read_bits(COILS, 0, 3) == [True, True, False]
        and view.write_bits(2, [True]) is MISSING
        and view.write_bits(3, [True]) is MISSING
    )
    control.put("dio.lamp", 1.0)
    control.put("aio.speed", -7.5)
    assert view.read_bits(DISCRETE, 0, 1) == [True] and view.read_bits(DISCRETE, 0, 2) is MISSING
    assert view.read_words(INPUT, 0, 2) == list(struct.unpack(">2H", struct.pack(">f", -7.5))) and view.read_words(INPUT, 1, 1) == [0]
    high, low = struct.unpack(">2H", struct.pack(">f", 3.14))
    assert view.write_words(0, [high, low]) is None and control.value("aio.level") == 3.14
    assert view.write_words(0, [high]) is MISSING is view.write_words(1, [low]) and view.write_words(0, [0x4130, 0]) is VALUE
    assert view.write_words(0, [0x7FC0, 0]) is VALUE and control.value("aio.level") == 3.14
    assert view.read_words(INPUT, 1000, 6) == [0] * 6
    control.put("dio.lamp.lock", 1.0)
    control.put("aio.level.simulate", 1.0)
    assert view.read_words(INPUT, 1000, 6) == [0, 0, 0, 1, 2, 0] and view.read_words(INPUT, 1006, 1) is MISSING
    assert view.read_words(HOLDING, 0, 2) == [0x3F80, 0], "the program sees the simulated value"


def test_a_board_in_fault_answers_04_and_its_states_say_why() -> None:
    running = Running(cell(VAL3, "val3", 88))
    control = running.control
    assert isinstance(control, Val3Control) and isinstance(running.view, Val3View)
    given = Val3Control(control.points.values(), {88})
    running.view.control = given
    given.step(InputImage(), bytes(RC_BYTES), CellState(), 0)
    assert running.view.read_bits(COILS, 0, 1) is FAILED is running.view.read_words(HOLDING, 0, 2)
    assert running.view.read_words(INPUT, 1000, 1) == [0x10000 - 3]
    running.view.control = None
    assert running.view.read_bits(COILS, 0, 1) is FAILED and running.view.read_words(INPUT, 1000, 1) is MISSING


@pytest.mark.parametrize(
    ("more", "view", "words"),
    [
        ("", "reis", 'kind = "reis"'),
        (VAL3, "reis", 'kind = "reis"'),
        (REIS, "val3", 'kind = "val3"'),
        (REIS + second("reis", 3100), "reis", "taken by the view reis"),
        (VAL3 + second("val3", 1005), "val3", "taken by the view val3"),
    ],
)
def test_a_picture_of_another_control_and_registers_in_its_place_are_refused(more: str, view: str, words: str) -> None:
    with pytest.raises(CellFaults) as found:
        cell(more, view)
    assert words in str(found.value)
