"""Outputs of the services: orders into their rings, events into the journal, RC inputs into their region."""

import time

from gateway.pure.cell.web import PAGE_SOURCE
from gateway.pure.image.records.cell import ORDER_LAYOUT, pack_inputs, pack_order
from gateway.runtime.regions import RegionWriter, RingWriter
from gateway.services.alarm_file import AlarmFile
from gateway.services.cell_values import CellValues
from gateway.services.controller_host import ControllerHost
from gateway.services.part import Part
from gateway.services.part_context import PartContext
from gateway.services.planner_link import PlannerLink
from gateway.services.routes import Bridge
from gateway.services.tool_interface import TOOL_SOURCE
from motion.execution.pieces import record_size
from protocols.base.machine import Ns

NAMES = {TOOL_SOURCE: "commissioning tool", PAGE_SOURCE: "page"}


class Publisher(Part):
    """With each tick, and at once when a part has written something (SharedImage.pass_on)."""

    def __init__(
        self,
        context: PartContext,
        cell_values: CellValues,
        bridge: Bridge,
        host: ControllerHost,
        alarms: AlarmFile,
        planner: PlannerLink,
        inputs: RegionWriter,
        orders: int,
    ) -> None:
        """`inputs`: the region of the RC inputs; `orders`: the descriptor of the ring to the cycle."""
        self._run, self._image, self._dispatcher, self._cell_values = context.run, context.image, context.dispatcher, cell_values
        self._bridge, self._host, self._alarms, self._planner, self._inputs = bridge, host, alarms, planner, inputs
        self._orders = RingWriter(orders, "orders", ORDER_LAYOUT)
        self._piece_size = record_size(len(context.run.cell.axis))
        self._written = b""

    def step(self, now: Ns) -> None:
        self.publish()

    def publish(self) -> None:
        """Routes and the control first: their writes are included."""
        now = time.monotonic_ns()
        self._bridge.step(now)
        self._host.inputs_came(now)
        self._events()
        self._image.changed = False
        payload = pack_inputs(self._host.for_cycle(self._image.for_cycle()))
        if payload != self._written:
            self._written = payload
            self._inputs.write(payload, time.monotonic_ns())
        for order in self._dispatcher.take_orders():
            self._orders.put(pack_order(order, self._piece_size))
        self._planner.order(self._dispatcher.take_programs())
        self._planner.say(self._image.statements)
        self._image.statements.clear()
        self._host.pass_on()

    def _events(self) -> None:
        language, refusals = self._run.cell.cell.language, self._cell_values.refusals
        for event in self._dispatcher.take_events():
            self._run.journal.write(
                "command", event.sentence(), source=event.source, code=event.code, what=event.what, reason=int(event.reason)
            )
            self._alarms.event(event, NAMES)
            if event.what in ("refused", "aborted"):
                refusals[event.source] = (int(event.reason), event.sentence(language), time.monotonic_ns())
            elif event.what == "accepted":
                refusals.pop(event.source, None)
