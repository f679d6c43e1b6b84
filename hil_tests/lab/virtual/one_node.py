"""One emulated CiA 402 drive, its start-up and our drive object on it, cycle by cycle in bus time."""

import pathlib
from collections.abc import Callable

import configs
from drivers.drives.cia402 import Cia402Actual, Cia402Drive, Cia402Settings, Phase
from drivers.drives.cia402_boot import NodePlan, Parameter, boot, default_pdos
from drivers.drives.cia402_family import Cia402Family
from drivers.drives.family import Actual, Demand, Event, Power
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings
from hil_tests.lab.virtual.cell_402_bench import Dialogue
from protocols.base.machine import Frame, Ns
from protocols.canopen import eds

NODE, P5_MS = 3, 4
P5_NS: Ns = P5_MS * 1_000_000
START: Ns = 1_000_000_000_000
EDS = pathlib.Path(configs.__path__[0]) / "drives" / "axisgate_402.eds"
DICTIONARY = eds.parse(EDS.read_text())[0]


def one_plan(*parameters: Parameter) -> NodePlan:
    """Return the plan for node 3."""
    return NodePlan(NODE, default_pdos(NODE, torque=True), parameters=parameters)


class OneNode:
    """Our side and the drive; `frames` are those of the last burst."""

    def __init__(self, servo: ServoSettings | None = None, settings: Cia402Settings | None = None) -> None:
        drives = DriveSettings(servo or ServoSettings(start_rad=40.0), multiturn_turns=4096)
        self.slave = Cia402Slave(BusSettings(P5_MS, 1, {}, {NODE: drives}), {NODE: DICTIONARY})
        self.family = Cia402Family([(0, NODE)], heartbeat_cycles=12, quiet_cycles=1)
        self.drive = Cia402Drive(settings)
        self.now: Ns = START
        self.actual: Cia402Actual | None = None
        self.frames: list[Frame] = []
        self.events: list[Event] = []
        self.deaf = False  # its TPDOs do not arrive
        self._burst = self.family.burst([self.drive.idle()])

    def power(self) -> Power:
        """Of our drive object."""
        return self.drive.power

    def dialogue(self) -> Dialogue:
        """For a start-up by hand."""
        return Dialogue(self.slave, NODE, self.now)

    def start(self, *parameters: Parameter) -> "OneNode":
        """Configured, operational, spoken to."""
        dialogue = self.dialogue()
        booted = dialogue.carry(boot(one_plan(*parameters)))
        self.now = dialogue.now
        self.family.release(NODE, booted.mode)
        self.cycles(5)
        return self

    def cycle(self, demand: Demand) -> None:
        """SYNC, TPDOs, our set value; the burst leaves with the next SYNC."""
        self.now += P5_NS
        self.frames = self._burst
        self.slave.receive([frame._replace(stamp_ns=self.now) for frame in self._burst], self.now)
        self.slave.wake(self.now + P5_NS - 1)
        actual: Actual | None = None
        for frame in self.slave.take_output():
            heard = self.family.hear(frame)
            if heard is not None and not self.deaf:
                actual = heard.actual
        self.actual = actual if isinstance(actual, Cia402Actual) else None
        value = self.drive.step(actual, demand)
        self.events += self.drive.events
        self._burst = self.family.burst([value])

    def cycles(self, count: int, demand: Demand | None = None, each: Callable[[], None] = lambda: None) -> "OneNode":
        """`demand` None: off."""
        for _ in range(count):
            self.cycle(demand or Demand())
            each()
        return self

    def on(self) -> "OneNode":
        """Enabled and held at its present position."""
        for _ in range(200):
            self.cycle(Demand(on=True, position_inc=self.drive.set_inc))
            if self.drive.power is Power.ENABLED:
                self.events.clear()
                return self.cycles(5, Demand(on=True, position_inc=self.drive.set_inc))
        raise AssertionError(f"not enabled: {self.drive.phase}, {self.events}, {self.actual}")

    def move(self, way_inc: int, cycles: int) -> "OneNode":
        """A steady way from the held position."""
        first = self.drive.set_inc
        for n in range(1, cycles + 1):
            self.cycle(Demand(on=True, position_inc=first + way_inc * n // cycles))
        return self

    def until(self, phase: Phase, demand: Demand, limit: int = 3000) -> "OneNode":
        """AssertionError when the phase never comes."""
        for _ in range(limit):
            self.cycle(demand)
            if self.drive.phase is phase:
                return self
        raise AssertionError(f"{phase} never came: {self.drive.phase}, {self.events}, {self.actual}")
