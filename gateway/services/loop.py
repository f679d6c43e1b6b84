"""The services process (asyncio): lines, Modbus servers, the dispatcher of commands, the journal; and the generation of motion pieces.

A list of parts and a tick.  It may die at any time: the cycle then ends motion as configured, a successor takes over the regions, starts
nothing on its own and adopts the commands it finds (AX-141).
"""

import argparse
import asyncio
import contextlib
import signal
import sys
import time
from collections.abc import Sequence

from gateway.assembly.axes import axis_facts, make_planner
from gateway.assembly.data_block_signals import inputs_of
from gateway.assembly.drive_buses import LISTENS
from gateway.assembly.run import RunPlan, load_plan
from gateway.assembly.telegrams import named_values
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import OnLoss
from gateway.pure.arbitration.link_watch import LinkWatch
from gateway.pure.cell.cell import Line
from gateway.pure.cell.modbus import Modbus
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, unpack_cell_state
from gateway.registry import LINE_LAYERS
from gateway.runtime.journal import Journal
from gateway.runtime.realtime import Timerfd, die_with_parent, go_ahead
from gateway.runtime.regions import RegionReader, RegionWriter, fds_from_text
from gateway.runtime.spare import OPTION, called
from gateway.services.canopen import CanopenServices
from gateway.services.cell_errors import CellErrors
from gateway.services.cell_values import CellValues
from gateway.services.contacts import DigitalContacts
from gateway.services.context import RunContext
from gateway.services.controller_host import ControllerHost
from gateway.services.cycle_watch import CycleWatch
from gateway.services.input_ages import InputAges
from gateway.services.page_interface import PageInterfaces
from gateway.services.part import Part
from gateway.services.part_context import PartContext
from gateway.services.planner_link import PlannerLink
from gateway.services.plant_addresses import PlantAddresses
from gateway.services.publisher import Publisher
from gateway.services.recording_tap import ServicesTap
from gateway.services.retained_file import file_of
from gateway.services.routes import Bridge
from gateway.services.shared_image import RcOutputs, SharedImage
from gateway.services.sources.base import BaseSource, SourceContext
from gateway.services.status_size import fitted
from gateway.services.tool_server import Variables
from gateway.services.value_directory import ValueDirectory
from protocols.base.machine import Ns, ms

TICK_NS, QUICKEST_NS = ms(5), ms(2)
STATUS_EVERY = 20  # ticks
SWITCH_S = 0.001  # threads of the masters of CANopen buses yield to the loop after this (5 ms are usual)


def tick_ns(plan: RunPlan) -> Ns:
    """Time between two turns: with an integrated PLC not longer than a cycle, because its inputs and outputs pass here (AX-1767)."""
    quick = plan.cell.controller is not None and plan.cell.controller.plc is not None
    return min(TICK_NS, max(ms(plan.p5_ms), QUICKEST_NS)) if quick else TICK_NS


