"""The local bus: a client port of the broker.  (The python-can plug-in is drivers.ports.can.broker_bus: the cycle must not load it.)

Source: docs/architecture.md, "Buses and lines without hardware"; AX-092 (records), AX-093 (queues and gaps).
"""

import json
import os
import socket
from collections.abc import Sequence
from typing import Any

from drivers.ports.base import PortError, runtime_dir
from drivers.ports.can.wire import (
    CONTROL,
    COUNT,
    EFF_FLAG,
    ERR_FLAG,
    RECORD,
    RECORD_BYTES,
    CanCounters,
    Control,
    control_record,
    fault_of,
    pack_records,
)
from protocols.base.machine import Frame, FrameFault, Ns

RECEIVE_BYTES = 65536  # one message; a statistics answer is the longest
BURST = 256  # messages one receive() reads at most, so that a flood cannot hold the caller
SEND_BUFFER = 1 << 17  # the kernel doubles it; full messages in it are fewer frames than a subscriber's queue holds
Record = tuple[int, int, int, bytes, int, int]  # id and flags, length, sender, data, stamp ns, sequence


def socket_path(name: str) -> str:
    """Where the broker of this name listens; PortError when a socket address cannot hold it (108 bytes, unix(7))."""
    path = str(runtime_dir() / f"broker-{name}.sock")
    if len(os.fsencode(path)) > 107:
        raise PortError(f"{path}: longer than the 107 bytes of a socket address; set AXISGATE_RUNTIME to a shorter folder")
    return path


def _connect(name: str) -> socket.socket:
    path = socket_path(name)
    link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET | socket.SOCK_NONBLOCK)
    link.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
    try:
        link.connect(path)
    except OSError as error:
        link.close()
        raise PortError(f"broker:{name}: {error.strerror}; start it with: python -m gateway.simulation.bus.broker --name {name}") from error
    return link


class Link:
    """One connection to a broker: records out, records in, gaps counted."""

    def __init__(self, name: str) -> None:
        self.name = f"broker:{name}"
        self.socket = _connect(name)
        self.counters = CanCounters()
        self.broker_start_ns: Ns | None = None
        self._buffer = memoryview(bytearray(RECEIVE_BYTES))  # one for all messages: allocating it costs more than reading
        self._next: int | None = None  # sequence number the next foreign frame has at least

    def send(self, messages: Sequence[bytes]) -> int:
        """Number of records accepted, in order; fewer than passed: the output to the broker is full, counted as refused."""
        taken, given = 0, sum(map(len, messages)) // RECORD_BYTES
        for message in messages:
            try:
                self.socket.send(message)
            except BlockingIOError:
                break
            except OSError as error:
                raise PortError(f"{self.name}: {error.strerror}; the broker has ended, open the port again") from error
            taken += len(message) // RECORD_BYTES
        self.counters.sent += taken
        self.counters.refused += given - taken
        return taken

    def receive(self, messages: int = BURST) -> list[Record]:
        """Frame records that wait; PortError when the broker closed us (it died, or we were too slow for its queue)."""
        records: list[Record] = []
        for _ in range(messages):
            try:
                size = self.socket.recv_into(self._buffer)
            except BlockingIOError:
                break
            except OSError as error:
                return self._ended(records, error.strerror or str(error))
            if not size:
                return self._ended(records, "connection closed")
            records += self.records_in(self._buffer[:size])
        return records

    def records_in(self, message: bytes | memoryview) -> list[Record]:
        """Records of one message."""
        records: list[Record] = []
        if len(message) % RECORD_BYTES:
            self.counters.ignored += 1
            return records
        for record in RECORD.iter_unpack(message):
            if record[0] < CONTROL:
                records.append(record)
            elif record[0] == CONTROL | Control.GAP:
                self._gap(record)
            else:
                break  # an answer to statistics: its text follows, not for us
        self.counters.received += len(records)
        return records

    def _ended(self, records: list[Record], why: str) -> list[Record]:
        """Return what came before the end first; report the end at the next call."""
        if records:
            return records
        raise PortError(f"{self.name}: {why}; the broker ended or disconnected this subscriber as too slow, open the port again")

    def _gap(self, record: Record) -> None:
        start = COUNT.unpack(record[3])[0]
        if self._next is not None and start == self.broker_start_ns:
            self.counters.gaps += max(0, record[5] - self._next)
        self.broker_start_ns = start

    def seen(self, sequence: int) -> None:
        """The last sequence number that reached the user: a later connection computes from it what it missed."""
        self._next = sequence + 1

    def reconnect(self) -> None:
        """A new connection in place of the old one; PortError when no broker listens."""
        fresh = _connect(self.name.removeprefix("broker:"))
        self.socket.close()
        self.socket = fresh


