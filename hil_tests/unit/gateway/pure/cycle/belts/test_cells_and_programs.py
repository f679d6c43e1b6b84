"""[[belt]] of the cell file and belts in the text of programs: what is legal, and how the rest is refused."""

import pytest

from gateway.assembly.plant import belt_settings
from gateway.cell_file.load import CellFaults, load_cell
from hil_tests.lab.virtual.belt_bench import HEAD, TEXT
from motion.program.blocks import OnBelt
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write

PART = "synchron B3 at=50mm\nlinear pose 200 150 50 0 0 0 belt=200mm camin=30mm camout=70mm\nsynchron_end\n"


def test_a_cells_belts_are_read_whole() -> None:
    cell = load_cell("belts.toml", TEXT)
    assert [(belt.name, belt.type, belt.id, belt.unit) for belt in cell.belt] == [(f"B{n}", n, 0x1F0 + n, "mm") for n in (1, 2, 3)]
    assert '"identifier": 497' in belt_settings(cell, "drives")


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("increment = 0.1", "increment = 0.0", "belt.B1.increment"),
        ("increment = 0.1", "increment = 1000.0", "-100.0..100.0 mm or deg"),
        ('bus = "drives"', 'bus = "nobody"', "no such bus"),
        ("id = 497", "id = 498", "is taken by SYNC, a drive or another belt"),
        ("id = 497", "id = 210", "is taken by SYNC, a drive or another belt"),
        ('name = "B1"', 'name = "B2"', "another belt has this name"),
        ("type = 1\n", "type = 4\n", "belt.B1.type"),
        ("type = 1\n", "type = 1\nbyte = 6\n", "0..4"),
        ("type = 1\n", "type = 1\nfactors = [0.0, 0.0, 0.0]\n", "a belt with factors 0 moves nothing"),
        ("type = 1\n", "type = 1\ntolerance = 13\n", "1..12 interpolation cycles"),
        ("[plant.belt.B1]", "[plant.belt.B9]", "no such belt; there is B1, B2, B3"),
    ],
)
def test_a_wrong_belt_is_refused_with_key_and_range(before: str, after: str, says: str) -> None:
    assert before in TEXT
    with pytest.raises(CellFaults) as caught:
        load_cell("belts.toml", TEXT.replace(before, after, 1))
    assert says in str(caught.value)


def test_a_part_of_a_program_reads_back_as_it_was_written() -> None:
    program = read(HEAD + PART + "linear pose 100 100 50 0 0 0\n" + PART)
    first, between, second = program.blocks
    assert first.synchron is not None and (first.synchron.belt, first.synchron.at) == ("B3", 0.05)
    assert first.on_belt == OnBelt(0.2, 0.03, 0.07) and between.synchron is None
    assert second.synchron is not None and second.synchron != first.synchron, "two parts on one belt are two"
    assert read(write(program, "rho3")).blocks == program.blocks


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ("linear pose 200 150 50 0 0 0 belt=200mm", "line 5: belt: is allowed in a synchronous part only"),
        ("synchron_end", "line 5: synchron_end: ends no synchronous part"),
        ("synchron B1\nsynchron B2", "line 6: synchron: the part on belt B1 is not ended"),
        ("synchron B1 at=5", "line 5: at: '5': a number with mm or deg"),
        ("synchron B1 to=5mm", "line 5: to: synchron accepts only at="),
        ("synchron B1\nlinear pose 200 150 50 0 0 0 camin=3mm", "line 6: camin: needs the block's value of the belt"),
        ("set belt=3mm", "line 5: belt: acts on one block only"),
    ],
)
def test_what_does_not_belong_there_is_reported_by_its_line(lines: str, says: str) -> None:
    with pytest.raises(TextFaults) as caught:
        read(HEAD + lines + "\n")
    assert says in str(caught.value)
