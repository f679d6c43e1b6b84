"""Mistakes of typing among statements: each is one fault at its place, and reading continues as intended (AX-1734, AX-1747)."""

from collections.abc import Callable, Collection

from gateway.pure.languages.baps2.declarations import DeclarationReader
from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.slips import ELSE_IF, IN_FRONT, REMEDIES, WHOLE_LINES
from gateway.pure.languages.baps2.standard import DEVICES, FACTORS, FUNCTIONS
from gateway.pure.languages.baps2.stream import Misread, Stream
from gateway.pure.languages.baps2.tree import Expression, Faulty, Head
from gateway.pure.languages.base.near import hint_of
from gateway.pure.languages.base.source import Position

CLOSERS = frozenset(
    "END PROGRAM_END SUB_END REPEAT_END PARALLEL_END ALSO EXCLUSIVE_END CASE_END EQUAL DEFAULT ELSE SUBROUTINE PROGRAM".split()
)
BEHIND_KINEMATIC = ("LINEAR", "PTP", "CIRCULAR", "WITH", "UNTIL", "TO", "VIA")
WITH_OPERAND = frozenset(  # their operand is in their line
    "MOVE MOVE_REL WAIT IF CASE REPEAT EXCLUSIVE JUMP START STOP SYNC SYNCHRON "
    "READ WRITE READ_BEGIN WRITE_BEGIN WRITE_END CLOSE ASSIGN".split()
)
OF_FILES = ("READ", "WRITE", "READ_BEGIN", "WRITE_BEGIN", "WRITE_END", "CLOSE", "ASSIGN")  # a file may follow
OPERATORS = ("UNTIL", "AND", "OR", "NOT", "WITH")  # a value follows, not a statement
WAITING = ("(", "[", "+", "-", "*", "/", ",", "=", "<", ">", "<=", ">=", "<>")  # a value follows here, too
SECOND = ("END", "BEGIN")  # words that are the second half of others
IN_TWO = ("TIMES", "EQUAL")  # words that may follow the first half of a word in two
NEAR = 2  # lines in which the rest of a statement is looked for


