"""A running cell as seen by a program: markers, inputs and outputs of the control, the robot.  Source: robotstar 1.4, 4, 5.6.

Reads wait for the previous positions; writes act after them, and are read back at once.
"""

from dataclasses import dataclass, field

from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.robotstar.ahead import Ahead
from gateway.pure.languages.robotstar.faults import INPUT_WRITTEN, StepFault
from gateway.pure.languages.robotstar.machine import Machine, NotYet
from gateway.pure.languages.robotstar.operands import signed
from gateway.pure.languages.robotstar.path import Target
from gateway.pure.languages.robotstar.progress import Progress, Reports
from gateway.pure.languages.robotstar.virtual import ANALOG_INPUTS, ANALOG_OUTPUTS, BASES, SCALE

SHOWN_NS = 50_000_000  # how long a written value is read back whether the control shows it or not: the PLC may have changed it since


@dataclass(slots=True)
class CellWorld:
    """Surroundings of a Machine."""

    port: Port
    ahead: Ahead
    machine: Machine | None = None  # set once it is made
    now: Ns = 0
    progress: Progress = field(default_factory=Progress)
    _reports: Reports = field(default_factory=Reports)
    _written: dict[int, tuple[int, int, Ns]] = field(default_factory=dict)  # byte -> mask, bits, until: not shown by the control yet

    # ---- reading
    def _wait(self) -> None:
        if self.ahead.busy:
            raise NotYet

    def _byte(self, place: int) -> int:
        value = self.port.view.channels.flags[place]
        found = self._written.get(place)
        if found is not None:
            mask, bits, until = found
            if value & mask == bits or self.now >= until:
                del self._written[place]
            else:
                value = value & ~mask | bits
        return value

    def byte(self, area: str, number: int) -> int:
        """A byte of an area."""
        self._wait()
        return self._byte(BASES[area] + number)

    def element(self, area: str, number: int) -> int:
        """Four bytes, the lowest first."""
        self._wait()
        place = BASES[area] + number
        return signed(int.from_bytes(bytes(self._byte(place + at) for at in range(4)), "little"))

    def analog_input(self, channel: int) -> float:
        """Volts."""
        self._wait()
        place = ANALOG_INPUTS + 2 * (channel - 1)
        return int.from_bytes(bytes((self._byte(place), self._byte(place + 1))), "little", signed=True) / SCALE

    def path_left(self, number: int) -> float:
        """_RPATH_DIST[1], [2], _RTIME_DIST[1], [2]: of the position before, once it is reached."""
        self._wait()
        return self.progress.values()[number - 1]

    def report_progress(self, now: Ns) -> None:
        """M1464 to M1479."""
        self.progress = self.ahead.progress(self.progress)
        if numbers := self._reports.due(self.progress, now):
            self.port.send("progress", values=numbers)

    def actual(self) -> Target:
        """Where the robot is."""
        self._wait()
        return self._here()

    def _here(self) -> Target:
        tool = self.machine.tool if self.machine is not None else None
        return self.ahead.arm.actual(self.ahead.arm.own(self.port.view.set), tool)

    def planned(self) -> Target:
        """Where it is once all positions that were asked for are reached."""
        return self.ahead.last() or self._here()

    def based(self, target: Target) -> Target:
        """A position in the basic system."""
        return self.ahead.arm.based(target)

    def seen_from(self, frame: int, target: Target) -> Target:
        """A position of the basic system in a station's frame."""
        return self.ahead.arm.seen_from(frame, target)

    # ---- writing
    def set_bit(self, area: str, number: int, bit: int, level: bool) -> None:
        """Set one bit after the previous position."""
        place = BASES[area] + number
        if BASES["INPUT"] <= place < BASES["OUTPUT"]:
            raise StepFault(INPUT_WRITTEN)
        self.ahead.act(lambda: self._set(place, 1 << bit, level << bit))

    def set_element(self, area: str, number: int, value: int) -> None:
        """Set four bytes after the previous position."""
        self._put(BASES[area] + number, (value & 0xFFFFFFFF).to_bytes(4, "little"))

    def set_analog_output(self, channel: int, volts: float) -> None:
        """Set volts after the previous position."""
        self._put(ANALOG_OUTPUTS + 2 * (channel - 1), round(volts * SCALE).to_bytes(2, "little", signed=True))

    def _put(self, place: int, data: bytes) -> None:
        if BASES["INPUT"] - len(data) < place < BASES["OUTPUT"]:
            raise StepFault(INPUT_WRITTEN)
        self.ahead.act(lambda: self._put_now(place, data))

    def _put_now(self, place: int, data: bytes) -> None:
        for at, value in enumerate(data, place):
            self._keep(at, 0xFF, value)
        self.port.send("write", first=place, data=data.hex())

    def _set(self, place: int, mask: int, bits: int) -> None:
        self._keep(place, mask, bits)
        self.port.send("bits", byte=place, mask=mask, bits=bits)

    def _keep(self, place: int, mask: int, bits: int) -> None:
        before, kept, _ = self._written.get(place, (0, 0, 0))
        self._written[place] = before | mask, kept & ~mask | bits, self.now + SHOWN_NS
