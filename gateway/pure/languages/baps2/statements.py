"""Reads statements.  A name before `=`, `.` or `[` is assigned to, before `:` it is a label, otherwise it is called."""

from collections.abc import Callable, Collection

from gateway.pure.languages.baps2 import instructions
from gateway.pure.languages.baps2.declarations import DeclarationReader
from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.homonyms import ASSIGNED
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.missing import IN_CASE, Missing
from gateway.pure.languages.baps2.mistakes import BEHIND_KINEMATIC, CLOSERS, Mistakes
from gateway.pure.languages.baps2.orders import OrderReader
from gateway.pure.languages.baps2.standard import GERMAN, PROCEDURES
from gateway.pure.languages.baps2.stream import Misread, Stream
from gateway.pure.languages.baps2.tree import (
    Binary,
    Block,
    CallStatement,
    Case,
    Choice,
    Exclusive,
    Expression,
    Faulty,
    Head,
    If,
    Jump,
    Label,
    Leg,
    Move,
    Name,
    Parallel,
    Repeat,
    Set,
    Simple,
    StartStop,
    Statement,
    Sync,
    Synchron,
    Wait,
    WaitUntil,
)
from gateway.pure.languages.base.source import Position

AFTER_THEN = "after THEN"
IN_MOVE = ("LINEAR", "CIRCULAR", "WITH", "UNTIL")
BEHIND_UNTIL = (*IN_MOVE, "ERROR", "MAX_TIME")
ROUTINE_ENDS = frozenset("PROGRAM_END SUB_END SUBROUTINE PROGRAM".split())


