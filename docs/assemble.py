"""`make docs`: docs/decisions.md from docs/decisions.d/AX-nnn-*.md, in the order of their numbers; docs/errors.md from configs/errors;
the table of functions in README.md and docs/compatibility.md from configs/evidence.toml.

python docs/assemble.py [--check]      (--check: exit 1 when a page is not what its files say)
"""

import itertools
import pathlib
import re
import sys

import error_pages
import evidence_pages
import site_pages

from gateway.files.decisions import Decision, files, parsed

HERE = pathlib.Path(__file__).resolve().parent
TARGET = HERE / "decisions.md"
CHAPTERS = (
    "Commands and control",
    "Cell file and commands",
    "Signals, routes and contacts",
    "Serial lines",
    "Modbus",
    "Drives on SERVODYN",
    "Drives on CANopen",
    "Motion",
    "Programs and the planner",
    "Measuring, switching and belts",
    "Functions of the rho 3",
    "ROBOTstar V",
    "VAL 3",
    "Programs of the old controllers",
    "Cycle and processes",
    "Page, recording and northbound",
    "Emulator and simulation",
    "The project",
)
UNSORTED = "Not sorted yet"
HEAD = """# Decisions

What the manuals leave open and axisgate had to settle, by chapter; `axisgate explain AX-334` prints one. Made by `make docs` from the
files in `decisions.d`; a decision is changed by a new one, which names the old.
"""


def decisions() -> list[Decision]:
    """All of them; raises ValueError naming a file of another form, an unknown chapter, or two with one number."""
    found = [parsed(path.name, path.read_text(encoding="utf-8")) for path in files()]
    for one, other in itertools.pairwise(found):
        if one.number == other.number:
            raise ValueError(f"decisions.d: {one.number} exists twice")
    for each in found:
        if each.chapter not in ("", *CHAPTERS):
            raise ValueError(f"{each.number}: no chapter {each.chapter!r}; there are {', '.join(CHAPTERS)}")
    return found


def assembled() -> str:
    """The whole page: contents, then the chapters.  Each decision has the anchor #ax-nnn."""
    found = decisions()
    chapters = [(name, [each for each in found if each.chapter == name.replace(UNSORTED, "")]) for name in (*CHAPTERS, UNSORTED)]
    parts = [HEAD]
    parts += [f"- [{name}](#{_anchor(name)}): {len(inside)}" for name, inside in chapters if inside]
    for name, inside in chapters:
        parts += [f'\n<a id="{_anchor(name)}"></a>\n\n## {name}\n'] if inside else []
        parts += [f'<a id="{each.number.lower()}"></a>\n\n### {each.number} {each.title}\n\n{each.text}\n' for each in inside]
    return "\n".join(parts)


def _anchor(chapter: str) -> str:
    return "chapter-" + re.sub(r"\W+", "-", chapter.lower())


def written() -> dict[pathlib.Path, str]:
    """Pages written by hand with tables of shipped cells and the questions between their marks."""
    found = {path: path.read_text(encoding="utf-8") for path in sorted([*HERE.glob("*.md"), *HERE.glob("howto/*.md")]) if path != TARGET}
    marks = (site_pages.WIRING, site_pages.QUESTIONS)
    return {path: site_pages.in_tree(text) for path, text in found.items() if any(mark.search(text) for mark in marks)}


def main() -> int:
    page, errors = assembled(), error_pages.page()
    pages = {TARGET: page, HERE / "errors.md": errors, HERE / "compatibility.md": evidence_pages.page()}
    pages[HERE.parent / "README.md"] = evidence_pages.readme()
    pages |= written()
    if "--check" in sys.argv[1:]:
        return int(any(not path.exists() or path.read_text(encoding="utf-8") != text for path, text in pages.items()))
    for path, text in pages.items():
        path.write_text(text, encoding="utf-8")
    print(f"{TARGET.name}: {page.count(chr(10) + '### ')} decisions; errors.md: {errors.count(chr(10) + '## ')} number spaces")
    return 0


if __name__ == "__main__":
    sys.exit(main())
