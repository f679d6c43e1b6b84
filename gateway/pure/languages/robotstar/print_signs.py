"""Signs and descriptors that a reader of print mistakes for others: Pege1 for Pegel, `;` for `:`, '' for ", a lost bracket or #.

All functions receive the text after the command of one step and return its intended form; a valid step is unchanged.
"""

import re

from gateway.pure.languages.base.near import all_nearest, looks
from gateway.pure.languages.robotstar.grammar import GRAMMAR
from gateway.pure.languages.robotstar.operands import RELATIONS
from gateway.pure.languages.robotstar.system import NAMES
from gateway.pure.languages.robotstar.words import Words

WITH_VALUES = ("POSITION", "VAR", "LOC_VAR", "CONST", "LOC_CONST")  # commands with X:, Y:, .. A7:
_MARKS = re.compile(r"''|[\u00b4`]|,,(?=\s*[\w.-]+\s*\")")
_UNCLOSED = re.compile(r"\"([\w.$/-]+)\s*$")
_UNOPENED = re.compile(r"(?<=:)(\s*)([\w.$/-]+)\"\s*$")
_DESCRIPTOR = re.compile(
    r"(?:(?<=^)|(?<=[,\s]))(?=\w*[A-Za-z])(\w[\w-]*(?: \w[\w-]*)?)\s*(?:[:;=](?=\s*(?:[-+\w\"#]|$))|\.(?=\s*(?:[-+\d\"#]|$)))"
)
_BEFORE_TEXT = re.compile(r"(^\s*[A-Za-z][\w-]*)\s+(?=\")")
_COMPONENT = re.compile(r"(?<=,)(\s*)([82])(\s*:)")
_COMPONENTS = {"8": "B", "2": "Z"}
_TWO_HASHES = re.compile(r"(?:(?<=^)|(?<=[,\s]))[H#]#(?=\w)")
_HASH_AND_BLANK = re.compile(r"#\s+(?=[\w<>=()])|\*(?=[A-Z])")
_RELATION = re.compile(r"#([<>=()]) ?([=>)]?)(?=\s*,)")
_LOST_HASH = re.compile(r"(?:(?<=^)|(?<=,))(\s*)([<>]=?|<>|=|[A-Za-z][\w-]+)(?=\s*(?:,|$))")
_SYSTEM = re.compile(r"(?<![\w.#])_[^\W_]\w*")
_OPEN_LOST = re.compile(r"(?<![\w.\[])(_?[IRVPTS]\w*?)[l1|](\d+)\]")
_ROUND = re.compile(r"(?<![\w.])(_[A-Z]\w*)\((\w+)\)")
_CLOSE_LOST = re.compile(r"(\w\[\w+)(?=\s*(?:,|$))")
_DASH = re.compile(r"(?<=[,:])(\s*)(?:-|_ )(?=[A-Z]\w*\[)")
_LOST_LINE = re.compile(r"(?:(?<=[,:])|(?<=^))(\s*[IRVPTS]) (?=[A-Z]\w+\s*(?:,|\[|$))")  # V ZP_EP3
_SIGNED = re.compile(r"(?:(?<=[,:])|(?<=^))(\s*[-+]) +(?=\d)")
_POINT = re.compile(r"(?:(?<=^)|(?<=[,:\s]))(\d+)\.(?=_?[IRVPTS]_?\w*[A-Z])")
_COMMA = re.compile(r',(?=(?:[^"]*"[^"]*")*[^"]*$)')  # outside texts
_WHOLE = re.compile(r"(?:^|[\s:])[+-]?\d+$")
_QUANTITY = (
    r"^\s*(?:([\[(]?)\s*({unit})\s*[\])]?)?\s*:?\s*(?:(\w+)\s*:)?\s*([+-]?[\dOoQl|]+(?:[.,][\dOoQl|]+)?)\s*[\[(]?({unit})?[\])]?\s*$"
)
NUMBERS = str.maketrans("OoQl|", "00011")


def quotes(text: str) -> str:
    """Correct quotation marks: of other kinds, and one that is lost next to a name."""
    text = _MARKS.sub('"', text)
    if text.count('"') % 2:
        text = _UNCLOSED.sub(r'"\1"', text) if _UNCLOSED.search(text) else _UNOPENED.sub(r'\1"\2"', text)
    return text


def descriptors(command: str, text: str, words: Words) -> str:
    """Correct descriptors before a colon: misread letters, two words, another sign for the colon."""
    if command in WITH_VALUES:
        text = _COMPONENT.sub(lambda found: found[1] + _COMPONENTS[found[2]] + found[3], text)
    text = _BEFORE_TEXT.sub(lambda found: f"{found[1]}:" if _meant(command, found[1].strip(), words) else found[0], text)
    return _DESCRIPTOR.sub(lambda found: _descriptor(command, found, words), text)


