"""The tokens of a PIC program in sequence."""

from dataclasses import dataclass, field
from itertools import pairwise

from gateway.pure.languages.base.source import Position
from gateway.pure.languages.pic.lexer import Kind, Token


@dataclass(slots=True)
class TokenReader:
    """What is next, and further on."""

    tokens: list[Token]
    _at: int = field(default=0, init=False, kw_only=True)
    _colons: set[str] | None = field(default=None, init=False, kw_only=True)  # names before a colon

    @property
    def token(self) -> Token:
        """The next one."""
        return self.tokens[self._at]

    def _is_label(self, token: Token) -> bool:
        """Whether a colon follows it somewhere: a label may be a word of the other language (`ENDE:`)."""
        if self._colons is None:
            self._colons = {each.word for each, behind in pairwise(self.tokens) if behind.text == ":"}
        return token.word in self._colons

    def _ahead(self, by: int = 1) -> Token:
        return self.tokens[min(self._at + by, len(self.tokens) - 1)]

    def _take(self) -> Token:
        token = self.token
        if token.kind is not Kind.END:
            self._at += 1
        return token

    def _gap(self) -> Position:
        """Return the place of a missing token: before the next token, or after the last one read if that ends its line."""
        return self._ahead(-1).end if self._at and self.token.first else self.token.at

    def _is(self, spellings: tuple[str, ...]) -> bool:
        return self.token.kind is Kind.NAME and self.token.word in spellings

    def _sign(self, sign: str) -> bool:
        return self.token.kind is Kind.SIGN and self.token.text == sign
