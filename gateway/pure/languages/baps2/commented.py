"""A semicolon instead of another sign makes a comment of the rest of its line: it is read as that sign (AX-1822)."""

import re
from collections.abc import Iterator, Mapping, Sequence

from gateway.pure.languages.baps2.lexer import Kind, Token, tokens_of
from gateway.pure.languages.baps2.repair import Repair
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.faults import Faults, Severity
from gateway.pure.languages.base.source import SourceFile

SIGNS = (",", "=", ":", "(")
MOST_TOKENS = 40  # of a comment that is a part of a program
_UNKNOWN = re.compile(r"(\S+) is not (?:declared|a subroutine|a belt)")


class Commented:
    """Finds such semicolons in the rows of the files of a program."""

    def __init__(self, rows: Mapping[str, Sequence[str]], words: Words) -> None:
        self._rows, self._words = rows, words

    def __call__(self, tokens: Sequence[Token], faults: Faults) -> Iterator[Repair]:
        """Comments in lines with a fault, and those with a name that is not known elsewhere."""
        errors = [each for each in faults if each.severity is Severity.ERROR]
        lines = {each.position[:2] for each in errors}
        unknown = {named[1].upper() for each in errors if (named := _UNKNOWN.match(each.text))}
        for place in range(1, len(tokens)):
            before, behind = tokens[place - 1 : place + 1]
            at = before.position
            if at.line == behind.position.line or at.included_from is not None or before.kind is Kind.INSTRUCTION:
                continue
            column = self._semicolon(before)
            if not column:
                continue
            found = self._tokens_of(at.file, at.line, column)
            wanted = any(token.key in unknown for token in found)
            if not found or len(found) > MOST_TOKENS or not (wanted or at[:2] in lines):
                continue
            for sign in SIGNS if at[:2] in lines else SIGNS[:1]:
                token = Token.of(Kind.SIGN, sign, at._replace(column=column))
                yield Repair(
                    place, token, f"'{sign}' is expected after {before}, not ';'", "a semicolon begins a comment", more=tuple(found)
                )

    def _semicolon(self, token: Token) -> int:
        """The column of the semicolon directly after the token, or 0."""
        row = self._row(token.position.file, token.position.line)
        end = token.end.column - 1
        rest = row[end:].lstrip()
        return len(row) - len(rest) + 1 if rest.startswith(";") and not rest.startswith(";;") else 0

    def _row(self, file: str, line: int) -> str:
        rows = self._rows.get(file, ())
        return rows[line - 1] if 0 < line <= len(rows) else ""

    def _tokens_of(self, file: str, line: int, column: int) -> list[Token]:
        """The tokens of the comment; none where it has what is no token."""
        rest = self._row(file, line)[column:].partition(";")[0]
        wrong = Faults()
        found = tokens_of(SourceFile(file, "\n" * (line - 1) + " " * column + rest), self._words, wrong)[:-1]
        return found if not len(wrong) else []
