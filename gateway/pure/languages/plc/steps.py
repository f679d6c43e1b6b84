"""Steps of a PLC program of the ROBOTstar V, one a line.  Source: robotstar 2.1, 5.2, 5.3, L2418-2722, D14, D17, D18; AX-742."""

import re
from collections.abc import Callable
from dataclasses import dataclass

from gateway.pure.languages.plc.commands import Code, Command, Operand

INPUTS, OUTPUTS, AREA, SIZE = 1968, 2008, 40, 2048  # binary inputs and outputs follow the markers (L2985)
NAME_LENGTH = 128
AREAS = {"E": INPUTS, "I": INPUTS, "A": OUTPUTS, "O": OUTPUTS, "M": 0}
LENGTHS = {"E": AREA, "I": AREA, "A": AREA, "O": AREA, "M": SIZE}
BIT = re.compile(r"([EIAOM])\s*(\d{1,6})\s*\.\s*(\d{1,6})$")
BYTE = re.compile(r"([EIAOM])\s*(\d{1,6})$")
CELL = re.compile(r"([TZ])\s*(\d{1,6})$")
DECIMAL, HEXADECIMAL = re.compile(r"[+-]?\d{1,10}$"), re.compile(r"0{0,8}[0-9A-F]{1,8}H$")
LINKS = {"U": Code.AND, "UN": Code.AND_NOT, "O": Code.OR, "ON": Code.OR_NOT, "XO": Code.XOR, "XON": Code.XOR_NOT}
ACCUS = {"U": Code.ACCU_AND, "O": Code.ACCU_OR, "XO": Code.ACCU_XOR}
OPENS = {"U": Code.OPEN_AND, "O": Code.OPEN_OR, "XO": Code.OPEN_XOR}
WRITES = {"S": Code.SET, "R": Code.RESET, "=": Code.ASSIGN}
MOVES = {"L": Code.LOAD_BYTE, "LD": Code.LOAD_LONG, "T": Code.STORE_BYTE, "TD": Code.STORE_LONG}
PLACES = {"SH R": Code.SHIFT_RIGHT, "SH L": Code.SHIFT_LEFT, "RO R": Code.ROTATE_RIGHT, "RO L": Code.ROTATE_LEFT}
COUNTS = {"ZV": (Code.COUNT_UP, 1), "ZR": (Code.COUNT_DOWN, -1)}
BRANCHES = {
    "SP": {"": Code.JUMP, "1": Code.JUMP_IF, "0": Code.JUMP_IF_NOT},
    "SU": {"": Code.CALL, "1": Code.CALL_IF, "0": Code.CALL_IF_NOT},
}
ALONE = {
    ")": Code.CLOSE,
    "=?": Code.EQUAL,
    "><": Code.UNEQUAL,
    ">=": Code.NOT_LESS,
    ">": Code.GREATER,
    "<=": Code.NOT_GREATER,
    "<": Code.LESS,
    "+": Code.PLUS,
    "-": Code.MINUS,
    "--": Code.MINUS,
    "MU": Code.TIMES,
    "DI": Code.DIVIDE,
    "K E": Code.ONES,
    "K Z": Code.TWOS,
    "TA": Code.EXCHANGE,
    "HD": Code.TO_BCD,
    "DH": Code.FROM_BCD,
}
WORD = re.compile(r"(XON|XO|UN|ON|LD|TD|ST|ZV|ZR|SH|RO|SP|SU|U|O|S|R|L|T|M)(?![A-Z_])|(=)(?!\?)")
NO_COMMAND, LEFT_OPEN = "No PLC-command", "NOT_TRANSLATED"  # the second begins what an import could not translate


@dataclass(frozen=True, slots=True)
class Wrong:
    """Why a line is not a step: the text of the control, or the allowed operands."""

    text: str
    hint: str = ""


