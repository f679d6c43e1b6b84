"""Names of a PIC program: addresses, signals of the interface, and symbols of its SYM file.  Source: rho3 0.2, 6, L1471-1500; AX-980."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from gateway.pure.image.addresses import Direction, RcBit
from gateway.pure.image.signals import SignalList
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position

BYTES = 128  # of each area (L9292-9311)
ADDRESS = re.compile(r"([IOMEA])\s*(\d{1,4})\.(\d{1,2})(?!\w)", re.IGNORECASE)
_ROW = re.compile(r"-?([^\W\d]\w*)\s*[=:,]?\s+?(?:=\s*)?(\S.*?)\s*|-?([^\W\d]\w*)=(\S.*?)\s*")
_USER = re.compile(r"(AEIN|AAUS)_(\d{1,3})(?:_\w+)?", re.IGNORECASE)  # AAUS_17 = USER_17_RCO (L1475), AEIN_42 = USER_42_RCI (L3974)


class Area(Enum):
    """Inputs of the PIC are outputs of the control, its outputs are inputs of the control."""

    INPUT = "I"
    OUTPUT = "O"
    FLAG = "M"


LETTERS = {"I": Area.INPUT, "E": Area.INPUT, "O": Area.OUTPUT, "A": Area.OUTPUT, "M": Area.FLAG}
ENDINGS = ("", "_RCI", "_RCO")


@dataclass(frozen=True, slots=True)
class Bit:
    """One bit of the PIC."""

    area: Area
    byte: int
    bit: int

    def __str__(self) -> str:
        return f"{self.area.value}{self.byte}.{self.bit}"


def address(text: str) -> Bit | str | None:
    """I8.4, O2.3, M0.0, with E and A as in German; a sentence: outside of its area; None: no address."""
    found = ADDRESS.fullmatch(text.strip())
    if found is None:
        return None
    area, byte, bit = LETTERS[found[1].upper()], int(found[2]), int(found[3])
    if byte >= BYTES or bit > 7:
        return f"{text.strip()}: bytes are 0..{BYTES - 1}, bits 0..7"
    return Bit(area, byte, bit)


Signals = Callable[[str], RcBit | None]  # the numbered signals by name


def named_in(listed: SignalList) -> Signals:
    """Those of a list."""

    def named(name: str) -> RcBit | None:
        found = listed.named(name)
        return None if found is None else found.at

    return named


@dataclass(slots=True)
class Symbols:
    """Own symbols before the signals of the interface; names in any case of letters."""

    signals: Signals
    own: Mapping[str, Bit] = field(default_factory=dict)

    def find(self, name: str) -> Bit | None:
        """The bit of that name; an ending _RCI or _RCO may be left out."""
        own = self.own.get(name.upper())
        if own is not None:
            return own
        for ending in ENDINGS:
            place = self.signals(name + ending)
            if place is not None:
                return _bit(place)
        user = _USER.fullmatch(name)
        if user is None:
            return None
        place = self.signals(f"USER_{int(user[2])}_{'RCI' if user[1].upper() == 'AEIN' else 'RCO'}")
        return None if place is None else _bit(place)


def _bit(place: RcBit) -> Bit:
    area = Area.OUTPUT if place.direction is Direction.INPUT else Area.INPUT
    return Bit(area, place.number >> 3, place.number & 7)


def symbols_of(text: str, file: str, signals: Signals, faults: Faults) -> Symbols:
    """Lines `NAME = I88.0 ; comment`; the name of a signal may follow the sign too."""
    own: dict[str, Bit] = {}
    known = Symbols(signals, own)
    for number, line in enumerate(text.splitlines(), 1):
        row = line.partition(";")[0].strip()
        if not row:
            continue
        match, here = _ROW.fullmatch(row), Position(file, number)
        if match is None:
            faults.error("symbol-line", here, f"{row[:40]!r} is not a symbol", "the form is NAME = I88.0")
            continue
        name, meant = (match[1] or match[3]).upper(), match[2] or match[4]
        place = address(meant)
        if place is None:
            place = known.find(meant) or f"{meant[:40]!r} is neither an address nor a signal"
        if isinstance(place, str):
            faults.error("symbol-line", here, place, "the form is NAME = I88.0")
        elif name in own:
            faults.error("symbol-twice", here, f"{name} is defined twice")
        else:
            own[name] = place
    return known
