"""The PIC program of the interpreter as a command source: it owns RC input bytes like a line (AX-981)."""

from gateway.pure.controllers.control import Control
from gateway.pure.controllers.rho3.functions.addresses import Places
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.drives import ALL_ON, AXES, FIRST_DRIVE
from gateway.pure.controllers.rho3.signals.errors import ACKNOWLEDGE, CONTROL_RESET
from gateway.pure.controllers.rho3.signals.pic import FreshEdges
from gateway.pure.image.records.cell import Quality
from gateway.services.sources.base import BaseSource
from protocols.base.machine import Ns

SILENT_MS = 1_000  # it reports ten times a second


def edges_of(places: Places) -> list[int]:
    """RC inputs that act as they rise: drives on, selection, abort, resets, keys and texts of the panel."""
    strobes = (places.select_strobe, places.abort_strobe, places.phg_strobe, places.text_strobe)
    return [ALL_ON, *range(FIRST_DRIVE, FIRST_DRIVE + AXES), *strobes, CONTROL_RESET, ACKNOWLEDGE]


class PicSource(BaseSource):
    """Outputs of its scans become RC inputs at once."""

    def join(self, control: Control) -> None:
        assert isinstance(control, RhoControl) and control.pic is not None  # as `check` has it
        self._fresh = FreshEdges(edges_of(control.setup.functions.places))
        control.pic.take, control.pic.gone = self.take, self.gone

    def gone(self) -> None:
        """Its bytes are bad until the next one has scanned for a while."""
        self._fresh.lost()
        for octet, number in self._image.owners.items():
            if number == self.number:
                self._image.age(octet, Quality.BAD)

    def take(self, outputs: bytes, now: Ns) -> None:
        """O0 to O127 after a scan."""
        self.heard(now)
        acting = self._fresh.passed(outputs, now)
        if acting is None:
            return
        for octet, number in self._image.owners.items():
            if number == self.number:
                self._image.write(octet, acting[octet : octet + 1], now)
