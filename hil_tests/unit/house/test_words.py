"""Texts that a user reads use the field's nouns (AX-850)."""

import pathlib

import pytest

from hil_tests.house.words import ROOT, Finding, allowed, files, findings, judged, lowered


def found_in(folder: pathlib.Path, name: str, text: str) -> list[str]:
    path = ROOT / "build" / folder.name / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    try:
        return [finding.word for finding in findings(path)]
    finally:
        path.unlink()
        path.parent.rmdir()


def test_texts_of_the_product_have_no_forbidden_word() -> None:
    found = [finding for path in files() for finding in findings(path)]
    assert judged(found, allowed()) == []


def test_decisions_are_read_and_none_is_allowed_a_word() -> None:
    read = {str(path.relative_to(ROOT)) for path in files()}
    decisions = {str(path.relative_to(ROOT)) for path in (ROOT / "docs" / "decisions.d").glob("*.md")}
    assert decisions and decisions <= read
    assert allowed() == {}, "the allow list is empty and stays so"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.py", 'raise ValueError("the name stands twice")\n', ["stands"]),
        ("a.py", 'raise ValueError(f"{name}: nobody writes it")\n', ["nobody"]),
        ("a.py", '"""What the cycle is told."""\n', ["told"]),
        ("a.py", 'class Part:\n    """Its desk."""\n', ["desk"]),
        ("a.py", 'class _Part:\n    """Its desk."""\n', []),
        ("a.py", 'kind = "door"\n', []),
        ("a.py", '"""Waits until the axis stands still behind the guard door."""\n', []),
        ("a.js", 't("Somebody else is in control"); const told = of(he);\n', ["Somebody"]),
        ("a.toml", 'door = "plc"  # the door that commands\n', ["door"]),
        ("a.toml", 'text = ["no answer", "eine andere Tuer fuehrt"]\n', ["Tuer"]),
        ("a.md", "`told` is a field. The partner is told.\n", ["told"]),
    ],
)
def test_a_forbidden_word_is_found_where_a_user_reads_it(tmp_path: pathlib.Path, name: str, text: str, words: list[str]) -> None:
    assert found_in(tmp_path, name, text) == words


def test_what_is_allowed_only_falls() -> None:
    found = [Finding("a.py", line, "told", "is told") for line in (1, 2)]
    assert judged(found, {"a.py": 2}) == [] and judged(found[:1], {}) == ["a.py:1: 'told': is told"]
    assert len(judged(found, {"a.py": 1})) == 2
    assert lowered(found, {"a.py": 5, "gone.py": 1}) == {"a.py": 2} and lowered(found, {"a.py": 1}) == {"a.py": 1}
    assert lowered(found, {}) == {}, "a file without an entry never gets one"
