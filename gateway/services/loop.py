"""The services process (asyncio): lines, Modbus servers, the dispatcher, the journal; and, in this version, the making of motion pieces.

It may die at any time: the cycle then ends motion as configured, a successor takes the regions over, starts nothing by itself and
adopts whatever commands stand (AX-141).
"""

import argparse
import asyncio
import contextlib
import signal
import sys
import time

from drivers.drives.servodyn_words import sentence as servodyn_fault
from drivers.ports.base import runtime_dir
from gateway.assembly.axes import axis_facts, make_planner
from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.axis_zeros import torn_lines
from gateway.assembly.data_block_signals import inputs_of
from gateway.assembly.drive_buses import LISTENS
from gateway.assembly.last_positions import LastPlaces, judge
from gateway.assembly.run import RunPlan, load_plan
from gateway.assembly.telegrams import named_values
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.link_watch import LinkWatch
from gateway.pure.cell.cell import Line
from gateway.pure.cell.modbus import Modbus
from gateway.pure.cell.web import PAGE_DOOR
from gateway.pure.image.reasons import CommandState, Reason, text
from gateway.pure.image.records.cell import (
    ALL_PERMITS,
    CELL_STATE_LAYOUT,
    ORDER_LAYOUT,
    RC_BYTES,
    AxisFlag,
    AxisState,
    CellState,
    InputImage,
    Motion,
    Quality,
    get_bit,
    pack_inputs,
    pack_order,
    unpack_cell_state,
    unpack_inputs,
)
from gateway.pure.image.records.planner import function_words
from gateway.pure.reports.late_machine import LateMachine
from gateway.runtime.journal import Journal
from gateway.runtime.realtime import Timerfd, die_with_parent, go_ahead
from gateway.runtime.regions import RegionReader, RegionWriter, RingWriter, fds_from_text
from gateway.runtime.spare import OPTION, called
from gateway.services.alarm_file import AlarmFile
from gateway.services.canopen import CanopenServices
from gateway.services.contacts import DigitalContacts
from gateway.services.controller_host import ControllerHost, RcOutputs
from gateway.services.forces import Forces
from gateway.services.io_error_log import IoComplaints
from gateway.services.page_interface import PageInterfaces
from gateway.services.planner_link import PlannerLink
from gateway.services.recording_tap import ServicesTap
from gateway.services.retained import RetainedData
from gateway.services.routes import Bridge
from gateway.services.sources.base import BaseSource, CellValues, SourceContext, on_loss_of
from gateway.services.sources.modbus import ModbusSource, modbus_clients, side_of
from gateway.services.sources.rk512 import Rk512Source
from gateway.services.sources.telegrams import TelegramSource
from gateway.services.status_size import fitted
from gateway.services.tool_interface import PERMIT_BYTES, TOOL_DOOR
from gateway.services.tool_server import Variables
from motion.execution.pieces import record_size
from protocols.base.machine import ms

TICK_NS = ms(5)
INHERITED_NS = ms(3_000)  # inputs a predecessor left stand this long, then they are bad (AX-143)
CYCLE_GONE_NS = ms(250)  # a cycle silent for this long is told to the command sources; restarts at once are quicker only on a fast machine
LINKS_EVERY = 20  # ticks
PLACES_EVERY = 200  # ticks
SERVER_QUICK = 40  # attempts of a Modbus server to listen, 50 ms apart; then it is told and tried every second
ACKNOWLEDGE = 62  # RC input: error acknowledgement
REFUSALS_KEPT_NS = ms(60_000)
WRONG = int(AxisFlag.FAULT | AxisFlag.UNCONFIGURED | AxisFlag.LOST)  # of an axis, in the list of errors
SWITCH_S = 0.001  # threads of the masters of CANopen buses give the loop its turn after this (5 ms are usual)
SERIAL = (Rk512Source, TelegramSource)


