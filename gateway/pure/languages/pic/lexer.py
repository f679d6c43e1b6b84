"""Words of a PIC program.  `;` begins a comment; line ends mean nothing but for labels of the instruction list."""

import re
from dataclasses import dataclass
from enum import Enum

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position

_TOKEN = re.compile(
    r"(?P<comment>;.*)|(?P<blank>\s+)|(?P<bit>[IOMEAioemea]\d{1,4}\.\d{1,2}(?!\w))"
    r"|(?P<slip>[IOMEAioemea][\dOo]{1,4}[.,][\dOo]{1,2}(?!\w)|[&|!])"
    r"|(?P<name>[^\W\d]\w*)|(?P<number>\d+)|(?P<sign>[=:()\-])"
)
MEANT = {"&": "AND", "|": "OR", "!": "NOT"}
DIGITS = str.maketrans({"O": "0", "o": "0", ",": "."})


class Kind(Enum):
    """What a token is."""

    NAME = "name"
    BIT = "bit"
    NUMBER = "number"
    SIGN = "sign"
    END = "end"


@dataclass(frozen=True, slots=True)
class Token:
    """`first`: the first of its line, `last`: the last."""

    kind: Kind
    text: str
    at: Position
    first: bool = False
    last: bool = False

    @property
    def word(self) -> str:
        """In upper case."""
        return self.text.upper()

    @property
    def end(self) -> Position:
        """The place directly after it."""
        return self.at._replace(column=self.at.column + len(self.text))


def tokens_of(text: str, file: str, faults: Faults) -> list[Token]:
    """Return all tokens, END last; any other character is a fault and skipped."""
    found: list[Token] = []
    for number, line in enumerate(text.splitlines(), 1):
        row = _row(line, file, number, faults)
        found += [Token(each.kind, each.text, each.at, n == 0, n == len(row) - 1) for n, each in enumerate(row)]
    end = found[-1].end if found else Position(file, 1)
    return [*found, Token(Kind.END, "", end)]


def _row(line: str, file: str, number: int, faults: Faults) -> list[Token]:
    found: list[Token] = []
    at = 0
    while at < len(line):
        match = _TOKEN.match(line, at)
        here = Position(file, number, at + 1)
        if match is None:
            faults.error("character", here, f"{line[at]!r} is not part of a PIC program", "a comment begins with ;")
            return found
        kind = match.lastgroup or ""
        if kind == "slip":
            found.append(_meant(match[0], here, faults))
        elif kind not in ("comment", "blank"):
            found.append(Token(Kind(kind), match[0], here))
        at = match.end()
    return found


def _meant(text: str, here: Position, faults: Faults) -> Token:
    """A sign of another language, or an address with a comma or a letter O: it is reported, and read as it was meant."""
    word = MEANT.get(text)
    meant = word or text[0] + text[1:].translate(DIGITS)
    faults.error("character", here, f"{text!r} is not part of a PIC program", f"write {meant}")
    return Token(Kind.NAME if word else Kind.BIT, meant, here)
