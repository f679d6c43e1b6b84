"""The python-can plug-in `cycle:`: a drive bus, seen from the services, while the cycle owns it.

On a drive bus only the cycle transmits.  Frames sent here go into the cycle's ring and leave with one of its next bursts (AX-301); received
are the frames that the cycle set aside (SDO, EMCY, heartbeat).  SYNC, PDOs and the gateway's heartbeat are refused: only a completed cycle
sends them.  The process that has the ring creates the links (`attach`).
"""

import threading
import time
from collections.abc import Mapping
from typing import Any, Protocol

import can

from protocols.base.machine import Frame

BUSY_S, IDLE_S, BUSY_FOR_S = 0.001, 0.010, 0.2  # how often the ring is looked at: quickly for a while after something was sent
SYNC, PDO_FIRST, PDO_LAST, HEARTBEATS = 0x080, 0x180, 0x57F, 0x700


class CycleLink(Protocol):
    """One bus in the ring."""

    def send(self, identifier: int, data: bytes) -> bool: ...  # False: the ring's bus is not there
    def receive(self) -> list[Frame]: ...  # everything that waits


_links: dict[str, CycleLink] = {}
_lock = threading.Lock()


def attach(channel: str, link: CycleLink) -> None:
    """From now on `can.Bus(interface="cycle", channel=...)` works in this process."""
    with _lock:
        _links[channel] = link


def detach(channel: str) -> None:
    """The link is lost."""
    with _lock:
        _links.pop(channel, None)


def links() -> Mapping[str, CycleLink]:
    """The attached links."""
    return dict(_links)


class CycleBus(can.BusABC):
    """python-can on the cycle's ring."""

    def __init__(self, channel: str, can_filters: can.typechecking.CanFilters | None = None, **kwargs: Any) -> None:
        link = _links.get(channel)
        if link is None:
            there = ", ".join(_links) or "none"
            raise can.CanInitializationError(f"cycle:{channel}: no such link in this process; there is {there}")
        self._link = link
        self._waiting: list[Frame] = []
        self._busy_until = 0.0
        self._can_protocol = can.CanProtocol.CAN_20
        self.channel_info = f"cycle:{channel}"
        super().__init__(channel=channel, can_filters=can_filters, **kwargs)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """CanOperationError for frames that only the cycle may send, and for frames that classic CAN with 11 bits lacks."""
        identifier = msg.arbitration_id
        if msg.is_extended_id or msg.is_remote_frame or msg.is_fd or msg.dlc > 8:
            raise can.CanOperationError(f"{self.channel_info}: 11-bit data frames only, not {msg}")
        if identifier == SYNC or PDO_FIRST <= identifier <= PDO_LAST or identifier & 0x780 == HEARTBEATS:
            raise can.CanOperationError(f"{self.channel_info}: {identifier:#05x} leaves from a completed cycle only")
        if not self._link.send(identifier, bytes(msg.data)):
            raise can.CanOperationError(f"{self.channel_info}: the cycle accepts no frames")
        self._busy_until = time.monotonic() + BUSY_FOR_S

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        end = None if timeout is None else time.monotonic() + timeout
        while not self._waiting:
            self._waiting = self._link.receive()[::-1]
            now = time.monotonic()
            if self._waiting or (end is not None and now >= end):
                break
            pause = BUSY_S if now < self._busy_until else IDLE_S
            time.sleep(pause if end is None else min(pause, max(0.0, end - now)))
        if not self._waiting:
            return None, False
        frame = self._waiting.pop()
        message = can.Message(
            timestamp=frame.stamp_ns / 1e9,
            arbitration_id=frame.identifier,
            is_extended_id=False,
            data=frame.data,
            channel=self._channel_name,
        )
        return message, False

    @property
    def _channel_name(self) -> str:
        return self.channel_info.partition(":")[2]
