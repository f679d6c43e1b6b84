"""How a PHG 2000 works with the control: machine parameter P35.  Source: rho 3 Releases L9166-9202; rho3 P35, AX-490."""

from dataclasses import dataclass
from enum import IntEnum

from protocols.base.errors import ProtocolError


class PhgMode(IntEnum):
    """P35; 0 is set at delivery."""

    TRANSPARENT = 0
    PHG3 = 1


class PhgError(ProtocolError):
    """A parameter or an output that the pendant's mode does not know."""


@dataclass(frozen=True, slots=True)
class Operation:
    """What holds between pendant and control."""

    mode: PhgMode
    baud: int
    lines: int  # of text
    columns: int
    pixels: tuple[int, int] | None  # size of the graphic display where transparent output may reach it
    control_leads: bool  # False: the pendant leads and shows its own masks

    @property
    def transparent(self) -> bool:
        """Whether frames of gateway.pure.controllers.rho3.pendant.frames may be sent."""
        return self.pixels is not None


def operation(p35: int, *, display_disabled: bool = False) -> Operation:
    """From P35 and the PLC's signal that disables the pendant's display; PhgError for another P35 than 0 and 1.

    In both modes WRITE PHG goes to 4 lines of 20 characters; only in transparent mode the 256 x 128 pixels can be written, and only
    there a disabled display passes the lead to the pendant with its own masks.
    """
    try:
        mode = PhgMode(p35)
    except ValueError as error:
        raise PhgError(f"P35 = {p35}: 0 (transparent, 9600 baud) or 1 (as PHG 3, 4800 baud)") from error
    if mode is PhgMode.PHG3:
        return Operation(mode, 4800, 4, 20, None, control_leads=True)
    return Operation(mode, 9600, 4, 20, (256, 128), control_leads=not display_disabled)
