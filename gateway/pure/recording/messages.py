"""What the cycle and the services put into their rings for a recording, and what a file keeps of it (AX-482).

A message is its kind (u8), the length of its payload (u32) and the payload.  The messages of one cycle are a script in the order of the
calls: BEGIN first, STEP last; played again they call the same things in the same order.  In the ring they travel in records of
CHUNK_BYTES.  Native byte order in the ring, so on the machine that wrote it; all machines axisgate runs on are little endian.
"""

import struct
from collections.abc import Iterable, Iterator
from enum import IntEnum
from typing import NamedTuple

from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns


class What(IntEnum):
    """Kinds of messages."""

    START = 1  # ring: the pickled state at rest; file: the same as JSON
    BEGIN = 2  # stamp of the cycle, grid instants missed before it
    RELEASE = 3  # bus, node, mode: the master has configured it
    HOLD = 4  # bus, node
    HEARD = 5  # bus, phase, frames as they were taken
    IMAGE = 6  # RC inputs, all of region rc_in
    EXCHANGE = 7  # bus, whether it is there: digital I/O of that bus
    SENT = 8  # bus, frames of the burst
    DRIVES_LOST = 9
    SERVICES_LOST = 10
    PLANNER_LOST = 11
    PIECE = 12  # record of the planner
    ORDER = 13  # record of the services
    SHOWN = 14  # bus, contacts of its couplers
    STEP = 15  # cycle, stamp, beat of the services, missing actual values
    OUTPUTS = 16  # cell state and RC outputs, as published
    SERVICE_EVENT = 17  # message of a command source or a tool: not an input of the core, but the origin of its orders


class Phase(IntEnum):
    """When frames were taken."""

    BEFORE = 0  # the burst: they belong to the cycle before
    AFTER = 1


class Message(NamedTuple):
    """One of them."""

    what: What
    payload: bytes = b""


HEAD = struct.Struct("=BI")
FRAME = struct.Struct("=HBq8s")
BEGIN = struct.Struct("=qI")
NODE = struct.Struct("=BHB")
BUS = struct.Struct("=BBH")  # bus, phase or whether it is there, number of frames
STEP = struct.Struct("=QqqH")
CONTACT = struct.Struct("=HB")
CHUNK = struct.Struct("=QHHI")  # cycle, part, parts, bytes
CHUNK_BYTES, CHUNK_RECORDS = 1024, 8192  # 16 s at 2 ms, where a cycle fits one record
CHUNK_DATA = CHUNK_BYTES - CHUNK.size
CHUNK_LAYOUT = f"record/1 {CHUNK.format} {CHUNK_DATA}"
SERVICE_EVENT = struct.Struct("=qBBH")  # stamp, source, command source, bytes
SERVICE_EVENT_BYTES, SERVICE_EVENT_RECORDS = 512, 4096
SERVICE_EVENT_LAYOUT = f"service_event/1 {SERVICE_EVENT.format} {SERVICE_EVENT_BYTES}"
ASKED = struct.Struct("=Q")
ASKED_LAYOUT = f"recorder/1 {ASKED.format}"
RECORDER_GONE: Ns = 30_000_000_000  # a recorder that died and comes back within that time has lost nothing


class Source(IntEnum):
    """Origin of a message."""

    HEARD = 1  # characters of the partner of a line
    SAID = 2  # characters of ours
    WRITTEN = 3  # octets of RC inputs a Modbus partner wrote: number u8, value u8, ...
    COMMAND = 4  # words of a command block: first u16, words u16
    TOOL = 5  # a request of a tool, JSON


def pack(what: What, payload: bytes = b"") -> bytes:
    """One message."""
    return HEAD.pack(what, len(payload)) + payload


def unpack(octets: bytes) -> Iterator[Message]:
    """Yield the messages in sequence.  Raise DecodeError at the first invalid one."""
    at = 0
    while at < len(octets):
        if at + HEAD.size > len(octets):
            raise DecodeError(f"{len(octets) - at} bytes left, a message has {HEAD.size} at least")
        kind, size = HEAD.unpack_from(octets, at)
        at += HEAD.size
        if kind not in KINDS or at + size > len(octets):
            raise DecodeError(f"message of kind {kind} with {size} bytes; {len(octets) - at} are left")
        yield Message(KINDS[kind], bytes(octets[at : at + size]))
        at += size


