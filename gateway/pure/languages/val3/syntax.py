"""Tokens and expressions of one line.  Source: VAL 3 reference 2.2 and 3, L600-1080; priorities L1511-1579 with doubt D03."""

import math
import re
from dataclasses import dataclass
from typing import NamedTuple

DEEPEST = 60  # operands one in the other
TOKEN = re.compile(
    r"\s*(?:(?P<num>(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)|(?P<text>\"[^\"]*\")"
    r"|(?P<op>==|!=|>=|<=|[-+*/%<>=!()\[\]{},.:&$]))"
)
ESCAPED = re.compile(r"\"(?:\\\"|[^\"])*\"")
GROUPS = (("or",), ("and",), ("xor",), ("!=", "=="), (">=", ">", "<=", "<"), ("-", "+"), ("%", "/", "*"))
STRICT = tuple((operator,) for operator in ("or", "and", "xor", "!=", "==", ">=", ">", "<=", "<", "-", "+", "%", "/", "*"))
RANKS = {operator: level for level, group in enumerate(GROUPS) for operator in group}
STRICT_RANKS = {operator: level for level, group in enumerate(STRICT) for operator in group}


class CompileFault(Exception):
    """One fault of a line; `column` counts from 1."""

    def __init__(self, text: str, column: int = 1) -> None:
        super().__init__(text)
        self.text, self.column = text, column


class Consequence(CompileFault):
    """Consequence of a fault reported elsewhere, in an unreadable file or declaration: the line itself is not at fault."""

    def __init__(self) -> None:
        super().__init__("")


class Token(NamedTuple):
    """kind: num, name, text, op, end."""

    kind: str
    text: str
    start: int
    end: int


@dataclass(slots=True)
class Node:
    """An expression; start and end are places in the line."""

    start: int
    end: int


@dataclass(slots=True)
class Number(Node):
    value: float


@dataclass(slots=True)
class Text(Node):
    value: str


@dataclass(slots=True)
class Name(Node):
    """A variable or constant, of a library where `library` is given."""

    library: str
    name: str


@dataclass(slots=True)
class Index(Node):
    base: Node
    indices: list[Node]


@dataclass(slots=True)
class Field(Node):
    base: Node
    name: str


@dataclass(slots=True)
class Invoke(Node):
    """An instruction with parameters."""

    library: str
    name: str
    arguments: list[Node]


@dataclass(slots=True)
class Literal(Node):
    """{a, b, ...}; None: an empty field."""

    parts: list[Node | None]


@dataclass(slots=True)
class Binary(Node):
    operator: str
    left: Node
    right: Node


@dataclass(slots=True)
class Unary(Node):
    operator: str
    operand: Node


@dataclass(slots=True)
class Assign(Node):
    target: Node
    value: Node


def tokens(line: str) -> list[Token]:
    """The tokens of a line.  CompileFault for a letter the language does not have."""
    found, at = [], 0
    escapes = line.count('"') % 2 == 1 or ('\\"' in line and line.replace('\\"', "").count('"') % 2 == 0)
    while at < len(line):
        if not line[at:].strip():
            break
        match = TOKEN.match(line, at)
        if match is None or match.lastgroup is None:
            rest = line[at:].strip()
            raise CompileFault(f"'{rest[:40]}' : unexpected character", line.index(rest, at) + 1)
        kind = match.lastgroup
        start, end = match.span(kind)
        if kind == "text" and escapes and (longer := ESCAPED.match(line, start)):
            end = longer.end()
        if kind == "num" and end < len(line) and (line[end].isalnum() or line[end] == "_"):
            wrong = re.match(r"\w+", line[start:])
            raise CompileFault(f"'{wrong.group() if wrong else line[start:end]}' : invalid name", start + 1)
        if kind == "op" and line.startswith("//", start):
            raise CompileFault(f"'{line[start:].strip()[:40]}' : comment not at the begin of the line", start + 1)
        found.append(Token(kind, line[start:end], start, end))
        at = end
    found.append(Token("end", "", len(line), len(line)))
    return found


