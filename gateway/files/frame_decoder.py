"""Frames as text: messages of a DBC file, or CANopen by identifier."""

from collections.abc import Callable

import cantools
from cantools.database.can import Database
from cantools.database.errors import Error as DatabaseError

from drivers.ports.can.wire import EFF_FLAG, ID_BITS, RTR_FLAG
from gateway.files.find import find_config
from gateway.pure.buses.decoder import canopen_text
from protocols.base.machine import Frame

Decode = Callable[[Frame], str]


def named(identifier: int) -> str:
    """ "100 (64h)"; extended identifiers by hexadecimals alone."""
    identifier &= ~RTR_FLAG
    return f"{identifier & ID_BITS:08X}h" if identifier & EFF_FLAG else f"{identifier} ({identifier:X}h)"


def decoder(dbc: str | None, *, canopen: bool) -> Decode:
    """Text form of a frame; raises ConfigNotFound and errors of cantools."""
    database = cantools.database.load_file(str(find_config(dbc, "drives"))) if dbc else None
    known = {m.frame_id: m for m in database.messages} if isinstance(database, Database) else {}

    def decode(frame: Frame) -> str:
        if frame.identifier & RTR_FLAG:
            return f"remote frame, asks for {len(frame.data)} bytes"
        message = known.get(frame.identifier & ~EFF_FLAG)
        if message is None:
            return canopen_text(frame) if canopen else ""
        try:
            values = message.decode(frame.data, decode_choices=False)
        except (ValueError, DatabaseError) as error:
            return f"{message.name}: {error}"
        assert isinstance(values, dict)
        return f"{message.name} " + " ".join(
            f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}" for name, value in values.items()
        )

    return decode
