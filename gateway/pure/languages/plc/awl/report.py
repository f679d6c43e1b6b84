"""Imports a statement list: programs, and a reason for each line that was not translated."""

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.plc.awl.reader import OPERANDS, Block, Reader, Refused
from gateway.pure.languages.plc.awl.translator import OPENS, OPENS_NOT, Translator
from gateway.pure.languages.plc.awl.unfed import unfed

ROW = re.compile(r"((?:D[BX]\d+\.)?[A-Z]{1,3}\d+(?:\.\d+)?)\s*[=;,\t ]\s*(M\d+(?:\.\d)?)$")
BIT_WORD = re.compile(r"(?:D[BX]\d+\.)?[A-Z]+\d+\.\d")
BYTE_WORD = re.compile(r"(?:DL|DR|DBB)\d+$")
LAST_FREE = 511
MARKER = re.compile(r"\b(?:M[BWD]?|F[YWD]?)\s*(\d{1,4})")  # F: the flags of an English list of STEP 5
NARROW = "numbers are calculated with 32 bits; STEP 5 has 16: check lines"


@dataclass(slots=True)
class Imported:
    """Programs by name, refused lines, and lines to check."""

    programs: dict[str, str] = field(default_factory=dict)
    refused: list[Refused] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)  # blocks that are called and are nowhere: no PLC starts
    statements: int = 0

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        rows = [{"line": each.line, "block": each.block, "text": each.text, "reason": each.reason} for each in self.refused]
        return {"statements": self.statements, "refused": rows, "missing": self.missing, "notes": self.notes}


def words_of(table: str) -> tuple[Mapping[str, str], list[str]]:
    """Return the table of words and markers, and the lines that are not a row of it."""
    found: dict[str, str] = {}
    wrong: list[str] = []
    for number, line in enumerate(table.splitlines(), 1):
        text = " ".join(line.split("#")[0].upper().split())
        if not text:
            continue
        row = ROW.match(text)
        reason = _wrong_row(row[1], row[2], found) if row else f"{text[:60]!r} is not a row; write DB10.DW5 = M200"
        if row and not reason:
            found[row[1]] = row[2]
        else:
            wrong.append(f"table, line {number}: {reason}")
    return found, wrong


def _wrong_row(word: str, marker: str, found: Mapping[str, str]) -> str:
    """Why a row cannot count: bits get bits, the others bytes of their own below the system markers."""
    if word in found:
        return f"{word} is in the table twice"
    bit = BIT_WORD.match(word) is not None
    if bit != ("." in marker):
        return f"{word} needs {'a bit, M200.1' if bit else 'a byte to begin at, M200'}"
    if marker in found.values():
        return f"{marker} is in the table twice"
    first, last = _taken(word, marker)
    if last > LAST_FREE:
        return f"{word} = {marker}: M0 to M{LAST_FREE} are free, and {word} needs {last - first + 1}"
    for other, there in found.items():
        begin, end = _taken(other, there)
        if not bit and "." not in there and first <= end and begin <= last:
            return f"{word} = {marker} overlaps {other} = {there}, which uses M{begin} to M{end}"
    return ""


def _taken(word: str, marker: str) -> tuple[int, int]:
    """First and last marker byte of a row; a word is held in a double word (32 bits), DL, DR and DBB in a byte."""
    first = int(marker[1:].partition(".")[0])
    return first, first if "." in marker or BYTE_WORD.search(word) else first + 3


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


def _unclosed(block: Block) -> Iterator[Refused]:
    """Brackets that the block opens and does not close."""
    opened = []
    for each in block.statements:
        if each.word in OPENS or each.word in OPENS_NOT:
            opened.append(each)
        elif opened and (each.word == ")" or (each.word == "?" and ")" in each.text)):
            opened.pop()
    yield from (Refused(each.line, block.name, each.text[:100], "this bracket is not closed") for each in opened)


def imported(text: str, table: str = "", present: Collection[str] = ()) -> Imported:
    """The programs of a list.  `present`: names of programs that are there already and may be called."""
    reader = Reader(text)
    listing = reader.run()
    words, wrong = words_of(table)
    if reader.english:
        words = {_german(name): marker for name, marker in words.items()}
    result = Imported(refused=list(listing.refused), notes=[*listing.notes, *wrong])
    calls: dict[str, str] = {}
    spare, *pool = spare_bytes(text, words) or [""]
    names = frozenset(block.name for block in listing.blocks)
    for block in listing.blocks:
        translator = Translator(block, words, reader.english, spare, pool=pool, blocks=names)
        result.programs[block.name] = translator.run()
        result.statements += len(block.statements)
        known = {each.line for each in result.refused}
        result.refused += [each for each in translator.refused if each.line not in known]
        known |= {each.line for each in translator.refused}
        result.refused += [each for each in _unclosed(block) if each.line not in known]
        result.notes += unfed(block.name, block.statements, known)
        for name in translator.calls:
            calls.setdefault(name, block.name)
        if translator.spared:
            result.notes.append(f"{block.name}: {spare}.0 and {spare}.1 are auxiliary bits of edges; no other program may use them")
        if translator.local:
            rows = ", ".join(f"LB{byte} = {marker}" for byte, marker in sorted(translator.local.items()))
            result.notes.append(f"{block.name}: local bits: {rows}; no other program may use them")
        if translator.narrow:
            result.notes.append(f"{block.name}: {NARROW} {', '.join(str(line) for line in sorted(set(translator.narrow)) if line)}")
        if block.name.startswith("OB") and block.name != "OB1":
            result.notes.append(f"{block.name}: the integrated PLC calls OB1 only; call it with SU, at power-on with U M1020.4")
    result.missing = sorted(name for name in calls if name not in result.programs and name not in present)
    result.notes += [f"{name} is called in {calls[name]} and is not in the list; import it too, or write it" for name in result.missing]
    result.refused.sort(key=lambda each: each.line)
    return result
