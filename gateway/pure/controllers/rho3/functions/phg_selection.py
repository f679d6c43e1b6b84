"""Selection of panel functions by the PLC (option 41).  Source: rho 3 Releases L4913-5007; rho3 3.3, AX-538."""

from gateway.pure.controllers.rho3.functions.addresses import Edge, Places, number_at, trusted
from gateway.pure.controllers.rho3.functions.dat_lines import Table
from gateway.pure.controllers.rho3.functions.display import Display, Layer
from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.image.records.cell import InputImage, set_bit

BASE = "0"  # the basic level


class PhgSelection:
    """The mode the panel is in: the operator enters modes, the PLC selects them by code.

    `file_error`: a code without a usable line was selected; the caller reports it and clears it.
    """

    def __init__(self, places: Places, table: Table[str] | None, language: str = "en", *, option: bool = True) -> None:
        self.table, self.mode, self.file_error = table, BASE, False
        self._places, self._language, self._option = places, language, option
        self._edge = Edge(places.phg_strobe)

    def step(self, inputs: InputImage, outputs: bytearray, display: Display) -> None:
        """Process edges of the strobe with the code next to it; bit 104: the basic level is active."""
        edge = self._edge.step(inputs) if self._option and trusted(inputs, self._places.phg_code) else 0
        code = number_at(inputs.values, self._places.phg_code, 4)
        if edge < 0 and code == 0:
            self._go(BASE, display)
        elif edge > 0 and self.mode == BASE:
            self._select(code, display)
        set_bit(outputs, self._places.base_level, self.mode == BASE)

    def _select(self, code: int, display: Display) -> None:
        mode = self.table.entries.get(code) if self.table else None
        if mode is not None:
            self._go(mode, display)
        elif code:  # code 0 needs no line: it only leads back
            self.file_error = True
            display.write(Layer.INFO, 2, say("phg_code_error", self._language))

    def _go(self, mode: str, display: Display) -> None:
        self.mode = mode
        display.close(Layer.INFO)
        display.selected()
