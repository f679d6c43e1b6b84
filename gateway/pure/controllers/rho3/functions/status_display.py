"""Machine status display, mode 7.12.  Source: rho 3 Releases L798-880; rho3 3.3, AX-537."""

from gateway.pure.controllers.rho3.functions.addresses import Places
from gateway.pure.controllers.rho3.functions.dat_lines import Table
from gateway.pure.controllers.rho3.functions.display import Display, Layer
from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.image.records.cell import InputImage, get_bit, set_bit
from protocols.base.machine import Ns, ms

PERIOD: Ns = ms(1000)  # of the automatic display ("cyclically in seconds", L826)
MANUAL, AUTOMATIC = "7.12.1", "7.12.2"
_ROWS = 2


class StatusDisplay:
    """Shows the texts of the inputs that are 1, two at a time, on lines 2 and 3."""

    def __init__(self, places: Places, table: Table[str] | None, language: str = "en", period: Ns = PERIOD) -> None:
        self.table = table
        self._places, self._language, self._period = places, language, period
        self._mode = ""
        self._top = 0  # number of the status in line 2, 0: none yet
        self._turned: Ns = 0
        self._running = False

    def scroll(self) -> None:
        """SHIFT + arrow: forward by one status; in the automatic display it stops the turning."""
        if self._running:
            self._running = False
        elif self._mode:
            self._top = -self._top  # handed to the next step, which knows the inputs

    def step(self, inputs: InputImage, outputs: bytearray, display: Display, mode: str, now: Ns) -> None:
        """mode: the mode the panel is in."""
        display.tag = say("phg_msd", self._language) if inputs.bit(self._places.msd_active) else ""
        wanted = mode if mode in (MANUAL, AUTOMATIC) else ""
        if wanted != self._mode:
            self._mode, self._top, self._turned, self._running = wanted, 0, now, wanted == AUTOMATIC
        if wanted:
            self._show(self.active(inputs), display, now)
        set_bit(outputs, self._places.msd_open, mode == "7.12" or mode.startswith("7.12."))

    def active(self, inputs: InputImage) -> list[int]:
        """Numbers of the statuses that are 1 and have a text, in order."""
        entries = self.table.entries if self.table else {}
        return [number for number in sorted(entries) if get_bit(inputs.values, self._places.statuses + number - 1)]

    def _show(self, active: list[int], display: Display, now: Ns) -> None:
        display.write(Layer.STANDARD, 1, say("phg_msd_title", self._language))
        if self.table is None:
            rows = [say("phg_msd_missing", self._language), ""]
        elif not active:
            rows = [say("phg_no_status", self._language), ""]
        else:
            self._turn(active, now)
            at = active.index(self._top)
            shown = (active[at:] + active[:at])[:_ROWS]
            rows = [f"{number:02} {self.table.entries[number]}" for number in shown]
        for line in range(_ROWS):
            display.write(Layer.STANDARD, 2 + line, rows[line] if line < len(rows) else "")

    def _turn(self, active: list[int], now: Ns) -> None:
        """The status in line 2 for this cycle: kept, the next one in the ring, or the next that is still there."""
        forward = self._top < 0
        top = abs(self._top)
        if self._running and now - self._turned >= self._period:
            self._turned, forward = now, True
        later = [number for number in active if number > top or (number == top and not forward)]
        self._top = (later or active)[0]
