"""One axis in virtual time: our drive object and scaling on one side, an emulated booster on the other; positions in m or rad."""

from dataclasses import replace

from drivers.drives.family import Demand
from drivers.drives.scaling import Scaling
from drivers.drives.servodyn import Drive, DriveSettings, Power
from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.slave import ServodynSlave
from hil_tests.lab.virtual.servodyn_bus import CODEC, START
from protocols.base.machine import Frame
from protocols.servodyn.codec import SYNC, ActualValue, SetValue
from protocols.servodyn.parameters import Answer, Request, decode_answer, encode_request


class OneAxis:
    """`cycle` once per SYNC; `goal` is where the axis shall be, approached at `speed` per second."""

    def __init__(
        self, scaling: Scaling, settings: ServoSettings | None = None, p5_ms: float = 4.0, drive: DriveSettings | None = None
    ) -> None:
        self.scaling = scaling
        self.slave = ServodynSlave(BusSettings(p5_ms, 1, {1: settings or ServoSettings()}), CODEC)
        self.drive = Drive(drive or DriveSettings())
        self.period_ns, self.now = self.slave.cycle_ns, START
        self.on = self.reset = self.limit_switch = False
        self.set = self.goal = 0.0
        self.speed = 1.0
        self.actual: ActualValue | None = None
        self.answers: list[Answer] = []
        self.silent = False  # the gateway sends nothing: SYNC stays away
        self._burst = [SYNC, CODEC.encode_set(1, SetValue())]

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            if self.silent:
                self.slave.wake(self.now)
            else:
                self.slave.receive([frame._replace(stamp_ns=self.now) for frame in self._burst], self.now)
            self._listen()
            self._step()
            self.now += self.period_ns

    def run(self, seconds: float) -> None:
        self.cycle(round(seconds * 1e9 / self.period_ns))

    def enable(self) -> None:
        """Take control at the present position of the axis."""
        self.run(0.1)
        self.on = True
        self.run(0.4)
        assert self.drive.power is Power.ENABLED, self.drive.phase

    def send(self, request: Request) -> Answer:
        """A parameter by hand; the answer."""
        self.slave.receive([encode_request(1, request)._replace(stamp_ns=self.now)], self.now)
        self.answers.clear()
        self._listen()
        assert len(self.answers) == 1, self.answers
        return self.answers[0]

    @property
    def position(self) -> float:
        return self.scaling.to_si(self.drive.position_inc)

    @property
    def shaft_rad(self) -> float:
        return self.slave.axis(1).servo.position_rad

    def zero_here(self) -> None:
        """Set the present position of the axis to 0."""
        self.scaling = replace(self.scaling, zero_inc=float(self.drive.position_inc))
        self.set = self.goal = 0.0

    def _listen(self) -> None:
        heard: list[Frame] = self.slave.take_output()
        values = [frame for frame in heard if frame.identifier == 610]
        self.answers += [decode_answer(frame)[1] for frame in heard if frame.identifier == 710]
        self.actual = CODEC.decode_actual(values[-1])[1] if values else None

    def _step(self) -> None:
        if self.drive.power is Power.ENABLED:
            reach = self.speed * self.period_ns * 1e-9
            self.set += min(max(self.goal - self.set, -reach), reach)
        else:
            self.set = self.position
        demand = Demand(self.on, self.reset, self.scaling.to_inc(self.set), 0.0, self.limit_switch)
        value = self.drive.step(self.actual, demand)
        self._burst = [SYNC, CODEC.encode_set(1, value)]
