"""Translates the statements of a block.  Each line written is checked as the control checks it, or refused with a reason."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.plc.awl.constants import NO_CONSTANT, NO_TIME, Kind, constant_of, kind_of
from gateway.pure.languages.plc.awl.reader import Block, Refused, Statement
from gateway.pure.languages.plc.awl.reasons import INDIRECT, NO_STATUS, REASONS, REST, WORD_ORDER
from gateway.pure.languages.plc.steps import Wrong, step_of

END = "_END"
ONE = ("O M0.0", "ON M0.0")  # 1 whatever the marker holds
BIT = re.compile(r"([EAM])\s*(\d+)\.(\d)\b")
LOCAL = re.compile(r"L\s*(\d+)\.([0-7])\b")
LOCAL_BYTE, LOCAL_WORD = re.compile(r"LB\s*(\d+)\b"), re.compile(r"L[WD]\s*\d")
STATUS = re.compile(r"(?:==|<>|>=|<=|>|<)0|OV\b|OS\b|UO\b|BIE\b|BR\b|STW\b")
CELL = re.compile(r"([TZ])\s*(\d+)\b(?!\.)")
BYTE = re.compile(r"([EAM])B\s*(\d+)\b")
OPERAND_LIKE = re.compile(r"\(?\s*(?:[A-Z]{1,3}\s*\d|[=#\"-]|\d|[EAMTZIQFC]\s+\S*[.,]\S)")  # anything else after a single O is a comment
TABLED = re.compile(r"(?:(D[BX]\s*\d+)\s*\.\s*)?(MW|EW|AW|MD|ED|AD|DW|DL|DR|DD|DBW|DBD|DBB|DBX|D)\s*(\d+(?:\.\d+)?)\b")
BLOCK = re.compile(r"(OB|PB|FB|FX|SB|FC)\s*(\d+)\b")
SYMBOL = re.compile(r'"([^"]+)"')
LINKS = {"U": "U", "UN": "UN", "O": "O", "ON": "ON", "X": "XO", "XN": "XON"}
OPENS = {"U(": "U(", "O(": "O(", "X(": "XO("}
OPENS_NOT = {"UN(": "U(", "ON(": "O(", "XN(": "XO("}
TIMERS = {"SI": "I", "SV": "V", "SE": "E", "SA": "A"}
COMPARES = {
    **{f"{sign}{kind}": to for sign, to in (("!=", "=?"), ("==", "=?"), ("><", "><"), ("<>", "><")) for kind in "FIDG"},
    **{f"{sign}{kind}": sign for sign in (">=", "<=", ">", "<") for kind in "FID"},
}
CALCULATES = {
    "+F": "+", "+I": "+", "+D": "+", "-F": "-", "-I": "-", "-D": "-", "XF": "MU", "*I": "MU", "*D": "MU", ":F": "DI",
    "/I": "DI", "/D": "DI",
    "TAK": "TA", "KEW": "K E", "INVI": "K E", "INVD": "K E", "KZW": "K Z", "NEGI": "K Z", "NEGD": "K Z",
    "UW": "U ACCU", "OW": "O ACCU", "XOW": "XO ACCU", "UD": "U ACCU", "OD": "O ACCU", "XOD": "XO ACCU",
    "BTI": "DH", "BTD": "DH", "ITB": "HD", "DTB": "HD",
}  # fmt: skip
SHIFTS = {"SLW": "SH L", "SRW": "SH R", "SLD": "SH L", "SRD": "SH R", "RLD": "RO L", "RRD": "RO R"}
SAVING = {"SPBB": "SPB", "SPBNB": "SPBN"}  # they keep the VKE in BIE, which is refused where it is read
EDGES = ("FP", "FN")  # constants that are loaded between an edge and its use leave the result alone
NARROW = {"SLW", "KEW", "INVI", "XF", "*I", "+F", "+I", "-F", "-I", "/I", ":F"}


class NoCounterpart(Exception):
    """A statement that cannot be translated; the text is the reason."""


@dataclass(slots=True)
class Level:
    """A bracket of the source: brackets to be closed with it, whether a single O is open in it."""

    closes: int = 1
    single_or: bool = False


@dataclass(slots=True)
class Translator:
    """One block.  `words` maps operands of the source to markers of the integrated PLC."""

    block: Block
    words: Mapping[str, str]
    english: bool = False
    spare: str = ""  # marker byte that nothing else uses; "": there is none
    spared: bool = False  # it is used
    pool: list[str] = field(default_factory=list)  # further ones, for local bytes
    blocks: frozenset[str] = frozenset()  # names of all blocks of the list
    local: dict[int, str] = field(default_factory=dict)  # local byte -> its marker byte
    lines: list[str] = field(default_factory=list)
    refused: list[Refused] = field(default_factory=list)
    calls: set[str] = field(default_factory=set)
    narrow: list[int] = field(default_factory=list)  # lines whose 16 bits become 32
    _levels: list[Level] = field(default_factory=lambda: [Level()])
    _fresh: bool = True
    _one: bool = False  # STEP has set the VKE to 1 after a conditional jump that was not taken
    _loaded: Kind | None = None
    _data: str = ""  # data block that is open
    _ends: bool = False  # a jump to the end
    _edges: int = 0
    _next: Statement | None = None
    _rest: list[Statement] = field(default_factory=list)  # the statement and those after it
    _line: int = 0
    _call: int | None = None  # place of a conditional call after which no chain has begun

    def run(self) -> str:
        """The program."""
        statements = self.block.statements
        if statements and statements[-1].word == "BE" and not statements[-1].label:
            statements = statements[:-1]
        for at, statement in enumerate(statements):
            self._rest = statements[at:]
            self._next = next(
                (each for each in statements[at + 1 :] if statement.word not in EDGES or each.word != "L" or each.label), None
            )
            before, self._line = len(self.lines), statement.line
            try:
                self._statement(statement)
                for line in self.lines[before:]:
                    if isinstance(wrong := step_of(line, 1), Wrong):
                        raise NoCounterpart(f"{wrong.text}; {wrong.hint}")
            except NoCounterpart as reason:
                label, made = f"M {statement.label}", self.lines[before:]
                del self.lines[before + (made.index(label) + 1 if label in made else 0) :]  # jumps to the label go on
                self._refuse(statement, str(reason))
        self._close_or()
        return "\n".join([f"PLC {self.block.name}", *self.lines, *([f"M {END}"] if self._ends else []), "END", ""])

    def _refuse(self, statement: Statement, reason: str) -> None:
        self.refused.append(Refused(statement.line, self.block.name, statement.text[:100], reason))
        self.lines.append(f"NOT_TRANSLATED {statement.text[:100].replace(';', ',')} ; line {statement.line}: {reason}")

    def _statement(self, statement: Statement) -> None:
        word, operand = statement.word, statement.operand
        if statement.label:
            self._close_or()
            if self._family(word) in (self._use, self._branch, self._leave) or self._goes_on():  # who falls into the label brings the 1
                self._result_is_one()
            self.lines.append(f"M {statement.label}")
            self._loaded, self._one, self._call = None, False, None
        family = self._family(word)
        if word == "?":
            raise NoCounterpart(operand)
        if family is None:
            formal = operand.startswith("=")  # LW, SVZ, SAR and others of a formal operand
            raise NoCounterpart(REASONS.get(word, REASONS["CALL"] if formal else f"the integrated PLC has no {word}"))
        family(word, operand)

    def _family(self, word: str) -> Callable[[str, str], None] | None:
        if word in LINKS:
            return self._link
        if word in OPENS or word in OPENS_NOT or word == ")":
            return self._bracket
        if word in COMPARES or word in CALCULATES or word in SHIFTS or word == "MOD":
            return self._calculate
        if word in TIMERS or word in ("S", "R", "=", "ZV", "ZR", "FP", "FN"):
            return self._use
        return {
            "L": self._load, "T": self._store, "SPA": self._branch, "SPB": self._branch, "SPBN": self._branch,
            "SPBB": self._branch, "SPBNB": self._branch,
            "UC": self._branch, "CC": self._branch, "CALL": self._branch, "BA": self._branch, "BAB": self._branch,
            "BE": self._leave, "BEA": self._leave, "BEB": self._leave, "SET": self._constant, "CLR": self._constant, "NOT": self._constant,
            "NOP": self._nothing, "BLD": self._nothing, "A": self._open_data, "AUF": self._open_data, "AX": self._open_data,
            "I": self._count_accu, "D": self._count_accu, "INC": self._count_accu, "DEC": self._count_accu,
            "+": self._add, "ADD": self._add,
        }.get(word)  # fmt: skip

    def _goes_on(self) -> bool:
        """Whether the result is used further on before a chain begins or a jump leads away."""
        for each in self._rest:
            family = self._family(each.word)
            if family in (self._link, self._bracket) or each.word in COMPARES or each.word in ("SET", "CLR"):
                return each.word == ")"
            if family in (self._use, self._constant) or each.word in ("SPB", "SPBN", "SPBB", "SPBNB", "CC", "BAB", "BEB"):
                return True
            if family in (self._branch, self._leave):
                return False
        return False

    def _nothing(self, word: str, operand: str) -> None:
        """NOP and BLD have no effect."""

    def _close_or(self) -> None:
        if self._levels[-1].single_or:
            self._levels[-1].single_or = False
            if self.lines[-1] == "O(":
                self.lines.pop()  # O x or O( follows: no AND has to be grouped
            else:
                self.lines.append(")")

    def _operand(self, operand: str) -> str:
        """A bit, timer or counter."""
        if found := BIT.match(operand):
            return self._marker(found[1], int(found[2])) + f".{found[3]}"
        if found := CELL.match(operand):
            return f"{found[1]}{int(found[2])}"
        if found := LOCAL.match(operand):
            return f"{self._local(int(found[1]))}.{found[2]}"
        if tabled := self._tabled(operand):
            return tabled
        self._symbol(operand)
        raise NoCounterpart(f"{operand or 'a missing operand'}: a bit of E, A or M, a timer or a counter is needed")

    def _local(self, byte: int) -> str:
        """The marker byte of a local byte: each block has its own."""
        if byte not in self.local:
            if not self.pool:
                raise NoCounterpart("local bits need spare marker bytes; all of M0 to M511 are used")
            self.local[byte] = self.pool.pop(0)
        return self.local[byte]

    def _symbol(self, operand: str) -> None:
        if STATUS.match(operand):
            raise NoCounterpart(NO_STATUS)
        if LOCAL_WORD.match(operand):
            raise NoCounterpart("local words: write marker words in their place, and give them markers with --words")
        if operand.startswith("="):
            raise NoCounterpart(REASONS["CALL"])
        if "[" in operand or operand.startswith("P#"):
            raise NoCounterpart(INDIRECT)
        if operand.startswith(('"', "#", "-")) and not operand[1:2].isdigit():
            raise NoCounterpart("operands by symbol: write the source with absolute operands")

    def _marker(self, area: str, number: int) -> str:
        if area == "M" and number > 511:
            raise NoCounterpart("M512 to M2047 are system markers of the integrated PLC")
        return f"{area}{number}"

    def _tabled(self, operand: str) -> str | None:
        """Return the marker of an operand in the table."""
        if not (found := TABLED.match(operand)):
            return None
        name = found[2] + found[3]
        data = "".join((found[1] or self._data).split())
        keys = [f"{data}.{name}"] if found[2].startswith("D") and data else []
        for key in (*keys, name):
            if key in self.words:
                return self.words[key]
        if found[2].startswith("D"):
            key, bit = (keys or [name])[0], ".1" if "." in name else ""
            raise NoCounterpart(f"{key} has no marker; give it one with --words: {key} = M200{bit}")
        raise NoCounterpart(WORD_ORDER)

    def _link(self, word: str, operand: str) -> None:
        level = self._levels[-1]
        if word == "O" and not OPERAND_LIKE.match(operand):
            self._close_or()
            self.lines.append("O(")
            level.single_or = True
        else:
            if word not in ("U", "UN"):
                self._close_or()
            self.lines.append(f"{LINKS[word]} {self._operand(operand)}")
        self._fresh, self._one, self._call = False, False, None

    def _bracket(self, word: str, operand: str) -> None:
        if word == ")":
            if len(self._levels) == 1:
                raise NoCounterpart("this bracket was not opened")
            self._close_or()
            self.lines += [")"] * self._levels.pop().closes
            self._fresh = False
            return
        if re.match(r"[EAMTZ]\s*\d", operand):
            self._levels.append(Level(0))  # its end is not a separate mistake
            raise NoCounterpart(f"{word} has no operand; the first link of a bracket is a statement of its own")
        if word not in ("U(", "UN("):
            self._close_or()
        if word in OPENS_NOT:
            self.lines += [OPENS_NOT[word], *ONE, "XO("]
        else:
            self.lines.append(OPENS[word])
        self._levels.append(Level(2 if word in OPENS_NOT else 1))
        self._fresh, self._one, self._call = True, False, None

    def _constant(self, word: str, operand: str) -> None:
        self._close_or()
        if word == "NOT":
            if self._fresh:
                raise NoCounterpart("NOT after the end of a chain; invert the chain itself")
            self.lines += ["XO(", *ONE, ")"]
            return
        word_next = "" if self._next is None else self._next.word
        family = self._family(word_next) if word_next != ")" else self._use  # the end of a bracket uses its content
        begun = not self._fresh
        if family not in (self._link, self._bracket):
            self.lines += ONE if word == "SET" else ("U M0.0", "UN M0.0")
            if word_next == "NOT":
                self._fresh, self._one = False, False
                return
            begun = family not in (None, self._use, self._branch)
        if begun:  # a chain that nothing ends: a jump to the next command does
            self.lines += [f"SP _ANEW{self._edges}", f"M _ANEW{self._edges}"]
            self._edges += 1
        self._fresh, self._one = True, False

    def _result_is_one(self) -> None:
        """STEP sets the VKE to 1 where a conditional jump is not taken; the integrated PLC leaves it."""
        if self._one:
            self.lines += ONE
        elif self._call is not None:
            call, number = self.lines[self._call], self._edges
            self._edges += 1
            one, two = f"_CALL{number}A", f"_CALL{number}B"
            name, _, when = call.partition(",")
            around = "0" if when == "1" else "1"
            self.lines[self._call] = "\n".join([f"SP {one},{around}", name, f"SP {two}", f"M {one}", *ONE, f"M {two}"])
        self._one, self._call = False, None

    def _use(self, word: str, operand: str) -> None:
        self._close_or()
        self._result_is_one()
        if word in EDGES:
            self._edge(word, operand)
            return
        if word in TIMERS:
            if self._loaded is not Kind.TIME:
                raise NoCounterpart("the time is not loaded as a constant (L KT) in front; BCD with a time base has no counterpart")
            self.lines.append(f"ST {TIMERS[word]},{self._operand(operand)}")
        elif word in ("ZV", "ZR"):
            self.lines.append(f"{word} {self._operand(operand)},1")
        else:
            target = self._operand(operand)
            if word == "S" and target.startswith("Z") and self._loaded is not Kind.COUNT:
                raise NoCounterpart("the count is not loaded as a constant (L KZ) in front; BCD has no counterpart")
            self.lines.append(f"{word} {target}")
        self._fresh = True

    def _edge(self, word: str, operand: str) -> None:
        """Translate edges by jumps: after them the result is that of the edge, and the next statement has to use it."""
        after = self._next and self._next.word
        bit, number = self._operand(operand), self._edges
        if after not in ("=", "S", "R", "SPB", "SPBN", "SPBB", "SPBNB", "CC", "BEB", "ZV", "ZR", *TIMERS) or (
            self._next and self._next.label
        ):
            self._edge_in_a_chain(word, bit)
            return
        self._edges += 1
        one, two = f"_EDGE{number}A", f"_EDGE{number}B"
        if word == "FP":
            self.lines += [f"SP {one},0", f"UN {bit}", f"S {bit}", f"SP {two}", f"M {one}", f"U {bit}", f"R {bit}", f"U {bit}", f"M {two}"]
        else:
            self.lines += [f"SP {one},1", f"U {bit}", f"R {bit}", f"SP {two}", f"M {one}", f"UN {bit}", f"S {bit}", f"UN {bit}", f"M {two}"]
        self._fresh = True

    def _edge_in_a_chain(self, word: str, bit: str) -> None:
        """Translate an edge inside a chain: its result and the previous one are kept in two spare bits, and the last one begins a chain."""
        if self._next and self._next.label:
            raise NoCounterpart(f"a jump leads to the statement after {word}, which continues with its result")
        if not self.spare:
            raise NoCounterpart(f"{word} with a logic chain that continues needs two spare marker bits; all of M0 to M511 are used")
        now, edge, self.spared = f"{self.spare}.0", f"{self.spare}.1", True
        first, second = ("U", "UN") if word == "FP" else ("UN", "U")
        self.lines += [f"= {now}", f"{first} {now}", f"{second} {bit}", f"= {edge}", f"U {now}", f"= {bit}", f"U {edge}"]
        self._fresh = False

    def _load(self, word: str, operand: str) -> None:
        self._loaded = kind_of(operand)
        if found := BYTE.match(operand):
            self.lines.append(f"L {self._marker(found[1], int(found[2]))}")
        elif found := LOCAL_BYTE.match(operand):
            self.lines.append(f"L {self._local(int(found[1]))}")
        elif CELL.match(operand):
            raise NoCounterpart(REASONS["LC"])
        elif re.match(r"P[YEAW]|P[EA][BWD]|QB|QW", operand):
            raise NoCounterpart("peripheral bytes are read as E only")
        elif found := TABLED.match(operand):
            self.lines.append(f"{'L' if found[2] in ('DL', 'DR', 'DBB') else 'LD'} {self._tabled(operand)}")
        elif (constant := constant_of(operand, self.english)) is not None:
            self.lines.append(f"L {constant.value}")
            self._loaded = constant.kind
            if constant.value > 0x7FFF and constant.kind is Kind.NUMBER and not operand.startswith(("DH", "DW#", "DWORD#", "L#")):
                self.narrow.append(self._line)  # a negative word to comparisons and calculations with 16 bits
        else:
            self._symbol(operand)
            raise NoCounterpart(f"{operand or 'a missing operand'}: {NO_TIME if self._loaded is Kind.TIME else NO_CONSTANT}")

    def _store(self, word: str, operand: str) -> None:
        if found := BYTE.match(operand):
            self.lines.append(f"T {self._marker(found[1], int(found[2]))}")
        elif found := LOCAL_BYTE.match(operand):
            self.lines.append(f"T {self._local(int(found[1]))}")
        elif found := TABLED.match(operand):
            self.lines.append(f"{'T' if found[2] in ('DL', 'DR', 'DBB') else 'TD'} {self._tabled(operand)}")
        else:
            self._symbol(operand)
            raise NoCounterpart(f"{operand or 'a missing operand'}: a byte of E, A or M is needed")

    def _calculate(self, word: str, operand: str) -> None:
        self._loaded = None
        if word in ("MOD", "/D", "/I") and self._reads_second():
            raise NoCounterpart(REST)
        if word in NARROW:
            self.narrow.append(self._line)
        if word == "SRW" and (places := re.match(r"(\d+)\b", operand)) and int(places[1]):
            self.lines += ["SH L,16", f"SH R,{16 + int(places[1])}"]  # zeros move into a word: the upper half is cleared before
        elif word in SHIFTS:
            self.lines.append(f"{SHIFTS[word]},{operand.split(maxsplit=1)[0] if operand else ''}")
        elif word in COMPARES:
            self.lines.append(COMPARES[word])
            self._fresh, self._one, self._call = False, False, None
        elif word == "MOD":
            self.lines += ["DI", "TA"]
        else:
            self.lines.append(CALCULATES[word])

    def _reads_second(self) -> bool:
        """Return whether a later statement uses ACCU2 before a load fills it."""
        for each in self._rest[1:]:
            if each.word == "L" or each.label:
                return False
            if each.word in COMPARES or each.word == "MOD" or CALCULATES.get(each.word, "K E") not in ("K E", "K Z", "DH", "HD"):
                return True
        return False

    def _count_accu(self, word: str, operand: str) -> None:
        self._loaded = None
        if not re.match(r"\d+\b", operand):
            raise NoCounterpart(f"{word} {operand}: a number from 0 to 255 is needed")
        self.narrow.append(self._line)
        self.lines.append(f"{'ZV' if word in ('I', 'INC') else 'ZR'} ACCU,{operand.split(maxsplit=1)[0]}")

    def _add(self, word: str, operand: str) -> None:
        """A constant is added to ACCU1, and ACCU2 stays: + 1, ADD BF +1, ADD KF -20."""
        self._loaded = None
        found = re.match(r"(?:(?:BF|BN|KF|DF|DH)\b\s*|L#)?([+-]?\s*\d+)\b(?![.#])", operand)
        if not found or not -255 <= (number := int("".join(found[1].split()))) <= 255:
            raise NoCounterpart(f"{word} {operand}: a constant from -255 to 255 can be added; load a larger one with L, and use +I")
        if not operand.startswith("L#"):
            self.narrow.append(self._line)
        self.lines.append(f"{'ZV' if number >= 0 else 'ZR'} ACCU,{abs(number)}")

    def _branch(self, word: str, operand: str) -> None:
        self._close_or()
        word = SAVING.get(word, word)
        when = {"SPB": ",1", "CC": ",1", "BAB": ",1", "SPBN": ",0"}.get(word, "")
        if when:
            self._result_is_one()
        block = BLOCK.match(operand) or SYMBOL.match(operand)
        name = "".join("".join(block.groups()).split()) if block else ""
        if block and (block.re is BLOCK or name in self.blocks):
            if word in ("CALL", "UC", "CC") and operand[block.end() :].strip().startswith(("(", ",")):
                raise NoCounterpart(REASONS["CALL"])
            self.calls.add(name)
            self.lines.append(f"SU {name}{when}")
            self._fresh, self._one, self._call = True, False, len(self.lines) - 1 if when else None
            return
        elif "[" in operand:
            raise NoCounterpart(INDIRECT)
        elif word in ("SPA", "SPB", "SPBN") and (label := re.match(r"=?\s*([A-Z_][A-Z0-9_]*)", operand)):
            if label[1] not in {each.label for each in self.block.statements}:
                raise NoCounterpart(f"this block has no label {label[1]}")
            self.lines.append(f"SP {label[1]}{when}")
        else:
            self._symbol(operand)
            raise NoCounterpart(f"{operand or 'a missing operand'}: a label or a block is needed")
        self._fresh, self._one = True, bool(when)

    def _leave(self, word: str, operand: str) -> None:
        self._close_or()
        if word == "BEB":
            self._result_is_one()
        self.lines.append(f"SP {END}{',1' if word == 'BEB' else ''}")
        self._ends, self._fresh, self._one = True, True, word == "BEB"

    def _open_data(self, word: str, operand: str) -> None:
        found = re.match(r"(DB|DX|DI)\s*(\d+)\b", operand)
        if not found:
            raise NoCounterpart(f"{word} {operand}: a data block is needed")
        self._data = found[1] + found[2]
