"""Faults of the I/O blocks and parameter downloads of a cycle as passed to the services: a table of fixed size.

One entry for each trouble of each block and for each module whose parameters were not taken; it stays, and counts.  An error that was
there for one cycle only is seen by its count.  Numbers and texts: gateway.pure.controllers.rho3.can.messages,
drivers.drives.servodyn_download.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass

from drivers.drives.servodyn_download import Cause, DownloadError, download_error
from gateway.pure.controllers.rho3.can.messages import FIRST_NUMBER, IoError, Trouble

_ENTRY = struct.Struct("<7B")  # kind, bus, block or module, standing, count, cause and number of a parameter
MOST = 92  # two buses with four troubles of ten blocks, and two times six modules
LEDGER_BYTES = MOST * _ENTRY.size
LEDGER_LAYOUT = f"io_errors/1 {MOST} entries of kind, bus, place, standing, count, cause, parameter"
_TROUBLES = tuple(Trouble)
_DOWNLOAD = len(_TROUBLES) + 1


@dataclass(frozen=True, slots=True)
class Complaint:
    """One entry as a person reads it."""

    number: int  # 380, 381, 645, 650; 0: no manual has one
    where: str  # as the pendant shows it, or the module
    en: str
    de: str
    active: bool
    count: int  # of times it came, modulo 256

    def words(self, language: str) -> str:
        """ "no transm. CAN1 I2: no data from ..." in `language` (de | en)."""
        return f"{self.where}: {self.de if language == 'de' else self.en}"


class Ledger:
    """The cycle's side, one for all its buses; `changed` until the next `pack`."""

    def __init__(self) -> None:
        self._entries: dict[tuple[int, int, int], list[int]] = {}  # kind, bus, place -> standing, count, cause, parameter
        self.changed = True  # an empty table is written, too: it ends what a predecessor left

    def note(self, errors: Iterable[IoError]) -> None:
        """Errors that came or went."""
        for error in errors:
            self._enter((_TROUBLES.index(error.trouble) + 1, error.bus, error.block), active=error.active)

    def refused(self, bus: int, module: int, error: DownloadError) -> None:
        """A module refused its parameters; kept until the next start."""
        self._enter((_DOWNLOAD, bus, module), active=True, cause=error.cause, parameter=error.parameter)

    def _enter(self, key: tuple[int, int, int], *, active: bool, cause: int = 0, parameter: int = 0) -> None:
        before = self._entries.get(key)
        count = (before[1] if before else 0) + active & 0xFF
        if before is not None or len(self._entries) < MOST:
            self._entries[key] = [active, count, cause, parameter & 0xFF]
            self.changed = True

    def pack(self) -> bytes:
        """All entries."""
        self.changed = False
        return b"".join(_ENTRY.pack(*key, *entry) for key, entry in self._entries.items()).ljust(LEDGER_BYTES, b"\0")


def unpack_ledger(payload: bytes) -> list[Complaint]:
    """The services' side, in the order they first came."""
    rows = (row for row in _ENTRY.iter_unpack(payload[:LEDGER_BYTES]) if row[0])
    return [_complaint(kind, bus, place, bool(active), count, cause, number) for kind, bus, place, active, count, cause, number in rows]


def _complaint(kind: int, bus: int, place: int, active: bool, count: int, cause: int, parameter: int) -> Complaint:
    if kind == _DOWNLOAD:
        error = download_error(Cause(cause), parameter)
        return Complaint(error.number, f"CAN{bus} module {place}", error.english, error.german, active, count)
    found = IoError(_TROUBLES[kind - 1], bus, place)
    en, de = (found.trouble.words(bus, place, language) for language in ("en", "de"))
    return Complaint(found.number or FIRST_NUMBER + bus - 1, found.text, en, de, active, count)  # AX-431
