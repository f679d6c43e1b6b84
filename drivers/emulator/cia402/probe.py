"""Touch probes 1 and 2: 60B8h function, 60B9h status, 60BAh..60BDh positions.  Source: CiA 402-2 (IEC 61800-7-201), touch probe."""

from dataclasses import dataclass

from drivers.emulator.canopen.objects import Objects
from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.switches import Edge, Signal

ENABLE, CONTINUOUS, SOURCE, RISING, FALLING = 0x01, 0x02, 0x0C, 0x10, 0x20
INDEX_SOURCE = 0x04
_SHIFTS = (0, 8)
_SIGNALS = (Signal.PROBE_1, Signal.PROBE_2)


@dataclass(slots=True)
class _Probe:
    function: int = 0
    taken: int = 0  # bit 0 rising, bit 1 falling


class TouchProbe:
    """Captures the exact place of an edge; the index pulse counts as a rising edge."""

    def __init__(self, objects: Objects) -> None:
        self._objects = objects
        self._probes = (_Probe(), _Probe())
        objects.readers[od.PROBE_STATUS] = lambda: self.status

    @property
    def status(self) -> int:
        """60B9h: enabled, value of the rising edge stored, of the falling edge."""
        word = 0
        for probe, shift in zip(self._probes, _SHIFTS, strict=True):
            if probe.function & ENABLE:
                word |= (1 | probe.taken << 1) << shift
        return word

    @property
    def wants_index(self) -> bool:
        return any(probe.function & ENABLE and probe.function & SOURCE == INDEX_SOURCE for probe in self._probes)

    def arm(self, function: int) -> None:
        """Evaluate a write to 60B8h: a probe that is enabled again, or whose edges are selected again, discards its captures."""
        for probe, shift in zip(self._probes, _SHIFTS, strict=True):
            wanted, before = function >> shift & 0xFF, probe.function
            probe.function = wanted
            if not wanted & ENABLE or not before & ENABLE:
                probe.taken = 0
            else:
                probe.taken &= ~(1 if wanted & RISING and not before & RISING else 0)
                probe.taken &= ~(2 if wanted & FALLING and not before & FALLING else 0)

    def edge(self, edge: Edge, shift: int) -> None:
        """An edge at counter + shift; once or continuously, as the function selects."""
        for number, probe in enumerate(self._probes):
            signal = Signal.INDEX if probe.function & SOURCE == INDEX_SOURCE else _SIGNALS[number]
            wanted = probe.function & (RISING if edge.rising else FALLING)
            bit = 1 if edge.rising else 2
            if edge.signal is not signal or not probe.function & ENABLE or not wanted:
                continue
            if probe.function & CONTINUOUS or not probe.taken & bit:
                place = od.PROBE_VALUES[2 * number + (0 if edge.rising else 1)]
                self._objects.values[place] = (edge.counter + shift + 0x80000000 & 0xFFFFFFFF) - 0x80000000
                probe.taken |= bit
