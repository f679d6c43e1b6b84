"""The integrated PLC as the services know it: its region and rings, joined with the Reis control (AX-900)."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.controllers.reis.integrated import IntegratedPlc
from gateway.pure.image.records.interpreter import TEXT_LAYOUT, pack_facts, unpack_facts
from gateway.pure.image.records.plc import PLC_LAYOUT, ROBOT_LAYOUT, RobotSide, pack_robot, unpack_plc
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter
from protocols.base.machine import ms

SPARE_MS = 100  # of a PLC process beyond the longest scan its watchdog allows
TAKEN = 64


@dataclass(slots=True)
class _Seen:
    index: int = -1
    robot: bytes = b""


class PlcHost:
    """Rings and regions of the PLC process."""

    def __init__(self, control: ReisControl, fds: Mapping[str, int], watchdog: int) -> None:
        """`watchdog`: longest scan in 1/100 s."""
        self._control = control
        self._silent_ns = ms(10 * watchdog + SPARE_MS)
        self.plc = control.plc = IntegratedPlc()
        self._region = RegionReader(fds["plc"], "plc", PLC_LAYOUT)
        self._robot = RegionWriter(fds["plc-robot"], "plc-robot", ROBOT_LAYOUT)
        self._orders = RingWriter(fds["plc-orders"], "plc-orders", TEXT_LAYOUT)
        self._says = RingReader(fds["plc-says"], "plc-says", TEXT_LAYOUT)
        self._seen = _Seen()

    def before(self) -> None:
        """Before a cycle of the control: the PLC after its last period, and its messages."""
        payload = self._region.read()
        alive = time.monotonic_ns() - self._region.life[1] < self._silent_ns
        if payload is not None and (self._region.index != self._seen.index or alive != self.plc.alive):
            self._seen.index = self._region.index
            self.plc.take(unpack_plc(payload), alive=alive)
        for _, data in self._says.take(TAKEN):
            self.plc.hear(unpack_facts(data))

    def after(self, *, drives: bool) -> list[str]:
        """Behind it: the robot's markers, orders; what a person should read."""
        robot = pack_robot(RobotSide(drives, self._control.markers.own()))
        if robot != self._seen.robot:
            self._seen.robot = robot
            self._robot.write(robot, time.monotonic_ns())
        self.flush()
        told, self.plc.told = self.plc.told, []
        return told

    def order(self, request: dict[str, object]) -> dict[str, object]:
        """`do`: status, start (`name`, empty: the start program of the cell), stop, ack."""
        match request.get("do"):
            case "status":
                return self.plc.status()
            case "start":
                self.plc.orders.append({"do": "start", "name": str(request.get("name", ""))})
            case "stop":
                self.plc.orders.append({"do": "stop"})
            case "ack":
                self.plc.acknowledge()
            case other:
                return {"error": f"do {other!r}; status, start, stop, ack are known"}
        self.flush()
        return {"ok": True}

    def flush(self) -> None:
        """Orders that wait."""
        orders, self.plc.orders = self.plc.orders, []
        for order in orders:
            self._orders.put(pack_facts(order))
