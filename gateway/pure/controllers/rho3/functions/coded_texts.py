"""Coded text output: number and strobe of the PLC, a text on lines 2 and 3.  Source: rho 3 Releases L882-958; rho3 3.3."""

from gateway.pure.controllers.rho3.functions.addresses import Edge, Places, Pulse, number_at, trusted
from gateway.pure.controllers.rho3.functions.dat_lines import Table
from gateway.pure.controllers.rho3.functions.display import COLUMNS, Display, Layer
from gateway.pure.controllers.rho3.functions.messages import Text
from gateway.pure.image.records.cell import InputImage
from protocols.base.machine import Ns


class CodedTexts:
    """One text per rising edge of the strobe; each is answered by one of two pulses of P9."""

    def __init__(self, places: Places, strobe_time: Ns, table: Table[str] | None) -> None:
        self.table = table
        self._places = places
        self._edge = Edge(places.text_strobe)
        self._ok, self._error = Pulse(places.text_ok, strobe_time), Pulse(places.text_error, strobe_time)

    def step(self, inputs: InputImage, outputs: bytearray, display: Display, now: Ns, *, ready: bool = True) -> Text | None:
        """ready: a panel is connected and accepts characters.  Return why a text was refused."""
        edge = self._edge.step(inputs)
        refusal = None
        if edge > 0:
            code = number_at(inputs.values, self._places.text_code, 8)
            refusal = self._show(code, display, ready) if trusted(inputs, self._places.text_code) else Text("not_good")
            (self._ok if refusal is None else self._error).give()
        if not inputs.bit(self._places.text_strobe):
            display.release(Layer.CODED)  # from now on the system may write over it (L896-898, AX-535)
        self._ok.step(outputs, now)
        self._error.step(outputs, now)
        return refusal

    def _show(self, code: int, display: Display, ready: bool) -> Text | None:
        if self.table is None:
            return Text("no_file")
        if code not in self.table.entries:
            return Text("no_code", (self.table.file, f"{code:02X}"))
        if not ready:
            return Text("channel_off")
        if display.occupied(Layer.CODED):
            return Text("channel_busy")
        text = self.table.entries[code]
        display.hold(Layer.CODED)
        display.write(Layer.CODED, 2, text[:COLUMNS])
        display.write(Layer.CODED, 3, text[COLUMNS:])
        return None
