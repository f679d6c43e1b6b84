"""CANopen: parts for the communication half of axisgate's emulated drive, each with one fault (used by peers.canopen301)."""

from collections.abc import Callable, Sequence

from drivers.emulator.canopen.guard import NEVER
from drivers.emulator.canopen.node import CanopenNode
from drivers.emulator.canopen.objects import OK
from drivers.emulator.canopen.pdo import Rpdo
from drivers.emulator.canopen.sdo import Phase, SdoServer
from gateway.conformance.peers.can_devices import NODE, Drive, Says, Tune, put
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss, sdo
from protocols.canopen.dictionary import Key
from protocols.canopen.emcy import Register
from protocols.canopen.nmt import State
from protocols.canopen.sdo import Abort, Answer


# ---- what it says
def answers(change: Callable[[bytes], bytes | None]) -> Says:
    """Its SDO answers are changed; None: not sent."""

    def says(drive: Drive, frame: Frame) -> Sequence[Frame]:
        if frame.identifier != cobid.sdo_answer(NODE):
            return [frame]
        data = change(frame.data)
        return [] if data is None else [frame._replace(data=data)]

    return says


def when(command: int, change: Callable[[bytes], bytes]) -> Says:
    """Only answers with this command specifier."""
    return answers(lambda data: change(data) if data[0] >> 5 == command else data)


def abort_code(before: int, after: int) -> Says:
    def change(data: bytes) -> bytes:
        is_it = data[0] == Answer.ABORT << 5 and sdo.abort_of(data).code == before
        return data[:4] + after.to_bytes(4, "little") if is_it else data

    return answers(change)


def on(identifier: int, change: Callable[[Drive, Frame], Sequence[Frame]]) -> Says:
    return lambda drive, frame: change(drive, frame) if frame.identifier == identifier else [frame]


def beats(change: Callable[[bytes], bytes]) -> Says:
    return on(cobid.heartbeat(NODE), lambda drive, frame: [frame._replace(data=change(frame.data))])


def deaf(identifier: int, size: int | None = None) -> Says:
    return on(identifier, lambda drive, frame: [] if size is None or len(frame.data) == size else [frame])


def commands(change: Callable[[int, int], tuple[int, int] | None]) -> Says:
    """NMT commands it hears: (command, node)."""

    def hears(drive: Drive, frame: Frame) -> Sequence[Frame]:
        if frame.identifier != cobid.NMT or len(frame.data) != 2:
            return [frame]
        found = change(frame.data[0], frame.data[1])
        return [] if found is None else [frame._replace(data=bytes(found))]

    return hears


# ---- parts
class NoToggleCheck(SdoServer):
    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase in (Phase.UPLOAD, Phase.DOWNLOAD) and request[0] >> 5 in (0, 3):
            request = bytes((request[0] & ~sdo.TOGGLE | sdo.TOGGLE * self._toggle,)) + request[1:]
        return super().handle(request, now)


class NoCrcCheck(SdoServer):
    def _block_download_end(self, request: bytes) -> list[bytes]:
        self._crc = False
        return super()._block_download_end(request)


class AnySize(SdoServer):
    """Takes more bytes than were announced, and cuts."""

    def _complete(self) -> int:
        self._size = None
        del self._data[2:]
        return super()._complete()


class AnyBlock(SdoServer):
    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if request[0] >> 5 == sdo.Request.BLOCK_UPLOAD and not request[0] & 3 and not 1 <= request[4] <= 127:
            request = request[:4] + b"\x40" + request[5:]
        return super().handle(request, now)


class NoRepeat(SdoServer):
    """Goes on behind what it sent, whatever was acknowledged."""

    def _acknowledged(self, good: int, block: int) -> list[bytes]:
        return super()._acknowledged(self._sequence, block)


class BigBlocks(SdoServer):
    """Ignores the block size of the client."""

    def _next_block(self) -> list[bytes]:
        self._wanted = 127
        return super()._next_block()


class Holds(SdoServer):
    """A transfer begun is carried on, whatever comes."""

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase is Phase.UPLOAD and request[0] >> 5 == sdo.Request.INITIATE_UPLOAD:
            return self._abort(Abort.COMMAND)
        return super().handle(request, now)


class AnswersAborts(SdoServer):
    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        said = super().handle(request, now)
        return said or [sdo.abort((0, 0), Abort.GENERAL)] if request[0] == 0x80 else said


class HangsInBlocks(SdoServer):
    """A client that gives up a block upload is waited for."""

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase is Phase.BLOCK_OUT_START and request[0] == 0x80:
            return []
        return [] if self._phase is Phase.BLOCK_OUT_START and request[0] >> 5 == 2 else super().handle(request, now)


def server(kind: type[SdoServer]) -> Tune:
    def tune(drive: Drive) -> None:
        drive.node.sdo = kind(drive.node.objects)

    return tune


def unchecked(*keys: Key) -> Tune:
    return lambda drive: drive.unchecked(*keys)


def mapping_free(drive: Drive) -> None:
    drive.unchecked(*((0x1A00, sub) for sub in range(9)))


def count_free(drive: Drive) -> None:
    """Entries and count are checked for their sum only where the PDO is built: never."""
    for pdo in drive.node._tpdos:
        put(pdo, _sound=lambda words: OK)


def entries_free(drive: Drive) -> None:
    for pdo in drive.node._tpdos:
        put(pdo, _entry_sound=lambda word: OK)


def beat_times(factor: float) -> Tune:
    class Slow(CanopenNode):
        @property
        def _beat_ns(self) -> Ns:
            return round(super()._beat_ns * factor)

    def tune(drive: Drive) -> None:
        drive.node.__class__ = Slow

    return tune


