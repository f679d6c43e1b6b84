"""From [controller] of a cell to the Modbus view of a Reis or of a VAL 3 controller; loaded only where a server asks for it."""

from collections.abc import Callable, Collection, Mapping

from gateway.assembly.controllers import points_of
from gateway.pure.cell.controller import Controller
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.image.records.cell import InputImage
from gateway.pure.modbus.other_views import Image, ReisView, Val3View
from gateway.pure.modbus.registers import Registers

__all__ = ["PICTURES", "ReisView", "Val3View", "join", "picture"]

PICTURES: Mapping[str, str] = {"reis": "reis", "val3": "val3"}  # view -> kind of the controller it is of


def picture(
    controller: Controller,
    inputs: InputImage,
    owned: Collection[int],
    written: Callable[[Collection[int]], None],
    registers: Registers | None,
    order: str,
) -> ReisView | Val3View:
    """The view of this control; `join` gives it the control itself once that is made."""
    image = Image(inputs, frozenset(owned), written)
    if controller.kind == "reis":
        return ReisView(image, controller.first_byte, registers)
    return Val3View(image, points_of(controller), order, registers)


def join(view: ReisView | Val3View, control: Control) -> None:
    """Markers, or points with their states."""
    if isinstance(view, ReisView):
        view.flags = control
    elif isinstance(control, Val3Control):
        view.control = control
