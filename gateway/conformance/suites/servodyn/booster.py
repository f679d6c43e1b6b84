"""The tester's side of a SERVODYN bus: SYNC and set values in their phase, one actual value for each SYNC (AX-001)."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

from gateway.conformance.framework.base import hexed
from gateway.conformance.framework.frame_wire import FrameWire
from gateway.conformance.suites.can.tester import CanTester, shown
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive, Warn
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns, ms
from protocols.servodyn.codec import SYNC, ActualValue, Codec, SetValue
from protocols.servodyn.parameters import Answer, Request, answer_id, decode_answer, encode_request

LONG = ms(8000)
ACTUAL, EACH = "one actual value", "one actual value after each SYNC"


@dataclass(slots=True)
class BoosterSetup:
    """Known facts about the booster and the bench."""

    codec: Codec
    module: int = 1
    cycle: Ns = ms(4)  # P5
    wait: Ns = ms(200)  # a parameter's answer
    boot: Ns = ms(10_000)
    way: int = 2000  # increments of a motion
    way_stated: bool = False
    turn: int = 16_384  # increments of one turn of the motor (AX-084)
    stop: Ns = ms(500)  # longest time of a stop
    pics: Mapping[str, object] = field(default_factory=dict)


class BoosterTester(CanTester):
    """One module."""

    def __init__(self, connect: Callable[[], FrameWire], setup: BoosterSetup, witness: Callable[[], Ns] = lambda: 0) -> None:
        super().__init__(connect, witness)
        self.setup = setup
        self.value = SetValue()
        self.last: ActualValue | None = None
        self.life_runs = True
        self.home: int | None = None  # start of the first motion that did not return
        self._grid: Ns = 0
        self._sequence = 0
        self.answers = False  # to a parameter, right or wrong
        self.syncs = self.missing = 0  # SYNCs of this run, and single ones without an actual value
        self.counted = False  # SERVO_CYC_ST_01 has passed, and no case has met one since
        self._lone = 0  # missing in this case, with an actual value before and after
        self._held = False  # the SYNC before had no actual value

    @property
    def actual_id(self) -> int:
        return self.setup.codec.actual_id(self.setup.module)

    @property
    def limit(self) -> Ns:
        """Longest time from SYNC to the actual value: the set values of the next cycle need the rest."""
        return self.setup.cycle * 3 // 4

    # ---- the cycle
    def give(self, **changes: Any) -> None:
        """From here on the set values hold this."""
        self.value = self.value._replace(**changes)

    def read(self, frame: Frame) -> ActualValue:
        try:
            return self.setup.codec.decode_actual(frame)[1]
        except DecodeError as error:
            raise Fail(f"an impossible actual value: {error}", "8 bytes as in the layout", hexed(frame.data)) from error

    def sync(self) -> None:
        """On the grid, one cycle after the one before."""
        self._grid = max(self._grid + self.setup.cycle, self.now())
        self.pause(self._grid - self.now())
        self.drain()
        self.say(SYNC.identifier)
        self.syncs += 1

    def say_set(self) -> None:
        if self.life_runs:
            self.value = self.value._replace(life=(self.value.life + 1) & 0xFF)
        frame = self.setup.codec.encode_set(self.setup.module, self.value)
        self.say_on(frame.identifier, frame.data)

    def answered(self) -> ActualValue:
        """Judged: the actual value of the SYNC just sent, within its cycle.  For a single missing one the value before it counts."""
        start = self.asked_at
        frame = self.hear((self.actual_id,), self.limit + self.uncertainty())
        if frame is None:
            if self.last is None or self._held:
                self.last, self._held = None, False
                raise Fail("no actual value after SYNC", f"{ACTUAL} on {self.actual_id:03X}h within {self.limit / 1e6:g} ms", "nothing")
            self._held = True
            return self.last
        if self._held:
            self.missing, self._lone, self._held = self.missing + 1, self._lone + 1, False
        self.last = self.read(frame)
        self.answered_after = self.answered_at - start
        return self.last

    answered_after: Ns = 0

    def begin(self) -> None:
        super().begin()
        self._lone, self._held, self.last = 0, False, None

    def standing(self) -> None:
        """A lone missing actual value decides no other question: SERVO_CYC_ST_01 judges it, after that the first case that meets one."""
        if not self._lone:
            return
        if self.counted:
            self.counted = False
            raise Fail(f"{self.missing} of {self.syncs} SYNCs without an actual value", EACH, "nothing")
        raise Warn(f"SYNCs without an actual value: {self._lone}; SERVO_CYC_ST_01 judges this", EACH, "nothing")

    def turn(self, count: int = 1, with_set: bool = True) -> ActualValue:
        """So many cycles; without control the set position follows the actual one."""
        found = None
        for _ in range(count):
            self.sync()
            found = self.answered()
            if not found.enabled:
                self.give(position_inc=found.position_inc, speed_rpm=0)
            if with_set:
                self.say_set()
        assert found is not None, "at least one cycle"
        return found

    def until(self, good: Callable[[ActualValue], bool], what: str, limit: Ns = LONG) -> ActualValue:
        """Judged: it becomes so in time."""
        begin = self.now()
        while not good(found := self.turn()):
            if self.now() - begin > limit:
                raise Fail(f"{what}: not within {limit / 1e6:.0f} ms: {words(found)}", what, words(found))
        return found

    def stays(self, good: Callable[[ActualValue], bool], what: str, time: Ns = ms(300)) -> None:
        begin = self.now()
        while self.now() - begin < time:
            if not good(found := self.turn()):
                raise Fail(f"{what}: {words(found)}", what, words(found))

    # ---- states
    def rest(self) -> None:
        """Without power and fault: where every case begins and ends."""
        self.life_runs = True
        self.give(enable=False, drive_on=False, fault_reset=False, brake_open=False)
        self.until(lambda found: not found.enabled and not found.power_on, "no power")
        self.turn(2)
        for _ in range(3):
            if not self.turn().fault:
                break
            self.give(fault_reset=True)
            self.turn(3)
            self.give(fault_reset=False)
            self.turn(3)
        self.until(lambda found: found.ready and not found.fault, "ready without fault")

    @contextmanager
    def powered(self, enabled: bool = False) -> Iterator[None]:
        """Power on, and under control, within the block."""
        try:
            with self.given():
                self.rest()
                self.give(drive_on=True)
                self.until(lambda found: found.power_on, "power on")
                if enabled:
                    self.give(enable=True)
                    self.until(lambda found: found.enabled, "enabled")
            yield
        finally:
            with suppress(Ended):
                self.give(enable=False)
                self.until(lambda found: not found.enabled, "stops")
            with suppress(Ended):
                self.rest()

    def move(self, way: int, cycles: int = 200) -> None:
        """Along a straight line, then a moment of rest."""
        start = self.value.position_inc
        for at in range(1, cycles + 1):
            self.give(position_inc=start + way * at // cycles)
            self.turn()
        self.turn(100)

    def spontaneous(self, time: Ns) -> list[tuple[Ns, ActualValue]]:
        """Frames without SYNC."""
        return [(frame.stamp_ns, self.read(frame)) for frame in self.pause(time) if frame.identifier == self.actual_id]

    # ---- parameters
    def ask(self, number: int, value: bool | int | float) -> Answer:
        """Judged: an answer to this request."""
        self._sequence = self._sequence + 1 & 0xFF
        frame = encode_request(self.setup.module, Request(number, value, self._sequence))
        self.drain()
        self.say(frame.identifier, frame.data)
        got = self.hear((answer_id(self.setup.module),), self.setup.wait)
        self.answers = self.answers or got is not None
        if got is None:
            raise Fail(f"no answer to parameter {number}", f"an answer on {answer_id(self.setup.module):03X}h", "nothing")
        try:
            answer = decode_answer(got)[1]
        except DecodeError as error:
            raise Fail(f"an impossible answer: {error}", "8 bytes: number, status, sequence, value", shown(got)) from error
        if (answer.number, answer.sequence) != (number, self._sequence):
            wanted = f"number {number}, sequence {self._sequence}"
            raise Fail(f"another request is answered: number {answer.number}, sequence {answer.sequence}", wanted, shown(got))
        return answer

    def alive(self) -> None:
        """The suite's postamble: at rest, one actual value for a SYNC."""
        try:
            self.rest()
        except Inconclusive as ended:
            raise Fail(ended.reason, ended.expected, ended.got) from ended


def answer_words(answer: Answer) -> str:
    """The answer to a parameter for a reader."""
    status = f"status {int(answer.status)} ({answer.status.name})"
    return f"parameter {answer.number}: {status}, value {answer.value}, sequence {answer.sequence}"


def words(found: ActualValue | None) -> str:
    """An actual value for a reader."""
    if found is None:
        return "nothing"
    flags = [name for name in ActualValue._fields[:8] if getattr(found, name)]
    return f"{', '.join(flags) or 'no bit'}; fault code {found.fault_code}, position {found.position_inc}, torque {found.torque_permille}"
