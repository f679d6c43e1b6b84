"""Axisgate's emulated SERVODYN booster as a machine of frames, with exchangeable parts: for trials of the suite servodyn."""

from collections.abc import Callable, Sequence
from functools import lru_cache

from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.axis import ServodynAxis
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.conformance.framework.frame_wire import Pair
from gateway.files.dbc import load_servodyn
from gateway.files.find import find_config
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns
from protocols.servodyn.codec import ActualValue, Codec, SetValue
from protocols.servodyn.parameters import Answer, answer_id, decode_answer, encode_answer

MODULE, CYCLE_MS = 1, 4.0
QUICK = ServoSettings(boot_s=0.2, charge_s=0.2)
ActualChange = Callable[["Booster", ActualValue], ActualValue | None]
Heard = Callable[["Booster", SetValue], SetValue | None]
Answered = Callable[["Booster", Answer], Answer | None]
Raw = Callable[["Booster", Frame], Sequence[Frame]]
Tune = Callable[["Booster"], None]


@lru_cache
def codec() -> Codec:
    return load_servodyn(find_config("servodyn_gc.dbc", "drives"))


class Booster:
    """Changes: actual (values it sends), sets (values it gets), answered (parameters), out and into (frames), tune (once)."""

    def __init__(
        self,
        actual: ActualChange | None = None,
        sets: Heard | None = None,
        answered: Answered | None = None,
        out: Raw | None = None,
        into: Raw | None = None,
        tune: Tune | None = None,
        settings: ServoSettings = QUICK,
        module: int = MODULE,
    ) -> None:
        self.slave = ServodynSlave(BusSettings(CYCLE_MS, 1, {module: settings}), codec())
        self.module, self.now, self.last_sync, self.tally = module, 0, 0, 0
        self.kept: ActualValue | None = None
        self._actual, self._sets, self._answered, self._out, self._into = actual, sets, answered, out, into
        if tune is not None:
            tune(self)

    @property
    def axis(self) -> ServodynAxis:
        return self.slave.axis(self.module)

    # ---- the machine
    def receive(self, frames: Sequence[Pair], now: Ns) -> None:
        self.now = now
        for identifier, data in frames:
            frame = Frame(identifier, data, now)
            for one in self._into(self, frame) if self._into is not None else (frame,):
                changed = self._changed(one._replace(stamp_ns=now))
                if changed is not None:
                    self.slave.receive([changed], now)

    def _changed(self, frame: Frame) -> Frame | None:
        if self._sets is None or frame.identifier != codec().set_id(self.module):
            return frame
        try:
            _, value = codec().decode_set(frame)
        except DecodeError:
            return frame
        found = self._sets(self, value)
        return None if found is None else codec().encode_set(self.module, found)._replace(stamp_ns=frame.stamp_ns)

    def wake(self, now: Ns) -> None:
        self.now = now
        self.slave.wake(now)

    def deadline(self) -> Ns | None:
        return self.slave.deadline()

    def take_output(self) -> list[tuple[int, bytes]]:
        found: list[Frame] = []
        self.slave.take_record()
        for frame in self.slave.take_output():
            changed = self._spoken(frame)
            if changed is not None:
                found += self._out(self, changed) if self._out is not None else [changed]
        return [(frame.identifier, frame.data) for frame in found]

    def _spoken(self, frame: Frame) -> Frame | None:
        if self._actual is not None and frame.identifier == codec().actual_id(self.module):
            value = self._actual(self, codec().decode_actual(frame)[1])
            return None if value is None else codec().encode_actual(self.module, value)
        if self._answered is not None and frame.identifier == answer_id(self.module):
            answer = self._answered(self, decode_answer(frame)[1])
            return None if answer is None else encode_answer(self.module, answer)
        return frame

    def sent(self, now: Ns) -> None:
        """Nothing counts from here."""

    def lost(self, now: Ns) -> None:
        self.slave.lost(now)

    def power(self, on: bool, now: Ns) -> None:
        if on:
            self.slave.power_on(self.module)
        else:
            self.slave.power_off(self.module)


class Late(Booster):
    """Everything it sends comes later."""

    def __init__(self, late: Ns) -> None:
        super().__init__()
        self._late = late
        self._queue: list[tuple[Ns, tuple[int, bytes]]] = []

    def take_output(self) -> list[tuple[int, bytes]]:
        self._queue += [(self.now + self._late, one) for one in super().take_output()]
        ready = [one for due, one in self._queue if due <= self.now]
        self._queue = [(due, one) for due, one in self._queue if due > self.now]
        return ready

    def deadline(self) -> Ns | None:
        due = super().deadline()
        mine = self._queue[0][0] if self._queue else None
        return mine if due is None else due if mine is None else min(due, mine)

    def wake(self, now: Ns) -> None:
        due = super().deadline()
        self.now = now
        if due is not None and due <= now:
            super().wake(now)
