"""`axisgate line learn TRACE`: a recorded line (record of the line process, or journal) becomes the draft of a cell."""

import pathlib
from collections.abc import Iterator

from drivers.ports.serial.line_format import LineFormat, parse_record
from gateway.pure.lines.decoder import LineDecoder, LineReport
from gateway.pure.lines.learning import Learned, draft, learn
from protocols.base.dialogue import parse as parse_journal
from protocols.base.errors import DecodeError
from protocols.base.machine import Damage, Ns, ms

Characters = Iterator[tuple[Ns, str, int | Damage]]
ARRIVED = ("", "parity", "framing", "overrun", "break")


class NoTrace(ValueError):
    """The file is neither a line record nor a journal; the text names what was found."""


def text_of(path: pathlib.Path) -> str:
    """The file as text.  NoTrace: a device, which would be read for ever; OSError."""
    if path.exists() and not path.is_file():
        raise NoTrace(f"{path}: a file expected; --tap A,B listens live; axisgate line monitor --save FILE writes such a file")
    return path.read_text(encoding="utf-8", errors="replace")


def characters(text: str) -> Characters:
    """Characters on the line, in order of the stamps."""
    if text.lstrip().startswith(("dialogue", "station")) or "\ndialogue " in text:
        yield from _of_journal(text)
        return
    record = parse_record(text.splitlines(keepends=True))
    for run in sorted(record.runs, key=lambda run: run.stamp_ns):
        if run.mark in ("parity", "framing", "overrun", "break"):
            yield run.stamp_ns, run.side, Damage[run.mark.upper()]
        elif run.mark == "" or run.mark.startswith("flip="):
            data = run.data if not run.mark else bytes.fromhex(run.mark.removeprefix("flip="))
            yield from ((run.stamp_ns, run.side, byte) for byte in data)


def _of_journal(text: str) -> Characters:
    """The station of a journal is side B, its partner A."""
    start = 0
    for dialogue in parse_journal(text):
        station = dialogue.station.get("side", "B")
        partner = "A" if station == "B" else "B"
        last = start
        for entry in dialogue.entries:
            last = start + entry.time
            if entry.verb in ("hears", "says"):
                yield from ((last, partner if entry.verb == "hears" else station, byte) for byte in entry.data)
            elif entry.verb == "damaged":
                yield last, partner, Damage[entry.what]
        start = last + ms(1000)


def decoded(text: str) -> list[LineReport]:
    """The sentences of a trace; NoTrace when it is none."""
    decoder, found, last = LineDecoder(), list[LineReport](), 0
    try:
        for stamp, side, what in characters(text):
            last = stamp
            found += decoder.take(stamp, side, what)
    except DecodeError as error:
        raise NoTrace(f"neither a line record nor a journal: {error}") from error
    return found + decoder.flush(last + ms(1000))


def line_format(text: str) -> tuple[int, str]:
    """Baud and frame as the record's first note has them; the usual ones where it has none."""
    baud, bits = 9600, 11
    for word in text[:400].split():
        key, _, value = word.partition("=")
        if key == "baud" and value.isdecimal() and int(value):
            baud = int(value)
        elif key == "bits" and value.isdecimal():
            bits = int(value)
    return baud, "8N1" if bits == 10 else "8E1"


def of_line(tolds: list[LineReport], source: str, line_format: LineFormat) -> tuple[Learned, str]:
    """The same from the characters of a monitor.  NoTrace if there was no block."""
    seen = learn(tolds)
    if not seen.blocks:
        if seen.tests:
            raise NoTrace(f"only the {seen.tests} test blocks of axisgate's own tools were received at {source}")
        raise NoTrace(
            f"no 3964R block was received at {source} ({len(tolds)} characters and signs); axisgate line diagnose finds the cause"
        )
    frame = f"{line_format.data_bits}{line_format.parity}{line_format.stop_bits}"
    return seen, draft(seen, source, line_format.baud, frame)


def learned(path: pathlib.Path) -> tuple[Learned, str]:
    """The observations and the draft.  OSError, NoTrace."""
    text = text_of(path)
    seen = learn(decoded(text))
    if not seen.blocks:
        if seen.tests:
            raise NoTrace(f"only the {seen.tests} test blocks of axisgate's own tools are in it")
        raise NoTrace(f"no block of 3964R in it ({len(text)} characters); a record has lines such as: 123456789 A 02")
    return seen, draft(seen, path.name, *line_format(text))
