"""Statement lists of STEP 5 and STEP 7 run as the list says."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.languages.plc.awl.report import Imported, imported
from hil_tests.unit.languages.plc.rig import Rig

LISTING = """OB 1                           C:TESTST.S5D                    LAE=14   ABS
                                                              BLATT    1
SEGMENT 1         0000   Hauptprogramm
0000      :U    E    0.0         Start
0001      :U    E    0.1
0002      :O
0003      :U    E    0.2
0004      :UN   E    0.3
0005      :=    A    1.0         Lampe
0006      :L    KT 100.1
0007      :SE   T    1
0008      :U    T    1
0009      :=    A    1.1
000A      :U    E    0.4
000B      :SPB  FB   3
000C NAME :ANLAUF
000D      :U    E    0.5
000E      :SPB  =M001
000F      :=    A    1.2
0010 M001 :NOP 0
0011      :L    KF +7
0012      :L    MB 10
0013      :>F
0014      :=    A    1.3
0015      :***
0016      :BE

FB 3                           C:TESTST.S5D                    LAE=14
NAME :ANLAUF
0005      :U    M    1.0
0006      :BEB
0007      :S    M    1.1
0008      :BE
"""
SOURCE = """ORGANIZATION_BLOCK OB 1
TITLE = Main
VERSION : 0.1
VAR_TEMP
  OB1_EV_CLASS : BYTE ;
END_VAR
BEGIN
NETWORK
TITLE =
      U(    ;
      O     E      0.0;
      O     E      0.1;
      )     ;
      UN    E      0.2; // comment
      =     A      0.0;
      SPBN  NEXT;
      L     S5T#2S;
      SE    T      2;
NEXT: U     T      2;
      =     A      0.1;
      CALL  FC     1 ;
      SET   ;
      S     M      5.0;
      U     E      0.3;
      FP    M      7.0;
      =     A      0.2;
      U     E      0.3;
      FN    M      7.1;
      =     A      0.3;
      U     E      0.4;
      NOT   ;
      =     A      0.4;
END_ORGANIZATION_BLOCK
FUNCTION FC 1 : VOID
BEGIN
      L     W#16#FF;
      T     MB    20;
