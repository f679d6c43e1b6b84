"""What a Reis control, its programs and its PLC refuse or report has German words on the page and at the pendant."""

import ast
import pathlib
import re
from collections.abc import Iterator

import pytest

import gateway
from gateway.files.texts import read_texts
from gateway.pure.controllers.reis.marker_operand import MarkerFault, marker_of
from gateway.web.german import german

PURE = pathlib.Path(gateway.__file__).parent / "pure"
CHECKED = (  # what `robotstar check`, `robotstar import` and `plc check` report
    "languages/robotstar/checker.py",
    "languages/robotstar/circles.py",
    "languages/robotstar/grammar.py",
    "languages/robotstar/layout.py",
    "languages/robotstar/listing.py",
    "languages/robotstar/literals.py",
    "languages/robotstar/memory.py",
    "languages/robotstar/operands.py",
    "languages/robotstar/program.py",
    "languages/robotstar/reader.py",
    "languages/robotstar/slips.py",
    "languages/plc/messages.py",
    "languages/plc/reader.py",
    "languages/plc/steps.py",
    "languages/plc/translation.py",
)
SOURCES = (
    *CHECKED,
    "controllers/reis/marker_operand.py",
    "controllers/reis/programs.py",
    "controllers/reis/binary.py",
    "controllers/reis/analog.py",
    "languages/robotstar/ahead.py",
    "languages/robotstar/arm.py",
    "languages/robotstar/cell_robot.py",
    "languages/robotstar/cell_run.py",
    "languages/robotstar/cell_world.py",
    "languages/robotstar/control_steps.py",
    "languages/robotstar/data_steps.py",
    "languages/robotstar/faults.py",
    "languages/robotstar/initial.py",
    "languages/robotstar/lines.py",
    "languages/robotstar/machine.py",
    "languages/robotstar/motion_steps.py",
    "languages/robotstar/mouse.py",
    "languages/robotstar/pallet.py",
    "languages/robotstar/path.py",
    "languages/robotstar/robot.py",
    "languages/robotstar/steps.py",
    "languages/robotstar/values.py",
)
PAIRS = (("start", "auxiliary"), ("auxiliary", "end"), ("start", "end"))
TYPES = re.compile(  # no sentences
    r"^[A-Z_]+$|^(rsv\.)?[a-z]+[-_][a-z_-]+$|\[\\w|\(\?|\|MP\||re\.Match|7 (step|line) 7$"
    r"|speed=|joints|radius=|circular via|tool 7 7|\| None|Callable\[|F1 or F2"
)
VALUE = "7"
PUT_TOGETHER = {  # sentences of which a part is a word of a list
    "program 7 is not a 7": ["program P is not a sub-program", "program P is not a macro", "program P is not a main program"],
    "circle: 7 and 7 point are the same": [f"circle: {a} and {b} point are the same" for a, b in PAIRS],
    "circle: 7 point is a position of the tool, not of the axes": [
        "circle: the end point is a position of the tool, not of the axes",
        "circle: an auxiliary point is a position of the tool, not of the axes",
    ],
    "7 is defined twice in 7": ["I1 is defined twice in this program", "I1 is defined twice in the memory (in P.MPR)"],
    "the memory (in 7)": [],
    "a bit of A, E or M (A1.0)7": [
        f"a bit of A, E or M (A1.0){more}" for more in ("", " or a counter (Z5)", ", a timer (T5) or a counter (Z5)")
    ],
    ", a timer (T5) or a counter (Z5)": [],
    "a byte of E, A or M (M20)7": [
        f"a byte of E, A or M (M20){more}" for more in ("", ", a decimal constant or a hexadecimal one with H (12ACH)")
    ],
    ", a decimal constant or a hexadecimal one with H (12ACH)": [],
    "not executable in Test 5": ["WAIT_BIT is not executable in Test 5"],
}


def sentences(path: pathlib.Path) -> Iterator[tuple[int, str]]:
    """Texts of three words and more, whatever is filled in as 7."""
    tree = ast.parse(path.read_text())
    inner = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node) if part is not node}
    inner |= {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if id(node) not in inner and isinstance(node, ast.JoinedStr | ast.Constant):
            parts = node.values if isinstance(node, ast.JoinedStr) else [node]
            words = "".join(str(part.value) if isinstance(part, ast.Constant) else VALUE for part in parts)
            if len(re.findall(r"[a-zA-Z]{2,}", words)) >= 3 and not TYPES.search(words):
                yield node.lineno, words


@pytest.mark.parametrize("name", SOURCES)
def test_each_sentence_has_its_german(name: str) -> None:
    found = [(line, each) for line, words in sentences(PURE / name) for each in PUT_TOGETHER.get(words, [words])]
    missing = [f"{name}:{line}: {words}" for line, words in found if german(words) == words]
    assert not missing, "give them a line in configs/texts/robotstar.toml"


def test_a_marker_of_the_robot_is_refused_in_german() -> None:
    with pytest.raises(MarkerFault) as fault:
        marker_of("MD944")
    assert german(str(fault.value)) == "MD944: ihn schreibt der Roboter (Fehlernummer der Steuerung)"
    assert german("P: START is refused: the drives are off") == "P: START abgelehnt: die Antriebe sind aus"
    assert german("program X not found (P step 3)") == "Programm X nicht gefunden (P Schritt 3)"


def test_each_text_keeps_its_fields() -> None:
    pairs = list(read_texts("robotstar").pairs())
    assert len({english for english, _ in pairs}) == len(pairs) > 100
    for english, said in pairs:
        assert set(re.findall(r"\{\d\}", english)) == set(re.findall(r"\{\d\}", said)), english
