"""The Modbus view of a Reis or of a VAL 3 controller for [controller] of a cell; loaded only if a server needs it."""

from collections.abc import Callable, Collection

from gateway.assembly.controllers import points_of
from gateway.pure.cell.controller import Controller
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.binary import BYTES
from gateway.pure.controllers.reis.markers import SIZE
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.image.records.cell import InputImage
from gateway.pure.modbus.other_views import STATES_AT, Image, ReisView, Val3View
from gateway.pure.modbus.registers import Registers
from gateway.pure.modbus.rho3_view import FLAGS_AT
from gateway.registry import MODBUS_VIEWS

__all__ = ["OtherView", "ReisView", "Val3View", "join", "reis_registers", "reis_view", "val3_registers", "val3_view", "view_of"]

OtherView = ReisView | Val3View


def reis_registers() -> list[int]:
    """Registers the view of a Reis control has."""
    return [*range(BYTES // 2), *range(FLAGS_AT, FLAGS_AT + SIZE // 2)]


def val3_registers(controller: Controller | None) -> list[int]:
    """Registers the view of a VAL 3 controller has: those of its points."""
    points = controller.point if controller is not None else ()
    analog = [sum(1 for point in points if point.steps and point.output is output) for output in (False, True)]
    return [*range(2 * max(analog)), *range(STATES_AT, STATES_AT + len(points))]


def reis_view(controller: Controller, image: Image, registers: Registers | None) -> OtherView:
    """Bytes and markers of a Reis control."""
    return ReisView(image, controller.first_byte, registers)


def val3_view(controller: Controller, image: Image, registers: Registers | None, order: str) -> OtherView:
    """Points of a VAL 3 controller."""
    return Val3View(image, points_of(controller), order, registers)


def view_of(
    controller: Controller,
    inputs: InputImage,
    owned: Collection[int],
    written: Callable[[Collection[int]], None],
    registers: Registers | None,
    order: str,
) -> OtherView:
    """The view of this control; `join` adds the control itself once that exists."""
    image = Image(inputs, frozenset(owned), written)
    make = MODBUS_VIEWS[controller.kind].make
    assert make is not None  # the cell's checks have seen to its kind
    return make(controller, image, registers, order)


def join(view: OtherView, control: Control) -> None:
    """Markers, or points with their states."""
    if isinstance(view, ReisView):
        view.flags = control
    elif isinstance(control, Val3Control):
        view.control = control
