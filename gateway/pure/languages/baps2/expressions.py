"""Reads expressions.  Order of the operators: OR, AND, NOT, comparisons, + -, * / MOD, sign, % (axisgate's; no table in the manual)."""

from collections.abc import Callable
from typing import TypeVar

from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.standard import CONDITIONS, CONVERSIONS, ENDS, FUNCTIONS, GERMAN
from gateway.pure.languages.baps2.stream import Stream
from gateway.pure.languages.baps2.tree import Binary, Call, Expression, Index, Member, Name, Number, PointValue, Text, Unary

T = TypeVar("T")
LEVELS = {"OR": 0, "AND": 1, **dict.fromkeys(("=", "<>", "<", ">", "<=", ">="), 3), "+": 4, "-": 4, "*": 5, "/": 5, "MOD": 5}
NOT_LEVEL, COMPARED = 2, 3
BEHIND_OPERAND = (".", "[", "%")
CALLED = frozenset((*FUNCTIONS, *CONVERSIONS, *CONDITIONS, *ENDS))  # their value is in brackets
BEHIND_VALUE = ("AND", "OR", "MOD", "THEN", "TIMES", "EQUAL", "MAX_TIME", "ERROR")
FUNCTION_WORDS = {"CHAR": "CHR", "WC_FRAME": "WC_FRAME"}  # words that are functions in front of a bracket


