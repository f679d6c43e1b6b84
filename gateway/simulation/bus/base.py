"""A local bus without a process: its clients, and one round of their common loop.

Source: docs/architecture.md, "Buses and lines without hardware"; AX-092 (records), AX-093 (queues, gaps, refusals), AX-095 (log).
Read the senders until they have no more, stamp the records, pass each subscriber one batch.  Nothing here waits for a client.
"""

import collections
import contextlib
import json
import os
import select
import socket
import struct
import sys
import time

from drivers.ports.can.wire import (
    CONTROL,
    COUNT,
    MAX_DATA,
    MAX_MESSAGE,
    MAX_RECORDS,
    RECORD,
    RECORD_BYTES,
    Control,
    control_record,
    text_record,
)
from gateway.runtime.life import BEAT_S
from gateway.simulation.bus.log import LogPipe

QUEUE_FRAMES = 16_384  # of one subscriber: 1.8 s of a full 1 Mbit/s bus (9009 frames/s)
MESSAGES_PER_TURN = 64  # read from one sender before the others get their turn
SEND_BUFFER = 1 << 18
UCRED = struct.Struct("=iII")  # pid, uid, gid: unix(7), SO_PEERCRED


class Client:
    """A sender and subscriber: its socket, and its waiting messages."""

    def __init__(self, link: socket.socket, number: int) -> None:
        self.link = link
        self.number = number  # 1..255, in every record it sends
        self.pid = UCRED.unpack(link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, UCRED.size))[0]
        self.queue: collections.deque[bytes] = collections.deque()
        self.queued = 0  # frames in the queue
        self.sent = 0
        self.received = 0  # frames it gave us
        self.deaf = False  # its receiving end is gone; frames it sends are still accepted

    def offer(self, message: bytes) -> bool:
        """Send or queue one message; True when the queue was empty before and is not now."""
        if self.deaf:
            return False
        if not self.queue and self._send(message):
            return False
        self.queue.append(message)
        self.queued += len(message) // RECORD_BYTES
        return len(self.queue) == 1

    def flush(self) -> bool:
        """Send the waiting messages, small ones joined to full ones; True when nothing waits any more."""
        while self.queue:
            batch = self._batch()
            if not self._send(batch):
                self.queue.appendleft(batch)
                self.queued += len(batch) // RECORD_BYTES
                return False
        return True

    def _batch(self) -> bytes:
        parts: list[bytes] = []
        size = 0
        while self.queue and (not parts or size + len(self.queue[0]) <= MAX_MESSAGE):
            parts.append(self.queue.popleft())
            size += len(parts[-1])
        self.queued -= size // RECORD_BYTES
        return b"".join(parts)

    def _send(self, message: bytes) -> bool:
        """True: the frame need not be kept (accepted, or there is no receiver)."""
        try:
            self.link.send(message)
        except BlockingIOError:
            return False
        except OSError:
            self.deaf = True
            self.queue.clear()
            self.queued = 0
            return True
        self.sent += len(message) // RECORD_BYTES
        return True


