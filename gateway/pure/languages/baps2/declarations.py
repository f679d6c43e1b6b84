"""Reads the declarations of a program or a subroutine.  Any order is accepted (the manual prints constants after variables: L7163-7169)."""

from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.stream import Misread, Stream
from gateway.pure.languages.baps2.tree import (
    Constant,
    Declaration,
    Declared,
    Expression,
    External,
    Head,
    Number,
    Parameter,
    SpecialFunction,
    TypeName,
)
from gateway.pure.languages.baps2.type_names import KINEMATIC, TYPES, TypeReader

STARTERS = (*TYPES, "CONST", "PUBLIC", "DEF", "EXTERNAL", "SPC_FCT", "VALUE")
BODY = ("BEGIN", "START", "PROGRAM_END", "SUB_END", "END", "SUBROUTINE", "PROGRAM")
FAR = 2_000  # tokens that a misspelt declaration may have


class DeclarationReader(TypeReader):
    """Reads from a stream; declared names are entered in `names` of the expression reader at once."""

    def __init__(self, stream: Stream, expressions: ExpressionReader, head: Head) -> None:
        super().__init__(stream, expressions, head)
        self.files: set[str] = set()
        self.belts: set[str] = set()
        self.semaphores: set[str] = set()
        self.inputs: set[str] = set()
        self.programs: set[str] = set()  # external ones, which are called by their names
        self.garbled: list[Parameter] = []  # of a subroutine whose parameters are misread
        self._begun: list[Token] = []  # names of the declaration that is read

    def read(self) -> tuple[Declaration, ...]:
        """Return all declarations before the body."""
        found: list[Declaration] = []
        while self._begins():
            place, depth = self._stream.place, self._stream.depth
            self._begun.clear()
            try:
                found += self._one()
            except Misread:
                found += [*map(_misread, self._begun), *self._pass_over(place)]
                self._stream.back_to(depth)
            self._stream.sign(",")
        return tuple(found)

    def misspelt(self, found: list[Declaration]) -> bool:
        """Passes over a declaration whose type is none (reported), if declarations or BEGIN follow; its names go to `found`."""
        if self._stream.is_sign(":", "["):
            found += self._untyped()
            return True
        if self._of_no_kinematic():
            return True
        if self._stream.token.kind is not Kind.NAME or self._stream.is_word(BODY):
            return False
        if self._misspelt_starter():
            return True
        if not self._declares_on():
            return False
        self._stream.faults.error("syntax", self._stream.token.position, f"a declaration or BEGIN is expected, not {self._stream.token}")
        found += self._pass_over(self._stream.place)
        return True

    def _misspelt_starter(self) -> bool:
        """Whether the first word of a declaration is next with a slip in it; it is reported, and read as it was meant."""
        token, behind = self._stream.token, self._stream.ahead()
        numbered = behind.text == ":" and self._stream.ahead(2).kind is Kind.NUMBER
        if not numbered and behind.text != "[" and behind.word not in STARTERS and behind.key not in self._head.kinematics:
            return False
        spelling = self._stream.slip(self._likely(behind))
        if spelling:
            hint = f"did you mean {spelling}?"
            self._stream.faults.error("syntax", token.position, f"a declaration or BEGIN is expected, not {token}", hint)
            self._stream.read_as(spelling)
        return bool(spelling)

    def _likely(self, behind: Token) -> tuple[str, ...]:
        """Return the first words of a declaration that may be in front of this token."""
        if behind.text == "[":
            return ("ARRAY",)
        if behind.text == ":":
            return ("INPUT", "OUTPUT")
        return ("INPUT", "OUTPUT", "FILE", "PUBLIC", "DEF")

    def _of_no_kinematic(self) -> bool:
        """Whether points of a kinematic that is not declared are next; it is reported."""
        token = self._stream.token
        if token.word or self._stream.ahead().text != "." or self._stream.ahead(2).word not in KINEMATIC:
            return False
        self.unknown_kinematic()
        return True

    def _untyped(self) -> list[Declaration]:
        """A list of names whose type, or whose word ARRAY, is missing: it is reported, and the names may be anything."""
        token = self._stream.token
        self._stream.faults.error("syntax", token.position, f"{'a type' if token.text == ':' else 'ARRAY'} is missing in front of {token}")
        if self._stream.sign(":"):
            return self._pass_over(self._stream.place - 1)
        depth = self._stream.depth
        try:
            return list(self._listed_of(self._array(token.position), public=False, teach=False))
        except Misread:
            self._stream.back_to(depth)
            return self._pass_over(self._stream.place - 1)

    def _declares_on(self) -> bool:
        """Whether the next word of the language is one of a declaration or BEGIN, not of a statement."""
        colon = self._stream.ahead().text == ":"
        for count in range(1, FAR):
            token = self._stream.ahead(count)
            if token.kind is Kind.END or (token.text == "=" and not colon and self._stream.ahead(count - 1).kind is Kind.NAME):
                return False
            if (
                token.word
                and token.key not in self._expressions.names
                and not (self._stream.is_foreign(token) and token.word not in STARTERS)
            ):
                return token.word in STARTERS or token.word in ("BEGIN", "START")
        return False

    def _begins(self) -> bool:
        return self._stream.is_word(STARTERS) or self._is_kinematic(self._stream.token)

    def _pass_over(self, place: int) -> list[Declaration]:
        """Skip to the next declaration or the body; the skipped names are declared with any type, so that their uses are not further
        faults.
        """
        listed = self._stream.place != place  # after the type
        if not listed:
            self._stream.take()
        before = self._stream.ahead(-1).text if listed else ""
        depth = 0  # of brackets: a type inside them, or after the bounds of an array, does not begin a declaration
        named, found = False, list[Declaration]()
        while not (self._in_body(before) or self._stream.token.kind is Kind.END):
            if depth <= 0 and before != "]" and (self._begins() or (named and self._another())):
                break
            token = self._stream.take()
            depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
            listed = listed or token.text == ":"
            named = token.kind is Kind.NAME and depth <= 0 and before in (":", ",", "=")
            if listed and named and token.key not in self._expressions.names:
                found.append(_misread(self._declare(token, None)))
            before = token.text
        return found

    def _in_body(self, before: str) -> bool:
        """Whether the body is next; START may be the name of a constant (L5960)."""
        return self._stream.is_word(BODY) and not (before in (":", ",") and self._stream.ahead().text == "=")

    def _another(self) -> bool:
        """Whether another misspelt type is next."""
        return self._stream.token.kind is Kind.NAME and self._stream.ahead().text in (":", "[")

    def _one(self) -> list[Declaration]:
        if self._stream.word("CONST"):
            if not self._colon("after CONST"):
                return [_misread(self._declare(each, None)) for each in self._stream.commented()]
            return list(self._constants())
        if self._stream.word("EXTERNAL"):
            return [self._external()]
        if self._stream.word("SPC_FCT"):
            return [self._special_function()]
        public = self._stream.word("PUBLIC")
        teach = self._stream.word("DEF")
        return self._listed_of(self.type_name(), public, teach)

    def _listed_of(self, kind: TypeName, public: bool, teach: bool) -> list[Declaration]:
        """Return the names after a type."""
        if not self._colon("after the type"):
            commented = [self._declare(token, kind) for token in self._stream.commented()]
            channels = kind.base in ("INPUT", "OUTPUT", "BELT")
            return [_misread(each) if channels else Declared(each.position, each.key, kind, None, public, teach) for each in commented]
        if kind.base in ("INPUT", "OUTPUT", "BELT"):
            return list(self._channels(kind))
        return [Declared(token.position, token.key, kind, None, public, teach) for token in self._names(kind)]

    def _names(self, kind: TypeName | None) -> list[Token]:
        if self._begins_next():
            self._stream.faults.error("syntax", self._stream.gap, f"a name is expected, not {self._stream.token}")
            return []
        found = [self._declare(self._stream.name("a name"), kind)]
        while self._stream.comma() or self._no_comma(found[-1]):
            if self._begins_next():
                break  # a surplus comma before the next declaration
            if self._body_next():
                self._stream.faults.error("syntax", self._stream.gap, f"a name is expected after ',', not {self._stream.token}")
                break
            found.append(self._declare(self._stream.name("a name"), kind))
        for token in self._stream.commented():
            self._head.commented.setdefault(token.key, token.position.line)
        return found

    def _no_comma(self, before: Token) -> bool:
        """Whether the next name of a list follows without its comma; it is reported."""
        token, behind = self._stream.token, self._stream.ahead()
        listed = behind.text == "," or behind.word in STARTERS or behind.word in ("BEGIN", "START") or behind.kind is Kind.END
        word = token.word and not self._stream.is_foreign()
        other = word or token.key in self._head.kinematics or behind.text in (":", "[", "(", "=", ".")
        if self._stream.is_sign(".") and behind.kind is Kind.NAME:
            self._stream.missing("','", f"after {before.text}")
            self._stream.take()
            return True
        if token.kind is not Kind.NAME or other:
            return False
        fresh = token.position.line != before.position.line
        if fresh and behind.word in STARTERS and self._stream.slip(STARTERS):
            return False
        if not listed and token.position.line != before.position.line:
            return False
        self._stream.missing("','", f"after {before.text}")
        return True

    def _begins_next(self) -> bool:
        """Return whether a declaration begins after a comma, and not a name that is a word of the other language (`INTEGER : NO, WERT`)."""
        behind = self._stream.ahead().text
        return self._begins() and behind not in (",", "=") and (behind in (":", "[") or not self._stream.is_foreign())

    def _body_next(self) -> bool:
        """Return whether the body begins in a new line where a name is expected, and not a name that is like its word."""
        fresh = self._stream.ahead(-1).position.line != self._stream.token.position.line
        return fresh and self._stream.is_word(BODY) and self._stream.ahead().text not in (",", "=")

    def _declare(self, token: Token, kind: TypeName | None) -> Token:
        self._expressions.names.add(token.key)
        self._begun.append(token)
        self._stream.length(token)
        if kind is not None and kind.base in ("FILE", "BNR_FILE"):
            self.files.add(token.key)
        if kind is not None and kind.base == "BELT":
            self.belts.add(token.key)
        if kind is not None and kind.base == "INPUT":
            self.inputs.add(token.key)
        if kind is not None and kind.base == "SEMAPHORE":
            self.semaphores.add(token.key)
        return token

    def _constants(self) -> list[Constant]:
        found = []
        while True:
            token = self._declare(self._stream.name("the name of a constant"), None)
            self._equal("after the name of a constant")
            found.append(Constant(token.position, token.key, self._expressions.alone()))
            comma = self._stream.comma()
            behind = self._stream.ahead()
            goes_on = behind.text == "=" or (comma and behind.kind in (Kind.NUMBER, Kind.TEXT))
            if self._stream.token.kind is not Kind.NAME or not goes_on or (not comma and self._begins()):
                return found

    def _channels(self, kind: TypeName) -> list[Declared]:
        """`610 = PROBE, 611 = HS`; a comma may be missing (D-34)."""
        found = []
        while True:
            if self._stream.is_sign("="):
                self._stream.faults.error("syntax", self._stream.token.position, "the number of a channel is missing in front of '='")
                channel: Expression | None = None
            else:
                channel = self._expressions.sum()
            self._equal("after the channel")
            if self._body_next():
                self._stream.wrong(f"the name of the channel is expected, not {self._stream.token}")
            token = self._declare(self._stream.name("the name of the channel"), kind)
            found.append(_misread(token) if channel is None else Declared(token.position, token.key, kind, channel))
            comma = self._stream.comma()
            if not comma and self._stream.is_sign(".") and self._stream.ahead().kind is Kind.NUMBER:
                self._stream.missing("','", f"after {token.text}")
                self._stream.take()
            in_line = self._stream.token.position.line == token.position.line
            number = self._stream.token.kind is Kind.NUMBER or self._stream.is_sign("=")
            constant = (comma or in_line) and self._expressions.names_it(self._stream.token) and self._stream.ahead().text == "="
            if not (number or constant):
                return found

    def _equal(self, where: str) -> None:
        """Read the =; report a missing or wrong one and still read the rest of the line."""
        if self._stream.sign("="):
            self._stream.doubled("=")
            return
        self._stream.missing("'='", where)
        colon = self._stream.sign(":")
        self._stream.sign("=")
        if not (colon or self._listed(self._stream.token)):
            raise Misread

    def _external(self) -> External:
        at = self._stream.token.position
        program = "" if self._stream.is_sign(":") else self._stream.name("the name of a program").key
        self._stream.expect_sign(":", "after EXTERNAL")
        tokens = self._names(None) if program else self._programs()
        return External(at, program, tuple((token.key, token.position) for token in tokens))

    def _programs(self) -> list[Token]:
        found = [self._stream.name("the name of a program")]
        while self._stream.sign(","):
            found.append(self._stream.name("the name of a program"))
        self.programs.update(token.key for token in found)
        return found

    def _special_function(self) -> SpecialFunction:
        self._stream.expect_sign(":", "after SPC_FCT")
        at = self._stream.token.position
        number: Expression = self._expressions.sum() if self._stream.token.kind is not Kind.NUMBER else self._number()
        if not self._stream.sign("="):
            self._stream.faults.error("syntax", self._stream.gap, f"'=' is expected after the number, not {self._stream.token}")
            self._stream.sign(":")  # as it is printed once (D-63)
        name = self._declare(self._stream.name("the name of the special function"), None)
        return SpecialFunction(at, number, name.key, self.parameters())

    def _number(self) -> Expression:
        token = self._stream.take()
        return Number(token.position, int(token.text) if token.text.isdigit() else float(token.text))

    def parameters(self) -> tuple[Parameter, ...]:
        """Groups of parameters in brackets; one VALUE serves its group, no comma is needed between groups (L1721, 9730)."""
        if not self._stream.sign("("):
            return ()
        found: list[Parameter] = []
        try:
            self._parameters(found)
        except Misread:
            self._to_bracket(found)
            self.garbled.extend(found)
            raise
        return tuple(found)

    def _to_bracket(self, found: list[Parameter]) -> None:
        """Behind the bracket that closes faulty parameters; names on the way may be anything."""
        depth = 1
        while depth and not (self._stream.is_word(BODY) or self._stream.token.kind is Kind.END):
            foreign = self._stream.is_foreign()
            token = self._stream.take()
            depth += (token.text == "(") - (token.text == ")")
            if token.kind is Kind.NAME and (foreign or not token.word) and token.key not in {each.name for each in found}:
                found.append(Parameter(token.position, token.key, TypeName(token.position, ""), False))

    def _parameters(self, found: list[Parameter]) -> None:
        while not self._stream.sign(")"):
            by_value = self._by_value()
            kind = self._parameter_type()
            self._colon("after the type of a parameter")
            while True:
                token = self._stream.name("the name of a parameter")
                found.append(Parameter(token.position, token.key, kind, by_value))
                if not (self._stream.sign(",") or self._no_comma_here(token)) or (self._group() and not self._name_without_type()):
                    break
            if not (self._group() or self._misspelt_value() or self._stream.is_sign(")")):
                self._stream.wrong(f"')' is expected after the parameters, not {self._stream.token}", at=self._stream.gap)

    def _name_without_type(self) -> bool:
        """Whether a name follows a comma, and then the colon of a group without its type."""
        token = self._stream.token
        listed = self._stream.ahead(-1).text == "," and self._stream.ahead().text == ":"
        return listed and token.kind is Kind.NAME and not token.word and not self._stream.slip(TYPES)

    def _no_comma_here(self, before: Token) -> bool:
        """Whether another parameter of the group follows without its comma; it is reported."""
        token = self._stream.token
        if token.kind is not Kind.NAME or token.word or self._group() or self._stream.ahead().text not in (",", ")"):
            return False
        self._stream.missing("','", f"after {before.text}")
        return True

    def _by_value(self) -> bool:
        """Read VALUE; report another word before a type."""
        token = self._stream.token
        if self._misspelt_value():
            self._stream.faults.error("syntax", self._stream.gap, f"VALUE or a type is expected, not {token}")
            self._stream.take()
            return True
        return self._stream.word("VALUE")

    def _misspelt_value(self) -> bool:
        """Whether a name that is no parameter is in front of a type."""
        token, behind = self._stream.token, self._stream.ahead()
        typed = behind.word in TYPES or (behind.key in self._head.kinematics and self._stream.ahead(2).text == ".")
        return token.kind is Kind.NAME and not token.word and typed

    def _parameter_type(self) -> TypeName:
        """A type; one that is misspelt is reported, and the parameter may be anything."""
        at = self._stream.token.position
        return TypeName(at, "") if self._misspelt_type() else self.type_name()

    def _group(self) -> bool:
        """Whether a group of parameters begins here, and not a name that is a word of the other language (`REAL : MASS, WERT`)."""
        behind = self._stream.ahead()
        misspelt = self._stream.token.kind is Kind.NAME and behind.text == ":"
        if self._stream.is_foreign() and (behind.text in (",", ")") or behind.word == "VALUE"):
            return False
        return misspelt or self._stream.is_word((*TYPES, "VALUE")) or self._is_kinematic(self._stream.token)


def _misread(token: Token) -> Declared:
    """A name whose declaration is faulty."""
    return Declared(token.position, token.key, TypeName(token.position, ""))
