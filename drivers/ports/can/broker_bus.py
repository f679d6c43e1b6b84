"""The python-can plug-in of the local bus: `can.Bus(interface="broker", channel=NAME)`."""

import os
import select
import time
from collections import deque
from typing import Any

import can

from drivers.ports.base import PortError
from drivers.ports.can.broker import Link, Record
from drivers.ports.can.wire import EFF_FLAG, ERR_FLAG, MAX_DATA, RECORD, RTR_FLAG


class BrokerBus(can.BusABC):
    """python-can on the local bus: `can.Bus(interface="broker", channel=NAME)`, also with Notifier (thread or asyncio).

    `Message.timestamp` is the bus stamp in seconds of the monotonic clock.  Own messages are not received.
    """

    def __init__(self, channel: str, can_filters: can.typechecking.CanFilters | None = None, **kwargs: Any) -> None:
        if kwargs.pop("receive_own_messages", False):
            raise can.CanInitializationError(f"broker:{channel}: a subscriber does not hear its own messages; open a second bus")
        self._can_protocol = can.CanProtocol.CAN_20
        self.channel_info = f"broker:{channel}"
        self._channel = channel
        self._waiting: deque[can.Message] = deque()
        try:
            self._link = Link(channel)
        except PortError as error:
            raise can.CanInitializationError(str(error)) from error
        # readable while the socket has data or messages of a batch wait here: an asyncio Notifier reads one per event
        self._more = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._epoll = select.epoll()
        self._epoll.register(self._link.socket, select.EPOLLIN)
        self._epoll.register(self._more, select.EPOLLIN)
        super().__init__(channel=channel, can_filters=can_filters, **kwargs)

    def fileno(self) -> int:
        return self._epoll.fileno()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """CanOperationError when the output to the broker is full for `timeout` seconds (None: at once) or the broker is gone."""
        if msg.is_fd or msg.dlc > MAX_DATA:
            raise can.CanOperationError(f"{self.channel_info}: classic CAN only, {MAX_DATA} bytes")
        flags = (EFF_FLAG if msg.is_extended_id else 0) | (RTR_FLAG if msg.is_remote_frame else 0)
        flags = ERR_FLAG if msg.is_error_frame else flags
        record = RECORD.pack(msg.arbitration_id | flags, msg.dlc, 0, bytes(msg.data), 0, 0)
        end = time.monotonic() + (timeout or 0)
        try:
            while not self._link.send([record]):
                left = end - time.monotonic()
                if left <= 0:
                    raise can.CanOperationError(f"{self.channel_info}: full, {self._link.counters.refused} refused so far")
                select.select([], [self._link.socket], [], left)
        except PortError as error:
            raise can.CanOperationError(str(error)) from error

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._waiting:
            self._fetch(timeout)
        message = self._waiting.popleft() if self._waiting else None
        if not self._waiting:
            self._mark(False)
        return message, False

    def _fetch(self, timeout: float | None) -> None:
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            try:
                records = self._link.receive()
            except PortError as error:
                raise can.CanOperationError(str(error)) from error
            self._waiting.extend(self._message(record) for record in records)
            left = None if end is None else end - time.monotonic()
            if self._waiting or (left is not None and left <= 0):
                self._mark(bool(self._waiting))
                return
            select.select([self._link.socket], [], [], left)

    def _mark(self, waiting: bool) -> None:
        try:
            if waiting:
                os.eventfd_write(self._more, 1)
            else:
                os.eventfd_read(self._more)
        except BlockingIOError:
            pass  # was not set

    def _message(self, record: Record) -> can.Message:
        can_id, length, _, data, stamp, _ = record
        return can.Message(
            timestamp=stamp / 1e9,
            arbitration_id=can_id & 0x1FFFFFFF,
            is_extended_id=bool(can_id & EFF_FLAG),
            is_remote_frame=bool(can_id & RTR_FLAG),
            is_error_frame=bool(can_id & ERR_FLAG),
            dlc=length,
            data=None if can_id & RTR_FLAG else data[:length],
            channel=self._channel,
            is_rx=True,
        )

    def shutdown(self) -> None:
        super().shutdown()
        if not self._epoll.closed:
            self._epoll.close()
            os.close(self._more)
            self._link.socket.close()
