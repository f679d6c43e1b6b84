"""Statement lists read from a print: what cannot be a statement is put right and named, nothing is lost in silence (AX-1830)."""

import pathlib

import pytest

from gateway.commands.plc import main
from gateway.pure.languages.plc.awl.report import imported

PRINT = """0B 1                                     LAE=34
0000      :SPA PB  1O
0001      :U(
0002      :O   E   l.2
0003      :ON  E   O.3
0004      :)
0005      ;=   A   4.O
0006       U   E   0,4
0007      :L   KT  1OO.1
0009      :SE  T   I
000A      :SPB =MOO1
000B      :L   KF  +I5
000D      :T   M8  2O
000E M001 :8E
P8 10
0000      :0   M   30.1
0001      :5   A   1.0
0002      :BE
"""
MEANT = "PLC OB1\nSU PB10\nU(\nO E1.2\nON E0.3\n)\n= A4.0\nU E0.4\nL 1000\nST E,T1\nSP M001,1\n"
MEANT += "L 15\nT M20\nO M0.0\nON M0.0\nM M001\nSP _END\nM _END\nEND\n"


def test_misread_letters_of_a_print_are_put_right_and_each_change_is_named() -> None:
    result = imported(PRINT)
    assert result.refused == [] and result.missing == []
    assert result.programs == {"OB1": MEANT, "PB10": "PLC PB10\nO M30.1\nS A1.0\nEND\n"}
    named = [int(note.split(":")[0].removeprefix("line ")) for note in result.notes if " is read as " in note]
    assert sorted(named) == [1, 2, 4, 5, 7, 7, 8, 8, *range(9, 18)]
    assert "line 4: 'O   E   l.2' is read as 'O E 1.2'" in result.notes


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("PB 1\n:U(\n:O E ?.2\n:O E 0.1\n:)\n:= A 0.0\n:BE", 3),  # once a single O with a comment
        ("PB 1\n0000 :U E 0.0   0010 :U E 1.0\n0001 :UN E 0.1\n0002 :BE", 2),  # two columns
        ("PB 1\n:U E 0.0 = A 0.0\n:BE", 2),
        ("PB 1\nU E 0.0 ;= A0.0\nU E 0.1 ; lamp = A0.1\nBE", 2),  # a second statement was taken as a comment
        ("PB 1\n:U(\n:O E 0.0\n:O (E 0.1\n:)\n:= A 0.0\n:BE", 4),  # the same: its operand was dropped without a word
        ("PB 1\n:U( E 0.0\n:U E 0.1\n:)\n:= A 0.0\n:BE", 2),
        ("PB 1\n:U(\n:U E 0.1\n:= A 0.0\n:BE", 2),  # not closed
    ],
)
def test_what_cannot_be_one_statement_is_refused_with_its_line(text: str, line: int) -> None:
    assert [each.line for each in imported(text).refused] == [line]


def test_labels_of_the_letters_a_to_f_are_no_addresses() -> None:
    result = imported("FUNCTION FC 1 : VOID\nBEGIN\nU E 0.0;\nSPB ADD1;\nSPA FACE;\nADD1: INC 1;\nFACE: NOP 0;\nEND_FUNCTION")
    assert result.refused == []
    assert result.programs["FC1"].count("M ADD1\n") == result.programs["FC1"].count("M FACE\n") == 1


def test_a_block_that_is_called_and_nowhere_is_a_finding_until_it_is_in_the_folder(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, two = tmp_path / "one.txt", tmp_path / "two.txt"
    one.write_text("OB 1\n:SPA PB 8\n:BE\n")
    two.write_text("PB 8\n:U E 0.0\n:= A 0.0\n:BE\n")
    assert main(["import", str(one), "--to", str(tmp_path / "a")]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "PB8 is called in OB1 and is not in the list; import it too, or write it"
    assert main(["import", str(two), "--to", str(tmp_path / "b")]) == 0
    assert main(["import", str(one), "--to", str(tmp_path / "b")]) == 0


def test_a_line_that_is_not_translated_keeps_its_label_and_its_reason() -> None:
    result = imported("PB 1\n:U E 0.0\n:SPB =M1\nM1 :SS T 1\n:L KT 5\n:SE T 2\n:A DB 5\n:L DBB 7\nX :E 1.0\n:BE")
    assert "M M1\nNOT_TRANSLATED M1 :SS T 1 ; line 4: the integrated PLC has no latching" in result.programs["PB1"]
    assert "NOT_TRANSLATED X :E 1.0 ; line 9: subprograms of the integrated PLC have no parameters" in result.programs["PB1"]
    reasons = {each.line: each.reason for each in result.refused}
    assert reasons[5] == "KT 5: a time has up to three digits, a point and a time base from 0 to 3 (KT 050.1)"
    assert 6 not in reasons and "line 6 (PB1): :SE T 2: uses what line 5 would have loaded, which is not translated" in result.notes
    assert imported("PB 1\n:U E 0.0\n:O\nM1 :U 0E0.4\n:BE").programs["PB1"].startswith("PLC PB1\nU E0.0\nM M1\nNOT_TRANSLATED")
    assert reasons[8] == "DB5.DBB7 has no marker; give it one with --words: DB5.DBB7 = M200"  # once read as DB 87


def test_addresses_of_a_function_block_with_parameters_and_misread_ones() -> None:
    head = "NAME :VENTIL\nBEZ  :AUF       E/A/D/B/T/Z: E   BI/BY/W/D: BI\nBEZ  :ZU        E/A/D/B/T/Z: A   BI/BY/W/D: BI\n"
    call = "OB 1\n0000 :SPA FB 10\nNAME :VENTIL\nAUF  :    E 0.0\nZU   :    A 1.0\n0003 :BE"
    result = imported(f"FB 10\n{head}OOOO :U   E 0.0\n0001 :=   =ZU\n0002 :BE\n{call}")
    assert {each.line: each.reason.replace(" of the integrated PLC", "") for each in result.refused} == dict.fromkeys(
        (3, 4, 6, 11, 12), "subprograms have no parameters"
    )
    assert "\nU E0.0\n" in result.programs["FB10"] and "M OOOO" not in result.programs["FB10"]
    assert result.programs["OB1"].startswith("PLC OB1\nSU FB10\n")


def test_a_listing_with_addresses_and_without_colons() -> None:
    text = "STEP 5   ANLAGE 3    SEITE 1\nPB 7\n0000   U  E  0.0   -START  Taster\n0002   O  A  4.0\n0004   =  A  4.0  -M1\n0006   BE"
    result = imported(text)
    assert (result.refused, result.programs) == ([], {"PB7": "PLC PB7\nU E0.0\nO A4.0\n= A4.0\nEND\n"})
