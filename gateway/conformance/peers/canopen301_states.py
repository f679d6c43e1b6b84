"""CANopen: parts with faults of states, repetitions and order, as firmware errs between two services (used by peers.canopen301)."""

from collections.abc import Callable, Sequence
from functools import partial

from drivers.emulator.canopen.guard import NEVER, LifeSigns
from drivers.emulator.canopen.objects import OK, Objects
from drivers.emulator.canopen.pdo import TYPE, Pdo, Tpdo
from drivers.emulator.canopen.sdo import Phase, SdoServer
from gateway.conformance.peers.can_devices import NODE, Drive, Tune, put
from gateway.conformance.peers.canopen301_servers import server
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import pdo, sdo
from protocols.canopen.dictionary import Key
from protocols.canopen.emcy import Emergency
from protocols.canopen.nmt import State
from protocols.canopen.sdo import Abort

LOST = 0x8130


# ---- SDO
class SecondToggle(SdoServer):
    """The toggle bit counts in the first segment only: a repeated segment is accepted twice."""

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase is Phase.DOWNLOAD and self._data and request[0] >> 5 == sdo.Request.DOWNLOAD_SEGMENT:
            request = bytes((request[0] & ~sdo.TOGGLE | sdo.TOGGLE * self._toggle,)) + request[1:]
        return super().handle(request, now)


class WritesAborted(SdoServer):
    """Writes the data so far when the client aborts."""

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase is Phase.DOWNLOAD and request[0] == sdo.Request.ABORT << 5 and self._data:
            self._objects.values[self._key] = int.from_bytes(self._data, "little")
        return super().handle(request, now)


class SkipsGaps(SdoServer):
    """A segment of a block that is missing is not missed."""

    def _block_segment(self, segment: bytes) -> list[bytes]:
        self._sequence = max(self._sequence, (segment[0] & 0x7F) - 1)
        return super()._block_segment(segment)


class CrcAlways(SdoServer):
    """Checks a CRC that the client did not offer."""

    def _block_download(self, request: bytes) -> list[bytes]:
        said = super()._block_download(request)
        self._crc = True
        return said


# ---- states
def boots_twice(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame, frame] if frame.identifier == cobid.heartbeat(NODE) and frame.data == b"\0" else [frame]