END_FUNCTION
"""


def rig_of(text: str, table: str = "", start: str = "OB1") -> Rig:
    result = imported(text, table)
    assert result.refused == []
    rig = Rig(sources=result.programs, start=start)
    assert rig.refused == []
    return rig


def test_a_listing_of_step_5_runs() -> None:
    rig = rig_of(LISTING)
    assert [bool(rig.scan(*high.split()).outputs[1] & 1) for high in ("E0.0", "E0.0 E0.1", "E0.2", "E0.2 E0.3", "E0.0 E0.1 E0.3")] == [
        False,
        True,
        True,
        False,
        True,
    ]
    rig = rig_of(LISTING)
    seen = [bool(rig.scan("E0.2").outputs[1] & 2) for _ in range(1002)]
    assert seen == [False] * 1000 + [True] * 2
    assert rig.outputs[1] & 4  # the jump was not taken: STEP 5 sets the result to 1
    assert not rig.scan("E0.5").plc.data.memory[1] & 2
    assert rig.scan("E0.4").plc.bit(1, 1)
    rig.plc.set_marker(10, 6)
    assert rig.scan().outputs[1] & 8


def test_a_source_of_step_7_runs() -> None:
    rig = rig_of(SOURCE)
    assert (rig.scan("E0.1").outputs[0], rig.plc.marker(20), rig.plc.bit(5, 0)) == (0x11, 0xFF, True)
    assert rig.scan("E0.1", "E0.2").outputs[0] == 0x10
    assert [rig.scan(*high).outputs[0] & 12 for high in (["E0.3"], ["E0.3"], [], [], ["E0.3"])] == [4, 0, 8, 0, 4]
    assert rig.scan("E0.4").outputs[0] == 0x00 or rig.outputs[0] & 0x10 == 0
    rig = rig_of(SOURCE)
    assert [bool(rig.scan("E0.0").outputs[0] & 2) for _ in range(202)] == [False] * 200 + [True] * 2


def test_english_mnemonics() -> None:
    rig = rig_of("A I 0.0\nAN I 0.1\n= Q 0.0\nL KT 5.2\nA I 0.2\nSD T 1\nA T 1\n= Q 0.1\nCU C 3\nA C 3\n= Q 0.2\nBEU\n= Q 0.3\nBE")
    assert rig.scan("E0.0", "E0.2").outputs[0] == 1
    assert rig.scan("E0.2", ticks=500).outputs[0] == 0
    assert rig.scan("E0.2").outputs[0] == 2 + 4


def test_flags_of_an_english_list_of_step_5_are_markers() -> None:
    first = "OB 1\nA F 5.0\nAN F 5.1\nS F 6.0\nL FY 10\nT FY 11\nL FW 20\nT QW 4\nA I 0.0\nFP F 511.0\nA I 0.1\n= F 7.0\nJU FB 3\nBE"
    text = f"{first}\nFB 3\nO F 6.0\n= Q 0.0\nBE"
    rig = rig_of(text, "FW20 = M100\nQW4 = M104")
    for marker, value in ((5, 1), (10, 77), (100, 9)):
        rig.plc.set_marker(marker, value)
    assert rig.scan("E0.0", "E0.1").output("A0.0") and rig.plc.bit(6, 0) and rig.plc.bit(7, 0)
    assert (rig.plc.marker(11), rig.plc.marker(104)) == (77, 9)
    assert rig.plc.marker(511) == 1 and rig.plc.marker(510)  # the auxiliary byte is one that no flag uses


def test_words_of_16_bits_with_a_sign() -> None:
    same = "L KH FFFF\nL KF -1\n!=F\n= A 0.0\nL KF -1\nSRW 4\nL KH 0FFF\n!=F\n= A 0.1\nL KM 11111111 00000000\nL KF 0\n<F\n= A 0.2\n"
    rig = rig_of(f"OB 1\n{same}L KH F0F0\nSRW 12\nT AB 1\nL KH F0F0\nSRW 0\nT AB 2\nBE")
    assert rig.scan().outputs[:3] == bytes((7, 0x0F, 0xF0))
    notes = imported("FUNCTION FC 1 : VOID\nBEGIN\nL W#16#FFFF;\nL MB 5;\n>I;\n= A 0.0;\nEND_FUNCTION").notes
    assert any("lines 3" in note for note in notes)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("SS T 1", "latching"),
        ("L MW 10", "byte order of words"),
        ("T AW 2", "byte order of words"),
        ("B MW 10", "indirect"),
        ("LC Z 1", "cannot be loaded"),
        ("SPZ =M001", "condition bits"),
        ("U E 40.0", "outside 0..39"),
        ("U T 40", "outside 0..31"),
        ("U M 600.0", "system markers"),
        ("L DW 5", "--words: DW5 = M200"),
        ("SE T 1", "L KT"),
        ("S Z 1", "L KZ"),
        ('U "START"', "symbol"),
        ("STP", "cannot stop"),
        ("L PY 64", "peripheral"),
        ("L KG +1234567+01", "neither a constant"),
        ("GIBBERISH 1", "has no GIBBERISH"),
        ("SPB =M001", "no label M001"),
        ("SU M 10.0", "by the result only"),
        ("P M 10.1", "tested with U or UN"),
        ("E DB 5", "no data blocks"),
        ("SAVE", "no bit BIE"),
        ("POP", "two accumulators"),
        ("MCRA", "no master control relay"),
        ("LOOP M001", "by a number"),
        ("SVW 3", "fill with 0"),
        ("SSI 3", "fill with 0"),
        ("ITD", "32 bits"),
        ("+R", "no real numbers"),
        ("O =EIN", "parameters"),
        ("O E 41.0", "outside 0..39"),
        ("CALL PUMP", "a block is needed"),
        ("EIN :  E 1.0", "parameters"),
        ("BEZ :EIN E/A/D/B/T/Z: E BI/BY/W/D: BI", "parameters"),
        ("DECL :EIN I/Q/D/B/T/C: I BI/BY/W/D: BI", "parameters"),
        ("SPA FB [MW 20]", "indirect"),
        ("U E [AR1,P#0.0]", "indirect"),
        ("L MB [MD 10]", "indirect"),
        ("L P#20.0", "indirect"),
        ("LAR1", "indirect"),
        ("ADD KF +300", "from -255 to 255"),
    ],
)
def test_what_has_no_counterpart_is_named_and_keeps_the_program_from_starting(line: str, reason: str) -> None:
    result = imported(f"OB 1\n:U E 0.0\n{'' if ' :' in line else ':'}{line}\n:= A 0.0\n:BE")
    (refused,) = result.refused
    assert (refused.line, refused.block) == (3, "OB1")
    assert reason in refused.reason
    assert Rig(sources=result.programs, start="OB1").refused == ["No PLC-command"]


def test_data_words_get_markers_by_a_table() -> None:
    rig = rig_of(
        "OB 1\n:A DB 10\n:L KF -3\n:T DW 5\n:L DW 5\n:L KF +2\n:<F\n:= D 6.1\n:U D 6.1\n:= A 0.0\n:L KH 00FF\n:T MW 20\n:BE",
        "DB10.DW5 = M200  # level\nDB10.D6.1 = M210.1\nMW20 = M300\n",
    ).scan()
    assert (rig.plc.number(200), rig.plc.bit(210, 1), rig.outputs[0], rig.plc.number(300)) == (-3, True, 1, 255)


@pytest.mark.parametrize(
    ("constant", "value"),
    [
        ("KF -5", -5), ("KH 1F", 31), ("KM 00000000 00000101", 5), ("KY 1,2", 258), ("KB 7", 7), ("KZ 50", 50),
        ("KT 5.0", 5), ("KT 20.3", 20000),
        ("KH FFFF", -1), ("KM 10000000 00000000", -32768), ("KY 255,254", -2),
        ("W#16#FFFF", 65535), ("2#1010", 10), ("L#-70000", -70000), ("C#9", 9), ("S5T#1M30S", 9000), ("12", 12),
    ],
)  # fmt: skip
def test_constants(constant: str, value: int) -> None:
    assert rig_of(f"OB 1\n:L {constant}\n:BE" if "#" not in constant else f"BEGIN\nL {constant};\nEND_FUNCTION").refused == []
    text = imported(f"L {constant}\nBE").programs["OB1"]
    assert f"L {value}\n" in text


def test_a_single_or_may_have_a_comment() -> None:
    rig = rig_of("OB 1\n:U E 0.0\n:O     oder\n:U E 0.1   Taster (links)\n:SPB PB 1  (Presse)\n:BE\nPB 1\n:UN M 5.0\n:S A 0.0\n:BE")
    assert [rig.scan(*high).outputs[0] for high in ([], ["E0.1"])] == [0, 1]


def test_an_inverted_bracket() -> None:
    rig = rig_of("U E 0.0\nUN(\nU E 0.1\nO E 0.2\n)\n= A 0.0\nBE")
    assert [rig.scan(*high).outputs[0] for high in (["E0.0"], ["E0.0", "E0.1"], ["E0.0", "E0.2"], [])] == [1, 0, 0, 0]


def test_a_single_or_in_a_bracket_and_two_in_a_row() -> None:
    rig = rig_of("U E 0.0\nU(\nU E 0.1\nO\nU E 0.2\nU E 0.3\nO\nU E 0.4\n)\n= A 0.0\nBE")
    highs = (["E0.0", "E0.1"], ["E0.0", "E0.2"], ["E0.0", "E0.2", "E0.3"], ["E0.0", "E0.4"], ["E0.4"])
    assert [rig.scan(*high).outputs[0] for high in highs] == [1, 0, 1, 1, 0]


def test_a_call_that_is_not_taken_leaves_the_result_1_as_in_step_5() -> None:
    text = "OB 1\n:U E 0.0\n:SPB PB 2\n:= A 0.0\n:BE\nPB 2\n:U E 0.1\n:= M 1.0\n:BE"
    rig = rig_of(text)
    assert [rig.scan(*high).outputs[0] for high in ([], ["E0.0"], ["E0.0", "E0.1"])] == [1, 0, 1]


def test_the_result_1_of_a_jump_not_taken_goes_into_the_label_behind_it() -> None:
    """Both ways into the label bring a 1: A 0.1 is set and BEB leaves, whatever E 0.0 is."""
    rig = rig_of("OB 1\n:U E 0.0\n:SPB =M001\nM001:= A 0.1\n:U E 0.0\n:SPB =M002\nM002:BEB\n:UN M 5.0\n:= A 0.0\n:BE")
    assert [rig.scan(*high).outputs[0] for high in ([], ["E0.0"])] == [2, 2]


def test_missing_blocks_and_other_organisation_blocks_are_noted() -> None:
    result = imported("OB 1\n:SPA PB 7\n:BE\nOB 21\n:SPA PB 7\n:BE\nDB 10\n0: KH = 0000;")
    assert set(result.programs) == {"OB1", "OB21"}
    assert any("PB7" in note for note in result.notes)
    assert any("OB21" in note for note in result.notes)
    assert "data blocks" in result.refused[0].reason


ALPHABET = "UNOXELTSPMRDIHKAZFBW 0123456789.,;:()=<>+-\n\"'#"


@given(
    st.text(alphabet=ALPHABET, max_size=150)
    | st.lists(st.sampled_from(LISTING.splitlines() + SOURCE.splitlines()), max_size=30).map("\n".join)
)
def test_any_text_is_imported_or_named(text: str) -> None:
    result = imported(text, text)
    assert isinstance(result, Imported)
    for refused in result.refused:
        assert refused.reason
        assert refused.line <= len(text.splitlines())


def test_a_constant_loaded_between_an_edge_and_its_timer_leaves_the_edge_alone() -> None:
    statements = "U E 0.0;\nFP M 10.1;\nL S5T#1S;\nSV T 5;\nU T 5;\n= A 1.0;\n"
    result = imported(f"ORGANIZATION_BLOCK OB 1\nBEGIN\n{statements}END_ORGANIZATION_BLOCK\n")
    assert not result.refused
    rig = Rig(sources=result.programs, start="OB1")
    assert rig.scan("E0.0").output("A1.0"), "the edge starts it"
    assert not rig.scan("E0.0", ticks=200).scan("E0.0").output("A1.0"), "once"


@pytest.mark.parametrize("head", ["ORGANISATIONSBAUSTEIN OB 1   C:ANLAGEST.S5D", "BAUSTEIN#OB1", "OB 1"])
def test_every_printed_head_of_a_block_is_one(head: str) -> None:
    result = imported(f"{head}\n0000   :U E 0.0\n0001   := A 0.0\n0002   :BE\n")
    assert list(result.programs) == ["OB1"] and not result.refused


EDGES = """ORGANIZATION_BLOCK OB 1
BEGIN
      U     E      0.0;
      FP    M     20.0;
      U     E      0.1;
      =     A      0.0;
      U(    ;
      O     E      0.2;
      O     E      0.3;
      )     ;
      FN    M     20.1;
      O     E      0.4;
      =     A      0.1;
      U     E      0.6;
      U(    ;
      U     E      0.5;
      FP    M    511.0;
      )     ;
      S     A      0.2;
      U     E      0.7;
      FP    M     20.3;
      NOT   ;
      =     A      0.3;
