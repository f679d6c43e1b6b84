"""The communication half of an emulated CANopen device: NMT states, SYNC, PDO, SDO, EMCY, heartbeat, LSS, in bus time.

Source: CiA 301 (version 4.2); LSS: CiA 305.  The device it serves (a drive) is an `Application`; for a device of objects only, its methods
may do nothing.  Every method takes the bus time `now`; nothing here reads a clock.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from drivers.emulator.canopen.guard import NEVER, PRODUCER, Consumer, Emergencies, LifeSigns
from drivers.emulator.canopen.lss import LssSlave
from drivers.emulator.canopen.objects import OK, Objects
from drivers.emulator.canopen.pdo import Rpdo, Tpdo
from drivers.emulator.canopen.pdos import Pdos
from drivers.emulator.canopen.sdo import SdoServer
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss, nmt, pdo
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.emcy import Register
from protocols.canopen.lss import Identity
from protocols.canopen.nmt import Command, State
from protocols.canopen.sdo import Abort
from protocols.canopen.types import Value

SYNC_ID, CYCLE_PERIOD, SYNC_OVERFLOW, ERROR_BEHAVIOUR, IDENTITY = 0x1005, 0x1006, 0x1019, 0x1029, 0x1018
HEARTBEAT_LOST, BUS_OFF_GONE, PDO_SHORT, PDO_LONG, SYNC_LENGTH, RPDO_LATE = 0x8130, 0x8140, 0x8210, 0x8220, 0x8240, 0x8250
NO_SYNC = -1
Handler = Callable[[Frame, Ns], None]


class Application(Protocol):
    """The device that uses the communication."""

    def advance(self, now: Ns) -> None: ...  # everything up to now has happened
    def sample(self, now: Ns) -> None: ...  # SYNC: latch the values to be sent
    def activate(self, now: Ns) -> None: ...  # SYNC: synchronous set values are active
    def connection_lost(self, now: Ns) -> None: ...  # abort connection option code 6007h
    def reset(self, now: Ns) -> None: ...  # NMT reset node
    def changed(self) -> bool: ...  # whether a value of an event-driven TPDO has changed since the last call


@dataclass(slots=True)
class Accepted:
    """Identifiers the node listens to, and the handlers of their frames."""

    data: dict[int, Handler] = field(default_factory=dict)
    remotes: dict[int, Handler] = field(default_factory=dict)  # remote frames
    changed: bool = True  # since its bus looked last


class CanopenNode:
    """`accepted` are its identifiers; `soonest` the next instant at which `expire` has work."""

    def __init__(self, dictionary: ObjectDictionary, node: int, application: Callable[[Objects, "CanopenNode"], Application]) -> None:
        self.objects = Objects(dictionary, node)
        self.state = State.INITIALISING
        self.output: list[Frame] = []
        self.accepted = Accepted()
        self.soonest: Ns = NEVER
        self.silent = False  # powered off or bus-off: receives and sends nothing
        self.boot_ns: Ns = 0
        self._boot_due = NEVER
        self.life = LifeSigns(self.objects)
        self.pdos = Pdos()
        self.emergencies = Emergencies(self.objects, self.output.append)
        self.emergencies.allowed = lambda: self.state in (State.PRE_OPERATIONAL, State.OPERATIONAL)
        self.consumer = Consumer(self.objects, self._replan)
        self.sdo = SdoServer(self.objects)
        identity = Identity(*(self.objects.whole((IDENTITY, sub)) for sub in (1, 2, 3, 4)))
        self.lss = LssSlave(identity, node, lambda: not self.silent)
        self._hook()
        self.application = application(self.objects, self)
        self.pdos.make(self.objects, self._replan)
        self._replan()

    @property
    def number(self) -> int:
        return self.lss.active

    @property
    def sync_identifier(self) -> int:
        """NO_SYNC without 1005h: 0 would be the identifier of NMT."""
        return self.objects.whole((SYNC_ID, 0)) & cobid.ID_BITS if (SYNC_ID, 0) in self.objects.values else NO_SYNC

    def _hook(self) -> None:
        objects = self.objects
        objects.checks[SYNC_ID, 0] = self._check_sync
        objects.written[SYNC_ID, 0] = lambda value: self._replan()
        objects.checks[SYNC_OVERFLOW, 0] = lambda value: Abort.VALUE if value == 1 or (isinstance(value, int) and value > 240) else OK
        objects.written[PRODUCER, 0] = self._beat_changed

    def _check_sync(self, value: Value) -> int:
        new = int(value) if isinstance(value, int) else 0
        wrong = new & (cobid.EXTENDED | cobid.PRODUCER) or cobid.restricted(new & cobid.ID_BITS)
        return Abort.VALUE if wrong else OK  # this device cannot make SYNC

    # -- plan -----------------------------------------------------------------------------------

    def _replan(self) -> None:
        """Map identifiers to handlers; PDOs with equal identifiers all receive the frame."""
        node, pdos, accepted = self.number, self.pdos, self.accepted
        pdos.sort()
        accepted.data = {identifier: self._rpdo_handler(targets) for identifier, targets in pdos.takers().items()}
        accepted.data |= {cobid.LSS_MASTER: self._lss, cobid.NMT: self._nmt}
        accepted.remotes = {item.identifier: self._asked(item) for item in pdos.sent if item.valid and item.rtr}
        if node <= cobid.MAX_NODE:
            accepted.data |= {cobid.sdo_request(node): self._sdo, self.sync_identifier: self._sync}
            accepted.data |= {cobid.heartbeat(other): self._heartbeat for other in self.consumer.watched}
            accepted.remotes[cobid.heartbeat(node)] = self._guarded
        accepted.changed = True

    # -- time -----------------------------------------------------------------------------------

    def plan(self, application_due: Ns) -> None:
        """Sets `soonest`; to be called after anything happened."""
        life = self.life
        due = application_due if application_due < life.beat_due else life.beat_due
        for other in (self._boot_due, life.life_due, self.sdo.due, self.emergencies.due, self.consumer.due):
            if other < due:
                due = other
        self.soonest = self.pdos.due(due)

    def expire(self, now: Ns) -> None:
        """Everything that is due at `now`; the application was advanced already."""
        life = self.life
        if now >= self._boot_due:
            self._booted(now)
        if now >= self.sdo.due:
            self.output += [Frame(cobid.sdo_answer(self.number), data) for data in self.sdo.wake(now)]
        if now >= life.beat_due:
            self.output.append(life.beat(self.number, self.state, now))
        if now >= self.consumer.due:
            for lost in self.consumer.expired(now):
                self._communication_error(HEARTBEAT_LOST, bytes((lost,)), now)
        if now >= life.life_due:
            life.life_due = NEVER
            self._communication_error(HEARTBEAT_LOST, bytes((self.number,)), now)
        for rpdo in self.pdos.received:
            if now >= rpdo.due:
                rpdo.due = NEVER
                self._communication_error(RPDO_LATE, bytes((rpdo.number + 1,)), now)
        self.emergencies.wake(now)
        self.events(now)

    def events(self, now: Ns) -> None:
        """Event-driven TPDOs: changes are sent when the inhibit time allows, the rest when the event timer expires."""
        by_event = self.pdos.by_event
        if not by_event or self.state is not State.OPERATIONAL:
            return
        changed = self.application.changed()
        for tpdo in by_event:
            tpdo.happened = tpdo.happened or changed or (tpdo.inhibit_ns > 0 and tpdo.by_event and tpdo.read() != tpdo.last)
            if tpdo.by_event and ((tpdo.happened and now >= tpdo.free_at) or now >= tpdo.due):
                self._send_tpdo(tpdo, now)

    def _send_tpdo(self, tpdo: Tpdo, now: Ns) -> None:
        tpdo.last, tpdo.happened = tpdo.read(), False
        tpdo.free_at = now + tpdo.inhibit_ns
        tpdo.due = now + max(tpdo.event_ns, tpdo.inhibit_ns) if tpdo.event_ns else NEVER  # never closer than the inhibit time
        self.output.append(Frame(tpdo.identifier, tpdo.last))

    # -- NMT ------------------------------------------------------------------------------------

    def power_up(self, now: Ns) -> None:
        """Power returns, or reset node: boots with the stored parameters."""
        self.silent = False
        self.lss.power_on()
        self._reset(now, application=True)

    def power_down(self) -> None:
        self.silent, self.state = True, State.INITIALISING
        self._boot_due = NEVER
        self.life.reset()
        self.sdo.reset()
        self.emergencies.reset()
        self.consumer.reset()
        self.consumer.watched.clear()
        self.pdos.power_down()

    def _reset(self, now: Ns, application: bool) -> None:
        self.state, self.life.toggle = State.INITIALISING, False
        node = self.lss.take_over()
        self.objects.reset(node, application)
        if (period := self.objects.written.get((CYCLE_PERIOD, 0))) is not None:
            period(self.objects.whole((CYCLE_PERIOD, 0)))
        self.sdo.reset()
        self.emergencies.reset()
        self.consumer.reset()
        self.life.reset()
        self._boot_due = now + self.boot_ns if node <= cobid.MAX_NODE else NEVER
        self.pdos.load()
        self._replan()

    def _booted(self, now: Ns) -> None:
        self._boot_due = NEVER
        self.output.append(nmt.heartbeat(self.number, State.INITIALISING))
        self._enter(State.PRE_OPERATIONAL, now)
        self._beat_changed(None, now)

    def _enter(self, state: State, now: Ns) -> None:
        before, self.state = self.state, state
        if state is State.OPERATIONAL and before is not state:
            self.application.advance(now)
            self.application.changed()  # earlier changes are not events
            self.pdos.begin()
            for tpdo in self.pdos.sent:
                if tpdo.valid and tpdo.by_event:
                    self._send_tpdo(tpdo, now)  # informs its master of the present state
        if state is not State.OPERATIONAL:
            self.pdos.end()
        self.emergencies.wake(now)  # send what had to wait for a state that allows it
        if state is State.STOPPED:
            self.sdo.reset()
            if before is State.OPERATIONAL:
                self.application.connection_lost(now)

    def _nmt(self, frame: Frame, now: Ns) -> None:
        command = nmt.command_of(frame)
        if command is None or command[1] not in (nmt.ALL_NODES, self.number) or self.state is State.INITIALISING:
            return
        match command[0]:
            case Command.START:
                self._enter(State.OPERATIONAL, now)
            case Command.STOP:
                self._enter(State.STOPPED, now)
            case Command.PRE_OPERATIONAL:
                self._enter(State.PRE_OPERATIONAL, now)
            case Command.RESET_NODE:
                self._reset(now, application=True)
                self.application.reset(now)  # torque off: nothing is left that could stop along a ramp
            case Command.RESET_COMMUNICATION:
                self.application.connection_lost(now)
                self._reset(now, application=False)

    # -- services -------------------------------------------------------------------------------

    def _lss(self, frame: Frame, now: Ns) -> None:
        unconfigured = self.lss.active > cobid.MAX_NODE
        self.output += self.lss.handle(frame.data)
        if unconfigured and self.lss.pending <= cobid.MAX_NODE and self.lss.mode is lss.Mode.WAITING:
            self._reset(now, application=False)  # a node without a number adopts its new one when it leaves configuration (CiA 305)

    def _sdo(self, frame: Frame, now: Ns) -> None:
        if self.state in (State.PRE_OPERATIONAL, State.OPERATIONAL):
            self.application.advance(now)
            self.output += [Frame(cobid.sdo_answer(self.number), data) for data in self.sdo.handle(frame.data, now)]
            self.events(now)

    def _rpdo_handler(self, targets: list[Rpdo]) -> Handler:
        targets = [target for target in targets if target.valid]

        def handle(frame: Frame, now: Ns) -> None:
            if self.state is State.OPERATIONAL:
                for target in targets:
                    self._rpdo(target, frame.data, now)

        return handle

    def _rpdo(self, target: Rpdo, data: bytes, now: Ns) -> None:
        size, active = target.mapping.size, self.emergencies.active
        if len(data) != size:
            detail = bytes((target.number + 1, len(data), size))
            self.emergencies.raise_(PDO_SHORT if len(data) < size else PDO_LONG, Register.COMMUNICATION, now, detail)
            if len(data) < size:
                return
        elif active:
            self.emergencies.clear([PDO_SHORT, PDO_LONG, RPDO_LATE], now)
        if target.time_out_ns:
            target.due = now + target.time_out_ns
        if target.synchronous:
            target.pending = data
            return
        self.application.advance(now)
        target.apply(data)
        self.events(now)

    def _sync(self, frame: Frame, now: Ns) -> None:
        expected = 1 if self.objects.whole((SYNC_OVERFLOW, 0)) else 0
        if self.state is State.INITIALISING:
            self.application.sample(now)
            return
        if len(frame.data) != expected:
            self.emergencies.raise_(SYNC_LENGTH, Register.COMMUNICATION, now, bytes((len(frame.data),)))
            return
        application, operational = self.application, self.state is State.OPERATIONAL
        application.sample(now)
        if operational:
            for rpdo in self.pdos.held:
                if rpdo.pending is not None:
                    data, rpdo.pending = rpdo.pending, None
                    rpdo.apply(data)
        application.activate(now)
        if operational:
            counter = frame.data[0] if expected else None
            for tpdo in self.pdos.with_sync:
                due = tpdo.on_sync(counter)
                if due is not None:
                    self.output.append(Frame(tpdo.identifier, due))
        self.events(now)

    def _asked(self, tpdo: Tpdo) -> Handler:
        """A remote frame requests a TPDO."""

        def handle(frame: Frame, now: Ns) -> None:
            if self.state is not State.OPERATIONAL:
                return
            self.application.advance(now)
            if tpdo.type == pdo.RTR_SYNC:
                data = tpdo.sampled
                if data is not None:
                    self.output.append(Frame(tpdo.identifier, data))
            else:
                self._send_tpdo(tpdo, now)

        return handle

    # -- life -----------------------------------------------------------------------------------

    def _beat_changed(self, value: Value | None, now: Ns | None = None) -> None:
        """1017h was written (then the first beat is at once) or the device has booted."""
        if self.state is State.INITIALISING:
            self.life.beat_due = NEVER
        else:
            self.life.begin(now)

    def _heartbeat(self, frame: Frame, now: Ns) -> None:
        heard = nmt.heartbeat_of(frame)
        if heard is None or heard[0] not in self.consumer.watched:
            return
        if self.consumer.heard(heard[0], now) and not self.consumer.any_lost:
            self.emergencies.clear([HEARTBEAT_LOST], now)

    def _guarded(self, frame: Frame, now: Ns) -> None:
        """Node guarding, if there is no heartbeat."""
        if not self.life.beat_ns and self.state is not State.INITIALISING:
            self.output.append(self.life.guarded(self.number, self.state, now))

    def _communication_error(self, code: int, detail: bytes, now: Ns) -> None:
        """Emergency, abort connection option, error behaviour 1029h."""
        self.emergencies.raise_(code, Register.COMMUNICATION, now, detail)
        self.application.connection_lost(now)
        match self.objects.whole((ERROR_BEHAVIOUR, 1)):
            case 0 if self.state is State.OPERATIONAL:
                self._enter(State.PRE_OPERATIONAL, now)
            case 2:
                self._enter(State.STOPPED, now)

    def bus_off(self, now: Ns) -> None:
        """Its controller left the bus; `bus_on` brings it back."""
        self.silent = True
        self.output.clear()
        self.application.connection_lost(now)

    def bus_on(self, now: Ns) -> None:
        self.silent = False
        self.emergencies.raise_(BUS_OFF_GONE, Register.COMMUNICATION, now)
        self.emergencies.clear([BUS_OFF_GONE], now)
