"""What a station of the soak keeps: words others write, and words they read, of every type."""

from random import Random

from protocols.rk512.header import ErrorNumber, Kind

BYTES = 1200


def payload(form: int, size: int, chance: Random) -> bytes:
    """0 zero-rich, 1 random, 2 all 10h."""
    if form == 0:
        return bytes(chance.randrange(256) if chance.random() < 0.25 else 0 for _ in range(size))
    return chance.randbytes(size) if form == 1 else b"\x10" * size


class Store:
    """DB 10 and DX 10 take what comes; DB 11, DX 11 and the areas give what was filled in."""

    def __init__(self, chance: Random) -> None:
        self.taken = {kind: bytearray(BYTES) for kind in (Kind.BLOCK, Kind.EXTENDED)}
        self.given = {kind: payload(1, BYTES, chance) for kind in Kind}

    def fill(self, kind: Kind, form: int, chance: Random) -> None:
        """New content to fetch, before a job."""
        self.given[kind] = payload(form, BYTES, chance)

    def spoil(self, data: bytes) -> None:
        """Nothing that is there is what the next job writes."""
        wrong = bytes(~byte & 0xFF for byte in (data * (BYTES // len(data) + 1))[:BYTES])
        for kind in self.taken:
            self.taken[kind][:] = wrong

    def given_at(self, kind: Kind, place: int, size: int) -> bytes:
        at = place * kind.unit
        return self.given[kind][at : at + size]

    def taken_at(self, kind: Kind, place: int, size: int) -> bytes:
        at = place * kind.unit
        return bytes(self.taken[kind][at : at + size])

    # ---- what RK512 asks for
    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        return self.read_area(Kind.BLOCK, db, word, words)

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        return self.write_area(Kind.BLOCK, db, word, data)

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        size = amount * kind.unit
        source = bytes(self.taken[kind]) if kind.in_blocks and block == 10 else self.given[kind] if block == 11 * kind.in_blocks else b""
        at = address * kind.unit
        return source[at : at + size] if at + size <= len(source) else ErrorNumber.BLOCK

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        at = address * kind.unit
        if kind not in self.taken or block != 10 or at + len(data) > BYTES:
            return ErrorNumber.BLOCK
        self.taken[kind][at : at + len(data)] = data
        return None