class Services:
    """All command sources of one run."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        cell = self.cell = plan.cell
        self.plan = plan
        self.journal = Journal(plan.journal, "services")
        self.axes = RegionReader(fds["axes"], "axes", CELL_STATE_LAYOUT)
        self.rc_out = RcOutputs(RegionReader(fds["rc_out"], "rc_out"))
        self.rc_in = RegionWriter(fds["rc_in"], "rc_in")
        self.links = RegionWriter(fds["links"], "links")
        self.orders = RingWriter(fds["orders"], "orders", ORDER_LAYOUT)
        self.recorded = ServicesTap(fds)
        self.started_ns = time.monotonic_ns()
        latest = self.rc_in.latest()
        self.inputs = InputImage() if latest is None else unpack_inputs(latest)
        for octet in range(RC_BYTES):
            self.inputs.quality[octet] = Quality.STALE if self.inputs.quality[octet] else Quality.BAD
        self.values = CellValues(cell)
        self.named = named_values(cell)
        self.retain = RetainedData(self, self.started_ns, fds)
        self.forces = Forces()
        standing = self.axes.read()
        first_job = 1 if standing is None else unpack_cell_state(standing).taken + 1000
        self.numbers = rc_numbers(cell)
        self.owned = {octet: plan.door(name).number for octet, name in cell.rc_inputs.owner.items()}
        self.entry_inputs = inputs_of(cell)
        for line, places in self.entry_inputs.items():
            for bit in places.values():
                self.owned.setdefault(bit >> 3, plan.door(line).number)
        self.programs = PlannerLink(fds)
        programs = {number: program.facts for number, program in plan.programs.items()}
        self.office = CommandDispatcher(axis_facts(cell), make_planner(cell), first_job, programs)
        self.doors = [self._door(number, fds) for number in range(len(plan.doors))]
        self.canopen = self._masters(fds)
        self.contacts = DigitalContacts(self, fds)
        self.bridge = Bridge(self, fds)
        self.clients = modbus_clients(self)
        self.timer = Timerfd()
        self.tools = PageInterfaces(self)
        self.variables = Variables(self)
        self.signals = ControllerHost(self, self.started_ns, fds)
        self._state_index, self._piece_size = -1, record_size(len(cell.axis))
        self.late_machine = LateMachine(simulated=plan.simulated)
        self.alarms = AlarmFile(plan)
        self.complaints = IoComplaints(fds, self.journal, self.cell.cell.language)
        self._places_judged = False
        self.places = LastPlaces(cell)
        self.blind = {name: f"bus {name} {LISTENS}" for name in plan.listening}
        self.office.unspoken = {n: self.blind[axis.drive.bus] for n, axis in enumerate(cell.axis) if axis.drive.bus in self.blind}
        for words in self.blind.values():
            self.journal.write("alarm", words)
        self._ticks = 0
        self._inputs_written = b""
        self._done = asyncio.Event()

    def _masters(self, fds: dict[str, int]) -> CanopenServices:
        return CanopenServices(self.plan, fds, self.journal.write)

    def _door(self, index: int, fds: dict[str, int]) -> BaseSource:
        door = self.plan.doors[index]
        region = RegionWriter(fds[f"door-{door.number}"], f"door-{door.number}")
        if door.kind == "modbus":
            modbus = next(m for m in self.cell.modbus if m.name == door.name)
            watch = LinkWatch(ms(modbus.max_silence_ms), has_life_word=False)
            made = self._modbus_door(
                SourceContext(door, self.office, watch, on_loss_of(modbus.on_loss), region, self.journal.write), modbus
            )
            owned = [octet for octet, owner in self.cell.rc_inputs.owner.items() if owner == door.name]
            made.listen(modbus, self.plan.modbus[door.name], side_of(self, made, owned))
            return made
        line = next(x for x in self.cell.line if x.name == door.name)
        watch = LinkWatch(ms(line.supervision.max_silence_ms), has_life_word=line.supervision.life_word is not None)
        return self._line_door(
            SourceContext(door, self.office, watch, on_loss_of(line.supervision.on_loss), region, self.journal.write), line
        )

    def _modbus_door(self, post: SourceContext, settings: Modbus) -> ModbusSource:
        return ModbusSource(post)

    def _line_door(self, post: SourceContext, line: Line) -> BaseSource:
        kind = TelegramSource if line.layer == "telegrams" else Rk512Source
        return kind(post, line, self)

    # ---- life --------------------------------------------------------------------------------------------------------
    async def run(self) -> None:
        """Until SIGTERM."""
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGTERM, self._done.set)
        loop.add_reader(self.timer.fileno(), self._on_timer)
        self.timer.set(time.monotonic_ns() + TICK_NS, TICK_NS)
        self.contacts.start()
        if self.clients is not None:
            self.clients.start()
        self.bridge.start(loop)
        self.tick()
        late = [self._start_server(door) for door in self.doors if isinstance(door, ModbusSource) and await self._started(door)]
        servers = [asyncio.create_task(each) for each in late]
        for door in self.doors:
            if isinstance(door, SERIAL):
                door.open(self.plan.lines[door.name])
        variables = await self.variables.listen(runtime_dir() / f"{self.plan.slug}-services.sock")
        await self._done.wait()
        variables.close()
        for server in servers:
            server.cancel()
        self.canopen.stop()
        self.contacts.close()
        if self.clients is not None:
            self.clients.close()
        self.retain.close()
        if not self.plan.simulated:
            self.places.stop(self.values.state, self._placed())
        for door in self.doors:
            if isinstance(door, ModbusSource):
                await door.server.close()
            elif isinstance(door, SERIAL):
                door.close()
        self.timer.close()
        self.journal.close()
        self.alarms.close()

    async def _started(self, door: ModbusSource) -> str:
        """Empty: it listens; else why it does not."""
        try:
            await door.server.start()
        except OSError as error:  # a predecessor's port still in use, an address or adapter that is not there yet
            return str(error)
        return ""

    async def _start_server(self, door: ModbusSource) -> None:
        """Whenever its address, port or adapter comes: quickly at first, then every second; told once, and when it is over."""
        attempts = 0
        while words := await self._started(door):
            attempts += 1
            if attempts == SERVER_QUICK:
                self.journal.write("alarm", f"{words}; it is tried again every second", door=door.name)
            await asyncio.sleep(0.05 if attempts < SERVER_QUICK else 1.0)
        if attempts >= SERVER_QUICK:
            self.journal.write("link", f"Modbus server {door.name} listens now", door=door.name)

    def _placed(self) -> int:
        planner = self.office.planner
        return planner.placed if planner is not None else 0

    def _on_timer(self) -> None:
        if self.timer.expired():
            self.tick()

    def tick(self) -> None:
        """What time brings: the cycle's news, silent links, status blocks, orders, our own life."""
        now = time.monotonic_ns()
        self._ticks += 1
        self._observe(now)
        for door in self.doors:
            door.wake(now)
            if isinstance(door, SERIAL):
                door.settle()
        self.tools.wake(now)
        self._age_inputs(now)
        self.signals.step(now)
        if self.clients is not None:
            self.clients.step(now)
        self._refresh(now)
        self.flush()
        self.links.beat(now)
        if self._ticks % LINKS_EVERY == LINKS_EVERY // 2:
            self.retain.look()
        if self._ticks % PLACES_EVERY == 0 and self._places_judged:
            self.places.look(self.values.state, self._placed())
        if self._ticks % LINKS_EVERY == 1:
            self.links.write(fitted(self.status(), self.links.size), now)

    def on_cycle(self) -> None:
        """The cycle has published: what routes and contacts join goes on at once."""
        self._observe(time.monotonic_ns())
        self.flush()

    def settle(self) -> None:
        """A named value may have changed: telegrams that wait for its edge."""
        for door in self.doors:
            if isinstance(door, TelegramSource):
                door.settle()

    def _observe(self, now: int) -> None:
        payload = self.axes.read()
        if payload is None or self.axes.index == self._state_index:
            if self.values.state.generation and now - self.axes.life[1] > CYCLE_GONE_NS:
                self._cycle_gone(now)
            return
        self._state_index = self.axes.index
        state = unpack_cell_state(payload)
        self.values.state = state
        self.late_machine.observe(state, now)
        self.canopen.observe(state)
        if not self._places_judged and not self.plan.simulated and not any(axis.flags & AxisFlag.LOST for axis in state.axes):
            self._places_judged = True
            for sentence in (*judge(self.cell, state), *torn_lines(self.cell)):
                self.journal.write("alarm", sentence)
        self.values.life += 1
        self.office.planner = self.programs.state()
        self.office.observe(state, now)

    def _cycle_gone(self, now: int) -> None:
        """Positions stay as last seen (the life word stands still); nothing is enabled, referenced or ready, no command waits for it."""
        places = [AxisState(axis.actual, axis.set, flags=AxisFlag.LOST) for axis in self.values.state.axes]
        self.values.state = CellState(axes=places)
        self.office.observe(self.values.state, now)

    def _age_inputs(self, now: int) -> None:
        """Bytes of a silent command source are bad; what a predecessor left is stale and then bad."""
        image = self.inputs
        for octet, number in self.owned.items():
            door = self.doors[number - 1]
            if self.tools.permits and octet in PERMIT_BYTES:
                continue  # a simulated cell without its PLC, a tool stands in
            if (image.quality[octet] == Quality.GOOD and not door.watch.alive) or (
                image.quality[octet] == Quality.STALE and now - self.started_ns > INHERITED_NS
            ):
                image.quality[octet] = Quality.BAD

    def _refresh(self, now: int) -> None:
        state, facts = self.values.state, self.office.axes
        places = [(state.axes[n].actual / axis.si, state.axes[n].lag / axis.si) for n, axis in enumerate(facts)]
        self._collect_errors(state, now)
        outputs = self.rc_out.read()
        for door in self.doors:
            door.refresh(state, places, self.values.life, now)
            if isinstance(door, ModbusSource):
                door.show(outputs)

    def _late_words(self) -> str:
        return ", ".join(axis.name for n, axis in enumerate(self.office.axes) if n in self.late_machine.axes)

    def _cause_ended(self, state: CellState) -> bool:
        """What stopped the axes is away and no rest of a move waits: it is history, no error (AX-642)."""
        if state.motion in (Motion.STOPPED, Motion.STOPPING):
            return False
        match state.stop_cause:
            case Reason.STOPPED_BY_DOOR | Reason.SERVICES_LOST | Reason.ABANDONED | Reason.EMERGENCY_STOP:
                return True  # a latched emergency stop is an error of its own
            case Reason.LINK_LOST:
                return all(door.watch.alive or not door.watch.losses for door in self.doors)
            case Reason.INPUT_LOST:
                return state.permits & int(ALL_PERMITS) == int(ALL_PERMITS)
            case Reason.DRIVE_LOST:
                return not any(axis.flags & AxisFlag.LOST for axis in state.axes[: len(self.office.axes)])
        return False

    def _collect_errors(self, state: CellState, now: int) -> None:
        errors: list[tuple[int, str]] = [(Reason.NOT_READY, text(Reason.NOT_READY, detail=words)) for words in self.blind.values()]
        if state.emergency:
            errors.append((Reason.EMERGENCY_STOP, text(Reason.EMERGENCY_STOP)))
        if self.late_machine.blamed:
            errors.append((Reason.MACHINE_LATE, text(Reason.MACHINE_LATE, detail=self._late_words())))
        for n, axis in enumerate(self.office.axes):
            flags = int(state.axes[n].flags)
            if not flags & WRONG or (n in self.late_machine.axes and not flags & AxisFlag.UNCONFIGURED):
                continue
            if flags & AxisFlag.FAULT:
                code = state.axes[n].fault_code
                fault = self.canopen.fault(n, code) or servodyn_fault(code, self.plan.cell.cell.language)
                errors.append((Reason.DRIVE_FAULT, text(Reason.DRIVE_FAULT, detail=f"{axis.name} {fault}")))
            why = self.canopen.why_not(n) if flags & AxisFlag.UNCONFIGURED else ""
            if why:
                errors.append((Reason.DRIVE_NOT_STARTED, text(Reason.DRIVE_NOT_STARTED, detail=f"{axis.name}: {why}")))
            elif flags & AxisFlag.LOST and self.cell.axis[n].drive.bus not in self.blind:
                errors.append((Reason.DRIVE_LOST, text(Reason.DRIVE_LOST, detail=axis.name)))
        strayed = self.office.strayed(self.plan.cell.cell.language)
        if strayed:
            errors.append((Reason.FOLLOWING_ERROR, text(Reason.FOLLOWING_ERROR, detail=strayed)))
        ended = self._cause_ended(state)
        if state.stop_cause and not ended and state.stop_cause not in (e[0] for e in errors) and not self.late_machine.blamed:
            errors.append((state.stop_cause, text(Reason(state.stop_cause))))
        if state.path_stop and Reason.OUTPUT_IN_USE not in (e[0] for e in errors):
            errors.append((Reason.OUTPUT_STOPPED, text(Reason.OUTPUT_STOPPED, detail=function_words(state.path_stop))))
        if self.office.planner is not None and self.office.planner.warning:
            errors.append((Reason.INTERPOLATOR_STOP, text(Reason.INTERPOLATOR_STOP, detail=self.office.planner.warning)))
        errors += [
            (Reason.COUPLER_FAULT, text(Reason.COUPLER_FAULT, self.plan.cell.cell.language, words)) for words in self.contacts.faults()
        ]
        io = self.complaints.look(self.signals, now)
        for door, refusal in list(self.values.refusals.items()):
            if now - refusal[2] > REFUSALS_KEPT_NS:
                del self.values.refusals[door]
        self.values.errors = errors + io
        self.alarms.look(self.values.errors)
        self.alarms.inputs({number: self.input_bit(number) for number in (self.numbers.reset, ACKNOWLEDGE)})
        self.signals.note([*errors, *((code, words) for code, words in io if code == Reason.DRIVE_NOT_STARTED)], now)

    # ---- orders ------------------------------------------------------------------------------------------------------
    def flush(self) -> None:
        """Orders into the ring, events into the journal, inputs into their region; also right after a command."""
        now = time.monotonic_ns()
        self.bridge.step(now)
        self.signals.inputs_came(now)
        for event in self.office.take_events():
            self.journal.write("command", event.sentence(), door=event.door, code=event.code, what=event.what, reason=int(event.reason))
            self.alarms.event(event, {TOOL_DOOR: "commissioning tool", PAGE_DOOR: "page"})
            if event.what in ("refused", "aborted"):
                refusal = (int(event.reason), event.sentence(self.cell.cell.language), time.monotonic_ns())
                self.values.refusals[event.door] = refusal
            elif event.what == "accepted":
                self.values.refusals.pop(event.door, None)
        payload = pack_inputs(self.signals.for_cycle(self.forces.over(self.inputs)))
        if payload != self._inputs_written:
            self._inputs_written = payload
            self.rc_in.write(payload, time.monotonic_ns())
        for order in self.office.take_orders():
            self.orders.put(pack_order(order, self._piece_size))
        self.programs.order(self.office.take_programs())

    # ---- what tools see ----------------------------------------------------------------------------------------------
    def status(self) -> dict[str, object]:
        """Links and errors for tools; kept under the size of the region."""
        return {
            "doors": [
                {
                    "number": d.number,
                    "name": d.name,
                    "kind": d.kind,
                    "alive": d.watch.alive,
                    "losses": d.watch.losses,
                    "state": CommandState(d.status.state).name,
                    "reason": Reason(d.status.reason).name,
                    **(d.counters() if isinstance(d, SERIAL) else {}),
                    **({"requests": d.server.counters.requests} if isinstance(d, ModbusSource) else {}),
                }
                for d in self.doors
            ],
            "owner": self.office.owner,
            **({"listening": list(self.blind)} if self.blind else {}),
            "forced": self.forces.count,
            **({"permits": True} if self.tools.permits else {}),
            **self.canopen.status(),
            **self.signals.status(),
            **self.retain.status(),
            **self.bridge.status(),
            **(self.clients.status() if self.clients is not None else {}),
            **({"modbus_couplers": self.contacts.modbus.status()} if self.contacts.modbus is not None else {}),
            "errors": [{"code": code, "text": words} for code, words in self.values.errors[:8]],
            "inputs": {str(octet): self.inputs.values[octet] for octet in self.owned},
        }

    def input_bit(self, number: int) -> bool:
        """Present value of RC input N; of a forced one the forced value."""
        return self.forces.bits.get(number, get_bit(self.inputs.values, number))


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
