"""Slips of a reader of print in a statement list: O for 0, l or I for 1, B for 8, `;` for the colon; AX-1830.

Only text that is not a valid statement is corrected; the caller names each change.  All texts here are in capital letters.
"""

import re
from collections.abc import Collection

DIGITS = str.maketrans({"O": "0", "Q": "0", "I": "1", "L": "1", "|": "1", "!": "1", "S": "5", "B": "8", "Z": "2"})
WORDS = frozenset(
    "U UN O ON X XN A AN ( U( UN( O( ON( X( XN( A( AN( ) S R = L T LC FR SI SV SE SS SA SP SD SF ZV ZR CU CD SPA SPB SPBN SPZ SPN SPP SPM"
    " SPO JU JC JCN BA BAB BE BEA BEB BEU BEC NOP BLD SET CLR NOT SLW SRW SLD SRD RLD RRD UW OW XOW UD OD XOD KEW KZW TAK I D INC DEC ADD"
    " CALL UC CC AUF FP FN MOD STP STS LIR TIR TNB B E AX PN SU RU P".split()
)
PLAIN = frozenset("SLW SRW SLD SRD RLD RRD I D INC DEC".split())  # a number alone is their operand
JUMPS = frozenset("SPA SPB SPBN JU JC JCN BA BAB UC CC CALL".split())
COMPARES = re.compile(r"[><=!]{1,2}[FIDRG]|[+\-*/:X][FIDRG]\b|\+")
BEHIND = r"(?![\w.])"
DIGIT = r"[\dOQIL|!SBZ]"
BIT = re.compile(rf"([EAMDIQFL])(?:(\s+)({DIGIT}{{1,4}})|([\dOIL|!]{DIGIT}{{0,3}}))\s*([.,])\s*([\dOQIL|!S]){BEHIND}")
BYTES = "EB|AB|MB|EW|AW|MW|ED|AD|MD|IB|IW|ID|QB|QW|QD|FY|FW|FD|DW|DL|DR|DD|PY|PW|LB|OB|PB|FB|FX|SB|FC|DB|DX|T|Z|C"
BYTE = re.compile(rf"({BYTES}|0B|[EAMPFSD]8)\s*({DIGIT}{{1,4}}){BEHIND}")
DATA = re.compile(r"(?:DB\s*\d+\.)?D[BI][BWDX]\s*\d+(?!\w)")  # DBB 7 is no DB 8 7
BLOCK = re.compile(rf"([OPFS]B|FX|FC|0B|[PFS]8)\s+({DIGIT}{{1,3}}){BEHIND}")  # a label has no blank
TIME = re.compile(rf"KT\s*({DIGIT}{{1,3}})\s*([.,])\s*([0-3OQIL|!Z]){BEHIND}")
DECIMAL = re.compile(rf"(K[FZBC]\s*[+-]?\s*|C#|L#[+-]?)({DIGIT}{{1,5}}){BEHIND}")
PAIR = re.compile(rf"KY\s*({DIGIT}{{1,3}})\s*[,.]\s*({DIGIT}{{1,3}}){BEHIND}")
PATTERN = re.compile(r"(K[HM])((?:\s*[\dA-FOQIL|!S]){1,32})" + BEHIND)
TIME7 = re.compile(r"(S5T|S5TIME)#([\dOILHMS_]+)" + BEHIND)
HEADING = re.compile(rf"([O0P]B|[P]8|F[B8X]|[S5]B|[O0]8|FC)\s*({DIGIT}{{1,3}})(?=\s*$|\s+LAE|\s+LEN)", re.IGNORECASE)
ADDRESS = re.compile(r"\s*[\dA-FOIL]{4,6}\s+", re.IGNORECASE)
NO_COLON = re.compile(r"(?:([A-Z]\w{1,3})\s*[;.,|'!]\s*|[;.,|'!]?\s*)(?=[A-Z0-9=)(+><!\-:])(.*)$", re.IGNORECASE)


def digits(text: str) -> str:
    """A number whose digits were read as letters."""
    return text.upper().translate(DIGITS)