class Expressions:
    """Parses the expressions of one line."""

    def __init__(self, line: str, *, strict: bool = False) -> None:
        self.line = line
        self.tokens = tokens(line)
        self.at = 0
        self.depth = 0
        self.ranks = STRICT_RANKS if strict else RANKS

    # ---- tokens ----------------------------------------------------------------------------------------------------------
    @property
    def next(self) -> Token:
        """The token that comes."""
        return self.tokens[self.at]

    def take(self) -> Token:
        """It is used up."""
        token = self.tokens[self.at]
        if token.kind != "end":
            self.at += 1
        return token

    def meets(self, text: str) -> bool:
        """Takes an operator or keyword if it comes."""
        token = self.next
        if token.kind in ("op", "name") and token.text.lower() == text:
            self.at += 1
            return True
        return False

    def demand(self, text: str) -> None:
        """An operator that must come."""
        if not self.meets(text):
            raise self.fault(f"'{text}' expected")

    def fault(self, text: str) -> CompileFault:
        """A fault at the token that comes."""
        token = self.next
        shown = f"'{token.text}' : " if token.text else ""
        return CompileFault(shown + text, token.start + 1)

    def finish(self) -> None:
        """Nothing may follow."""
        if self.next.kind != "end":
            raise self.fault("end of line expected")

    # ---- expressions -----------------------------------------------------------------------------------------------------
    def expression(self) -> Node:
        """With assignment, which groups to the right."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.fault("expression nested too deeply")
        start = self.next.start
        left = self._binary(0)
        if self.next.kind == "op" and self.next.text == "=":
            self.take()
            right = self.expression()
            left = Assign(start, self._end(), left, right)
        self.depth -= 1
        return left

    def _binary(self, level: int) -> Node:
        """Operators from this level on; those of a higher level bind tighter."""
        start = self.next.start
        left = self._unary()
        while True:
            token = self.tokens[self.at]
            rank = self.ranks.get(token.text.lower()) if token.kind in ("op", "name") else None
            if rank is None or rank < level:
                return left
            self.at += 1
            right = self._binary(rank + 1)
            left = Binary(start, self._end(), token.text.lower(), left, right)

    def _end(self) -> int:
        """Where the last token ends, a closing parenthesis for instance."""
        return self.tokens[self.at - 1].end

    def _unary(self) -> Node:
        token = self.next
        if token.kind == "op" and token.text in ("-", "!", "+"):
            self.take()
            self.depth += 1
            if self.depth > DEEPEST:
                raise self.fault("expression nested too deeply")
            operand = self._unary()
            self.depth -= 1
            return Unary(token.start, self._end(), token.text, operand) if token.text != "+" else operand
        return self._postfix(self._operand())

    def _postfix(self, node: Node) -> Node:
        while True:
            if self.next.kind == "op" and self.next.text == "[":
                self.take()
                indices = self._list("]")
                node = Index(node.start, self._end(), node, indices)
            elif self.next.kind == "op" and self.next.text == ".":
                self.take()
                name = self._name()
                node = Field(node.start, name.end, node, name.text)
            else:
                return node

    def _operand(self) -> Node:
        token = self.next
        if token.kind == "num":
            self.take()
            value = float(token.text)
            if not math.isfinite(value):
                raise CompileFault(f"'{token.text}' : number too large", token.start + 1)
            return Number(token.start, token.end, value)
        if token.kind == "text":
            self.take()
            return Text(token.start, token.end, token.text[1:-1].replace('\\"', '"'))
        if token.kind == "op" and token.text == "(":
            self.take()
            node = self.expression()
            self.demand(")")
            return node
        if token.kind == "op" and token.text == "{":
            return self._literal()
        if token.kind == "name":
            return self._named()
        raise self.fault("data expected")

    def _named(self, program: bool = False) -> Node:
        token = self._name(program)
        library, start = "", token.start
        if self.next.text == ":":
            self.take()
            library, token = token.text, self._name(program)
        if self.next.kind == "op" and self.next.text == "(":
            self.take()
            arguments = self._list(")")
            return Invoke(start, self._end(), library, token.text, arguments)
        return Name(start, token.end, library, token.text)

    def _name(self, program: bool = False) -> Token:
        token = self.next
        if token.kind != "name":
            raise self.fault("data expected")
        if token.text.startswith("_") and not program:
            raise self.fault("invalid name")
        return self.take()

    def _list(self, closing: str) -> list[Node]:
        found: list[Node] = []
        if self.meets(closing):
            return found
        while True:
            found.append(self.expression())
            if self.meets(closing):
                return found
            self.demand("," if self.next.kind != "end" else closing)

    def _literal(self) -> Node:
        start = self.take().start
        parts: list[Node | None] = []
        while True:
            empty = self.next.kind == "op" and self.next.text in (",", "}")
            parts.append(None if empty else self.expression())
            if self.meets("}"):
                return Literal(start, self._end(), parts)
            self.demand("," if self.next.kind != "end" else "}")
