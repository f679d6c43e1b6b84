"""Reads the broker's log (lines of candump -L with bus stamps; AX-095).  A witness: it shares no code with the broker."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

LINE = re.compile(
    r"\((?P<s>\d+)\.(?P<us>\d{6})\) (?P<bus>\S+) (?P<id>[0-9A-F]{3}|[0-9A-F]{8})#(?P<data>(?:[0-9A-F]{2}){0,8}|R[1-8]?)"
    r"(?: (?P<sender>\d+) (?P<sequence>\d+) (?P<ns>\d{3}))?"
)
REMARK = re.compile(r"# \((?P<s>\d+)\.(?P<us>\d{6})\) (?P<text>.*)")
LOST = re.compile(r"lost (\d+) frames")
CLIENT = re.compile(r"client (\d+) connected, pid (\d+)")


@dataclass(frozen=True, slots=True)
class Logged:
    """A frame on the bus; sender and sequence are 0 in a log that candump itself wrote."""

    stamp_ns: int
    identifier: int
    data: bytes
    remote: bool = False
    sender: int = 0
    sequence: int = 0


@dataclass(frozen=True, slots=True)
class Remark:
    """What the broker recorded besides frames: who came and went, who was too slow, what the log lost."""

    stamp_ns: int
    text: str

    @property
    def lost(self) -> int:
        """Frames missing from the log at this place."""
        match = LOST.match(self.text)
        return int(match[1]) if match else 0


def read(lines: Iterable[str]) -> Iterator[Logged | Remark]:
    """Frames and remarks in order; ValueError on any other line.  A last line cut short (a killed broker) is left out."""
    for number, line in enumerate(lines, 1):
        if not line.endswith("\n"):
            return
        yield from _entry(number, line.rstrip("\n"))


def _entry(number: int, line: str) -> Iterator[Logged | Remark]:
    if line.startswith("#"):
        if match := REMARK.fullmatch(line):
            yield Remark(_stamp(match["s"], match["us"]), match["text"])
        return
    match = LINE.fullmatch(line)
    if not match:
        raise ValueError(f"line {number}: not a line of the bus log: {line!r}")
    remote = match["data"].startswith("R")
    data = b"" if remote else bytes.fromhex(match["data"])
    stamp = _stamp(match["s"], match["us"]) + int(match["ns"] or 0)
    yield Logged(stamp, int(match["id"], 16), data, remote, int(match["sender"] or 0), int(match["sequence"] or 0))


def _stamp(seconds: str, microseconds: str) -> int:
    return int(seconds) * 1_000_000_000 + int(microseconds) * 1000


def frames(lines: Iterable[str]) -> list[Logged]:
    """The frames alone."""
    return [entry for entry in read(lines) if isinstance(entry, Logged)]


def remarks(lines: Iterable[str]) -> list[Remark]:
    """The remarks alone."""
    return [entry for entry in read(lines) if isinstance(entry, Remark)]


def senders(entries: Iterable[Remark]) -> dict[int, int]:
    """Sender number -> pid; the last one to have a number wins."""
    return {int(match[1]): int(match[2]) for entry in entries if (match := CLIENT.match(entry.text))}
