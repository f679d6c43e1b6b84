"""SERVODYN boosters and CiA 402 drives on one bus: two FrameMachines with the interface of one."""

from collections.abc import Sequence

from drivers.emulator.cia402 import seat as cia402_seat
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servodyn import slave as servodyn_slave
from drivers.emulator.servodyn.slave import ServodynSlave
from protocols.base.machine import Frame, FrameFault, Ns

Event = servodyn_slave.Event | cia402_seat.Event


class BothFamilies:
    """Every frame reaches both; each keeps its own record."""

    def __init__(self, servodyn: ServodynSlave, cia402: Cia402Slave) -> None:
        self.servodyn, self.cia402 = servodyn, cia402
        self.grace_ns = max(servodyn.grace_ns, cia402.grace_ns)

    def receive(self, frames: Sequence[Frame], now: Ns) -> list[Event]:
        return [*self.servodyn.receive(frames, now), *self.cia402.receive(frames, now)]

    def error_frame(self, kind: FrameFault, now: Ns) -> list[Event]:
        return [*self.servodyn.error_frame(kind, now), *self.cia402.error_frame(kind, now)]

    def sent(self, now: Ns) -> list[Event]:
        return [*self.servodyn.sent(now), *self.cia402.sent(now)]

    def wake(self, now: Ns) -> list[Event]:
        return [*self.servodyn.wake(now), *self.cia402.wake(now)]

    def deadline(self) -> Ns | None:
        dues = [due for due in (self.servodyn.deadline(), self.cia402.deadline()) if due is not None]
        return min(dues, default=None)

    def take_output(self) -> list[Frame]:
        return self.servodyn.take_output() + self.cia402.take_output()

    def lost(self, now: Ns) -> list[Event]:
        return [*self.servodyn.lost(now), *self.cia402.lost(now)]

    def prepare(self) -> None:
        self.servodyn.prepare()
        self.cia402.prepare()
