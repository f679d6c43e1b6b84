"""Printed listings become programs of a memory; repaired and missing parts are reported by line.  Source: L322-338, L592-606, L4348-4649.

A listing may be a table with bars, a numbered list, a block of code, with or without step numbers; several programs may follow one
another, each with its head.
"""

import difflib
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.plc.slips import DIGITS, meant
from gateway.pure.languages.plc.steps import Wrong, step_of
from gateway.pure.languages.robotstar.layout import is_numbered, steps_of, with_lost_numbers
from gateway.pure.languages.robotstar.path import CARTESIAN
from gateway.pure.languages.robotstar.program import HEADS
from gateway.pure.languages.robotstar.slips import command, parameters
from gateway.pure.languages.robotstar.words import Words

QUOTES = str.maketrans({"„": '"', "“": '"', "”": '"', "»": '"', "«": '"', "\u2013": "-", "\u00a0": " ", "\u2019": "'"})
_NUMBER = re.compile(r"S?\s*(\d+)\s*[.:)]?(\s+|$)", re.IGNORECASE)
_WORD = re.compile(r"(\\?\s*)([^\W\d][\w-]*)(.*)", re.DOTALL)
_MARKED = re.compile(r"(?:->|=>|>|-)\s*(?=S?\s*\d)")  # the cursor, or the step completed last (L1484)
_SECOND = re.compile(r"(?:\s+|\.)([^\W\d]\w*)")
_POSITION = re.compile(r"\b[XYZABC]\s*:|\bA\d+\s*:", re.IGNORECASE)
_PLC_NUMBER = re.compile(r"S?\s*(\d[\dOIl]*)\s*[.:)]?\s+(?=\S)", re.IGNORECASE)  # `8 )` is step 8
_PLC_HEAD = re.compile(r"(?:MPR|SPR|MAC|PAL|PLC|DIR)\b", re.IGNORECASE)  # SP is a jump of the PLC, M a label
_KIND = re.compile(r"\s*(#[NP])\b\s*,?\s*", re.IGNORECASE)
ALIKE = 0.84  # likeness of a misread word to a command


class PointFault(ValueError):
    """The table of points cannot be read."""


@dataclass(frozen=True, slots=True)
class Note:
    """What was repaired, or is missing, in a line of the listing."""

    line: int
    text: str


@dataclass(slots=True)
class Imported:
    """Programs as files of a memory (name -> text) and the notes."""

    files: dict[str, str] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)


@dataclass(slots=True)
class _Open:
    """The program that is being read."""

    name: str
    kind: str
    steps: list[str]
    ended: bool = False
    last: int = 0  # step number printed last

    def repeated(self, head: "_Open", printed: int) -> bool:
        """Whether a head is this program's own again: as a title above the steps, or at the top of the next page."""
        same = not self.ended and (head.kind, head.name) == (self.kind, self.name)
        return same and (not printed or len(self.steps) == 1)


def points_of(text: str) -> dict[str, str]:
    """Parameters of POSITION by the name of a point: columns name, X..C, optional Frame and axes; PointFault with a sentence."""
    text = text.removeprefix("\ufeff")
    sign = next((sign for sign in ";\t" if sign in text.partition("\n")[0]), ",")
    rows = [[cell.strip().strip('"') for cell in line.split(sign)] for line in text.splitlines()]
    if not rows or not rows[0] or rows[0][0].strip().lower() != "name":
        raise PointFault("the first line of the table of points names the columns: name,X,Y,Z,A,B,C[,Frame,A7..]")
    head = [column.strip().upper() for column in rows[0]]
    if any(column not in (*CARTESIAN, "FRAME") and not re.fullmatch(r"A\d{1,2}", column) for column in head[1:]):
        raise PointFault(f"columns are name, {', '.join(CARTESIAN)}, Frame, A1 .. A24; there is {', '.join(head[1:])}")
    found: dict[str, str] = {}
    for number, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        values = [cell.strip() if sign == "," else cell.strip().replace(",", ".") for cell in row[1:]]  # a German table: 4,5;5;6
        if len(row) != len(head) or any(not re.fullmatch(r"[+-]?\d+(\.\d+)?", value) for value in values if value):
            raise PointFault(f"line {number}: {len(head)} columns with a name and numbers with a decimal point are needed")
        given = {name: value for name, value in zip(head[1:], values, strict=True) if value}
        missing = [name for name in CARTESIAN if name not in given]
        axes = any(re.fullmatch(r"A\d{1,2}", name) for name in given)
        if missing and (len(missing) < len(CARTESIAN) or not axes):
            raise PointFault(f"line {number}: {row[0]}: {', '.join(missing)} missing; a point has all of X Y Z A B C, or its axes only")
        found[_plain(row[0])] = ", ".join(f"{'Frame' if name == 'FRAME' else name}:{value}" for name, value in given.items())
    return found


