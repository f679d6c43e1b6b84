"""Rights of a partner: read, write, and where.  Checked after the validation table, on the raw PDU of a legal request (AX-343)."""

from collections.abc import Sequence
from dataclasses import dataclass

from protocols.modbus.view import ExceptionCode

Span = tuple[int, int]  # first and last address
COIL_WRITES, HOLDING_WRITES = (5, 15), (6, 16, 22, 23)
FILE_WRITE = 21


@dataclass(frozen=True, slots=True)
class Rights:
    """None for a table: all of it may be written.  A partner whose writing is limited to addresses writes no files but those named."""

    read: bool = True
    write: bool = True
    coils: tuple[Span, ...] | None = None
    holding: tuple[Span, ...] | None = None
    files: tuple[Span, ...] | None = None  # None: all if coils and holding are None too, else none

    @property
    def limited(self) -> bool:
        """Whether `refusal` must be called at all."""
        return not self.read or (self.write and not (self.coils is None and self.holding is None and self.files is None))

    def refusal(self, pdu: bytes) -> ExceptionCode | None:
        """01 where nothing may be read, 02 for a write to addresses that are not this partner's."""
        function = pdu[0]
        if not self.read and function not in (5, 6, 15, 16, 21, 22):
            return ExceptionCode.ILLEGAL_FUNCTION
        if function in COIL_WRITES:
            first, count = _word(pdu, 1), 1 if function == 5 else _word(pdu, 3)
            return _outside(self.coils, first, count)
        if function in HOLDING_WRITES:
            at = 5 if function == 23 else 1
            count = _word(pdu, at + 2) if function in (16, 23) else 1
            return _outside(self.holding, _word(pdu, at), count)
        return self._files(pdu) if function == FILE_WRITE else None

    def _files(self, pdu: bytes) -> ExceptionCode | None:
        """Every file of the request must be this partner's."""
        spans = () if self.files is None and not (self.coils is None and self.holding is None) else self.files
        at = 2
        while at < len(pdu):
            if _outside(spans, _word(pdu, at + 1), 1) is not None:
                return ExceptionCode.ILLEGAL_DATA_ADDRESS
            at += 7 + 2 * _word(pdu, at + 5)
        return None


def _word(pdu: bytes, at: int) -> int:
    return pdu[at] << 8 | pdu[at + 1]


def _outside(spans: Sequence[Span] | None, first: int, count: int) -> ExceptionCode | None:
    """One span must contain all of it."""
    if spans is None or any(low <= first and first + count - 1 <= high for low, high in spans):
        return None
    return ExceptionCode.ILLEGAL_DATA_ADDRESS
