"""Timers and counters of the PIC, controlled by flags.  Source: rho3 3.5 (L4070-4113); P3 how many, P13/P14 their values, AX-502.

Stage s (numbers 8s..8s+7) owns six flag bytes from M6s: counter decrement, counter ready, timer start, timer ready, timer active,
counter reset.  The manual prints M17 twice for the resets; stage 3 resets at M23 (rho3 D-08), as printed where `reset_as_printed`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.image.records.cell import get_bit, set_bit
from protocols.base.machine import Ns, ms

STAGES = (8, 16, 24, 32)  # P3
PIC_CYCLE = ms(10)  # rho3.2 (L4083)


def unit_of(control: str, p5: Ns, pic_cycle: Ns = PIC_CYCLE) -> Ns:
    """Smallest unit of time: the clock P5 on rho3.1 (and rho3.0, AX-502), the cycle of the PIC on rho3.2."""
    if control not in ("rho3.0", "rho3.1", "rho3.2"):
        raise ValueError(f"{control!r}: rho3.0, rho3.1 or rho3.2 expected")
    return pic_cycle if control == "rho3.2" else p5


@dataclass(frozen=True, slots=True)
class Flags:
    """Flag bits of timer and counter `number`."""

    decrement: int
    ready: int
    start: int
    timer_ready: int
    active: int
    reset: int


def flags_of(number: int, reset_as_printed: bool = False) -> Flags:
    """The six flags of number 0..31."""
    if not 0 <= number < STAGES[-1]:
        raise ValueError(f"timer or counter {number}: 0..31")
    stage, bit = divmod(number, 8)
    first = stage * 48 + bit
    reset = 17 * 8 + bit if stage == 3 and reset_as_printed else first + 40
    return Flags(first, first + 8, first + 16, first + 24, first + 32, reset)


class TimersAndCounters:
    """`presets`: P13 and P14, in units and pulses; missing ones are 0.  A timer runs while its start flag is set (AX-502)."""

    def __init__(self, count: int, timers: Sequence[int], counters: Sequence[int], unit: Ns, reset_as_printed: bool = False) -> None:
        """Raise ValueError when `count` is not a valid stage, or there are more values than timers or counters."""
        if count not in STAGES:
            raise ValueError(f"P3 = {count}: 8, 16, 24 or 32")
        if max(len(timers), len(counters)) > count or min([0, *timers, *counters]) < 0:
            raise ValueError(f"P13/P14: at most {count} values, none below 0")
        self._unit = unit
        self._flags = [flags_of(number, reset_as_printed) for number in range(count)]
        self._presets = [*timers, *[0] * (count - len(timers))]
        self._counter_presets = [*counters, *[0] * (count - len(counters))]
        self.counters = list(self._counter_presets)
        self.left: list[Ns] = [0] * count  # time each timer still has to run
        self._decrement, self._start = [True] * count, [False] * count

    def step(self, flags: bytearray, elapsed: Ns) -> None:
        """Once per cycle of the PIC, before its program: reads decrement, reset and start, writes ready and active."""
        for number, own in enumerate(self._flags):
            self._count(flags, number, own)
            self._time(flags, number, own, elapsed)

    def _count(self, flags: bytearray, number: int, own: Flags) -> None:
        pulse = get_bit(flags, own.decrement)
        if get_bit(flags, own.reset):
            self.counters[number] = self._counter_presets[number]
        elif pulse and not self._decrement[number]:
            self.counters[number] = max(0, self.counters[number] - 1)
        self._decrement[number] = pulse
        set_bit(flags, own.ready, self.counters[number] == 0)

    def _time(self, flags: bytearray, number: int, own: Flags, elapsed: Ns) -> None:
        start = get_bit(flags, own.start)
        if start and not self._start[number]:
            self.left[number] = self._presets[number] * self._unit
        elif start:
            self.left[number] = max(0, self.left[number] - elapsed)
        self._start[number] = start
        set_bit(flags, own.active, start and self.left[number] > 0)
        set_bit(flags, own.timer_ready, start and self.left[number] == 0)
