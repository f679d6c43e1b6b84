"""XML of application files as a tree whose elements know their lines.  No document type, no entities: a controller writes none."""

import xml.parsers.expat as expat
from dataclasses import dataclass, field

from gateway.pure.languages.val3.encodings import Undecodable, decoded

DEEPEST = 200
MISMATCH = 7  # code of expat: a tag closes another element
ENDS = (3, 5, MISMATCH)  # no element found, unclosed token


class XmlFault(Exception):
    """The text is not XML that the controller could have written."""

    def __init__(self, line: int, text: str, column: int = 1) -> None:
        super().__init__(text)
        self.line, self.text, self.column = line, text, column


@dataclass(slots=True)
class Element:
    """One element.  Prefixes are kept, so that xsi:type and type are two attributes."""

    tag: str
    attributes: dict[str, str]
    line: int
    column: int = 1
    children: list["Element"] = field(default_factory=list)
    text: str = ""
    text_line: int = 0  # line of the first character of `text`
    doubts: tuple[tuple[int, str], ...] = ()  # of the root: line and sentence of what was read in another way than the file declares

    def get(self, name: str, default: str = "") -> str:
        """An attribute."""
        return self.attributes.get(name, default)

    def all(self, tag: str) -> list["Element"]:
        """Children of that tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> "Element | None":
        """The first child of that tag."""
        return next(iter(self.all(tag)), None)


class _Builder:
    def __init__(self, parser: expat.XMLParserType) -> None:
        self.parser = parser
        self.open: list[Element] = []
        self.root: Element | None = None

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag.rpartition(":")[2], attributes, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)
        if self.open:
            self.open[-1].children.append(element)
        elif self.root is None:
            self.root = element
        if len(self.open) >= DEEPEST:
            raise XmlFault(element.line, f"more than {DEEPEST} nested elements", element.column)
        self.open.append(element)

    def end(self, _: str) -> None:
        self.open.pop()

    def text(self, data: str) -> None:
        if self.open:
            element = self.open[-1]
            if not element.text:
                element.text_line = self.parser.CurrentLineNumber
            element.text += data

    def refuse(self, *_: object) -> None:
        text = "a document type is declared; application files have none"
        raise XmlFault(self.parser.CurrentLineNumber, text, self.parser.CurrentColumnNumber + 1)


def parse_xml(data: bytes) -> Element:
    """The root element.  XmlFault with its line for anything else."""
    try:
        read = decoded(data)
    except Undecodable as error:
        raise XmlFault(1, str(error)) from None
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    parser.buffer_size = 1 << 16
    builder = _Builder(parser)
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.text
    parser.StartDoctypeDeclHandler = builder.refuse
    try:
        parser.Parse(read.text.encode("utf-8", "replace"), True)
    except expat.ExpatError as error:
        text = f"not well-formed XML: {_why(error, read.text)}{_left_open(error, builder)}"
        column = error.offset + 1 - (len("</") if error.code == MISMATCH else 0)  # the tag, not its name
        raise XmlFault(error.lineno, text, column) from None
    if builder.root is None:
        raise XmlFault(1, "the file is empty")
    builder.root.doubts = read.doubts
    return builder.root


def _left_open(error: expat.ExpatError, builder: _Builder) -> str:
    """The element whose end is missing; "" where that is not the fault."""
    if error.code not in ENDS or not builder.open:
        return ""
    last = builder.open[-1]
    return f", <{last.tag}> of line {last.line} is not closed"


def _why(error: expat.ExpatError, text: str) -> str:
    """The words of the parser; a control character, which XML does not have, by its code."""
    lines = text.splitlines()
    line = lines[error.lineno - 1].encode("utf-8", "replace") if 1 <= error.lineno <= len(lines) else b""
    letter = line[error.offset : error.offset + 1]
    if letter and letter[0] < 32:
        return f"a control character, {letter[0]:02X}h, in column {error.offset + 1}"
    return expat.ErrorString(error.code).removeprefix("not well-formed (").removesuffix(")")
