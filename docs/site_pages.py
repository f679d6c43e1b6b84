"""Pages of the docs site that are made of the program itself, in build/docs-src beside a copy of docs; `make docs` runs it, then MkDocs.

None of these pages is kept in the tree, so they cannot differ from the program.  A line `<!-- wiring: CELL -->` in a page becomes the
wiring table of that shipped cell, as `axisgate map CELL --wiring` prints it; docs/assemble.py puts the same tables into the tree.
"""

import contextlib
import io
import pathlib
import re
import shutil
import sys
import typing
from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points

from gateway.__main__ import load
from gateway.cell_file.load import load_cell
from gateway.commands.assess import WORDS
from gateway.files.find import read_signals
from gateway.pure.cell.cell import CellTables
from gateway.pure.cell.columns import Column, bare_type, columns
from gateway.pure.cell.marks import Pattern, Registered
from gateway.pure.reports.tables import render
from gateway.registry import NAMES
from gateway.tools.address_map import SHEETS
from gateway.tools.new_cell.assessment import ASKED, assess
from gateway.tools.progress import steps

HERE = pathlib.Path(__file__).resolve().parent
TARGET = HERE.parent / "build" / "docs-src"
KEPT = ("*.md", "guide/*.md", "howto/*.md", "pictures/*.png", "requirements/*.csv")
WIRING = re.compile(r"^<!-- wiring: ([\w-]+) -->$\n?(?:(?:(?!<!-- wiring:).)*?<!-- /wiring -->)?", re.DOTALL | re.MULTILINE)
QUESTIONS = re.compile(r"^<!-- questions -->$\n?(?:.*?<!-- /questions -->)?", re.DOTALL | re.MULTILINE)
OUTSIDE = re.compile(r"\]\((?:\.\./)+(configs|hil_tests|gateway|drivers|protocols|motion|README\.md|LICENSE)[^)]*\)")
MADE = "Made by `make docs` out of the program; it is never edited.\n"


# --------------------------------------------------------------------------------------------------------- cell file


def cell_keys() -> str:
    """Every key of the cell file: tables in the order of the file, from the classes that check it."""
    sections = [f"# Keys of the cell file\n\n{MADE}\n`axisgate explain KEY --cell CELL` shows the value of a key and its source.\n"]
    for path, table in tables(CellTables, ""):
        rows = "".join(_key(column) for column in columns(table).values() if not column.table and not column.loaded)
        if rows:
            title = f"`{path}`" if path else "The file itself"
            sections.append(f"## {title}\n\n| key | takes | without it |\n|---|---|---|\n{rows}")
    return "\n".join(sections)


def tables(table: type, path: str) -> Iterator[tuple[str, type]]:
    """All tables below a table with their headings as a file writes them."""
    yield path, table
    for key, column in columns(table).items():
        if column.table is not None:
            bare = f"{path.strip('[]')}.{key}" if path else key
            yield from tables(column.table, f"[[{bare}]]" if typing.get_origin(bare_type(column.annotation)) is tuple else f"[{bare}]")


def _key(column: Column) -> str:
    allowed = [mark.allowed for mark in column.marks if isinstance(mark, Pattern)]
    named = [", ".join(f"`{name}`" for name in NAMES[mark.table]) for mark in column.marks if isinstance(mark, Registered)]
    takes = ", ".join([*(named or [_type(column.annotation)]), *_bounds(column.marks), *allowed, *([column.unit] if column.unit else [])])
    default = "must be given" if column.required else "-" if column.default in ("", None, (), {}) else f"`{_written(column.default)}`"
    return f"| `{column.key}` | {_cell(takes)} | {_cell(default)} |\n"


def _written(value: object) -> object:
    """A default as the file writes it: lists in brackets."""
    return [_written(each) for each in value] if isinstance(value, tuple) else value


def _bounds(marks: tuple[object, ...]) -> Iterator[str]:
    for sign, name in ((">=", "ge"), (">", "gt"), ("<=", "le"), ("<", "lt")):
        yield from (f"{sign} {getattr(mark, name)}" for mark in marks if getattr(mark, name, None) is not None)


def _type(annotation: object) -> str:
    names = {str: "text", int: "whole number", float: "number", bool: "true or false", type(None): ""}
    if annotation in names:
        return names[typing.cast(type, annotation)]
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Literal:
        return ", ".join(f"`{part}`" for part in parts if part != "")
    if origin is typing.Annotated:
        return _type(parts[0])
    words = [word for part in parts if part is not Ellipsis and (word := _type(part))]
    if origin is Mapping:
        return f"table of {words[-1]}"
    if origin in (list, tuple):
        return f"list of {words[0] if words else 'values'}"
    return " or ".join(dict.fromkeys(words)) if words else getattr(annotation, "__name__", "text")


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


# ----------------------------------------------------------------------------------------------------------- the rest


def commands() -> str:
    """The help of every command."""
    parts = [f"# Commands\n\n{MADE}\nExit codes: 0 ok; 1 valid input but a finding; 2 command line, cell or file invalid; 3 environment.\n"]
    for entry in sorted(entry_points(group="axisgate.commands"), key=lambda entry: entry.name):
        parts.append(f"## {entry.name}\n\n```text\n{_help(entry).rstrip()}\n```\n")
    return "\n".join(parts)


