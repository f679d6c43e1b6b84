"""Data blocks in memory, for tests of the passive RK512 station."""

from protocols.rk512.passive import ErrorNumber


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
