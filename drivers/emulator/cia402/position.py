"""Positions of an emulated CiA 402 drive: the counter of its encoder, the user's position above it, the software limits."""

from math import inf

from drivers.emulator.cia402.servo import DriveServo


class UserPosition:
    """Counter + shift, at the instant reached."""

    def __init__(self, servo: DriveServo) -> None:
        self._servo = servo
        self.rest_ns = 0  # since the last full step of the model
        self.shift = 0
        self.homed = False
        self._counter: int | None = None  # of this instant, once it was read

    def at(self, rest_ns: int) -> None:
        """Time has passed."""
        self.rest_ns, self._counter = rest_ns, None

    def look_again(self) -> None:
        """The model or the encoder has changed."""
        self._counter = None

    @property
    def counter(self) -> int:
        """Increments of the encoder now."""
        if self._counter is None:
            self._counter = self._servo.latch(self.rest_ns)[1]
        return self._counter

    def home(self, counter: int, offset: int) -> None:
        """The position at `counter` is `offset` (AX-288)."""
        self.shift, self.homed = offset - counter, True

    def forget(self) -> None:
        """Its encoder loses its position."""
        self.homed, self.shift = False, 0


class SoftLimits:
    """Set positions beyond them are clipped; `active`: the last one was."""

    def __init__(self) -> None:
        self.active = False
        self._low, self._high = -inf, inf

    def load(self, low: int, high: int) -> None:
        """607Dh; the full range, or limits that contradict each other: none."""
        whole = low >= high or (low == -(1 << 31) and high == (1 << 31) - 1)
        self._low, self._high = (-inf, inf) if whole else (float(low), float(high))

    def clip(self, position: float) -> float:
        if self._low <= position <= self._high:
            self.active = False
            return position
        self.active = True
        return self._low if position < self._low else self._high
