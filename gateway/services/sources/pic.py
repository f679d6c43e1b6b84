"""The PIC program of the interpreter as a command source: it owns RC input bytes like a line (AX-981)."""

from gateway.pure.controllers.control import Control
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.image.records.cell import Quality
from gateway.services.sources.base import BaseSource
from protocols.base.machine import Ns

SILENT_MS = 1_000  # it reports ten times a second


class PicSource(BaseSource):
    """What its scans put out becomes RC inputs at once."""

    def join(self, control: Control) -> None:
        assert isinstance(control, RhoControl) and control.pic is not None  # as `check` has it
        control.pic.take, control.pic.gone = self.take, self.gone

    def gone(self) -> None:
        """Its bytes are bad until the first scan of the next one."""
        for octet, number in self._image.owners.items():
            if number == self.number:
                self._image.age(octet, Quality.BAD)

    def take(self, outputs: bytes, now: Ns) -> None:
        """O0 to O127 after a scan."""
        self.heard(now)
        for octet, number in self._image.owners.items():
            if number == self.number:
                self._image.write(octet, outputs[octet : octet + 1], now)
