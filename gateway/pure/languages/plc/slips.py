"""The intended form of a faulty step: misread or mistyped digits and words (U EO.0, U E0,0, UE0.0), words of STEP 5; AX-1831.

A reading counts only if the control accepts it as a step; names of labels and programs are unchanged.
"""

import re

from gateway.pure.languages.plc.steps import Wrong, step_of

DIGITS = str.maketrans({"O": "0", "Q": "0", "I": "1", "L": "1", "|": "1", "!": "1", "S": "5", "B": "8", "Z": "2"})
WORDS = frozenset("U UN O ON XO XON S R = L LD T TD ST ZV ZR SH RO MU DI K TA HD DH U( O( XO( ) END".split())
DIGIT = r"[\dOQIL|!SBZ]"
NUMBER = re.compile(rf"(?<![A-Z\d.])([EIAOMTZ]?)\s*((?:\d|[OQIL|!]){DIGIT}*(?:\s*\.\s*{DIGIT})?)(?=\s*(?:,|$))")
COMMA = re.compile(rf"(?<=\d)\s*,\s*({DIGIT})$")
HEXADECIMAL = re.compile(r"[\dA-FOQIL]+H$")
OUTPUT, INPUT = re.compile(r"(?<![A-Z])Q(?=B?\s*\d)"), re.compile(r"(?<![A-Z])I(?=B\s*\d)")
JOINED = re.compile(r"(XON|XO|UN|ON|LD|TD|[UOSRLT])([EIAOMTZ]\s*\d.*)$")
SPLIT = re.compile(r"(\S+?\(?)(?=\s|$|(?<=\())\s*(.*)$")
STEP5 = {  # {0}: the operand
    "SPA": "SP {0}", "SPB": "SP {0},1", "SPBN": "SP {0},0", "BE": "END", "A": "U {0}", "AN": "UN {0}", "X": "XO {0}", "XN": "XON {0}",
    "SI": "ST I,{0}", "SV": "ST V,{0}", "SE": "ST E,{0}", "SA": "ST A,{0}", "!=F": "=?", "==I": "=?", "==": "=?", "<>": "><",
    "><F": "><", ">F": ">", "<F": "<",
    ">=F": ">=", "<=F": "<=", "+F": "+", "-F": "-", "XF": "MU", ":F": "DI", "TAK": "TA", "KEW": "K E", "KZW": "K Z", "SLW": "SH L,{0}",
    "SRW": "SH R,{0}", "UW": "U ACCU", "OW": "O ACCU", "XOW": "XO ACCU", "I": "ZV ACCU,{0}", "D": "ZR ACCU,{0}",
}  # fmt: skip
TIME5 = re.compile(r"L\s+KT\s*(\d{1,3})\s*\.\s*([0-3])$")
LOADED5 = re.compile(r"(L|T)\s+([EAM])B\s*(\d+)$|L\s+K[FZB]\s*\+?(\d+)$")


def meant(text: str) -> str:
    """The step that a faulty one was meant to be, without its comment; "" where none fits."""
    body = _body(text)
    if joined := JOINED.match(body):
        body = f"{joined[1]} {joined[2]}"
    split = SPLIT.match(body)
    if not split or split[1] in ("SP", "SU", "M"):
        return ""
    found = [word for word in sorted(WORDS) if word.translate(DIGITS) == split[1].translate(DIGITS)]
    words = [split[1]] if split[1] in WORDS else found
    read = NUMBER.sub(_number, split[2])
    rests = dict.fromkeys((split[2], _hexadecimal(split[2]), read, COMMA.sub(r".\1", read)))
    readings = dict.fromkeys(f"{word} {rest}".strip() for word in words for rest in rests)
    taken = [each for each in readings if each == "END" or not isinstance(step_of(each, 1) or Wrong(""), Wrong)]
    return taken[0] if len({"".join(each.split()) for each in taken}) == 1 else ""


def of_step5(text: str) -> str:
    """The step that replaces one of STEP 5; "" where there is none."""
    body = _body(text)
    if time := TIME5.match(body):
        return f"L {int(time[1]) * 10 ** int(time[2])}"
    if loaded := LOADED5.match(body):
        return f"{loaded[1]} {loaded[2]}{loaded[3]}" if loaded[1] else f"L {loaded[4]}"
    word, _, operand = body.partition(" ")
    operand = "".join(operand.lstrip("=").split())
    step = STEP5.get(word, "").format(operand)
    if word in ("SPA", "SPB", "SPBN") and re.match(r"(PB|FB|SB|FC|FX)\d", operand):
        step = f"SU{step[2:]}"
    return step if step == "END" or (step and not isinstance(step_of(step, 1), Wrong)) else ""


def _body(text: str) -> str:
    """The step without its comment, the colon of a printed statement list and the letters of English bytes and outputs."""
    body = " ".join(text.split(";", maxsplit=1)[0].upper().split())
    return INPUT.sub("E", OUTPUT.sub("A", body.removeprefix(":").lstrip()))


def _number(found: re.Match[str]) -> str:
    return found[1] + "".join(found[2].translate(DIGITS).split())


def _hexadecimal(text: str) -> str:
    return text.translate(str.maketrans("OQIL", "0011")) if HEXADECIMAL.match(text) else text
