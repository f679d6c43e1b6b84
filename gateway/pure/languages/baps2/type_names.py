"""Reads the types of declarations and parameters."""

from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.stream import Misread, Stream
from gateway.pure.languages.baps2.tree import Expression, Faulty, Head, TypeName
from gateway.pure.languages.base.near import hint_of, nearest
from gateway.pure.languages.base.source import Position

PLAIN = ("INTEGER", "REAL", "BINARY", "CHAR", "TEXT")
KINEMATIC = ("POINT", "JC_POINT", "WC_FRAME", "BELT")
TYPES = (*PLAIN, *KINEMATIC, "ARRAY", "INPUT", "OUTPUT", "FILE", "BNR_FILE", "SEMAPHORE")


class TypeReader:
    """Reads from a stream."""

    def __init__(self, stream: Stream, expressions: ExpressionReader, head: Head) -> None:
        self._stream, self._expressions, self._head = stream, expressions, head

    def unknown_kinematic(self) -> None:
        """Report the kinematic that is next and not declared; it is read as the one that it is like, if there is one."""
        token = self._stream.token
        hint = hint_of(token.key, self._head.kinematics)
        self._stream.faults.error("kinematic-unknown", token.position, f"kinematic {token.text} is not declared", hint)
        if meant := nearest(token.key, self._head.kinematics):
            self._stream.read_as_key(meant)
        else:
            self._head.kinematics[token.key] = max(self._head.kinematics.values(), default=0) + 1  # its uses are consequences

    def _is_kinematic(self, token: Token) -> bool:
        return token.kind is Kind.NAME and self._stream.ahead().text == "." and token.key in self._head.kinematics

    def _colon(self, where: str) -> bool:
        """Read the colon; report a missing or wrong one and still read the rest of the line.  False: a semicolon in its place turns the
        list into a comment.
        """
        if self._stream.sign(":"):
            self._stream.doubled(":")
            return True
        self._stream.missing("':'", where)
        if self._stream.commented():
            return False
        if self._stream.gap == self._stream.token.position:
            self._stream.faults.spoilt(self._stream.token.position)
        if not (self._stream.sign("=", ",", ".") or self._listed(self._stream.token)):
            raise Misread
        return True

    def _listed(self, token: Token) -> bool:
        """Whether a name or a number is next, in the line of the token before it."""
        named = token.kind is Kind.NAME and (not token.word or self._stream.is_foreign())
        return (named or token.kind is Kind.NUMBER) and token.position.line == self._stream.ahead(-1).position.line

    def type_name(self) -> TypeName:
        """A type as it is written."""
        token, kinematic = self._stream.token, ""
        if self._is_kinematic(token):
            kinematic = token.key
            self._stream.take()
            self._stream.take()
        elif self._stream.ahead().text == "." and self._stream.ahead(2).word in KINEMATIC:
            self.unknown_kinematic()
            return self.type_name()
        word = self._stream.token.word
        if word not in TYPES or (kinematic and word not in KINEMATIC):
            self._stream.wrong(f"a type is expected, not {self._stream.token}")
        self._stream.take()
        if word == "ARRAY":
            return self._array(token.position)
        element = ""
        if word in ("FILE", "INPUT", "OUTPUT") and self._misspelt_type():
            return TypeName(token.position, "" if word == "FILE" else word)
        if word in ("FILE", "INPUT", "OUTPUT") and self._stream.is_word((*PLAIN, *KINEMATIC)) and not self._stream.commented():
            element = self._stream.take().word
        return TypeName(token.position, word, kinematic, element=element)

    def _array(self, at: Position) -> TypeName:
        self._stream.expect_sign("[", "after ARRAY")
        low: Expression = Faulty(at)
        high: Expression = Faulty(at)
        depth = self._stream.depth
        try:
            low = self._expressions.read()
            self._stream.expect_sign("..", "between the bounds")
            high = self._expressions.read()
        except Misread:
            self._stream.back_to(depth)
            if not self._stream.passed_to_sign("]"):
                raise
        if not self._stream.sign("]"):
            self._stream.missing("']'", "after the bounds")
            if not self._stream.is_word(TYPES):
                raise Misread
        if self._misspelt_type():
            return TypeName(at, "")
        kind = self.type_name()
        if kind.base not in (*PLAIN, "POINT", "JC_POINT"):
            self._stream.wrong(f"{kind.base} is not a type of an element", at=kind.at)
        return TypeName(at, kind.base, kind.kinematic, low, high)

    def _misspelt_type(self) -> bool:
        """Whether a type before its colon is misspelt or missing: it is reported, and its names may be anything."""
        token, behind = self._stream.token, self._stream.ahead()
        if token.text == ":":
            if self._stream.ahead(-1).word in ("FILE", "INPUT", "OUTPUT"):
                return False  # they need none
            self._stream.faults.error("syntax", self._stream.gap, f"a type is missing in front of {token}")
            return True
        if self._is_kinematic(token) and self._stream.ahead(2).word not in KINEMATIC and self._stream.ahead(3).text == ":":
            self._stream.take()
            self._stream.take()
            token, behind = self._stream.token, self._stream.ahead()
        if token.kind is not Kind.NAME or token.word in TYPES or behind.text != ":":
            return False
        self._stream.faults.error("syntax", self._stream.gap, f"a type is expected, not {token}")
        self._stream.take()
        return True
