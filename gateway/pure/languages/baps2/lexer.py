"""Characters to tokens.  Line ends mean nothing but for comments and compiler instructions; names are compared without case.

Source: rho 3 releases, the programs printed (`;` comments L1156, `(* *)` L8084, `;;` instructions L1145, `::` for them D-30).
A `;` directly after a word that only assignments follow separates them (`AFACTOR=1;DFACTOR=1`, L11628; AX-690).
"""

import re
from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position, SourceFile


class Kind(Enum):
    """What a token is."""

    NAME = "name"
    NUMBER = "number"
    TEXT = "text"
    SIGN = "sign"  # operators and punctuation
    INSTRUCTION = "compiler instruction"
    END = "end of file"


class Token(NamedTuple):
    """`text` is what the source has: texts without quotes, instructions with their comment.  `word` is of the word table, "" for names."""

    kind: Kind
    text: str
    position: Position
    word: str = ""

    @property
    def key(self) -> str:
        """The name as names are compared."""
        return self.text.upper()

    @property
    def end(self) -> Position:
        """The place directly after it."""
        quotes = 2 if self.kind is Kind.TEXT else 0
        return self.position._replace(column=self.position.column + len(self.text) + quotes)

    def touches(self, behind: "Token") -> bool:
        """Return whether the other one follows directly, without a blank."""
        here, there = self.position, behind.position
        return (here.line, here.file, here.column + len(self.text)) == (there.line, there.file, there.column)

    def __str__(self) -> str:
        return "the end of the file" if self.kind is Kind.END else f"'{self.text}'"


_PATTERN = re.compile(
    r"""(?:(?P<blank>[^\S\n]+)
      | (?P<line>\n)
      | (?P<instruction>(?:;[ \t]*;|(?<!\w)(?<!\w[ ])::)[^\n]*)
      | (?P<separator>(?<=\w);(?=[ \t]*@?[^\W\d]\w*[ \t]*=[ \t]*[-+]?[\w.%]+[ \t]*(?:[;,]|\n|$)))
      | (?P<comment>;[^\n]*|\(\*.*?\*\))
      | (?P<number>(?:\d+\.\d+|\d+|\.\d+)[eE][-+]?\d+(?!\w)|\d+\.\d+|\d+\.(?![.\w])|\.\d+|\d+)
      | (?P<name>@?[^\W\d]\w*)
      | (?P<text>'[^'\n]*'|"[^"\n]*")
      | (?P<sign>(?!//)(?:<>|<=|>=|=<|=>|\.\.|[-+*/=<>(),:.\[\]@%]))
    )[^\S\n]*  # blanks behind a token go with it: half as many matches
    """,
    re.VERBOSE | re.DOTALL,
)
_BEHIND = re.compile(r"[^\W\d]\w*|(?:\.\d+)+")  # a word directly after a number, or a second point in it
SKIPPED = ("blank", "comment", "separator")
QUOTES = "'\""
_SAME = {"=<": "<=", "=>": ">="}
_STRANGE = re.compile(r"//[^\n]*|\{[^{}\n]*\}|!=|&&?|\|\|?")
_MEANT = {"!=": "<>", "&": "AND", "&&": "AND", "|": "OR", "||": "OR"}  # signs of other languages


def _runs_on(found: str, match: re.Match[str], behind: re.Match[str], position: Position, faults: Faults) -> tuple[str, re.Match[str]]:
    """Reports a number that does not end where it should: what to read for it, and up to where."""
    if behind[0].startswith("."):
        faults.error("no-token", position, f"'{found}{behind[0]}' is not a number")
        return found.partition(".")[0] or "0", behind  # an integer fits everywhere
    faults.error("number-runs-into-word", position, f"'{found}' runs into the word behind it", "put a blank between them")
    return found, match


