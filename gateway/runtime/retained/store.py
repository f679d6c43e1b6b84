"""The file of retained data: SQLite (WAL, synchronous FULL), one transaction a write: after any death it holds the old or the new state.

Two tables: `value` (group.name -> the last value) and `history` (kind, JSON record; the newest of each kind are kept).  Every row
carries a CRC: a corrupted page that SQLite itself does not detect is named and left out (AX-424).
"""

import json
import pathlib
import sqlite3
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from gateway.runtime.clock import wall

Value = int | float | str | bytes
Record = dict[str, object]

APPLICATION, FORMAT = 0x41784772, 1  # "AxGr": whose file it is; the shape of its tables
BUSY_S = 2.0  # patience with a tool that writes at the same moment
HISTORY = 1000  # records kept of each kind but these:
FOR_GOOD = ("zero", "configuration")
TABLES = """
CREATE TABLE value (name TEXT PRIMARY KEY, data NOT NULL, crc INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE history (id INTEGER PRIMARY KEY AUTOINCREMENT, kind TEXT NOT NULL, data TEXT NOT NULL, crc INTEGER NOT NULL);
CREATE INDEX history_kind ON history (kind, id);
"""


class RetainError(OSError):
    """The file cannot be read or written; the message names it."""


@dataclass(frozen=True, slots=True)
class Opened:
    """A file that is ready, and messages from opening it."""

    file: "RetainFile"
    events: tuple[str, ...]


class RetainFile:
    """One open file.  Used by one thread; other processes may have it open at the same time."""

    def __init__(self, path: pathlib.Path, connection: sqlite3.Connection) -> None:
        self.path, self._connection = path, connection

    def values(self) -> tuple[dict[str, Value], list[str]]:
        """All values, and the names of corrupted rows.  RetainError."""
        rows = self._rows("SELECT name, data, crc FROM value")
        good = {str(name): data for name, data, crc in rows if crc == _crc(str(name), data)}
        return good, [str(name) for name, _, _ in rows if str(name) not in good]

    def history(self, kind: str) -> list[Record]:
        """Records of a kind, oldest first; corrupted ones are left out.  RetainError."""
        rows = self._rows("SELECT data, crc FROM history WHERE kind = ? ORDER BY id", kind)
        return [json.loads(str(data)) for data, crc in rows if crc == _crc(kind, data)]

    def kinds(self) -> list[str]:
        """Kinds of which there are records.  RetainError."""
        return [str(row[0]) for row in self._rows("SELECT DISTINCT kind FROM history ORDER BY kind")]

    def write(self, values: Mapping[str, Value], records: Iterable[tuple[str, Record]] = (), *, drop: Iterable[str] = ()) -> None:
        """All of it or nothing; on return it has reached the disk.  RetainError: nothing was written."""
        added = [(kind, json.dumps(record, ensure_ascii=False, default=str)) for kind, record in records]
        try:
            with self._connection as transaction:
                transaction.execute("BEGIN IMMEDIATE")
                transaction.executemany("DELETE FROM value WHERE name = ?", [(name,) for name in drop])
                transaction.executemany("REPLACE INTO value VALUES (?, ?, ?)", [(n, v, _crc(n, v)) for n, v in values.items()])
                transaction.executemany(
                    "INSERT INTO history (kind, data, crc) VALUES (?, ?, ?)", [(k, text, _crc(k, text)) for k, text in added]
                )
                for kind in {kind for kind, _ in added if kind not in FOR_GOOD}:
                    transaction.execute(
                        "DELETE FROM history WHERE kind = ?1 AND id <= "
                        "(SELECT id FROM history WHERE kind = ?1 ORDER BY id DESC LIMIT 1 OFFSET ?2)",
                        (kind, HISTORY),
                    )
        except (sqlite3.Error, OverflowError) as error:
            raise RetainError(f"{self.path}: cannot be written: {error}") from error

    def close(self) -> None:
        """Closes it; the write-ahead log goes into the file."""
        self._connection.close()

    def _rows(self, statement: str, *parameters: str) -> list[tuple[Value, ...]]:
        try:
            return self._connection.execute(statement, parameters).fetchall()
        except sqlite3.Error as error:
            raise RetainError(f"{self.path}: cannot be read: {error}") from error


def open_file(path: pathlib.Path, *, repair: bool = True) -> Opened:
    """The file, made where it is missing; a damaged one is set aside, and its new name reported.

    RetainError: it cannot be opened; without `repair` also when it is damaged.
    """
    try:
        path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
        return Opened(_sound(path), ())
    except sqlite3.OperationalError as error:  # not the file's fault: permission, disk, lock
        raise RetainError(f"{path}: cannot be opened: {error}") from error
    except sqlite3.DatabaseError as error:
        if not repair:
            raise RetainError(f"{path}: damaged ({error}); the next start of the cell sets it aside and reports it") from error
        aside = set_aside(path)
        message = f"retained data: {path} is damaged ({error}); set aside as {aside.name}, started with defaults"
        try:
            return Opened(_sound(path), (message,))
        except sqlite3.Error as again:
            raise RetainError(f"{path}: cannot be created again: {again}") from again
    except OSError as error:
        raise RetainError(f"{path}: {error.strerror}") from error


def set_aside(path: pathlib.Path) -> pathlib.Path:
    """Renames the file with its log, so that it can be examined; returns the new name."""
    mark = wall().replace(":", "").replace(" ", "T")[:19]
    number = next(n for n in range(1, 10_000) if not path.with_name(f"{path.name}.damaged-{mark}-{n}").exists())
    aside = path.with_name(f"{path.name}.damaged-{mark}-{number}")
    path.rename(aside)
    log, shared = path.with_name(path.name + "-wal"), path.with_name(path.name + "-shm")
    if log.exists():
        log.rename(aside.with_name(aside.name + "-wal"))
    shared.unlink(missing_ok=True)
    return aside


def _sound(path: pathlib.Path) -> RetainFile:
    connection = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
    try:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        with connection:
            connection.execute("BEGIN IMMEDIATE")
            if connection.execute("SELECT count(*) FROM sqlite_schema").fetchone()[0] == 0:
                for statement in TABLES.split(";\n"):
                    connection.execute(statement)
                connection.execute(f"PRAGMA application_id = {APPLICATION}")
                connection.execute(f"PRAGMA user_version = {FORMAT}")
        _judge(connection)
    except BaseException:
        connection.close()
        raise
    return RetainFile(path, connection)


def _judge(connection: sqlite3.Connection) -> None:
    owner = connection.execute("PRAGMA application_id").fetchone()[0]
    shape = connection.execute("PRAGMA user_version").fetchone()[0]
    if (owner, shape) != (APPLICATION, FORMAT):
        raise sqlite3.DatabaseError(f"application id {owner:#x}, format {shape}; {APPLICATION:#x}, format {FORMAT} expected")
    found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise sqlite3.DatabaseError(str(found))


def _crc(name: str, data: Value) -> int:
    body = data if isinstance(data, bytes) else f"{type(data).__name__}:{data!r}".encode()
    return zlib.crc32(name.encode() + b"\0" + body)