END_ORGANIZATION_BLOCK
"""


def test_a_chain_goes_on_behind_an_edge() -> None:
    """FP and FN give their result to the link behind them: one scan, and only with it."""
    rig = rig_of(EDGES)
    assert imported(EDGES).notes == ["OB1: M510.0 and M510.1 are auxiliary bits of edges; no other program may use them"]
    first = ("", "E0.0 E0.1", "E0.0 E0.1", "", "E0.0", "E0.0 E0.1", "E0.2", "E0.2 E0.3", "E0.3", "", "")
    inputs = (*first, "E0.4", "E0.5", "E0.5 E0.6", "E0.6", "E0.5 E0.6", "E0.7", "E0.7")
    rest = 0b1000  # A0.3: NOT of an edge
    wanted = (0, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 4, 4 - rest, 4)
    assert [rig.scan(*high.split()).outputs[0] - rest for high in inputs] == list(wanted)


def test_an_edge_whose_result_a_jump_enters_is_refused() -> None:
    text = EDGES.replace("      U     E      0.1;", "MARK: U     E      0.1;")
    assert [(each.line, "a jump leads to the statement after FP" in each.reason) for each in imported(text).refused] == [(4, True)]


LADDER = """ORGANIZATION_BLOCK OB1
BEGIN
      AN    T      10;
      L     S5T#500MS;
      SE    T      10;
      A     I       0.0;
      =     L      20.0;
      A     L      20.0;
      A     I       0.1;
      JNB   _001;
      L     7;
      T     MB     10;
