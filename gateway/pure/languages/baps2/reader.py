"""Reads a complete source: head, declarations, main part, subroutines.  All faults of the file in one run, never an exception."""

from collections.abc import Callable, Iterable
from dataclasses import replace

from gateway.pure.languages.baps2 import instructions
from gateway.pure.languages.baps2.declarations import STARTERS, DeclarationReader
from gateway.pure.languages.baps2.expressions import ExpressionReader
from gateway.pure.languages.baps2.lexer import Kind, Token
from gateway.pure.languages.baps2.statements import ROUTINE_ENDS, StatementReader
from gateway.pure.languages.baps2.stream import Misread, Stream
from gateway.pure.languages.baps2.tree import Declaration, Declared, Head, Parameter, Program, Routine, Statement, TypeName
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position, SourceFile
from gateway.pure.languages.base.store import ProgramStore

BEGINS = ("BEGIN", "START")
MOST_GARBLED = 20  # then the declarations are left for the body
ENDS = {"PROGRAM": ("PROGRAM_END", "END"), "SUBROUTINE": ("SUB_END", "END")}


def read(
    source: SourceFile, words: Words, store: ProgramStore, faults: Faults, repairs: Iterable[Callable[[list[Token]], None]] = ()
) -> Program | None:
    """The tree; None where not even a program begins in it.  `repairs`: each changes the tokens as they were meant."""
    return _Reader(Stream(source, words, store, faults, repairs), faults).program()


