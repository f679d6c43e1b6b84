"""RC inputs with the correction of an application: what the interpreter writes takes effect in the next cycle (AX-1062)."""

from collections.abc import Mapping

from gateway.cycle.recording_tap import CycleTap
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.correction_inputs import laid_over
from gateway.pure.image.records.cell import InputImage, pack_inputs
from gateway.pure.image.records.correction import CORRECTION_LAYOUT, ProgramCorrection, unpack_correction
from gateway.runtime.regions import RegionReader


class Corrected:
    """Copies the inputs only when one of both has changed."""

    def __init__(self, cell: Cell, fds: Mapping[str, int]) -> None:
        self.there = cell.alter is not None and "correction" in fds
        self._byte = cell.alter.input >> 3 if cell.alter is not None else 0
        self._region = RegionReader(fds["correction"], "correction", CORRECTION_LAYOUT) if self.there else None
        self._index = 0
        self._now = ProgramCorrection()
        self._seen: InputImage | None = None
        self._made = InputImage()

    def over(self, image: InputImage, tap: CycleTap) -> InputImage:
        """As the cycle judges them."""
        assert self._region is not None
        payload = self._region.read()
        if payload is not None and self._region.index != self._index:
            self._index, self._now, self._seen = self._region.index, unpack_correction(payload), None
        if self._seen is not image:
            self._seen, self._made = image, laid_over(image, self._now, self._byte)
            if self._made is not image:
                tap.image(pack_inputs(self._made))
        return self._made
