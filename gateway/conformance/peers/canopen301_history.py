"""CANopen: wrong error histories, TPDOs of type 0 with each SYNC, contents shifted by power-on, wrong forms (used by peers.canopen301)."""

import functools
from collections.abc import Callable, Sequence

from drivers.emulator.canopen.guard import HISTORY, HISTORY_DEPTH
from drivers.emulator.canopen.objects import OK
from drivers.emulator.canopen.pdo import Tpdo
from gateway.conformance.peers.can_devices import NODE, Drive, Tune, put
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import pdo
from protocols.canopen.emcy import Register
from protocols.canopen.sdo import Abort
from protocols.canopen.types import Value


def _entries(drive: Drive, entry: Callable[[list[int], int], Value]) -> None:
    history = drive.node.emergencies.history
    for sub in range(1, HISTORY_DEPTH + 1):
        drive.node.objects.readers[HISTORY, sub] = functools.partial(entry, history, sub)


def oldest_first(drive: Drive) -> None:
    _entries(drive, lambda history, sub: history[-sub] if sub <= len(history) else Abort.NO_DATA)


def entries_stay(drive: Drive) -> None:
    """A write of 0 sets the count back, the entries can still be read."""
    kept = list[int]()

    def entry(history: list[int], sub: int) -> Value:
        if len(history) >= len(kept):
            kept[:] = history
        return kept[sub - 1] if sub <= len(kept) else Abort.NO_DATA

    _entries(drive, entry)
    history = drive.node.emergencies.history

    def written(value: Value) -> None:
        kept[:] = history
        history.clear()

    drive.node.objects.written[HISTORY, 0] = written


def newest_only_first(drive: Drive) -> None:
    """The entry before is overwritten by a second error."""
    raise_ = drive.node.emergencies.raise_

    def raised(code: int, register: Register, now: Ns, detail: bytes = b"") -> None:
        raise_(code, register, now, detail)
        history = drive.node.emergencies.history
        if len(history) > 1:
            history[1] = history[0]

    put(drive.node.emergencies, raise_=raised)


def cleared_by_refusal(drive: Drive) -> None:
    def check(value: Value) -> int:
        drive.node.emergencies.history.clear()
        return Abort.VALUE if value else OK

    drive.node.objects.checks[HISTORY, 0] = check


def refuses_one(drive: Drive) -> None:
    """1 and 2 are refused, greater values empty it."""
    drive.node.objects.checks[HISTORY, 0] = lambda value: Abort.VALUE if value in (1, 2) else OK


def always_event(drive: Drive) -> None:
    """Type 0 is as type 1."""

    def act(tpdo: Tpdo) -> None:
        real = tpdo.on_sync
        put(tpdo, on_sync=lambda counter: tpdo.read() if tpdo.type == pdo.SYNC_ACYCLIC else real(counter))

    for tpdo in drive.node.pdos.sent:
        act(tpdo)


class Shifted(Drive):
    """After power-on its TPDO 1 is a bit out of place."""

    def __init__(self, tune: Tune | None = None) -> None:
        super().__init__(tune, says=_shifts)
        self.powered = 0

    def power(self, on: bool, now: Ns) -> None:
        super().power(on, now)
        self.powered += on


def _shifts(drive: Drive, frame: Frame) -> Sequence[Frame]:
    if frame.identifier != cobid.tpdo(1, NODE) or not isinstance(drive, Shifted) or not drive.powered:
        return [frame]
    size = len(frame.data)
    value = int.from_bytes(frame.data, "little") << 1 & ((1 << 8 * size) - 1)
    return [frame._replace(data=value.to_bytes(size, "little"))]


# ---- forms that many cases see
def two_as_four(drive: Drive, frame: Frame) -> Sequence[Frame]:
    is_it = frame.identifier == cobid.sdo_answer(NODE) and frame.data[:1] == b"\x4b"
    return [frame._replace(data=b"\x43" + frame.data[1:])] if is_it else [frame]


def _aborts(frame: Frame, data: bytes) -> Sequence[Frame]:
    return [frame._replace(data=data)] if frame.identifier == cobid.sdo_answer(NODE) and frame.data[:1] == b"\x80" else [frame]


def short_aborts(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return _aborts(frame, frame.data[:7])


def turned_aborts(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return _aborts(frame, frame.data[:4] + frame.data[:3:-1])


def starts_for_others(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """Start acts whatever node it names."""
    is_it = frame.identifier == cobid.NMT and frame.data[:1] == b"\x01"
    return [frame._replace(data=b"\x01\x00")] if is_it else [frame]