class _Reader:
    def __init__(self, stream: Stream, faults: Faults) -> None:
        self._stream, self._faults, self._head = stream, faults, Head()
        self._garbled = 0  # places among declarations that are none
        self._main: tuple[ExpressionReader, DeclarationReader] | None = None  # its names are known in the subroutines too

    def program(self) -> Program | None:
        self._instructions()
        first, early = self._stream.token, dict[str, Declared]()
        if first.word not in ENDS:
            self._faults.error("no-program", first.position, f"PROGRAM is expected, not {first}")
            early = self._find()
            if self._stream.token.word not in ENDS:
                return None
        external = self._stream.token.word == "SUBROUTINE"
        main = self._routine()
        if early:
            known = {getattr(each, "name", "") for each in main.declarations}
            known |= set(self._stream.routines)
            main = replace(main, declarations=(*main.declarations, *(each for name, each in early.items() if name not in known)))
        external = external or bool(main.parameters)  # only a caller has values for them
        self._head.over = True
        subroutines = []
        while self._more():
            subroutines.append(self._routine())
        return Program(self._head, main, tuple(subroutines), external)

    def _instructions(self) -> None:
        while self._stream.token.kind is Kind.INSTRUCTION:
            token = self._stream.take()
            instructions.take(token.text, token.position, self._head, self._faults, begun=False)

    def _find(self) -> dict[str, Declared]:
        """The beginning of a routine; names on the way may be anything."""
        passed: dict[str, Declared] = {}
        while self._stream.token.word not in ENDS and self._stream.token.kind is not Kind.END:
            if self._stream.token.kind is Kind.INSTRUCTION:
                self._instructions()
                continue
            token = self._stream.take()
            if token.kind is Kind.NAME and not token.word:
                passed.setdefault(token.key, Declared(token.position, token.key, TypeName(token.position, "")))
        return passed

    def _no_declaration(self) -> bool:
        """Report anything else among the declarations and continue at the next one.  False: the body begins."""
        token = self._stream.token
        left = 0 if token.word in BEGINS else self._open_begin()
        if not left:
            return False
        self._faults.error("no-begin", token.position, f"a declaration or BEGIN is expected, not {token}")
        self._garbled += 1
        for _ in range(left):
            line = self._stream.take().position.line
            following = self._stream.token
            begins = following.word in STARTERS and following.position.line != line
            if self._garbled < MOST_GARBLED and (begins or following.kind is Kind.INSTRUCTION):
                break
        return True

    def _open_begin(self) -> int:
        """Return the number of tokens before the BEGIN of the routine, the one that no END closes; 0: there is none."""
        opened: list[int] = []
        place = 0
        while (token := self._stream.ahead(place)).kind is not Kind.END and token.word not in ROUTINE_ENDS:
            if token.word == "BEGIN":
                opened.append(place)
            elif token.word == "END" and opened:
                opened.pop()
            place += 1
        return opened[0] if opened else 0

    def _more(self) -> bool:
        """Return whether another routine follows; report anything else after an end once."""
        self._instructions()
        token = self._stream.token
        if self._nameless():
            return True
        if token.kind is not Kind.END and token.word != "SUBROUTINE":
            spelling = self._stream.slip(("SUBROUTINE",))
            hint = f"did you mean {spelling}?" if spelling else ""
            self._faults.error("behind-the-end", token.position, f"only subroutines may follow here, not {token}", hint)
            if spelling:
                self._stream.read_as(spelling)
            elif token.word not in ENDS:
                self._find()
        return self._stream.token.kind is not Kind.END

    def _nameless(self) -> bool:
        """Whether a subroutine without its word is next; it is reported."""
        token, behind = self._stream.token, self._stream.ahead()
        begins = behind.text == "(" or (behind.position.line != token.position.line and behind.word in (*BEGINS, *STARTERS))
        if token.kind is not Kind.NAME or token.word or not begins:
            return False
        self._faults.error("syntax", token.position, f"SUBROUTINE is missing in front of {token}")
        return True

    def _routine(self) -> Routine:
        word = self._stream.take().word if self._stream.token.word else "SUBROUTINE"  # missing and reported
        at, name = self._stream.token.position, ""
        expressions = ExpressionReader(self._stream, set())
        declarations = DeclarationReader(self._stream, expressions, self._head)
        if self._main is None:
            self._main = expressions, declarations
        else:
            expressions.names |= self._main[0].names
            declarations.files |= self._main[1].files
            declarations.belts |= self._main[1].belts
            declarations.semaphores |= self._main[1].semaphores
            declarations.inputs |= self._main[1].inputs
            declarations.programs |= self._main[1].programs
        parameters: tuple[Parameter, ...] = ()
        try:
            name = self._name("the name of the program" if word == "PROGRAM" else "the name of the subroutine")
            parameters = declarations.parameters()
        except Misread:
            self._stream.back_to(0)
            parameters = tuple(declarations.garbled)
        expressions.names.update(parameter.name for parameter in parameters)
        declarations.files.update(each.name for each in parameters if each.type.base in ("FILE", "BNR_FILE"))
        found: list[Declaration] = []
        while True:
            self._instructions()
            place = self._stream.place
            found += declarations.read()
            if self._misspelt_begin():
                break
            if self._stream.place == place and not declarations.misspelt(found) and not self._no_declaration():
                break
        body = self._body(word, at, expressions, declarations)
        return Routine(at, name, parameters, tuple(found), body, garbled=bool(declarations.garbled))

    def _misspelt_begin(self) -> bool:
        """Whether a BEGIN with a slip in it is alone in its line; it is reported, and read as it was meant."""
        token, following = self._stream.token, self._stream.ahead()
        if following.text in (":", "[", "=", "(", ".", ",") or following.position.line == token.position.line:
            return False
        spelling = self._stream.slip(("BEGIN",))
        if spelling:
            self._faults.error("no-begin", token.position, f"BEGIN is expected, not {token}", f"did you mean {spelling}?")
            self._stream.read_as(spelling)
        return bool(spelling)

    def _name(self, what: str) -> str:
        """The name of a routine; words of the language may be one (L5756), but not what begins its body or a declaration."""
        token, following = self._stream.token, self._stream.ahead()
        begins = token.word in BEGINS and following.word not in (*BEGINS, *STARTERS)
        if begins or (token.word in STARTERS and following.text in (":", "[")):
            self._stream.wrong(f"{what} is expected, not {token}")
        return self._stream.length(self._stream.name(what)).key

    def _body(self, word: str, at: Position, expressions: ExpressionReader, declarations: DeclarationReader) -> tuple[Statement, ...]:
        """From BEGIN to the end of the routine."""
        if not self._stream.word(*BEGINS):
            self._faults.error("no-begin", self._stream.token.position, f"BEGIN is expected, not {self._stream.token}")
        self._stream.settle(expressions.names)
        statements = StatementReader(self._stream, expressions, declarations, self._head)
        found: list[Statement] = []
        while True:
            found += statements.body(ENDS[word])
            token = self._stream.token
            if self._stream.word(*ENDS[word]):
                return tuple(found)
            if token.kind is Kind.END or token.word in ROUTINE_ENDS:
                self._faults.error("not-closed", token.position, f"{ENDS[word][0]} is expected for {word} of line {at.line}, not {token}")
                self._stream.word("PROGRAM_END", "SUB_END")
                return tuple(found)
            self._faults.error("syntax", token.position, f"there is nothing for {token} to end here")
            self._stream.take()
