"""Slips of a reader of print inside one step: O for 0, l for 1, B for 8, a lost comma or colon, another sign instead of them.

Only invalid text is corrected: the name of a variable begins with the letter of its type (L764), so `8O` and `l80` are not names.
"""

import re

from gateway.pure.languages.robotstar.grammar import GRAMMAR
from gateway.pure.languages.robotstar.path import CARTESIAN
from gateway.pure.languages.robotstar.print_signs import (
    decimal_comma,
    descriptors,
    equate,
    hashes,
    operands,
    quantity,
    quotes,
    system_variables,
)
from gateway.pure.languages.robotstar.words import Words

ALIKE = str.maketrans({"0": "O", "Q": "O", "1": "I", "L": "I", "|": "I", "!": "I", "8": "B", "5": "S", "-": "_"})
DIGITS = str.maketrans({"O": "0", "o": "0", "Q": "0", "l": "1", "I": "1", "|": "1", "B": "8", "S": "5", "Z": "2"})
NAMED = ("LABEL", "BRANCH", "CALL", "PROGRAM")  # followed by a name or a text
ONE_NUMBER = (  # a second number can only be the digits after a decimal comma
    "WAIT", "PTP_SPEED", "PTP_ACCEL", "PATH_SPEED", "PATH_ACCEL", "PATH_TIME", "PATH_RADIUS", "PATH_DISTANCE",
)  # fmt: skip
_TEXT = re.compile(r'("[^"]*")')
_NUMBER = re.compile(r"(?<![\w#.])[+-]?(?=[\w.|]*\d)(?![IRVPTS_])[\dOoQl|IBSZ]+(?:\.[\dOoQlI|BSZ]+)?(?![\w.])")
_HEX = re.compile(r"(?<![\w#])(?=[\dO])[\dA-FOo]+H(?!\w)")
_BINARY = re.compile(r"[01]+B")
_NAME = re.compile(  # the text before it, and a name whose first letter, that of its type, was read as a digit
    r"(?:(?P<descriptor>[A-Za-z][\w-]*)\s*:?\s*|(?<=,)\s*|(?<=^)\s*|(?<=\[)\s*)(?<![\w.#])(?P<first>[1l|!5])(?=_?[A-Z]{2}|_[A-Z])(?P<rest>\w+)"
)
VARIABLES = ("OP_1", "OP_2", "VARIABLE", "SOURCE", "DESTINATION", "VECTOR")
_ALONE = re.compile(r"(?<=[:,])(\s*[+-]?)([OolB])(?=\s*(?:,|$))|^(\s*[+-]?)([Ool])(?=\s*,)")
_OF_LABEL = re.compile(r"(?:marke|label|name)\s*:$", re.IGNORECASE)
_EQUATE = re.compile(r"#([\w|!-]+|[<>]?=[Ool|]|=[<>])")
_SIGN = re.compile(r"(?<=[\"\w])(\s*)[;.](\s*)(?=#|[A-Za-z_]\w*\s*:)|(?<=\")\s*[.;](?=\s*[\w#\"])")
_COLON_LOST = re.compile(r"(?:(?<=^)|(?<=,))(\s*)([A-Za-z][\w-]*)\s+(?=[-+\d#\"])")
_COMMA_LOST = re.compile(r"(?<=[\w\"\]])\s+(?=[A-Za-z_][\w-]*\s*:)")
_COMMA_BEHIND_NUMBER = re.compile(r"(?<=[\s,:])([+-]?\d+(?:\.\d+)?)\s+(?=[A-Za-z_#\"])")
_DECIMAL = re.compile(r"^(\s*[+-]?\d+),(\d+)\s*$")
_OF_POSITION = re.compile(r"(\b(?:[XYZABC]|A\d+)\s*:\s*[+-]?\d{1,3})((?:\.\d{3})*),(\d+)(?=\s*(?:,|$)|\s+[A-Za-z]\w*\s*:)")


def command(word: str, words: Words) -> str:
    """The command that a word with misread letters is; "" for none, or for more than one."""
    wanted = word.upper().translate(ALIKE)
    found = {each for each in words.words if each.translate(ALIKE) == wanted}
    return found.pop() if len(found) == 1 else ""


def parameters(word: str, rest: str, words: Words) -> str:
    """What follows the command, put right."""
    meant = words.words.get(word.upper(), "")
    if not meant or meant in ("C", "DIR"):
        return rest
    rest = quotes(rest)
    if meant in NAMED:
        return descriptors(meant, rest, words) if '"' in rest else rest
    if meant in ONE_NUMBER and (number := quantity(rest, words)):
        return number
    parts = _TEXT.split(rest)
    parts[::2] = [_outside_texts(meant, part, words) for part in parts[::2]]
    text = _SIGN.sub(lambda found: "," + (found[2] or "") if found[2] is not None else ",", "".join(parts))
    text = _COMMA_LOST.sub(", ", text) if meant != "POSITION" or ":" in text else text
    return decimal_comma(meant, text)


def _outside_texts(meant: str, text: str, words: Words) -> str:
    text = system_variables(operands(hashes(meant, descriptors(meant, text, words), words)))
    text = _EQUATE.sub(lambda found: "#" + _equate(meant, found[1], words), text)
    text = _HEX.sub(lambda found: found[0].replace("O", "0").replace("o", "0"), text)
    text = _NUMBER.sub(lambda found: found[0] if _BINARY.fullmatch(found[0]) else found[0].translate(DIGITS), text)
    if meant != "TRAFO_6D":  # B may be the name of a program, or of a label
        text = _ALONE.sub(lambda found: found[0] if _OF_LABEL.search(text[: found.start()]) else found[0].translate(DIGITS), text)
    text = _NAME.sub(lambda found: _name(meant, found, words), text)
    if meant in ONE_NUMBER:
        text = _DECIMAL.sub(r"\1.\2", text)
    if meant == "POSITION":
        return _OF_POSITION.sub(lambda found: f"{found[1]}{found[2].replace('.', '')}.{found[3]}", text)
    text = _COLON_LOST.sub(lambda found: f"{found[1]}{found[2]}: " if _is_descriptor(found[2], words) else found[0], text)
    return _COMMA_BEHIND_NUMBER.sub(r"\1, ", text)


def _name(meant: str, found: re.Match[str], words: Words) -> str:
    """A variable 1ZAEHL is IZAEHL, 5_PROG is S_PROG; labels and names of programs begin as they like."""
    named = any(place.kind == "text" for place in GRAMMAR.get(meant, ()))
    of_variable = words.descriptor(found["descriptor"] or "") in VARIABLES
    if (named and not of_variable) or _HEX.fullmatch(found["first"] + found["rest"]):
        return found[0]
    return found[0][: -1 - len(found["rest"])] + ("S" if found["first"] == "5" else "I") + found["rest"]


def _is_descriptor(text: str, words: Words) -> bool:
    return bool(words.descriptor(text)) and text.upper() not in CARTESIAN


def _equate(meant: str, text: str, words: Words) -> str:
    """Behind #: the word, a relation or a level."""
    if text[-1] in "Ool|" and text[:-1] == "=":
        return text[:-1] + text[-1].translate(DIGITS)
    if text in ("=>", "=<"):
        return text[::-1]
    if text.upper() in words.equates:
        return text
    wanted = text.upper().translate(ALIKE)
    found = [each for each in words.equates if each.translate(ALIKE) == wanted]
    return found[0] if len(found) == 1 else equate(meant, text, words)
