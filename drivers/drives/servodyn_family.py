"""One bus of SERVODYN-GC drives: SYNC and set values out, actual values in.  Source: rho3 2.2; AX-001."""

from collections.abc import Sequence

from drivers.drives.family import Heard, SetRecord
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns
from protocols.servodyn.codec import SYNC, Codec, SetValue


class ServodynFamily:
    """Modules of one bus; `axes`: (index in the cell, module on this bus)."""

    def __init__(self, codec: Codec, axes: Sequence[tuple[int, int]]) -> None:
        self.codec = codec
        self.aside: list[Frame] = []
        self.axes = tuple(axes)
        self._readers = {codec.actual_id(module): (index, codec.reader(module)) for index, module in axes}
        self._writers = [(index, codec.writer(module)) for index, module in axes]

    @property
    def expected(self) -> int:
        """Every drive answers every SYNC."""
        return len(self.axes)

    @property
    def unconfigured(self) -> int:
        """Boosters need no start-up."""
        return 0

    def burst(self, values: Sequence[SetRecord]) -> list[Frame]:
        """SYNC and the set values of this bus; TypeError when a drive of another family was put on it."""
        frames = [SYNC]
        for index, write in self._writers:
            value = values[index]
            if not isinstance(value, SetValue):
                raise TypeError(f"axis {index + 1}: {type(value).__name__} on a SERVODYN bus")
            frames.append(write(value))
        return frames

    def hear(self, frame: Frame) -> Heard | None:
        """The actual value of an axis; raises DecodeError for a frame this bus does not have."""
        known = self._readers.get(frame.identifier)
        if known is not None:
            return tuple.__new__(Heard, (known[0], known[1](frame.data)))
        module, _ = self.codec.decode_actual(frame)
        raise DecodeError(f"identifier {frame.identifier}: module {module} has no axis in this cell")

    def release(self, node: int, mode: int) -> None:
        """Boosters need no start-up."""

    def hold(self, node: int) -> None:
        """Boosters need no start-up."""

    def began(self, now: Ns) -> None:
        """Nothing depends on it here."""
