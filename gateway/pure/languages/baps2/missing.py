"""Words that a statement lacks: each is named once, and the statement is read as if the word were there (AX-1820)."""

from collections.abc import Callable, Collection
from typing import Protocol

from gateway.pure.languages.baps2.declarations import DeclarationReader
from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.mistakes import BEHIND_KINEMATIC, CLOSERS, Mistakes
from gateway.pure.languages.baps2.standard import DEVICES, FACTORS, GERMAN
from gateway.pure.languages.baps2.stream import Misread, Stream
from gateway.pure.languages.baps2.tree import Block, Expression, Faulty, If, Jump, Statement
from gateway.pure.languages.base.source import Position

IN_CASE = ("EQUAL", "DEFAULT", "CASE_END")
OPENERS = {
    "REPEAT_END": "REPEAT",
    "EXCLUSIVE_END": "EXCLUSIVE",
    "PARALLEL_END": "PARALLEL",
    "ALSO": "PARALLEL",
    "CASE_END": "CASE",
    "EQUAL": "CASE",
    "DEFAULT": "CASE",
    "END": "BEGIN",
    "ELSE": "IF",
}
SEVERAL = "put several statements between BEGIN and END"
COMPARED = ("=", "<>", "<", ">", "<=", ">=")
JOINED = (*COMPARED, "+", "-", "*", "/", ".", "[")  # signs of a condition after its first name
ENDS_ROUTINE = ("PROGRAM_END", "SUB_END")


class Reads(Protocol):
    """What reads statements."""

    readers: dict[str, Callable[[Position], Statement]]

    def body(self, ends: Collection[str]) -> tuple[Statement, ...]:
        """Statements up to one of these words."""

    def one(self) -> Statement | None:
        """One statement, or None where it is misread."""

    def required(self, where: str) -> Statement:
        """One statement, which has to be there."""


