"""Each line of a run is decoded by its own protocol."""

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import pytest

from gateway.cell_file.load import load_cell
from gateway.observer.tool_link import ServicesLink
from gateway.pure.cell.cell import Cell
from gateway.pure.lines.decoder import LineReport
from gateway.registry import LINE_LAYERS, LineLayer
from gateway.web.line_view import LineViews
from protocols.base.machine import Damage, Ns

DIALOGUE = (("A", "02"), ("B", "10"), ("A", "4142"), ("A", "1003"), ("B", "10"))  # procedure 3964: no block check behind DLE ETX


class Said:
    """In place of the services: the same pieces once."""

    async def ask(self, op: str, **more: Any) -> dict[str, Any]:
        seen = more["since"].get("plc1", 0)
        pieces = [[n, n * 1_000_000, side, octets] for n, (side, octets) in enumerate(DIALOGUE, 1) if n > seen]
        return {"lines": {"plc1": pieces}, "modbus": {}}


def shown(cell: Cell) -> list[dict[str, Any]]:
    return asyncio.run(LineViews(cell, cast(ServicesLink, Said())).look())["plc1"]


def with_line(**changed: Any) -> Cell:
    cell = load_cell("demo")
    return replace(cell, line=tuple(replace(line, **changed) for line in cell.line if line.name == "plc1"))


def test_a_line_without_block_check_ends_its_blocks_with_etx() -> None:
    assert [row["kind"] for row in shown(with_line(protocol="3964"))] == ["STX", "DLE", "BLOCK", "DLE"]
    assert "BLOCK" not in [row["kind"] for row in shown(with_line())[:3]], "3964R waits for the check"


class Text:
    """A protocol of its own: two characters a word."""

    def __init__(self) -> None:
        self._heard = ""

    def take(self, stamp: Ns, side: str, what: int | Damage) -> Sequence[LineReport]:
        self._heard += f"{what:02X}"
        if len(self._heard) < 4:
            return ()
        word, self._heard = self._heard, ""
        return (LineReport(stamp, side, "WORD", word),)


def test_a_layer_with_its_own_protocol_has_its_own_words(monkeypatch: pytest.MonkeyPatch) -> None:
    row = LineLayer("text", "text", LINE_LAYERS["telegrams"].source, decoder=lambda line: Text())
    monkeypatch.setitem(cast(dict[str, LineLayer], LINE_LAYERS), "text", row)
    assert [(one["kind"], one["say"][0]) for one in shown(with_line(layer="text"))] == [
        ("WORD", "0210"),
        ("WORD", "4142"),
        ("WORD", "1003"),
    ]
