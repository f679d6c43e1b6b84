"""CANopen: parts for the communication half of axisgate's emulated drive, each with one fault (used by peers.canopen301)."""

from collections.abc import Callable

from drivers.emulator.canopen.guard import NEVER, LifeSigns
from drivers.emulator.canopen.objects import OK
from drivers.emulator.canopen.pdo import Rpdo
from gateway.conformance.peers.can_devices import Drive, Tune, put
from gateway.conformance.peers.canopen301_frames import on_heartbeat_silent
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss
from protocols.canopen.dictionary import Key
from protocols.canopen.emcy import Register
from protocols.canopen.nmt import State
from protocols.canopen.sdo import Abort


def unchecked(*keys: Key) -> Tune:
    return lambda drive: drive.unchecked(*keys)


def mapping_free(drive: Drive) -> None:
    drive.unchecked(*((0x1A00, sub) for sub in range(9)))


def count_free(drive: Drive) -> None:
    """Entries and count are checked for their sum only where the PDO is built: never."""
    for pdo in drive.node.pdos.sent:
        put(pdo, _sound=lambda words: OK)


def entries_free(drive: Drive) -> None:
    for pdo in drive.node.pdos.sent:
        put(pdo, _entry_sound=lambda word: OK)


def beat_times(factor: float) -> Tune:
    class Slow(LifeSigns):
        @property
        def beat_ns(self) -> Ns:
            return round(super().beat_ns * factor)

    def tune(drive: Drive) -> None:
        drive.node.life.__class__ = Slow

    return tune


def never_resets(drive: Drive) -> None:
    """Reset communication keeps the written values."""
    objects = drive.node.objects
    kept = objects.reset
    put(objects, reset=lambda node, application: kept(node, application) if application else None)


def no_store(drive: Drive) -> None:
    put(drive.node.objects, _store=lambda sub: OK)
    for entry in drive.node.objects.dictionary.subs(0x1010):
        if entry.sub:
            drive.node.objects.checks[entry.key] = lambda value: OK if value == 0x65766173 else Abort.NO_STORE


def restores_nothing(drive: Drive) -> None:
    """Load is acknowledged, the stored values stay."""
    drive.node.objects.checks[0x1011, 1] = lambda value: OK if value == 0x64616F6C else Abort.NO_STORE


def restores_at_once(drive: Drive) -> None:
    objects = drive.node.objects

    def load(value: object) -> int:
        if value != 0x64616F6C:
            return Abort.NO_STORE
        objects.stored.clear()
        objects.values[0x1017, 0] = 0
        return OK

    objects.checks[0x1011, 1] = load


def any_signature(index: int) -> Tune:
    def tune(drive: Drive) -> None:
        objects = drive.node.objects
        check = objects.checks[index, 1]
        word = 0x65766173 if index == 0x1010 else 0x64616F6C
        objects.checks[index, 1] = lambda value: OK if value != word else check(value)

    return tune


def shows_register(drive: Drive) -> None:
    drive.fixed((0x1001, 0), 0)


def history_stays(drive: Drive) -> None:
    drive.node.objects.written[0x1003, 0] = lambda value: None


def consumer(factor: float) -> Tune:
    def tune(drive: Drive) -> None:
        load = drive.node.consumer.load

        def changed() -> None:
            load()
            for watched in drive.node.consumer.watched.values():
                watched.time_ns = round(watched.time_ns * factor)

        put(drive.node.consumer, load=changed)

    return tune


def reports_once(drive: Drive) -> None:
    put(drive.node.emergencies, clear=lambda codes, now: None)


def stays(drive: Drive) -> None:
    drive.node.objects.readers[0x1029, 1] = lambda: drive.node.objects.values[0x1029, 1]
    node = drive.node

    def error(code: int, detail: bytes, now: Ns) -> None:
        node.emergencies.raise_(code, Register.COMMUNICATION, now, detail)

    put(node, _communication_error=error)


def toggle_stays(drive: Drive) -> None:
    node = drive.node
    reset = node._reset

    def kept(now: Ns, application: bool) -> None:
        toggle = node.life.toggle
        reset(now, application)
        node.life.toggle = toggle

    put(node, _reset=kept)


def life_never(drive: Drive) -> None:
    expire = drive.node.expire

    def without(now: Ns) -> None:
        drive.node.life.life_due = NEVER
        expire(now)

    put(drive.node, expire=without)


def inhibit_ignored(drive: Drive) -> None:
    for pdo in drive.node.pdos.sent:
        own = pdo._load_own

        def load(pdo: object = pdo, own: Callable[[], None] = own) -> None:
            own()
            put(pdo, inhibit_ns=0)

        put(pdo, _load_own=load)


def each_sync(drive: Drive) -> None:
    for pdo in drive.node.pdos.sent:
        put(pdo, on_sync=lambda counter, pdo=pdo: pdo.read())


def always_valid(drive: Drive) -> None:
    """Bit 31 is kept, and means nothing."""
    node = drive.node
    replan = node._replan

    def planned() -> None:
        replan()
        node.pdos.with_sync = [item for item in node.pdos.sent[:1] if item.mapping.parts and item.type <= 240]

    for item in node.pdos.sent:
        item._changed = planned


