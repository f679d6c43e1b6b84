"""Blocks in, events out.  Everything a partner sends is an event and is counted; nothing is raised.

As READ of a rho 3 does with one block (rho3 1.3), but completely or not at all: a block border inside an item, a BINARY above 1 or a REAL
that is not a number refuses the block, and none of its values is used (AX-192).
"""

from collections.abc import Sequence

from protocols.base.errors import DecodeError
from protocols.telegrams.fields import decode
from protocols.telegrams.layout import Event, Incoming, Received, Refused, Unknown


class Reader:
    """Knows the incoming telegrams of one line."""

    def __init__(self, telegrams: Sequence[Incoming]) -> None:
        self._telegrams = tuple(telegrams)
        self.received = {telegram.name: 0 for telegram in self._telegrams}
        self.refused = {telegram.name: 0 for telegram in self._telegrams}
        self.unknown = 0

    def block(self, data: bytes) -> Event:
        """The meaning of a complete block."""
        known = [telegram for telegram in self._telegrams if telegram.recognises(data)]
        telegram = next((each for each in known if each.fits(data)), known[0] if known else None)
        if telegram is None:
            self.unknown += 1
            return Unknown(data)
        event = _read(telegram, data)
        counts = self.received if isinstance(event, Received) else self.refused
        counts[telegram.name] += 1
        return event


def _read(telegram: Incoming, data: bytes) -> Received | Refused:
    if not telegram.fits(data):
        wanted = telegram.needed if telegram.length is None else telegram.length
        return Refused(telegram.name, f"{len(data)} bytes received, {wanted}{' or more' if telegram.length is None else ''} expected")
    try:
        values = tuple((field.name, decode(field, data)) for field in telegram.fields)
    except DecodeError as error:
        return Refused(telegram.name, str(error))
    return Received(telegram.name, values, telegram.signal)