def step_of(text: str, line: int) -> Command | Wrong | None:
    """The command of a step without its number; None: a comment alone."""
    branch = re.match(r"(SP|SU|M)\s+(?=\S)", text, re.IGNORECASE)
    if branch and not _marker_like(text):
        return _branch(branch[1].upper(), text[branch.end() :].strip(), line)
    body = " ".join(text.split(";", 1)[0].upper().split())
    if not body:
        return None
    if body in ALONE:
        return Command(ALONE[body], line)
    if opened := re.match(r"(XO|U|O) ?\( ?\)?$", body):
        return Command(OPENS[opened[1]], line)
    word = WORD.match(body)
    if body.startswith(LEFT_OPEN):
        statement, _, reason = text.partition(" ; ")
        return Wrong(NO_COMMAND, f"the import did not translate {statement[len(LEFT_OPEN) :].strip()}; {reason.strip()}".rstrip("; "))
    if word is None:
        return Wrong(NO_COMMAND, f"{text.strip()[:60]!r} is not a command of the integrated PLC")
    name = word[1] or word[2]
    return FAMILIES[name](name, body[word.end() :].strip(), line)


def _marker_like(text: str) -> bool:
    """Return whether a text is an operand without its command: `M 5.0` is not a label."""
    return re.match(r"M\s*\d+\s*\.\s*\d", text, re.IGNORECASE) is not None


def _branch(word: str, rest: str, line: int) -> Command | Wrong:
    if ";" in rest:
        return Wrong(f"A comment cannot follow {word}", "write the comment as a step of its own, introduced by ';'")
    name, comma, when = (part.strip() for part in rest.partition(","))
    if len(name) > 2 and name[0] == name[-1] and name[0] in "'\"":
        name = name[1:-1].strip()
    if not name or len(name) > NAME_LENGTH or '"' in name or "'" in name:
        return Wrong(f"{word} {rest[:60]}: no name", f"names have 1 to {NAME_LENGTH} characters without quotation marks")
    if word == "M":
        return Wrong("M has one name and no condition") if comma else Command(Code.LABEL, line, name=name.upper())
    if comma and when not in ("0", "1"):
        return Wrong(f"{word} {rest[:60]}: condition {when or 'missing'}", "the condition is 1 (VKE = 1) or 0 (VKE = 0)")
    return Command(BRANCHES[word][when], line, name=name.upper())


def _place(area: str, number: int, size: int) -> int | Wrong:
    last = LENGTHS[area] - size
    if number > last:
        return Wrong(f"{area}{number}: outside 0..{last}", f"{area} 0 to {area} {last}")
    return AREAS[area] + number


def _bit(code: Code, found: re.Match[str], line: int) -> Command | Wrong:
    byte = _place(found[1], int(found[2]), 1)
    if isinstance(byte, Wrong):
        return byte
    if int(found[3]) > 7:
        return Wrong(f"bit {found[3]}: outside 0..7", f"{found[1]}{found[2]}.0 to {found[1]}{found[2]}.7")
    return Command(code, line, byte=byte, mask=1 << int(found[3]))


def _cell(code: Code, found: re.Match[str], line: int) -> Command | Wrong:
    if int(found[2]) > 31:
        return Wrong(f"{found[1]}{found[2]}: outside 0..31", f"{found[1]} 0 to {found[1]} 31")
    operand = Operand.TIMER if found[1] == "T" else Operand.COUNTER
    return Command(code, line, operand, cell=int(found[2]))


def _link(word: str, rest: str, line: int) -> Command | Wrong:
    if rest == "ACCU" and word in ACCUS:
        return Command(ACCUS[word], line)
    if found := BIT.match(rest):
        return _bit(LINKS[word], found, line)
    if found := CELL.match(rest):
        return _cell(LINKS[word], found, line)
    if rest.startswith("("):
        hint = f"{word}( is a step of its own" if word in OPENS else "brackets are opened by U(, O( and XO("
        return Wrong(f"{word}{rest[:60]}: wrong operand", hint)
    return Wrong(f"{word} {rest[:60]}: wrong operand", "a bit of E, A or M (E0.6), a timer (T5) or a counter (Z5)")


