"""Compiler instructions (rho 3 releases L788-794, 1145-1148, 2190, 5725-5746, 5950): what they set in the head of a program."""

import re

from gateway.pure.languages.baps2.tree import Head, Instruction
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.near import nearest
from gateway.pure.languages.base.source import Position

WAYS = {"LINEAR": "LINEAR", "PTP": "PTP", "CIRCULAR": "CIRCULAR", "ZIRKULAR": "CIRCULAR"}
ALIASES = {
    "STEUERUNG": "CONTROL",
    "KINEMATIC": "KINEMATICS",  # D-30
    "KINEMATIK": "KINEMATICS",
    "KINEMATIKEN": "KINEMATICS",
    "JC_NAME": "JC_NAMES",  # D-30
    "MK_NAMEN": "JC_NAMES",
    "WC_NAME": "WC_NAMES",
    "WK_NAMEN": "WC_NAMES",
    "PROCESS_TYPE": "PROCESS_KIND",  # D-30
    "PROZESS_ART": "PROCESS_KIND",
    "WARNUNG": "WARNING",
    "FEHLER": "ERROR",
}
MOST_KINEMATICS = 16
NAMES = ("JC_NAMES", "WC_NAMES")
KINEMATICS = ("KINEMATICS", *(alias for alias, word in ALIASES.items() if word == "KINEMATICS"))
_FORM = re.compile(r"(?:(?P<kinematic>[^\W\d]\w*)\s*\.\s*)?(?P<word>[^\W\d]\w*)\s*[:=]?\s*(?P<value>.*)", re.DOTALL)
_PAIR = re.compile(r"(\d+)\s*=\s*([^\W\d]\w*)")
_NAME = re.compile(r"[^\W\d]\w*")


def take(text: str, at: Position, head: Head, faults: Faults, *, begun: bool) -> Instruction | None:
    """Enter an instruction in the head; return one that acts among the statements (`begun`: after BEGIN)."""
    text, _, comment = (part.strip() for part in text.partition(";"))
    match = _FORM.fullmatch(text)
    if match is None:
        _none(text, at, head, faults)
        return None
    word = match["word"].upper()
    word, value, kinematic = ALIASES.get(word, word), _whole(word, match["value"].strip(), comment), (match["kinematic"] or "").upper()
    match word:
        case "CONTROL":
            head.control = value.replace(" ", "").upper()
            if head.control != "RHO3":
                faults.error("control", at, f"control {value or 'without a name'}", "only RHO3 runs here")
        case "KINEMATICS" if _NAME.fullmatch(value) is None:
            _kinematics(value, at, head, faults)
        case "KINEMATICS" | "INT":
            return _default(word, value, at, head, faults, begun=begun)
        case "JC_NAMES" | "WC_NAMES":
            _components(word, kinematic, value, at, head, faults)
        case "PROCESS_KIND":
            head.permanent = value.upper() in ("PERMANENT", "PERM")
            if not head.permanent:
                faults.error("process-kind", at, f"process kind {value or 'without a name'}", "only PERMANENT is allowed")
        case "FILE_ERROR":
            head.file_error = _once(word, value, at, head, faults, begun)
        case "SER_IO_STOP":
            head.serial_stop = _once(word, value, at, head, faults, begun)
        case "WARNING":
            faults.warnings = _on(word, value, at, faults)
        case "ERROR":
            if value.isdigit() and int(value):
                faults.most = int(value)
            else:
                faults.error("instruction-value", at, f"ERROR = {value}", "a number of errors from 1 is expected")
        case _:
            _other(text, word, kinematic, value, at, head, faults)
    return None


def _whole(word: str, value: str, comment: str) -> str:
    """The value, with the comment where it is the rest of a list: a kinematic with its number, or names of the same form (A1; A2)."""
    known, more = ({_shape(part.strip()) for part in re.split("[,;]", each)} for each in (value, comment))
    goes_on = more <= known if ALIASES.get(word, word) in NAMES else word in KINEMATICS and _PAIR.match(comment) is not None
    return f"{value}; {comment}" if goes_on else value


def _shape(name: str) -> str:
    """The form of a name: which of its characters are letters, digits and others."""
    return "".join("9" if sign.isdigit() else "a" if sign.isalpha() else sign for sign in name)


