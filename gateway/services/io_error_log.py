"""Errors of I/O blocks and parameter downloads as the services see them: in the cell's errors while pending, in the list of errors
until they are acknowledged, in the journal when they come and go (AX-431).
"""

from collections.abc import Mapping

from gateway.pure.controllers.rho3.can.ledger import LEDGER_LAYOUT, Complaint, unpack_ledger
from gateway.pure.image.reasons import Reason, text
from gateway.runtime.journal import Journal
from gateway.runtime.regions import RegionReader
from gateway.services.controller_host import ControllerHost
from protocols.base.machine import Ns

Error = tuple[int, str]


class IoComplaints:
    """`look` once per cycle of the services; nothing in a cell without P30."""

    def __init__(self, fds: Mapping[str, int], journal: Journal, language: str) -> None:
        self._region = RegionReader(fds["io_errors"], "io_errors", LEDGER_LAYOUT) if "io_errors" in fds else None
        self._journal, self._language = journal, language
        self._payload = b""
        self._known: dict[str, Complaint] = {}

    def look(self, host: ControllerHost, now: Ns) -> list[Error]:
        """Pending errors, number and sentence; changes since the last look go to list and journal."""
        if self._region is None:
            return []
        payload = self._region.read()
        if payload is not None and payload != self._payload:
            self._payload = payload
            self._learn({each.where: each for each in unpack_ledger(payload)}, host, now)
        return [_error(each, self._language) for each in self._known.values() if each.active]

    def _learn(self, complaints: dict[str, Complaint], host: ControllerHost, now: Ns) -> None:
        """An error may have come and gone between two looks: then its count is another one."""
        for where, each in complaints.items():
            before = self._known.get(where)
            if before is None or before.count != each.count:
                host.came(each.number, where, now)
                self._report(each, "")
            if not each.active and (before is None or before.active or before.count != each.count):
                host.gone(each.number, where)
                self._report(each, ": recovered")
        for where in self._known.keys() - complaints.keys():  # another cycle, which knows nothing of it
            host.gone(self._known[where].number, where)
        self._known = complaints

    def _report(self, each: Complaint, end: str) -> None:
        code, words = _error(each, self._language)
        self._journal.write("error", f"{code} {words}{end}", code=code, where=each.where)


def _error(each: Complaint, language: str) -> Error:
    """Where no manual has a number: 32, the drive is not started up."""
    words = each.words(language)
    return (each.number, words) if each.number else (Reason.DRIVE_NOT_STARTED, text(Reason.DRIVE_NOT_STARTED, language, words))
