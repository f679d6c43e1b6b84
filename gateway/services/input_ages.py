"""RC inputs whose command source is silent."""

from collections.abc import Callable, Sequence

from gateway.pure.image.records.cell import Quality
from gateway.services.part import Part
from gateway.services.shared_image import SharedImage
from gateway.services.sources.base import BaseSource
from gateway.services.tool_interface import PERMIT_BYTES
from protocols.base.machine import Ns, ms

INHERITED_NS: Ns = ms(3_000)  # inputs of a predecessor are stale for so long, then they are bad (AX-143)


class InputAges(Part):
    """Bytes of a silent command source are bad; those left over from a predecessor are stale and then bad."""

    def __init__(self, image: SharedImage, sources: Sequence[BaseSource], permits: Callable[[], bool], now: Ns) -> None:
        """`permits`: a tool has set the enabling inputs of a simulated cell; `now`: of the start."""
        self._image, self._sources, self._permits, self._started = image, sources, permits, now

    def step(self, now: Ns) -> None:
        image = self._image
        for octet, number in image.owners.items():
            if octet in PERMIT_BYTES and self._permits():
                continue  # a simulated cell without its PLC, a tool replaces it
            quality = image.inputs.quality[octet]
            if (quality == Quality.GOOD and not self._sources[number - 1].watch.alive) or (
                quality == Quality.STALE and now - self._started > INHERITED_NS
            ):
                image.age(octet, Quality.BAD)