class Missing:
    """Finds the words.  `open`: for each construct that is being read, the words that continue or end it."""

    def __init__(
        self, stream: Stream, expressions: ExpressionReader, declarations: DeclarationReader, mistakes: Mistakes, reads: Reads
    ) -> None:
        self._stream, self._expressions, self._declarations = stream, expressions, declarations
        self._mistakes, self._reads = mistakes, reads
        self.open: list[Collection[str]] = []

    def _report(self, word: str, token: Token, hint: str = "") -> None:
        self._stream.faults.error("syntax", token.position, f"{word} is missing in front of {token}", hint)

    # ---- words that begin a statement

    def opener(self) -> Statement | None:
        """A statement without its first word; None: nothing of the kind is next."""
        token, following = self._stream.token, self._stream.ahead()
        is_name = self._expressions.names_it(token)
        if token.word and not is_name:
            return self._by_word(token)
        if token.kind is Kind.NUMBER or following.word in ("TIMES", "THEN", "AND", "OR") or following.text in JOINED or token.text == "(":
            return self._counted(token) or self._conditional(token)
        if token.kind is Kind.TEXT:
            return self._begun("WRITE", token)
        if token.kind is not Kind.NAME:
            return None
        alone = following.position.line != token.position.line and token.key in self._expressions.names
        if token.key in self._declarations.semaphores or (alone and self._closes_on("EXCLUSIVE", "EXCLUSIVE_END")):
            return self._begun("EXCLUSIVE", token)
        if following.word == "EQUAL" and token.key in self._expressions.names:
            return self._begun("CASE", token)
        if following.word in BEHIND_KINEMATIC and self._mistakes.is_kinematic(token):
            return self._begun("MOVE", token)
        if (token.key in DEVICES or token.key in self._declarations.files) and following.text == ",":
            return self._begun("WRITE", token, "READ or WRITE")
        return None

    def _begun(self, word: str, token: Token, named: str = "") -> Statement:
        """The statement that this word begins, from its second word on."""
        self._report(named or word, token)
        return self._reads.readers[word](token.position)

    def _by_word(self, token: Token) -> Statement | None:
        """A word from inside of a statement is first."""
        if token.word in ("TO", "VIA", "LINEAR", "PTP", "CIRCULAR"):
            return self._begun("MOVE", token)
        if token.word == "NOT":
            return self._conditional(token)
        if token.word == "UNTIL":
            self._report("WAIT", token)
            return self._reads.readers["WAIT"](token.position)
        return None

    def _counted(self, token: Token) -> Statement | None:
        """`3 TIMES`."""
        return self._begun("REPEAT", token) if self._is_ahead("TIMES", lines=1) else None

    def _conditional(self, token: Token) -> Statement | None:
        """Read a condition followed by THEN."""
        return self._begun("IF", token) if self._is_ahead("THEN") else None

    def _is_ahead(self, word: str, lines: int = 2) -> bool:
        """Whether the word follows in this line, or in the next ones, and no statement begins before it."""
        last, place = self._stream.token.position.line + lines, 0
        while (token := self._stream.ahead(place)).kind is not Kind.END and token.position.line < last:
            if token.word == word:
                return True
            if place and self._mistakes.starts(place):
                return False
            place += 1
        return False

    def of_condition(self, at: Position) -> Statement | None:
        """Handle an assignment that is one only because IF is missing before it."""
        if self._stream.token.word != "THEN" or self._stream.too_deep:
            return None
        token = self._stream.token
        self._stream.faults.error("syntax", at, f"IF is missing in front of the condition of {token}")
        return self._then(at)

    def _then(self, at: Position) -> If:
        self._stream.take()
        then = self._reads.required("after THEN")
        return If(at, Faulty(at), then, self._reads.required("after ELSE") if self._stream.word("ELSE") else None)

    # ---- words inside of a statement

    def jump(self) -> Statement | None:
        """A label, where a statement is expected in its line."""
        token, following = self._stream.token, self._stream.ahead()
        if token.kind is not Kind.NAME or token.word or following.text in (":", "=", "[", ".", "("):
            return None
        if self._mistakes.is_known(token) or token.key in self._declarations.programs or not self._stream.is_label(token.key):
            return None
        self._report("JUMP", token)
        return Jump(token.position, self._stream.take().key)

    def operator(self) -> bool:
        """Return whether the condition continues without an operator, up to a THEN; report and skip it."""
        token = self._stream.token
        if token.word in self._reads.readers or not self._is_ahead_of_value("THEN"):
            return False
        self._stream.faults.error("syntax", token.position, f"an operator or THEN is expected, not {token}")
        while self._stream.token.word != "THEN":
            self._stream.take()
        return True

    def _is_ahead_of_value(self, word: str) -> bool:
        """Whether the word is the next one of the language in this line and the next."""
        last, place = self._stream.ahead(-1).position.line + 2, 0
        while (token := self._stream.ahead(place)).kind is not Kind.END and token.position.line < last:
            if token.word == word:
                return True
            if token.word not in ("", "AND", "OR", "NOT", "MOD"):
                return False
            place += 1
        return False

    def in_move(self, until: bool) -> str:
        """The word that a MOVE lacks in front of what is next: WITH, UNTIL or ERROR; it is reported."""
        token = self._stream.token
        if not until and (token.word or token.kind is not Kind.NAME):
            return ""
        following = self._stream.ahead()
        word, line = "", token.position.line
        if until and token.word in ("JUMP", "HALT", "WRITE", "BEGIN", "STOP") and self._is_ahead("TO", lines=3):
            word = "ERROR"
        elif token.kind is Kind.NAME and not token.word and following.text in COMPARED and self._stream.ahead(-1).position.line == line:
            word = "WITH" if GERMAN.get(token.key, token.key) in FACTORS and following.text == "=" else "UNTIL"
            if not self._is_ahead_in_line(("TO", "VIA", "ERROR", "UNTIL", "WITH")):
                word = ""
        if word:
            self._report(word, token)
        return word

    def _is_ahead_in_line(self, words: Collection[str]) -> bool:
        line, place = self._stream.token.position.line, 0
        while (token := self._stream.ahead(place)).position.line == line and token.kind is not Kind.END:
            if token.word in words:
                return True
            place += 1
        following = self._stream.ahead(place)
        return following.word in words and following.position.line == line + 1

    def until(self, tree: Expression, token: Token) -> bool:
        """Return whether the value after WAIT, which begins with the token, is a condition; report the missing UNTIL."""
        sign = getattr(tree, "sign", "")
        if sign not in (*COMPARED, "AND", "OR", "NOT") and not self._stream.is_word(("MAX_TIME",)):
            return False
        self._report("UNTIL", token)
        return True

    def equal(self) -> bool:
        """Whether constants and their colon are next without EQUAL; it is reported."""
        token, place = self._stream.token, 0
        while (each := self._stream.ahead(place)).kind in (Kind.NUMBER, Kind.TEXT) or each.text in (",", "-"):
            place += 1
        if not place or each.text != ":" or each.position.line != token.position.line:
            return False
        self._report("EQUAL", token)
        return True

    def of_choice(self) -> tuple[Statement, ...]:
        """Report statements after the one of a choice and read them up to the continuation of the CASE; none: CASE_END is missing."""
        token = self._stream.token
        if token.word in (*IN_CASE, "ELSE") or not self._closes_on("CASE", "CASE_END"):
            return ()
        self._report("EQUAL, DEFAULT or CASE_END", token, SEVERAL)
        return self._reads.body(IN_CASE)

    def _closes_on(self, begin: str, end: str) -> bool:
        """Whether the end of the construct that is open follows in this routine."""
        depth = place = 0
        while (token := self._stream.ahead(place)).kind is not Kind.END and token.word not in ENDS_ROUTINE:
            depth += (token.word == begin) - (token.word == end)
            if depth < 0:
                return True
            place += 1
        return False

    # ---- words that end or continue nothing --

    def orphan(self) -> Statement | None:
        """Reads a word that no construct around it has begun, and what belongs to it; None: a construct around it is meant."""
        token = self._stream.token
        if token.word not in OPENERS:
            return None
        opened = [words for words in self.open if token.word in words]
        if token.word == "END":  # which may also be that of a program
            opened = [words for words in opened if len(words) == 1]
        if opened or (token.word == "END" and not self._routine_goes_on()):
            return None
        hint = SEVERAL if token.word == "ELSE" else ""
        if self._stream.too_deep:  # a consequence
            self._stream.take()
            return Block(token.position, ())
        self._stream.faults.error("syntax", token.position, f"{token} without {OPENERS[token.word]}", hint)
        if token.word in ("ALSO", "PARALLEL_END"):
            return self._branches(token.position)
        if token.word in IN_CASE:
            return self._choices(token.position)
        self._stream.take()
        follows = token.word == "ELSE" or (token.word == "END" and self._stream.word("ELSE"))
        statement = self._reads.one() if follows and not self._stream.is_word(CLOSERS) else None
        return statement or Block(token.position, ())

    def _routine_goes_on(self) -> bool:
        """Whether END is not that of the program: its own end follows."""
        place = 1
        while (token := self._stream.ahead(place)).kind is not Kind.END and token.word not in ("SUBROUTINE", "PROGRAM"):
            if token.word in ENDS_ROUTINE:
                return True
            place += 1
        return False

    def _branches(self, at: Position) -> Block:
        """Branches of a PARALLEL that is not there."""
        found: list[Statement] = []
        self.open.append(("ALSO", "PARALLEL_END"))
        while self._stream.word("ALSO"):
            found += self._reads.body(("ALSO", "PARALLEL_END"))
        self.open.pop()
        self._stream.word("PARALLEL_END")
        return Block(at, tuple(found))

    def _choices(self, at: Position) -> Block:
        """Choices of a CASE that is not there."""
        found: list[Statement] = []
        self.open.append(IN_CASE)
        while self._stream.is_word(("EQUAL", "DEFAULT")):
            if self._stream.take().word == "EQUAL":
                self._passed_constants()
            self._stream.sign(":")
            found += self._reads.body(IN_CASE)
        self.open.pop()
        self._stream.word("CASE_END")
        return Block(at, tuple(found))

    def _passed_constants(self) -> None:
        try:
            self._mistakes.constants()
        except Misread:  # reported
            return