class Broker:
    """All clients of one bus; `turn()` is one round of the loop."""

    def __init__(self, name: str, listener: socket.socket, log: LogPipe | None, queue_frames: int = QUEUE_FRAMES) -> None:
        self.name, self._listener, self._log, self._limit = name, listener, log, queue_frames
        self._clients: dict[int, Client] = {}
        self._numbers = 0
        self._sequence = 0
        self._start_ns = time.monotonic_ns()
        self._out: list[tuple[Client, bytes, int]] = []  # read in this turn: sender, records, how many
        self.counters = {"frames": 0, "malformed": 0, "overflows": 0, "overflow_frames": 0, "connects": 0, "disconnects": 0}
        self._epoll = select.epoll()
        self._epoll.register(listener, select.EPOLLIN)

    def register(self, fd: int) -> None:
        """Another descriptor that ends the wait of a turn (signals); the owner reads it."""
        self._epoll.register(fd, select.EPOLLIN)

    def turn(self) -> None:
        """Wait for something to do, then do all of it once."""
        timeout = BEAT_S if self._log is None or not self._log.waiting() else 0.05
        for fd, events in self._epoll.poll(timeout):
            client = self._clients.get(fd)
            if client is not None:
                if events & select.EPOLLOUT and client.flush():
                    self._watch(client, writable=False)
                if events & ~select.EPOLLOUT:
                    self._take(client)
            elif fd == self._listener.fileno():
                self._accept()
        self._pump()
        if self._out:
            self._distribute()
        elif self._log is not None:
            self._log.flush()

    def _accept(self) -> None:
        while True:
            try:
                link, _ = self._listener.accept()
            except OSError:  # none waiting, or out of descriptors: the listener's queue keeps them
                return
            link.setblocking(False)
            link.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
            self._numbers = self._numbers % 255 + 1
            client = Client(link, self._numbers)
            self._clients[link.fileno()] = client
            self._epoll.register(link, select.EPOLLIN)
            self.counters["connects"] += 1
            client.offer(control_record(Control.GAP, COUNT.pack(self._start_ns), self._sequence + 1, time.monotonic_ns()))
            self._note(f"client {client.number} connected, pid {client.pid}")

    def _take(self, client: Client) -> None:
        """Everything this sender has, up to its share of the turn; the rest stays readable for the next."""
        for _ in range(MESSAGES_PER_TURN):
            try:
                message = client.link.recv(MAX_MESSAGE + 1)
            except BlockingIOError:
                return
            except ConnectionResetError:
                continue  # it closed without reading our last messages; those it sent before still wait
            except OSError as error:
                return self._drop(client, error.strerror or str(error))
            if not message:
                return self._drop(client, "closed")
            if len(message) % RECORD_BYTES or len(message) > MAX_MESSAGE:
                self.counters["malformed"] += 1
                continue
            self._stamp(client, message)

    def _stamp(self, client: Client, message: bytes) -> None:
        """Frames of one message get the same stamp and rising sequence numbers."""
        stamp, pack, number, sequence = time.monotonic_ns(), RECORD.pack, client.number, self._sequence
        records = []
        for can_id, length, _, data, _, _ in RECORD.iter_unpack(message):
            if can_id >= CONTROL:
                self._control(client, can_id)
            elif length > MAX_DATA:
                self.counters["malformed"] += 1
            else:
                sequence += 1
                records.append(pack(can_id, length, number, data, stamp, sequence))
        if records:
            self._sequence = sequence
            client.received += len(records)
            self.counters["frames"] += len(records)
            self._out.append((client, b"".join(records), len(records)))

    def _pump(self) -> None:
        """Frames that a bus with a modelled pace delivers now (gateway.simulation.bus.wired_broker); this one delays none."""

    def _distribute(self) -> None:
        out, self._out = self._out, []
        for client in list(self._clients.values()):
            for message in _batches([(records, count) for sender, records, count in out if sender is not client]):
                if client.offer(message):
                    self._watch(client, writable=True)
            if client.queued > self._limit:
                self._overflow(client)
        if self._log is not None:
            for _, records, _ in out:
                self._log.put(records)

    def _overflow(self, client: Client) -> None:
        self.counters["overflows"] += 1
        self.counters["overflow_frames"] += client.queued
        self._drop(client, f"too slow: {client.queued} frames waited (limit {self._limit}), disconnected")

    def _drop(self, client: Client, why: str) -> None:
        if self._clients.pop(client.link.fileno(), None) is None:
            return
        self._epoll.unregister(client.link)
        client.link.close()
        self.counters["disconnects"] += 1
        self._note(f"client {client.number} {why}, pid {client.pid}; gave {client.received} frames, took {client.sent}")

    def _watch(self, client: Client, writable: bool) -> None:
        self._epoll.modify(client.link, select.EPOLLIN | (select.EPOLLOUT if writable else 0))

    def _control(self, client: Client, can_id: int) -> None:
        if can_id == CONTROL | Control.STATS:
            if client.offer(text_record(Control.STATS_REPLY, json.dumps(self.stats()).encode())):
                self._watch(client, writable=True)
        else:
            self.counters["malformed"] += 1

    def stats(self) -> dict[str, object]:
        """All counters; clients as a list."""
        clients = [
            {"number": c.number, "pid": c.pid, "gave": c.received, "took": c.sent, "queued": c.queued}
            for c in list(self._clients.values())[:500]
        ]
        return {
            "name": self.name,
            "pid": os.getpid(),
            **self.counters,
            "log_lost": self._log.lost if self._log else 0,
            "clients": clients,
        }

    def _note(self, text: str) -> None:
        if self._log is not None:
            self._log.note(text)

    def note_stats(self) -> None:
        """Counters to standard error and into the log (SIGUSR1)."""
        text = json.dumps(self.stats())
        with contextlib.suppress(OSError):
            print(text, file=sys.stderr, flush=True)
        self._note(text)

    def close(self) -> None:
        for client in list(self._clients.values()):
            self._drop(client, "still connected at the end")
        self._epoll.close()
        if self._log is not None:
            self._log.close()


def _batches(parts: list[tuple[bytes, int]]) -> list[bytes]:
    """Messages of at most 64 records from one turn's frames, in order."""
    if len(parts) <= 1:
        return [records for records, _ in parts]
    messages: list[bytes] = []
    open_parts: list[bytes] = []
    count = 0
    for records, n in parts:
        if count + n > MAX_RECORDS:
            messages.append(b"".join(open_parts))
            open_parts, count = [], 0
        open_parts.append(records)
        count += n
    return [*messages, b"".join(open_parts)]
