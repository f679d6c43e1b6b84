"""One slip of a PIC program that causes several errors: what is written twice, exchanged, misspelt or missing is put right, and the
program is read again (AX-1854).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from operator import ne

from gateway.pure.languages.base.faults import Faults, Severity, SourceFault
from gateway.pure.languages.base.near import hint_with, nearest
from gateway.pure.languages.pic import words
from gateway.pure.languages.pic.lexer import Kind, Token

MOST_CAUSED = 6  # errors of a program in which a slip is looked for: one causes no more
MOST_TRIALS = 200
MOST_TOKENS = 40_000  # that are read again in all
KEYWORDS = (*words.NOT, *words.AND, *words.OR, *words.THEN, *words.IF, *words.JUMP)
SHORTEST = 3  # letters of a keyword that is compared
PLACEHOLDER = "M0.0"

Reading = Callable[[list[Token]], Faults]


@dataclass(frozen=True, slots=True)
class Slip:
    """The tokens without it, and the error that takes the place of those it caused."""

    tokens: list[Token]
    fault: SourceFault


def slip_of(tokens: list[Token], found: Faults, reading: Reading) -> tuple[SourceFault, Faults] | None:
    """The slip whose repair leaves the fewest errors, at least two fewer, and what is left; None: there is none."""
    if found.errors > MOST_CAUSED:
        return None
    best: tuple[SourceFault, Faults] | None = None
    fewest = found.errors - 1
    trials = min(MOST_TRIALS, MOST_TOKENS // len(tokens))
    for slip in islice(_slips(tokens, found), trials):
        left = reading(slip.tokens)
        if left.errors < fewest and all(each.position.line != slip.fault.position.line for each in left):
            best, fewest = (slip.fault, left), left.errors
        if not fewest:
            break
    return best


def _slips(tokens: list[Token], found: Faults) -> Iterator[Slip]:
    faulty = {each.position.line for each in found if each.severity is Severity.ERROR}
    lines = [line for line in _lines(tokens) if tokens[line.start].at.line in faulty]
    before = [earlier for earlier, line in pairwise(_lines(tokens)) if line in lines and earlier not in lines]
    labels = [label.text for label, colon in pairwise(tokens) if colon.text == ":"]
    kinds = (_doubled, _keywords, _operands, _exchanged, _colons)
    for line in (*lines, *before):
        for kind in kinds:
            yield from kind(tokens, line)
        yield from _targets(tokens, line, labels)


def _lines(tokens: Sequence[Token]) -> list[range]:
    starts = [place for place, token in enumerate(tokens) if token.first]
    return [range(start, behind) for start, behind in pairwise([*starts, len(tokens) - 1])]


def _changed(tokens: Sequence[Token], line: range, row: Sequence[Token]) -> list[Token]:
    placed = [replace(each, first=n == 0, last=n == len(row) - 1) for n, each in enumerate(row)]
    return [*tokens[: line.start], *placed, *tokens[line.stop :]]


def _slip(tokens: Sequence[Token], line: range, row: Sequence[Token], fault: SourceFault) -> Slip:
    return Slip(_changed(tokens, line, row), fault)


def _doubled(tokens: Sequence[Token], line: range) -> Iterator[Slip]:
    row = tokens[line.start : line.stop]
    for at, (first, second) in enumerate(pairwise(row), 1):
        if first.word == second.word:
            fault = SourceFault("twice", second.at, f"{second.text} is written twice")
            yield _slip(tokens, line, [*row[:at], *row[at + 1 :]], fault)


def _keywords(tokens: Sequence[Token], line: range) -> Iterator[Slip]:
    row = tokens[line.start : line.stop]
    for at, token in enumerate(row):
        meant = _keyword(token.word) if token.kind is Kind.NAME and token.word not in words.RESERVED else ""
        if meant:
            fault = SourceFault("name", token.at, f"{token.text} is neither a signal nor a symbol", hint=hint_with([meant]))
            yield _slip(tokens, line, [*row[:at], replace(token, text=meant), *row[at + 1 :]], fault)


def _keyword(word: str) -> str:
    """The one that it looks like; of three letters one may be wrong, because the program is read again with it."""
    short = (each for each in KEYWORDS if len(each) == len(word) == SHORTEST and sum(map(ne, each, word)) == 1)
    return nearest(word, KEYWORDS) or next(short, "")


def _exchanged(tokens: Sequence[Token], line: range) -> Iterator[Slip]:
    row = tokens[line.start : line.stop]
    for at, (first, second) in enumerate(pairwise(row)):
        if first.word != second.word:
            fault = SourceFault(
                "exchanged", first.at, f"{first.text} and {second.text} are exchanged", hint=f"write {second.text} {first.text}"
            )
            yield _slip(tokens, line, [*row[:at], second, first, *row[at + 2 :]], fault)


def _colons(tokens: Sequence[Token], line: range) -> Iterator[Slip]:
    """A label alone in its line that lacks its colon or its name; in an instruction list a hyphen precedes the name."""
    row = tokens[line.start : line.stop]
    name, hyphen = row[-1], row[0].text == "-"
    if len(row) == 1 and name.kind is Kind.NAME:
        fault = SourceFault("label", name.end, f"':' is missing after {name.text}", hint=f"a label is written {name.text}:")
        yield _slip(tokens, line, [name, Token(Kind.SIGN, ":", name.end)], fault)
    elif hyphen and len(row) == 1:
        fault = SourceFault("label", name.end, "the name of a label is expected")
        yield from (_slip(tokens, line, [name, Token(Kind.NAME, target, name.end)], fault) for target in _jumped(tokens))
    elif row[0].text == ":" and len(row) == 1:
        fault = SourceFault("label", name.at, "the name of a label is expected")
        yield from (_slip(tokens, line, [Token(Kind.NAME, target, name.at), name], fault) for target in _jumped(tokens))


def _jumped(tokens: Sequence[Token]) -> list[str]:
    """The names that a JUMP or JC leads to, each once."""
    leads = {*words.JUMP, *words.JUMPS}
    found = [
        after.text if behind.text == "-" else behind.text
        for lead, behind, after in zip(tokens, tokens[1:], tokens[2:], strict=False)
        if lead.word in leads
    ]
    return list(dict.fromkeys(found))


def _operands(tokens: Sequence[Token], line: range) -> Iterator[Slip]:
    """A signal that is missing at the end of the line or before =."""
    row = tokens[line.start : line.stop]
    for at in range(len(row) + 1):
        before = row[at - 1] if at else None
        behind = row[at] if at < len(row) else None
        gap = before.end if before is not None else row[0].at
        ends = behind is None and before is not None and before.text in ("-", "=", *words.NOT, *words.AND, *words.OR)
        if ends or (behind is not None and behind.text == "=" and (before is None or before.kind is not Kind.NAME)):
            fault = SourceFault("operand", gap, "a signal or an address is expected here")
            yield _slip(tokens, line, [*row[:at], Token(Kind.BIT, PLACEHOLDER, gap), *row[at:]], fault)


def _targets(tokens: Sequence[Token], line: range, labels: Sequence[str]) -> Iterator[Slip]:
    """JUMP without the name of its label."""
    row = tokens[line.start : line.stop]
    if row[-1].word in words.JUMP and labels:
        fault = SourceFault("label", row[-1].end, "the name of a label is expected")
        yield _slip(tokens, line, [*row, Token(Kind.NAME, labels[0], row[-1].end)], fault)
