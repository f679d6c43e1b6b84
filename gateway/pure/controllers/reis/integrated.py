"""The integrated PLC as the control sees it: what its process reported last, orders to it, its messages.  Pure.  Source: AX-900."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from gateway.pure.controllers.reis.marker_operand import MarkerOperand
from gateway.pure.image.records.interpreter import Fact
from gateway.pure.image.records.plc import AREA, CELL, CELLS, MARKERS, PlcReport
from gateway.pure.languages.plc.cells import COUNTER, KEPT, NONE

STOPS, DRIVES_OFF = 3, 7
CHUNK = 512  # octets of an order
NS_PER_MS = 1_000_000


@dataclass(slots=True)
class IntegratedPlc:
    """One PLC of another process."""

    report: PlcReport = field(default_factory=lambda: PlcReport(0))
    alive: bool = False
    orders: list[dict[str, Fact]] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    messages: list[dict[str, Fact]] = field(default_factory=list)  # that the control has not looked at
    shown: dict[str, Fact] | None = None  # the message that is not acknowledged
    drives_off: bool = False  # wanted by a message of class 7, until they are off
    fresh: bool = False  # a report has come since the control looked
    _was_on: bool = False
    _robots: bytearray = field(default_factory=lambda: bytearray(AREA))  # outputs as the robot program wrote them last

    def take(self, report: PlcReport, *, alive: bool) -> None:
        """What the process has published."""
        if self.alive and not alive:
            self.sentences.append("the PLC process has failed: its outputs are 0 until it is back")
        begun = report.id != self.report.id
        self.report, self.alive, self.fresh = report, alive, True
        for byte, bits in enumerate(self._robots if begun else b""):
            if bits:  # a process that begins knows none of them
                self.orders.append({"do": "output", "byte": byte, "mask": bits, "bits": bits})

    def hear(self, facts: dict[str, Fact]) -> None:
        """A message of the PLC."""
        self.messages.append(facts)
        self.shown = facts
        place = f" ({facts['program']} step {facts['step']})" if facts["program"] else ""
        self.sentences.append(f"PLC: {facts['text']}{place}")

    @property
    def on(self) -> bool:
        """It runs, and its outputs count."""
        return self.alive and self.report.running

    def released(self) -> bool:
        """True once when the PLC has stopped: all outputs become 0."""
        before, self._was_on = self._was_on, self.on
        stopped = before and not self.on
        if stopped and self.alive:
            self._robots = bytearray(AREA)
        return stopped

    def outputs(self) -> Mapping[tuple[int, int], bool]:
        """Output bits that the last complete scan wrote."""
        found: dict[tuple[int, int], bool] = {}
        for byte in range(AREA if self.on else 0):
            written, level = self.report.written[byte], self.report.outputs[byte]
            for bit in range(8 if written else 0):
                if written >> bit & 1:
                    found[byte, bit] = bool(level >> bit & 1)
        return found

    def write(self, first: int, data: bytes) -> bool:
        """Markers M0..M1967, between two scans; False: inputs and outputs are not a command source's where a PLC runs."""
        if first + len(data) > MARKERS:
            return False
        for at in range(0, len(data), CHUNK):
            self.orders.append({"do": "write", "first": first + at, "data": data[at : at + CHUNK].hex()})
        shown = bytearray(self.report.markers)  # read back at once; the next report has it from the PLC
        shown[first : first + len(data)] = data
        self.report = replace(self.report, markers=bytes(shown))
        return True

    def write_bits(self, byte: int, mask: int, bits: int) -> None:
        """Bits of a marker byte, between two scans."""
        self.orders.append({"do": "bits", "byte": byte, "mask": mask, "bits": bits})
        shown = bytearray(self.report.markers)
        shown[byte] = shown[byte] & ~mask | bits & mask
        self.report = replace(self.report, markers=bytes(shown))

    def robot_output(self, byte: int, mask: int, bits: int) -> None:
        """Output bits the robot program has written: the PLC program sees them from its next scan on."""
        self._robots[byte] = self._robots[byte] & ~mask | bits & mask
        self.orders.append({"do": "output", "byte": byte, "mask": mask, "bits": bits})

    def set_marker(self, marker: MarkerOperand, value: int) -> None:
        """A marker by hand, between two scans."""
        if marker.bit is not None:
            self.write_bits(marker.byte, 1 << marker.bit, value << marker.bit)
        else:
            self.write(marker.byte, marker.data(value))

    def acknowledge(self) -> None:
        """The message shown is acknowledged."""
        if self.shown is not None:
            self.shown = None
            self.orders.append({"do": "ack"})

    def timer(self, number: int) -> int | None:
        """Rest in ms; None: none of that number."""
        kind, _, left = self._cell(number)
        return None if kind in (NONE, COUNTER) else max(0, left) // NS_PER_MS

    def counter(self, number: int) -> int | None:
        """None: none of that number."""
        kind, _, count = self._cell(number)
        return count if kind == COUNTER else None

    def _cell(self, number: int) -> tuple[int, int, int]:
        if not 0 <= number < CELLS:
            return NONE, 0, 0
        kind, flags, left = KEPT.unpack_from(self.report.cells, CELL * number)
        return kind, flags, left

    def status(self) -> dict[str, object]:
        """For tools and pages."""
        return {
            "state": "RUN" if self.on else "STOP" if self.alive else "GONE",
            "scans": self.report.scans,
            "message": dict(self.shown) if self.shown is not None else None,
        }