def no_sdo_at_work(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [] if frame.identifier == cobid.sdo_request(NODE) and drive.node.state is State.OPERATIONAL else [frame]


def remembers(drive: Drive) -> None:
    """Reset node keeps the written values."""
    reset = drive.node.objects.reset
    put(drive.node.objects, reset=lambda node, application: None if application else reset(node, application))


def keeps_pdos(drive: Drive) -> None:
    """Reset communication keeps the parameters of the PDOs."""
    objects = drive.node.objects
    reset = objects.reset

    def kept(node: int, application: bool) -> None:
        before = {key: value for key, value in objects.values.items() if 0x1800 <= key[0] < 0x1A00 and not application}
        reset(node, application)
        objects.values.update(before)

    put(objects, reset=kept)


def sends_when_stopped(drive: Drive) -> None:
    """SYNC is served in state stopped as well."""
    node = drive.node
    serve = node._sync

    def served(frame: Frame, now: Ns) -> None:
        before = node.state
        if before is State.STOPPED:
            node.state = State.OPERATIONAL
        serve(frame, now)
        node.state = before

    put(node, _sync=served)
    node._replan()


def timers_run_on(drive: Drive) -> None:
    """Event timers do not end with state operational."""
    node = drive.node
    enter, events = node._enter, node.events

    def entered(state: State, now: Ns) -> None:
        due = [tpdo.due for tpdo in node.pdos.sent]
        enter(state, now)
        for tpdo, before in zip(node.pdos.sent, due, strict=True):
            tpdo.due = before if state is State.PRE_OPERATIONAL else tpdo.due

    def always(now: Ns) -> None:
        before = node.state
        if before is State.PRE_OPERATIONAL:
            node.state = State.OPERATIONAL
        events(now)
        node.state = before

    put(node, _enter=entered, events=always)


# ---- errors
class Misread:
    """The object dictionary as the emergency part reads it, with one object misread."""

    def __init__(self, objects: Objects, key: Key, clear: int) -> None:
        self._real, self._key, self._clear = objects, key, clear

    def whole(self, key: Key) -> int:
        found = self._real.whole(key)
        return found & ~self._clear if key == self._key else found


def emergencies_never_off(drive: Drive) -> None:
    put(drive.node.emergencies, _objects=Misread(drive.node.objects, (0x1014, 0), cobid.INVALID))


def emergencies_unhindered(drive: Drive) -> None:
    put(drive.node.emergencies, _objects=Misread(drive.node.objects, (0x1015, 0), 0xFFFF))


def reports_again(drive: Drive) -> None:
    """A lost heartbeat is reported with each of its periods."""
    consumer, emergencies = drive.node.consumer, drive.node.emergencies
    expired = consumer.expired

    def again(now: Ns) -> list[int]:
        found = expired(now)
        for number in found:
            consumer.watched[number].due = now + consumer.watched[number].time_ns
            emergencies.active.pop(LOST, None)
        return found

    put(consumer, expired=again)


def watches_unheard(drive: Drive) -> None:
    """A heartbeat is missed before it came for the first time."""
    consumer = drive.node.consumer
    load = consumer.load

    def loaded() -> None:
        load()
        for watched in consumer.watched.values():
            watched.due = drive.now + watched.time_ns if watched.due == NEVER else watched.due

    put(consumer, load=loaded)


def any_heartbeat(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """The heartbeat of any node is the one that is watched."""
    return [frame._replace(identifier=0x700 + 126)] if 0x701 <= frame.identifier <= 0x77F else [frame]


def register_sticks(drive: Drive) -> None:
    """Bits of 1001h are set, and never cleared but by a reset."""
    emergencies = drive.node.emergencies
    report, reset = emergencies._report, emergencies.reset

    def reported(message: Emergency, now: Ns) -> None:
        drive.tally |= int(emergencies.register)
        report(message, now)

    def forgotten() -> None:
        drive.tally = 0
        reset()

    put(emergencies, _report=reported, reset=forgotten)
    drive.node.objects.readers[0x1001, 0] = lambda: drive.tally


def guards_as_before(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Node guarding shows pre-operational, whatever the state is."""
    guard = frame.identifier == cobid.heartbeat(NODE) and not drive.node.objects.whole((0x1017, 0)) and frame.data != b"\0"
    return [frame._replace(data=bytes((frame.data[0] & 0x80 | State.PRE_OPERATIONAL,)))] if guard else [frame]


def beats_toggle(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Its heartbeat has the toggle bit of node guarding."""
    if frame.identifier != cobid.heartbeat(NODE) or frame.data == b"\0" or not drive.node.objects.whole((0x1017, 0)):
        return [frame]
    drive.tally ^= 0x80
    return [frame._replace(data=bytes((frame.data[0] | drive.tally,)))]


# ---- PDO
def _after_loading(item: Pdo, act: Callable[[], None]) -> None:
    """Run `act` on a PDO whenever it loads its parameters."""
    own = item._load_own

    def load() -> None:
        own()
        act()

    put(item, _load_own=load)


def takes_invalid(drive: Drive) -> None:
    """Bit 31 of an RPDO does not count."""
    for item in drive.node.pdos.received:
        _after_loading(item, partial(_made_valid, item))


def _made_valid(item: Pdo) -> None:
    item.valid = bool(item.mapping.parts)


def no_wrap(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """A SYNC counter that restarts with 1 counts as an error."""
    if frame.identifier != cobid.SYNC:
        return [frame]
    before, drive.tally = drive.tally, frame.data[0] if frame.data else 0
    return [] if frame.data and frame.data[0] < before else [frame]


def starts_at_once(drive: Drive) -> None:
    """1800h:06 does not count."""
    for item in drive.node.pdos.sent:
        _after_loading(item, partial(put, item, start_at=0, waits_for_start=False))


def any_entry_length(drive: Drive) -> None:
    """The length of an entry is not compared with its object."""
    for item in drive.node.pdos.sent:
        put(item, _entry_sound=partial(_sound_but_for_length, drive, item._entry_sound))


def _sound_but_for_length(drive: Drive, sound: Callable[[int], int], word: int) -> int:
    part = pdo.mapped(word)
    entry = drive.node.objects.dictionary.entry(part.index, part.sub)
    return sound(word & ~0xFF | (entry.type.bits if entry is not None else part.bits))


class FreeTpdo(Tpdo):
    """Can be remapped while it is valid."""

    @property
    def _exists(self) -> bool:
        return False


def remaps_valid(drive: Drive) -> None:
    for item in drive.node.pdos.sent:
        item.__class__ = FreeTpdo


def remaps_counted(drive: Drive) -> None:
    """1800h:01 alone is checked before an entry is written, not the number of entries."""

    def only_invalid(item: Tpdo) -> Callable[[object], int]:
        return lambda value: Abort.ACCESS if item._exists else OK

    for item in drive.node.pdos.sent:
        for sub in range(1, 9):
            if (item.map, sub) in drive.node.objects.values:
                drive.node.objects.checks[item.map, sub] = only_invalid(item)


# ---- correct devices unlike it
def refuses(*ranges: range, taken: Sequence[int] = ()) -> Tune:
    """Entries of these indexes are constant; with `taken`: they accept these values."""

    def tune(drive: Drive) -> None:
        objects = drive.node.objects
        for key in objects.values:
            if any(key[0] in one for one in ranges) and (not taken or key[1] == TYPE):
                objects.checks[key] = lambda value: OK if value in taken else Abort.VALUE if taken else Abort.READ_ONLY

    return tune


def starts_itself(drive: Drive) -> None:
    """Operational without a command (1F80h)."""
    node = drive.node
    booted = node._booted

    def began(now: Ns) -> None:
        booted(now)
        node._enter(State.OPERATIONAL, now)

    put(node, _booted=began)


def late_ready(drive: Drive) -> None:
    """Its SDO server begins 800 ms after its boot-up message."""
    node = drive.node
    booted, serve = node._booted, node._sdo

    def began(now: Ns) -> None:
        booted(now)
        drive.tally = now + ms(800)

    put(node, _booted=began, _sdo=lambda frame, now: serve(frame, now) if now >= drive.tally else None)
    node._replan()


def coarse_beats(drive: Drive) -> None:
    """Its heartbeat has a clock of 10 ms."""

    class Coarse(LifeSigns):
        @property
        def beat_ns(self) -> Ns:
            return -(-super().beat_ns // ms(10)) * ms(10)

    drive.node.life.__class__ = Coarse


def never_says_gone(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Sends no message that an error is gone."""
    return [] if frame.identifier == cobid.emcy(NODE) and frame.data[:2] == b"\0\0" else [frame]


def expedited_only(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Segmented and block transfers are unknown to it."""
    command = frame.data[0] >> 5 if frame.data else 0
    other = command in (0, 3, 5, 6) or (command == 1 and not frame.data[0] & sdo.EXPEDITED)
    return [frame._replace(data=b"\xe0" + frame.data[1:])] if frame.identifier == cobid.sdo_request(NODE) and other else [frame]


second_toggle, writes_aborted, skips_gaps, crc_always = (server(kind) for kind in (SecondToggle, WritesAborted, SkipsGaps, CrcAlways))
