"""The one list of errors: the first error is shown first (first-out), repeats are counted, the list never grows beyond its bound.

An error leaves the list only after its cause is gone and a user with sufficient rights acknowledged it (rho3 9.1: L3033, L3059, L4066).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

from protocols.base.machine import Ns

CAPACITY = 64  # runtime errors the rho 3 keeps (rho3 3.3, L3035)


class Reset(IntEnum):
    """What clears an error whose cause is gone; a higher one clears the lower ones too."""

    ITSELF = 0  # gone with its cause
    ACKNOWLEDGE = 1  # rising edge of error acknowledgement (bit 62)
    CONTROL_RESET = 2  # control reset (bit 19): emergency stop, drive faults
    RESTART = 3  # system errors


@dataclass(frozen=True, slots=True)
class ErrorRecord:
    """One error in one place."""

    code: int  # the manual's number, or ours (AX)
    source: str  # who numbered it: "rho3", "axisgate", "drive"
    where: str  # axis, line or file:key
    text_id: str  # key of the texts in German and English
    first_ns: Ns
    last_ns: Ns
    count: int = 1
    reset: Reset = Reset.ACKNOWLEDGE
    active: bool = True  # the cause is still there


class ErrorList:
    """All errors since the list was last empty."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._capacity = capacity
        self._records: dict[tuple[int, str, str], ErrorRecord] = {}
        self.lost = 0  # errors that found the list full

    @property
    def records(self) -> Sequence[ErrorRecord]:
        """In the order they came."""
        return tuple(self._records.values())

    @property
    def first(self) -> ErrorRecord | None:
        """The error that came first: the one to look at."""
        return next(iter(self._records.values()), None)

    def report(self, code: int, where: str, now: Ns, text_id: str = "", source: str = "axisgate", reset: Reset = Reset.ACKNOWLEDGE) -> bool:
        """An error happened; True when it is new to the list, False when it was counted on or found the list full."""
        key = (code, source, where)
        known = self._records.get(key)
        if known is not None:
            self._records[key] = replace(known, last_ns=now, count=known.count + 1, active=True)
            return False
        if len(self._records) >= self._capacity:
            self.lost += 1  # the first ones stay: they show how it began
            return False
        self._records[key] = ErrorRecord(code, source, where, text_id or f"{source}.{code}", now, now, reset=reset)
        return True

    def gone(self, code: int, where: str, source: str = "axisgate") -> None:
        """The cause is away; errors that clear themselves leave the list."""
        key = (code, source, where)
        known = self._records.get(key)
        if known is None:
            return
        if known.reset is Reset.ITSELF:
            del self._records[key]
        else:
            self._records[key] = replace(known, active=False)

    def drop(self, code: int, where: str, source: str = "axisgate") -> None:
        """It leaves the list whatever its rule: its owner knows that it is over."""
        self._records.pop((code, source, where), None)

    def acknowledge(self, right: Reset) -> int:
        """Clear the errors that this right may clear and whose cause is gone; return their number."""
        kept = {key: record for key, record in self._records.items() if record.active or record.reset > right}
        cleared = len(self._records) - len(kept)
        self._records = kept
        if not kept:
            self.lost = 0
        return cleared
