"""The tokens of a program with its included files in their place, read with one token of look-ahead and recovery after faults."""

import re
from collections.abc import Callable, Collection, Iterable
from typing import NoReturn

from gateway.pure.languages.baps2.expansion import expanded
from gateway.pure.languages.baps2.homonyms import called, is_foreign, labels_among, language_of, named, no_subroutines
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.slips import meant
from gateway.pure.languages.baps2.standard import PROCEDURES
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position, SourceFile
from gateway.pure.languages.base.store import ProgramStore

_NAME = re.compile(r"@?[^\W\d]\w*")
_ITEM = r"(?:\d+\s*=\s*)?@?[^\W\d]\w*(?:\s*=\s*-?[\d.]+)?"  # of a list of names, channels or constants
_LIST = re.compile(rf";\s*{_ITEM}(?:\s*,\s*{_ITEM})*\s*")
LONG_NAME = 12  # characters that count (L5677, L8837); longer names are printed (L6914)
MOST_NESTED = 60  # statements and brackets one in the other


class Misread(Exception):
    """Inside the reader: the fault is reported, the reader continues after it."""


class Stream:
    """Tokens, and the places in which names are declared as far as the grammar needs them."""

    def __init__(
        self,
        source: SourceFile,
        words: Words,
        store: ProgramStore,
        faults: Faults,
        repairs: Iterable[Callable[[list[Token]], None]] = (),
    ) -> None:
        """`repairs`: each changes the tokens as they were meant."""
        self.faults, self._words = faults, words
        self._tokens, self._rows = expanded(source, words, store, faults)
        for repair in repairs:
            repair(self._tokens)
        for place in no_subroutines(self._tokens, words):
            self._tokens[place] = self._tokens[place]._replace(word="")
        self._next = 0
        self._last = len(self._tokens) - 1
        self._depth = 0
        self.too_deep = False  # it is reported; constructs are read without their ends from there on
        self._names: tuple[set[str], set[str]] | None = None  # of subroutines, and after JUMP
        self._marked: set[str] | None = None  # names followed by a colon
        self._labels: set[str] | None = None  # that are words of the language
        self.token = self._tokens[0]  # the token that is next

    def ahead(self, count: int = 1) -> Token:
        """A token further on."""
        try:
            return self._tokens[self._next + count]
        except IndexError:
            return self._tokens[self._last]

    @property
    def place(self) -> int:
        """A number that grows with each token taken."""
        return self._next

    def take(self) -> Token:
        """The next token; the END token is never passed."""
        token = self.token
        if self._next < self._last:
            self._next += 1
            self.token = self._tokens[self._next]
        return token

    def sign(self, *signs: str) -> bool:
        """Whether one of these signs is next; it is taken."""
        if self.token.text in signs and self.token.kind is Kind.SIGN:
            self.take()
            return True
        return False

    def is_sign(self, *signs: str) -> bool:
        """Whether one of these signs is next."""
        return self.token.text in signs and self.token.kind is Kind.SIGN

    def word(self, *words: str) -> bool:
        """Whether one of these words is next; it is taken."""
        if self.token.word in words and self.token.word:
            self.take()
            return True
        return False

    def is_word(self, words: Collection[str]) -> bool:
        """Whether one of these words is next."""
        return bool(self.token.word) and self.token.word in words

    def passed_to_sign(self, sign: str) -> bool:
        """Passes over to this sign in the line; False: it is not there."""
        line = self.ahead(-1).position.line
        while self.token.position.line == line and self.token.kind is not Kind.END and not self.is_sign(sign):
            self.take()
        return self.is_sign(sign)

    def expect_sign(self, sign: str, where: str) -> None:
        """Takes the sign, or reports that it is missing."""
        if not self.sign(sign):
            self.missing(f"'{sign}'", where)
            raise Misread

    def missing(self, what: str, where: str) -> None:
        """Report a missing token, at a semicolon in its place, which begins a comment; reading may continue without it."""
        at, hint = self.gap, ""
        comment, column = self._comment()
        if comment:
            at, hint = self.ahead(-1).position._replace(column=column), "a semicolon begins a comment"
        self.faults.error("syntax", at, f"{what} is expected {where}, not {self.token}", hint)

    @property
    def gap(self) -> Position:
        """Return the place of a missing token: before the next token, or after the last one read if that ends its line."""
        before = self.ahead(-1)
        same = before.position[:2] == self.token.position[:2] or before.kind is Kind.INSTRUCTION or not self._next
        return self.token.position if same else before.end

    def ends_line(self) -> bool:
        """Whether the token that was taken ends its line, and an assignment, a call or a label begins the next one."""
        line, place, depth = self.token.position.line, 1, 0
        if self.token.kind is not Kind.NAME or line == self.ahead(-1).position.line:
            return False
        if self.ahead().text == "(":
            return self.token.key in self.routines or self.token.key in PROCEDURES
        while (token := self.ahead(place)).position.line == line and (depth or token.text in (".", "[")):  # components and elements
            if token.kind is Kind.END:
                return False
            depth += (token.text == "[") - (token.text == "]")
            place += 2 if token.text == "." else 1
        return token.text in ("=", ":") and token.position.line == line

    def _comment(self) -> tuple[str, int]:
        """What follows the token that was taken in its line, if it begins with a semicolon, and the column; else "" and 0."""
        token = self.ahead(-1)
        if self.token.position.line == token.position.line or not self._next:
            return "", 0
        rows = self._rows[token.position.file]
        row = rows[token.position.line - 1] if token.position.line <= len(rows) else ""
        end = token.position.column - 1 + len(token.text)
        rest = row[end:].lstrip()
        return (rest, len(row) - len(rest) + 1) if rest.startswith(";") else ("", 0)

    def commented(self) -> list[Token]:
        """Return names of a list in the comment after the last token read: the semicolon may be meant as another sign."""
        comment, column = self._comment()
        if not comment or _LIST.fullmatch(comment) is None:
            return []
        at = self.ahead(-1).position
        return [Token.of(Kind.NAME, each[0], at._replace(column=column + each.start())) for each in _NAME.finditer(comment)]

    def doubled(self, sign: str) -> None:
        """Read and report the same sign directly after the one just read."""
        if self.is_sign(sign) and self.ahead(-1).touches(self.token):
            self.faults.error("syntax", self.token.position, f"'{sign}{sign}' is not a sign", f"write {sign}")
            self.take()

    def comma(self) -> bool:
        """Read a comma; report a second one directly after it."""
        taken = self.sign(",")
        if taken:
            self.doubled(",")
        return taken

    def joins(self, whole: str) -> bool:
        """Whether the next two tokens are this word of the language in two parts; they are one from now on."""
        word = self._words.token(whole)
        if word is not None:
            self._tokens[self._next] = self.token._replace(text=whole, word=word, key=whole.upper())
            del self._tokens[self._next + 1]
            self._last -= 1
            self.token = self._tokens[self._next]
        return word is not None

    def expect_word(self, word: str, where: str, goes_on: bool = False) -> None:
        """Takes the word, or reports that it is missing; a misspelt one is read as meant.  goes_on: its construct is read without it."""
        if self.word(word):
            return
        text = f"{word} is expected {where}, not {self.token}"
        misspelt = self.slip((word,))
        if not (misspelt or goes_on):
            self.wrong(text)
        self.faults.error("syntax", self.token.position if misspelt else self.gap, text)
        if misspelt:
            self.take()

    def slip(self, words: Collection[str], place: int = 0) -> str:
        """The spelling of the one of these words that the name there was meant to be; "": of none."""
        token = self.ahead(place)
        own = token.kind is Kind.NAME and not token.word
        return meant(token.text, self._words, words, language_of(self._tokens, self._words)) if own else ""

    def read_as(self, spelling: str) -> None:
        """From now on the next token is this word of the language."""
        word, key = self._words.token(spelling) or "", spelling.upper()
        self.token = self._tokens[self._next] = self.token._replace(text=spelling, word=word, key=key)

    @property
    def routines(self) -> Collection[str]:
        """Names of the subroutines of the text, also of those that follow."""
        return self._called()[0]

    @property
    def jumped(self) -> Collection[str]:
        """Names that a JUMP of the text leads to."""
        return self._called()[1]

    def is_label(self, key: str) -> bool:
        """Whether a colon follows the name somewhere in the text."""
        if self._marked is None:
            pairs = zip(self._tokens, self._tokens[1:], strict=False)
            self._marked = {before.key for before, behind in pairs if behind.text == ":" and before.kind is Kind.NAME}
        return key in self._marked

    def _called(self) -> tuple[set[str], set[str]]:
        if self._names is None:
            self._names = called(self._tokens)
        return self._names

    def settle(self, names: Collection[str]) -> None:
        """In the routine that begins, words that are names of this text are names and no words."""
        if self._labels is None:
            ends = {token.key for token in self._tokens if token.word in ("END", "ERROR")}  # only as a label has it a colon
            self._labels = labels_among({name for name in self.jumped if name in self._words} | ends, self._tokens)
        homonyms = {name for name in (*names, *self.routines) if name in self._words}
        if not (homonyms or self._labels):
            return
        for place in named(self._tokens, self._next, homonyms, self._labels, self._words):
            self._tokens[place] = self._tokens[place]._replace(word="")
        self.token = self._tokens[self._next]

    def is_foreign(self, token: Token | None = None) -> bool:
        """Whether this token, or the next one, is a word of the other language alone."""
        return is_foreign(token or self.token, language_of(self._tokens, self._words), self._words)

    def read_as_key(self, key: str) -> None:
        """From now on the next token is this name."""
        self.token = self._tokens[self._next] = self.token._replace(key=key)

    def read_as_name(self) -> None:
        """From now on the next token is a name."""
        self.token = self._tokens[self._next] = self.token._replace(word="")

    def name(self, what: str) -> Token:
        """Takes a name; words of the language may be names too, where one is expected."""
        if self.token.kind is not Kind.NAME:
            self.wrong(f"{what} is expected, not {self.token}")
        return self.take()

    def length(self, token: Token) -> Token:
        """Warns of a name that is too long."""
        if len(token.text.lstrip("@")) > LONG_NAME:
            self.faults.warning("long-name", token.position, f"{token.text} has more than {LONG_NAME} characters")
        return token

    def wrong(self, text: str, id: str = "syntax", at: Position | None = None) -> NoReturn:
        """Report a missing token or a fault at a place, and leave the construct."""
        if not self.too_deep:
            self.faults.error(id, at or self.gap, text)
        raise Misread

    def deeper(self) -> None:
        """Enter one level; `back` leaves it.  The depth of nesting is limited."""
        self._depth += 1
        if self._depth > MOST_NESTED:
            self._depth -= 1
            if not self.too_deep:  # reported once; further faults are consequences
                self.faults.error("nesting-too-deep", self.token.position, f"more than {MOST_NESTED} nested levels")
            self.too_deep = True
            raise Misread

    def back(self) -> None:
        """One level less deep."""
        self._depth -= 1

    @property
    def depth(self) -> int:
        """Levels open."""
        return self._depth

    def back_to(self, depth: int) -> None:
        """The level of a construct that was left by a fault."""
        self._depth = depth
