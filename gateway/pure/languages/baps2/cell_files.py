"""What the pendant sees of the user memory: the list of its files, the lines of VTLnnn.DAT, KEY.BNR at the start (AX-1041).  Pure."""

import re
from collections import deque
from collections.abc import Mapping

from gateway.pure.image.records.interpreter import Fact
from gateway.pure.languages.base.hosting import Port

EVERY_NS = 200_000_000
PIECES = 8  # a turn
PIECE = 400  # characters
MOST_LINES = 999
NO_CARD = (0, 0)
KEYS = ("KEY.BNR", "TASTEN.BNR")
_LIST = re.compile(r"VTL(\d{3})\.DAT")


class CellFiles:
    """`turn` reports changes, a few pieces at a time."""

    def __init__(self, port: Port) -> None:
        self.stamps: dict[str, tuple[str, str]] = {}  # file -> day and time of its last change, as 24.09.95 and 09:40
        self._port = port
        self._out: deque[dict[str, Fact]] = deque()
        self._listed: tuple[str, ...] = ()
        self._lists: dict[int, bytes] = {}
        self._due, self._keys = 0, True
        self.card = NO_CARD  # system error of the SRAM card, and its bytes
        self._card = NO_CARD

    def again(self) -> None:
        """Report everything again: the services have restarted."""
        self._out.clear()
        self._lists.clear()
        self._listed, self._keys, self._due, self._card = (), True, 0, (-1, 0)  # also that there is no card

    def turn(self, files: Mapping[str, bytes], now: int) -> None:
        """The memory as it is."""
        if now >= self._due:
            self._due = now + EVERY_NS
            self._look(files)
        for _ in range(min(PIECES, len(self._out))):
            self._port.send("memory", **self._out.popleft())

    def points(self, file: str, points: Mapping[str, tuple[float, ...]], point: str = "", *, size: int, select: bool) -> None:
        """A point file for modes 4.1 and 4.2; size: components of its points; select: for their next selection, by special function 16."""
        rows = tuple(" ".join((name, *(f"{value:.10g}" for value in values))) for name, values in points.items())
        self._pieces(rows, part="points", file=file, point=point, size=size, select=select)

    def _look(self, files: Mapping[str, bytes]) -> None:
        if self._keys:
            self._keys = False
            data = next((files[name] for name in KEYS if name in files), b"")
            self._out.append({"part": "keys", "text": data[:257].hex()})
        if self.card != self._card:
            self._card = self.card
            self._out.append({"part": "card", "text": "", "error": self.card[0], "size": self.card[1]})
        none = ("", "")
        rows = tuple("|".join((name, str(len(files[name])), *self.stamps.get(name, none))) for name in sorted(files))
        if rows != self._listed:
            self._listed = rows
            self._pieces(rows, part="files")
        found = {int(match[1]): data for name, data in files.items() if (match := _LIST.fullmatch(name)) and int(match[1]) < 256}
        for number in self._lists.keys() - found.keys():
            self._out.append({"part": "no list", "number": number, "text": ""})
        for number, data in found.items():
            if self._lists.get(number) is not data:
                self._pieces(lines_of_list(data), part="list", number=number)
        self._lists = found

    def _pieces(self, rows: "tuple[str, ...] | list[str]", **facts: Fact) -> None:
        first = 0
        while True:
            last, size = first, 0
            while last < len(rows) and (last == first or size + len(rows[last]) < PIECE):
                size += len(rows[last]) + 1
                last += 1
            self._out.append({**facts, "first": first, "of": len(rows), "text": "\n".join(rows[first:last])})
            first = last
            if first >= len(rows):
                return


def lines_of_list(data: bytes) -> list[str]:
    """Lines of a text list: code page 437, ended by CR LF or LF, the file perhaps by 1Ah."""
    text = data.partition(b"\x1a")[0].decode("cp437").replace("\r\n", "\n").replace("\r", "\n")
    return [row[:80] for row in text.removesuffix("\n").split("\n")][:MOST_LINES] if text else []
