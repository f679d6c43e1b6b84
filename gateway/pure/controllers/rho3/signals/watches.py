"""What a control watches: that its PLC answers, that its PIC runs in time, what the cycle reports.  Pure."""

from collections.abc import Callable

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.codes import PLC_SILENT, CycleErrors
from gateway.pure.controllers.rho3.signals.errors import Faults
from gateway.pure.controllers.rho3.signals.setup import Setup
from gateway.pure.controllers.rho3.signals.supervision import PicGuard, PlcWatch
from gateway.pure.image.records.cell import CellState
from protocols.base.machine import Ns

SETTLES = 200  # cycles after a start in which a late one does not indicate a timer fault (AX-478)


class Watches:
    """Each as far as the cell has it."""

    def __init__(self, setup: Setup, faults: Faults, now: Ns) -> None:
        self._faults = faults
        self._cycle = CycleErrors(faults, setup.axes)
        self._plc = PlcWatch(setup.plc_silence, now, setup.plc_grace) if setup.plc_silence else None
        self._pic = PicGuard(setup.pic_timeout, SETTLES) if setup.pic_timeout else None

    @property
    def stopped(self) -> bool:
        """The PIC's timer has failed."""
        return self._pic is not None and self._pic.stopped

    @property
    def guarded(self) -> bool:
        """The time of the PIC is watched."""
        return self._pic is not None

    def run(self, image: PicImage, now: Ns, program: Callable[[], None]) -> None:
        """One cycle of the control, or none where the timer has failed."""
        if self._pic is None:
            program()
        else:
            self._pic.run(image, now, lambda _: program())

    def look(self, state: CellState, now: Ns, *, heard: bool) -> None:
        """Call once per cycle; `heard`: the PLC has transmitted since."""
        self._cycle.look(state, now)
        plc = self._plc
        if plc is not None and heard:
            plc.heard(now)
        if plc is not None and plc.wake(now):
            self._faults.came(PLC_SILENT, now=now)