class Mistakes:
    """What was meant.  `begins`: words that begin a statement."""

    def __init__(
        self, stream: Stream, expressions: ExpressionReader, declarations: DeclarationReader, head: Head, begins: Collection[str]
    ) -> None:
        self._stream, self._expressions, self._declarations = stream, expressions, declarations
        self._head, self._begins = head, begins
        self._strange: set[str] = set()  # remedies that are reported

    def is_known(self, token: Token) -> bool:
        """Whether the name is declared, a subroutine or a kinematic."""
        key = token.key
        return key in self._expressions.names or key in self._stream.routines or key in self._head.kinematics

    # ---- misspelt words

    def misspelt(self, words: Collection[str]) -> bool:
        """Whether one of these words is next with a slip in it; it is reported, and read as it was meant."""
        token, following = self._stream.token, self._stream.ahead()
        if (
            token.kind is not Kind.NAME
            or token.word
            or following.text in ("=", "[", ".", ":", "(")
            or self.is_known(token)
            or token.key in self._stream.jumped
        ):
            return False
        alone = following.kind is Kind.END or following.position.line != token.position.line
        if following.key in self._declarations.files:
            words = [each for each in words if each in OF_FILES] or words
        spelling = self._stream.slip([each for each in words if not (alone and each in WITH_OPERAND)])
        if spelling:
            self._stream.faults.error("name-unknown", token.position, f"{token.text} is not a subroutine", f"did you mean {spelling}?")
            self._stream.read_as(spelling)
        return bool(spelling)

    def misspelt_part(self, words: Collection[str], where: str) -> None:
        """The same for words inside a statement, before a name, a number or a bracket in their line."""
        token, following = self._stream.token, self._stream.ahead()
        if token.word or token.kind is not Kind.NAME:
            return
        goes_on = following.kind in (Kind.NAME, Kind.NUMBER) or following.text in ("(", "@", "=")
        if self.is_known(token) or not goes_on or following.position.line != token.position.line:
            return
        if spelling := self._stream.slip(words):
            self._stream.faults.error("syntax", token.position, f"{spelling} is expected {where}, not {token}")
            self._stream.read_as(spelling)

    def in_two(self) -> bool:
        """Whether a word is next that has a blank in the place of its underscore; it is reported, and read as one."""
        following = self._stream.ahead()
        if following.word not in SECOND:  # nearly always
            return False
        token, behind = self._stream.token, self._stream.ahead(2)
        if token.kind is not Kind.NAME or following.position.line != token.position.line:
            return False
        whole = f"{token.text}_{following.text}"
        of_program = token.word in ("PROGRAM", "SUBROUTINE") and not (behind.kind is Kind.END or behind.word == "SUBROUTINE")
        goes_on = behind.word in IN_TWO or behind.text in (".", "[", "=")
        if of_program or goes_on or following.key in self._expressions.names or not self._stream.joins(whole):
            return False
        self._stream.faults.error("syntax", token.position, f"{token.text} {following.text} is one word", f"write {whole}")
        return True

    def stranger(self) -> bool:
        """Whether a word of another language is next that BAPS2 has no word for: it is reported, and its line passed over."""
        token = self._stream.token
        remedy = REMEDIES.get(token.key, "") if token.kind is Kind.NAME else ""
        if not remedy or self.is_known(token) or self._stream.ahead().text in ("=", ":", ".", "["):
            return False
        if remedy not in self._strange:  # a WHILE and its end are one mistake
            self._strange.add(remedy)
            self._stream.faults.error("name-unknown", token.position, f"{token.text} is not a word of BAPS2", remedy)
        self._stream.take()
        whole = token.key in WHOLE_LINES
        while token.key not in IN_FRONT and self._stream.token.position.line == token.position.line and (whole or not self.starts()):
            self._stream.take()
        return True

    def else_if(self) -> bool:
        """Whether ELSE and IF are next in one word; it is reported, and read as IF."""
        token = self._stream.token
        if token.key not in ELSE_IF or token.kind is not Kind.NAME or self.is_known(token):
            return False
        self._stream.faults.error("name-unknown", token.position, f"{token.text} is not a word of BAPS2", "write ELSE IF")
        self._stream.read_as("IF")
        return True

    # ---- signs

    def colon(self, where: str) -> bool:
        """Read the colon after constants; False: it is missing (reported), and reading continues as if it were present."""
        if self._stream.sign(":"):
            self._stream.doubled(":")
            return True
        line = self._stream.ahead(-1).position.line
        self._stream.missing("':'", where)
        while self._stream.token.position.line == line and not self.starts() and not self._stream.sign(":", "="):
            self._stream.take()
        return False

    def constants(self) -> list[Expression]:
        """Read the constants of a choice; after a misread one reading continues at the colon."""
        found: list[Expression] = []
        depth, line = self._stream.depth, self._stream.ahead(-1).position.line
        try:
            found.append(self._expressions.constant())
            while self._stream.comma():
                found.append(self._expressions.constant())
        except Misread:
            self._stream.back_to(depth)
            while self._stream.token.position.line == line and not self._stream.is_sign(":") and not self.starts():
                self._stream.take()
            if not self._stream.is_sign(":"):
                raise
        return found

    def unassigned(self) -> bool:
        """Return whether a declared name is next, followed by its value without the =."""
        token, following = self._stream.token, self._stream.ahead()
        if token.key not in self._expressions.names or token.key in self._declarations.programs or self.is_kinematic(following):
            return False
        known = (
            following.kind is Kind.NAME and following.key in self._expressions.names and self._stream.ahead(2).text not in ("=", ":", "(")
        )
        function = following.key in FUNCTIONS and self._stream.ahead(2).text == "("
        value = known or function or following.kind in (Kind.NUMBER, Kind.TEXT)
        return value and following.position.line == token.position.line

    def is_kinematic(self, token: Token) -> bool:
        """Whether the name is a kinematic."""
        return token.key in self._head.kinematics

    def assigned(self, where: str) -> None:
        """Takes the = of an assignment; `:=` and `==` are reported."""
        if self._stream.is_sign(":") and self._stream.ahead().text == "=":
            self._stream.faults.error("syntax", self._stream.token.position, "':=' is not a sign", "write =")
            self._stream.take()
        self._stream.expect_sign("=", where)
        self._stream.doubled("=")

    # ---- names

    def label(self) -> bool:
        """Whether a name that a JUMP leads to is next without its colon; it is reported."""
        token, following = self._stream.token, self._stream.ahead()
        if (
            token.kind is not Kind.NAME
            or token.word
            or self.is_known(token)
            or token.key not in self._stream.jumped
            or following.text in ("=", "[", ".", "(")
        ):
            return False
        self._stream.faults.error(
            "name-unknown", token.position, f"{token.text} is not a subroutine", "declare it, or write a colon after a label"
        )
        return True

    def is_label(self, token: Token) -> bool:
        """Whether the name before `:` and `=` is no variable but one that a JUMP leads to, or the signs are apart: a name is missing."""
        apart = not self._stream.ahead().touches(self._stream.ahead(2))
        return (apart or token.key in self._stream.jumped) and token.key not in self._expressions.names

    def no_kinematic(self) -> str:
        """Read an undeclared name where a kinematic may be: not a teach point, whose list continues with a comma."""
        token, following = self._stream.token, self._stream.ahead()
        if token.kind is not Kind.NAME or token.word or following.word not in BEHIND_KINEMATIC or token.key in self._expressions.names:
            return ""
        hint = hint_of(token.key, self._head.kinematics)
        self._stream.faults.error("kinematic-unknown", token.position, f"kinematic {token.text} is not declared", hint)
        return self._stream.take().key

    def no_target_word(self) -> None:
        """Report a name before a declared point in its line: a misspelt TO or VIA, not a teach point."""
        token, following = self._stream.token, self._stream.ahead()
        names = self._expressions.names
        pointed = following.kind is Kind.NAME and following.key in names and following.key not in self._declarations.programs
        in_line = following.position.line == token.position.line
        if token.kind is Kind.NAME and not token.word and token.key not in names and pointed and in_line:
            if self._stream.ahead(2).text not in ("=", ":", "("):
                self._stream.faults.error("syntax", token.position, f"TO or VIA is expected, not {token}")
                self._stream.take()

    def target(self) -> None:
        """Report a missing target before the next assignment or label."""
        if self._stream.ends_line():
            self._stream.wrong(f"a point is expected, not {self._stream.token}")

    def foreign_point(self) -> None:
        """A teach point that bears the name of a word of the other language: the last of its line, or in a list."""
        before, following = self._stream.ahead(-1), self._stream.ahead()
        last = following.position.line != self._stream.token.position.line or following.text == "," or following.word in ("TO", "VIA")
        if last and before.position.line == self._stream.token.position.line and self._stream.is_foreign():
            self._stream.read_as_name()
            self._expressions.names.add(self._stream.token.key)

    def device(self) -> str:
        """Read a device or file that lacks the following comma."""
        token, following = self._stream.token, self._stream.ahead()
        names, device = self._expressions.names, token.key in DEVICES and token.key not in self._expressions.names
        function = following.key in FUNCTIONS and self._stream.ahead(2).text == "("
        value = following.kind in (Kind.TEXT, Kind.NUMBER) or (following.kind is Kind.NAME and (following.key in names or function))
        if not (device or token.key in self._declarations.files) or not value or following.position.line != token.position.line:
            return ""
        if self._stream.ahead(2).text == "=":  # the next assignment
            return ""
        self._stream.take()
        what = "device" if device else "file"
        self._stream.faults.error("syntax", following.position, f"',' is expected after the {what}, not {following}")
        return token.key

    def operand(self, name: Token) -> bool:
        """Whether a declared name is next that no statement begins with, in the line of a name that may be a misspelt word."""
        token, names = self._stream.token, self._expressions.names
        if token.kind is not Kind.NAME or token.position.line != name.position.line or name.key in names:
            return False
        known = token.key in DEVICES or (token.key in names and token.key not in self._declarations.programs)
        return known and self._stream.ahead().text not in ("=", "[", ".", ":", "(")

    # ---- recovery

    def tried(self, name: Callable[[], str]) -> str:
        """Read a name; "" where it is missing, which is reported: its construct is still read."""
        try:
            return name()
        except Misread:
            return ""

    def condition(self, ends: Collection[str]) -> Expression:
        """Read a condition; if it is misread, reading continues at one of these words."""
        return self._value(self._expressions.condition, lambda line: self._goes_on(ends))

    def no_condition(self, at: Position) -> bool:
        """Whether UNTIL ends its line and a label, or an assignment that is not indented, follows and no condition; it is reported."""
        token, behind = self._stream.token, self._stream.ahead()
        if not self._stream.ends_line():
            return False
        own = token.key in self._expressions.names or token.key not in FACTORS
        indented = token.position.column > at.column or token.key in self._declarations.inputs
        if behind.text != ":" and own and (indented or self._goes_on_in_line(("MAX_TIME", "THEN"))):
            return False
        self._stream.faults.error("syntax", self._stream.gap, f"a condition is expected after WAIT UNTIL, not {token}")
        return True

    def _goes_on_in_line(self, words: Collection[str]) -> bool:
        """Whether one of the words is in the line of the next token."""
        line, place = self._stream.token.position.line, 0
        while (token := self._stream.ahead(place)).position.line == line and token.kind is not Kind.END:
            if token.word in words:
                return True
            place += 1
        return False

    def header(self) -> Expression:
        """Read the operand of a REPEAT or CASE; if it is misread, reading continues after its line."""
        return self._value(self._expressions.alone, self._behind)

    def _value(self, read: Callable[[], Expression], goes_on: Callable[[int], bool]) -> Expression:
        """Read a value; if it is misread, reading continues where `goes_on` leads from this line, and is given up where that is False."""
        at, depth = self._stream.token.position, self._stream.depth
        try:
            return read()
        except Misread:
            self._stream.back_to(depth)
            if not goes_on(at.line):
                raise
            return Faulty(at)

    def _behind(self, line: int) -> bool:
        """Passes over the rest of the line, to a statement or TIMES in it."""
        while self._stream.token.position.line == line and not self.starts() and self._stream.token.word != "TIMES":
            self._stream.take()
        return True

    def then(self) -> None:
        """Takes THEN; where it is missing, a statement may follow."""
        if self._stream.word("THEN"):
            return
        token, at = self._stream.token, self._stream.token.position if self._stream.slip(("THEN",)) else self._stream.gap
        called = token.key in self._stream.routines and self._stream.ahead().text == "("
        if not called and not self.starts() and not self._goes_on(("THEN",)):
            self._stream.missing("THEN", "after the condition")
            raise Misread
        self._stream.faults.error("syntax", at, f"THEN is expected after the condition, not {token}")
        if self._stream.token.word == "THEN" or self._stream.slip(("THEN",)):
            self._stream.take()

    def _goes_on(self, words: Collection[str]) -> bool:
        """Passes over to one of these words in this statement, also where it is misspelt; False: there is none."""
        last = self._stream.ahead(-1).position.line + NEAR
        place = 0
        while (token := self._stream.ahead(place)).kind is not Kind.END and token.position.line < last:
            unknown = token.kind is Kind.NAME and not token.word and token.key not in self._expressions.names
            if token.word in words or (unknown and self._stream.slip(words, place)):
                for _ in range(place):
                    self._stream.take()
                return True
            if place and self.starts(place):
                return False
            place += 1
        return False

    def starts(self, place: int = 0) -> bool:
        """Whether a statement begins there, or ends."""
        token, following = self._stream.ahead(place), self._stream.ahead(place + 1)
        if token.word:
            return token.word in self._begins or token.word in CLOSERS
        if token.kind is not Kind.NAME:
            return token.kind in (Kind.INSTRUCTION, Kind.END)
        before = self._stream.ahead(place - 1)
        if before.word in OPERATORS or before.text == "." or (before.text == "(" and before.position.line == token.position.line):
            return False
        if following.kind is Kind.SIGN and following.text in ("=", ":"):
            return True
        if before.position.line == token.position.line or before.text in WAITING:
            return False
        called = token.key in self._stream.routines or token.key in self._declarations.programs
        if following.text in (".", "[", "("):
            return called or token.key in self._expressions.names
        return called and following.position.line != token.position.line

    def pass_over(self, place: int) -> None:
        """To a token that begins or ends a statement."""
        if self._stream.place == place:
            self._stream.take()
        while self._stream.token.kind is not Kind.END:
            if self._stream.ahead(-1).word == "ERROR" and self._stream.token.word in ("JUMP", "HALT"):  # of the statement passed over
                self._stream.word("JUMP")
            elif self.starts() or self._ends_misspelt():
                return
            self._stream.take()

    def passed_to(self, words: Collection[str]) -> bool:
        """Passes over to one of these words in this line; False: there is none."""
        place, line = 0, self._stream.ahead(-1).position.line
        while (token := self._stream.ahead(place)).position.line == line and token.kind is not Kind.END:
            if token.word in words:
                for _ in range(place):
                    self._stream.take()
                return True
            place += 1
        return False

    def _ends_misspelt(self) -> bool:
        """Whether a word that ends something is next, alone in its line and with a slip in it."""
        line = self._stream.token.position.line
        alone = self._stream.ahead(-1).position.line != line != self._stream.ahead().position.line
        return alone and not self.is_known(self._stream.token) and bool(self._stream.slip(CLOSERS))
