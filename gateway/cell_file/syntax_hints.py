"""A TOML syntax error explained for users who do not know TOML."""

import re
import tomllib

from gateway.pure.cell.faults import Fault

_PLACE = re.compile(r"\(at line (\d+), column \d+\)")
_QUIET = re.compile(r"\"(?:\\.|[^\"\\\n])*\"|'[^'\n]*'|#[^\n]*")


def syntax_fault(file: str, text: str, error: tomllib.TOMLDecodeError) -> Fault:
    """The fault with its line and, for a common mistake, the correct form."""
    message = str(error)
    lines = text.splitlines() or [""]
    found = _PLACE.search(message)
    number = min(int(found[1]), len(lines)) if found else len(lines)
    bare = [_QUIET.sub(lambda m: "#" if m[0].startswith("#") else '""', line).split("#")[0] for line in lines]
    hint = _hint(message, bare, number)
    said = _PLACE.sub("", message).strip()
    return Fault(file, "TOML", hint=f"{said}; {hint}" if hint else said, line=number, kind="syntax")


def _hint(message: str, bare: list[str], number: int) -> str:
    line = bare[number - 1].strip()
    if ";" in line:
        return "TOML has no semicolons: one key on each line"
    if opened := _open_inline_table(bare, number):
        return (
            f"the inline table opened in line {opened} is not closed there: {{ ... }} stays on one line; "
            "write a list of one-line tables, or a [table] header with one key on each line"
        )
    if (found := re.match(r"\[\[\s*([\w-]+)", line)) and any(re.match(rf"\s*\[{found[1]}[.\]]", each) for each in bare[: number - 1]):
        return f"[{found[1]}.xxx] belongs to the last [[{found[1]}]] above it, so [[{found[1]}]] has to come first"
    if (found := re.match(r"\[\s*([\w-]+)\s*\.\s*([\w.-]+)", line)) and any(
        re.match(rf"\s*\[\[\s*{found[1]}\s*\]\]", each) for each in bare
    ):
        return f"[{found[1]}.{found[2]}] belongs to the last [[{found[1]}]] above it; write it at most once for each of them"
    if re.search(r"=\s*-?\d+,\d", line):
        return "numbers have a decimal point, no comma"
    if re.match(r"[\w.-]+\s*=\s*[A-Za-z]", line) or re.match(r"[\w.-]+\s*:", line):
        return 'write key = value, texts in "quotes", Boolean values as true or false'
    if "overwrite" in message or "twice" in message:
        return "this key or table is already in the file"
    return ""


def _open_inline_table(bare: list[str], number: int) -> int | None:
    """The line in which an inline table was opened and not closed before the line of the error."""
    for index in range(number - 1, max(-1, number - 40), -1):
        line = bare[index]
        if line.count("{") > line.count("}"):
            return index + 1
        if index < number - 1 and re.match(r"\s*\[", line):
            return None
    return None