class StatementReader:
    """Reads from a stream, using the head and the declarations."""

    def __init__(self, stream: Stream, expressions: ExpressionReader, declarations: DeclarationReader, head: Head) -> None:
        self._stream, self._expressions, self._declarations, self._head = stream, expressions, declarations, head
        self.readers: dict[str, Callable[[Position], Statement]] = {
            "MOVE": lambda at: self._move(at, self._relative_mark()),
            "MOVE_REL": lambda at: self._move(at, True),
            "WAIT": self._wait,
            "IF": self._if,
            "BEGIN": self._block,
            "CASE": self._case,
            "REPEAT": self._repeat,
            "PARALLEL": self._parallel,
            "EXCLUSIVE": self._exclusive,
            "JUMP": lambda at: Jump(at, self._called("a label")),
            "HALT": lambda at: Simple(at, "HALT"),
            "BREAK": lambda at: Simple(at, "BREAK"),
            "REF_PNT": lambda at: Simple(at, "REF_PNT", self._kinematic()),
            "START": lambda at: StartStop(at, "START", self._called("a program")),
            "STOP": lambda at: StartStop(at, "STOP", self._called("a program")),
            "SYNC": self._sync,
            "SYNCHRON": self._synchron,
            "SYNCHRON_END": lambda at: Simple(at, "SYNCHRON_END", self._belt()),
        }
        self._mistakes = Mistakes(stream, expressions, declarations, head, self.readers)
        orders = OrderReader(stream, expressions, declarations, self._mistakes, lambda: self._called("a file or a device"))
        self.readers |= orders.readers()
        self._missing = Missing(stream, expressions, declarations, self._mistakes, self)

    def body(self, ends: Collection[str]) -> tuple[Statement, ...]:
        """Statements up to one of these words, which is not taken, or a word that can only end something around."""
        found: list[Statement] = []
        words = (*ends, *self.readers)
        self._missing.open.append(ends)
        while not self._ends(ends):
            if self._stream.sign(","):  # between assignments (L6275)
                continue
            if not self._stream.token.word and self._mistakes.misspelt(words) and self._stream.is_word(ends):
                break
            if self._stream.token.word in CLOSERS:
                if (orphan := self._missing.orphan()) is None:
                    break
                found.append(orphan)
            elif (statement := self.one()) is not None:
                found.append(statement)
        self._missing.open.pop()
        return tuple(found)

    def _ends(self, ends: Collection[str]) -> bool:
        """Whether the body ends here; END may be one too many in a program."""
        self._mistakes.in_two()
        token = self._stream.token
        return token.kind is Kind.END or (token.word in ends and not (token.word == "END" and len(ends) > 1))

    def one(self) -> Statement | None:
        """One statement; None where it was misread or only set something."""
        place, depth = self._stream.place, self._stream.depth
        try:
            self._stream.deeper()
            return self._statement()
        except Misread:
            self._mistakes.pass_over(place)
            return None
        finally:
            self._stream.back_to(depth)

    def required(self, where: str) -> Statement:
        """One statement, which has to be there."""
        self._mistakes.misspelt(tuple(self.readers))
        at = self._stream.token.position
        if (jump := self._missing.jump()) is not None:
            return jump
        if self._stream.token.word == "ELSE" and where == AFTER_THEN:
            self._stream.faults.error("syntax", self._stream.gap, f"a statement is expected {where}, not {self._stream.token}")
            return Block(at, ())
        if self._stream.is_word(CLOSERS) or self._stream.token.kind is Kind.END:
            self._stream.wrong(f"a statement is expected {where}, not {self._stream.token}")
        return self.one() or Block(at, ())

    def _statement(self) -> Statement | None:
        token, following = self._stream.token, self._stream.ahead()
        if token.kind is Kind.INSTRUCTION:
            self._stream.take()
            return instructions.take(token.text, token.position, self._head, self._stream.faults, begun=True)
        if token.kind is not Kind.NAME:
            return self._other(token)
        is_name = self._expressions.names_it(token)
        assigned = following.text in ASSIGNED and following.kind is Kind.SIGN
        if assigned and is_name:  # the most frequent one
            return self._set()
        assigned = assigned or (following.text == ":" and self._stream.ahead(2).text == "=" and not self._mistakes.is_label(token))
        if is_name and following.text == ":" and following.kind is Kind.SIGN and not assigned:
            self._stream.length(self._stream.take())
            self._stream.take()
            self._stream.doubled(":")
            return Label(token.position, token.key)
        if token.word in self.readers and not (is_name and assigned):
            self._stream.take()
            return self.readers[token.word](token.position)
        if (jump := self._missing.jump()) is not None:
            return jump
        if self._mistakes.label():
            return Label(token.position, self._stream.take().key)
        if (assigned and is_name) or self._mistakes.unassigned():
            return self._set()
        if token.word and following.text in ASSIGNED and self._stream.is_foreign():
            self._stream.read_as_name()
            return self._set()
        if token.word and following.text == "=":
            self._stream.wrong(f"a value is expected, not the word {token}", at=token.position)
        return self._other(token)

    def _other(self, token: Token) -> Statement:
        """A call, or a statement whose first word is missing."""
        called = token.kind is Kind.NAME and not token.word
        if called and self._mistakes.stranger():
            return Block(token.position, ())
        if not (called and self._is_called(token)) and (opened := self._missing.opener()) is not None:
            return opened
        if called:
            return self._call(self._stream.take())
        self._stream.wrong(f"a statement is expected, not {token}", at=token.position)

    def _is_called(self, token: Token) -> bool:
        """Whether the name is one of a subroutine or program."""
        return token.key in self._stream.routines or token.key in self._declarations.programs or token.key in PROCEDURES

    # ---- names that decide the grammar

    def _called(self, what: str) -> str:
        """The name of a label or program; a word that ends something, or begins a statement, is none: the name is missing."""
        before, token = self._stream.ahead(-1), self._stream.token
        far = token.position.line != before.position.line
        if far and self._stream.ahead().text in ("=", ":"):
            self._stream.wrong(f"{what} is expected, not {token}")
        begins = token.word in self.readers and far
        if what == "a label" and not far and self._stream.is_foreign():
            return self._stream.take().key
        if (token.word in CLOSERS or begins) and not self._expressions.names_it(token):
            self._stream.wrong(f"{what} is expected, not {token}")
        return self._stream.name(what).key

    def _kinematic(self) -> str:
        """Read a kinematic before another token."""
        token = self._stream.token
        if token.kind is Kind.NAME and token.key in self._head.kinematics and self._stream.ahead().text != ".":
            return self._stream.take().key
        return ""

    def _belt(self) -> str:
        token = self._stream.token
        return self._stream.take().key if token.kind is Kind.NAME and token.key in self._declarations.belts else ""

    def _relative_mark(self) -> bool:
        """`MOVE REL`, `MOVE-REL` (L1626, L11664)."""
        if self._stream.is_sign("-") and self._stream.ahead().word == "REL":
            self._stream.take()
        return self._stream.word("REL")

    # ---- assignments and calls

    def _set(self) -> Statement:
        at = self._stream.token.position
        target = self._expressions.sum()
        self._mistakes.assigned("after the assigned variable")
        found = Set(at, target, self._expressions.alone())
        return self._missing.of_condition(at) or found

    def _call(self, name: Token) -> CallStatement:
        """Read a call, including tokens that cannot follow it: a misspelt word is one mistake, not two."""
        arguments, token = self._arguments(), self._stream.token
        if self._mistakes.operand(name):
            self._mistakes.pass_over(-1)
            return CallStatement(name.position, name.key, arguments, (token.position, str(token)))
        if token.kind in (Kind.END, Kind.INSTRUCTION) or token.word in self.readers or token.word in CLOSERS or token.text == ",":
            return CallStatement(name.position, name.key, arguments)
        if token.kind is Kind.NAME and (not token.word or self._expressions.names_it(token) or self._stream.ahead().text in ("=", ":")):
            return CallStatement(name.position, name.key, arguments)
        if token.kind in (Kind.NUMBER, Kind.TEXT) and token.position.line != self._stream.ahead(-1).position.line:
            return CallStatement(name.position, name.key, arguments)
        self._mistakes.pass_over(-1)
        return CallStatement(name.position, name.key, arguments, (token.position, str(token)))

    def _arguments(self) -> tuple[Expression, ...]:
        if not self._stream.sign("("):
            return ()
        found: list[Expression] = []
        while not self._stream.sign(")"):
            found.append(self._expressions.read())
            if not self._stream.comma() and not self._stream.is_sign(")"):
                self._stream.wrong(f"')' is expected after the parameters, not {self._stream.token}", at=self._stream.gap)
        return tuple(found)

    # ---- motion

    def _move(self, at: Position, relative: bool) -> Move:
        kinematic, way = "", ""
        factors: list[tuple[str, Expression]] = []
        until: Expression | None = None
        until_time: Expression | None = None
        otherwise: Statement | None = None
        while True:
            self._mistakes.misspelt_part(IN_MOVE if until is None else BEHIND_UNTIL, "after MOVE")
            lacking = self._missing.in_move(until is not None)
            if lacking == "ERROR":
                otherwise = self.required("after ERROR")
            elif lacking == "UNTIL":
                until = self._expressions.condition()
            elif lacking or self._stream.word("WITH"):
                factors += self._factors()
            elif not kinematic and (found := self._kinematic()):
                kinematic = found
            elif not kinematic and (found := self._mistakes.no_kinematic()):
                kinematic = found  # reported
            elif self._stream.is_word(("LINEAR", "PTP", "CIRCULAR")):
                way = self._stream.take().word
            elif self._stream.word("UNTIL"):
                until = self._expressions.condition()
            elif self._stream.word("MAX_TIME"):
                self._stream.expect_sign("=", "after MAX_TIME")
                until_time = self._expressions.sum()
            elif until is not None and self._stream.word("ERROR"):
                otherwise = self.required("after ERROR")
            else:
                return Move(at, relative, kinematic, way, tuple(factors), until, until_time, otherwise, self._legs())

    def _factors(self) -> list[tuple[str, Expression]]:
        found = []
        while True:
            try:
                token = self._stream.name("the name of a speed, an acceleration or a factor")
                self._stream.expect_sign("=", f"after WITH {token.text}")
                found.append((GERMAN.get(token.key, token.key), self._expressions.alone()))
            except Misread:
                if not self._mistakes.passed_to(BEHIND_KINEMATIC):
                    raise
                return found
            comma = self._stream.sign(",")
            another = self._stream.token.kind is Kind.NAME and self._stream.ahead().text == "="
            if not another and (not comma or self._stream.is_word(("VIA", "TO", "UNTIL", "LINEAR", "PTP", "CIRCULAR"))):
                return found

    def _legs(self) -> tuple[Leg, ...]:
        """Targets; VIA and TO hold for all points of their list."""
        found, through = [], False
        while True:
            if self._stream.is_word(("VIA", "TO")):
                through = self._stream.take().word == "VIA"
            else:
                self._mistakes.no_target_word()
            self._mistakes.foreign_point()
            self._mistakes.target()
            found.append(Leg(self._expressions.sum(), through))
            if not (self._stream.comma() or self._stream.is_word(("TO", "VIA"))):
                return tuple(found)

    def _sync(self, at: Position) -> Sync:
        belt = self._stream.token._replace(key=self._called("a belt"))
        self._stream.sign(",")
        if self._stream.is_sign(">=", "<=", ">", "<", "="):
            sign = self._stream.take()
            if self._stream.ends_line():
                self._stream.wrong(f"a value is expected, not {self._stream.token}")
            return Sync(at, belt.key, Binary(sign.position, sign.text, Name(belt.position, belt.key), self._expressions.sum()))
        return Sync(at, belt.key, self._expressions.read())

    def _synchron(self, at: Position) -> Synchron:
        kinematic = self._kinematic()
        self._stream.sign(",")
        return Synchron(at, kinematic, self._called("a belt"))

    # ---- flow

    def _wait(self, at: Position) -> Statement:
        self._mistakes.misspelt_part(("UNTIL",), "after WAIT")
        max_time: Expression | None = None
        otherwise: Statement | None = None
        if self._stream.word("UNTIL"):
            if self._mistakes.no_condition(at):
                return WaitUntil(at, Faulty(at), None, None)
            condition = self._mistakes.condition(("MAX_TIME", "ERROR"))
        else:
            first, condition = self._stream.token, self._expressions.alone()
            if not self._missing.until(condition, first):
                return Wait(at, condition)
        self._mistakes.misspelt_part(("MAX_TIME", "ERROR"), "after the condition")
        if self._stream.word("MAX_TIME"):
            self._stream.expect_sign("=", "after MAX_TIME")
            max_time = self._expressions.alone()
            self._mistakes.misspelt_part(("ERROR",), "after MAX_TIME")
        if self._stream.word("ERROR"):
            otherwise = self.required("after ERROR")
        return WaitUntil(at, condition, max_time, otherwise)

    def _if(self, at: Position) -> If:
        condition = self._mistakes.condition(("THEN",))
        if not self._stream.is_word(("THEN",)) and self._missing.operator():
            condition = Faulty(at)
        self._mistakes.then()
        self._missing.open.append(("ELSE",))
        then = self.required(AFTER_THEN)
        self._missing.open.pop()
        self._mistakes.misspelt(("ELSE",))
        otherwise = self._mistakes.else_if() or self._stream.word("ELSE")
        return If(at, condition, then, self.required("after ELSE") if otherwise else None)

    def _block(self, at: Position) -> Block:
        body = self.body(("END",))
        self._close("END", "BEGIN", at)
        return Block(at, body)

    def _close(self, end: str, begin: str, at: Position) -> bool:
        """Takes the word that ends a construct; where there is another one, the construct is reported and left."""
        closed = self._stream.word(end)
        if not closed:
            token = self._stream.token
            hint = f"{token} of line {token.position.line} ends what is around it" if token.kind is not Kind.END else ""
            self._stream.faults.error("not-closed", at, f"{begin} has no {end}", hint)
        return closed

    def _case(self, at: Position) -> Case:
        selector, choices, otherwise = self._mistakes.header(), list[Choice](), None
        self._missing.open.append(IN_CASE)
        while (another := self._another()) or (choices and self._several_of(choices)):
            if another:
                choices.append(self._choice())
        if not choices:
            self._missing.open.pop()
            self._stream.wrong(f"EQUAL and its constants are expected after the expression, not {self._stream.token}")
        if self._stream.word("DEFAULT", "ELSE"):  # German SONST
            self._stream.sign(":")
            otherwise = self.required("after DEFAULT")
            self._mistakes.misspelt(("CASE_END",))
            self._missing.of_choice()
        self._missing.open.pop()
        self._close("CASE_END", "CASE", at)
        return Case(at, selector, tuple(choices), otherwise)

    def _another(self) -> bool:
        """Whether another choice is next."""
        misspelt = self._stream.is_word(("EQUAL",)) or self._mistakes.misspelt((*IN_CASE, "ELSE"))
        return self._stream.is_word(("EQUAL",)) if misspelt else self._missing.equal()

    def _choice(self) -> Choice:
        place = self._stream.token.position
        self._stream.word("EQUAL")
        values = self._mistakes.constants()
        empty = not self._mistakes.colon("after the constants") and self._stream.is_word(IN_CASE)
        return Choice(place, tuple(values), Block(place, ()) if empty else self.required("after the constants"))

    def _several_of(self, choices: list[Choice]) -> bool:
        """Whether more statements follow in the last choice, which is reported."""
        place, last = self._stream.place, choices[-1]
        more = self._missing.of_choice()
        choices[-1] = Choice(last.at, last.values, Block(last.at, (last.body, *more)))
        return self._stream.place > place

    def _repeat(self, at: Position) -> Repeat:
        times = self._mistakes.header()
        if not (isinstance(times, Faulty) and not self._stream.is_word(("TIMES",))):
            self._stream.expect_word("TIMES", "after the number of repetitions", goes_on=True)
        body = self.body(("REPEAT_END",))
        self._close("REPEAT_END", "REPEAT", at)
        return Repeat(at, times, body)

    def _parallel(self, at: Position) -> Parallel | Block:
        branches = [self.body(("ALSO", "PARALLEL_END"))]
        while self._stream.word("ALSO"):
            branches.append(self.body(("ALSO", "PARALLEL_END")))
        if not self._close("PARALLEL_END", "PARALLEL", at):
            return Block(at, tuple(statement for branch in branches for statement in branch))  # jumps may lead out of it
        return Parallel(at, tuple(branches))

    def _exclusive(self, at: Position) -> Exclusive:
        semaphore = self._mistakes.tried(lambda: self._called("a semaphore"))
        body = self.body(("EXCLUSIVE_END",))
        self._close("EXCLUSIVE_END", "EXCLUSIVE", at)
        return Exclusive(at, semaphore, body)
