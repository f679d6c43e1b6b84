"""Sessions, users and tokens: handlers of the interface for the first password, login, and changes by an administrator."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.responses import JSONResponse, Response

from gateway.web.access import COOKIE, Access, Denied
from gateway.web.bodies import Login, Named, Token, User
from gateway.web.endpoints import Call, Endpoint
from gateway.web.operator_control import OperatorControl
from gateway.web.store import SESSION_S, Role, Store, StoreError

Row = dict[str, Any]


class Accounts:
    """Users and logins.  `judge` closes the connections of changed users."""

    def __init__(self, access: Access, operator_control: OperatorControl) -> None:
        self.access, self.operator_control = access, operator_control
        self.store: Store = access.store
        self.secure = bool(access.web.tls_certificate)
        self.judge: Callable[[], Awaitable[None]] = _nothing
        self._login = asyncio.Semaphore(1)  # argon2 occupies a core for a moment: one at a time

    async def setup(self, call: Call) -> Response:
        """The first password; from this computer only, and only while there is none."""
        body: Login = call.body
        if not call.person.local:
            raise Denied(403, "the first password is set on the gateway itself")
        async with self._login:
            if not self.store.fresh:
                raise Denied(409, "there is an administrator already")
            await asyncio.to_thread(self.store.put_user, body.name, Role.ADMIN, body.password)
        return self._logged_in(body.name)

    async def login(self, call: Call) -> Response:
        body: Login = call.body
        keys = (f"address {call.person.source}", f"name {body.name}")
        wait = self.access.patience.wait_s(*keys)
        if wait:
            raise Denied(429, f"too many wrong passwords; try again in {wait:.0f} s")
        self.access.patience.wrong(*keys)
        async with self._login:
            right = await asyncio.to_thread(self.store.right, body.name, body.password)
        if right:
            self.access.patience.right(*keys)
        else:
            self.store.note(body.name, call.person.source, "wrong password")
            raise Denied(401, "name or password is wrong")
        return self._logged_in(body.name)

    def _logged_in(self, name: str) -> Response:
        session = self.store.open_session(name)
        response = JSONResponse({"name": name, "role": session.role.name.lower(), "csrf": session.csrf})
        response.set_cookie(COOKIE, session.id, max_age=SESSION_S, httponly=True, samesite="strict", secure=self.secure, path="/")
        return response

    async def logout(self, call: Call) -> Response:
        if call.person.key and call.person.key == self.operator_control.holder:
            await self.operator_control.lose()
        self.store.close_session(call.request.cookies.get(COOKIE, ""))
        await self.judge()
        response = JSONResponse({"ok": True})
        response.delete_cookie(COOKIE, path="/")
        return response

    async def users(self, call: Call) -> Row:
        tokens = [{"label": label, "role": role.name.lower(), "made": made} for label, role, made in self.store.tokens()]
        return {"users": [{"name": name, "role": role.name.lower()} for name, role in self.store.users()], "tokens": tokens}

    async def put_user(self, call: Call) -> Row:
        body: User = call.body
        async with self._login:
            await asyncio.to_thread(self.store.put_user, body.name, Role[body.role.upper()], body.password)
        await self.judge()
        return {"ok": True}

    async def drop_user(self, call: Call) -> Row:
        body: Named = call.body
        if not self.store.drop_user(body.name):
            raise StoreError(f"no user {body.name}")
        await self.judge()
        return {"ok": True}

    async def put_token(self, call: Call) -> Row:
        body: Token = call.body
        return {"token": self.store.put_token(body.label, Role[body.role.upper()])}

    async def drop_token(self, call: Call) -> Row:
        body: Named = call.body
        if not self.store.drop_token(body.name):
            raise StoreError(f"no token {body.name}")
        await self.judge()
        return {"ok": True}


async def _nothing() -> None:
    """No connection is open."""


def account_endpoints(accounts: Accounts) -> list[Endpoint]:
    """Login, users and tokens."""
    a, n = Role.ADMIN, Role.NOBODY
    row = Endpoint
    return [
        row("POST", "/api/setup", n, "the first password", accounts.setup, Login, True),
        row("POST", "/api/login", n, "begin a session", accounts.login, Login, True),
        row("POST", "/api/logout", n, "end it", accounts.logout, None, True),
        row("GET", "/api/users", a, "users and tokens", accounts.users),
        row("POST", "/api/users", a, "a new user, or a new password", accounts.put_user, User, True),
        row("POST", "/api/users/drop", a, "a user leaves", accounts.drop_user, Named, True),
        row("POST", "/api/tokens", a, "a secret for a script, shown once", accounts.put_token, Token, True),
        row("POST", "/api/tokens/drop", a, "a token ends", accounts.drop_token, Named, True),
    ]