class ExpressionReader:
    """Reads from a stream.  `names`: declared names, which win over words of the language."""

    def __init__(self, stream: Stream, names: set[str]) -> None:
        self._stream, self.names = stream, names
        self._alone = False  # one value: a comma after a number does not separate values
        self._lines = False  # it may continue in the next line with a comparison that looks like an assignment

    def read(self) -> Expression:
        """Read a complete expression."""
        self._expect_value()
        return self._binary(0)

    def sum(self) -> Expression:
        """An expression without comparisons: targets of moves."""
        return self._binary(LEVELS["+"])

    def target(self) -> Expression:
        """A variable that is read."""
        self._expect_value()
        return self.sum()

    def alone(self) -> Expression:
        """Read a complete expression where a list of values is impossible, so that a comma in a number is a mistake."""
        return self._within(self.read, alone=True)

    def condition(self) -> Expression:
        """Read a complete condition, which a word of the language follows."""
        return self._within(self.read, alone=True, lines=True)

    def constant(self) -> Expression:
        """Read one constant of a list before a colon."""
        return self._within(self.sum, lines=True)

    def _within(self, read: Callable[[], T], *, alone: bool = False, lines: bool = False) -> T:
        before, self._alone, self._lines = (self._alone, self._lines), alone, lines
        try:
            return read()
        finally:
            self._alone, self._lines = before

    def _expect_value(self, *, compared: bool = False) -> None:
        """Reports a value that is missing at the end of a line: an assignment or a label begins the next one."""
        if (compared or not self._lines) and self._stream.ends_line():
            self._stream.wrong(f"a value is expected, not {self._stream.token}")

    def names_it(self, token: Token) -> bool:
        """Whether the token is a name here: declared, or no word of the language."""
        return token.kind is Kind.NAME and (not token.word or token.key in self.names)

    def _binary(self, lowest: int) -> Expression:
        """Operands joined by operators of this level and higher ones."""
        stream = self._stream
        stream.deeper()
        token = stream.token
        if token.word == "NOT" and lowest <= NOT_LEVEL and token.key not in self.names:
            stream.take()
            left: Expression = Unary(token.position, "NOT", self._binary(NOT_LEVEL))
        else:
            left = self._signed()
        while True:
            token = stream.token
            is_sign = token.kind is Kind.SIGN
            sign = token.text if is_sign else token.word
            level = LEVELS.get(sign, -1)
            if level < lowest or not (is_sign or token.key not in self.names):
                break
            if sign == "=" and not self._lines and stream.ahead(-1).position.line != token.position.line:
                break  # an assignment without its name
            at = stream.take().position
            if sign == "=":
                stream.doubled("=")
            if level > NOT_LEVEL and stream.token.position.line != at.line:  # what AND and OR join is a condition
                self._expect_value(compared=level == COMPARED)
            left = Binary(at, sign, left, self._binary(level + 1))
        stream.back()
        return left

    def _signed(self) -> Expression:
        token = self._stream.token
        if token.text in ("+", "-") and token.kind is Kind.SIGN:
            self._stream.take()
            self._stream.deeper()
            value: Expression = Unary(token.position, token.text, self._signed())
            self._stream.back()
            return value
        value = self._operand()
        if self._stream.token.text not in BEHIND_OPERAND:  # nearly always
            return value
        value = self._parts(value)
        while self._stream.is_sign("%"):
            value = Unary(self._stream.take().position, "%", value)
        return value

    def _operand(self) -> Expression:
        token = self._stream.token
        kind = token.kind
        if kind is Kind.NAME:
            return self._named(token)
        if kind is Kind.NUMBER:
            self._stream.take()
            return Number(token.position, _number(self._with_comma(token) if self._alone else token.text))
        if kind is Kind.TEXT:
            self._stream.take()
            return Text(token.position, token.text)
        if kind is Kind.SIGN and token.text == "(":
            self._stream.take()
            values = self._list()
            return values[0] if len(values) == 1 else PointValue(token.position, values, joint=False)
        if kind is Kind.SIGN and token.text == "@" and self._stream.ahead().text == "(":
            self._stream.take()
            self._stream.take()
            return PointValue(token.position, self._list(), joint=True)
        self._stream.wrong(f"a value is expected, not {token}")

    def _named(self, token: Token) -> Expression:
        name = token.key
        declared = name in self.names
        if token.word and not declared and not (token.word in FUNCTION_WORDS and self._stream.ahead().text == "("):
            if not self._foreign_name():
                self._stream.wrong(f"a value is expected, not the word {token}")
            token = token._replace(word="")
        self._stream.take()
        behind = self._stream.token
        if not declared:
            if name == "O" and behind.kind is Kind.NUMBER and token.touches(behind):
                return self._letter_o(token)
            name = FUNCTION_WORDS.get(token.word, GERMAN.get(name, name))
        if behind.text == "(" and behind.kind is Kind.SIGN:
            self._stream.take()
            return Call(token.position, name, self._list())
        if not declared and name in CALLED and behind.kind is Kind.NAME and behind.position.line == token.position.line and not behind.word:
            self._stream.faults.error("syntax", behind.position, f"'(' and ')' are missing around {behind}")
            return Call(token.position, name, (self._operand(),))
        return Name(token.position, name)

    def _foreign_name(self) -> bool:
        """Whether a word of the other language is a name that is not declared: a value is expected in this line, and its end follows."""
        token, behind = self._stream.token, self._stream.ahead()
        if token.position.line != self._stream.ahead(-1).position.line or not self._stream.is_foreign():
            return False
        ends = behind.kind in (Kind.SIGN, Kind.END) and behind.text != "("
        return ends or behind.word in BEHIND_VALUE or behind.position.line != token.position.line

    def _letter_o(self, token: Token) -> Expression:
        """`O.3`, which is meant to be 0.3."""
        rest = self._stream.take().text
        self._stream.faults.error("syntax", token.position, f"{token.text}{rest} begins with the letter O", f"write 0{rest}")
        return Number(token.position, float(f"0{rest}"))

    def _list(self) -> tuple[Expression, ...]:
        """Values up to the closing bracket; the opening one is taken."""
        if self._stream.sign(")"):
            return ()
        values = [self._within(self.read, lines=True)]
        while self._stream.sign(","):
            values.append(self._within(self.read, lines=True))
        self._stream.expect_sign(")", "after the values")
        return tuple(values)

    def _with_comma(self, token: Token) -> str:
        """A number; one with a comma is reported and read with a point."""
        comma, behind = self._stream.token, self._stream.ahead()
        if comma.text != "," or not (token.touches(comma) and comma.touches(behind) and token.text.isdigit() and behind.text.isdigit()):
            return token.text
        self._stream.take()
        self._stream.take()
        number = f"{token.text}.{behind.text}"
        self._stream.faults.error("syntax", token.position, f"{token.text},{behind.text}: a number has a point", f"write {number}")
        return number

    def _parts(self, value: Expression) -> Expression:
        """Read components and elements after a value."""
        while True:
            token = self._stream.token
            if token.kind is not Kind.SIGN:
                return value
            behind = self._stream.ahead()
            named = behind.kind is Kind.NAME and behind.position.line == token.position.line
            if token.text == "." and named and isinstance(value, Name | Member | Index):
                self._stream.take()
                name = self._stream.take().key
                value = Member(token.position, value, GERMAN.get(name, name))
            elif token.text == "." and isinstance(value, Name | Member | Index):
                self._stream.wrong(f"the name of a component is expected after '.', not {behind}", at=token.position)
            elif token.text == "[":
                self._stream.take()
                value = Index(token.position, value, self._within(self.read, lines=True))
                self._stream.expect_sign("]", "after the index")
            else:
                return value


def _number(text: str) -> int | float:
    return int(text) if text.isdigit() else float(text)