def word_of(token: str) -> str:
    """The word of a statement that a token is or was; "" for none or more than one."""
    if token in WORDS or COMPARES.fullmatch(token):
        return token
    wanted = digits(token)
    found = sorted(each for each in WORDS if digits(each) == wanted)
    return found[0] if len(found) == 1 else ""


def put_right(text: str) -> str:
    """A statement without label and colon; as it is where nothing is misread, or more than one reading fits."""
    split = re.match(r"(\S+?\(?)(?=\s|$|(?<=\())\s*(.*)$", text)
    if not split:
        return text
    word, rest = word_of(split[1]), split[2]
    if not word and split[1] != "1":
        joined = re.match(r"(UN|ON|[UOSRLT])([EAMTZ]\s*\d.*)$", text)  # the blank is lost: UE 0.0
        return f"{joined[1]} {joined[2]}" if joined else text
    if split[1] in ("1", "I"):  # an L, unless a number alone follows: I 3 counts
        word = "L" if re.match(r"K[A-Z]|[A-Z]{1,2}\s*\d|\"", rest) else split[1]
    meant = operand_of(word, rest)
    return text if (word, meant) == (split[1], rest) else f"{word} {meant}".rstrip()


def operand_of(word: str, text: str) -> str:
    """The operand of a statement; what follows it, a comment, stays."""
    if DATA.match(text):
        return text
    if word in PLAIN:
        found = re.match(rf"({DIGIT}{{1,3}}){BEHIND}", text)
        return digits(found[1]) + text[found.end() :] if found else text
    if word in JUMPS:
        found = BLOCK.match(text)
        misread = found is not None and not (found[2].isdigit() and found[1].isalpha())
        return _byte(found) + text[found.end() :] if found and misread else text
    if found := BIT.match(text):
        number = digits(found[3] or found[4])
        if found[5] == "." and (found[3] or found[4], found[6]) == (number, digits(found[6])):
            return text
        return f"{found[1]} {number}.{digits(found[6])}{text[found.end() :]}"
    for form, said in FORMS:
        if found := form.match(text):
            meant = said(found)
            same = "".join(meant.split()) == "".join(found[0].split())
            return text if same else meant + text[found.end() :]
    return text


def _byte(found: re.Match[str]) -> str:
    return f"{found[1].replace('8', 'B').replace('0', 'O')} {digits(found[2])}"


def _pattern(found: re.Match[str]) -> str:
    if found[1] == "KM":
        return f"{found[1]} {digits(found[2]).strip()}"
    return f"{found[1]} {found[2].translate(str.maketrans('OQIL|!S', '0011115')).strip()}"


FORMS = (
    (TIME, lambda found: f"KT {digits(found[1])}.{digits(found[3])}"),
    (PAIR, lambda found: f"KY {digits(found[1])},{digits(found[2])}"),
    (DECIMAL, lambda found: found[1] + digits(found[2])),
    (PATTERN, _pattern),
    (TIME7, lambda found: f"{found[1]}#{found[2].translate(str.maketrans('OIL', '011'))}"),
    (BYTE, _byte),
)


def heading_of(text: str) -> str:
    """The heading of a block with misread letters; as it is where it is none."""
    found = HEADING.match(text)
    if not found:
        return text
    kind, number = found[1].upper().translate(str.maketrans("085", "OBS")), digits(found[2])
    return text if (kind, number) == (found[1].upper(), found[2]) else f"{kind} {number}{text[found.end() :]}"


def without_colon(text: str) -> str:
    """The statement of a line of a listing with addresses that lacks its colon, or has another sign for it; "" for print."""
    address = ADDRESS.match(text)
    found = NO_COLON.match(text[address.end() :]) if address else None
    if not found or not (token := re.match(r"\S+", found[2].upper())) or not word_of(token[0]):
        return ""
    return f"{found[1] or ''}:{found[2]}"


def label_of(name: str, labels: Collection[str]) -> str:
    """The one of the labels of a block that a misread name is; "" for none or more than one."""
    found = [each for each in labels if digits(each) == digits(name)]
    return found[0] if len(found) == 1 else ""
