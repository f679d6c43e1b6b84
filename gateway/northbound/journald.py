"""The journal of a run to journald, each record with its fields (systemd's native protocol: datagrams of FIELD=value)."""

import contextlib
import json
import os
import pathlib
import socket
import struct
from collections import deque

from gateway.runtime.journal import JournalReader

SOCKET = "/run/systemd/journal/socket"
PRIORITY = {"alarm": 3, "error": 3, "link": 5, "retain": 4, "process": 5}  # syslog's: 3 error, 4 warning, 5 notice; else 6, information
MOST_RECORD = 100_000  # longer datagrams need a memfd; none of these records is that long


class Journald:
    """Follows one journal file; entries that journald refuses now wait for the next look."""

    def __init__(self, journal: pathlib.Path, slug: str, address: str = SOCKET) -> None:
        self._slug, self._address = slug, address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._reader = JournalReader(journal, 0)  # records of an earlier run were reported then
        self._waiting: deque[bytes] = deque()
        self.sent = 0

    def look(self) -> None:
        """Send new records; never waits."""
        with contextlib.suppress(OSError):
            if self._hand_over():
                self._waiting.extend(self._reader.lines())
                self._hand_over()

    def _hand_over(self) -> bool:
        """True: nothing waits."""
        while self._waiting and self._send(self._waiting[0]):
            self._waiting.popleft()
        return not self._waiting

    def close(self) -> None:
        self._socket.close()
        self._reader.close()

    def _send(self, line: bytes) -> bool:
        try:
            record = json.loads(line)
        except ValueError:
            return True
        if not isinstance(record, dict):
            return True
        try:
            self._socket.sendto(datagram(record, self._slug)[:MOST_RECORD], self._address)
        except (BlockingIOError, FileNotFoundError, ConnectionRefusedError):
            return False
        self.sent += 1
        return True


def datagram(record: dict[str, object], slug: str) -> bytes:
    """One record: MESSAGE, PRIORITY, SYSLOG_IDENTIFIER, AXISGATE_*; values with line ends carry their length (journald's rule)."""
    kind = str(record.get("kind", ""))
    fields = {"MESSAGE": str(record.get("text", "")), "PRIORITY": str(PRIORITY.get(kind, 6)), "SYSLOG_IDENTIFIER": "axisgate"}
    fields["AXISGATE_RUN"] = slug
    fields |= {f"AXISGATE_{name.upper()}": str(value) for name, value in record.items() if name != "text" and name.isidentifier()}
    return b"".join(_field(name, value.encode(errors="replace")) for name, value in fields.items())


def _field(name: str, value: bytes) -> bytes:
    if b"\n" in value:
        return name.encode() + b"\n" + struct.pack("<Q", len(value)) + value + b"\n"
    return name.encode() + b"=" + value + b"\n"


def there(address: str = SOCKET) -> bool:
    """Whether journald listens on this computer."""
    return os.path.exists(address)
