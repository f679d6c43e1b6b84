"""Which axes are synchronised with the machine data of today (robotstar 677, 678, 679).  Pure."""

from collections.abc import Mapping, Sequence

from gateway.pure.controllers.reis.regulator import Reference
from gateway.pure.image.records.cell import AxisFlag, AxisState


class References:
    """`wanted`: machine data of today, axis 1.. -> reference."""

    def __init__(self, wanted: Mapping[int, Reference]) -> None:
        self._wanted = wanted
        self.synchronised: dict[int, Reference] = {}  # machine data of the last synchronisation of each axis; kept over power-off
        self.asynchronous: set[int] = set()  # axes whose machine data have changed since
        self._referenced, self._seen = 0, False  # axes that were referenced at the last step; there was one

    def known(self, synchronised: Mapping[int, Reference], asynchronous: set[int]) -> None:
        """As the control was last alive; these axes have other machine data today."""
        self.synchronised, self.asynchronous = dict(synchronised), asynchronous

    def look(self, axes: Sequence[AxisState]) -> bool:
        """An axis that has just been referenced is synchronised with the machine data of today; True: it was the last asynchronous one."""
        before = len(self.asynchronous)
        referenced = sum(1 << n for n, axis in enumerate(axes) if axis.flags & AxisFlag.REFERENCED)
        fresh, self._referenced = referenced & ~self._referenced, referenced
        for number, data in self._wanted.items():
            if referenced >> number - 1 & 1 and ((fresh >> number - 1 & 1 and self._seen) or number not in self.synchronised):
                self.synchronised[number] = data
                self.asynchronous.discard(number)
        self._seen = True
        return before > 0 and not self.asynchronous