class Services:
    """Makes the parts of one run and steps them."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        cell, now = plan.cell, time.monotonic_ns()
        self.started_ns = now
        self.timer = Timerfd()
        self._done = asyncio.Event()
        self.run_context = run = RunContext(cell, plan, Journal(plan.journal, "services"), ServicesTap(fds))
        inputs = RegionWriter(fds["rc_in"], "rc_in")
        self.image = image = SharedImage(RcOutputs(RegionReader(fds["rc_out"], "rc_out")), _owners(plan), inputs.latest())
        self.values = values = ValueDirectory(named_values(cell))
        cell_values = CellValues(cell, image, values)
        values.register(cell_values)
        self.dispatcher = dispatcher = self._dispatcher(fds)
        context = PartContext(run, image, values, dispatcher)
        self._blind = {name: f"bus {name} {LISTENS}" for name in plan.listening}
        dispatcher.admission.listen_only = {
            n: self._blind[axis.drive.bus] for n, axis in enumerate(cell.axis) if axis.drive.bus in self._blind
        }
        for words in self._blind.values():
            run.journal.write("alarm", words)
        self.errors = ErrorList()
        self.sources = [self._source(number, fds) for number in range(len(plan.sources))]
        self.canopen = canopen = self._masters(fds)
        planner = PlannerLink(fds)
        self.cycle = cycle = CycleWatch(run, image, cell_values, dispatcher, canopen, planner, fds)
        self.contacts = contacts = DigitalContacts(run, image, values, canopen.coupler_fault, fds)
        self.bridge = Bridge(run, image, values, contacts, canopen.parameters.put, fds, self.on_cycle)
        self.clients = self._clients()
        self.tools = PageInterfaces(run, image, values, dispatcher, canopen, contacts, self.sources)
        self.host = host = ControllerHost(context, self.errors, self._last_heard, planner.end, fds, now)
        self.retained = self._retained(fds)
        if host.control is not None:
            for source in self.sources:
                source.join(host.control)
        addresses = PlantAddresses(cell, image, values)
        values.register(addresses)
        self.variables = Variables(context, self.tools, contacts, host, addresses, self.bridge.facts_of, self.status)
        self.cell_errors = CellErrors(context, cell_values, self.sources, cycle, canopen, contacts, host, fds)
        self.publisher = Publisher(context, cell_values, self.bridge, host, self.cell_errors.alarms, planner, inputs, fds["orders"])
        image.goes_on = self.publisher.publish
        image.cycle_lives = lambda: cycle.lives(time.monotonic_ns())
        self._links = RegionWriter(fds["links"], "links")
        ages = InputAges(image, self.sources, lambda: self.tools.permits, now)
        self.stepped: Sequence[Part] = (
            cycle, *self.sources, self.tools, ages, host, self.clients, self.cell_errors, self.publisher
        )  # fmt: skip
        self._ticks = 0

    # ---- making the parts --------------------------------------------------------------------------------------------
    def _dispatcher(self, fds: dict[str, int]) -> CommandDispatcher:
        cell = self.run_context.cell
        published = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT).read()
        first_job = 1 if published is None else unpack_cell_state(published).taken + 1000
        programs = {number: program.facts for number, program in self.run_context.plan.programs.items()}
        return CommandDispatcher(axis_facts(cell), make_planner(cell), first_job, programs)

    def _masters(self, fds: dict[str, int]) -> CanopenServices:
        return CanopenServices(self.run_context.plan, fds, self.run_context.journal.write)

    def _source(self, index: int, fds: dict[str, int]) -> BaseSource:
        run, source = self.run_context, self.run_context.plan.sources[index]
        region = RegionWriter(fds[f"source-{source.number}"], f"source-{source.number}")
        if source.kind == "pic":
            from gateway.services.sources.pic import SILENT_MS, PicSource  # only cells that have one pay for it

            silent = LinkWatch(ms(SILENT_MS), has_life_word=False)
            return PicSource(SourceContext(run, self.image, self.values, self.dispatcher, source, silent, OnLoss.STOP, region))
        if source.kind == "modbus":
            modbus = next(m for m in run.cell.modbus if m.name == source.name)
            watch, on_loss = LinkWatch(ms(modbus.max_silence_ms), has_life_word=False), OnLoss(modbus.on_loss)
            return self._server(SourceContext(run, self.image, self.values, self.dispatcher, source, watch, on_loss, region), modbus)
        line = next(x for x in run.cell.line if x.name == source.name)
        watch = LinkWatch(ms(line.supervision.max_silence_ms), has_life_word=line.supervision.life_word is not None)
        on_loss = OnLoss(line.supervision.on_loss)
        return self._line(SourceContext(run, self.image, self.values, self.dispatcher, source, watch, on_loss, region), line)

    def _server(self, context: SourceContext, settings: Modbus) -> BaseSource:
        from gateway.services.sources.modbus import ModbusSource  # its library: only cells with [[modbus]] pay for it

        made = ModbusSource(context)
        made.listen(settings)
        return made

    def _line(self, context: SourceContext, line: Line) -> BaseSource:
        return LINE_LAYERS[line.layer].source()(context, line)

    def _clients(self) -> Part:
        """Clients of a cell that has some; loaded only then."""
        if not any(modbus.role == "client" for modbus in self.run_context.cell.modbus):
            return Part()
        from gateway.services.modbus_clients import ModbusClients

        return ModbusClients(self.run_context, self.values)

    def _retained(self, fds: dict[str, int]) -> Part:
        """Retained data of a run that keeps some; loaded only then."""
        path = file_of(self.run_context.plan)
        if path is None:
            return Part()
        from gateway.services.retained import RetainedData

        kept = RetainedData(self.run_context, self.image, self.values, self.dispatcher, self.errors, path, self.started_ns, fds)
        kept.restore(self.host.control)
        return kept

    # ---- life --------------------------------------------------------------------------------------------------------
    async def run(self) -> None:
        """Until SIGTERM."""
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGTERM, self._done.set)
        loop.add_reader(self.timer.fileno(), self._on_timer)
        tick = tick_ns(self.run_context.plan)
        self.timer.set(time.monotonic_ns() + tick, tick)
        early: Sequence[Part] = (self.contacts, self.clients, self.bridge)
        late: Sequence[Part] = (*self.sources, self.variables)
        closed: Sequence[Part] = (self.variables, self.canopen, self.contacts, self.clients, self.retained, self.cycle, *self.sources)
        for part in early:
            await part.start()
        self.tick()
        for part in late:
            await part.start()
        await self._done.wait()
        for part in closed:
            await part.close()
        self.timer.close()
        self.run_context.journal.close()
        await self.cell_errors.close()

    def _on_timer(self) -> None:
        if self.timer.expired():
            self.tick()

    def tick(self) -> None:
        """Periodic work: every part in order, then the life counter."""
        now = time.monotonic_ns()
        self._ticks += 1
        for part in self.stepped:
            part.step(now)
        self._links.beat(now)
        self.retained.step(now)
        self.cycle.keep_places()
        if self._ticks % STATUS_EVERY == 1:
            self._links.write(fitted(self.status(), self._links.size), now)

    def on_cycle(self) -> None:
        """The cycle has published: update what depends on it in routes and contacts at once."""
        self.cycle.step(time.monotonic_ns())
        self.publisher.publish()

    def _last_heard(self) -> Ns:
        return max((source.watch.last_ns for source in self.sources if source.kind != "pic"), default=0)

    # ---- status for tools
    def status(self) -> dict[str, object]:
        """Links and errors for tools; kept under the size of the region."""
        modbus = self.contacts.modbus
        return {
            "command_sources": [source.row() for source in self.sources],
            "owner": self.dispatcher.owner,
            **({"listening": list(self._blind)} if self._blind else {}),
            "forced": self.image.forces.count,
            **({"permits": True} if self.tools.permits else {}),
            **self.canopen.status(),
            **self.host.status(),
            **self.retained.status(),
            **self.bridge.status(),
            **self.clients.status(),
            **({"modbus_couplers": modbus.status()} if modbus is not None else {}),
            "errors": [{"code": code, "text": words} for code, words in self.values.errors[:8]],
            "inputs": {str(octet): self.image.inputs.values[octet] for octet in self.image.owners},
        }


def _owners(plan: RunPlan) -> dict[int, int]:
    """RC input byte -> number of the command source that writes it: as configured, else by the entries of its data blocks."""
    owners = {octet: plan.source(name).number for octet, name in plan.cell.rc_inputs.owner.items()}
    for line, places in inputs_of(plan.cell).items():
        for bit in places.values():
            owners.setdefault(bit >> 3, plan.source(line).number)
    return owners


async def _run(plan: RunPlan, fds: dict[str, int]) -> None:
    services = Services(plan, fds)
    await services.run()


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate services", description="the services process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    parser.add_argument(OPTION, action="store_true", help="stand by until a line on standard input")
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    go_ahead()
    sys.setswitchinterval(SWITCH_S)
    if arguments.spare and not called():
        return 0
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_run(load_plan(arguments.plan), fds_from_text(arguments.fds)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