def never_resets(drive: Drive) -> None:
    """Reset communication keeps what was written."""
    objects = drive.node.objects
    kept = objects.reset
    put(objects, reset=lambda node, application: kept(node, application) if application else None)


def no_store(drive: Drive) -> None:
    put(drive.node.objects, _store=lambda sub: OK)
    for entry in drive.node.objects.dictionary.subs(0x1010):
        if entry.sub:
            drive.node.objects.checks[entry.key] = lambda value: OK if value == 0x65766173 else Abort.NO_STORE


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
        toggle = node.toggle
        reset(now, application)
        node.toggle = toggle

    put(node, _reset=kept)


def no_toggle(drive: Drive, frame: Frame) -> Sequence[Frame]:
    if frame.identifier == cobid.heartbeat(NODE) and frame.data[0] & 0x80:
        return [frame._replace(data=bytes((frame.data[0] & 0x7F,)))]
    return [frame]


def life_never(drive: Drive) -> None:
    expire = drive.node.expire

    def without(now: Ns) -> None:
        drive.node._life_due = NEVER
        expire(now)

    put(drive.node, expire=without)


def inhibit_ignored(drive: Drive) -> None:
    for pdo in drive.node._tpdos:
        own = pdo._load_own

        def load(pdo: object = pdo, own: Callable[[], None] = own) -> None:
            own()
            put(pdo, inhibit_ns=0)

        put(pdo, _load_own=load)


def each_sync(drive: Drive) -> None:
    for pdo in drive.node._tpdos:
        put(pdo, on_sync=lambda counter, pdo=pdo: pdo.read())


def always_valid(drive: Drive) -> None:
    """Bit 31 is kept, and means nothing."""
    node = drive.node
    replan = node._replan

    def planned() -> None:
        replan()
        node._sync_tpdos = [item for item in node._tpdos[:1] if item.mapping.parts and item.type <= 240]

    for item in node._tpdos:
        item._changed = planned


def rpdo_at_once(drive: Drive) -> None:
    for pdo in drive.node._rpdos:
        own = pdo._load_own

        def load(pdo: object = pdo, own: Callable[[], None] = own) -> None:
            own()
            put(pdo, type=255)

        put(pdo, _load_own=load)


def first_rpdo(drive: Drive) -> None:
    """Of several before a SYNC the first one counts."""
    rpdo = drive.node._rpdo

    def taken(target: Rpdo, data: bytes, now: Ns) -> None:
        if target.pending is None:
            rpdo(target, data, now)

    put(drive.node, _rpdo=taken)


def short_taken(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Fills up what is missing with zeros."""
    return [frame._replace(data=frame.data.ljust(6, b"\0"))] if frame.identifier == cobid.rpdo(1, NODE) else [frame]


def always_operational(drive: Drive) -> None:
    """PDOs whatever the state."""
    node = drive.node
    enter = node._enter

    def entered(state: State, now: Ns) -> None:
        enter(State.OPERATIONAL if state is State.PRE_OPERATIONAL and node.state is State.OPERATIONAL else state, now)

    put(node, _enter=entered)


def kept_rpdos(drive: Drive) -> None:
    node = drive.node
    enter = node._enter

    def entered(state: State, now: Ns) -> None:
        waiting = [rpdo.pending for rpdo in node._rpdos]
        enter(state, now)
        for rpdo, data in zip(node._rpdos, waiting, strict=True):
            rpdo.pending = data

    put(node, _enter=entered)


def stuck_contents(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(data=bytes((frame.data[0] ^ 1,)) + frame.data[1:])] if frame.identifier == cobid.tpdo(1, NODE) else [frame]


def each_50th(drive: Drive, frame: Frame) -> Sequence[Frame]:
    if frame.identifier != cobid.tpdo(1, NODE):
        return [frame]
    drive.tally += 1
    return [] if drive.tally % 50 == 0 else [frame]


def fixed_identifier(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(identifier=cobid.tpdo(1, NODE))] if frame.identifier == 0x6B0 else [frame]


def served_when_stopped(drive: Drive) -> None:
    node = drive.node

    def served(frame: Frame, now: Ns) -> None:
        node.output += [Frame(cobid.sdo_answer(node.number), data) for data in node.sdo.handle(frame.data, now)]

    put(node, _sdo=served)
    node._replan()


def other_number(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """SDO requests to the next node are its own as well."""
    return [frame._replace(identifier=cobid.sdo_request(NODE))] if frame.identifier == cobid.sdo_request(NODE + 1) else [frame]


def lss_answers(change: Callable[[bytes], bytes]) -> Says:
    return on(cobid.LSS_SLAVE, lambda drive, frame: [frame._replace(data=change(frame.data))])


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


def tires(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """An answer in 250 is lost."""
    if frame.identifier != cobid.sdo_answer(NODE):
        return [frame]
    drive.tally += 1
    return [] if drive.tally % 250 == 0 else [frame]


class KeepsUnsaved(Drive):
    """1017h survives a power failure without having been stored."""

    def power(self, on: bool, now: Ns) -> None:
        objects = self.node.objects
        before = objects.values[0x1017, 0]
        super().power(on, now)
        if on:
            objects.values[0x1017, 0] = before


class NoBootAtPower(Drive):
    """No boot-up message after a power failure."""

    def power(self, on: bool, now: Ns) -> None:
        super().power(on, now)
        if on:
            self._says = on_heartbeat_silent


def on_heartbeat_silent(drive: Drive, frame: Frame) -> list[Frame]:
    return [] if frame.identifier == cobid.heartbeat(NODE) else [frame]


class Late(Drive):
    """Its SDO answers come so much later."""

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


def chatty(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Something of another node on the bus with every frame it sends."""
    return [Frame(cobid.heartbeat(77), b"\x05"), frame]
