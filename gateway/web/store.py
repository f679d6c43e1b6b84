"""Users, sessions, tokens and the audit, in one SQLite file; secrets are stored only as argon2 or SHA-256 hashes.

The audit is a chain: each entry's hash covers the entry before it, so a changed or missing entry is found by `verify` (AX-474).  If the
disk refuses writes, operator commands are carried out and their entries wait; everything else is refused with a reason (AX-823).
"""

import contextlib
import hashlib
import json
import pathlib
import secrets
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from argon2 import PasswordHasher
from argon2.exceptions import Argon2Error, InvalidHashError

from gateway.runtime.clock import wall

SHORTEST = 10  # characters of a password
SESSION_S = 12 * 3600
MOST_KEPT = 100  # watch lists, and layouts
MOST_WAITING = 1000  # entries of the audit that the disk has not accepted yet
BEGIN = "0" * 64  # predecessor of the first entry of the audit
SCHEMA = """
create table if not exists user (name text primary key, role integer not null, hash text not null);
create table if not exists session (id text primary key, name text not null, csrf text not null, until real not null);
create table if not exists token (id text primary key, label text not null unique, role integer not null, made text not null);
create table if not exists audit (number integer primary key, wall text not null, who text not null, source text not null,
                                  what text not null, detail text not null, hash text not null);
create table if not exists kept (kind text not null, name text not null, value text not null, primary key (kind, name));
"""


class Role(IntEnum):
    """Permissions; each role includes those below it."""

    NOBODY = 0
    VIEWER = 1
    OPERATOR = 2
    SETTER = 3
    ADMIN = 4


class StoreError(ValueError):
    """Reason why something cannot be stored, in a sentence."""


@dataclass(frozen=True, slots=True)
class Session:
    """One login; `csrf` goes with every change made through it."""

    id: str
    name: str
    role: Role
    csrf: str