def _plain(name: str) -> str:
    return " ".join(name.strip().strip('<>"').upper().split())


def import_listing(text: str, words: Words, points: Mapping[str, str] | None = None, name: str = "LISTING") -> Imported:
    """All programs of a listing.  `name` is that of a program without a head."""
    result = Imported()
    program: _Open | None = None

    def add_note(number: int, words_of_note: str) -> None:
        result.notes.append(Note(number, words_of_note))

    lines = steps_of(text, lambda spelt: bool(words.descriptor(spelt)), lambda spelt: spelt.upper() in words.words, add_note)
    lines = with_lost_numbers(lines, add_note)
    numbered = is_numbered(line for _, line in lines)
    for number, line in lines:
        if program is not None and program.kind == "PLC" and not program.ended and (found := _plc_step(line)) is not None:
            _take_plc_step(program, result, number, *found, numbered)
            continue
        printed, step = _step(number, line, words, points or {}, result.notes, numbered)
        if step is None:
            if printed and program is not None:
                result.notes.append(Note(number, f"step {printed} is not printed"))
                program.last = printed
            continue
        word = step.lstrip("\\").split(None, 1)[0].rstrip(":").upper()
        if words.words.get(word) in HEADS and not step.startswith("\\"):
            head = _head(step, word, words)
            if program is not None and program.repeated(head, printed):
                result.notes.append(Note(number, f"the head of {program.name} is printed again; its steps go on"))
                program.last = printed or program.last
                continue
            _close(program, result, number)
            program, head.last = head, printed
            continue
        if numbered and not printed and (program is None or program.ended):
            add_note(number, f"{line.strip()[:40]!r} is not a step and is left out")  # a title of the page
            continue
        if program is None or program.ended:
            program = _Open(name, "MPR", [f'MPR "{name}"'])
            result.notes.append(Note(number, f"the head is not printed; main program {name} is assumed"))
        _count(program, printed, number, result)
        program.steps.append(step)
        if words.words.get(word) == "END":
            _close(program, result, number)
    _close(program, result, len(text.splitlines()))
    result.notes.sort(key=lambda note: note.line)
    return result


def _count(program: _Open, printed: int, line: int, result: Imported) -> None:
    """Takes the number of a step; those that are not printed are named."""
    if printed > program.last + 1 > 1:
        first, last = program.last + 1, printed - 1
        result.notes.append(Note(line, f"step {first} is not printed" if first == last else f"steps {first} to {last} are not printed"))
    program.last = printed or program.last


def _plc_step(line: str) -> tuple[int, str] | None:
    """(step number printed or 0, the step) of a PLC program, whose commands are not those of a robot; None: the head of a program."""
    text = _MARKED.sub("", line.translate(QUOTES).replace("|", " ").strip(), count=1)
    found = _PLC_NUMBER.match(text)
    text = text[found.end() :].strip() if found else text
    return None if _PLC_HEAD.match(text) else (int(found[1].translate(DIGITS)) if found else 0, text)


def _take_plc_step(program: _Open, result: Imported, line: int, printed: int, step: str, numbered: bool) -> None:
    """A step of a PLC program, put right where it is none as it is printed."""
    if not step or step.startswith("```"):
        return
    if numbered and not printed:
        result.notes.append(Note(line, f"{step[:40]!r} is not a step and is left out"))
        return
    _count(program, printed, line, result)
    if not _ends(step) and isinstance(step_of(step, 1), Wrong) and (better := meant(step)):
        comment = step.partition(";")[2]
        better = f"{better} ;{comment}" if comment else better
        result.notes.append(Note(line, f"{step} is read as {better}"))
        step = better
    program.steps.append(step)
    if _ends(step):
        _close(program, result, line)


def _ends(step: str) -> bool:
    return step.split(";", maxsplit=1)[0].strip().upper() in ("END", "ENDE")


def _head(step: str, word: str, words: Words) -> _Open:
    kind = words.words[word]
    rest = step.split(None, 1)[1] if " " in step else ""
    quoted = re.match(r"[\"']([^\"']+)[\"']|<([^>]+)>|([^\s(]+)", rest.removeprefix("name:").strip())
    name = re.sub(r"[^\w$-]+", "_", (quoted[1] or quoted[2] or quoted[3]) if quoted else "LISTING").strip("_") or "LISTING"
    return _Open(name.upper(), kind, [f'{kind} "{name.upper()}"'])


