"""PDOs of an emulated device: dynamic mapping with its rules, transmission types, inhibit and event timers.

Source: CiA 301, 7.2.2 and objects 1400h.., 1600h.., 1800h.., 1A00h..; choices where CiA 301 is open: AX-282, AX-283.
"""

import struct
from collections.abc import Callable, Sequence

from drivers.emulator.canopen.objects import OK, Objects
from protocols.base.machine import Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import pdo
from protocols.canopen.dictionary import Key
from protocols.canopen.sdo import Abort
from protocols.canopen.types import TYPES, DataType, Kind, Value

NEVER: Ns = 1 << 62
COB, TYPE, INHIBIT, EVENT, START = 1, 2, 3, 5, 6  # sub-indexes of the communication record
_CODES = {(Kind.SIGNED, 8): "b", (Kind.SIGNED, 16): "h", (Kind.SIGNED, 32): "i", (Kind.SIGNED, 64): "q"}
_CODES |= {(Kind.UNSIGNED, bits): code.upper() for (_, bits), code in list(_CODES.items())}


class Mapping:
    """The compiled content of one PDO: which objects at which bits."""

    def __init__(self, objects: Objects, words: Sequence[int]) -> None:
        self.parts = [pdo.mapped(word) for word in words]
        self.bits = sum(part.bits for part in self.parts)
        self.size = (self.bits + 7) // 8
        self.keys: list[Key] = [(part.index, part.sub) for part in self.parts]
        self.types = [_type_of(objects, part) for part in self.parts]
        codes = [_CODES.get((kind.kind, kind.bits)) for kind in self.types]
        aligned = all(codes) and all(part.bits == kind.bits for part, kind in zip(self.parts, self.types, strict=True))
        self.struct = struct.Struct("<" + "".join(code or "" for code in codes)) if aligned else None

    def pack(self, values: Sequence[Value]) -> bytes:
        """Values in the order of the keys."""
        if self.struct is not None:
            try:
                return self.struct.pack(*values)
            except struct.error:
                pass  # a value beyond its type: its low bits, as below
        total = place = 0
        for part, kind, value in zip(self.parts, self.types, values, strict=True):
            total |= (_bits(kind, value) & ((1 << part.bits) - 1)) << place
            place += part.bits
        return total.to_bytes(self.size, "little")

    def unpack(self, data: bytes) -> Sequence[Value]:
        """The values of the first `size` bytes."""
        if self.struct is not None:
            return self.struct.unpack_from(data)
        total, values = int.from_bytes(data[: self.size], "little"), []
        for part, kind in zip(self.parts, self.types, strict=True):
            raw, total = total & ((1 << part.bits) - 1), total >> part.bits
            values.append(_value(kind, raw, part.bits))
        return values


def _type_of(objects: Objects, part: pdo.Mapped) -> DataType:
    entry = objects.dictionary.entries.get((part.index, part.sub))
    return entry.type if entry is not None else TYPES[part.index]


def _bits(kind: DataType, value: Value) -> int:
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return int.from_bytes(struct.pack("<f" if kind.bits == 32 else "<d", value), "little")
    return int.from_bytes(value.encode("latin-1", "replace") if isinstance(value, str) else value, "little")


