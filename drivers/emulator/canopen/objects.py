"""The living object dictionary of an emulated CANopen device: values, limits, access rules, store and restore.

Source: CiA 301, 7.4 and objects 1010h, 1011h; aborts in the order of AX-280.
"""

from collections.abc import Callable

from protocols.base.errors import DecodeError, EncodeError
from protocols.canopen.dictionary import Entry, Key, ObjectDictionary, fits
from protocols.canopen.sdo import Abort
from protocols.canopen.types import Value, decode, encode

Check = Callable[[Value], int]  # abort code or 0, before a value is accepted
Written = Callable[[Value], None]  # after it was accepted
Read = Callable[[], Value]

OK = 0
MOST_BYTES = 65_536  # of one string or domain
SAVE, LOAD = 0x65766173, 0x64616F6C  # "save", "load"
STORE, RESTORE = 0x1010, 0x1011
ALL, COMMUNICATION, APPLICATION = 1, 2, 3  # sub-indexes of both
NOT_STORED = frozenset((0x1001, 0x1003, STORE, RESTORE, 0x6040, 0x607A, 0x6071, 0x60FF, 0x60C1, 0x60B8))


class Objects:
    """`values` may be read and written by the device's own parts; only `upload` and `download` obey the access rules."""

    def __init__(self, dictionary: ObjectDictionary, node: int) -> None:
        self.dictionary, self.node = dictionary, node
        self.stored: dict[Key, Value] = {}  # what survives a reset
        self.defaults_next = set[int]()  # groups that come up with their defaults after the next reset
        self.checks: dict[Key, Check] = {}
        self.written: dict[Key, Written] = {}
        self.readers: dict[Key, Read] = {}
        self.refused: dict[Key, tuple[int, int]] = {}  # to order: (abort code, how often)
        self.memory_broken = False  # to order: storing ends in 06060000h
        self.may_store: Callable[[], bool] = lambda: True
        self.factory: dict[Key, Value] = {}  # defaults of this very device in place of the data sheet's
        self.values: dict[Key, Value] = {entry.key: entry.default_of(node) for entry in dictionary}
        for index, word, act in ((STORE, SAVE, self._store), (RESTORE, LOAD, self._restore)):
            for entry in dictionary.subs(index):
                if entry.sub:
                    self.checks[entry.key] = self._signed(word, act, entry.sub)

    # -- SDO ------------------------------------------------------------------------------------

    def upload(self, key: Key) -> bytes | Abort | int:
        """The bytes of an object, or an abort code."""
        entry = self.dictionary.entries.get(key)
        if entry is None:
            return self.missing(key)
        if code := self._ordered(key):
            return code
        if not entry.access.readable:
            return Abort.WRITE_ONLY
        value = self.read(key)
        try:
            return value if isinstance(value, Abort) else encode(entry.type, value)
        except EncodeError:
            return Abort.INTERNAL  # the data sheet gives the object a type that its value does not fit

    def download(self, key: Key, data: bytes) -> int:
        """0 or an abort code; nothing is changed then."""
        entry = self.dictionary.entries.get(key)
        if entry is None:
            return self.missing(key)
        if code := self._ordered(key) or writable(entry, len(data)):
            return code
        try:
            value = decode(entry.type, data)
        except DecodeError:
            return Abort.LENGTH
        return self.write(key, value)

    def write(self, key: Key, value: Value) -> int:
        """As a download after its form was found right: limits, checks, reactions."""
        entry = self.dictionary.entries[key]
        if beyond := fits(entry, value):
            return Abort.TOO_HIGH if beyond > 0 else Abort.TOO_LOW
        check = self.checks.get(key)
        if check is not None and (code := check(value)):
            return code
        if entry.index in (STORE, RESTORE):
            return OK  # the signature was an order, not a value
        self.values[key] = value
        if (written := self.written.get(key)) is not None:
            written(value)
        return OK

    def read(self, key: Key) -> Value:
        """The living value; an Abort where there is none (1003h beyond its count)."""
        reader = self.readers.get(key)
        return self.values[key] if reader is None else reader()

    def whole(self, key: Key) -> int:
        """A number the dictionary surely has."""
        value = self.values.get(key, 0)
        return value if isinstance(value, int) else 0

    def missing(self, key: Key) -> Abort:
        return Abort.NO_SUB if key[0] in self.dictionary.heads else Abort.NO_OBJECT

    def _ordered(self, key: Key) -> int:
        if key not in self.refused:
            return OK
        code, left = self.refused.pop(key)
        if left > 1:
            self.refused[key] = code, left - 1
        return code

    # -- store and restore ----------------------------------------------------------------------

    def reset(self, node: int, application: bool) -> None:
        """After a reset: stored values if any, else defaults; communication objects alone unless `application`."""
        self.node = node
        for entry in self.dictionary:
            communication = entry.index < 0x2000
            if not communication and not application:
                continue
            group = COMMUNICATION if communication else APPLICATION
            if ALL in self.defaults_next or group in self.defaults_next:
                self.stored.pop(entry.key, None)
            default = self.factory[entry.key] if entry.key in self.factory else entry.default_of(node)
            self.values[entry.key] = self.stored.get(entry.key, default)
        self.defaults_next -= {ALL, COMMUNICATION, APPLICATION} if application else {COMMUNICATION}

    def _signed(self, word: int, act: Callable[[int], int], sub: int) -> Check:
        return lambda value: act(sub) if value == word else Abort.NO_STORE

    def _store(self, sub: int) -> int:
        if not self.may_store():
            return Abort.DEVICE_STATE
        if self.memory_broken:
            return Abort.HARDWARE
        for entry in self.dictionary:
            mine = sub == ALL or (sub == COMMUNICATION) == (entry.index < 0x2000)
            if mine and entry.access.writable and entry.index not in NOT_STORED:
                self.stored[entry.key] = self.values[entry.key]
        self.defaults_next -= {sub}
        return OK

    def _restore(self, sub: int) -> int:
        if not self.may_store():
            return Abort.DEVICE_STATE
        self.defaults_next.add(sub)
        return OK


def writable(entry: Entry, size: int) -> int:
    """Abort code if a download of so many bytes cannot be right, else 0."""
    if not entry.access.writable:
        return Abort.READ_ONLY
    if entry.type.size:
        return Abort.TOO_LONG if size > entry.type.size else Abort.TOO_SHORT if size < entry.type.size else OK
    return Abort.MEMORY if size > MOST_BYTES else OK
