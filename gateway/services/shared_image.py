"""Shared image of all parts of the services: RC inputs with their owners, RC outputs, forces, the state of the cell.

Every part writes RC inputs through this class, which sets one mark, `changed`; `pass_on` passes written values on at once instead of with
the next tick.
"""

from collections.abc import Callable, Collection, Mapping
from typing import Protocol

from gateway.pure.controllers.control import Control
from gateway.pure.controllers.rho3.signals.coupling import Coupled
from gateway.pure.image.records.cell import RC_BYTES, CellState, InputImage, Quality, get_bit, set_bit, unpack_inputs
from gateway.pure.image.records.planner import BlockRecord
from gateway.pure.routes.addresses import Place, put_at
from gateway.services.forces import Forces
from protocols.base.machine import Ns


class Published(Protocol):
    """A region another process writes."""

    def read(self) -> bytes | None:
        """Its latest payload; None: nothing has been published yet."""


class RcOutputs:
    """RC outputs as command sources, routes and tools read them."""

    def __init__(self, region: Published) -> None:
        self.region = region
        self.control: Control | None = None

    def read(self) -> bytes | None:
        """The cycle's, with those of the control; None: nothing has been published yet."""
        return self.region.read() if self.control is None else self.control.outputs


class SharedImage:
    """Owned by the services process; one thread."""

    def __init__(self, outputs: RcOutputs, owners: Mapping[int, int], left: bytes | None = None) -> None:
        """`owners`: RC input byte -> number of its command source; `left`: inputs of a predecessor, stale until they are written."""
        self.inputs = InputImage() if left is None else unpack_inputs(left)
        for octet in range(RC_BYTES):
            self.inputs.quality[octet] = Quality.STALE if self.inputs.quality[octet] else Quality.BAD
        self.outputs, self.owners = outputs, owners
        self.forces = Forces()
        self.state = CellState()  # as the cycle published it last
        self.coupled: Coupled | None = None  # bit coupling of a control that has one
        self.statements: list[BlockRecord] = []  # of streams, for the planner after its orders
        self.changed = False  # an RC input was written since they were last passed to the cycle
        self.goes_on: Callable[[], None] = _nothing  # set by the process
        self.cycle_lives: Callable[[], bool] = _yes  # the cycle's published state is recent enough; set by the process

    @property
    def control(self) -> Control | None:
        """The control of [controller]; None: this cell has none."""
        return self.outputs.control

    @control.setter
    def control(self, control: Control | None) -> None:
        self.outputs.control = control

    def pass_on(self) -> None:
        """Pass written values on at once: to routes, to the control, to the cycle."""
        self.goes_on()

    # ---- RC inputs ---------------------------------------------------------------------------------------------------
    def input_bit(self, number: int) -> bool:
        """RC input N as it is, a forced one as it is forced."""
        return self.forces.bits.get(number, get_bit(self.inputs.values, number))

    def for_cycle(self) -> InputImage:
        """RC inputs with the forces over them."""
        return self.forces.over(self.inputs)

    def owned_by(self, number: int, octets: Collection[int]) -> bool:
        """All these bytes are this command source's."""
        return all(self.owners.get(octet) == number for octet in octets)

    def write(self, first: int, data: bytes, now: Ns) -> None:
        """Write complete bytes from `first` on; they become good."""
        self.inputs.values[first : first + len(data)] = data
        self.judge(range(first, first + len(data)), Quality.GOOD, now)

    def put_bit(self, number: int, value: bool) -> None:
        """One bit; the quality of its byte stays."""
        set_bit(self.inputs.values, number, value)
        self.changed = True

    def put_number(self, place: Place, value: float) -> None:
        """A number of a route; the quality of its bytes stays."""
        put_at(place, self.inputs.values, value)
        self.changed = True

    def judge(self, octets: Collection[int], quality: Quality | int, now: Ns) -> None:
        """How good these bytes are from now on."""
        for octet in octets:
            self.inputs.quality[octet], self.inputs.stamps[octet] = quality, now
        self.changed = True

    def age(self, octet: int, quality: Quality) -> None:
        """Its source is silent: another quality, the stamp of the last write stays."""
        self.inputs.quality[octet] = quality
        self.changed = True


def _nothing() -> None:
    """Until the process has set its own function."""


def _yes() -> bool:
    """For a cell without a cycle, as in a test of one part."""
    return True
