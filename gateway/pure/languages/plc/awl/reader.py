"""Reads a statement list: printed listings of STEP 5, sources of STEP 7, bare lists.  Blocks, labels, words and operands, in German."""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace

from gateway.pure.languages.plc.awl.slips import heading_of, label_of, put_right, without_colon

STEP7 = re.compile(r"^\s*(ORGANIZATION_BLOCK|FUNCTION_BLOCK|FUNCTION|BEGIN)\b", re.IGNORECASE | re.MULTILINE)
OPENED = re.compile(r"(ORGANIZATION_BLOCK|FUNCTION_BLOCK|FUNCTION)\s+(?:\"([^\"]+)\"|([A-Z]+\s*\d+|[^\"\s:]+))", re.IGNORECASE)
SKIPPED = re.compile(r"(DATA_BLOCK|TYPE)\b\s*(.*)", re.IGNORECASE)
HEADER = re.compile(
    r"#?(?:(?:(?:ORGANISATIONS|PROGRAMM|FUNKTIONS|SCHRITT|DATEN)?BAUSTEIN|BLOCK|BSTN)\s*[#:=]?\s*)?"
    r"(OB|PB|FB|FX|SB|FC|DB|DX)\s*(\d{1,3})\b(?!\s*\.)\s*(.*)$",
    re.IGNORECASE,
)
NOISE = re.compile(
    r"(SEGMENT|NETZWERK|NETWORK|TITLE|TITEL|VERSION|AUTHOR|AUTOR|FAMILY|FAMILIE|BLATT|PAGE|BEGIN|STANDARD|KNOW_HOW_PROTECT|LAE|LEN|BIB|LIB)\b",
    re.IGNORECASE,
)
DECLARATION = re.compile(r"VAR(_TEMP|_INPUT|_OUTPUT|_IN_OUT)?\b", re.IGNORECASE)
ADDRESSED = re.compile(r"(?:[0-9A-F][0-9A-FO]{3,5}|O[0-9O]{3,5})\s*(?=[:A-Z])", re.IGNORECASE)
PARAMETER = re.compile(r"(?:[EAMTZDIQCB][BWD]?\s+\d|K[A-Z]\s|[A-Z]+/[A-Z]+/)", re.IGNORECASE)
PRINTED = re.compile(r"\s*(?:[0-9A-F]{4,6}\s+)?[A-Z0-9_]{0,8}\s*:", re.IGNORECASE)
MORE = re.compile(  # a second statement in the same line: a lost line end, or a second column of the print
    r"\s(?:(?:UN?|ON?|XN?|=|S|R|L|T|ZV|ZR|S[IVEA])\s+[EAMTZIQFC][BWD]?\s*\d|(?:SPA|SPB)\s+(?:=|[PFS]B\s*\d))|\s[0-9A-F]{4}\s+\w{0,4}\s*:",
    re.IGNORECASE,
)
ADDS = re.compile(r"(?:\d*\s*:)?\s*\+\s*-?\d")  # STEP 7 adds a constant: a statement without a letter
DECLARES = re.compile(r"(?:BEZ|DECL)\s*:.*\b[EI]/[AQ]/D/B/[TC]", re.IGNORECASE)  # BEZ :EIN  E/A/D/B/T/Z: E  BI/BY/W/D: BI, of STEP 5
JUMP = re.compile(r"=?\s*([A-Z_0-9][A-Z0-9_]*)$")
LABELLED = re.compile(r"([A-Z_][A-Z0-9_]{0,23})?\s*:\s*(.*)$", re.IGNORECASE)
WORD = re.compile(
    r"(==[IDR]|<>[IDR]|[><]=?[IDRFG]|>=[IDFG]|<=[IDFG]|!=[FDG]|><[FDG]|[+\-*/:X][IDRFG]\b|[LT]AR[12]\b|\+AR[12]\b|\+|[A-Z]+\(|=|\)|[A-Z]+\b)\s*(.*)$",
    re.IGNORECASE,
)
ENGLISH = {
    "A": "U", "AN": "UN", "A(": "U(", "AN(": "UN(", "JU": "SPA", "JC": "SPB", "JCN": "SPBN", "JNB": "SPBNB", "JCB": "SPBB",
    "BEC": "BEB", "BEU": "BEA",
    "CU": "ZV", "CD": "ZR", "SP": "SI", "SE": "SV", "SD": "SE", "SF": "SA", "AW": "UW", "AD": "UD", "CFW": "KEW", "CSW": "KZW",
    "OPN": "AUF", "C": "A", "LD": "LC", "JZ": "SPZ", "JN": "SPN", "JP": "SPP", "JM": "SPM", "JO": "SPO", "LOOP": "LOOP", "DO": "B",
}  # fmt: skip
OPERANDS = {
    "I": "E",
    "Q": "A",
    "C": "Z",
    "IB": "EB",
    "QB": "AB",
    "IW": "EW",
    "QW": "AW",
    "ID": "ED",
    "QD": "AD",
    "PIB": "PEB",
    "PQB": "PAB",
    "F": "M",  # flags of STEP 5
    "FY": "MB",
    "FW": "MW",
    "FD": "MD",
}
MARKS_ENGLISH = re.compile(
    r"(?:^|[:;\s])(?:(?:AN?|ON?|=|S|R|L|T)\s+(?:[IQ][BWD]?|F[YWD]?)\s*\d|JU\s|JC\s|BEU|BEC|AN\(?\s|A\()", re.IGNORECASE
)
MARKS_GERMAN = re.compile(r"(?:^|[:;\s])(?:UN?\s|UN?\(|SPA\s|SPB\s|BEA\b|BEB\b|(?:ON?|=|S|R|L|T)\s+[EA][BWD]?\s*\d)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement: word and operand in capital letters, German; `text` as it was written."""

    line: int
    label: str
    word: str
    operand: str
    text: str


@dataclass(slots=True)
class Block:
    """A block under the name its program gets."""

    name: str
    line: int
    statements: list[Statement] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Refused:
    """A line that was not translated, and why."""

    line: int
    block: str
    text: str
    reason: str


@dataclass(slots=True)
class Listing:
    """Blocks, and the lines that the reader itself refused."""

    blocks: list[Block] = field(default_factory=list)
    refused: list[Refused] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def english_of(text: str) -> bool:
    """Whether the list uses the English mnemonics."""
    return len(MARKS_ENGLISH.findall(text)) > len(MARKS_GERMAN.findall(text))


@dataclass(slots=True)
class Reader:
    """One run over a text."""

    text: str
    found: Listing = field(default_factory=Listing)
    step7: bool = False
    english: bool = False
    _printed: bool = False  # a listing: each statement has a colon
    _addressed: bool = False  # and its address in front; else FADE and ADD1 are labels
    _bare: bool = False  # a listing with addresses whose colons are not printed
    _block: Block | None = None
    _skipping: re.Pattern[str] | None = None  # up to the line that matches
    _skipped: str = ""

    def run(self) -> Listing:
        """The blocks."""
        bare = re.sub(r"//.*", "", self.text)
        self.step7, self.english = bool(STEP7.search(bare)), english_of(bare)
        lines = [line for line in bare.splitlines() if line.strip()]
        self._printed = not self.step7 and 2 * sum(bool(PRINTED.match(line)) for line in lines) > len(lines)
        addresses = [ADDRESSED.match(line.strip()) for line in lines if ":" in line]
        numbers = sum(found[0][0] in "0123456789Oo" for found in addresses if found)  # a label begins with a letter: FADE, ADD1
        self._addressed = not self.step7 and 2 * numbers > sum(found is not None for found in addresses)
        if not self.step7 and not addresses and 2 * sum(bool(without_colon(line)) for line in lines) > len(lines):
            self._printed = self._addressed = self._bare = True
            self.found.notes.append("the listing has no colons: what follows an address is read as a statement")
        for number, line in enumerate(self.text.removeprefix("\ufeff").splitlines(), 1):
            for part in self._parts(number, line):
                self._line(number, part)
        for block in self.found.blocks:
            labels = {each.label for each in block.statements if each.label}
            block.statements = [self._led(labels, each) for each in block.statements]
        return self.found

    def _parts(self, number: int, line: str) -> Iterator[str]:
        line = line.split("//", maxsplit=1)[0].replace("\f", " ").replace("\t", " ")
        if self._addressed and ":" not in line and (meant := without_colon(line)):
            if not self._bare:
                self._read_as(number, line.strip(), meant)
            line = meant
        before, _, comment = line.partition(";")
        spaced = re.sub(r"^\s*(=|[A-Z]{1,3})\s*(?=[EAMTZIQ]\s*\d)", r" \1 ", comment, flags=re.IGNORECASE)
        parts = line.split(";") if self.step7 else [before + spaced if MORE.match(spaced) else before]
        yield from (part.strip() for part in parts if part.strip())

    def _line(self, number: int, part: str) -> None:
        if self._skipping is not None:
            if self._skipping.match(part):
                self._skipping = None
            return
        if part.upper().startswith("END_"):
            self._block = None
        elif opened := OPENED.match(part):
            self._begin(opened[2] or opened[3], number)
        elif skipped := SKIPPED.match(part):
            self._skipping = re.compile(rf"END_{skipped[1]}\b", re.IGNORECASE)
            self._refuse(number, part, "the integrated PLC has no data blocks and no types; give its words markers with --words")
        elif DECLARATION.match(part):
            self._declaration(number, part)
        elif not self._header(number, part):
            self._statement(number, part)

    def _declaration(self, number: int, part: str) -> None:
        self._skipping = re.compile(r"END_VAR\b", re.IGNORECASE)
        if DECLARATION.match(part) and re.match(r"VAR_(INPUT|OUTPUT|IN_OUT)", part, re.IGNORECASE):
            self._refused(number, "", part, "subprograms of the integrated PLC have no parameters")

    def _header(self, number: int, part: str) -> bool:
        """Whether the line is a heading, or print without a meaning for the program."""
        if not self.step7 and (meant := heading_of(part)) != part:
            self._read_as(number, part, meant)
            part = meant
        found = HEADER.match(part)
        if found and not self.step7 and not found[3].startswith(":"):
            if found[1].upper() in ("DB", "DX"):
                self._refuse(number, part, "the integrated PLC has no data blocks; give their words markers with --words")
                self._block = Block("", number)
            else:
                self._begin(found[1] + found[2], number)
            return True
        return NOISE.match(part) is not None or not (re.search(r"[A-Z=)(]", part, re.IGNORECASE) or ADDS.match(part))

    def _begin(self, name: str, number: int) -> None:
        name = "".join(name.upper().split())
        there = next((block for block in self.found.blocks if block.name == name), None)
        if there is None:
            there = Block(name, number)
            self.found.blocks.append(there)
        self._block = there

    def _refuse(self, number: int, text: str, reason: str) -> None:
        self.found.refused.append(Refused(number, self._block.name if self._block else "", text[:100], reason))

    def _refused(self, number: int, label: str, text: str, reason: str) -> None:
        """A line that is not a statement; its place in the block is kept."""
        self._refuse(number, text, reason)
        self._add(Statement(number, label, "?", reason, text))

    def _statement(self, number: int, part: str) -> None:
        if self._block is not None and not self._block.name:
            return  # a row of a data block, which its head has named
        addressed = ADDRESSED.match(part) if self._addressed else None
        body = part[addressed.end() :] if addressed and ":" in part else part
        label, rest = "", body
        if labelled := LABELLED.match(body):
            label, rest = (labelled[1] or "").upper(), labelled[2].strip()
        if self._named(label, rest):
            return
        if self._printed and ":" not in body:
            self.found.notes.append(f"line {number}: {part[:60]!r} is read as print: it has no ':'")
            return
        if label and ((self.step7 and ":=" in body) or PARAMETER.match(rest) or DECLARES.match(body)):
            self._refused(number, "", part, "subprograms of the integrated PLC have no parameters")
            return
        if not rest or rest.startswith("***"):
            if label:
                self._add(Statement(number, label, "NOP", "0", part))
            return
        if (meant := put_right(rest.upper())) != rest.upper():
            self._read_as(number, rest, meant)
            rest = meant
        word = WORD.match(rest)
        if word is None:
            self._refused(number, label, part, "this line is not a statement of STEP 5 or STEP 7")
            return
        if MORE.search(f" {word[2]}" if word[1] in ("(", ")") or word[1].endswith("(") else word[2]):
            self._refused(number, label, part, "there is more than one statement in the line; write one per line")
            return
        self._add(self._normal(number, label, word[1].upper(), word[2].strip(), part))

    def _read_as(self, number: int, text: str, meant: str) -> None:
        self.found.notes.append(f"line {number}: {text[:60]!r} is read as {meant[:60]!r}")

    def _led(self, labels: Collection[str], statement: Statement) -> Statement:
        """A jump to a label of the block, also where one of the two is misread."""
        found = JUMP.match(statement.operand) if statement.word in ("SPA", "SPB", "SPBN", "SPBB", "SPBNB") else None
        if found is None or found[1] in labels or not (meant := label_of(found[1], labels)):
            return statement
        self._read_as(statement.line, statement.operand, f"={meant}")
        return replace(statement, operand=f"={meant}")

    def _named(self, label: str, rest: str) -> bool:
        """The name line of a function block in a listing of STEP 5."""
        last = self._block.statements[-1] if self._block and self._block.statements else None
        return label == "NAME" and (last is None or last.operand.startswith(("FB", "FX")))

    def _add(self, statement: Statement) -> None:
        if self._block is None:
            self._begin("OB1", statement.line)
        if self._block is not None and self._block.name:
            self._block.statements.append(statement)

    def _normal(self, number: int, label: str, word: str, operand: str, text: str) -> Statement:
        operand = " ".join(operand.upper().split())
        if self.english:
            word = ENGLISH.get(word, word)
            jumps = word.startswith("SP")  # to a label, which may look like an operand: M001, I1
            if not jumps and (found := re.match(r"([A-Z]+)\s*(?=\d)(?![^ ]*#)", operand)):  # S5T#1S is a constant
                operand = OPERANDS.get(found[1], found[1]) + " " + operand[found.end() :]
        return Statement(number, label, word, operand, text)
