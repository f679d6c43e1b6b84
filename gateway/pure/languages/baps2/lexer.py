"""Characters to tokens.  Line ends mean nothing but for comments and compiler instructions; names are compared without case.

Source: rho 3 releases, the programs printed (`;` comments L1156, `(* *)` L8084, `;;` instructions L1145, `::` for them D-30).
A `;` directly after a word that only assignments follow separates them (`AFACTOR=1;DFACTOR=1`, L11628; AX-690).
"""

import re
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
    word: str
    key: str  # the text as names are compared

    @classmethod
    def of(cls, kind: Kind, text: str, position: Position, word: str = "") -> "Token":
        """A token with its key."""
        return cls(kind, text, position, word, text.upper())

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


Known = dict[str, tuple[Kind, str, str, str]]  # names and signs that were here before: kind, text, word, key

_NUMBER = r"(?:\d+\.\d+|\d+|\.\d+)[eE][-+]?\d+(?!\w)|\d+\.\d+|\d+\.(?![.\w])|\.\d+|\d+"
_PATTERN = re.compile(  # the most frequent ones first; a look behind comes last, because it is tried at each place
    rf"""(?:(?P<name>@?[^\W\d]\w*)
      | (?P<line>\n)
      | (?P<number>(?>{_NUMBER}))(?![^\W\d]|\.\d)
      | (?P<run>{_NUMBER})  # a number that runs into what is behind it
      | (?P<instruction>(?:;[ \t]*;|::(?<!\w::)(?<!\w[ ]::))[^\n]*)
      | (?P<separator>;(?<=\w;)(?=[ \t]*@?[^\W\d]\w*[ \t]*=[ \t]*[-+]?[\w.%]+[ \t]*(?:[;,]|\n|$)))
      | (?P<comment>;[^\n]*|\(\*.*?\*\))
      | (?P<sign>(?!//)(?:<>|<=|>=|=<|=>|\.\.|[-+*/=<>(),:.\[\]@%]))
      | (?P<text>'[^'\n]*'|"[^"\n]*")
      | (?P<blank>[^\S\n]+)
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
    faults.error("number-runs-into-word", position, f"'{found}' runs into the next word", "put a blank between them")
    return found, match


def tokens_of(source: SourceFile, words: Words, faults: Faults) -> list[Token]:
    """All tokens, an END token last.  What is no token is a fault and is passed over."""
    text, at, line, start = source.text, 0, 1, 0
    name, above, size = source.name, source.included_from, len(source.text)
    tokens: list[Token] = []
    known: Known = {}
    add, seen, new = tokens.append, known.get, tuple.__new__  # tuple: a call less for each of the many tokens
    while at < size:
        for match in _PATTERN.finditer(text, at):
            begin = match.start()
            if begin != at:  # in between is what is no token
                break
            found, at = match[match.lastindex or 0], match.end()
            if (same := seen(found)) is not None:
                kind, shown, word, key = same
                add(new(Token, (kind, shown, new(Position, (name, line, begin - start + 1, above)), word, key)))
                continue
            group = match.lastgroup or ""
            if group == "line":
                line, start = line + 1, begin + 1
            elif group == "run":
                token, at = _run_on(match, source.at(line, begin - start + 1), words, known, faults)
                add(token)
                break
            elif group not in SKIPPED:
                add(_token(group, found, source.at(line, begin - start + 1), words, known))
            elif group == "comment" and "\n" in found:
                line, start = line + found.count("\n"), begin + found.rindex("\n") + 1
        if at < size and _PATTERN.match(text, at) is None:
            if _opens_behind(text, at) and tokens:
                faults.error("text-without-end", source.at(line, at - start + 1), "this text has no opening quote")
                faults.spoilt(tokens[-1].position)  # a word of it
                at += 1
                continue
            passed, meant = _unknown(text, at, source.at(line, at - start + 1), words, faults)
            at += passed
            if meant is not None:
                add(meant)
    add(Token.of(Kind.END, "", source.at(line, at - start + 1)))
    return tokens


def _opens_behind(text: str, at: int) -> bool:
    """Whether the quote there ends a word and its line: the quote in front of the text is missing."""
    end = text.find("\n", at)
    return text[at] in QUOTES and text[at - 1 : at].isalnum() and not text[at + 1 : end if end >= 0 else len(text)].strip()


def _token(group: str, found: str, position: Position, words: Words, known: Known) -> Token:
    """A token that is not known yet; names, signs and numbers are from then on."""
    if group == "text":
        return Token.of(Kind.TEXT, found[1:-1], position)
    if group == "instruction":
        return Token.of(Kind.INSTRUCTION, found.lstrip(";: \t").strip(), position)
    token = Token.of(Kind(group), _SAME.get(found, found), position, (words.token(found) or "") if group == "name" else "")
    known[found] = token.kind, token.text, token.word, token.key
    return token


def _run_on(match: re.Match[str], position: Position, words: Words, known: Known, faults: Faults) -> tuple[Token, int]:
    """A number that does not end where it should, and where to go on."""
    found, behind = match["run"], _BEHIND.match(match.string, match.end("run"))
    if behind is None:
        return Token.of(Kind.NUMBER, found, position), match.end()
    if found.isdigit() and words.token(behind[0]) is None and not behind[0].startswith("."):
        return _misnamed(found + behind[0], position, known, faults), behind.end()
    found, match = _runs_on(found, match, behind, position, faults)
    return Token.of(Kind.NUMBER, found, position), match.end()


def _misnamed(name: str, position: Position, known: Known, faults: Faults) -> Token:
    """A name that begins with a digit: it is said once, and the name is read as any other."""
    if name.upper() not in known:
        faults.error("name-begins-with-digit", position, f"{name} begins with a digit", "a name begins with a letter")
        known[name.upper()] = Kind.NAME, name, "", name.upper()
    faults.spoilt(position)
    return Token.of(Kind.NAME, name, position)


def _unknown(text: str, at: int, position: Position, words: Words, faults: Faults) -> tuple[int, Token | None]:
    """Reports what begins no token; how many characters to pass over, and the token that is meant."""
    if text[at] in QUOTES:
        end = text.find("\n", at)
        faults.error("text-without-end", position, "this text has no closing quote on its line")
        end = end if end >= 0 else len(text)
        return end - at, Token.of(Kind.TEXT, text[at + 1 : end], position)  # a value all the same
    if text.startswith("(*", at):
        faults.error("comment-without-end", position, "this comment has no closing *)")
        return len(text) - at, None
    if found := _STRANGE.match(text, at):
        return len(found[0]), _meant(found[0], position, words, faults)
    end = at + 1
    while end < len(text) and not text[end].isspace() and _PATTERN.match(text, end) is None:
        end += 1
    faults.error("no-token", position, f"'{text[at:end]}' has no meaning here")
    return end - at, None


def _meant(found: str, position: Position, words: Words, faults: Faults) -> Token | None:
    """A sign of another language, read as it was meant; None: a comment."""
    if found not in _MEANT:
        begin = found[:2] if found[0] == "/" else found[0]
        faults.error("no-token", position, f"{begin} does not begin a comment", "a semicolon begins a comment")
        return None
    sign = _MEANT[found]
    faults.error("no-token", position, f"'{found}' is not a sign", f"write {sign}")
    return Token.of(Kind.NAME if sign.isalpha() else Kind.SIGN, sign, position, words.token(sign) or "")