_001: NOP   0;
      A     L      20.0;
      BLD   102;
      =     Q       0.0;
      CALL  FC     1;
END_ORGANIZATION_BLOCK
FUNCTION FC 1 : VOID
BEGIN
      A     I       0.2;
      =     L      20.0;
      AN    L      20.0;
      =     Q       0.1;
END_FUNCTION
"""


def test_a_ladder_as_step_7_prints_it_runs_with_local_bits_and_english_times() -> None:
    rig = rig_of(LADDER)
    assert [note for note in imported(LADDER).notes if "local" in note] == [
        "OB1: local bits: LB20 = M510; no other program may use them",
        "FC1: local bits: LB20 = M509; no other program may use them",
    ]
    assert [rig.scan(*high.split()).outputs[0] for high in ("", "E0.0", "E0.0 E0.2", "E0.2")] == [2, 3, 1, 0]
    assert rig.plc.data.memory[10] == 0
    assert rig.scan("E0.0", "E0.1").plc.data.memory[10] == 7


COUNTED = """ORGANIZATION_BLOCK OB 1
BEGIN
      L     0;
      T     MB 50;
m001: L     MB 50;
      + 3;
      T     MB 50;
      + L#-2;
      T     MB 51;
      L     12;
      L     MB 50;
      >I;
      JC    m001;
      A     I      0.0;
      JCN   i1;
      =     Q      0.0;
