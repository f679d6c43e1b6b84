"""A client's bytes written by hand, and a whole server without a socket: framing and answers put together."""

import struct

from protocols.modbus.answering import answer
from protocols.modbus.mbap import Closing, Framing, Request
from protocols.modbus.station import Station
from protocols.modbus.view import View, home_unit


def frame(pdu: str, transaction: int = 1, unit: int = 1, protocol: int = 0, length: int | None = None) -> bytes:
    """An MBAP frame around a PDU in hex; `length` overrides the right one."""
    body = bytes.fromhex(pdu)
    return struct.pack(">HHHB", transaction, protocol, len(body) + 1 if length is None else length, unit) + body


def exchange(data: bytes, view: View, may_write: bool = True) -> tuple[bytes, bool]:
    """What a server of unit 1 says to these bytes, and whether it closes."""
    framing, station, closed = Framing(), Station(), False
    for event in framing.receive(data, 0):
        if isinstance(event, Request):
            unit = home_unit(event.unit, 1)
            framing.reply(event, answer(event.pdu, view if unit == 1 else None, may_write, station))
        closed |= isinstance(event, Closing)
    return framing.take_output(), closed
