"""Records between the cycle and the master of a bus, in addition to the cyclic data."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, NamedTuple

from gateway.pure.image.records.layout import I64, U8, U16, Code, Layout


class Aside(IntEnum):
    """Records between the cycle and the master of a bus: non-cyclic frames, and what the cycle must know of a node."""

    FRAME = 0
    RELEASE = 1  # to the cycle: this node is configured; data = the mode it is in (6061h)
    HOLD = 2  # to the cycle: this node is not, or no longer


class AsideRecord(NamedTuple):
    """One of them; `bus` counts the cell's drive buses from 0, `identifier` is the node for RELEASE and HOLD."""

    kind: Aside
    bus: int
    identifier: int
    data: bytes = b""
    stamp_ns: int = 0


@dataclass(frozen=True, slots=True)
class _AsideBytes:
    """An AsideRecord as the ring holds it."""

    kind: Annotated[Aside, Code("B", Aside)]
    bus: U8
    identifier: U16
    size: Annotated[int, Code("B3x")]
    data: Annotated[bytes, Code("8s")]
    stamp_ns: I64


_ASIDE = Layout(_AsideBytes, "aside/1")
ASIDE_BYTES, ACYCLIC_RECORDS, HEARD_RECORDS, ASIDE_LAYOUT = _ASIDE.size, 1024, 8192, _ASIDE.text


def pack_aside(record: AsideRecord) -> bytes:
    """AsideRecord as ASIDE_BYTES bytes; data has at most 8. By hand: it is done for every frame."""
    kind, bus, identifier, data, stamp = record
    return _ASIDE.struct.pack(kind, bus, identifier, len(data), data, stamp)


def unpack_aside(data: bytes) -> AsideRecord:
    """The reverse of pack_aside."""
    kind, bus, identifier, size, octets, stamp = _ASIDE.struct.unpack(data)
    return AsideRecord(Aside(kind), bus, identifier, octets[:size], stamp)
