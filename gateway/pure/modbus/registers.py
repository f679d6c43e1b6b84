"""Values of the cell in additional registers: [[modbus.registers]], readable as holding and as input registers (AX-347)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gateway.pure.controllers.rho3.pendant.catalogue import PREFIX, register_type
from protocols.base.errors import EncodeError
from protocols.modbus.numbers import encode_number, words_of
from protocols.modbus.view import ExceptionCode, Kind

MEASURED = ("actual", "set", "lag", "speed", "torque")  # of an axis; also cell.override: numbers with a fraction
MISSING = ExceptionCode.ILLEGAL_DATA_ADDRESS


@dataclass(frozen=True, slots=True)
class Placed:
    """One value from register `at` on."""

    at: int
    name: str
    type: str

    @property
    def words(self) -> int:
        return words_of(self.type)


def type_of(name: str) -> str:
    """Return REAL for a measured value, else one register; variables of the PHG by their base type."""
    if name.startswith(PREFIX):
        return register_type(name)
    return "REAL" if name.rpartition(".")[2] in MEASURED or name.endswith(".override") else "UINT16"


def place(at: int, name: str, type_: str, axes: Sequence[str]) -> list[Placed]:
    """Place a name.  `axis.*.actual` is every axis, consecutive in the order of the cell; flags of `axis.*` are one value, all of them."""
    kind = type_ or type_of(name)
    if name.startswith("axis.*.") and name.rpartition(".")[2] in MEASURED:
        names = [name.replace("*", axis, 1) for axis in axes]
        return [Placed(at + n * words_of(kind), each, kind) for n, each in enumerate(names)]
    return [Placed(at, name, kind)]


class Registers:
    """Answers reads from the values as they are; a value that does not fit its type is a failure (04), never a wrong number."""

    def __init__(self, placed: Sequence[Placed], value: Callable[[str], float], order: str = "ABCD") -> None:
        self._value, self._order = value, order
        self._at = {each.at + n: (each, n) for each in placed for n in range(each.words)}

    def __contains__(self, address: int) -> bool:
        return address in self._at

    def read(self, address: int, count: int) -> Sequence[int] | ExceptionCode:
        """Registers next to one another; a gap between two values is a missing address."""
        words: list[int] = []
        shown: dict[str, tuple[int, ...]] = {}
        for register in range(address, address + count):
            found = self._at.get(register)
            if found is None:
                return MISSING
            placed, n = found
            try:
                number = shown.get(placed.name) or encode_number(self._value(placed.name), placed.type, self._order)
            except (EncodeError, KeyError):
                return ExceptionCode.SERVER_DEVICE_FAILURE
            shown[placed.name] = number
            words.append(number[n])
        return words


class RegistersView:
    """A unit that shows nothing but these registers."""

    def __init__(self, registers: Registers) -> None:
        self._registers = registers

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        return MISSING

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return self._registers.read(address, count)

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return MISSING

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return MISSING
