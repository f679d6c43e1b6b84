"""DBC text to plain layouts: messages (BO_) and their signals (SG_); all other sections are ignored.

Only the parts for a raw bit-field layout are accepted: Intel byte order, factor 1, offset 0, no multiplexing.  Everything else is refused
with file, line, message, signal and expected form, all faults at once.
"""

import re

from protocols.base.errors import ProtocolError
from protocols.base.layout import Layout, Signal

_MESSAGE = re.compile(r"BO_\s+(\d+)\s+(\w+)\s*:\s*(\d+)\s+(\w+)")
_SIGNAL = re.compile(r"SG_\s+(\w+)\s*(\w*)\s*:\s*(\d+)\|(\d+)@([01])([+-])\s*\(([^,)]+),([^)]+)\)\s*\[([^|]+)\|([^\]]+)\]\s*\"([^\"]*)\"")
MAX_IDENTIFIER = 0x7FF
NO_MESSAGE = 0xC0000000  # "VECTOR__INDEPENDENT_SIG_MSG": signals without a message


class DbcError(ProtocolError):
    """A DBC text that cannot be used; `faults` holds one line per fault."""

    def __init__(self, faults: list[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = tuple(faults)


def compile_dbc(text: str, name: str = "dbc") -> dict[str, Layout]:
    """Layouts by message name; `name` is the file's name for messages.  Raises DbcError."""
    layouts: dict[str, Layout] = {}
    faults: list[str] = []
    current = ""
    for number, line in enumerate(text.splitlines(), 1):
        words = line.strip()
        try:
            if words.startswith("BO_ "):
                message = _message(words)
                current = message.name if message else ""
                if message and message.name in layouts:
                    raise ValueError(f"message {message.name} is defined twice")
                if message:
                    layouts[message.name] = message
            elif words.startswith("SG_ ") and current:
                layouts[current] = _with_signal(layouts[current], words)
        except ValueError as fault:
            faults.append(f"{name}:{number}: {fault}")
    if not layouts and not faults:
        faults.append(f"{name}:1: no message (BO_) found; is this a DBC file?")
    if faults:
        raise DbcError(faults)
    return layouts


def _message(words: str) -> Layout | None:
    found = _MESSAGE.match(words)
    if not found:
        raise ValueError(f'message line not understood: "{words}"; expected "BO_ IDENTIFIER NAME: LENGTH SENDER"')
    identifier, length = int(found[1]), int(found[3])
    if identifier == NO_MESSAGE:
        return None
    if identifier > MAX_IDENTIFIER:
        raise ValueError(f"message {found[2]}: identifier {identifier} is outside 0..{MAX_IDENTIFIER} (11 bits)")
    if length > 8:
        raise ValueError(f"message {found[2]}: length {length} is outside 0..8 bytes")
    return Layout(found[2], identifier, length, ())


def _with_signal(layout: Layout, words: str) -> Layout:
    found = _SIGNAL.match(words)
    if not found:
        raise ValueError(f'message {layout.name}: signal line not understood: "{words}"')
    where = f"message {layout.name}, signal {found[1]}"
    if found[2]:
        raise ValueError(f"{where}: multiplexed ({found[2]}); expected a plain signal")
    if found[5] != "1":
        raise ValueError(f"{where}: byte order Motorola (@0); expected Intel (@1)")
    if float(found[7]) != 1.0 or float(found[8]) != 0.0:
        raise ValueError(f"{where}: scale ({found[7]},{found[8]}); expected raw counts (1,0)")
    signal = _signal(found, where)
    _fit(layout, signal, where)
    return Layout(layout.name, layout.identifier, layout.length, (*layout.signals, signal))


def _signal(found: re.Match[str], where: str) -> Signal:
    start, bits, signed = int(found[3]), int(found[4]), found[6] == "-"
    if not 1 <= bits <= 64:
        raise ValueError(f"{where}: {bits} bits; expected 1..64")
    lowest, highest = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signed else (0, (1 << bits) - 1)
    low, high = float(found[9]), float(found[10])
    if low == high == 0.0:  # "no range given" in DBC
        low, high = lowest, highest
    if not (float(low).is_integer() and float(high).is_integer() and lowest <= low <= high <= highest):
        raise ValueError(f"{where}: range {found[9]}..{found[10]} does not fit {bits} bits; expected within {lowest}..{highest}")
    return Signal(found[1], start, bits, signed, int(low), int(high), found[11])


def _fit(layout: Layout, signal: Signal, where: str) -> None:
    if signal.start + signal.bits > 8 * layout.length:
        last = signal.start + signal.bits - 1
        raise ValueError(f"{where}: bits {signal.start}..{last}; expected within 0..{8 * layout.length - 1} ({layout.length} bytes)")
    for other in layout.signals:
        if other.name == signal.name:
            raise ValueError(f"{where}: defined twice")
        if other.start < signal.start + signal.bits and signal.start < other.start + other.bits:
            raise ValueError(f"{where}: overlaps signal {other.name} (bits {other.start}..{other.start + other.bits - 1})")
