"""One declaration a record: packer, unpacker and hash come from the codes of its fields."""

import ast
import pathlib
import struct
from dataclasses import dataclass, fields
from typing import Annotated

import pytest

import gateway
from gateway.pure.image.records import alter, belts, inputs, planner, points
from gateway.pure.image.records import cell as cell_records
from gateway.pure.image.records.cell import AXIS, STATE, AxisState, CellState, Motion, pack_cell_state, unpack_cell_state
from gateway.pure.image.records.layout import U8, U16, Code, Layout, Yes
from motion.geometry.frames import Pose
from motion.program.blocks import Interpolation, Until
from motion.sync.alter import Reference
from motion.sync.alterable import AlterOrder
from motion.sync.belts import Type
from motion.sync.facts import SynchronOrder
from motion.sync.pace import Pace
from motion.sync.synchronous_part import BeltBlock

RECORDS = pathlib.Path(gateway.__file__).parent / "pure" / "image" / "records"
TURNED = Pose((1.0, 2.0, 3.0), (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0))


@dataclass
class Sample:
    small: U8
    word: Annotated[int, Code("H2x")]
    on: Yes
    name: Annotated[str, Code("4s", bytes.decode, str.encode)]
    pose: Annotated[tuple[float, ...], Code("3d")]
    text: str = ""


def test_codes_of_the_fields_make_the_struct_and_its_text() -> None:
    layout = Layout(Sample, "sample/1")
    assert (layout.names, layout.text) == (("small", "word", "on", "name", "pose"), "sample/1 =BH2x?4s3d")
    assert (layout.offset("on"), layout.code("word"), layout.size) == (5, "H2x", 34)


def test_a_record_comes_back_whole() -> None:
    layout = Layout(Sample)
    packed = layout.pack(Sample(1, 515, True, "fIn0", (0.5, -1.0, 2.0), "aside"))
    assert packed == struct.pack("=BH2x?4s3d", 1, 515, True, b"fIn0", 0.5, -1.0, 2.0)
    assert layout.unpack(packed, "again") == Sample(1, 515, True, "fIn0", (0.5, -1.0, 2.0), "again")


def test_a_number_beyond_its_code_is_refused() -> None:
    with pytest.raises(struct.error):
        Layout(Sample).pack(Sample(256, 0, False, "", (0.0, 0.0, 0.0)))


def test_packed_fields_come_first() -> None:
    @dataclass
    class Mixed:
        text: str
        number: U16

    with pytest.raises(TypeError, match="packed fields come before"):
        Layout(Mixed)


def test_the_state_of_the_cell_has_every_field_in_its_layout() -> None:
    assert [*STATE.names, "axes", "lanes"] == [field.name for field in fields(CellState)]
    assert [*AXIS.names] == [field.name for field in fields(AxisState)]
    assert cell_records.CELL_STATE_LAYOUT == "cell-state/2 =QqQBdQdQQHQBBBHQQQQQQQdddHIBBHBIQHQHQH axes x =dddddHHBHd"
    state = CellState(cycle=7, motion=Motion.STOPPING, ready=True, reason_4=65535, axes=[AxisState(actual=1.5, finding=647)])
    assert unpack_cell_state(pack_cell_state(state)) == state


def test_orders_of_motion_come_back_whole() -> None:
    altered = AlterOrder(Reference.TOOL, TURNED, 1.0, 2.0, 3.0, 4.0, 5.0, TURNED, Until(7, True), 9, 2)
    assert alter.alter_of(alter.alter_record(1, 2, altered)) == altered
    synchron = SynchronOrder(2, Type(1), 0.5, 0.25, 11, TURNED, 6, 1)
    assert belts.synchron_of(belts.synchron_record(1, 2, synchron)) == synchron
    block = BeltBlock((1.0, 2.0), 0.5, Interpolation.LINEAR, pace=Pace(1.0, 2.0, 3.0), first=0.1, third=0.2, via=(3.0,))
    assert belts.belt_block_of(belts.belt_block_record(1, 2, block)) == block
    flying = inputs.FlyingAt(3, 0.5, 610, 12, 3, False, 1)
    assert inputs.flying_of(inputs.flying_record(1, 2, flying)) == flying
    latch = points.LatchAt(3, 0.5, 12, 3, "fIn1")
    assert points.latch_of(points.latch_record(1, 2, latch)) == latch
    switch = planner.SwitchAt(3, 0.5, -1)
    assert planner.switch_of(planner.switch_record(1, 2, switch)) == switch


def test_no_second_list_of_names_and_no_format_string() -> None:
    """Beside layout.py no module of the records makes a struct of a text, but of codes of a layout."""
    made = [
        f"{path.name}:{node.lineno}"
        for path in sorted(RECORDS.glob("*.py"))
        if path.name != "layout.py"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "struct.Struct" and "codes" not in ast.unparse(node)
    ]
    assert made == []
