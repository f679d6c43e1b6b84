"""Raw blocks as plain tables: blocks to recognise and read, blocks to build.  Source: users.md 3.5, `[[telegram]]`."""

from dataclasses import dataclass

from protocols.telegrams.fields import Field, Value

MAX_BLOCK = 138  # bytes of a block, a doubled DLE counted once (rho 3 Releases part 1, 7.1); other stations have limits of their own


@dataclass(frozen=True, slots=True)
class Match:
    """The block has these bytes at `byte`."""

    byte: int
    data: bytes

    @property
    def end(self) -> int:
        return self.byte + len(self.data)


@dataclass(frozen=True, slots=True)
class Incoming:
    """A block from the partner: recognised by `matches` (and its length, if set), read field by field, then `signal` is raised."""

    name: str
    matches: tuple[Match, ...]
    fields: tuple[Field, ...] = ()
    length: int | None = None  # None: any length that holds matches and fields
    signal: str = ""
    most: int = MAX_BLOCK  # bytes a block of this line may have

    @property
    def needed(self) -> int:
        """Least length in bytes."""
        return max([0, *(match.end for match in self.matches), *(field.end for field in self.fields)])

    def recognises(self, data: bytes) -> bool:
        """All match bytes agree; the length is judged separately."""
        return all(data[match.byte : match.end] == match.data for match in self.matches)

    def fits(self, data: bytes) -> bool:
        """The length is right."""
        return len(data) >= self.needed if self.length is None else len(data) == self.length


@dataclass(frozen=True, slots=True)
class Outgoing:
    """A block to send: fixed bytes and values in sequence (a Field's `byte` is its place)."""

    name: str
    parts: tuple[bytes | Field, ...]
    most: int = MAX_BLOCK  # bytes a block of this line may have

    @property
    def length(self) -> int:
        return sum(len(part) if isinstance(part, bytes) else part.size for part in self.parts)


@dataclass(frozen=True, slots=True)
class Received:
    """A block was recognised and read completely."""

    name: str
    values: tuple[tuple[str, Value], ...]
    signal: str = ""


@dataclass(frozen=True, slots=True)
class Refused:
    """A block was recognised, but contains a fault: none of its values is used."""

    name: str
    why: str


@dataclass(frozen=True, slots=True)
class Unknown:
    """No telegram has these bytes."""

    data: bytes


Event = Received | Refused | Unknown
