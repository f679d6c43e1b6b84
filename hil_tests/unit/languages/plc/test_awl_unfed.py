"""What the import reports of statements behind a line that it did not translate."""

from gateway.pure.languages.plc.awl.report import imported

UNFED = """OB 1
:L MW 10
:+ 1
:T MB 12
:L KF +3
:+F
:L KF +5
:L KF +6
:+F
:T MB 13
:L MW 20
:L MB 14
:><F
:L KF +1
:L KF +1
:!=F
:= A 1.0
:L MW 20
M001:T MB 15
:BE
"""


def test_statements_that_use_what_a_line_not_translated_would_have_loaded_are_named_with_their_lines() -> None:
    result = imported(UNFED)
    assert [each.line for each in result.refused] == [2, 11, 18]
    named = [note for note in result.notes if "not translated" in note]
    assert named == [
        f"line {line} (OB1): {text}: uses what line {missing} would have loaded, which is not translated"
        for line, text, missing in ((3, ":+ 1", 2), (4, ":T MB 12", 2), (6, ":+F", 2), (13, ":><F", 11))
    ]
