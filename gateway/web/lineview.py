"""The lines of a run, decoded as `axisgate line monitor` does, out of what the services' taps kept."""

from collections import deque
from typing import Any

from gateway.cell import Cell
from gateway.pure.line_decoder import LineDecoder
from gateway.web.desk import ServicesDesk
from protocols.base.machine import Damage

KEPT, SHOWN = 300, 80
Row = dict[str, Any]


class LineViews:
    """Sentences of every line, the last few hundred."""

    def __init__(self, cell: Cell, desk: ServicesDesk) -> None:
        self._desk = desk
        self._rk512 = {line.name for line in cell.line}
        self._seen: dict[str, int] = {}
        self._decoders: dict[str, LineDecoder] = {}
        self._told: dict[str, deque[Row]] = {}

    async def look(self) -> dict[str, list[Row]]:
        """What was said since the last look is decoded; the newest sentences of each line, oldest first.  Gone, Refused."""
        answer = await self._desk.ask("tap", since=self._seen)
        for line, pieces in answer["lines"].items():
            if pieces and pieces[-1][0] < self._seen.get(line, 0):  # the services were restarted and count anew
                self._seen.pop(line)
            self._take(line, pieces)
        return {line: list(told)[-SHOWN:] for line, told in self._told.items()}

    def _take(self, line: str, pieces: list[list[Any]]) -> None:
        decoder = self._decoders.setdefault(line, LineDecoder(both=True))
        told = self._told.setdefault(line, deque(maxlen=KEPT))
        for number, stamp, side, what in pieces:
            self._seen[line] = number
            heard = [Damage[what[1:]]] if what.startswith("!") else list(bytes.fromhex(what))
            for each in heard:
                for one in decoder.take(stamp, side, each):
                    row = {"ms": round(one.stamp / 1e6, 1), "side": one.side, "kind": one.kind, "text": one.text}
                    told.append({**row, "hex": one.data[:64].hex(" "), "ok": one.check_ok})
