"""The local bus with a modelled wire: frames take their bits' time, the lowest identifier goes first, stamps are those of the wire.

python -m gateway.simulation.bus.broker --name NAME --bitrate 1000000.  A frame is delivered when its last EOF bit has passed on the
modelled wire (AX-331); the broker itself acknowledges, so a sender is never alone.  Remote, extended and error frames pass at once, outside
the model.
"""

import socket
import sys
import time

from drivers.emulator.wire.cable import Carried, Wire
from drivers.ports.can.wire import CONTROL, MAX_DATA, MAX_ID, RECORD
from drivers.ports.timerfd import Timer
from gateway.simulation.bus.base import Broker, Client
from gateway.simulation.bus.log import LogPipe
from protocols.base.machine import Frame, Ns, ms

FULL = ms(10)  # backlog: more than any cycle has
SAY_AGAIN = ms(1000)
MOST_WAITING = 16_384  # frames of one sender: 1.8 s of a full bus


class WiredBroker(Broker):
    """See the module; everything else is the broker's."""

    def __init__(self, name: str, listener: socket.socket, log: LogPipe | None, queue_frames: int, bitrate: int) -> None:
        """ValueError: a bit is not an integer number of nanoseconds."""
        self._wire = Wire(bitrate)
        super().__init__(name, listener, log, queue_frames)
        self._wire.attach("broker")
        self._nodes: dict[int, int] = {}  # client number -> node
        self._owners: dict[int, Client] = {}  # node -> client
        self._free: list[int] = []  # nodes of clients that left
        self._timer = Timer()
        self.register(self._timer.fileno())
        self._said: Ns = -SAY_AGAIN

    def _stamp(self, client: Client, message: bytes) -> None:
        now = time.monotonic_ns()
        past = []
        for can_id, length, _, data, _, _ in RECORD.iter_unpack(message):
            if can_id >= CONTROL:
                self._control(client, can_id)
            elif length > MAX_DATA:
                self.counters["malformed"] += 1
            elif can_id > MAX_ID:
                past.append(self._record(client, can_id, data[:length], now))
            else:
                self._wire.offer(self._node(client), Frame(can_id, data[:length]), now)
                client.received += 1
                self.counters["frames"] += 1
        if past:
            client.received += len(past)
            self.counters["frames"] += len(past)
            self._out.append((client, b"".join(past), len(past)))
        if len(self._wire.nodes[self._node(client)].queue) > MOST_WAITING:
            self._overflow(client)

    def _pump(self) -> None:
        now = time.monotonic_ns()
        for event in self._wire.advance(now):
            if isinstance(event, Carried):
                owner = self._owners[event.node]
                self._out.append((owner, self._record(owner, event.frame.identifier, event.frame.data, event.end_ns), 1))
        if self._wire.backlog_ns(now) > FULL and now - self._said > SAY_AGAIN:
            self._said = now
            text = f"broker:{self.name}: the modelled bus is full: {self._wire.backlog_ns(now) / 1e6:.1f} ms of frames wait"
            print(text, file=sys.stderr, flush=True)
            self._note(text)
        due = self._wire.next_end()
        if due is None:
            self._timer.clear()
        else:
            self._timer.arm(due)

    def stats(self) -> dict[str, object]:
        """The wire's own figures in addition to the broker's."""
        load = self._wire.load
        wire = {"bits": load.bits, "busy_ns": load.busy_ns, "longest_wait_ns": load.longest_wait_ns, "errors": load.errors}
        return {**super().stats(), "wire": wire}

    def close(self) -> None:
        super().close()
        self._timer.close()

    def _record(self, client: Client, can_id: int, data: bytes, stamp: Ns) -> bytes:
        self._sequence += 1
        return RECORD.pack(can_id, len(data), client.number, data, stamp, self._sequence)

    def _node(self, client: Client) -> int:
        if client.number not in self._nodes or self._owners[self._nodes[client.number]] is not client:
            node = self._free.pop() if self._free else self._wire.attach(f"client {client.number}")
            self._nodes[client.number] = node
            self._owners[node] = client
        return self._nodes[client.number]

    def _drop(self, client: Client, why: str) -> None:
        """Its unsent frames are lost with it."""
        super()._drop(client, why)
        node = self._nodes.get(client.number)
        if node is not None and self._owners[node] is client:
            self._wire.nodes[node].queue.clear()
            self._free.append(self._nodes.pop(client.number))