def tokens_of(source: SourceFile, words: Words, faults: Faults) -> Iterator[Token]:
    """Yield all tokens, an END token last.  Anything else is a fault and is skipped."""
    text, at, line, start = source.text, 0, 1, 0
    name, above, size, match_at = source.name, source.included_from, len(source.text), _PATTERN.match
    new = tuple.__new__  # a call less for each of the many tokens
    known: dict[str, tuple[Kind, str, str]] = {}  # names and signs that were here before
    while at < size:
        match = match_at(text, at)
        if match is None:
            size_of, meant = _unknown(text, at, source.at(line, at - start + 1), words, faults)
            at += size_of
            if meant is not None:
                yield meant
            continue
        kind = match.lastgroup or ""
        found = match[kind]
        if (same := known.get(found)) is not None:
            yield new(Token, (same[0], same[1], new(Position, (name, line, at - start + 1, above)), same[2]))
        elif kind == "line":
            line, start = line + 1, at + 1
        elif kind not in SKIPPED:
            position = new(Position, (name, line, at - start + 1, above))
            if kind == "name":
                known[found] = Kind.NAME, found, words.token(found) or ""
                yield Token(Kind.NAME, found, position, known[found][2])
            elif kind == "sign":
                known[found] = Kind.SIGN, _SAME.get(found, found), ""
                yield Token(Kind.SIGN, known[found][1], position)
            elif kind == "number":
                behind = _BEHIND.match(text, match.end(kind))
                if behind is None:
                    yield Token(Kind.NUMBER, found, position)
                elif found.isdigit() and words.token(behind[0]) is None:
                    yield _misnamed(found + behind[0], position, known, faults)
                    match = behind
                else:
                    found, match = _runs_on(found, match, behind, position, faults)
                    yield Token(Kind.NUMBER, found, position)
            elif kind == "text":
                yield Token(Kind.TEXT, found[1:-1], position)
            else:
                yield Token(Kind.INSTRUCTION, found.lstrip(";: \t").strip(), position)
        elif kind == "comment" and "\n" in found:
            line, start = line + found.count("\n"), at + found.rindex("\n") + 1
        at = match.end()
    yield Token(Kind.END, "", source.at(line, at - start + 1))


def _misnamed(name: str, position: Position, known: dict[str, tuple[Kind, str, str]], faults: Faults) -> Token:
    """Return a name that begins with a digit: it is reported once and read like any other."""
    if name.upper() not in known:
        faults.error("name-begins-with-digit", position, f"{name} begins with a digit", "a name begins with a letter")
        known[name.upper()] = Kind.NAME, name, ""
    faults.spoilt(position)
    return Token(Kind.NAME, name, position)


def _unknown(text: str, at: int, position: Position, words: Words, faults: Faults) -> tuple[int, Token | None]:
    """Reports what begins no token; how many characters to pass over, and the token that is meant."""
    if text[at] in QUOTES:
        end = text.find("\n", at)
        faults.error("text-without-end", position, "this text has no closing quote on its line")
        end = end if end >= 0 else len(text)
        return end - at, Token(Kind.TEXT, text[at + 1 : end], position)  # still a value
    if text.startswith("(*", at):
        faults.error("comment-without-end", position, "this comment has no closing *)")
        return len(text) - at, None
    if found := _STRANGE.match(text, at):
        return len(found[0]), _meant(found[0], position, words, faults)
    end = at + 1
    while end < len(text) and not text[end].isspace() and _PATTERN.match(text, end) is None:
        end += 1
    faults.error("no-token", position, f"'{text[at:end]}' means nothing here")
    return end - at, None


def _meant(found: str, position: Position, words: Words, faults: Faults) -> Token | None:
    """A sign of another language, read as it was meant; None: a comment."""
    if found not in _MEANT:
        begin = found[:2] if found[0] == "/" else found[0]
        faults.error("no-token", position, f"{begin} begins no comment", "a semicolon begins a comment")
        return None
    sign = _MEANT[found]
    faults.error("no-token", position, f"'{found}' is not a sign", f"write {sign}")
    return Token(Kind.NAME if sign.isalpha() else Kind.SIGN, sign, position, words.token(sign) or "")
