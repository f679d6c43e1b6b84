"""All PDOs of an emulated device, by their trigger: SYNC, an event or the end of a time.  Source: CiA 301, 7.2.2."""

from collections.abc import Callable

from drivers.emulator.canopen.objects import Objects
from drivers.emulator.canopen.pdo import NEVER, Rpdo, Tpdo
from protocols.base.machine import Ns
from protocols.canopen import pdo
from protocols.canopen.dictionary import ObjectDictionary


class Pdos:
    """`received` and `sent` by number; the other lists are the valid ones among them."""

    def __init__(self) -> None:
        """Empty until `make` reads the mapping from the objects."""
        self.received: list[Rpdo] = []
        self.sent: list[Tpdo] = []
        self.held: list[Rpdo] = []  # their data waits for SYNC
        self.with_sync: list[Tpdo] = []
        self.by_event: list[Tpdo] = []

    def make(self, objects: Objects, changed: Callable[[], None]) -> None:
        """Call it after the device has registered its handlers at the objects."""
        self.received = [Rpdo(objects, number, changed) for number in _numbers(objects.dictionary, pdo.RPDO_COMMUNICATION)]
        self.sent = [Tpdo(objects, number, changed) for number in _numbers(objects.dictionary, pdo.TPDO_COMMUNICATION)]

    def load(self) -> None:
        """Takes over the contents of the dictionary."""
        for item in (*self.received, *self.sent):
            item.load()

    def sort(self) -> None:
        """After one of them changed."""
        self.held = [item for item in self.received if item.valid and item.synchronous]
        self.with_sync = [item for item in self.sent if item.valid and (item.type <= pdo.SYNC_LAST or item.type == pdo.RTR_SYNC)]
        self.by_event = [item for item in self.sent if item.valid and (item.by_event or item.type == pdo.SYNC_ACYCLIC)]

    def takers(self) -> dict[int, list[Rpdo]]:
        """RPDOs by identifier; those with equal identifiers all receive the frame."""
        found: dict[int, list[Rpdo]] = {}
        for item in self.received:
            if item.valid:
                found.setdefault(item.identifier, []).append(item)
        return found

    def due(self, due: Ns) -> Ns:
        """The next instant at which one of them has work, `due` at the latest."""
        for tpdo in self.by_event:
            due = min(due, tpdo.due, tpdo.free_at if tpdo.happened and tpdo.by_event else NEVER)
        for rpdo in self.received:
            due = rpdo.due if rpdo.due < due else due
        return due

    def begin(self) -> None:
        """State operational: counts and times begin."""
        for tpdo in self.sent:
            tpdo.count, tpdo.waits_for_start, tpdo.free_at = 0, tpdo.start_at > 0, 0
        for rpdo in self.received:
            rpdo.pending, rpdo.due = None, NEVER

    def end(self) -> None:
        """Another state: no time runs on."""
        for rpdo in self.received:
            rpdo.due = NEVER
        for tpdo in self.sent:
            tpdo.due = NEVER

    def power_down(self) -> None:
        """Nothing is sent any more, so nothing may stay due: otherwise time would not advance."""
        self.by_event = []
        for item in self.received:
            item.due = NEVER


def _numbers(dictionary: ObjectDictionary, first: int) -> list[int]:
    return [index - first for index in sorted(dictionary.heads) if first <= index < first + 0x200]
