"""Source of a Modbus server's answers: four tables with one interface, independent of the owner.

Addresses are protocol addresses, base 0: register "40001" of a manual is holding register 0 here.
"""

from collections.abc import Sequence
from enum import Enum, IntEnum, auto
from typing import Protocol, runtime_checkable


class Kind(Enum):
    """The four tables of V1.1b3, section 4.3; coils and holding registers may be written."""

    COILS = auto()
    DISCRETE_INPUTS = auto()
    HOLDING_REGISTERS = auto()
    INPUT_REGISTERS = auto()


class ExceptionCode(IntEnum):
    """Why a request was not done: the second byte of an exception answer (V1.1b3, section 7)."""

    ILLEGAL_FUNCTION = 0x01
    ILLEGAL_DATA_ADDRESS = 0x02
    ILLEGAL_DATA_VALUE = 0x03
    SERVER_DEVICE_FAILURE = 0x04
    ACKNOWLEDGE = 0x05
    SERVER_DEVICE_BUSY = 0x06
    MEMORY_PARITY_ERROR = 0x08
    GATEWAY_PATH_UNAVAILABLE = 0x0A
    GATEWAY_TARGET_SILENT = 0x0B


class View(Protocol):
    """One unit's tables.  Each request is exactly one call, so a view reads or writes all of it at one moment.

    address 0..65535 and count >= 1 are checked before the call, address + count never exceeds 65536; the view decides whether the range
    exists (ILLEGAL_DATA_ADDRESS; a partly missing range is missing, and nothing of it may be written). A read returns exactly `count`
    values, words 0..65535; anything else is answered with SERVER_DEVICE_FAILURE.
    """

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode: ...  # COILS, DISCRETE_INPUTS
    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode: ...  # HOLDING_, INPUT_REGISTERS
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None: ...  # coils; None: done, all of it
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None: ...  # holding registers; None: done


# Optional functions of a unit besides its four tables; a view without the method answers 01 to the function (AX-342).


@runtime_checkable
class HasStatus(Protocol):
    """FC 7."""

    def exception_status(self) -> int: ...  # 0..255


@runtime_checkable
class HasFiles(Protocol):
    """FC 20 and 21; record numbers and counts are checked before, file numbers are 1..65535."""

    def read_record(self, file: int, record: int, count: int) -> Sequence[int] | ExceptionCode: ...
    def refuses_record(self, file: int, record: int, count: int) -> ExceptionCode | None: ...  # None: it may be written
    def write_record(self, file: int, record: int, values: Sequence[int]) -> ExceptionCode | None: ...


@runtime_checkable
class HasQueue(Protocol):
    """FC 24."""

    def read_queue(self, address: int) -> Sequence[int] | ExceptionCode: ...  # more than 31 are answered with 03


def home_unit(unit: int, own: int) -> int:
    """The unit a request on TCP means: 0 and 255 address the server itself (TCP guide, 4.4.2.3; AX-012)."""
    return own if unit in (0, 255) else unit
