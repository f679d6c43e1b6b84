"""Access control: cookies and tokens, protection against requests of other sites, limits for wrong passwords.

On loopback, looking and stopping need no password; in a simulation the emulator panel neither.  From elsewhere everything does, and
every change does (AX-471, AX-473).
"""

import ipaddress
import secrets
import time
from collections import deque
from dataclasses import dataclass

from starlette.requests import HTTPConnection

from gateway.pure.cell.web import LOOPBACK, Web
from gateway.web.store import Role, Store

COOKIE, CSRF = "axisgate", "x-axisgate-csrf"
TRIES, WINDOW_S = 5, 60.0  # wrong passwords of one address or for one name
OURS = "x-axisgate"  # a header no form of another page can send


@dataclass(frozen=True, slots=True)
class Person:
    """The person who sent a request."""

    name: str
    role: Role
    source: str  # address
    local: bool
    key: str  # control is bound to it: a session, a token, or none
    csrf: str = ""


class Denied(Exception):
    """Answered with this status and sentence."""

    def __init__(self, status: int, words: str) -> None:
        super().__init__(words)
        self.status, self.words = status, words


class Patience:
    """Five wrong passwords a minute from one address or for one name; then logins from there are refused for the rest of it."""

    def __init__(self) -> None:
        self._wrong: dict[str, deque[float]] = {}

    def wait_s(self, *keys: str) -> float:
        """Seconds until the next attempt is accepted; 0: now."""
        now = time.monotonic()
        for key in list(self._wrong):
            while self._wrong[key] and now - self._wrong[key][0] > WINDOW_S:
                self._wrong[key].popleft()
            if not self._wrong[key]:
                del self._wrong[key]
        return max((WINDOW_S - (now - self._wrong[key][0]) for key in keys if len(self._wrong.get(key, ())) >= TRIES), default=0.0)

    def wrong(self, *keys: str) -> None:
        """An attempt that is not checked yet counts as a wrong one: at most five are accepted at once, too."""
        for key in keys:
            self._wrong.setdefault(key, deque(maxlen=TRIES)).append(time.monotonic())

    def right(self, *keys: str) -> None:
        """It was the right one."""
        for key in keys:
            if self._wrong.get(key):
                self._wrong[key].pop()


class Access:
    """Judges every request."""

    def __init__(self, store: Store, web: Web, *, simulated: bool) -> None:
        self.store, self.web, self.simulated = store, web, simulated
        self.patience = Patience()

    def person(self, request: HTTPConnection) -> Person:
        """By token, else by cookie, else by address.  Denied 401: an invalid token or session."""
        source = request.client.host if request.client else ""
        local = is_local(source)
        bearer = request.headers.get("authorization", "")
        if bearer:
            found = self.store.token(bearer.removeprefix("Bearer ").strip())
            if found is None:
                raise Denied(401, "this token is not known")
            return Person(f"token {found[0]}", found[1], source, local, f"token:{found[0]}")
        session = self.store.session(request.cookies.get(COOKIE, ""))
        if session is not None:
            return Person(session.name, session.role, source, local, f"session:{session.id}", session.csrf)
        return Person("local" if local else "nobody", Role.VIEWER if local else Role.NOBODY, source, local, "")

    def role_of(self, key: str) -> Role:
        """Present role of the person with this key: users and tokens may be changed at any time, also from the command line."""
        kind, _, name = key.partition(":")
        if kind == "session":
            session = self.store.session(name)
            return session.role if session is not None else Role.NOBODY
        return next((role for label, role, _ in self.store.tokens() if label == name), Role.NOBODY)

    def host(self, request: HTTPConnection) -> None:
        """Checks the Host name: another site's name that resolves to this server is refused."""
        asked = host_of(request.headers.get("host", ""))
        known = {*LOOPBACK, self.web.host, *self.web.names}
        if asked not in known and not (self.web.host in ("0.0.0.0", "::") and _is_address(asked)):
            raise Denied(421, f"host {asked!r} is not served here; [web] names lists what is")

    def origin(self, request: HTTPConnection) -> None:
        """A browser names the page a request comes from: only our own may change or receive anything."""
        origin = request.headers.get("origin")
        if origin is None:
            return
        scheme, _, host = origin.partition("://")
        if scheme not in ("http", "https") or host != request.headers.get("host"):
            raise Denied(403, "a request of another page is not carried out")

    def may(self, request: HTTPConnection, person: Person, role: Role) -> None:
        """Check a change through the API; Denied names the required role."""
        self.origin(request)
        if person.key.startswith("session:"):
            if not secrets.compare_digest(request.headers.get(CSRF, ""), person.csrf):
                raise Denied(403, "the request has no session token (header x-axisgate-csrf)")
        elif not person.key and request.headers.get(OURS) is None:
            raise Denied(403, "the header x-axisgate is missing")
        self.role(person, role)

    @staticmethod
    def role(person: Person, role: Role) -> None:
        """The role alone."""
        if person.role < role:
            words = f"role {role.name.lower()} required; logged in: {person.name}, {person.role.name.lower()}"
            raise Denied(403 if person.key else 401, words)


def is_local(address: str) -> bool:
    """A request from this computer."""
    return _is_address(address) and ipaddress.ip_address(address).is_loopback


def host_of(header: str) -> str:
    """Name or address of a Host header, without its port."""
    if header.startswith("["):
        return header[1:].partition("]")[0]
    return header.rpartition(":")[0] if header.count(":") == 1 else header


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
    return True
