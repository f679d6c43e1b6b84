"""Reads a PIC program (QLS): statements of BAPS-PIC and lines of the instruction list, also mixed, into commands of the scan engine.

Source: rho3 6, L1471-1572, L2079-2095, L3962-4044, L10698-10747.  What the manual leaves open: AX-980.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.near import hint_of, nearest
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.pic import words
from gateway.pure.languages.pic.expressions import FLAGS, INPUTS, OUTPUTS, Expression, Operand, chain, constant, inverted, joined
from gateway.pure.languages.pic.lexer import Kind, Token, tokens_of
from gateway.pure.languages.pic.slips import slip_of
from gateway.pure.languages.pic.symbols import Area, Bit, Symbols, address
from gateway.pure.languages.pic.token_reader import TokenReader
from gateway.pure.languages.plc.commands import Code, Command, Program, Routine

FIRST = {Area.INPUT: INPUTS, Area.OUTPUT: OUTPUTS, Area.FLAG: FLAGS}
DEEPEST = 40  # statements or brackets one in the other
UNKNOWN = Bit(Area.FLAG, 0, 0)  # stands in for a reported operand
END_LABEL = "\0end"  # no name of a program


@dataclass(frozen=True, slots=True)
class PicProgram:
    """A program that can be scanned; outputs: bytes it writes, with the first place that does."""

    program: Program
    outputs: Mapping[int, Position]


class _Wrong(Exception):
    """The rest of the statement is left out."""


def read_program(text: str, file: str, symbols: Symbols, faults: Faults) -> PicProgram | None:
    """None: it has errors."""
    before = faults.errors
    tokens = tokens_of(text, file, faults)
    reader, found = _read(tokens, symbols)
    if found.errors > 1 and (slip := slip_of(tokens, found, lambda trial: _read(trial, symbols)[1])) is not None:
        faults.add(slip[0])
        found = slip[1]
    for fault in found:
        faults.add(fault)
    if faults.errors > before:
        return None
    name = file.upper()
    routine = Routine(name, tuple(reader.commands), len(text.splitlines()))
    return PicProgram(Program(name, {name: routine}), reader.outputs)


def _read(tokens: list[Token], symbols: Symbols) -> "tuple[Reader, Faults]":
    """Read all statements, with faults of their own."""
    found = Faults()
    reader = Reader(tokens, symbols, found)
    reader.read()
    return reader, found


@dataclass(slots=True)
class Reader(TokenReader):
    """Recursive descent; after a fault reading continues at the next statement."""

    symbols: Symbols
    faults: Faults
    commands: list[Command] = field(default_factory=list)
    outputs: dict[int, Position] = field(default_factory=dict)
    _depth: int = 0
    _made: int = 0  # labels of conditions
    _brackets: list[Position] = field(default_factory=list)  # of the instruction list
    _forgiven: int = 0  # closing brackets that may still follow, of brackets that are reported
    _labels: dict[str, Position] = field(default_factory=dict)
    _jumps: list[tuple[str, Position]] = field(default_factory=list)
    _unknown: set[str] = field(default_factory=set)  # names that are reported

    def _fail(self, id: str, at: Position, text: str, hint: str = "") -> _Wrong:
        self.faults.error(id, at, text, hint)
        return _Wrong()

    def _emit(self, code: Code, line: int, bit: Operand | None = None, name: str = "") -> None:
        byte, mask = (bit.byte, bit.mask) if bit is not None else (0, 0)
        self.commands.append(Command(code, line, byte=byte, mask=mask, name=name))

    # ---- statements

    def read(self) -> None:
        """Read the entire program."""
        while self.token.kind is not Kind.END and not self.faults.full:
            before = self._at
            try:
                self._statement()
            except _Wrong:
                self._recover(before)
        for where in self._brackets:
            self.faults.error("bracket", where, "this bracket is not closed")
        for name, where in self._jumps:
            if name not in self._labels:
                hint = hint_of(name, self._labels) or f"put {name}: in front of the statement to continue with"
                self.faults.error("label", where, f"there is no label {name}", hint)
        self._emit(Code.LABEL, self.token.at.line, name=END_LABEL)

    def _recover(self, before: int) -> None:
        """Skip to the next line, or past the refused part; a bracket of the list that closes there is closed."""
        self._depth, inner = 0, 0
        if self._at == before:
            self._take()
        while self.token.kind is not Kind.END and not self.token.first:
            inner += self._sign("(")
            if self._sign(")"):
                if not inner and self._brackets:
                    self._brackets.pop()
                inner = max(0, inner - 1)
            self._take()

    def _statement(self) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise self._fail("nesting", self.token.at, f"more than {DEEPEST} nested statements")
        token = self.token
        if self._sign("=") or self._sign(")"):
            self._list_sign()
        elif self._sign("-") and token.first and self._ahead().last and self._ahead().kind is Kind.NAME:
            self._take()
            self._label(self._take())
        elif token.kind is Kind.NAME and self._ahead().text == ":" and self._ahead(2).text != "=":
            self._label(self._take())
            self._take()
        elif self._is(words.IF):
            self._take()
            self._condition()
        elif self._lacks_if(token):
            self._condition()
        elif self._lacks_jump(token):
            self._go(Code.JUMP, token.at.line)
        elif self._is(words.JUMP):
            self._go(Code.JUMP, self._take().at.line)
        elif self._is(words.BEGIN):
            self._compound()
        elif token.kind is Kind.NAME and token.word in words.LIST and (token.last or self._ahead().text not in ("=", ":")):
            self._list()
        elif (token.kind is Kind.NAME and token.word not in words.RESERVED) or token.kind is Kind.BIT:
            self._assignment()
        else:
            shown = repr(token.text) if token.text else "the end"
            if self._is(words.ELSE) or self._is(words.END):
                raise self._fail("statement", token.at, f"{shown} without {'IF' if self._is(words.ELSE) else 'BEGIN'}", words.SEVERAL)
            raise self._fail("statement", token.at, f"{shown} does not begin a statement", "NAME = .., IF .. THEN .., JUMP NAME, NAME:")
        self._depth -= 1

    def _label(self, token: Token) -> None:
        if token.word in self._labels:
            raise self._fail("label-twice", token.at, f"the label {token.text} is defined twice")
        self._labels[token.word] = token.at
        self._emit(Code.LABEL, token.at.line, name=token.word)

    def _lacks_if(self, token: Token) -> bool:
        """Return whether a condition and THEN follow in the line without IF, or after another word; report it."""
        place, closed = 0, False
        while (each := self._ahead(place)).kind is not Kind.END and not (each.first and place):
            closed = each.word in words.THEN
            if closed or each.word in words.IF or (each.text == "=" and self._ahead(place + 1).kind is not Kind.NUMBER):
                break
            place += 1
        if not closed or (token.word in words.RESERVED and token.word not in words.NOT):
            return False
        behind = self._ahead()
        misspelt = token.kind is Kind.NAME and (behind.kind is Kind.BIT or behind.word in words.NOT or not self._joins(behind))
        misspelt = misspelt and token.word not in words.NOT
        self.faults.error("if", token.at, f"IF is expected, not {token.text}" if misspelt else f"IF is missing in front of {token.text}")
        if misspelt:
            self._take()
        return True

    @staticmethod
    def _joins(token: Token) -> bool:
        """Whether it may follow an operand of a condition."""
        return token.word in (*words.AND, *words.OR, *words.THEN) or token.text in ("=", ")")

    def _lacks_jump(self, token: Token) -> bool:
        """Whether a label is next where a statement is expected in the line; it is reported."""
        if token.kind is not Kind.NAME or token.first or self._ahead().text in ("=", ":") or not self._is_label(token):
            return False
        if token.word in words.LIST and not token.last:
            return False
        self.faults.error("jump", token.at, f"JUMP is missing in front of {token.text}")
        return True

    def _lacks_operator(self, *, then: bool) -> None:
        """Report an operand that follows an operand; reading continues at THEN or in the next line."""
        token = self.token
        operand = token.kind is Kind.BIT or (token.kind is Kind.NAME and token.word not in words.RESERVED and token.word not in words.LIST)
        if token.first or not operand or self._ahead().text in ("=", ":") or (not then and self._is_label(token)):
            return
        place = 0
        while not (self._ahead(place).first or self._ahead(place).kind is Kind.END or self._ahead(place).word in words.THEN):
            place += 1
        found = self._ahead(place).word in words.THEN
        if then and not found:
            return
        if token.word in words.REMEDIES:
            self.faults.error("name", token.at, f"{token.text} is neither a signal nor a symbol", words.REMEDIES[token.word])
        else:
            self.faults.error("operator", token.at, f"AND or OR is missing in front of {token.text}")
        while place:
            self._take()
            place -= 1

    def _condition(self) -> None:
        line = self.token.at.line
        test = self._test()
        if not self._is(words.THEN):
            self.faults.error("then", self._gap(), "THEN is expected after the condition")
            if self.token.kind is not Kind.NAME or not nearest(self.token.word, words.THEN):
                raise _Wrong
        self._take()
        self._made += 1
        otherwise, behind = f"\0else{self._made}", f"\0behind{self._made}"
        self.commands += chain(test, line)
        self._emit(Code.JUMP_IF_NOT, line, name=otherwise)
        self._statement()
        if self._is(words.ELSE):
            self._take()
            self._emit(Code.JUMP, line, name=behind)
            self._emit(Code.LABEL, line, name=otherwise)
            self._statement()
            self._emit(Code.LABEL, line, name=behind)
        else:
            self._emit(Code.LABEL, line, name=otherwise)

    def _test(self) -> Expression:
        """Read the condition of an IF; if it is refused, reading continues at its THEN."""
        depth = self._depth
        try:
            found = self._expression(compares=True)
            self._lacks_operator(then=True)
        except _Wrong:
            while not self._is(words.THEN):
                if self.token.kind is Kind.END or self.token.first:
                    raise
                self._take()
            self._depth, found = depth, constant(0)
        return found

    def _compound(self) -> None:
        begun = self._take()
        while not self._is(words.END):
            if self.token.kind is Kind.END:
                raise self._fail("end", begun.at, "END is missing for this BEGIN")
            self._statement()
        self._take()

    def _go(self, code: Code, line: int) -> None:
        symbol = self._sign("-")  # after it any word is a name
        if symbol:
            self._take()
        token = self.token
        far = token.first and not self._is_label(token)
        if far or token.kind is not Kind.NAME or (token.word in words.RESERVED and not symbol and not self._is_label(token)):
            raise self._fail("label", self._gap(), "the name of a label is expected")
        self._take()
        self._outside(token.at)
        self._jumps.append((token.word, token.at))
        self._emit(code, line, name=token.word)

    def _assignment(self) -> None:
        token = self.token
        target = self._operand(writes=True)
        if self._sign(":"):
            self.faults.error("assign", self.token.at, "':=' is not a sign", "write =")
            self._take()
        if not self._sign("="):
            raise self._fail("assign", self._gap(), f"= is expected after {token.text}")
        self._take()
        if self._sign("=") and not self.token.first:
            self.faults.error("assign", self.token.at, "'==' is not a sign", "write =")
            self._take()
        self.commands += chain(self._expression(compares=False), token.at.line)
        self._lacks_operator(then=False)
        self._emit(Code.ASSIGN, token.at.line, target)

    # ---- expressions

    def _expression(self, *, compares: bool) -> Expression:
        parts = [self._term(compares=compares)]
        while self._is(words.OR):
            self._take()
            parts.append(self._term(compares=compares))
        return joined(parts, every=False)

    def _term(self, *, compares: bool) -> Expression:
        parts = [self._factor(compares=compares)]
        while self._is(words.AND):
            self._take()
            parts.append(self._factor(compares=compares))
        return joined(parts, every=True)

    def _factor(self, *, compares: bool) -> Expression:
        turned = False
        while self._is(words.NOT):
            self._take()
            turned = not turned
        self._misspelt_not()
        if self._sign("("):
            opened = self._take()
            self._depth += 1
            if self._depth > DEEPEST:
                raise self._fail("nesting", opened.at, f"more than {DEEPEST} nested brackets")
            found = self._expression(compares=compares)
            if not self._sign(")"):
                raise self._fail("bracket", opened.at, "this bracket is not closed")
            self._take()
            self._depth -= 1
        elif self.token.kind is Kind.NUMBER:
            found = constant(self._binary())
        else:
            self._lacks_operand(compares=compares)
            found = self._operand(writes=False)
        if compares and self._sign("="):
            self._take()
            if self._binary() == 0:
                turned = not turned
        return inverted(found) if turned else found

    def _lacks_operand(self, *, compares: bool) -> None:
        """Reports an operand that is missing at the end of a line: an assignment begins the next one."""
        if self.token.first and self._ahead().text == "=" and not (compares and self._ahead(2).kind is Kind.NUMBER):
            before = self._ahead(-1)
            raise self._fail("operand", before.end, f"a signal or an address is expected after {before.text}, not a new line")

    def _misspelt_not(self) -> None:
        """Report and skip a misspelt NOT before an operand."""
        token, behind = self.token, self._ahead()
        operand = not behind.first and (
            behind.kind is Kind.BIT or (behind.kind is Kind.NAME and behind.word not in (*words.RESERVED, *words.LIST))
        )
        if token.kind is Kind.NAME and operand and token.word not in words.RESERVED and self.symbols.find(token.text) is None:
            if spelling := nearest(token.word, words.NOT):
                self.faults.error("name", token.at, f"{token.text} is neither a signal nor a symbol", f"did you mean {spelling}?")
                self._take()

    def _binary(self) -> int:
        token = self.token
        if token.kind is not Kind.NUMBER or token.text not in ("0", "1"):
            raise self._fail("binary", self._gap(), f"{token.text or 'the end'}: 0 or 1 is expected")
        self._take()
        return int(token.text)

    def _operand(self, *, writes: bool) -> Operand:
        if self._sign("-"):
            self._take()
        token = self.token
        try:
            bit = self._bit(token)
            if writes and bit.area is Area.INPUT:
                raise self._fail("written", token.at, f"{token.text} is an input of the PIC: it is read, not written")
        except _Wrong:
            if token.kind not in (Kind.NAME, Kind.BIT) or token.word in words.RESERVED or (writes and self._ahead().text != "="):
                raise
            bit = UNKNOWN  # reported; the statement is read to its end for further faults
        self._take()
        if writes and bit.area is Area.OUTPUT:
            self.outputs.setdefault(bit.byte, token.at)
        return Operand(FIRST[bit.area] + bit.byte, 1 << bit.bit)

    def _bit(self, token: Token) -> Bit:
        if token.kind is Kind.BIT:
            place = address(token.text)
            if isinstance(place, Bit):
                return place
            raise self._fail("address", token.at, str(place), "I0.0 to I127.7, O0.0 to O127.7, M0.0 to M127.7")
        if token.kind is not Kind.NAME or token.word in words.RESERVED:
            raise self._fail("operand", self._gap(), f"{token.text or 'the end'}: a signal or an address is expected")
        found = self.symbols.find(token.text)
        if found is None:
            if token.word in self._unknown:
                raise _Wrong
            self._unknown.add(token.word)
            hint = words.REMEDIES.get(token.word) or hint_of(token.word, (*self.symbols.own, *words.RESERVED))
            hint = hint or f"a line {token.word} = I88.0 in the SYM file"
            raise self._fail("name", token.at, f"{token.text} is neither a signal nor a symbol", hint)
        return found

    # ---- the instruction list

    def _list_sign(self) -> None:
        token = self._take()
        if token.text == "=":
            self._outside(token.at)
            self._emit(Code.ASSIGN, token.at.line, self._operand(writes=True))
        elif self._forgiven and not self._brackets:
            self._forgiven -= 1
        elif not self._brackets or self.commands[-1].code in words.OPENS.values():
            raise self._fail("bracket", token.at, "this ) does not close a bracket, or an empty one")
        else:
            self._brackets.pop()
            self._emit(Code.CLOSE, token.at.line)

    def _list(self) -> None:
        token = self._take()
        word, line = token.word, token.at.line
        if token.last and word in (*words.LINKS, *words.SETS) and (self._sign("=") or self.token.word in words.LIST):
            raise self._fail("operand", token.end, f"a signal or an address is expected after {token.text}, not a new line")
        if word in words.OPENS and self._sign("("):
            self._take()
            if len(self._brackets) >= DEEPEST:
                raise self._fail("nesting", token.at, f"more than {DEEPEST} nested brackets")
            self._brackets.append(token.at)
            self._emit(words.OPENS[word], line)
            self._begins_bracket(word)
        elif word in words.LINKS:
            self._emit(words.LINKS[word], line, self._operand(writes=False))
        elif word in words.SETS:
            self._outside(token.at)
            self._emit(words.SETS[word], line, self._operand(writes=True))
        elif word in words.JUMPS:
            self._go(words.JUMPS[word], line)
        elif word in words.ENDS:
            self._emit(Code.JUMP, line, name=END_LABEL)

    def _begins_bracket(self, word: str) -> None:
        """Refuse an operand alone, which is not an instruction, as in BAPS-PIC."""
        token = self.token
        if token.first or token.kind is Kind.END or token.word in words.LIST or token.text in (")", "="):
            return
        shown = token.text if token.kind is Kind.BIT else "I88.0"
        raise self._fail(
            "bracket-operand", token.at, f"an instruction is expected after {word}(, not {token.text}", f"{word}( {word} {shown} )"
        )

    def _outside(self, at: Position) -> None:
        self._forgiven = len(self._brackets)
        if self._brackets:
            self._brackets.clear()
            raise self._fail("bracket", at, "a bracket is open here", "close it with )")
