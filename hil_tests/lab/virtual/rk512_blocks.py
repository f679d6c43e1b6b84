"""Data blocks and areas in memory, for tests of the passive RK512 station."""

from protocols.rk512.header import ErrorNumber, Kind


class Blocks:
    """DB number -> its bytes; `locked` blocks may be read only."""

    def __init__(self, sizes: dict[int, int], locked: tuple[int, ...] = ()) -> None:
        self.blocks = {number: bytearray(2 * words) for number, words in sizes.items()}
        self.locked = locked

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        block = self.blocks.get(db, bytearray())
        if 2 * (word + words) > len(block):
            return ErrorNumber.BLOCK
        return bytes(block[2 * word : 2 * (word + words)])

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        block = self.blocks.get(db, bytearray())
        if 2 * word + len(data) > len(block):
            return ErrorNumber.BLOCK
        if db in self.locked:
            return ErrorNumber.NOT_ALLOWED
        block[2 * word : 2 * word + len(data)] = data
        return None


class Areas:
    """Every other area, unlimited: the value of a byte gives its address; what is written is kept as a list."""

    def __init__(self) -> None:
        self.written: list[tuple[Kind, int, int, bytes]] = []
        self.refuse: ErrorNumber | None = None

    @staticmethod
    def content(kind: int, block: int, address: int, size: int) -> bytes:
        return bytes((kind + 3 * block + 5 * address + at) % 256 for at in range(size))

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        return self.refuse or self.content(kind, block, address, amount * kind.unit)

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        if self.refuse is None:
            self.written.append((kind, block, address, data))
        return self.refuse
