"""The lines of a run and its Modbus servers in words, from the services' taps; lines as in `axisgate line monitor`."""

from collections import deque
from typing import Any

from gateway.observer.tool_link import ServicesLink
from gateway.pure.cell.cell import Cell
from gateway.pure.image.reasons import Reason, text
from gateway.pure.lines.decoder import Decoder
from gateway.pure.modbus import texts as modbus_words
from gateway.registry import LINE_LAYERS
from gateway.web.german import says, umlauts
from protocols.base.machine import Damage

KEPT, SHOWN = 300, 80
SAID = ("why", "advice")
Row = dict[str, Any]


def asked_links(status: Row) -> list[Row]:
    """Modbus clients and couplers of the services' status, one row per link: its name, whether all its devices answer, its refusals."""
    found: dict[str, Row] = {**status.get("modbus_clients", {}), **status.get("modbus_couplers", {})}
    return [
        {
            **link,
            "name": name,
            "alive": bool(link["connected"]) and all(device["alive"] for device in link["devices"].values()),
            "why": says(str(link["why"])),
            "refused": [says(words) for words in link["refused"]],
        }
        for name, link in found.items()
    ]


def shown_sources(status: Row) -> list[Row]:
    """Command sources of the services' status, their texts in both languages."""
    return [
        {**source, **{key: says(str(source[key])) for key in SAID if source.get(key)}, "because": _reason(source)}
        for source in status.get("command_sources", [])
    ]


def _reason(source: Row) -> list[str]:
    """Why its last command was refused or aborted."""
    name = str(source.get("reason", "NONE"))
    if name == "NONE" or name not in Reason.__members__:
        return ["", ""]
    return [text(Reason[name], "en", "").rstrip(": "), umlauts(text(Reason[name], "de", "")).rstrip(": ")]


class LineViews:
    """Sentences of every line, the last few hundred."""

    def __init__(self, cell: Cell, services_link: ServicesLink) -> None:
        self._services_link = services_link
        self._lines = {line.name: line for line in cell.line}
        self._seen: dict[str, int] = {}
        self._decoders: dict[str, Decoder] = {}
        self._kept: dict[str, deque[Row]] = {}

    async def look(self) -> dict[str, list[Row]]:
        """Decode the traffic since the last look; return the newest sentences of each line, oldest first.  Gone, Refused."""
        answer = await self._services_link.ask("tap", since=self._seen)
        for take, found in ((self._take, answer["lines"]), (self._take_modbus, answer["modbus"])):
            for line, pieces in found.items():
                if pieces and pieces[-1][0] < self._seen.get(line, 0):  # the services were restarted and count from 0
                    self._seen.pop(line)
                take(line, pieces)
        return {line: list(rows)[-SHOWN:] for line, rows in self._kept.items()}

    def _take(self, line: str, pieces: list[list[Any]]) -> None:
        if line not in self._decoders:
            table = self._lines[line]
            self._decoders[line] = LINE_LAYERS[table.layer].decoder(table)
        decoder = self._decoders[line]
        kept = self._kept.setdefault(line, deque(maxlen=KEPT))
        for number, stamp, side, what in pieces:
            self._seen[line] = number
            heard = [Damage[what[1:]]] if what.startswith("!") else list(bytes.fromhex(what))
            for each in heard:
                for one in decoder.take(stamp, side, each):
                    row = {"ms": round(one.stamp / 1e6, 1), "side": one.side, "kind": one.kind, "say": says(one.text)}
                    kept.append({**row, "hex": one.data[:64].hex(" "), "ok": one.check_ok})

    def _take_modbus(self, server: str, exchanges: list[list[Any]]) -> None:
        """One row an exchange."""
        kept = self._kept.setdefault(server, deque(maxlen=KEPT))
        for number, stamp, address, unit, asked, long, answer, _ in exchanges:
            self._seen[server] = number
            pdu = bytes.fromhex(asked)
            words = modbus_words.exchange_text(pdu, bytes.fromhex(answer))
            row = {"n": number, "ms": round(stamp / 1e6, 1), "client": address, "unit": unit, "function": pdu[0] if pdu else 0}
            kept.append({**row, "asked": says(words.asked), "answered": says(words.answered), "ok": words.ok, "hex": asked, "bytes": long})