class Store:
    """One file; safe to use from several threads."""

    def __init__(self, path: pathlib.Path, report: Callable[[str], None] = lambda words: None) -> None:
        """`report` gets a sentence when the disk begins to refuse writes, and one when that is over.  sqlite3.Error, OSError."""
        self._report = report
        self._waiting: deque[tuple[str, str, str, str, str]] = deque()
        self._lost = 0  # entries beyond those that may wait
        self._full = False
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.path = path
        self._lock = threading.Lock()
        self._db = sqlite3.connect(path, check_same_thread=False, isolation_level=None)
        path.chmod(0o600)
        self._db.executescript("pragma journal_mode=wal; pragma synchronous=normal;" + SCHEMA)
        self._hasher = PasswordHasher(time_cost=2, memory_cost=19456, parallelism=1)  # OWASP's least: small gateways have to bear it
        self._nobody = self._hasher.hash(secrets.token_urlsafe(16))  # an unknown name's password is compared with it

    def close(self) -> None:
        self._db.close()

    # ---- users ---------------------------------------------------------------------------------------------------------
    @property
    def fresh(self) -> bool:
        """No password is set yet."""
        return not self._rows("select 1 from user limit 1")

    def users(self) -> list[tuple[str, Role]]:
        """Names and roles."""
        return [(str(name), Role(int(str(role)))) for name, role in self._rows("select name, role from user order by name")]

    def put_user(self, name: str, role: Role, password: str) -> None:
        """New, or with a new password and role: its sessions end.  StoreError: a weak password, or no administrator left."""
        if len(password) < SHORTEST:
            raise StoreError(f"a password has {SHORTEST} characters or more")
        if password.lower() == name.lower():
            raise StoreError("a password is not the name")
        self._keep_an_admin(name, role)
        hashed = self._hasher.hash(password)
        self._do("insert or replace into user values (?, ?, ?)", name, int(role), hashed)
        self._do("delete from session where name = ?", name)

    def drop_user(self, name: str) -> bool:
        """Gone with its sessions; False: there was none."""
        self._keep_an_admin(name, Role.NOBODY)
        self._do("delete from session where name = ?", name)
        return bool(self._do("delete from user where name = ?", name))

    def _keep_an_admin(self, name: str, role: Role) -> None:
        admins = [each for each, its in self.users() if its is Role.ADMIN]
        if admins == [name] and role is not Role.ADMIN:
            raise StoreError(f"{name} is the only administrator")

    def right(self, name: str, password: str) -> bool:
        """Whether this is the user's password; an unknown name takes as long as a wrong password."""
        rows = self._rows("select hash from user where name = ?", name)
        try:
            self._hasher.verify(str(rows[0][0]) if rows else self._nobody, password)
        except (Argon2Error, InvalidHashError):
            return False
        return bool(rows)

    # ---- sessions and tokens --------------------------------------------------------------------------------------------
    def open_session(self, name: str) -> Session:
        """After a right password."""
        secret, csrf = secrets.token_urlsafe(32), secrets.token_urlsafe(24)
        self._do("delete from session where until < ?", time.time())
        self._do("insert into session values (?, ?, ?, ?)", _hashed(secret), name, csrf, time.time() + SESSION_S)
        return Session(secret, name, self.role_of(name), csrf)

    def session(self, secret: str) -> Session | None:
        """The login a cookie belongs to; None: unknown or over."""
        rows = self._rows("select name, csrf from session where id = ? and until > ?", _hashed(secret), time.time())
        if not rows:
            return None
        name = str(rows[0][0])
        role = self.role_of(name)
        return Session(secret, name, role, str(rows[0][1])) if role else None

    def close_session(self, secret: str) -> None:
        self._do("delete from session where id = ?", _hashed(secret))

    def role_of(self, name: str) -> Role:
        rows = self._rows("select role from user where name = ?", name)
        return Role(int(str(rows[0][0]))) if rows else Role.NOBODY

    def put_token(self, label: str, role: Role) -> str:
        """A secret for a script, shown once.  StoreError: the label is in use."""
        secret = "axg_" + secrets.token_urlsafe(32)
        try:
            self._do("insert into token values (?, ?, ?, ?)", _hashed(secret), label, int(role), wall())
        except sqlite3.IntegrityError:
            raise StoreError(f"a token {label!r} exists already") from None
        return secret

    def token(self, secret: str) -> tuple[str, Role] | None:
        """Label and role of a token."""
        rows = self._rows("select label, role from token where id = ?", _hashed(secret))
        return (str(rows[0][0]), Role(int(str(rows[0][1])))) if rows else None

    def tokens(self) -> list[tuple[str, Role, str]]:
        """Labels, roles, since when."""
        rows = self._rows("select label, role, made from token order by label")
        return [(str(label), Role(int(str(role))), str(made)) for label, role, made in rows]

    def drop_token(self, label: str) -> bool:
        return bool(self._do("delete from token where label = ?", label))

    # ---- watch lists and layouts ------------------------------------------------------------------------------------------
    def kept(self, kind: str) -> list[dict[str, object]]:
        """Names and data written by the page, by name."""
        rows = self._rows("select name, value from kept where kind = ? order by name collate nocase", kind)
        return [{"name": name, "value": value} for name, value in rows]

    def keep(self, kind: str, name: str, value: str) -> None:
        """Under a name; an older one of the same name is replaced.  StoreError: no JSON, or too many."""
        try:
            json.loads(value)
        except (ValueError, RecursionError):
            raise StoreError("only JSON can be stored") from None
        names = {row["name"] for row in self.kept(kind)}
        if name not in names and len(names) >= MOST_KEPT:
            raise StoreError(f"{MOST_KEPT} are kept; remove one first")
        self._do("insert or replace into kept values (?, ?, ?)", kind, name, value)

    def drop_kept(self, kind: str, name: str) -> bool:
        """False: there was none."""
        return bool(self._do("delete from kept where kind = ? and name = ?", kind, name))

    # ---- audit -----------------------------------------------------------------------------------------------------------
    def note(self, who: str, source: str, what: str, detail: dict[str, object] | str = "") -> None:
        """One more entry of the chain."""
        words = detail if isinstance(detail, str) else json.dumps(detail, sort_keys=True, ensure_ascii=False)
        with self._lock:
            if len(self._waiting) < MOST_WAITING:
                self._waiting.append((wall(), who, source, what, words))
            else:
                self._lost += 1
            self._write_waiting()

    def settle(self) -> None:
        """Entries that wait are written where the disk has room again; to be called now and then."""
        with self._lock:
            if self._waiting:
                self._write_waiting()

    def _write_waiting(self) -> None:
        kept = len(self._waiting)
        try:
            self._db.execute("begin immediate")
            for entry in self._waiting:
                self._append(*entry)
            if self._lost:
                self._append(wall(), "axisgate", "local", "audit", f"{self._lost} entries were lost: the disk took nothing")
            self._db.execute("commit")
        except sqlite3.Error as error:
            with contextlib.suppress(sqlite3.Error):
                self._db.execute("rollback")  # SQLite may have done so itself
            if not self._full:
                self._report(
                    f"the audit of the page is not written ({error}); orders are carried out; free space on the disk of {self.path}"
                )
            self._full = True
            return
        self._waiting.clear()
        if self._full:
            self._report(f"the audit of the page is written again; {kept} entries had waited, {self._lost} are lost")
        self._full, self._lost = False, 0

    def _append(self, moment: str, who: str, source: str, what: str, words: str) -> None:
        last = self._db.execute("select number, hash from audit order by number desc limit 1").fetchone() or (0, BEGIN)
        number = int(last[0]) + 1
        link = _link(str(last[1]), number, moment, who, source, what, words)
        self._db.execute("insert into audit values (?, ?, ?, ?, ?, ?, ?)", (number, moment, who, source, what, words, link))

    def audit(self, last: int = 200) -> list[dict[str, object]]:
        """The newest entries, newest first."""
        names = ("number", "wall", "who", "source", "what", "detail", "hash")
        rows = self._rows(f"select {', '.join(names)} from audit order by number desc limit ?", last)
        return [dict(zip(names, row, strict=True)) for row in rows]

    def verify(self) -> int | None:
        """Number of the first entry that does not fit the one before it; None: the chain is intact."""
        before, expected = BEGIN, 1
        for row in self._rows("select number, wall, who, source, what, detail, hash from audit order by number"):
            number, moment, who, source, what, words, found = (str(each) for each in row)
            if int(number) != expected or _link(before, int(number), moment, who, source, what, words) != found:
                return expected
            before, expected = found, expected + 1
        return None

    # ---- the file ----------------------------------------------------------------------------------------------------------
    def _rows(self, text: str, *values: object) -> list[tuple[object, ...]]:
        with self._lock:
            return self._db.execute(text, values).fetchall()

    def _do(self, text: str, *values: object) -> int:
        """StoreError: the disk refuses writes."""
        with self._lock:
            try:
                return self._db.execute(text, values).rowcount
            except sqlite3.OperationalError as error:
                raise StoreError(f"it cannot be stored ({error}); free space on the disk of {self.path.parent}") from error


def _hashed(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def _link(before: str, *parts: object) -> str:
    return hashlib.sha256(json.dumps([before, *parts], ensure_ascii=False).encode()).hexdigest()
