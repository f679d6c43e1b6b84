"""Decisions (AX-nnn) as text: docs/decisions.d in the tree, configs/decisions in an installed wheel."""

import pathlib
import re
from typing import NamedTuple

from gateway.files.find import PACKAGED, read_text

FOLDERS = (PACKAGED.parent / "docs" / "decisions.d", PACKAGED / "decisions")
FORM = re.compile(
    r"(?:---\nchapter: (?P<chapter>[^\n]+)\n---\n+)?# (?P<number>AX-\d{3,4})\b[ :.-]*(?P<title>[^\n]+)\n(?P<text>.*)", re.DOTALL
)


class DecisionError(ValueError):
    """A file of a decision has another form; the message names it."""


class Decision(NamedTuple):
    """One decision; chapter: where the page of decisions has it, empty: not sorted yet."""

    number: str
    title: str
    text: str
    chapter: str


def parsed(name: str, source: str) -> Decision:
    """A file: `---`, `chapter: NAME`, `---`, `# AX-nnn title`, paragraphs.  Raises DecisionError."""
    found = FORM.fullmatch(source.strip() + "\n")
    if found is None or not name.startswith(found["number"]):
        raise DecisionError(
            f"{name}: the first line must be '# AX-nnn title' with the number of the file's name, after front matter `chapter:`"
        )
    title = found["title"].strip()
    return Decision(found["number"], title[0].upper() + title[1:], found["text"].strip(), found["chapter"] or "")


def files() -> list[pathlib.Path]:
    folder = next((folder for folder in FOLDERS if folder.is_dir()), None)
    return sorted(folder.glob("AX-*.md"), key=_order) if folder else []


def _order(path: pathlib.Path) -> tuple[int, str]:
    """By the number, which has three or four digits."""
    number = path.name.split("-")[1]
    return int(number) if number.isdecimal() else 0, path.name


def read_decision(number: str) -> Decision | None:
    """A decision by its number; None: there is none."""
    path = next((path for path in files() if path.name.startswith(f"{number}-")), None)
    return parsed(path.name, read_text(path)) if path else None
