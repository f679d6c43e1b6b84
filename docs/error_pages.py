"""docs/errors.md out of configs/errors/*.toml; called by docs/assemble.py."""

import re

from gateway.files.error_catalogue import catalogue
from gateway.pure.image.error_entries import RESETS, Entry, Family

HEAD = """# Errors

Every error number of the three manuals, of lines and drives, and of axisgate itself: made by `make docs` from `configs/errors`.
`axisgate explain 647`, `axisgate explain reis 647`, `axisgate explain rk512 14h` and `axisgate explain "tracking distance"` tell the
same at the machine, in the language of the cell. *ours*: the manual at hand has no such number.

What acknowledges what:

"""

HEXADECIMAL = {"cia402": 4, "rk512": 2}  # digits: as their partners print them


def page() -> str:
    """The whole page."""
    families = catalogue().values()
    resets = "".join(f"- **{key}**: {en} (*{de}*)\n" for key, (en, de) in RESETS.items())
    index = "".join(f"- [{family.title.en}](#{family.name}): {len(family.entries)} numbers\n" for family in families)
    return "\n".join([HEAD + resets, index, *(_section(family) for family in families)])


def _section(family: Family) -> str:
    same = {re.sub(rf"(?<![\w-]){entry.number}(?!\w)", "N", entry.shown.en) for entry in family.entries.values()}
    each = len(same) > 1
    rows = "".join(_row(entry, shown=each) for entry in family.entries.values())
    columns = ["No.", "Text", "Deutsch", "Cause", "What to do", "Reset", *(["Partner shows"] if each else []), "Source"]
    shown = "" if each else f"The partner shows: {_cell(same.pop())}\n\n"
    head = f'## <a id="{family.name}"></a>{family.title.en}\n\n*{family.title.de}*. Source: {family.source}.'
    head += f" `axisgate explain {family.name} N`.\n\n"
    return f"{head}{shown}| {' | '.join(columns)} |\n|{'---|' * len(columns)}\n{rows}"


def _row(entry: Entry, *, shown: bool) -> str:
    source = f"*ours*, {entry.source}" if entry.ours else entry.source
    digits = HEXADECIMAL.get(entry.family)
    number = f"{entry.number:0{digits}X}h" if digits else str(entry.number)
    cells = [number, entry.text.en, entry.text.de, entry.cause.en, entry.todo.en, entry.reset, *([entry.shown.en] if shown else []), source]
    return f"| {' | '.join(map(_cell, cells))} |\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")
