"""Results that STEP hands on past labels and divisions, and local bytes."""

import pytest

from gateway.pure.languages.plc.awl.report import imported
from hil_tests.unit.languages.plc.rig import Rig


@pytest.mark.parametrize(
    "lines",
    [
        "U E 0.0;SPB =M001;M001:NOP 0;= A 0.0",
        "U E 0.0;SPB =M001;L KB 7;T MB 9;M001:L KB 3;T MB 8;SPB =M002;UN A 0.7;S A 0.7;M002:NOP 0;= A 0.0",
        "U E 0.0;SPB =M001;M001:L KT 9.0;SV T 1;U T 1;= A 0.0",
    ],
)
def test_the_result_1_of_a_jump_not_taken_is_there_behind_the_label_and_what_leaves_it_alone(lines: str) -> None:
    """Both ways bring a 1 along (STEP 5: a conditional jump sets the result), past NOP, loads and transfers."""
    result = imported("\n".join(lines.split(";")))
    assert result.refused == []
    for high in ([], ["E0.0"]):
        assert Rig(sources=result.programs, start="OB1").scan(*high).outputs[0] == 1, high


DIVIDED = """FUNCTION FC 1 : VOID
BEGIN
L MB 10;
L 7;
MOD;
T MB 11;
L MB 10;
L L#7;
/D;
T LB 20;
L LB 20;
T MB 12;
U L 20.1;
= A 0.0;
END_FUNCTION
"""


def test_the_rest_of_a_division_and_local_bytes() -> None:
    result = imported(DIVIDED)
    assert result.refused == []
    rig = Rig(sources=result.programs, start="FC1")
    rig.plc.set_marker(10, 45)
    assert rig.scan().outputs[0] == 1 and (rig.plc.marker(11), rig.plc.marker(12)) == (3, 6)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("L MB 10;L 7;/D;TAK", "where STEP leaves the dividend"),
        ("L MB 10;L 7;MOD;T MB 9;+D", "where STEP leaves the dividend"),
        ("O ==0", "no condition bits"),
        ("U OV", "no condition bits"),
        ("UN BIE", "no condition bits"),
        ("L STW", "no condition bits"),
        ("LW =ZEIT", "no parameters"),
        ("SVZ =AUS", "no parameters"),
        ('CALL "Presse"', "operands by symbol"),
        ("T LW 20", "local words"),
    ],
)
def test_the_reason_of_a_line_is_its_own(line: str, reason: str) -> None:
    lines = "".join(f"{each};\n" for each in line.split(";"))
    (refused,) = imported(f"FUNCTION FC 1 : VOID\nBEGIN\n{lines}").refused
    assert reason in refused.reason


@pytest.mark.parametrize("second", ["O E 0.1", "O(;U E 0.1;)", "O;U E 0.1"])
def test_an_or_without_an_and_behind_it(second: str) -> None:
    """A single O in front of O, O( or another O joins nothing; the empty bracket it became kept the PLC from starting."""
    result = imported("\n".join(f"U E 0.0;O;{second};= A 0.0;BE".split(";")))
    assert result.refused == []
    rig = Rig(sources=result.programs, start="OB1")
    assert [rig.scan(*high).outputs[0] for high in ([], ["E0.0"], ["E0.1"])] == [0, 1, 1]


def test_a_block_of_the_list_is_called_by_its_symbol() -> None:
    block = 'FUNCTION "Presse 1" : VOID\nBEGIN\nU E 0.0;\n= A 0.0;\nEND_FUNCTION\n'
    result = imported(f'{block}ORGANIZATION_BLOCK OB 1\nBEGIN\nCALL "Presse 1";\nEND_ORGANIZATION_BLOCK\n')
    assert result.refused == [] and list(result.programs) == ["PRESSE1", "OB1"]
    assert Rig(sources=result.programs, start="OB1").scan("E0.0").outputs[0] == 1


def test_rows_of_a_data_block_are_named_with_its_head_and_a_bit_gets_a_bit() -> None:
    rows = "DB 10                LAE=12\n0:         KH = 0000;\n1:         KT = 050.1;\n\n"
    text = f"{rows}PB 1\n0000      :A   DB 10\n0001      :U   D   2.3\n0002      :BE"
    assert [(each.line, each.reason.partition(";")[0]) for each in imported(text).refused] == [
        (1, "the integrated PLC has no data blocks"),
        (7, "DB10.D2.3 has no marker"),
    ]
    assert imported(text).refused[1].reason.endswith("DB10.D2.3 = M200.1")
