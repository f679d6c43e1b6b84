"""An object dictionary as plain tables: the contents of an EDS or DCF.  Source: CiA 301, 7.4."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum

from protocols.canopen.types import DataType, Kind, Value

Key = tuple[int, int]  # index, sub-index


class Access(Enum):
    """As written in an EDS; rwr and rww: mappable into TPDOs only, into RPDOs only."""

    RO, WO, RW, RWR, RWW, CONST = "ro", "wo", "rw", "rwr", "rww", "const"

    @property
    def readable(self) -> bool:
        return self is not Access.WO

    @property
    def writable(self) -> bool:
        return self not in (Access.RO, Access.CONST)


@dataclass(frozen=True, slots=True)
class Entry:
    """One sub-index.  `default` of a relative entry counts from the node number ($NODEID)."""

    index: int
    sub: int
    name: str
    type: DataType
    access: Access = Access.RW
    default: Value | None = None
    relative: bool = False
    low: int | float | None = None
    high: int | float | None = None
    mappable: bool = False
    parameter: Value | None = None  # ParameterValue of a DCF: the value to download to the device
    parameter_relative: bool = False

    @property
    def key(self) -> Key:
        return self.index, self.sub

    @property
    def receivable(self) -> bool:
        """May be mapped in an RPDO."""
        return self.mappable and self.access in (Access.RW, Access.RWW, Access.WO)

    @property
    def transmittable(self) -> bool:
        """May be mapped in a TPDO."""
        return self.mappable and self.access in (Access.RO, Access.RW, Access.RWR, Access.CONST)

    def default_of(self, node: int) -> Value:
        """The power-on value; zero or empty where the file names none."""
        return self.type.zero if self.default is None else _moved(self.default, self.relative, node)

    def parameter_of(self, node: int) -> Value | None:
        """The value that a DCF sets, if it names one."""
        return None if self.parameter is None else _moved(self.parameter, self.parameter_relative, node)

    def __str__(self) -> str:
        return f"{self.index:04X}h:{self.sub:02X} {self.name}"


def _moved(value: Value, relative: bool, node: int) -> Value:
    return value + node if relative and isinstance(value, int) else value


class Shape(Enum):
    """Object codes (CiA 301, table 42)."""

    DOMAIN, DEFTYPE, DEFSTRUCT, VAR, ARRAY, RECORD = 2, 5, 6, 7, 8, 9


@dataclass(frozen=True, slots=True)
class Head:
    """A complete object."""

    index: int
    name: str
    shape: Shape


@dataclass(frozen=True, slots=True)
class ObjectDictionary:
    """`entries` by (index, sub-index), `heads` by index; `device` the file's [DeviceInfo] with lower-case keys, as text."""

    entries: Mapping[Key, Entry]
    heads: Mapping[int, Head]
    device: Mapping[str, str] = field(default_factory=dict)
    dummies: frozenset[int] = frozenset()  # types allowed in an RPDO as filler
    node: int | None = None  # [DeviceComissioning] of a DCF
    bit_rate: int | None = None  # bit/s, of a DCF
    _by_index: dict[int, list[Entry]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for key in sorted(self.entries):
            self._by_index.setdefault(key[0], []).append(self.entries[key])

    def entry(self, index: int, sub: int = 0) -> Entry | None:
        return self.entries.get((index, sub))

    def subs(self, index: int) -> list[Entry]:
        """All entries of an object, by sub-index."""
        return self._by_index.get(index, [])[:]

    def named(self, name: str) -> Entry | None:
        """By the name of a variable or "Object.Sub"; case does not matter."""
        wanted = name.casefold()
        for entry in self.entries.values():
            head = self.heads[entry.index]
            own = head.name if head.shape not in (Shape.ARRAY, Shape.RECORD) else f"{head.name}.{entry.name}"
            if own.casefold() == wanted:
                return entry
        return None

    def __iter__(self) -> Iterator[Entry]:
        return iter(sorted(self.entries.values(), key=lambda entry: entry.key))


def fits(entry: Entry, value: Value) -> int:
    """0 when the value is inside the entry's limits, +1 above, -1 below."""
    if not isinstance(value, int | float) or entry.type.kind is Kind.BOOLEAN:
        return 0
    if entry.high is not None and value > entry.high:
        return 1
    return -1 if entry.low is not None and value < entry.low else 0