def _descriptor(command: str, found: re.Match[str], words: Words) -> str:
    """Return one descriptor and its colon: the two words before it, or the last of them."""
    before, _, last = found[1].rpartition(" ")
    if name := _meant(command, found[1].replace(" ", "_"), words):
        return f"{name}:"
    name = _meant(command, last, words) if before else ""
    return f"{before} {name}:" if name else found[0]


def _meant(command: str, spelt: str, words: Words) -> str:
    """The descriptor that a word is or looks like; "": none."""
    if words.descriptor(spelt):
        element = spelt.upper() not in words.descriptors and "-" not in spelt  # X, A7
        return spelt if not element or command in WITH_VALUES else ""
    alike = [each for each in words.descriptors if len(each) > 2 and looks(each) == looks(spelt.replace("-", "_"))]
    return alike[0].title() if len({words.descriptors[each] for each in alike}) == 1 else ""


def hashes(command: str, text: str, words: Words) -> str:
    """Correct # before system equates: a blank after it, * or H for it, printed twice, brackets for < and >, none at all."""
    wanted = {name for place in GRAMMAR.get(command, ()) for name in place.equates}
    text = _HASH_AND_BLANK.sub("#", _TWO_HASHES.sub("#", text)) if wanted else text
    text = _RELATION.sub(lambda found: "#" + (found[1] + found[2]).translate(str.maketrans("()", "<>")), text)
    if "#" in text and command not in ("TEST", "TEST_BIT", "PALLET"):
        return text
    return _LOST_HASH.sub(lambda found: _with_hash(found, wanted, words), text)


def _with_hash(found: re.Match[str], wanted: set[str], words: Words) -> str:
    """An equate without its #, or with H for it; the text as it is where it is none."""
    for each in (found[2], found[2].removeprefix("H")):
        if _is_equate(each, wanted, words):
            return f"{found[1]}#{each}"
    return found[0]


def equate(command: str, text: str, words: Words) -> str:
    """The equate of this command that a misread one is: one wrong letter of a short word (#OEF); as it is where none or several fit."""
    wanted = [each for each, name in words.equates.items() if any(name in place.equates for place in GRAMMAR.get(command, ()))]
    short = [each for each in wanted if len(each) == len(text) and sum(map(str.__ne__, each, text.upper())) == 1]
    found = all_nearest(text, wanted) or short
    return found[0] if len({words.equates[each] for each in found}) == 1 else text


def _is_equate(text: str, wanted: set[str], words: Words) -> bool:
    return (text if text in RELATIONS else words.equates.get(text.upper(), "")) in wanted


def operands(text: str) -> str:
    """Correct brackets of an index, - or a blank for _, a blank after a sign, a point for the comma after an integer."""
    text = _OPEN_LOST.sub(r"\1[\2]", text)
    text = _ROUND.sub(r"\1[\2]", text)
    text = _CLOSE_LOST.sub(r"\1]", text)
    text = _DASH.sub(r"\1_", text)
    text = _LOST_LINE.sub(r"\1_", text)
    text = _SIGNED.sub(r"\1", text)
    return _POINT.sub(r"\1,", text)


def quantity(text: str, words: Words) -> str:
    """Return the number of a command that requires one, without a unit that is printed separately; "": there is none."""
    unit = "|".join(re.escape(each) for each in sorted(words.units, key=len, reverse=True))
    found = re.match(_QUANTITY.format(unit=unit), text)
    if not found or not (found[2] or found[5]) or (found[1] == "[" and "," not in found[4] and not found[5]):
        return ""
    return " " + (f"{found[3]}:" if found[3] else "") + found[4].translate(NUMBERS).replace(",", ".")


def system_variables(text: str) -> str:
    """Correct the names of system variables with misread letters: _SP5, _VNU1L; a name that looks like none or two of them stays."""
    return _SYSTEM.sub(_system_variable, text)


def _system_variable(found: re.Match[str]) -> str:
    name = found[0].upper()
    alike = [each for each in NAMES if looks(each) == looks(name)] if name not in NAMES else []
    return alike[0] if len(alike) == 1 else found[0]


def decimal_comma(command: str, text: str) -> str:
    """Correct a decimal comma where the step has one parameter too many and one pair of numbers has no blank: Max_Zeit: 3,5, Marke: A."""
    parts, places = _COMMA.split(text), len(GRAMMAR.get(command, ()))
    if places < 2 or len(parts) != places + 1:
        return text
    pairs = [at for at in range(places) if _WHOLE.search(parts[at]) and re.fullmatch(r"\d+\s*", parts[at + 1])]
    if len(pairs) != 1:
        return text
    return ",".join([*parts[: pairs[0]], f"{parts[pairs[0]]}.{parts[pairs[0] + 1]}", *parts[pairs[0] + 2 :]])
