"""Modbus: answers with one fault each (used by peers.modbus_rows)."""

import struct
from collections.abc import Callable, Sequence

from gateway.conformance.peers.modbus_devices import SIZE, Answer, Device, Tables
from protocols.base.machine import Ns
from protocols.modbus.answering import answer
from protocols.modbus.mbap import Request
from protocols.modbus.view import Kind


def rewritten(function: int, change: Callable[[bytes, bytes], bytes]) -> Answer:
    """The answers to one function are changed, refusals are not."""
    return lambda device, asked, said: change(asked, said) if said[0] == function else said


def number(old: int, new: int, functions: Sequence[int]) -> Answer:
    return lambda device, asked, said: (
        bytes((said[0], new)) if said[0] & 0x80 and said[1:] == bytes((old,)) and asked[0] in functions else said
    )


def all_as(code: int) -> Answer:
    return lambda device, asked, said: bytes((said[0], code)) if said[0] & 0x80 else said


def writes_bad(device: Device, asked: bytes, said: bytes) -> bytes:
    """Refuses a bad byte count, but writes."""
    if said[0] == 0x90 and said[1] == 3 and len(asked) > 7:
        device.tables.write_words(asked[1] << 8 | asked[2], [0x5A5A])
    return said


def any_coil_value(device: Device, asked: bytes, said: bytes) -> bytes:
    if said[0] == 0x85 and len(asked) == 5:
        device.tables.write_bits(asked[1] << 8 | asked[2], [bool(asked[3] or asked[4])])
        return asked
    return said


def any_amount(device: Device, asked: bytes, said: bytes) -> bytes:
    """Amount 0 is answered with nothing."""
    return bytes((asked[0], 0)) if said[1:] == b"\x03" and asked[0] < 5 and asked[3:5] == b"\0\0" else said


def too_many(device: Device, asked: bytes, said: bytes) -> bytes:
    if said[1:] == b"\x03" and asked[0] in (3, 4) and asked[3:5] == b"\x00\x7e":
        return bytes((asked[0], 252)) + bytes(252)
    return said


def longer(functions: Sequence[int], size: int = 0) -> Answer:
    """A byte too many does not count.  size: of the requests, where it is the same for all."""

    def changed(device: Device, asked: bytes, said: bytes) -> bytes:
        if asked[0] not in functions or said[1:] != b"\x03" or (size and len(asked) != size):
            return said
        again = answer(asked[:-1], device.tables, True, device.station)
        return said if again[0] & 0x80 else again

    return changed


def limited(count: int) -> Answer:
    """At most so many registers in one request."""

    def changed(device: Device, asked: bytes, said: bytes) -> bytes:
        if said[0] & 0x80 or asked[0] not in (3, 4, 16):
            return said
        return bytes((asked[0] | 0x80, 3)) if (asked[3] << 8 | asked[4]) > count else said

    return changed


def wraps(device: Device, asked: bytes, said: bytes) -> bytes:
    """Beyond 65535 it begins again at 0."""
    return bytes((asked[0], 4)) + bytes(4) if said[0] & 0x80 and asked[:5] in (b"\x03\xff\xff\x00\x02", b"\x04\xff\xff\x00\x02") else said


def reads_first(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 23 reads before it writes."""
    if said[0] != 23:
        return said
    count = said[1] // 2
    found = getattr(device, "_before", [0] * SIZE)
    at = asked[1] << 8 | asked[2]
    return said[:2] + struct.pack(f">{count}H", *found[at : at + count])


def counts_written(device: Device, asked: bytes, said: bytes) -> bytes:
    """The byte count of FC 23 is that of the written data."""
    return said[:1] + asked[9:10] + said[2:] if said[0] == 23 else said


class ReadsFirst(Device):
    def serve(self, request: Request, now: Ns) -> bytes:
        self._before = list(self.tables.words[Kind.HOLDING_REGISTERS])
        return super().serve(request, now)


def mask_or(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 22 without the and-mask of the or-mask."""
    if said[0] == 22:
        at, put = asked[1] << 8 | asked[2], asked[5] << 8 | asked[6]
        device.tables.words[Kind.HOLDING_REGISTERS][at] |= put
    return said


def padded(asked: bytes, said: bytes) -> bytes:
    free = -(asked[3] << 8 | asked[4]) % 8
    return said[:-1] + bytes((said[-1] | 0xFF << (8 - free) & 0xFF,)) if free else said


def mirrored(asked: bytes, said: bytes) -> bytes:
    return said[:2] + bytes(int(f"{byte:08b}"[::-1], 2) for byte in said[2:])


def byte_more(asked: bytes, said: bytes) -> bytes:
    return said[:1] + bytes((said[1] + 1,)) + said[2:] + b"\0" if asked[3:5] == b"\x00\x08" or (asked[3] << 8 | asked[4]) % 8 == 0 else said


def after_refusals(device: Device, asked: bytes, said: bytes) -> bytes:
    if said[0] & 0x80:
        device.refused += 1
    return said if device.refused < 100 else bytes((asked[0] | 0x80, 4))


def each_70th(device: Device, asked: bytes, said: bytes) -> bytes:
    return said if device.count % 70 else bytes((asked[0] | 0x80, 6))


def writes_unread(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 23 writes though the part to be read is missing."""
    if said == b"\x97\x02" and len(asked) >= 12:
        device.tables.write_words(asked[5] << 8 | asked[6], [asked[10] << 8 | asked[11]])
    return said


def reads_126(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 23 serves 126 registers."""
    return bytes((23, 252)) + bytes(252) if said == b"\x97\x03" and asked[3:5] == b"\x00\x7e" else said


class ForgetsWithTheClient(Device):
    """Values written by a client are lost with its connection."""

    def lost(self, now: Ns) -> Sequence[object]:
        self.tables = Tables()
        return super().lost(now)