def _value(kind: DataType, raw: int, bits: int) -> Value:
    if kind.kind is Kind.SIGNED:
        return raw - (1 << bits) if raw >> (bits - 1) else raw
    if kind.kind is Kind.REAL:
        return float(struct.unpack("<f" if kind.bits == 32 else "<d", raw.to_bytes(bits // 8, "little"))[0])
    return raw if kind.whole else raw.to_bytes((bits + 7) // 8, "little")


class Pdo:
    """Common to RPDO and TPDO: the two objects and the rules for changing them."""

    def __init__(self, objects: Objects, communication: int, mapping: int, receives: bool, changed: Callable[[], None]) -> None:
        self.objects, self.com, self.map = objects, communication, mapping
        self.receives, self._changed = receives, changed
        self.number = communication & 0x1FF
        self.valid = False
        self.identifier = 0
        self.type = pdo.EVENT_PROFILE
        self.mapping = Mapping(objects, [])
        self._hook()
        self.load()

    def _hook(self) -> None:
        checks, written = self.objects.checks, self.objects.written
        checks[self.com, COB], checks[self.com, TYPE] = self._check_identifier, self._check_type
        for sub in (INHIBIT, START):
            checks[self.com, sub] = lambda value: Abort.ACCESS if self.valid else OK
        for sub in (COB, TYPE, INHIBIT, EVENT, START):
            written[self.com, sub] = lambda value: self.load()
        checks[self.map, 0] = self._check_count
        written[self.map, 0] = lambda value: self.load()
        for sub in range(1, pdo.MOST_ENTRIES + 1):
            if (self.map, sub) in self.objects.values:
                checks[self.map, sub] = self._check_entry

    def load(self) -> None:
        """Takes over the contents of the dictionary."""
        objects, cob = self.objects, self.objects.whole((self.com, COB))
        self.identifier = cob & cobid.ID_BITS
        count = objects.whole((self.map, 0))
        words = [objects.whole((self.map, sub)) for sub in range(1, count + 1)]
        self.mapping = Mapping(objects, words if self._sound(words) == OK else [])
        self.valid = not cob & cobid.INVALID and bool(self.mapping.parts)
        self.type = objects.whole((self.com, TYPE))
        self._load_own()
        self._changed()

    def _load_own(self) -> None:
        """Load the parameters of one direction."""

    @property
    def _exists(self) -> bool:
        return not self.objects.whole((self.com, COB)) & cobid.INVALID

    # -- rules ----------------------------------------------------------------------------------

    def _check_identifier(self, value: Value) -> int:
        new, old = int(value) if isinstance(value, int) else 0, self.objects.whole((self.com, COB))
        if new & cobid.EXTENDED or (not new & cobid.INVALID and cobid.restricted(new & cobid.ID_BITS)):
            return Abort.VALUE
        if not old & cobid.INVALID and not new & cobid.INVALID and (new ^ old) & cobid.ID_BITS:
            return Abort.VALUE  # an existing PDO keeps its identifier
        return OK

    def _check_type(self, value: Value) -> int:
        if not isinstance(value, int) or pdo.reserved(value):
            return Abort.VALUE
        return Abort.VALUE if self.receives and value in (pdo.RTR_SYNC, pdo.RTR_EVENT) else OK

    def _check_entry(self, value: Value) -> int:
        if self._exists or self.objects.whole((self.map, 0)):
            return Abort.ACCESS  # invalid first, then no entries, then the entries
        return self._entry_sound(int(value)) if isinstance(value, int) and value else OK

    def _check_count(self, value: Value) -> int:
        if not isinstance(value, int) or not value:
            return Abort.ACCESS if self._exists else OK
        if self._exists:
            return Abort.ACCESS
        if value > pdo.MOST_ENTRIES or (self.map, value) not in self.objects.values:
            return Abort.MAPPED_LENGTH if value <= pdo.MOST_ENTRIES else Abort.VALUE
        return self._sound([self.objects.whole((self.map, sub)) for sub in range(1, value + 1)])

    def _sound(self, words: Sequence[int]) -> int:
        for word in words:
            if code := self._entry_sound(word):
                return code
        return Abort.MAPPED_LENGTH if sum(pdo.mapped(word).bits for word in words) > pdo.MOST_BITS else OK

    def _entry_sound(self, word: int) -> int:
        part = pdo.mapped(word)
        dictionary = self.objects.dictionary
        if self.receives and part.index in dictionary.dummies and not part.sub:
            return OK if TYPES[part.index].bits == part.bits else Abort.NOT_MAPPABLE
        entry = dictionary.entry(part.index, part.sub)
        if entry is None:
            return self.objects.missing((part.index, part.sub))
        if not (entry.receivable if self.receives else entry.transmittable):
            return Abort.NOT_MAPPABLE
        return OK if entry.type.bits == part.bits or (not entry.type.bits and part.bits <= pdo.MOST_BITS) else Abort.NOT_MAPPABLE


class Rpdo(Pdo):
    """`pending`: data that waits for SYNC."""

    def __init__(self, objects: Objects, number: int, changed: Callable[[], None]) -> None:
        self.pending: bytes | None = None
        self.takers: list[Callable[[Value], None]] = []
        self.time_out_ns: Ns = 0
        self.due: Ns = NEVER  # its deadline monitoring (event timer of an RPDO)
        super().__init__(objects, pdo.RPDO_COMMUNICATION + number, pdo.RPDO_MAPPING + number, True, changed)

    def _load_own(self) -> None:
        self.pending = None
        self.time_out_ns = self.objects.whole((self.com, EVENT)) * 1_000_000
        self.due = NEVER
        self.takers = [self._taker(key) for key in self.mapping.keys]

    def _taker(self, key: Key) -> Callable[[Value], None]:
        """The function that stores one value; a value outside the entry's limits is ignored (AX-283)."""
        objects = self.objects
        entry, values, written = objects.dictionary.entries.get(key), objects.values, objects.written.get(key)
        if entry is None:
            return lambda value: None  # a dummy
        limited, checks = entry.low is not None or entry.high is not None, objects.checks

        def take(value: Value) -> None:
            if limited:
                objects.write(key, value)
                return
            check = checks.get(key)
            if check is not None and check(value):
                return
            values[key] = value
            if written is not None:
                written(value)

        return take

    def apply(self, data: bytes) -> None:
        """Write the mapped objects in the order of the mapping."""
        for take, value in zip(self.takers, self.mapping.unpack(data), strict=True):
            take(value)

    @property
    def synchronous(self) -> bool:
        return self.type <= pdo.SYNC_LAST


class Tpdo(Pdo):
    """`values` are the readers of the mapped objects, in order."""

    def __init__(self, objects: Objects, number: int, changed: Callable[[], None]) -> None:
        self.readers: list[Callable[[], Value]] = []
        self.last = b""  # data sent last
        self.happened = False  # an event that waits for SYNC or for the end of the inhibit time
        self.count = 0  # SYNCs since the last one sent
        self.waits_for_start = False
        self.inhibit_ns = self.event_ns = 0
        self.free_at: Ns = 0  # end of the inhibit time
        self.due: Ns = NEVER  # event timer
        self.sampled: bytes | None = None  # type 252: the value at the last SYNC
        self.start_at = 0
        self.rtr = False
        super().__init__(objects, pdo.TPDO_COMMUNICATION + number, pdo.TPDO_MAPPING + number, False, changed)

    def _load_own(self) -> None:
        objects = self.objects
        self.rtr = not objects.whole((self.com, COB)) & cobid.NO_RTR
        self.inhibit_ns = objects.whole((self.com, INHIBIT)) * 100_000
        self.event_ns = objects.whole((self.com, EVENT)) * 1_000_000
        self.start_at = objects.whole((self.com, START))
        self.waits_for_start, self.count = self.start_at > 0, 0
        self.due, self.free_at, self.happened, self.sampled = NEVER, 0, False, None
        self.readers = [self._reader(key) for key in self.mapping.keys]

    def _reader(self, key: Key) -> Callable[[], Value]:
        living = self.objects.readers.get(key)
        values = self.objects.values
        return living if living is not None else lambda: values[key]

    def read(self) -> bytes:
        return self.mapping.pack([read() for read in self.readers])

    @property
    def cyclic(self) -> bool:
        """With every n-th SYNC."""
        return 1 <= self.type <= pdo.SYNC_LAST

    @property
    def by_event(self) -> bool:
        return self.type >= pdo.EVENT_MANUFACTURER

    def on_sync(self, counter: int | None) -> bytes | None:
        """PDOs due with this SYNC."""
        if self.type == pdo.RTR_SYNC:
            self.sampled = self.read()
            return None
        if self.type == pdo.SYNC_ACYCLIC:
            happened, self.happened = self.happened, False
            return self.read() if happened else None
        if self.waits_for_start and counter is not None:
            if counter != self.start_at:
                return None
            self.waits_for_start, self.count = False, self.type - 1
        self.count += 1
        if self.count < self.type:
            return None
        self.count = 0
        return self.read()