def _other(text: str, word: str, kinematic: str, value: str, at: Position, head: Head, faults: Faults) -> None:
    """No instruction; one that is like JC_NAMES or WC_NAMES is read as it was meant."""
    meant = nearest(word, NAMES)
    _none(text, at, head, faults, meant)
    if meant:
        _components(meant, kinematic, value, at, head, faults)


def _none(text: str, at: Position, head: Head, faults: Faults, meant: str = "") -> None:
    """No instruction; one with numbers of kinematics counts as KINEMATICS.  meant: the one it is like."""
    faults.error("instruction-unknown", at, f"';;{text}' is not a compiler instruction", f"did you mean {meant}?" if meant else "")
    if _PAIR.search(text):
        head.faulty.add("KINEMATICS")


def _kinematics(value: str, at: Position, head: Head, faults: Faults) -> None:
    pairs = _PAIR.findall(value)
    rest = _PAIR.sub("", value).translate(str.maketrans("", "", "(), \t"))
    if rest or not pairs:
        faults.error("kinematics", at, f"kinematics {value}", "the form is ;;KINEMATICS : ( 1 = NAME , 2 = NAME2 )")
        head.faulty.add("KINEMATICS")
    for number, name in pairs:
        if not 1 <= int(number) <= MOST_KINEMATICS:
            faults.error("kinematics", at, f"kinematic number {number}", f"1..{MOST_KINEMATICS} are allowed")
        elif int(number) in head.kinematics.values() or name.upper() in head.kinematics:
            faults.error("declared-twice", at, f"kinematic {number} = {name} is declared twice")
        else:
            head.kinematics[name.upper()] = int(number)


def _unknown(name: str, at: Position, head: Head, faults: Faults) -> None:
    """A kinematic without its number: reported once, and not at all where the instruction that numbers them is faulty."""
    if "KINEMATICS" not in head.faulty:
        faults.error("kinematic-unknown", at, f"kinematic {name} is not declared")
    free = (number for number in range(1, MOST_KINEMATICS + 1) if number not in head.kinematics.values())
    head.kinematics[name.upper()] = next(free, MOST_KINEMATICS)


def _default(word: str, value: str, at: Position, head: Head, faults: Faults, *, begun: bool) -> Instruction | None:
    """Default kinematic or interpolation, from here on."""
    name = value.upper()
    if word == "INT" and name not in WAYS:
        faults.error("instruction-value", at, f"INT = {value}", "LINEAR, PTP or CIRCULAR is expected")
        return None
    if word == "KINEMATICS" and name not in head.kinematics:
        _unknown(value, at, head, faults)
        return None
    name = WAYS.get(name, name) if word == "INT" else name
    if begun:
        return Instruction(at, word, name)
    if word == "INT":
        head.default_way = name
    else:
        head.default_kinematic = name
    return None


def _components(word: str, kinematic: str, value: str, at: Position, head: Head, faults: Faults) -> None:
    names = tuple(part.strip().upper() for part in value.split(","))
    if kinematic and kinematic not in head.kinematics:
        _unknown(kinematic, at, head, faults)
    if any(_NAME.fullmatch(name) is None for name in names):
        faults.error("instruction-value", at, f"{word} = {value}", "names separated by commas are expected")
        head.faulty.add(f"{kinematic}.{word}")
    for name in {name for name in names if names.count(name) > 1}:
        faults.error("declared-twice", at, f"component {name} is named twice")
    (head.joint_names if word == "JC_NAMES" else head.world_names)[kinematic] = names


def _once(word: str, value: str, at: Position, head: Head, faults: Faults, begun: bool) -> bool:
    """Enter an instruction for the entire program: before BEGIN, and once (L2198, L5738-5739)."""
    if begun or head.over:
        faults.error("instruction-place", at, f"{word} belongs at the beginning of the program, in front of BEGIN")
    elif word in head.said:
        faults.error("instruction-twice", at, f"{word} may occur once")
    head.said.add(word)
    return _on(word, value, at, faults)


def _on(word: str, value: str, at: Position, faults: Faults) -> bool:
    """`+`, `-` or nothing (which means +)."""
    if value not in ("", "+", "-"):
        faults.error("instruction-value", at, f"{word} {value}", "+ or - is expected")
    return value != "-"
