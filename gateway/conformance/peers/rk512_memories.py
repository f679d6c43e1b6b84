"""RK512: data blocks with one fault each (used by peers.rk512)."""

from collections.abc import Callable

from gateway.conformance.serial.partners import Blocks
from protocols.rk512.header import ErrorNumber, Kind
from protocols.rk512.passive import Areas


class Memory(Blocks):
    """Data blocks whose reads and writes are changed."""

    def __init__(
        self, read: Callable[[bytes, int, int, int], bytes] | None = None, where: Callable[[int, int], tuple[int, int]] | None = None
    ) -> None:
        super().__init__()
        self._changed, self._where = read, where or (lambda db, word: (db, word))

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        found = super().read(*self._where(db, word), words)
        return found if isinstance(found, ErrorNumber) or self._changed is None else self._changed(found, db, word, words)

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(*self._where(db, word), data)


class Rotates(Blocks):
    """A job of more than one word from an odd word on begins with its second word."""

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        found = super().read(db, word, words)
        return found if isinstance(found, ErrorNumber) or words == 1 or word % 2 == 0 else found[2:] + found[:2]


class Once(Blocks):
    """Data equal to those of the last write are not written."""

    _last = b""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        same, self._last = data == self._last, data
        return None if same else super().write(db, word, data)


class NotWritten(Blocks):
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        there = self.read(db, word, len(data) // 2)
        return there if isinstance(there, ErrorNumber) else None


class Swapped(Blocks):
    """Exchanges the bytes of each word it writes."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, b"".join(data[at + 1 : at + 2] + data[at : at + 1] for at in range(0, len(data), 2)))


class OffByOne(Blocks):
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, min(word + 1, 127 - len(data) // 2), data)


class FirstWordOnly(Blocks):
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data[:2])


class LosesLast(Blocks):
    """The last word of a job of more than eight is not written."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data[:-2] if len(data) > 16 else data)


class EvenWords(Blocks):
    """The last one of an odd number of words is not written, unless it is alone."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data[:-2] if len(data) > 2 and len(data) % 4 else data)


class EveryTwelfth(Blocks):
    """Each twelfth write is lost."""

    _count = 0

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        self._count += 1
        return None if self._count % 12 == 0 else super().write(db, word, data)


class Growing(Blocks):
    """Every block there is, zeros where nothing was written."""

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        return super().read(db, word, words) if db in self.content else bytes(2 * words)

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return super().write(db, word, data) if db in self.content else None


class ReadsBeyond(Blocks):
    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        if db in self.content and word < 128 < word + words:
            return (bytes(self.content[db][2 * word :]) + bytes(2 * words))[: 2 * words]
        return super().read(db, word, words)


class WritesToTheEnd(Blocks):
    """The part that fits is written, then the job is refused."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        if db in self.content:
            super().write(db, word, data[: max(0, 2 * (128 - word))])
        return super().write(db, word, data)


class WritesBeyond(Blocks):
    """Words beyond the end are written at the beginning."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        if db in self.content and word + len(data) // 2 > 128:
            return super().write(db, 0, data)
        return super().write(db, word, data)


class WordsForBytes(Areas):
    """Counts words where bytes are meant."""

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        return bytes(2 * amount)

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        return ErrorNumber.TYPE_NOT_SERVED


class AllAreas(Areas):
    """Serves all types."""

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        return bytes(kind.unit * amount)

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        return None


def swap(data: bytes) -> bytes:
    return b"".join(data[at + 1 : at + 2] + data[at : at + 1] for at in range(0, len(data), 2))


class NoMinusOne(Blocks):
    """A word FFFFh is written as 0."""

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        words = (data[at : at + 2] for at in range(0, len(data), 2))
        return super().write(db, word, b"".join(b"\0\0" if pair == b"\xff\xff" else pair for pair in words))