KINDS = {int(kind): kind for kind in What}


def pack_frames(bus: int, second: int, frames: Iterable[Frame]) -> bytes:
    """Bus, phase (or whether the bus is there), frames with their stamps."""
    packed = [FRAME.pack(identifier, len(data), stamp, data) for identifier, data, stamp in frames]
    return BUS.pack(bus, second, len(packed)) + b"".join(packed)


def unpack_frames(payload: bytes) -> tuple[int, int, list[Frame]]:
    """The reverse of pack_frames."""
    try:
        bus, second, count = BUS.unpack_from(payload)
        rows = list(FRAME.iter_unpack(payload[BUS.size :]))
    except struct.error as error:
        raise DecodeError(f"frames of a bus: {error}") from error
    if len(rows) != count:
        raise DecodeError(f"{count} frames announced, {len(rows)} there")
    return bus, second, [Frame(identifier, data[:size], stamp) for identifier, size, stamp, data in rows]


def pack_shown(bus: int, contacts: Iterable[tuple[int, bool]]) -> bytes:
    """Contacts of the couplers of a bus."""
    return bytes((bus,)) + b"".join(CONTACT.pack(number, shown) for number, shown in contacts)


def unpack_shown(payload: bytes) -> tuple[int, dict[int, bool]]:
    """The reverse of pack_shown."""
    try:
        return payload[0], {number: bool(shown) for number, shown in CONTACT.iter_unpack(payload[1:])}
    except (struct.error, IndexError) as error:
        raise DecodeError(f"contacts of a bus: {error}") from error


def chunks(cycle: int, octets: bytes | bytearray) -> Iterator[bytes]:
    """Records of the ring for the messages of one cycle."""
    parts = max(1, -(-len(octets) // CHUNK_DATA))
    for part in range(parts):
        data = octets[part * CHUNK_DATA : (part + 1) * CHUNK_DATA]
        yield CHUNK.pack(cycle, part, parts, len(data)) + bytes(data).ljust(CHUNK_DATA, b"\0")


class Assembly:
    """Assembles records of the ring to complete cycles; a missing part loses its cycle and is counted."""

    def __init__(self) -> None:
        self.broken = 0
        self._cycle, self._parts, self._data = 0, 0, bytearray()

    @property
    def whole(self) -> bool:
        """Nothing waits for more of it."""
        return not self._parts

    def take(self, record: bytes) -> tuple[int, bytes] | None:
        """(cycle, its messages) when this record completes it."""
        cycle, part, parts, size = CHUNK.unpack_from(record)
        if part != self._parts or (part and cycle != self._cycle):
            self.broken += 1
            self._parts, self._data = 0, bytearray()
            if part:
                return None
        self._cycle, self._parts = cycle, part + 1
        self._data += record[CHUNK.size : CHUNK.size + size]
        if self._parts < parts:
            return None
        whole, self._parts, self._data = bytes(self._data), 0, bytearray()
        return cycle, whole


def pack_service_event(stamp: Ns, source: Source, number: int, data: bytes) -> list[bytes]:
    """Return records of the ring; a long text needs several."""
    room = SERVICE_EVENT_BYTES - SERVICE_EVENT.size
    parts = [data[at : at + room] for at in range(0, len(data), room)]
    return [SERVICE_EVENT.pack(stamp, source, number, len(part)) + part.ljust(room, b"\0") for part in parts]


class ServiceEvent(NamedTuple):
    """Message of a command source or a tool."""

    stamp: Ns
    source: Source
    number: int
    data: bytes


def unpack_service_event(record: bytes) -> ServiceEvent:
    """The reverse of pack_service_event, for one record or its shorter form in a file."""
    try:
        stamp, source, number, size = SERVICE_EVENT.unpack_from(record)
        return ServiceEvent(stamp, Source(source), number, bytes(record[SERVICE_EVENT.size : SERVICE_EVENT.size + size]))
    except (struct.error, ValueError) as error:
        raise DecodeError(f"message: {error}") from error
