"""Emulated CiA 402 drives in a thread of the test, as the link of a CANopen master: no process, no bus, real time."""

import collections
import threading
import time
from collections.abc import Sequence

from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo.settings import BusSettings, DriveSettings
from hil_tests.lab.virtual.canopen_bus import DICTIONARY, QUICK
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid

HEARTBEAT_NS, STEP_S = 20_000_000, 0.002


class DrivesLink:
    """drivers.ports.can.cycle_bus.CycleLink with the drives on it; the next access raises `fail`."""

    def __init__(self, nodes: Sequence[int], gateway: int = 127) -> None:
        self._slave = Cia402Slave(BusSettings(8.0, 1, {}, {n: DriveSettings(QUICK) for n in nodes}), dict.fromkeys(nodes, DICTIONARY))
        self._slave.header()
        self._beat = Frame(cobid.heartbeat(gateway), b"\x05")
        self._in: collections.deque[Frame] = collections.deque()
        self._out: collections.deque[Frame] = collections.deque()
        self.fail: Exception | None = None
        self.released: set[int] = set()
        self.answered = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        beat = 0
        while not self._over.wait(STEP_S):
            now = time.monotonic_ns()
            frames = [self._in.popleft() for _ in range(len(self._in))]
            if now - beat > HEARTBEAT_NS:
                beat = now
                frames += [self._beat, Frame(cobid.SYNC)]
            self._slave.receive([frame._replace(stamp_ns=now) for frame in frames], now)
            self._slave.wake(now)
            self._slave.take_record()
            aside = [frame for frame in self._slave.take_output() if not 0x180 <= frame.identifier < 0x580]
            self._out += [frame._replace(stamp_ns=now) for frame in aside]
            self.answered += len(aside)

    def send(self, identifier: int, data: bytes) -> bool:
        self._in.append(Frame(identifier, data))
        return True

    def receive(self) -> list[Frame]:
        if self.fail is not None:
            failure, self.fail = self.fail, None
            raise failure
        return [self._out.popleft() for _ in range(len(self._out))]

    def left_out(self, identifier: int) -> int:
        return 0

    def release(self, node: int, mode: int) -> None:
        self.released.add(node)

    def hold(self, node: int) -> None:
        self.released.discard(node)

    def stop(self) -> None:
        self._over.set()
        self._thread.join(5.0)
