"""Files that went through other editors and file systems: UTF-16, Windows-1252, marks, line ends, zero bytes."""

import codecs
import contextlib
from collections.abc import Callable

import pytest

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.encodings import Undecodable, decoded
from gateway.pure.languages.val3.loader import Loader
from hil_tests.unit.languages.val3.apps import App, datum, value

PLAIN = App("enc", datum("s", "string", values=value(value="Größe")), {"start": '// grün\ns="äöü"+s'})
LINES = ["begin", "// grün", 's="äöü"+s', "end"]
READ = {  # written so: read as it is
    "without a mark": lambda text: text.encode(),
    "mark": lambda text: codecs.BOM_UTF8 + text.encode(),
    "CR LF": lambda text: text.replace("\n", "\r\n").encode(),
    "CR": lambda text: text.replace("\n", "\r").encode(),
    "ISO 8859-1 declared": lambda text: text.replace("utf-8", "iso-8859-1").encode("latin-1"),
    "Windows-1252 declared": lambda text: text.replace("utf-8", "windows-1252").encode("cp1252"),
    "UTF-16": lambda text: text.replace("utf-8", "utf-16").encode("utf-16"),
    "UTF-16 that declares UTF-8": lambda text: text.encode("utf-16"),
    "UTF-16 without a mark": lambda text: text.replace("utf-8", "utf-16").encode("utf-16-be"),
    "UTF-8 that declares UTF-16": lambda text: text.replace("utf-8", "utf-16").encode(),
    "UTF-32": lambda text: text.encode("utf-32"),
    "blank lines in front": lambda text: b"\r\n \n" + text.encode(),
}
DOUBTED = {
    "Windows-1252 that declares UTF-8": (
        lambda text: text.encode("cp1252"), ["byte F6h is not UTF-8; the file was read as Windows-1252",
                                             "byte FCh is not UTF-8; the file was read as Windows-1252"], [4, 4],
    ),
    "zero bytes of a card": (lambda text: text.encode() + b"\0" * 512, ["512 zero bytes after the text were left out"] * 3, [5, 3, 6]),
}  # fmt: skip
REFUSED = {
    "half": (lambda text: text.encode()[:-30], "enc/enc.pjx", "not well-formed XML: "),
    "nothing": (lambda text: b"", "enc/enc.pjx", "no element found"),
    "only zero bytes": (lambda text: b"\0" * 512, "enc/enc.pjx", "no element found"),
    "a control character": (lambda text: text.replace("grün", "gr\1n").encode(), "enc/start.pgx", "a control character, 01h, in column 6"),
    "unknown encoding": (lambda text: text.replace("utf-8", "klingon").encode(), "enc/enc.pjx", "the encoding 'klingon' is unknown"),
    "no encoding of text": (lambda text: text.replace("utf-8", "zip").encode(), "enc/enc.pjx", "the encoding 'zip' is unknown"),
    "half a letter of UTF-16": (lambda text: text.encode("utf-16") + b"\0", "enc/enc.pjx", "the text is not UTF-16-LE from byte "),
}
Way = Callable[[str], bytes]


def loaded(way: Way) -> tuple[Loader, list[tuple[str, int, str, str]]]:
    """The application so written; its faults."""
    files = {path: way(data.decode("utf-8-sig")) for path, data in PLAIN.files().items() if not path.endswith("stop.pgx")}
    files["enc/enc.pjx"] = way(PLAIN.files()["enc/enc.pjx"].decode("utf-8-sig").replace('<Program file="stop.pgx" />', ""))
    loader = Loader(Disk(files))
    found = loader.load("enc", "enc")
    assert found is not None
    return loader, [(each.position.file, each.position.line, each.text, each.severity.value) for each in found.faults]


def whole(loader: Loader) -> None:
    found = loader.load("enc", "enc")
    assert found is not None and found.app.programs["start"].lines == LINES
    assert found.app.data["s"].values[0].attributes["value"] == "Größe"


@pytest.mark.parametrize("way", READ.values(), ids=READ.keys())
def test_any_encoding_is_read(way: Way) -> None:
    loader, faults = loaded(way)
    assert faults == []
    whole(loader)


@pytest.mark.parametrize(("way", "texts", "lines"), DOUBTED.values(), ids=DOUBTED.keys())
def test_what_is_read_otherwise_than_it_says_is_a_warning(way: Way, texts: list[str], lines: list[int]) -> None:
    loader, faults = loaded(way)
    assert [each[2] for each in faults] == texts and [each[1] for each in faults] == lines
    assert {each[3] for each in faults} == {"warning"}
    whole(loader)


@pytest.mark.parametrize(("way", "file", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_what_cannot_be_read_is_named(way: Way, file: str, words: str) -> None:
    _, faults = loaded(way)
    assert any(each[0] == file and words in each[2] and each[3] == "error" for each in faults), faults


@pytest.mark.parametrize(
    "start", [b"", codecs.BOM_UTF16_LE, codecs.BOM_UTF32_BE, b"<\0", b'<?xml encoding="utf-7"?>', b'<?xml encoding="">']
)
def test_any_bytes_are_text_or_refused(start: bytes) -> None:
    for tail in (b"", b"\xff", b"\xd8\x00\xd8\x00", b"\x00\xd8", bytes(range(256))):
        with contextlib.suppress(Undecodable):
            decoded(start + tail)
