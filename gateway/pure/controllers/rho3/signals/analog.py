"""Numeric channels of BAPS programs: REAL inputs 201..224 (L7959), and outputs with the same numbers (AX-1120).

A REAL input exists once a route, a value of a Modbus device or a tool is wired to it.  An output that no route uses is only kept here.
"""

import math

from gateway.pure.controllers.rho3.signals.user import INTEGER_CHANNEL, INTEGERS
from gateway.pure.image.records.interpreter import FIRST_REAL, REALS

REAL_OUTPUTS = range(FIRST_REAL, FIRST_REAL + REALS)
INTEGER_OUTPUTS = range(INTEGER_CHANNEL, INTEGER_CHANNEL + INTEGERS)
IN, OUT, INTEGER_OUT = "rho3.real.input.", "rho3.real.output.", "rho3.integer.output."


class AnalogChannels:
    """Values as routes and tools name them, and as programs read and write them."""

    def __init__(self) -> None:
        self.inputs: dict[int, float] = {}  # channel -> value, of those that are wired
        self._outputs = dict.fromkeys((*REAL_OUTPUTS, *INTEGER_OUTPUTS), 0.0)

    @staticmethod
    def names() -> tuple[str, ...]:
        """All of them."""
        reals = [f"{way}{channel}" for way in (IN, OUT) for channel in REAL_OUTPUTS]
        return (*reals, *(f"{INTEGER_OUT}{channel}" for channel in INTEGER_OUTPUTS))

    @staticmethod
    def has(name: str) -> bool:
        """Whether the name is one of these."""
        return name.startswith((IN, OUT, INTEGER_OUT))

    def value(self, name: str) -> float:
        """One of these names; an input that nothing is wired to is 0."""
        channel = int(name.rpartition(".")[2])
        return self.inputs.get(channel, 0.0) if name.startswith(IN) else self._outputs[channel]

    def wire(self, name: str, value: float) -> None:
        """What is connected to an input; KeyError: an output, ValueError: no number."""
        if not name.startswith(IN):
            raise KeyError(name)
        if not math.isfinite(value):
            raise ValueError(f"{name}: a number is expected")
        self.inputs[int(name.rpartition(".")[2])] = value

    def writes(self, channel: int) -> bool:
        """Whether the channel is an output here."""
        return channel in self._outputs

    def write(self, channel: int, value: float) -> None:
        """A program sets an output."""
        self._outputs[channel] = value

    @property
    def seen(self) -> tuple[int, tuple[float, ...]]:
        """For programs: which inputs are wired (bit 0 = channel 201), and the values of all."""
        given = sum(1 << channel - FIRST_REAL for channel in self.inputs)
        return given, tuple(self.inputs.get(channel, 0.0) for channel in REAL_OUTPUTS)