i1:   NOP   0;
END_ORGANIZATION_BLOCK
"""


def test_english_labels_that_look_like_operands_and_constants_that_are_added() -> None:
    assert imported(COUNTED).statements == 15
    rig = rig_of(COUNTED)
    assert rig.scan("E0.0").outputs[0] == 1
    assert (rig.plc.marker(50), rig.plc.marker(51)) == (12, 10)


@pytest.mark.parametrize(
    ("lines", "outputs"),
    [
        ("U E 0.1;O E 0.2;SET;U E 0.0;= A 0.0", (0, 1)),
        ("U E 0.0;CLR;O E 0.0;= A 0.0", (0, 1)),
        ("CLR;L MB 20;U E 0.0;= A 0.0", (0, 1)),
        ("SET;SET;XN E 0.0;= A 0.0", (1, 0)),
        ("SET;NOT;= A 0.0;CLR;NOT;= A 0.1", (2, 2)),
        ("U E 0.0;U(;U E 0.1;SET;);= A 0.0;U E 0.0;O(;CLR;);= A 0.1", (0, 3)),
    ],
)
def test_set_and_clr_end_the_chain_in_front_of_them(lines: str, outputs: tuple[int, int]) -> None:
    """As in STEP 7: the next link loads its operand, whatever was linked before."""
    rig = rig_of("BEGIN\n" + "\n".join(f"{line};" for line in lines.split(";")))
    assert (rig.scan().outputs[0], rig.scan("E0.0").outputs[0]) == outputs


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("MW20 = M600", "table, line 1: MW20 = M600: M0 to M511 are free, and MW20 needs 4"),
        ("DB1.DW5 = M509", "table, line 1: DB1.DW5 = M509: M0 to M511 are free, and DB1.DW5 needs 4"),
        ("MW20 = M200\nMW22 = M203", "table, line 2: MW22 = M203 overlaps MW20 = M200, which uses M200 to M203"),
        ("MW20 = M200\nMW20 = M204", "table, line 2: MW20 is in the table twice"),
        ("DB1.D5.1 = M200", "table, line 1: DB1.D5.1 needs a bit, M200.1"),
        ("MW20 = M200.1", "table, line 1: MW20 needs a byte to begin at, M200"),
        ("DB1.DL5 = M511\nDB1.D5.1 = M0.1\nMW20 = M0", ""),
    ],
)
def test_a_row_of_the_table_that_cannot_count_is_named(rows: str, said: str) -> None:
    assert imported("OB 1\n:U E 0.0\n:= A 0.0\n:BE", rows).notes == ([said] if said else [])


def test_a_label_named_as_a_declaration_is_a_label() -> None:
    found = imported(
        "OB 1\n0000      :U    E    0.0         Start\n0001 BEZ  :U    E    0.1         Ein/Aus\n0002      :=    A    0.0\n0003      :BE",
        "",
    )
    assert found.refused == [] and "M BEZ\nU E0.1" in found.programs["OB1"]
