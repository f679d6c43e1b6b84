"""`make docs`: docs/decisions.md from docs/decisions.d/AX-nnn-*.md, in the order of their numbers; docs/errors.md from configs/errors;
the table of functions in README.md and docs/compatibility.md from configs/evidence.toml.

python docs/assemble.py [--check]      (--check: exit 1 when a page is not what its files say)
"""

import pathlib
import re
import sys

import error_pages
import evidence_pages

HERE = pathlib.Path(__file__).resolve().parent
TARGET = HERE / "decisions.md"
TITLE = re.compile(r"# (AX-\d{3})\b[ :.-]*(.+)")
HEAD = """# Decisions

What the manuals leave open and axisgate had to settle. One paragraph each, made by `make docs` from the files in `decisions.d`;
a decision is changed by a new one, which names the old.
"""


def assembled() -> str:
    """The whole page; raises ValueError naming a file without a title, or two with one number."""
    sections: dict[str, str] = {}
    for path in sorted((HERE / "decisions.d").glob("*.md")):
        title, _, body = path.read_text(encoding="utf-8").strip().partition("\n")
        match = TITLE.fullmatch(title.strip())
        if match is None or not path.name.startswith(match[1]):
            raise ValueError(f"{path.name}: the first line must be '# AX-nnn title' with the number of the file's name")
        if match[1] in sections:
            raise ValueError(f"{path.name}: {match[1]} exists already")
        sections[match[1]] = f"## {match[1]} {match[2][0].upper()}{match[2][1:]}\n\n{body.strip()}\n"
    return "\n".join([HEAD, *(sections[number] for number in sorted(sections))])


def main() -> int:
    page, errors = assembled(), error_pages.page()
    pages = {TARGET: page, HERE / "errors.md": errors, HERE / "compatibility.md": evidence_pages.page()}
    pages[HERE.parent / "README.md"] = evidence_pages.readme()
    if "--check" in sys.argv[1:]:
        return int(any(not path.exists() or path.read_text(encoding="utf-8") != text for path, text in pages.items()))
    for path, text in pages.items():
        path.write_text(text, encoding="utf-8")
    print(f"{TARGET.name}: {page.count(chr(10) + '## ')} decisions; errors.md: {errors.count(chr(10) + '## ')} number spaces")
    return 0


if __name__ == "__main__":
    sys.exit(main())
