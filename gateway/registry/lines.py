"""Layers of a serial line: `layer` of [[line]]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.registry.rows import table

if TYPE_CHECKING:
    from gateway.pure.cell.cell import Line
    from gateway.pure.lines.decoder import Decoder
    from gateway.services.sources.base import BaseSource
    from protocols.rk512.active import Denied, Failed
    from protocols.rk512.dialects import Dialect


def _procedure_decoder(line: "Line") -> "Decoder":
    from gateway.pure.lines.decoder import LineDecoder

    return LineDecoder(both=True, block_check=line.protocol == "3964R")


@dataclass(frozen=True, slots=True)
class LineLayer:
    """Layer above the link of a [[line]]."""

    name: str
    words: str  # as texts call it
    source: "Callable[[], Callable[..., BaseSource]]"  # its command source
    commands: bool = True  # it is a command source
    blocks: bool = False  # [[db]] are served by number, with jobs of RK512
    first: bool = False  # the usual one: blocks without a line belong to its only line, else to the only line that serves any
    telegrams: bool = False  # [[telegram]] tables belong to it; a quiet partner is not a loss
    shadowed: bool = False  # a shadow understands it
    kinds: str = "DXEAMTZ"  # of blocks that it carries
    profile: str = ""  # a station of this profile uses it whatever the layer
    dialect: "Callable[[Line], Dialect] | None" = None  # of its blocks
    failure: "Callable[[Failed | Denied], object] | None" = None  # what the partner shows when our own job failed
    decoder: "Callable[[Line], Decoder]" = _procedure_decoder  # decodes the line for page and monitor


def _blocks_source() -> "Callable[..., BaseSource]":
    from gateway.services.sources.rk512 import Rk512Source

    return Rk512Source


def _telegram_source() -> "Callable[..., BaseSource]":
    from gateway.services.sources.telegrams import TelegramSource

    return TelegramSource


def _rk512_dialect(line: "Line") -> "Dialect":
    from protocols.rk512.dialects import dialect_of

    return dialect_of(line.profile)


def _buep64_dialect(line: "Line") -> "Dialect":
    from gateway.pure.lines.buep64 import buep64_dialect
    from protocols.buep64.form import Form

    return buep64_dialect(Form())


def _buep64_failure(event: "Failed | Denied") -> object:
    from gateway.pure.lines.buep64 import buep64_fault

    return buep64_fault(event)


LINE_LAYERS = table(
    LineLayer("rk512", "RK512", _blocks_source, blocks=True, first=True, shadowed=True, dialect=_rk512_dialect),
    LineLayer("telegrams", "telegrams", _telegram_source, telegrams=True),
    LineLayer(
        "buep64", "BUEP64", _blocks_source, blocks=True, kinds="D", profile="bosch-buep64", dialect=_buep64_dialect, failure=_buep64_failure
    ),
    LineLayer("program", "program", _blocks_source, commands=False),  # programs of the old controller own the line
)


def layer_spoken(line: "Line") -> LineLayer:
    """The layer of a line as its station uses it."""
    station = line.profile.removesuffix("-tcp")
    return next((layer for layer in LINE_LAYERS.values() if layer.profile and layer.profile == station), LINE_LAYERS[line.layer])
