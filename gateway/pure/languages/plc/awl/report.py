"""Imports a statement list: programs, and a reason for each line that was not translated."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.plc.awl.reader import OPERANDS, Reader, Refused
from gateway.pure.languages.plc.awl.translator import Translator

ROW = re.compile(r"((?:D[BX]\d+\.)?[A-Z]{1,3}\d+(?:\.\d+)?)\s*[=;,\t ]\s*(M\d+(?:\.\d)?)$")
MARKER = re.compile(r"\b(?:M[BWD]?|F[YWD]?)\s*(\d{1,4})")  # F: the flags of an English list of STEP 5
NARROW = "numbers are calculated with 32 bits; STEP 5 has 16: check lines"


@dataclass(slots=True)
class Imported:
    """Programs by name, lines that were refused, and what is to be looked at."""

    programs: dict[str, str] = field(default_factory=dict)
    refused: list[Refused] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    statements: int = 0

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        rows = [{"line": each.line, "block": each.block, "text": each.text, "reason": each.reason} for each in self.refused]
        return {"statements": self.statements, "refused": rows, "notes": self.notes}

    def lines(self) -> list[str]:
        """For a reader."""
        rows = [f"line {each.line}{f' ({each.block})' if each.block else ''}: {each.text}: {each.reason}" for each in self.refused]
        return [f"{self.statements} statements, {len(self.refused)} not translated", *rows, *self.notes]


def words_of(table: str) -> tuple[Mapping[str, str], list[str]]:
    """The table of words and markers, and the lines that are no row of it."""
    found: dict[str, str] = {}
    wrong: list[str] = []
    for number, line in enumerate(table.splitlines(), 1):
        text = " ".join(line.split("#")[0].upper().split())
        if not text:
            continue
        if row := ROW.match(text):
            found[row[1]] = row[2]
        else:
            wrong.append(f"table, line {number}: {text[:60]!r} is no row; write DB10.DW5 = M200")
    return found, wrong


def _german(name: str) -> str:
    """QW20 is AW20, FW20 is MW20."""
    letters = name.rstrip("0123456789.")
    return OPERANDS.get(letters, letters) + name[len(letters) :]


def spare_bytes(text: str, words: Mapping[str, str]) -> list[str]:
    """Marker bytes that neither the list nor the table names, the last first."""
    used: set[int] = set()
    for found in MARKER.finditer(f"{text.upper()} {' '.join(words.values())}"):
        first = int(found[1])
        used.update(range(first, first + 4))  # a double word at most
    return [f"M{byte}" for byte in range(511, -1, -1) if byte not in used]


def imported(text: str, table: str = "") -> Imported:
    """The programs of a list."""
    reader = Reader(text)
    listing = reader.run()
    words, wrong = words_of(table)
    if reader.english:
        words = {_german(name): marker for name, marker in words.items()}
    result = Imported(refused=list(listing.refused), notes=[*listing.notes, *wrong])
    calls: dict[str, str] = {}
    spare, *pool = spare_bytes(text, words) or [""]
    for block in listing.blocks:
        translator = Translator(block, words, reader.english, spare, pool=pool)
        result.programs[block.name] = translator.run()
        result.statements += len(block.statements)
        known = {each.line for each in result.refused}
        result.refused += [each for each in translator.refused if each.line not in known]
        calls |= dict.fromkeys(translator.calls, block.name)
        if translator.spared:
            result.notes.append(f"{block.name}: {spare}.0 and {spare}.1 are auxiliary bits of edges; no other program may use them")
        if translator.local:
            rows = ", ".join(f"LB{byte} is {marker}" for byte, marker in sorted(translator.local.items()))
            result.notes.append(f"{block.name}: local bits: {rows}; no other program may use them")
        if translator.narrow:
            result.notes.append(f"{block.name}: {NARROW} {', '.join(str(line) for line in sorted(set(translator.narrow)) if line)}")
        if block.name.startswith("OB") and block.name != "OB1":
            result.notes.append(f"{block.name}: the integrated PLC calls OB1 alone; call it with SU, at power-on with U M1020.4")
    missing = sorted(name for name in calls if name not in result.programs)
    result.notes += [f"{name} is called in {calls[name]} and is not in the list" for name in missing]
    result.refused.sort(key=lambda each: each.line)
    return result
