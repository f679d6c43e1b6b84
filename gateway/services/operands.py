"""Operands of PLC programs besides single inputs and outputs, in a running cell: E and A bytes to double words, flags, timers, counters.

Inputs of a PLC (E, I) are RC outputs, its outputs (A, Q) RC inputs, at the PIC's addresses (AX-120).  Words have the high byte first as
a PLC of the S5 family has them (AX-010); markers of a Reis the low byte (robotstar D-16).
"""

from typing import Literal

from gateway.pure.cell.cell import Cell
from gateway.pure.image.addresses import Kind, Operand
from gateway.pure.image.records.cell import RC_BYTES
from gateway.registry import CONTROLLERS
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import ValueDirectory


class Operands:
    """Reads, and in a simulation writes, operands of the running cell."""

    def __init__(self, cell: Cell, image: SharedImage, values: ValueDirectory) -> None:
        self._cell, self._image, self._values = cell, image, values

    def there(self, place: Operand) -> bool:
        """This cell has it: every cell has inputs and outputs, one with a control the rest."""
        return self.number(place) is not None

    def number(self, place: Operand) -> int | None:
        """Its value, unsigned; None: the cell has none."""
        control = self._image.control
        if place.kind is Kind.TIMER:
            return None if control is None else control.timer(place.number)
        if place.kind is Kind.COUNTER:
            return None if control is None else control.counter(place.number)
        area = self._area(place.kind)
        if place.bit is not None:
            coordinated = place.kind is Kind.FLAG and self._coordination(place)
            return None if place.number >= len(area) else int(area[place.number] >> place.bit & 1 or coordinated)
        part = area[place.number : place.number + place.bytes]
        return int.from_bytes(part, self._order()) if len(part) == place.bytes else None

    def get(self, text: str, place: Operand) -> dict[str, object] | None:
        """As `var` shows it; None: the cell has none."""
        value = self.number(place)
        if value is None:
            return None
        shown: dict[str, object] = {"address": text, "place": f"{place}{self._remark(place)}", "value": value}
        if place.bytes:
            signed = value - (1 << 8 * place.bytes) if place.bytes > 1 and value >> 8 * place.bytes - 1 else value
            shown |= {"value": signed, "KH": f"{value:0{2 * place.bytes}X}"}
        return shown

    def put(self, text: str, place: Operand, value: str) -> dict[str, object] | None:
        """As the PLC's program would write a flag; the answer when it cannot be."""
        control = self._image.control
        if place.kind is not Kind.FLAG or control is None:
            return {"error": f"{text}: only flags are written here; inputs are their command source's, outputs and timers the control's"}
        bits = 8 * place.bytes or 1
        try:
            number = int(value, 0)
        except ValueError:
            number = 1 << bits
        if not -(1 << bits - 1) * (bits > 1) <= number < 1 << bits:
            return {"error": f"{text} = {value!r}: a whole number of {bits} bits is expected"}
        return None if self.write(place, number) else {"error": f"{text}: the system writes it, or there is no such flag"}

    def write(self, place: Operand, number: int) -> bool:
        """A flag, or the low bytes of the number to flag bytes; False: the system's, or not there."""
        control = self._image.control
        if control is None:
            return False
        if place.bit is None:
            size = place.bytes
            return control.write_flags(place.number, (number & (1 << 8 * size) - 1).to_bytes(size, self._order()))
        flags = control.flag_bytes()
        if place.number >= len(flags):
            return False
        old, mask = flags[place.number], 1 << place.bit
        return control.write_flags(place.number, bytes((old | mask if number else old & ~mask,)))

    def _area(self, kind: Kind) -> bytes:
        if kind is Kind.INPUT:
            return self._image.outputs.read() or bytes(RC_BYTES)
        if kind is Kind.OUTPUT:
            return bytes(self._image.for_cycle().values)
        return b"" if self._image.control is None else self._image.control.flag_bytes()

    def _coordination(self, place: Operand) -> bool:
        """A coordination flag of a line is at the same place."""
        return any(flag.byte == place.number and flag.bit == place.bit for line in self._values.lines for flag in line.flags.set)

    def _order(self) -> Literal["big", "little"]:
        controller = self._cell.controller
        return "little" if controller is not None and CONTROLLERS[controller.kind].little else "big"

    @staticmethod
    def _remark(place: Operand) -> str:
        match place.kind:
            case Kind.INPUT:
                return f" (RC outputs from bit {8 * place.number})"
            case Kind.OUTPUT:
                return f" (RC inputs from bit {8 * place.number})"
            case Kind.TIMER:
                return " (rest in ms)"
        return ""