def _write(word: str, rest: str, line: int) -> Command | Wrong:
    if found := BIT.match(rest):
        return _bit(WRITES[word], found, line)
    if word == "S" and (found := re.match(r"(Z)\s*(\d{1,6})$", rest)):
        return _cell(Code.COUNTER_SET, found, line)
    if word == "R" and (found := CELL.match(rest)):
        return _cell(Code.CELL_RESET, found, line)
    cells = {"S": " or a counter (Z5)", "R": ", a timer (T5) or a counter (Z5)"}.get(word, "")
    return Wrong(f"{word} {rest[:60]}: wrong operand", f"a bit of A, E or M (A1.0){cells}")


def _move(word: str, rest: str, line: int) -> Command | Wrong:
    size = 4 if word in ("LD", "TD") else 1
    if found := BYTE.match(rest):
        byte = _place(found[1], int(found[2]), size)
        return byte if isinstance(byte, Wrong) else Command(MOVES[word], line, byte=byte)
    if word == "L":
        number = constant(rest)
        if number is not None:
            return Command(Code.LOAD, line, number=number)
    constants = ", a decimal constant or a hexadecimal one with H (12ACH)" if word == "L" else ""
    return Wrong(f"{word} {rest[:60]}: wrong operand", f"a byte of E, A or M (M20){constants}")


def constant(text: str) -> int | None:
    """A constant of 32 bits as a signed number; None: it is none."""
    if HEXADECIMAL.match(text):
        value = int(text[:-1], 16)
    elif DECIMAL.match(text):
        value = int(text)
    else:
        return None
    if not -0x80000000 <= value <= 0xFFFFFFFF:
        return None
    return value - 0x100000000 if value > 0x7FFFFFFF else value


def _number(name: str, code: Code, text: str, most: int, line: int, sign: int = 1) -> Command | Wrong:
    if not re.match(r"\d{1,6}$", text) or int(text) > most:
        return Wrong(f"{name},{text[:60]}: outside 0..{most}", f"a number from 0 to {most} after the comma")
    return Command(code, line, number=sign * int(text))


def _count(word: str, rest: str, line: int) -> Command | Wrong:
    operand, comma, number = (part.strip() for part in rest.partition(","))
    code, sign = COUNTS[word]
    if operand == "ACCU":
        return _number(f"{word} ACCU", Code.ADD_NUMBER, number, 255, line, sign)
    if (found := re.match(r"(Z)\s*(\d{1,6})$", operand)) and comma and number == "1":
        return _cell(code, found, line)
    return Wrong(f"{word} {rest[:60]}: wrong operand", f"{word} Z5,1 counts a counter, {word} ACCU,5 the accumulator")


def _shift(word: str, rest: str, line: int) -> Command | Wrong:
    side, comma, number = (part.strip() for part in rest.partition(","))
    if side not in ("L", "R") or not comma:
        return Wrong(f"{word} {rest[:60]}: wrong operand", f"{word} L,n or {word} R,n with n from 0 to 31")
    return _number(f"{word} {side}", PLACES[f"{word} {side}"], number, 31, line)


def _timer(word: str, rest: str, line: int) -> Command | Wrong:
    kind, comma, cell = (part.strip() for part in rest.partition(","))
    found = re.match(r"(T)\s*(\d{1,6})$", cell)
    if kind not in ("I", "V", "E", "A") or not comma or not found:
        return Wrong(f"{word} {rest[:60]}: wrong operand", "ST I,T5 with the timer type I, V, E or A")
    placed = _cell(Code.TIMER, found, line)
    return placed if isinstance(placed, Wrong) else Command(Code.TIMER, line, Operand.TIMER, cell=placed.cell, name=kind)


def _unnamed(word: str, rest: str, line: int) -> Wrong:
    return Wrong(f"{word}{rest[:60]}: no name", f"{word} is followed by a blank and a name")


FAMILIES: dict[str, Callable[[str, str, int], Command | Wrong]] = {
    **dict.fromkeys(LINKS, _link),
    **dict.fromkeys(WRITES, _write),
    **dict.fromkeys(MOVES, _move),
    **dict.fromkeys(COUNTS, _count),
    **dict.fromkeys(("SH", "RO"), _shift),
    "ST": _timer,
    **dict.fromkeys(("SP", "SU", "M"), _unnamed),
}