def rpdo_at_once(drive: Drive) -> None:
    for pdo in drive.node.pdos.received:
        own = pdo._load_own

        def load(pdo: object = pdo, own: Callable[[], None] = own) -> None:
            own()
            put(pdo, type=255)

        put(pdo, _load_own=load)


def first_rpdo(drive: Drive) -> None:
    """With several before a SYNC the first one counts."""
    rpdo = drive.node._rpdo

    def taken(target: Rpdo, data: bytes, now: Ns) -> None:
        if target.pending is None:
            rpdo(target, data, now)

    put(drive.node, _rpdo=taken)


def always_operational(drive: Drive) -> None:
    """PDOs whatever the state."""
    node = drive.node
    enter = node._enter

    def entered(state: State, now: Ns) -> None:
        enter(State.OPERATIONAL if state is State.PRE_OPERATIONAL and node.state is State.OPERATIONAL else state, now)

    put(node, _enter=entered)


def stays_stopped(drive: Drive) -> None:
    """Start is ignored in state stopped."""
    node = drive.node
    enter = node._enter

    def entered(state: State, now: Ns) -> None:
        if node.state is not State.STOPPED or state is not State.OPERATIONAL:
            enter(state, now)

    put(node, _enter=entered)


def kept_rpdos(drive: Drive) -> None:
    node = drive.node
    enter = node._enter

    def entered(state: State, now: Ns) -> None:
        waiting = [rpdo.pending for rpdo in node.pdos.received]
        enter(state, now)
        for rpdo, data in zip(node.pdos.received, waiting, strict=True):
            rpdo.pending = data

    put(node, _enter=entered)


def served_when_stopped(drive: Drive) -> None:
    node = drive.node

    def served(frame: Frame, now: Ns) -> None:
        node.output += [Frame(cobid.sdo_answer(node.number), data) for data in node.sdo.handle(frame.data, now)]

    put(node, _sdo=served)
    node._replan()


def any_serial(drive: Drive) -> None:
    slave = drive.node.lss
    select = slave._select
    put(slave, _select=lambda part, number: select(part, slave.identity[part] if part == 3 else number))


def configures_always(drive: Drive) -> None:
    slave = drive.node.lss
    handle = slave.handle

    def handled(data: bytes) -> list[Frame]:
        if data[0] in (lss.Service.INQUIRE_NODE, lss.Service.CONFIGURE_NODE):
            slave.mode = lss.Mode.CONFIGURATION
        return handle(data)

    put(slave, handle=handled)


def any_number(drive: Drive) -> None:
    slave = drive.node.lss
    configure = slave._configure

    def configured(service: lss.Service, number: int, data: bytes) -> list[Frame]:
        if service is lss.Service.CONFIGURE_NODE and not 1 <= data[1] <= 127:
            return [lss.answer(service, lss.OK)]
        return configure(service, number, data)

    put(slave, _configure=configured)


def number_ignored(drive: Drive) -> None:
    put(drive.node.lss, take_over=lambda: drive.node.lss.active)


class KeepsUnsaved(Drive):
    """1017h survives a power failure without having been stored."""

    def power(self, on: bool, now: Ns) -> None:
        objects = self.node.objects
        before = objects.values[0x1017, 0]
        super().power(on, now)
        if on:
            objects.values[0x1017, 0] = before


class LosesStored(Drive):
    """Stored values are lost with the supply."""

    def power(self, on: bool, now: Ns) -> None:
        if not on:
            self.node.objects.stored.clear()
        super().power(on, now)


class NoBootAtPower(Drive):
    """No boot-up message after a power failure."""

    def power(self, on: bool, now: Ns) -> None:
        super().power(on, now)
        if on:
            self._says = on_heartbeat_silent


class Late(Drive):
    """Its SDO answers are delayed."""

    def __init__(self, late: Ns, identifiers: range = range(0x580, 0x600), tune: Tune | None = None) -> None:
        super().__init__(tune)
        self._late, self._which = late, identifiers
        self._queue: list[tuple[Ns, tuple[int, bytes]]] = []

    def deadline(self) -> Ns | None:
        due = super().deadline()
        return min(due if due is not None else NEVER, self._queue[0][0]) if self._queue else due

    def take_output(self) -> list[tuple[int, bytes]]:
        found = super().take_output()
        self._queue += [(self.now + self._late, pair) for pair in found if pair[0] in self._which]
        ready = [pair for due, pair in self._queue if due <= self.now]
        self._queue = [(due, pair) for due, pair in self._queue if due > self.now]
        return [pair for pair in found if pair[0] not in self._which] + ready


def sets_too(drive: Drive) -> None:
    """A write of a wrong length is refused, and done."""
    objects = drive.node.objects
    download = objects.download

    def done(key: Key, data: bytes) -> int:
        code = download(key, data)
        if code and key == (0x1017, 0):
            objects.values[key] = int.from_bytes(data[:2], "little")
        return code

    put(objects, download=done)


def beats_on(drive: Drive) -> None:
    objects = drive.node.objects
    check = objects.written[0x1017, 0]

    def written(value: object) -> None:
        if value == 0 and drive.node.state is not State.INITIALISING:
            objects.values[0x1017, 0] = 25
        check(objects.values[0x1017, 0])

    objects.written[0x1017, 0] = written
