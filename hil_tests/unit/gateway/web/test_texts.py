"""The page speaks English and German: every text it shows has both."""

import pathlib
import re

STATIC = pathlib.Path(__file__).resolve().parents[4] / "gateway" / "web" / "static"
SAME = {
    "SAFETY",
    "en",
    "KF / DH",
    "KH",
    "KM",
    "KG",
    "Modbus",
    "pointercancel",
    "freeze",
    "pagehide",
}  # by themselves, or the same in both


def used() -> set[str]:
    """Texts in t("..."), and those handed on to it."""
    found: set[str] = set()
    for path in (*STATIC.glob("*.js"), *STATIC.glob("pages/*.js")):
        if path.name.startswith("texts"):
            continue
        source = path.read_text()
        found.update(re.findall(r'\bt\("((?:[^"\\]|\\.)*)"\)', source))
        found.update(re.findall(r'\bpost\([^;]*?, "([A-Z][^"]+)"\)', source))
        found.update(re.findall(r'\["[a-z_]+", "([^"]+)"(?:, true)?\]', source))
    return found


def test_every_text_has_its_german() -> None:
    german = set(re.findall(r'"((?:[^"\\]|\\.)*)":\s*"', (STATIC / "texts_de.js").read_text()))
    assert len(used()) > 100
    assert sorted(used() - german - SAME) == []


def test_no_word_is_used_that_promises_too_much() -> None:
    promised = re.compile(r"certified|drop-in|100 % compatible|real-time guaranteed", re.IGNORECASE)
    for path in (*STATIC.glob("*.js"), *STATIC.glob("pages/*.js"), STATIC / "index.html"):
        source = re.sub(r"const SAFETY = \{.*?\};", "", path.read_text(), flags=re.DOTALL)
        assert not promised.search(source), path


def test_nothing_is_fetched_from_elsewhere() -> None:
    for path in (*STATIC.glob("*.js"), *STATIC.glob("pages/*.js"), STATIC / "index.html", STATIC / "style.css"):
        assert not re.search(r"(src|href|import|url)\W{1,4}https?://", path.read_text()), path
    for folder in ("uplot", "three"):
        assert "MIT" in (STATIC / "vendor" / folder / "LICENSE").read_text()
