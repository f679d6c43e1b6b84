"""The tokens of a program with its included files in their place, read with one token of look-ahead and recovery after faults."""

from collections.abc import Collection
from typing import NoReturn

from gateway.pure.languages.baps2.lexer import Kind, Token, tokens_of
from gateway.pure.languages.baps2.slips import meant
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position, SourceFile
from gateway.pure.languages.base.store import ProgramStore

LONG_NAME = 12  # characters that count (L5677, L8837); longer names are printed (L6914)
MOST_INCLUDED = 16  # files one in the other
MOST_NESTED = 60  # statements and brackets one in the other


class Misread(Exception):
    """Inside the reader: the fault is reported, the reader goes on behind it."""


class Stream:
    """Tokens, and the places in which names are declared as far as the grammar needs them."""

    def __init__(self, source: SourceFile, words: Words, store: ProgramStore, faults: Faults) -> None:
        self.faults, self._words, self._store = faults, words, store
        self._tokens: list[Token] = []
        self._expand(source)
        self._next = 0
        self._last = len(self._tokens) - 1
        self._depth = 0
        self._too_deep = False
        self._routines: set[str] | None = None
        self.token = self._tokens[0]  # the token that is next

    def _expand(self, source: SourceFile) -> None:
        """Adds the tokens of a file; an included file in the place of its instruction, without its END token."""
        add = self._tokens.append
        for token in tokens_of(source, self._words, self.faults):
            if token.kind is Kind.INSTRUCTION:
                word, _, name = token.text.partition(" ")
                if word.upper() == "INCLUDE":
                    self._include(source, name.strip(" =:"), token.position)
                    continue
            add(token)
        if source.included_from is not None:
            self._tokens.pop()

    def _include(self, source: SourceFile, name: str, at: Position) -> None:
        file = name.upper() if "." in name else f"{name.upper()}.QLL"
        text = self._store.text(file)
        if not name or text is None:
            self.faults.error("include-missing", at, f"file {file} is not there" if name else "INCLUDE names no file")
        elif source.includes_itself(file):
            self.faults.error("include-loop", at, f"{file} includes itself")
        elif source.depth() >= MOST_INCLUDED:
            self.faults.error("include-too-deep", at, f"more than {MOST_INCLUDED} nested include files")
        else:
            self._expand(SourceFile(file, text, at))

    def ahead(self, count: int = 1) -> Token:
        """A token further on."""
        return self._tokens[min(self._next + count, self._last)]

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
        if self.token.kind is Kind.SIGN and self.token.text in signs:
            self.take()
            return True
        return False

    def is_sign(self, *signs: str) -> bool:
        """Whether one of these signs is next."""
        return self.token.kind is Kind.SIGN and self.token.text in signs

    def word(self, *words: str) -> bool:
        """Whether one of these words is next; it is taken."""
        if self.token.word in words and self.token.word:
            self.take()
            return True
        return False

    def is_word(self, words: Collection[str]) -> bool:
        """Whether one of these words is next."""
        return bool(self.token.word) and self.token.word in words

    def expect_sign(self, sign: str, where: str) -> None:
        """Takes the sign, or reports that it is missing."""
        if not self.sign(sign):
            self.wrong(f"'{sign}' is expected {where}, not {self.token}")

    def expect_word(self, word: str, where: str, goes_on: bool = False) -> None:
        """Takes the word, or reports that it is missing; a misspelt one is read as meant.  goes_on: its construct is read without it."""
        if self.word(word):
            return
        text = f"{word} is expected {where}, not {self.token}"
        misspelt = self.slip((word,))
        if not (misspelt or goes_on):
            self.wrong(text)
        self.faults.error("syntax", self.token.position, text)
        if misspelt:
            self.take()

    def slip(self, words: Collection[str]) -> str:
        """The spelling of the one of these words that the next name was meant to be; "": of none."""
        own = self.token.kind is Kind.NAME and not self.token.word
        return meant(self.token.text, self._words, words) if own else ""

    def read_as(self, spelling: str) -> None:
        """From now on the next token is this word of the language."""
        self.token = self._tokens[self._next] = self.token._replace(text=spelling, word=self._words.token(spelling) or "")

    @property
    def routines(self) -> Collection[str]:
        """Names of the subroutines of the text, also of those that follow."""
        if self._routines is None:
            pairs = zip(self._tokens, self._tokens[1:], strict=False)
            self._routines = {name.key for word, name in pairs if word.word == "SUBROUTINE"}
        return self._routines

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
        """Reports a fault and leaves the construct."""
        self.faults.error(id, at or self.token.position, text)
        raise Misread

    def deeper(self) -> None:
        """One level deeper; `back` takes it back.  The source may not nest without end."""
        self._depth += 1
        if self._depth > MOST_NESTED:
            self._depth -= 1
            if self._too_deep:  # it is said once; what follows is a consequence
                raise Misread
            self._too_deep = True
            self.wrong(f"more than {MOST_NESTED} nested levels", "nesting-too-deep")

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
