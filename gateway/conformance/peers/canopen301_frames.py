"""CANopen: frames that the emulated drive of axisgate sends or receives otherwise (used by peers.canopen301)."""

from collections.abc import Callable, Sequence

from gateway.conformance.peers.can_devices import NODE, Drive, Says
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort, Answer


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


def toggle_zero(data: bytes) -> bytes:
    return bytes((data[0] & ~sdo.TOGGLE,)) + data[1:]


def all_used(data: bytes) -> bytes:
    """A last segment of seven bytes, whatever is in it."""
    return bytes((data[0] & ~0x0E,)) + data[1:]


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
    """NMT commands it accepts: (command, node)."""

    def hears(drive: Drive, frame: Frame) -> Sequence[Frame]:
        if frame.identifier != cobid.NMT or len(frame.data) != 2:
            return [frame]
        found = change(frame.data[0], frame.data[1])
        return [] if found is None else [frame._replace(data=bytes(found))]

    return hears


def no_toggle(drive: Drive, frame: Frame) -> Sequence[Frame]:
    if frame.identifier == cobid.heartbeat(NODE) and frame.data[0] & 0x80:
        return [frame._replace(data=bytes((frame.data[0] & 0x7F,)))]
    return [frame]


def short_taken(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Fills up missing bytes with zeros."""
    return [frame._replace(data=frame.data.ljust(6, b"\0"))] if frame.identifier == cobid.rpdo(1, NODE) else [frame]


def stuck_contents(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(data=bytes((frame.data[0] ^ 1,)) + frame.data[1:])] if frame.identifier == cobid.tpdo(1, NODE) else [frame]


def each_50th(drive: Drive, frame: Frame) -> Sequence[Frame]:
    if frame.identifier != cobid.tpdo(1, NODE):
        return [frame]
    drive.tally += 1
    return [] if drive.tally % 50 == 0 else [frame]


def fixed_identifier(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(identifier=cobid.tpdo(1, NODE))] if frame.identifier == 0x6B0 else [frame]


def other_number(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """SDO requests to the next node are its own as well."""
    return [frame._replace(identifier=cobid.sdo_request(NODE))] if frame.identifier == cobid.sdo_request(NODE + 1) else [frame]


def lss_answers(change: Callable[[bytes], bytes]) -> Says:
    return on(cobid.LSS_SLAVE, lambda drive, frame: [frame._replace(data=change(frame.data))])


def tires(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """An answer in 250 is lost."""
    if frame.identifier != cobid.sdo_answer(NODE):
        return [frame]
    drive.tally += 1
    return [] if drive.tally % 250 == 0 else [frame]


def unknown_unheard(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """An SDO with an unknown command specifier."""
    return [] if frame.data[:1] == b"\xe0" else [frame]


def on_heartbeat_silent(drive: Drive, frame: Frame) -> list[Frame]:
    return [] if frame.identifier == cobid.heartbeat(NODE) else [frame]


def chatty(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Something of another node on the bus with every frame it sends."""
    return [Frame(cobid.heartbeat(77), b"\x05"), frame]


def sub_for_index(data: bytes) -> bytes:
    missing = int(Abort.NO_OBJECT).to_bytes(4, "little")
    return data[:4] + int(Abort.NO_SUB).to_bytes(4, "little") if data[0] == 0x80 and data[4:] == missing else data


def general(data: bytes) -> bytes:
    return data[:4] + bytes((0, 0, 0, 8)) if data[0] == 0x80 else data