class BrokerPort:
    """CanPort of the local bus.  Own frames are not received; extended and remote frames are ignored and counted.

    After a PortError open a new port, or `reconnect()` this one: then the broker's gap record counts what was missed in between
    (`counters.gaps`; own frames that were not returned count too, and nothing is known across a restart of the broker).
    """

    not_data = CONTROL  # flags of frames that receive() leaves out; see drivers.ports.can.remote_frames

    def __init__(self, name: str) -> None:
        self.name = f"broker:{name}"
        self._link = Link(name)
        self._faults: list[tuple[FrameFault, Ns]] = []
        self.counters = self._link.counters

    def fileno(self) -> int:
        return self._link.socket.fileno()

    def send(self, frames: Sequence[Frame]) -> int:
        """Number of frames accepted, in order, at most 64 in one message; ValueError on a frame impossible in CAN."""
        return self._link.send(pack_records(frames))

    def receive(self) -> list[Frame]:
        """Everything that waits, stamped by the broker."""
        return self._frames(self._link.receive())

    def receive_next(self) -> list[Frame]:
        """One message of the broker: at most 64 frames."""
        return self._frames(self._link.receive(1))

    def send_message(self, message: bytes) -> int:
        """Records packed elsewhere: number accepted, all or none."""
        return self._link.send((message,))

    def frames_in(self, message: bytes) -> list[Frame]:
        """The frames of a message that was read from the socket elsewhere, as receive() would return them."""
        return self._frames(self._link.records_in(message))

    def _frames(self, records: list[Record]) -> list[Frame]:
        frames: list[Frame] = []
        make, not_data = tuple.__new__, self.not_data
        for can_id, length, _, data, stamp, _ in records:
            if can_id < EFF_FLAG and not can_id & not_data:
                frames.append(make(Frame, (can_id, data[:length], stamp)))
            elif can_id & ERR_FLAG:
                self.counters.faults += 1
                self._faults.append((fault_of(can_id, data[:length]), stamp))
            else:
                self.counters.ignored += 1
        if records:
            self._link.seen(records[-1][5])
        return frames

    def take_faults(self) -> list[tuple[FrameFault, Ns]]:
        """Error frames since the last call, with their stamps; call it after receive()."""
        faults, self._faults = self._faults, []
        return faults

    def reconnect(self) -> None:
        """Connect again after a PortError; PortError when no broker listens."""
        self._link.reconnect()

    def close(self) -> None:
        self._link.socket.close()


def broker_stats(name: str, timeout_s: float = 2.0) -> dict[str, Any]:
    """Counters of a running broker (its JSON answer); a tool's call that waits, PortError after `timeout_s`."""
    with _connect(name) as link:
        link.settimeout(timeout_s)
        try:
            link.send(control_record(Control.STATS, b""))
            while True:
                message = link.recv(RECEIVE_BYTES)
                if not message:
                    raise PortError(f"broker:{name}: closed before it answered")
                head = RECORD.unpack(message[:RECORD_BYTES])
                if head[0] == CONTROL | Control.STATS_REPLY:
                    size = COUNT.unpack(head[3])[0]
                    answer: dict[str, Any] = json.loads(message[RECORD_BYTES : RECORD_BYTES + size])
                    return answer
        except OSError as error:
            raise PortError(f"broker:{name}: no statistics: {error}") from error
