"""Reads expressions.  Order of the operators: OR, AND, NOT, comparisons, + -, * / MOD, sign, % (ours; the manual prints no table)."""

from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.stream import Stream
from gateway.pure.languages.baps2.tree import Binary, Call, Expression, Index, Member, Name, Number, PointValue, Text, Unary

COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")
FUNCTION_WORDS = {"CHAR": "CHR", "WC_FRAME": "WC_FRAME"}  # words that are functions in front of a bracket


class ExpressionReader:
    """Reads from a stream.  `names`: declared names, which win over words of the language."""

    def __init__(self, stream: Stream, names: set[str]) -> None:
        self._stream, self.names = stream, names

    def read(self) -> Expression:
        """A whole expression."""
        with self._stream.nested():
            return self._or()

    def sum(self) -> Expression:
        """An expression without comparisons: targets of moves."""
        with self._stream.nested():
            return self._sum()

    def names_it(self, token: Token) -> bool:
        """Whether the token is a name here: declared, or no word of the language."""
        return token.kind is Kind.NAME and (not token.word or token.key in self.names)

    def _word(self, *words: str) -> Token | None:
        token = self._stream.token
        return self._stream.take() if token.word in words and token.key not in self.names else None

    def _or(self) -> Expression:
        left = self._and()
        while token := self._word("OR"):
            left = Binary(token.position, "OR", left, self._and())
        return left

    def _and(self) -> Expression:
        left = self._not()
        while token := self._word("AND"):
            left = Binary(token.position, "AND", left, self._not())
        return left

    def _not(self) -> Expression:
        if token := self._word("NOT"):
            with self._stream.nested():
                return Unary(token.position, "NOT", self._not())
        return self._comparison()

    def _comparison(self) -> Expression:
        left = self._sum()
        while self._stream.is_sign(*COMPARISONS):
            token = self._stream.take()
            left = Binary(token.position, token.text, left, self._sum())
        return left

    def _sum(self) -> Expression:
        left = self._product()
        while self._stream.is_sign("+", "-"):
            token = self._stream.take()
            left = Binary(token.position, token.text, left, self._product())
        return left

    def _product(self) -> Expression:
        left = self._signed()
        while True:
            if self._stream.is_sign("*", "/"):
                token = self._stream.take()
                left = Binary(token.position, token.text, left, self._signed())
            elif found := self._word("MOD"):
                left = Binary(found.position, "MOD", left, self._signed())
            else:
                return left

    def _signed(self) -> Expression:
        if self._stream.is_sign("+", "-"):
            token = self._stream.take()
            with self._stream.nested():
                return Unary(token.position, token.text, self._signed())
        value = self._parts(self._operand())
        while self._stream.is_sign("%"):
            value = Unary(self._stream.take().position, "%", value)
        return value

    def _operand(self) -> Expression:
        token = self._stream.token
        match token.kind:
            case Kind.NUMBER:
                self._stream.take()
                return Number(token.position, _number(token.text))
            case Kind.TEXT:
                self._stream.take()
                return Text(token.position, token.text)
            case Kind.NAME:
                return self._named(token)
            case Kind.SIGN if token.text == "(":
                self._stream.take()
                values = self._list()
                return values[0] if len(values) == 1 else PointValue(token.position, values, joint=False)
            case Kind.SIGN if token.text == "@" and self._stream.ahead().text == "(":
                self._stream.take()
                self._stream.take()
                return PointValue(token.position, self._list(), joint=True)
        self._stream.wrong(f"a value is expected, not {token}")

    def _named(self, token: Token) -> Expression:
        if token.word and token.key not in self.names and not (token.word in FUNCTION_WORDS and self._stream.ahead().text == "("):
            self._stream.wrong(f"a value is expected, not the word {token}")
        self._stream.take()
        name = FUNCTION_WORDS.get(token.word, token.key) if token.key not in self.names else token.key
        if self._stream.is_sign("("):
            self._stream.take()
            return Call(token.position, name, self._list())
        return Name(token.position, name)

    def _list(self) -> tuple[Expression, ...]:
        """Values up to the closing bracket; the opening one is taken."""
        if self._stream.sign(")"):
            return ()
        values = [self.read()]
        while self._stream.sign(","):
            values.append(self.read())
        self._stream.expect_sign(")", "behind the values")
        return tuple(values)

    def _parts(self, value: Expression) -> Expression:
        """Components and elements behind a value."""
        while True:
            token = self._stream.token
            if self._stream.is_sign(".") and self._stream.ahead().kind is Kind.NAME and isinstance(value, Name | Member | Index):
                self._stream.take()
                value = Member(token.position, value, self._stream.take().key)
            elif self._stream.is_sign("["):
                self._stream.take()
                value = Index(token.position, value, self.read())
                self._stream.expect_sign("]", "behind the index")
            else:
                return value


def _number(text: str) -> int | float:
    return float(text) if "." in text else int(text)