def _close(program: _Open | None, result: Imported, line: int) -> None:
    """Writes a program down; END is added where the print ends before it."""
    if program is None or program.ended:
        return
    if program.steps[-1].split()[0].upper() not in ("END", "ENDE"):
        result.notes.append(Note(line, f"{program.name}: END is not printed; it is added"))
        program.steps.append("END")
    program.ended = True
    file, number = f"{program.name}.{program.kind}", 1
    while file in result.files:
        number += 1
        file = f"{program.name}_{number}.{program.kind}"
        program.steps[0] = f'{program.kind} "{program.name}_{number}"'
    result.files[file] = "".join(f"{number:<4} {step}\n" for number, step in enumerate(program.steps, 1))


def _step(number: int, line: str, words: Words, points: Mapping[str, str], notes: list[Note], numbered: bool) -> tuple[int, str | None]:
    """(step number printed or 0, the step); None for a line that holds none."""
    text = line.translate(QUOTES).replace("**", "").strip()
    if text.startswith(("```", "#")) or re.fullmatch(r"[|\s:-]*", text):
        return 0, None
    if text.startswith("|"):
        text = " ".join(cell.strip() for cell in text.strip("|").split("|")).strip()
    text = _MARKED.sub("", text, count=1) if _MARKED.match(text) else text
    found = _NUMBER.match(text)
    printed = int(found[1]) if found else 0
    text = text[found.end() :].strip() if found else text
    if not text:
        return printed, None
    if text.startswith('"') and text.count('"') % 2:
        notes.append(Note(number, "an unpaired quotation mark is left out"))
        text = text[1:].strip()
    matched = _WORD.match(text)
    if not matched:
        notes.append(Note(number, f"{text[:40]!r} is not a step and is left out"))
        return printed, None
    spelt, rest = _joined(matched[2], matched[3], words)
    word = _repaired(number, spelt, words, notes, certain=bool(printed), numbered=numbered)
    if not word:
        return printed, None
    fixed = parameters(word, rest, words)
    if fixed != rest:
        notes.append(Note(number, f"{rest.strip()} is read as {fixed.strip()}"))
        rest = fixed
    return printed, f"{matched[1].strip()}{word}{_parameters(number, word, rest, words, points, notes)}"


def _joined(word: str, rest: str, words: Words) -> tuple[str, str]:
    """A command that is printed in two words, as BAHN RADIUS (L1774), and what follows it."""
    second = _SECOND.match(rest)
    for joint in "_", "":
        if second and (joint or word.upper() not in words.words) and f"{word}{joint}{second[1]}".upper() in words.words:
            return f"{word}{joint}{second[1]}", rest[second.end() :]
    return word, rest


def _repaired(number: int, word: str, words: Words, notes: list[Note], certain: bool, numbered: bool) -> str:
    """Return the word, a misread one corrected; "" where a line without a number is not a step."""
    if word.upper() in words.words or (word.startswith("_") and word.isupper()):
        return word
    bare = "".join(sign for sign in unicodedata.normalize("NFKD", word.upper()) if not unicodedata.combining(sign))
    alike = command(bare, words)
    near = [bare] if bare in words.words else [alike] if alike else difflib.get_close_matches(bare, list(words.words), 1, ALIKE)
    if near and (certain or near[0] in (bare, alike)):
        notes.append(Note(number, f"{word} is read as {near[0]}"))
        return near[0]
    if certain or (word.isupper() and not numbered):
        notes.append(Note(number, f"{word} is not a command; it is kept as the call of a macro"))
        return word
    notes.append(Note(number, f"{word} .. is not a step and is left out"))
    return ""


def _parameters(number: int, word: str, rest: str, words: Words, points: Mapping[str, str], notes: list[Note]) -> str:
    if words.words.get(word.upper()) != "POSITION" or _POSITION.search(rest) or re.match(r"\s*variable\s*:", rest, re.IGNORECASE):
        return f" {rest.strip()}" if rest.strip() and not rest.startswith((":", "[")) else rest.rstrip()
    kind = _KIND.match(rest)
    rest = rest[kind.end() :] if kind else rest
    rest = rest.partition("<")[0].strip() or rest.strip() if re.match(r"\s*\w+\s+<", rest) else rest.strip()  # A <start point>
    name, place = _plain(rest), kind[1].upper() if kind else "#N"
    if name in points:
        return f" {place}, {points[name]}"
    notes.append(Note(number, f"POSITION {name or 'without a name'}: the values are not printed; give them with --points"))
    return f" {rest}" if rest else f" {place}" if kind else ""
