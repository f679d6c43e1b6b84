"""Faults of frames between the cable and the emulated drives: lost, late, doubled, altered; SYNC late or not at all; a quiet controller.

Pure: sits between port and slaves, both ways.  A frame destroyed by an error on the wire is repeated by the controllers and appears here as
a late one; an altered frame is a fault that a CAN controller cannot detect (a gateway or firmware that changes data).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from protocols.base.machine import Frame, Ns


class Kind(Enum):
    DROP = "drop"
    DELAY = "delay"
    DUPLICATE = "duplicate"
    CORRUPT = "corrupt"


class Way(Enum):
    """As the drives see it."""

    IN = "in"  # from the bus to the drives: SYNC, set values, SDO requests
    OUT = "out"  # from the drives to the bus


@dataclass(frozen=True, slots=True)
class Order:
    """The next `count` frames of that direction (and identifier) are corrupted."""

    kind: Kind
    way: Way
    count: int
    identifier: int | None = None  # None: any
    delay_ns: Ns = 0  # DELAY
    byte: int = 0  # CORRUPT
    bits: int = 1  # CORRUPT: turned over in that byte


class FrameFaults:
    """All orders of one emulator; without any it passes everything through."""

    def __init__(self) -> None:
        self.spoilt = dict.fromkeys(Kind, 0)  # frames corrupted so far
        self.silenced = 0  # frames lost while the controller was quiet
        self._orders: list[Order] = []
        self._late: dict[Way, list[Frame]] = {Way.IN: [], Way.OUT: []}
        self._quiet_until: Ns = 0

    def order(self, order: Order) -> None:
        self._orders.append(order)

    def quiet(self, until: Ns) -> None:
        """Nothing comes in and nothing goes out until then: a controller that is bus-off or waits for its restart."""
        self._quiet_until = until

    def clear(self) -> None:
        """Remove all orders; late frames still arrive."""
        self._orders.clear()
        self._quiet_until = 0

    @property
    def idle(self) -> bool:
        return not (self._orders or self._quiet_until or self._late[Way.IN] or self._late[Way.OUT])

    def due(self) -> Ns | None:
        """When the next late frame is due."""
        return min((frame.stamp_ns for frames in self._late.values() for frame in frames), default=None)

    def through(self, way: Way, frames: Sequence[Frame], now: Ns) -> list[Frame]:
        """Frames of one way as the faults leave them, late ones of earlier calls included; call it with none when `due()` has come.

        Stamps: a late frame coming in carries the stamp of its arrival, so the drives judge SYNC by it.
        """
        if self.idle:
            return list(frames)
        if now < self._quiet_until:
            self.silenced += len(frames)
            frames = ()
        elif self._quiet_until:
            self._quiet_until = 0
        passed = [out for frame in frames for out in self._spoil(way, frame, now)]
        ready = [frame for frame in self._late[way] if frame.stamp_ns <= now]
        if ready:
            self._late[way] = [frame for frame in self._late[way] if frame.stamp_ns > now]
            passed = sorted([*passed, *ready], key=lambda frame: frame.stamp_ns) if way is Way.IN else [*passed, *ready]
        return passed

    def _spoil(self, way: Way, frame: Frame, now: Ns) -> list[Frame]:
        meant = [at for at, order in enumerate(self._orders) if order.way is way and order.identifier in (None, frame.identifier)]
        if not meant:
            return [frame]
        at = meant[0]
        order = self._orders[at]
        if order.count <= 1:
            del self._orders[at]
        else:
            self._orders[at] = replace(order, count=order.count - 1)
        self.spoilt[order.kind] += 1
        match order.kind:
            case Kind.DROP:
                return []
            case Kind.DUPLICATE:
                return [frame, frame]
            case Kind.DELAY:
                self._late[way].append(frame._replace(stamp_ns=(frame.stamp_ns or now) + order.delay_ns))
                return []
            case Kind.CORRUPT:
                return [frame._replace(data=_altered(frame.data, order.byte, order.bits))]


def _altered(data: bytes, byte: int, bits: int) -> bytes:
    if not data:
        return data
    changed = bytearray(data)
    changed[byte % len(data)] ^= bits
    return bytes(changed)