def _help(entry: EntryPoint) -> str:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        load(entry)(["-h"])
    return said.getvalue()


def maps() -> str:
    """Registers and data blocks of the demo's cell, as `axisgate map` prints them."""
    sheet = _sheet("demo", "modbus", "db")
    return f"# Register map of a cell\n\n{MADE}\nThis is the cell `demo`; `axisgate map CELL --modbus --db` prints yours.\n\n{sheet}"


def signals() -> str:
    """The signal list."""
    rows = "".join(
        f"| {row['direction']} {row['bit']} | `{row['name']}` | {_cell(str(row['en']))} | {_cell(str(row['de']))} | {row['source']} |\n"
        for row in read_signals()
    )
    head = "`axisgate explain NAME` shows more; `[signals]` of a cell moves one to another number. Source *axisgate*: AX-002.\n"
    return f"# Signals\n\n{MADE}\n{head}\n| bit | name | text | Text | source |\n|---|---|---|---|---|\n{rows}"


PLAIN = {"p15": "3", "axes": "6", "risk": "J. Muster"}  # an answer to each question that asks for a number or a name


def questions() -> str:
    """The ten questions of `axisgate assess`, and the verdict on each answer."""
    usual = {asked.key: next(iter(asked.answers), PLAIN.get(asked.key, "-")) for asked in ASKED}
    rows = []
    for number, asked in enumerate(ASKED, 1):
        rows.append(f"| **{number}** | **{_cell(asked.text)}** | | {asked.free} |\n")
        for word, meaning in asked.answers.items():
            reason = next(reason for reason in assess({**usual, asked.key: word}) if reason.key == asked.key)
            rows.append(f"| | {_cell(f'{word}: {meaning}' if meaning else word)} | {WORDS[reason.verdict]} | {_cell(reason.text)} |\n")
    return "| | question and answers | verdict | reason |\n|---|---|---|---|\n" + "".join(rows)


def pictures() -> str:
    """Every page in both themes, at two sizes."""
    parts = ["# Screenshots of the page\n\nTaken by the tests from a running cell, simulated.\n"]
    for name in sorted({path.stem.split("-")[0] for path in (HERE / "pictures").glob("*-*-*.png")}):
        shots = "\n".join(f"![{path.stem}](../pictures/{path.name})" for path in sorted((HERE / "pictures").glob(f"{name}-*-*.png")))
        parts.append(f"## {name.capitalize()}\n\n{shots}\n")
    return "\n".join(parts)


def wiring(name: str) -> str:
    """The wiring table of a shipped cell."""
    return f"Wiring of the shipped cell `{name}` (`axisgate map {name} --wiring`):\n\n{_sheet(name, 'wiring')}"


def _sheet(name: str, *wanted: str) -> str:
    cell = load_cell(name)
    text = render(cell.cell.name, [sheet for each in wanted for sheet in SHEETS[each](cell)], "md")
    return text.partition("\n")[2].replace("\n# ", "\n## ").strip() + "\n"


GENERATED = {
    "reference/cell-file.md": cell_keys,
    "reference/commands.md": commands,
    "reference/register-map.md": maps,
    "reference/signals.md": signals,
    "reference/pictures.md": pictures,
}


def in_tree(text: str) -> str:
    """A page with the same tables between its marks, so that they can be read on a code host."""
    text = QUESTIONS.sub(lambda _: f"<!-- questions -->\n{questions()}<!-- /questions -->", text)
    return WIRING.sub(lambda found: f"<!-- wiring: {found[1]} -->\n{wiring(found[1])}<!-- /wiring -->", text)


def filled(text: str) -> str:
    """A page with its tables put in; what lies outside the site is named and not linked."""
    text = QUESTIONS.sub(lambda _: questions(), text)
    text = WIRING.sub(lambda found: wiring(found[1]), text)
    return OUTSIDE.sub(r"]", text)


GUIDES = "      # every page of docs/guide\n"


def settings() -> str:
    """mkdocs.yml; guides that it does not name follow by their titles."""
    rows, text = [], (HERE.parent / "mkdocs.yml").read_text(encoding="utf-8")
    for path in sorted((HERE / "guide").glob("*.md")):
        if f"guide/{path.name}" not in text:
            title = path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ").replace("`", "").replace('"', "")
            rows.append(f'      - "{title}": guide/{path.name}\n')
    return text.replace(GUIDES, "".join(rows))


def main() -> int:
    """build/docs-src and build/mkdocs.yml anew."""
    shutil.rmtree(TARGET, ignore_errors=True)
    for pattern in KEPT:
        for path in HERE.glob(pattern):
            target = TARGET / path.relative_to(HERE)
            target.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".md":
                target.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
            else:
                shutil.copy(path, target)
    (TARGET.parent / "mkdocs.yml").write_text(settings(), encoding="utf-8")
    for name, make in steps("pages made of the program", list(GENERATED.items())):
        (TARGET / name).parent.mkdir(parents=True, exist_ok=True)
        (TARGET / name).write_text(make(), encoding="utf-8")
    print(f"{TARGET.name}: {len(list(TARGET.rglob('*.md')))} pages, {len(GENERATED)} of them made of the program")
    return 0


if __name__ == "__main__":
    sys.exit(main())
