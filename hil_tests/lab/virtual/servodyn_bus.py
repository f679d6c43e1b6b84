"""A SERVODYN bus in virtual time: a master that sends SYNC and set values, and the emulated drives, no process and no clock."""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.emulator.servo import record
from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.axis import ServodynAxis
from drivers.emulator.servodyn.slave import Event, ServodynSlave
from gateway.files.dbc import load_servodyn
from gateway.files.find import find_config
from protocols.base.machine import Frame, Ns
from protocols.servodyn.codec import ActualValue, Codec, SetValue

START: Ns = 1_000_000_000_000
CODEC: Codec = load_servodyn(find_config("servodyn_gc.dbc", "drives"))
SET_DELAY: Ns = 700_000  # after SYNC, as the actual values are in


@dataclass
class Want:
    """What the master asks of one axis; without a path the set position follows the actual one until control, then stays."""

    on: bool = False
    enable: bool = False
    reset: bool = False
    limit_switch: bool = False
    brake: bool = False
    path: Callable[[float], float] | None = None  # inc over seconds since `since`, from where control began
    speed_rpm: int = 0
    base: int = 0
    since: Ns = 0
    silent: bool = False  # no set value at all
    life_stands: bool = False


class DriveBus:
    """`actual`: the last values received; `trace`: every frame handed to the drives; `said`: every frame they sent."""

    def __init__(self, *axes: ServoSettings, p5_ms: float = 4.0, seed: int = 1, substeps: int = 1) -> None:
        chosen = axes or (ServoSettings(),)
        self.settings = BusSettings(p5_ms, seed, dict(enumerate(chosen, 1)))
        self.slave = ServodynSlave(self.settings, CODEC, substeps)
        self.p5 = self.slave.cycle_ns
        self.now: Ns = START
        self.want = {number: Want() for number in self.settings.axes}
        self.actual: dict[int, ActualValue] = {}
        self.trace: list[Frame] = []
        self.said: list[Frame] = []
        self.events: list[Event] = []
        self._life = 0
        self._rows = bytearray(self.slave.header())

    def hand(self, *frames: Frame) -> list[Frame]:
        """These frames reach the drives; what they answer."""
        self.trace += frames
        self.events += self.slave.receive(frames, frames[-1].stamp_ns)
        return self._listen()

    def wake(self, now: Ns) -> list[Frame]:
        self.events += self.slave.wake(now)
        return self._listen()

    def cycle(self, count: int = 1) -> None:
        """SYNC at `now`, answers, set values; then now += P5."""
        for _ in range(count):
            self.hand(Frame(100, b"", self.now))
            frames = self.set_values()
            if frames:
                self.hand(*frames)
            self.slave.prepare()
            self.now += self.p5

    def set_values(self) -> list[Frame]:
        """The set values of this cycle, the life counter one further."""
        self._life = (self._life + 1) & 0xFF
        return [self._set(number, want) for number, want in self.want.items() if not want.silent]

    def run(self, seconds: float) -> None:
        self.cycle(round(seconds * 1e9 / self.p5))

    def enable(self) -> None:
        """All axes into control; asserts that they get there."""
        self.run(0.1)
        for want in self.want.values():
            want.on = True
        self.run(0.1)
        for want in self.want.values():
            want.enable = True
        self.run(0.2)
        assert all(value.enabled and value.brake_open for value in self.actual.values()), self.actual

    def move(self, path: Callable[[float], float], number: int = 1) -> None:
        """From now on the set position is the present position plus path(t) in inc."""
        want = self.want[number]
        want.path, want.since = path, self.now

    def rows(self) -> tuple[record.Row, ...]:
        self._rows += self.slave.take_record()
        return record.read(bytes(self._rows)).rows

    def axis(self, number: int = 1) -> ServodynAxis:
        return self.slave.axis(number)

    def _set(self, number: int, want: Want) -> Frame:
        seen = self.actual.get(number, ActualValue())
        if not seen.enabled:
            want.base = seen.position_inc
        position = want.base + (round(want.path((self.now - want.since) * 1e-9)) if want.path and seen.enabled else 0)
        position = (position + 2**31) % 2**32 - 2**31
        life = 0 if want.life_stands else self._life
        value = SetValue(want.enable, want.on, want.limit_switch, want.reset, want.brake, life, position, want.speed_rpm)
        return CODEC.encode_set(number, value)._replace(stamp_ns=self.now + SET_DELAY)

    def _listen(self) -> list[Frame]:
        return self.hear(self.slave.take_output())

    def hear(self, frames: list[Frame]) -> list[Frame]:
        """Take what the drives have sent."""
        self.said += frames
        for frame in frames:
            number, value = CODEC.decode_actual(frame)
            self.actual[number] = value
        return frames
