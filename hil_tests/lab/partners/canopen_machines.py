"""CANopen devices nobody of axisgate wrote, as machines of frames in virtual time: `canopen`'s LocalNode and a `durand` node.

Nothing of the two is replaced but the bus and the clock.
"""

import heapq
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import canopen
from canopen.network import PeriodicMessageTask
from durand import Node, Record, Variable, set_scheduler
from durand.datatypes import DatatypeEnum as DT
from durand.node import NodeCapabilities

from gateway.files.find import find_config
from protocols.base.machine import Ns

Pair = tuple[int, bytes]
NODE = 5


@dataclass(order=True)
class Timer:
    due: Ns
    order: int
    act: Callable[[], object] = field(compare=False)
    period: Ns = field(default=0, compare=False)
    stopped: bool = field(default=False, compare=False)


class FrameMachineBase:
    """Time, timers and output."""

    def __init__(self) -> None:
        self.now: Ns = 0
        self.said: list[Pair] = []
        self._timers: list[Timer] = []
        self._order = itertools.count()

    def later(self, delay: float, act: Callable[[], object], period: float = 0.0) -> Timer:
        timer = Timer(self.now + round(delay * 1e9), next(self._order), act, round(period * 1e9))
        heapq.heappush(self._timers, timer)
        return timer

    def wake(self, now: Ns) -> None:
        self.now = now
        while self._timers and self._timers[0].due <= now:
            timer = heapq.heappop(self._timers)
            if not timer.stopped:
                timer.act()
            if timer.period and not timer.stopped:
                timer.due += timer.period
                heapq.heappush(self._timers, timer)

    def deadline(self) -> Ns | None:
        return next((timer.due for timer in self._timers if not timer.stopped), None) if self._timers else None

    def take_output(self) -> list[Pair]:
        said, self.said = self.said, []
        return said

    def sent(self, now: Ns) -> None:
        """Nothing counts from here."""

    def lost(self, now: Ns) -> None:
        """It runs on."""


class _Periodic(PeriodicMessageTask):
    def __init__(self, timer: Timer, data: list[bytes]) -> None:
        self._timer, self._data = timer, data

    def stop(self) -> None:
        self._timer.stopped = True

    def update(self, data: Sequence[int]) -> None:
        self._data[0] = bytes(data)


class _Network(canopen.Network):
    def __init__(self, machine: FrameMachineBase) -> None:
        super().__init__()
        self._machine = machine

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self._machine.said.append((can_id, bytes(data)))

    def send_periodic(self, can_id: int, data: Sequence[int], period: float, remote: bool = False) -> _Periodic:
        held = [bytes(data)]
        return _Periodic(self._machine.later(period, lambda: self._machine.said.append((can_id, held[0])), period), held)


class LocalNodeMachine(FrameMachineBase):
    """`canopen.LocalNode` with the objects of a data sheet."""

    def __init__(self, node: int = NODE) -> None:
        super().__init__()
        self.network = _Network(self)
        self.node = canopen.LocalNode(node, str(find_config("axisgate_402.eds", "drives")))
        self.node.associate_network(self.network)
        self.node.nmt.send_command(0)
        self.node.nmt.send_command(128)

    def receive(self, frames: Sequence[Pair], now: Ns) -> None:
        self.wake(now)
        for identifier, data in frames:
            self.network.notify(identifier, bytearray(data), now / 1e9)


class _DurandNetwork:
    def __init__(self, machine: FrameMachineBase) -> None:
        self._machine = machine
        self.taken: dict[int, Callable[[int, bytes], None]] = {}

    def add_subscription(self, cob_id: int, callback: Callable[[int, bytes], None]) -> None:
        self.taken[cob_id] = callback

    def remove_subscription(self, cob_id: int) -> None:
        self.taken.pop(cob_id)

    def send(self, cob_id: int, msg: bytes) -> None:
        self._machine.said.append((cob_id, bytes(msg)))


class _NoLock:
    def __enter__(self) -> None: ...
    def __exit__(self, *_: object) -> None: ...


class _Scheduler:
    def __init__(self, machine: FrameMachineBase) -> None:
        self._machine = machine

    def add(
        self, delay: float, callback: Callable[..., object], args: tuple[object, ...] = (), kwargs: dict[str, object] | None = None
    ) -> Timer:
        return self._machine.later(delay, lambda: callback(*args, **(kwargs or {})))

    def cancel(self, entry: Timer) -> None:
        entry.stopped = True

    @property
    def lock(self) -> _NoLock:
        return _NoLock()


class DurandMachine(FrameMachineBase):
    """A `durand` node with a mappable object for its PDOs."""

    def __init__(self, node: int = NODE) -> None:
        super().__init__()
        set_scheduler(_Scheduler(self))
        self.network = _DurandNetwork(self)
        self.node = Node(self.network, node, capabilities=NodeCapabilities(1, 4, 4))
        dictionary = self.node.object_dictionary
        dictionary.write(0x1000, 0, 0x191, downloaded=False)
        for sub, value in ((1, 0x1234), (2, 0x402), (3, 1), (4, 99)):
            dictionary.write(0x1018, sub, value, downloaded=False)
        for index, kind in ((0x2000, DT.UNSIGNED16), (0x2001, DT.UNSIGNED32)):
            dictionary[index] = Variable(kind, "rw", 0, name=f"{index:04X}h")
        record = Record(name="Consumer heartbeat time")
        record[1] = Variable(DT.UNSIGNED32, "rw", 0, name="Consumer heartbeat time 1")
        dictionary[0x1016] = record
        self.node.tpdo[0].mapping = [(0x2000, 0), (0x2001, 0)]
        self.node.rpdo[0].mapping = [(0x2001, 0)]
        self.node.nmt.reset()

    def receive(self, frames: Sequence[Pair], now: Ns) -> None:
        self.wake(now)
        for identifier, data in frames:
            taker = self.network.taken.get(identifier)
            if taker is not None:
                taker(identifier, data)
