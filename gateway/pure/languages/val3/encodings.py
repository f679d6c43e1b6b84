"""The text of an XML file of a controller, whatever editor has had it: UTF-8 or UTF-16 with or without a mark, or what it declares."""

import re
from dataclasses import dataclass

MARKS = (
    (b"\xef\xbb\xbf", "utf-8"),
    (b"\xff\xfe\0\0", "utf-32-le"),  # before the mark of UTF-16, with which it begins
    (b"\0\0\xfe\xff", "utf-32-be"),
    (b"\xff\xfe", "utf-16-le"),
    (b"\xfe\xff", "utf-16-be"),
)
BARE = ((b"<\0", "utf-16-le"), (b"\0<", "utf-16-be"))  # without a mark
DECLARED = re.compile(r"\s*<\?xml\b[^>]*?\bencoding\s*=\s*[\"']([^\"']*)[\"']")
DECLARATION = re.compile(r"\s*<\?xml\b[^>]*\?>")
HEAD = 200  # bytes in which the declaration is looked for


class Undecodable(Exception):
    """One sentence."""


@dataclass(frozen=True, slots=True)
class Decoded:
    """Without the declaration, its lines kept.  doubts: what was read in another way than the file declares."""

    text: str
    doubts: tuple[tuple[int, str], ...] = ()  # line, sentence


def decoded(data: bytes) -> Decoded:
    """Undecodable for an encoding that does not exist, and for bytes that are none of UTF-16 or UTF-32."""
    doubts: list[tuple[int, str]] = []
    name, begin = next(((name, len(mark)) for mark, name in MARKS if data.startswith(mark)), ("", 0))
    if not name:
        name = next((name for start, name in BARE if data.startswith(start)), "") or _declared(data)
    try:
        text = data[begin:].decode(name)
    except UnicodeDecodeError as error:
        if name not in ("utf-8", "utf8"):
            raise Undecodable(f"the text is not {name.upper()} from byte {begin + error.start} on") from None
        line = data.count(b"\n", 0, begin + error.start) + 1
        doubts.append((line, f"byte {data[begin + error.start]:02X}h is not UTF-8; the file was read as Windows-1252"))
        text = data[begin:].decode("cp1252", "replace")
    whole = text.rstrip("\0")
    if len(whole) < len(text):
        doubts.append((whole.count("\n") + 1, f"{len(text) - len(whole)} zero bytes after the text were left out"))
    if head := DECLARATION.match(whole):
        whole = "\n" * head.group().count("\n") + whole[head.end() :]
    return Decoded(whole, tuple(doubts))


def _declared(data: bytes) -> str:
    """What the declaration names; UTF-8 without one, and where it names two or four bytes a letter, which these are not."""
    match = DECLARED.match(data[:HEAD].decode("ascii", "replace"))
    name = match.group(1).lower() if match is not None else "utf-8"
    if name.replace("_", "-").startswith(("utf-16", "utf16", "utf-32", "utf32", "utf-7", "utf7", "ascii", "us-ascii")):
        return "utf-8"
    try:
        b"<".decode(name)  # a codec that makes no text is a LookupError
    except (LookupError, ValueError):
        raise Undecodable(f"the encoding {name!r} is unknown; controllers write UTF-8") from None
    return name
