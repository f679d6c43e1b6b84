"""A drive written from CiA 301 and CiA 402 alone: expedited SDOs, power states, profile position by a program of one millisecond.

It shares nothing with axisgate's emulator.  Its variants are correct; each is of the kind that real drives have.
"""

import math
import struct
from collections.abc import Sequence

MS = 1_000_000
NODE = 5
DISABLED, READY, ON, ENABLED, QUICK = 0x40, 0x21, 0x23, 0x27, 0x07
REACHED, TAKEN = 0x400, 0x1000
SIZES = {1: 0x4F, 2: 0x4B, 4: 0x43}
TYPES = {0x1000: "I", 0x1001: "B", 0x1017: "H", 0x6040: "H", 0x6041: "H", 0x605A: "h", 0x605B: "h", 0x605C: "h"}
TYPES |= {0x605D: "h", 0x6060: "b", 0x6061: "b", 0x6064: "i", 0x606C: "i", 0x6067: "I", 0x607A: "i", 0x6081: "I", 0x6083: "I", 0x6084: "I"}
TYPES |= {0x6085: "I", 0x6502: "I"}
CONSTANT = {0x1000, 0x1001, 0x6041, 0x6061, 0x6064, 0x606C, 0x6502}
OPTIONS = {0x605A, 0x605B, 0x605C, 0x605D}
Pair = tuple[int, bytes]


