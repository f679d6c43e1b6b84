"""The integrated PLC as the services know it: its region and rings, joined with the Reis control (AX-900)."""

import time
from collections.abc import Mapping
from dataclasses import astuple, dataclass

from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.controllers.reis.integrated import IntegratedPlc
from gateway.pure.controllers.reis.marker_operand import MarkerFault, marker_of
from gateway.pure.image.records.interpreter import TEXT_LAYOUT, pack_facts, unpack_facts
from gateway.pure.image.records.plc import (
    PLC_LAYOUT,
    ROBOT_LAYOUT,
    SHOWN_LAYOUT,
    RobotSide,
    pack_robot,
    steps_of,
    unpack_plc,
    unpack_shown,
)
from gateway.runtime.process_end import ProcessEnd
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter
from protocols.base.machine import ms

SPARE_MS = 100  # of a PLC process beyond the longest scan its watchdog allows
TAKEN = 64
LOOKS_NS = ms(3_000)  # a test display that is not read for so long is switched off
MOST_ROWS = 500  # of it in an answer


@dataclass(slots=True)
class _Seen:
    index: int = -1
    last: int = -1  # report of a process that has ended; only a report of its successor counts
    robot: bytes = b""
    watched: str = ""  # program of the test display
    looked_ns: int = 0


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
        self._shown = RegionReader(fds["plc-shown"], "plc-shown", SHOWN_LAYOUT)
        self._seen = _Seen()
        self._end = ProcessEnd()

    def before(self) -> None:
        """Before a cycle of the control: the PLC after its last period, and its messages."""
        payload = self._region.read()
        if self._end.of(self._region.writer_pid):
            self._seen.last = self._region.index
        silent = time.monotonic_ns() - self._region.life[1] >= self._silent_ns
        alive = not silent and self._region.index != self._seen.last
        if payload is not None and (self._region.index != self._seen.index or alive != self.plc.alive):
            self._seen.index = self._region.index
            self.plc.take(unpack_plc(payload), alive=alive)
        for _, data in self._says.take(TAKEN):
            self.plc.hear(unpack_facts(data))

    def after(self, *, drives: bool) -> list[str]:
        """After it: the robot's markers, orders; report to the operator."""
        robot = pack_robot(RobotSide(drives, self._control.markers.own()))
        if robot != self._seen.robot:
            self._seen.robot = robot
            self._robot.write(robot, time.monotonic_ns())
        if self._seen.watched and time.monotonic_ns() - self._seen.looked_ns > LOOKS_NS:
            self._watch("")
        self.flush()
        sentences, self.plc.sentences = self.plc.sentences, []
        return sentences

    def order(self, request: dict[str, object]) -> dict[str, object]:
        """`do`: status, show (`name`: a program, `first`: a step), start (`name`, empty: the start program of the cell), stop, ack, write
        (`operand`: M10.0, M10, MD10; `value`)."""
        match request.get("do"):
            case "status":
                return self.plc.status()
            case "show":
                return self._show(str(request.get("name", "")).strip().upper(), int(str(request.get("first", 1))))
            case "start":
                self.plc.orders.append({"do": "start", "name": str(request.get("name", ""))})
            case "stop":
                self.plc.orders.append({"do": "stop"})
            case "ack":
                self.plc.acknowledge()
            case "write":
                return self._write(request)
            case other:
                return {"error": f"do {other!r}; status, show, start, stop, ack, write are known"}
        self.flush()
        return {"ok": True}

    def _write(self, request: dict[str, object]) -> dict[str, object]:
        """A marker by hand, between two scans."""
        operand, value = str(request.get("operand", "")), str(request.get("value", ""))
        try:
            marker = marker_of(operand)
            self.plc.set_marker(marker, marker.number(value))
        except MarkerFault as fault:
            return {"error": str(fault)}
        self.plc.sentences.append(f"{marker.name} = {marker.number(value)} by {request.get('who') or 'a tool'}")
        self.flush()
        return {"ok": True, "operand": marker.name, "value": marker.number(value)}

    def _show(self, name: str, first: int) -> dict[str, object]:
        """The test display of a program; it is switched on by being looked at.  One program at a time."""
        now = time.monotonic_ns()
        if self._seen.watched and name != self._seen.watched and now - self._seen.looked_ns < LOOKS_NS:
            return {"on": False, "why": f"the test display shows {self._seen.watched}", "rows": []}
        again = now - self._seen.looked_ns > LOOKS_NS // 3  # the PLC has switched it off, or was restarted
        payload = self._shown.read()
        shown = None if payload is None else unpack_shown(payload)
        on = shown is not None and shown.name.rstrip(b"\0").decode(errors="replace") == name and self.plc.on
        if name != self._seen.watched or (not on and again):
            self._watch(name)
            self._seen.looked_ns = now
        if on:
            self._seen.looked_ns = now
        if not on or shown is None:
            return {"on": False, "why": "" if self.plc.on else "the PLC does not run", "rows": []}
        rows = [astuple(row) for row in steps_of(shown) if row.step >= first][:MOST_ROWS]
        return {"on": True, "why": "", "text": shown.text, "scans": shown.scans, "rows": rows}

    def _watch(self, name: str) -> None:
        self._seen.watched = name
        self.plc.orders.append({"do": "watch", "name": name})
        self.flush()

    def flush(self) -> None:
        """Orders that wait."""
        orders, self.plc.orders = self.plc.orders, []
        for order in orders:
            self._orders.put(pack_facts(order))
