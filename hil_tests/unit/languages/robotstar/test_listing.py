"""Import of printed listings, and texts that are no programs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.listing import PointFault, import_listing, points_of
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, OrderFault, orders
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.unit.languages.robotstar.memory import WORDS

TABLE = """| | | |
|-----|-----------|
| S1 | MPR | BEWEGUNG (INTERPOL) |
| S2 | WERKZEUG | T |
| S9 | POSITION | A |
| S10 | MARKÈ | WIEDERHOLE |
| S11 | POSITION | <start  point> |
"""


def test_a_printed_table_becomes_a_program() -> None:
    found = import_listing(TABLE, WORDS, points_of("name,X,Y,Z,A,B,C,A7\nA,1,2,3,0,0,0,\nstart point,4,5,6,0,0,90,7.5\n"))
    lines = [line.split(None, 1)[1] for line in found.files["BEWEGUNG.MPR"].splitlines()]
    assert lines == [
        'MPR "BEWEGUNG"',
        "WERKZEUG T",
        "POSITION #N, X:1, Y:2, Z:3, A:0, B:0, C:0",
        "MARKE WIEDERHOLE",
        "POSITION #N, X:4, Y:5, Z:6, A:0, B:0, C:90, A7:7.5",
        "END",
    ]
    assert [(note.line, note.text) for note in found.notes] == [
        (5, "steps 3 to 8 are not printed"),
        (6, "MARKÈ is read as MARKE"),
        (7, "BEWEGUNG: END is not printed; it is added"),
    ]


def test_points_that_are_missing_are_named() -> None:
    found = import_listing(TABLE, WORDS)
    assert "POSITION A: the values are not printed; give them with --points" in [note.text for note in found.notes]
    assert "POSITION A" in found.files["BEWEGUNG.MPR"]


def test_marks_of_the_cursor_words_in_two_parts_and_positions_of_a_kind() -> None:
    found = import_listing(
        "1 MPR M\n->2 PTP GESCHW 50\n-3 SCHR BIT #AUSGANG, 1, 0, 4\n4 POSITION #P, Q\n5 POSITION #N\n6 END", WORDS, {"Q": "A7:1"}
    )
    lines = [line.split(None, 1)[1] for line in found.files["M.MPR"].splitlines()]
    assert lines[1:5] == ["PTP_GESCHW 50", "SCHR_BIT #AUSGANG, 1, 0, 4", "POSITION #P, A7:1", "POSITION #N"]
    assert [(note.line, note.text) for note in found.notes] == [
        (5, "POSITION without a name: the values are not printed; give them with --points")
    ]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "X,Y\n1,2",
        "name,X,Q\na,1,2",
        "name,X,Y,Z,A,B,C\na,1,2,3,4,5,x",
        "name,X\na,1,2",
        "name,X,Y\na,1,2",
        "name,X,Y,Z,A,B,C\na,1,2,3,4,,6",
    ],
)
def test_a_table_of_points_that_is_none(text: str) -> None:
    with pytest.raises(PointFault):
        points_of(text)


@pytest.mark.parametrize(
    "text", ["", "START", "1", "x START", "1 E40.0=1", "1 E0.8=1", "1 M20=256", "1 EA2=11", "1 DRIVES", "1 JUMP", "1 E0.1=2"]
)
def test_orders_that_are_none(text: str) -> None:
    with pytest.raises(OrderFault):
        orders([text])


NAMED = (*WORDS.words, *(f"#{name}" for name in WORDS.equates), *(f"{name}:" for name in WORDS.descriptors))
OPERANDS = ("I1", "V1.X", "T", "P1", "S1(5)", "I_A[3]", "I_A[I1]", "_SPS[1]", "12", "0FH", "1B", "2.5", "-1", "<x>", "#=", "#=1", "X:1")
_PARTS = st.sampled_from(("1 ", "\\", ",", " ", '"', "[", "]", "(", ":", "\n", *NAMED, *OPERANDS))


@given(st.lists(_PARTS, max_size=60).map("".join) | st.text(max_size=200))
def test_no_text_is_an_exception(text: str) -> None:
    """Whatever a file holds: faults, or a run that ends with a message."""
    faults = Faults()
    frame = "\n".join(["MPR P", "VAR I1", "VAR V1", "VAR P1", "VAR I_A[3]", text, "END"])
    memory = Memory.read([Source("P.MPR", frame), Source("Q.SPR", text)], WORDS, faults)
    cell = VirtualCell(memory, MODES["test2"])
    check(memory, faults, cell.system.names())
    cell.run([], NS, "P")
    assert cell.end("P")["state"] in ("running", "waiting", "stopped", "error")
    import_listing(text, WORDS)
