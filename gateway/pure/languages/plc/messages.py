"""Messages of the PLC: texts of PLCMSG_CNF, standard messages, errors of the run.  Source: robotstar 5.4, 5.5, L2749-2861; AX-744."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.plc.reader import body_of, lines_of

TEXT_PROGRAM = "PLCMSG_CNF"
LONGEST, PARAMETERS = 256, 4
NOTE, STOPS, DRIVES_OFF = 0, 3, 7  # reaction, bits 0 to 3
ONLY_WITH_DRIVES = 0x100
TIME, MEMORY, FUNCTION_CODE, IDENTIFICATION, OVERLOAD = 7000, 7001, 7003, 7004, 1052
TEXT_LINE = re.compile(r"I\s+(\d{1,10})\s*[,\s]\s*(\d{1,3}|[0-9A-F]{1,3}H)\s*[,\s]\s*\"(.*)\"\s*(?:;.*)?$", re.IGNORECASE)
PARAMETER = re.compile(r"\\[ndhb]")


@dataclass(frozen=True, slots=True)
class Message:
    """What the operator reads.  `reaction` 0: green, 3: red and the robot stops, 7: red and the drives go off."""

    text: str
    number: int | None = None
    reaction: int = STOPS
    program: str = ""
    step: int = 0

    @property
    def kind(self) -> str:
        """`message` is green, `error` is red."""
        return "error" if self.reaction else "message"


@dataclass(frozen=True, slots=True)
class Text:
    """One line of the text program."""

    number: int
    reaction: int
    with_drives_only: bool
    text: str

    def filled(self, parameters: Sequence[int]) -> str:
        """The text with its parameters, in their order."""
        values = iter(parameters)

        def put(found: re.Match[str]) -> str:
            if found[0] == "\\n":
                return "\n"
            value = next(values)
            return str(value) if found[0] == "\\d" else format(value & 0xFFFFFFFF, "X" if found[0] == "\\h" else "b")

        return PARAMETER.sub(put, self.text)


def read_texts(text: str, faults: Faults, name: str = TEXT_PROGRAM) -> Mapping[int, Text]:
    """The lines of the text program by their number; faults name the line."""
    found: dict[int, Text] = {}
    for line in body_of(lines_of(text), name, faults)[0]:
        if not line.valid or line.text.startswith(";"):
            continue
        where = Position(name, line.line)
        read = _read_line(line.text)
        if isinstance(read, str):
            faults.error("text", where, read, 'a text line reads I 5, 0, "text"')
        elif read.number in found:
            faults.error("two-texts", where, f"text {read.number} exists twice", "give each text a number of its own")
        else:
            found[read.number] = read
    return found


def _read_line(line: str) -> Text | str:
    """Return the text, or the fault."""
    match = TEXT_LINE.match(line)
    if match is None:
        return f"{line[:60]!r} is not a text line"
    number, word, text = int(match[1]), match[2].upper(), match[3]
    reaction = int(word[:-1], 16) if word.endswith("H") else int(word)
    if number > 0x7FFFFFFF:
        return f"text number {number}: outside 0..2147483647"
    if reaction & ~ONLY_WITH_DRIVES not in (NOTE, STOPS, DRIVES_OFF):
        return f"reaction {word}: 0, 3 or 7, with 256 (bit 8) added for 'only with drives on'"
    if len(text) > LONGEST:
        return f"{len(text)} characters of text, at most {LONGEST}"
    if sum(found != "\\n" for found in PARAMETER.findall(text)) > PARAMETERS:
        return f"more than {PARAMETERS} parameters in the text"
    return Text(number, reaction & 15, bool(reaction & ONLY_WITH_DRIVES), text)


def ordered(word: int, texts: Mapping[int, Text], parameters: Sequence[int], drives: bool) -> Message | None:
    """The message that the double word of the program asks for; None: its text is shown with drives on alone."""
    number = word & 0x7FFFFFFF
    if not word & 0x80000000:
        return Message(f"PLC error {number}", number)
    text = texts.get(number)
    if text is None:
        return Message(f"Text {number} is not in {TEXT_PROGRAM}", number)
    if text.with_drives_only and not drives:
        return None
    return Message(text.filled(parameters), number, text.reaction)


def runtime_error(number: int, program: str = "", step: int = 0) -> Message:
    """PLC error 700x: the PLC stops, drives go off."""
    return Message(f"PLC error {number}", number, DRIVES_OFF, program, step)