class PlainDrive:
    """`answer_ms`: of an SDO; `options_fixed`: option codes are constants; `quick_option`: 605Ah.

    `unit`: units of 6064h a second in one unit of speed.

    `forgets`: faulty, a halt forgets the set-point.

    `form`: of what an upload is answered with: "expedited", "no size" (expedited, 42h), "segments".
    """

    def __init__(
        self,
        answer_ms: int = 0,
        options_fixed: bool = False,
        quick_option: int = 2,
        unit: float = 1.0,
        forgets: bool = False,
        form: str = "expedited",
    ) -> None:
        self._form, self._rest = form, b""
        self._answer, self._fixed, self._quick, self._unit, self._forgets = answer_ms * MS, options_fixed, quick_option, unit, forgets
        self._output: list[Pair] = []
        self._queue: list[tuple[int, Pair]] = []
        self._next: int | None = None  # step of the program
        self._begin(0)

    def _begin(self, now: int) -> None:
        fast = 1.0 if self._unit == 1.0 else 0.01
        self._values = dict.fromkeys(TYPES, 0)
        self._values |= {0x1000: 0x20192, 0x605A: self._quick, 0x605B: 1, 0x605C: 1, 0x605D: 1, 0x6502: 1, 0x6060: 1, 0x6067: 20}
        self._values |= {0x6081: round(50_000 * fast), 0x6083: round(400_000 * fast), 0x6084: round(400_000 * fast)}
        self._values[0x6085] = round(1_000_000 * fast)
        self._state, self._bits, self._control = DISABLED, 0, 0
        self._position = self._speed = 0.0
        self._goal: float | None = None
        self._waiting: float | None = None
        self._stop: tuple[float, int | None] | None = None  # deceleration, and the state at its end
        self._output.append((0x700 + NODE, b"\0"))

    # ---- the seven methods
    def receive(self, frames: Sequence[Pair], now: int) -> list[object]:
        self.wake(now)
        for identifier, data in ((frame[0], frame[1]) for frame in frames):
            if identifier == 0 and len(data) == 2 and data[1] in (0, NODE) and data[0] in (129, 130):
                self._begin(now)
            if identifier == 0x600 + NODE and data[:1] == b"\x80":
                self._rest = b""
            elif identifier == 0x600 + NODE and len(data) == 8:
                self._queue.append((now + self._answer, (0x580 + NODE, self._served(data))))
        self._next = self._next or now + MS
        return self.wake(now)

    def wake(self, now: int) -> list[object]:
        while self._next is not None and self._next <= now:
            self._step()
            self._next = self._next + MS if self._moves() else None
        self._output += [pair for due, pair in self._queue if due <= now]
        self._queue = [one for one in self._queue if one[0] > now]
        return []

    def deadline(self) -> int | None:
        return min(
            [due for due, _ in self._queue] + [self._next] if self._next is not None else [due for due, _ in self._queue], default=None
        )

    def take_output(self) -> list[Pair]:
        said, self._output = self._output, []
        return said

    def sent(self, now: int) -> list[object]:
        return []

    def lost(self, now: int) -> list[object]:
        return []

    # ---- objects
    def _served(self, data: bytes) -> bytes:
        index, sub = struct.unpack_from("<HB", data, 1)
        if data[0] & 0xEF == 0x60:
            rest, self._rest = self._rest, b""
            if not rest or data[0] != 0x60:
                return self._refused(b"\x80" + bytes(3), 0x05040001)
            return bytes((7 - len(rest) << 1 | 1,)) + rest.ljust(7, b"\0")
        self._rest = b""
        if index not in TYPES:
            return self._refused(data, 0x06020000)
        if sub:
            return self._refused(data, 0x06090011)
        size = struct.calcsize(TYPES[index])
        if data[0] == 0x40:
            return self._uploaded(data, self._held(index))
        if data[0] >> 5 != 1 or not data[0] & 2:
            return self._refused(data, 0x05040001)
        return self._written(data, index, size)

    def _uploaded(self, data: bytes, held: bytes) -> bytes:
        if self._form == "segments":
            self._rest = held
            return b"\x41" + data[1:4] + len(held).to_bytes(4, "little")
        return bytes((0x42 if self._form == "no size" else SIZES[len(held)],)) + data[1:4] + held.ljust(4, b"\0")

    def _written(self, data: bytes, index: int, size: int) -> bytes:
        if index in CONSTANT or (self._fixed and index in OPTIONS):
            return self._refused(data, 0x06010002)
        if data[0] & 1 and 4 - (data[0] >> 2 & 3) != size:
            return self._refused(data, 0x06070010)
        (value,) = struct.unpack("<" + TYPES[index], data[4 : 4 + size])
        taken = {0x6060: (1,), 0x605A: (0, 1, 2, 5, 6), 0x605D: (1, 2)}
        if value not in taken.get(index, (value,)):
            return self._refused(data, 0x06090030)
        self._values[index] = value
        if index == 0x6040:
            self._commanded(value)
        return b"\x60" + data[1:4] + bytes(4)

    @staticmethod
    def _refused(data: bytes, code: int) -> bytes:
        return b"\x80" + data[1:4] + code.to_bytes(4, "little")

    def _held(self, index: int) -> bytes:
        powered = 0x10 if self._state != DISABLED else 0
        shown = {0x6041: self._state | self._bits | powered | 0x200, 0x6061: 1, 0x6064: round(self._position)}
        shown[0x606C] = round(self._speed / self._unit)
        return struct.pack("<" + TYPES[index], shown.get(index, self._values[index]))

    # ---- power states
    def _commanded(self, word: int) -> None:
        before, self._control = self._control, word
        if word & 0x80:
            return
        if not word & 2:
            self._off(DISABLED)
        elif not word & 4:
            self._quick_stop()
        elif self._state == DISABLED:
            self._state = READY if word & 7 == 6 else DISABLED
        elif word & 0x0F == 0x0F:
            self._enabled(before, word)
        elif self._state == ENABLED:
            self._stop = (self._values[0x6084] * self._unit, ON if word & 1 else READY)
        elif self._state != QUICK:
            self._state = ON if word & 1 else READY

    def _off(self, state: int) -> None:
        self._state, self._goal, self._waiting, self._stop, self._speed, self._bits = state, None, None, None, 0.0, 0

    def _quick_stop(self) -> None:
        option = self._values[0x605A]
        if self._state not in (ENABLED, QUICK) or not option:
            self._off(DISABLED)
            return
        self._state = QUICK
        self._stop = (self._values[0x6085 if option in (2, 6) else 0x6084] * self._unit, None if option > 4 else DISABLED)

    def _enabled(self, before: int, word: int) -> None:
        if self._state != ENABLED:
            if self._state != QUICK or self._values[0x605A] > 4:
                self._off(ENABLED)
            return
        if word & ~before & 0x100:
            self._stop = (self._values[0x6084 if self._values[0x605D] == 1 else 0x6085] * self._unit, ENABLED)
        if before & ~word & 0x100:
            self._stop = None
            self._goal = None if self._forgets else self._goal
        if word & ~before & 0x10:
            self._set_point(word)
        if not word & 0x10:
            self._bits &= ~TAKEN

    def _set_point(self, word: int) -> None:
        target = float(self._values[0x607A])
        if word & 0x40:
            target += self._goal if self._goal is not None else round(self._position)
        self._bits = self._bits & ~REACHED | TAKEN
        if self._goal is None or word & 0x20:
            self._goal, self._waiting = target, None
        else:
            self._waiting = target

    # ---- motion
    def _moves(self) -> bool:
        return self._state in (ENABLED, QUICK)

    def _step(self) -> None:
        if self._stop is not None:
            self._stopping(*self._stop)
        elif self._goal is not None and self._state == ENABLED:
            self._move(self._goal)

    def _move(self, goal: float) -> None:
        self._bits &= ~REACHED
        way = goal - self._position
        rate = self._values[0x6084] * self._unit / 1000
        wanted = math.copysign(min(self._values[0x6081] * self._unit, math.sqrt(2000 * rate * abs(way))), way)
        step = self._values[0x6083] * self._unit / 1000 if abs(wanted) > abs(self._speed) else rate
        self._speed = max(min(wanted, self._speed + step), self._speed - step)
        if abs(way) <= max(abs(self._speed) / 1000, rate / 1000) and abs(self._speed) <= 3 * rate:
            self._position, self._speed = goal, 0.0
            self._goal, self._waiting = self._waiting, None
            self._bits |= REACHED
        self._position += self._speed / 1000

    def _stopping(self, rate: float, state: int | None) -> None:
        self._speed = math.copysign(max(abs(self._speed) - rate / 1000, 0.0), self._speed)
        self._position += self._speed / 1000
        if self._speed == 0.0:
            if state == ENABLED:
                self._bits |= REACHED  # standstill during halt
            elif state is not None:
                self._off(state)
