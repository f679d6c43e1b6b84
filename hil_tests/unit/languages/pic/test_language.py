"""Statements, instruction list, timers and counters of the PIC; faults in place."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from gateway.pure.languages.plc.state import TimeError
from hil_tests.unit.languages.pic.pics import Bench, faults_of

INPUTS = ("I88.0", "I88.1", "I88.2")


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("O58.0 = I88.0 AND NOT I88.1 OR I88.2", lambda a, b, c: (a and not b) or c),
        ("O58.0 = I88.0 AND (I88.1 OR I88.2)", lambda a, b, c: a and (b or c)),
        ("O58.0 = NOT (I88.0 OR I88.1 AND I88.2)", lambda a, b, c: not (a or (b and c))),
        ("O58.0 = NOT NOT I88.0 AND 1 OR 0", lambda a, b, c: a),
        ("IF (I88.0 = 1) AND I88.1 = 0 THEN O58.0 = 1 ELSE O58.0 = I88.2", lambda a, b, c: True if a and not b else c),
        ("IF I88.0 THEN IF I88.1 THEN O58.0 = 1 ELSE O58.0 = I88.2 ELSE O58.0 = 0", lambda a, b, c: a and (b or c)),
        ("IF I88.0 THEN BEGIN M40.0 = I88.1 O58.0 = M40.0 END ELSE O58.0 = I88.2", lambda a, b, c: b if a else c),
        ("WENN E88.0 UND NICHT E88.1 DANN A58.0 = 1 SONST A58.0 = E88.2", lambda a, b, c: True if a and not b else c),
        ("A I88.0 O I88.1 A I88.2 = O58.0", lambda a, b, c: (a or b) and c),
        ("A I88.0 A( ON I88.1 O I88.2 ) = O58.0", lambda a, b, c: a and (not b or c)),
        ("U E88.0 O( U E88.1 UN E88.2 ) = A58.0", lambda a, b, c: a or (b and not c)),
        ("AN I88.0 JC OUT O58.0 = I88.1 EP OUT: O58.0 = I88.2", lambda a, b, c: b if a else c),
    ],
)
def test_every_row_of_the_truth_table(text: str, meant: object) -> None:
    assert callable(meant)
    bench = Bench(text)
    for values in itertools.product((False, True), repeat=3):
        for name, value in zip(INPUTS, values, strict=True):
            bench.set(name, value=value)
        bench.scan()
        assert bench.get("O58.0") is bool(meant(*values)), values


def test_set_and_reset_keep_and_a_later_assignment_wins() -> None:
    bench = Bench("A I88.0 S O58.0 A I88.1 R O58.0 O58.1 = 1 IF I88.2 THEN O58.1 = 0")
    bench.set("I88.0")
    assert bench.bits("O58.0", "O58.1") == "11"
    bench.set("I88.0", value=False)
    bench.set("I88.2")
    assert bench.bits("O58.0", "O58.1") == "10"
    bench.set("I88.1")
    assert bench.bits("O58.0") == "0"


def test_outputs_of_others_are_read_and_not_changed() -> None:
    bench = Bench("O1.0 = O2.7", owned=2)
    bench.set("O2.7")
    assert bench.bits("O1.0", "O2.7") == "11"
    bench.set("O2.7", value=False)
    assert bench.bits("O1.0", "O2.7") == "00"


def test_timers_and_counters_behind_their_flags() -> None:
    bench = Bench("M2.0 = I88.0 O58.0 = M3.0 O58.1 = M4.0 M0.1 = I88.1 O58.2 = M1.1 M5.1 = I88.2", timers=(3,), counters=(9, 2))
    bench.set("I88.0")
    seen = [bench.bits("O58.0", "O58.1") for _ in range(6)]
    assert seen == ["00", "01", "01", "01", "10", "10"], "three periods behind the start"
    for _ in range(2):
        bench.set("I88.1")
        bench.scan()
        bench.set("I88.1", value=False)
        bench.scan(2)
    assert bench.bits("O58.2") == "1", "two pulses: it is down"
    bench.set("I88.2")
    bench.scan(2)
    assert bench.bits("O58.2") == "0", "reset: its value of P14 again"


def test_a_program_that_does_not_end_is_stopped() -> None:
    bench = Bench("AGAIN: IF NOT I88.0 THEN JUMP AGAIN")
    with pytest.raises(TimeError):
        bench.scan()
    bench.set("I88.0")
    bench.scan()


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("O58.0 = NOWHERE", (1, 9, "name")),
        ("I88.0 = 1", (1, 1, "written")),
        ("USER_1_RCO = 1", (1, 1, "written")),
        ("O58.0 = I128.0", (1, 9, "address")),
        ("O58.0 = I88.8", (1, 9, "address")),
        ("O58.0 = 2", (1, 9, "binary")),
        ("JUMP OUT", (1, 6, "label")),
        ("OUT: OUT:", (1, 6, "label-twice")),
        ("IF I88.0 O58.0 = 1", (1, 10, "then")),
        ("IF I88.0 THEN BEGIN O58.0 = 1", (1, 15, "end")),
        ("O58.0 = (I88.0", (1, 9, "bracket")),
        ("A( A I88.0 = O58.0", (1, 12, "bracket")),
        ("A I88.0 ) = O58.0", (1, 9, "bracket")),
        ("O58.0 I88.0", (1, 7, "assign")),
        ("THEN", (1, 1, "statement")),
        ("O58.0 =\nO58.1 = I88.0", (1, 8, "operand")),
        ("O58.0 = I88.0 ?", (1, 15, "character")),
    ],
)
def test_a_fault_has_its_place(text: str, found: tuple[int, int, str]) -> None:
    assert faults_of(text)[0] == found


def test_all_faults_of_a_file_come_in_one_run() -> None:
    one = "IF NOWHERE AND NOBODY THEN I88.0 = NOTHING ELSE GONE = 2"
    assert [(column, id) for _, column, id in faults_of(one)] == [
        (4, "name"),
        (16, "name"),
        (28, "written"),
        (36, "name"),
        (49, "name"),
        (56, "binary"),
    ]
    text = "O58.0 = NOWHERE\nO58.1 = I88.0\nJUMP OUT\nI88.0 = 1\n"
    assert faults_of(text) == [(1, 9, "name"), (3, 6, "label"), (4, 1, "written")]
    assert faults_of("O58.0 = LAMP", "LAMP = I200.0\nLAMP = nothing\n?\nLAMP = I88.0") == [
        (1, 1, "symbol-line"), (2, 1, "symbol-line"), (3, 1, "symbol-line")
    ]  # fmt: skip


WORDS = [
    "IF",
    "THEN",
    "ELSE",
    "JUMP",
    "BEGIN",
    "END",
    "NOT",
    "AND",
    "OR",
    "(",
    ")",
    "=",
    ":",
    "-",
    "A",
    "ON",
    "JC",
    "EP",
    "O58.0",
    "I88.0",
    "X",
    "1",
    "\n",
]


@settings(max_examples=400, deadline=None)
@given(some.lists(some.sampled_from(WORDS), max_size=60) | some.text(max_size=80).map(list))
def test_no_text_is_an_exception(words: list[str]) -> None:
    faults_of(" ".join(words), "X = M40.0")


def test_what_was_read_can_be_scanned() -> None:
    for text in ("", "; nothing", "EP", "NOP1", "O58.0 = 0", "X: JUMP Y Y:", "-X\nJU -Y\n-Y\nA M0.0\n"):
        Bench(text).scan()


def test_nesting_has_an_end() -> None:
    assert faults_of("IF I88.0 THEN " * 100 + "O58.0 = 1")[0][2] == "nesting"
    assert faults_of("O58.0 = " + "(" * 100 + "I88.0" + ")" * 100)[0][2] == "nesting"


@pytest.mark.parametrize("wrong", ["A( I88.0 )", "A( NOT I88.0 )", "O( -LAMP )", "A( A I88.0 AND I88.1 )", "A( I88.0\nA I88.2\n)"])
def test_a_mistake_in_a_bracket_is_one_fault(wrong: str) -> None:
    assert len(faults_of(f"A I88.1\n{wrong}\n= O70.0\n")) == 1


def test_a_symbol_may_be_a_word_of_the_language() -> None:
    bench = Bench("A I88.0\nJC -END\nA I88.1\n= O58.0\n-END\nEP")
    bench.set("I88.1", value=True)
    bench.scan()
    assert bench.get("O58.0") is True
    bench.set("I88.0", value=True)
    bench.set("I88.1", value=False)
    bench.scan()
    assert bench.get("O58.0") is True, "it is jumped over"


def test_a_label_may_be_a_word_of_the_language_in_front_of_a_colon() -> None:
    bench = Bench("IF I88.0 THEN JUMP ENDE\nO58.0 = 1\nENDE:\nO58.1 = 1")
    bench.set("I88.0", value=True)
    assert bench.bits("O58.0", "O58.1") == "01"
    assert [row[2] for row in faults_of("JUMP ENDE\nO58.0 = 1")] == ["label"]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("LAMPE := TASTER\nLAMPE == TASTER", [(1, 7, "assign"), (2, 8, "assign")]),
        ("LAMPE = TASTER & I88,1\nLAMPE = !I88.O", [(1, 16, "character"), (1, 18, "character"), (2, 9, "character"), (2, 10, "character")]),
        ("IF TASTER THAN LAMPE = 1\nLAMPE = TASTR", [(1, 11, "then"), (2, 9, "name")]),
        ("WENN TASTER DAN BEGIN LAMPE = 1 END\nSONST LAMP = 0", [(1, 13, "then"), (2, 7, "name")]),
    ],
)
def test_two_mistakes_are_two_faults_at_their_places(text: str, found: list[tuple[int, int, str]]) -> None:
    assert faults_of(text, "TASTER = I88.0\nLAMPE = O58.0") == found


def test_an_instruction_without_operand_is_one_fault() -> None:
    assert faults_of("A\n= O58.0\n") == [(1, 2, "operand")]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("O58.0 = I88.0 AND\nO58.1 = I88.1", [(1, 18, "operand")]),
        ("IF I88.0 OR\nTHEN BEGIN O58.0 = 1\nEND\nELSE O58.0 = 0", [(1, 12, "operand")]),
        ("IF I88.0 =\nTHEN O58.0 = 1", [(1, 11, "binary")]),
        ("IF I88.0\nO58.0 = 1", [(1, 9, "then")]),
        ("JUMP\nA I88.0\n= O58.0", [(1, 5, "label")]),
        ("A I88.0\nS", [(2, 2, "operand")]),
        ("IF I88.0 AND\nI88.1 = 1 THEN O58.0 = 1", []),
    ],
)
def test_what_is_missing_at_the_end_of_a_line_is_reported_there(text: str, found: list[tuple[int, int, str]]) -> None:
    assert faults_of(text) == found


@pytest.mark.parametrize("inside", ["JC OUT", "S O58.1", "IF I88.2 THEN JUMP OUT"])
def test_an_output_or_jump_inside_of_a_bracket_is_one_fault(inside: str) -> None:
    text = f"A(\nA I88.0\n{inside}\nO I88.1\n)\n= O58.0\nOUT:\n"
    assert [(line, id) for line, _, id in faults_of(text)] == [(3, "bracket")]
    assert [(line, id) for line, _, id in faults_of(text + "A I88.0\n)\n= O58.0")] == [(3, "bracket"), (9, "bracket")]


@pytest.mark.parametrize(
    "text, line, column, id",
    [
        ("I8.0 THEN O58.0 = 1\nELSE O58.0 = 0", 1, 1, "if"),
        ("NOT I8.0 AND I8.1 THEN O58.0 = 1", 1, 1, "if"),
        ("FI I8.0 THEN O58.0 = 1", 1, 1, "if"),
        ("IF I8.0 THEN ENDE\nO58.0 = 0\nENDE:\nO58.1 = 0", 1, 14, "jump"),
        ("O58.0 = I8.0 I8.1\nO58.1 = 0", 1, 14, "operator"),
        ("IF I8.0 I8.1 THEN O58.0 = 0\nELSE O58.0 = 1", 1, 9, "operator"),
        ("IF I8.0 THEN O58.0 = 0 O58.1 = 1 END", 1, 34, "statement"),
        ("IF I8.0 THEN O58.0 = 0\nO58.1 = 1\nELSE O58.1 = 0", 3, 1, "statement"),
        ("O58.0 = NTO I8.0", 1, 9, "name"),
        ("O58.0 = LAMP\nO58.1 = LAMP", 1, 9, "name"),
        ("IF I8.0 THEN GOTO L\nL:", 1, 14, "name"),
        ("IF I8.0 THEN O58.0 = I8.1 ENDIF", 1, 27, "name"),
    ],
)
def test_a_missing_word_is_one_fault(text: str, line: int, column: int, id: str) -> None:
    """AX-1820."""
    assert faults_of(f"{text}\n") == [(line, column, id)]


@pytest.mark.parametrize(
    "text",
    [
        "IF I8.0 = 1 AND I8.1 = 0 THEN O58.0 = 1 O58.1 = I8.0 O58.2 = NOT I8.0",
        "IF I8.0 THEN IF NOT I8.1 THEN BEGIN O58.0 = 1 O58.1 = 0 END ELSE O58.2 = 1",
        "O58.0 = 1 IF I8.0 THEN JUMP ENDE\nENDE: O58.1 = I8.0",
        "A I8.0 AN I8.1 = O58.0 S O58.1 JC -ENDE\n-ENDE",
    ],
)
def test_sound_lines_stay_sound(text: str) -> None:
    assert faults_of(f"{text}\n") == []
