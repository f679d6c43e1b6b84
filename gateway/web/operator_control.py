"""Operator control from the web page: one user at a time, hold-to-run jogging and referencing, release of control
(AX-475, AX-499).

The services stop the axes on the path when the page is silent for a second; the page is silent as soon as the holder's own browser is.  A
jog is a slow move to the limit that ends when the key is released or no longer repeated; a reference run likewise.
"""

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Sequence

from gateway.assembly.jog import Jog
from gateway.observer.regions import Regions
from gateway.observer.tool_link import Gone, Refused, Row, ServicesLink
from gateway.pure.cell.cell import Axis
from gateway.pure.image.records.cell import AxisFlag, Motion
from gateway.web.store import Role

ALIVE_S = 0.25  # interval of the holder's sign of life to the services
HOLDER_S = 3.0  # it ends when his browser has been silent for so long: a busy computer delays it
KEY_S = 0.4  # a key without a repeat for so long has been released
SLOWEST, FASTEST = 0.1, 10.0  # % of the axis' speed a jog may have
ROOM = 0.02  # share of the travel a jog keeps from the limit
CODES = ("enable", "disable", "reference", "ptp_absolute", "ptp_relative", "stop", "resume", "abandon", "fault_reset", "override",
         "request_control", "release_control")  # fmt: skip


ENDED = ["stopped: release the key, then press it again", "angehalten: Taste loslassen, dann neu drücken"]
ANOTHER_KEY = ["another key is held: release it first", "eine andere Taste wird gehalten: erst loslassen"]
Held = tuple[str, int, int]  # "jog", axis, direction; "reference", mask, 0


class NotYours(Exception):
    """Another user has the page's command source."""


class OperatorControl:
    """The page's command source and who holds it."""

    def __init__(self, services_link: ServicesLink, regions: Regions, axes: Sequence[Axis], speeds: Jog | None = None) -> None:
        self.services_link, self.regions, self.axes = services_link, regions, axes
        self.speeds = speeds  # of a rho 3's jog keys; None: a share of the axis' speed
        self._pace = (0, 1.0)  # job of the jog, and at which share of its speed it goes
        self.holder, self.name = "", ""  # key of a session or token, and its person
        self._heard = 0.0
        self._held: Held | None = None
        self._held_heard = 0.0
        self._held_lock = asyncio.Lock()
        self.role_of: Callable[[str], Role] = lambda key: Role.ADMIN  # present role of a key, from Access

    # ---- life -----------------------------------------------------------------------------------------------------------
    async def run(self) -> None:
        """Until cancelled: send the holder's sign of life, end motions that are no longer held."""
        while True:
            await asyncio.sleep(ALIVE_S / 2)
            if self._held is not None and time.monotonic() - self._held_heard > KEY_S:
                await self.let_go()
            if self.holder and (time.monotonic() - self._heard > HOLDER_S or self.role_of(self.holder) < Role.OPERATOR):
                await self.lose()
            if self.holder:
                with contextlib.suppress(Gone, Refused):
                    holder, answer = self.holder, await self.services_link.ask("alive")
                    if not answer["holds"] and holder == self.holder:
                        self.holder = self.name = ""  # the services were restarted, or somebody else has control

    async def lose(self) -> None:
        """The holder is gone, or has lost the permission: the services stop the axes on the path and end the page's control at rest."""
        self.holder = self.name = ""
        await self.forget()
        with contextlib.suppress(Gone, Refused):
            await self.services_link.ask("leave")

    def heard(self, key: str) -> None:
        """The browser of this session is alive."""
        if key and key == self.holder:
            self._heard = time.monotonic()

    # ---- commands -------------------------------------------------------------------------------------------------------
    async def command(self, key: str, name: str, code: str, mask: int = 0, **rest: object) -> Row:
        """One command of the own block; NotYours, Gone, Refused."""
        if code == "stop":
            await self.forget()
            return await self.services_link.command("stop")
        if code == "request_control":
            return await self._request(key, name)
        self._mine(key)
        if code == "release_control":
            answer = await self.services_link.command(code)
            if answer["state"] == "DONE":
                self.holder = self.name = ""
            return answer
        return await self.services_link.command(code, mask, **rest)

    async def _request(self, key: str, name: str) -> Row:
        if self.holder and self.holder != key:
            raise NotYours(f"{self.name} has the page's command source")
        answer = await self.services_link.command("request_control")
        if answer["state"] in ("DONE", "ACCEPTED"):
            self.holder, self.name, self._heard = key, name, time.monotonic()
        return answer

    def free(self, key: str) -> None:
        """No other user has control; NotYours."""
        if self.holder and self.holder != key:
            raise NotYours(f"{self.name} has the page's command source")

    async def start_program(self, key: str, name: str, *, do: str = "start", **more: object) -> Row:
        """It moves as the page while this user has control, else as the PLC; NotYours, Gone, Refused."""
        self.free(key)
        if key and key == self.holder:
            self._heard = time.monotonic()
        return await self.services_link.ask("process", do=do, name=name, **more)

    def _mine(self, key: str) -> None:
        if not key or self.holder != key:
            raise NotYours(f"{self.name} has the page's command source" if self.holder else "request control first")
        self._heard = time.monotonic()

    async def job(self, number: int) -> Row:
        """Result of a command."""
        return await self.services_link.ask("job", job=number)

    # ---- hold to run ------------------------------------------------------------------------------------------------------
    async def jog(self, key: str, axis: int, direction: int, percent: float, *, first: bool = True) -> Row:
        """The key was pressed (`first`): start the move.  The key is still held: keep the move, but do not restart one that has ended."""
        speed = min(max(percent, SLOWEST), FASTEST)
        if self.speeds is not None and first and self._held is None:
            self.speeds.keys.press(axis, direction, time.monotonic())
        answer = await self._hold(key, ("jog", axis, direction), lambda: self._begin(axis, direction, speed), first)
        if self._held is None and self.speeds is not None:
            self.speeds.keys.release(axis)
        elif self._held == ("jog", axis, direction):
            await self._keep_pace(axis)
        return answer

    async def _keep_pace(self, axis: int) -> None:
        """A key held for 1.5 s goes from slow to fast (rho 3 L628)."""
        job, share = self._pace
        if self.speeds is not None and job and share != (now := self.speeds.share(axis, time.monotonic()) / self.speeds.most(axis)):
            self._pace = (job, now)
            await self.services_link.ask("pace", job=job, share=now)

    async def reference(self, key: str, mask: int, *, first: bool = True) -> Row:
        """The same for a reference run of the axes in the mask."""
        return await self._hold(key, ("reference", mask, 0), lambda: self.services_link.command("reference", mask), first)

    async def _hold(self, key: str, held: Held, begin: Callable[[], Awaitable[Row]], first: bool) -> Row:
        self._mine(key)
        async with self._held_lock:
            if self._held == held and not first:
                self._held_heard = time.monotonic()
                return {"state": "RUNNING"}
            if self._held is not None:
                return {"state": "REFUSED", "detail": "another key is held", "say": ANOTHER_KEY}
            if not first:
                return {"state": "ENDED", "detail": ENDED[0], "say": ENDED}
            answer = await begin()
            if answer["open"]:
                self._held, self._held_heard = held, time.monotonic()
            return answer

    async def _begin(self, number: int, direction: int, percent: float) -> Row:
        axis = self.axes[number]
        self.regions.look()
        state = self.regions.state.axes[number]
        si = self.regions.facts[number][2]
        room = ROOM * (axis.limits.max - axis.limits.min)
        limit = axis.limits.max - room if direction > 0 else axis.limits.min + room
        way = limit - state.set / si
        if axis.modulo:
            way = direction * axis.modulo  # one round: there is no limit to stop at
        if way * direction <= 0:
            say = [f"{axis.name} is at its limit", f"{axis.name} steht an der Grenze"]
            return {"state": "REFUSED", "open": False, "words": "TARGET_LIMIT", "detail": say[0], "say": say}
        rest: dict[str, object] = {"velocity": percent / 100.0, "acceleration": 0.5}
        if self.speeds is not None:  # planned at the fast speed, begun at the slow one
            slow = self.speeds.share(number, time.monotonic()) / self.speeds.most(number)
            rest = {
                "velocity": self.speeds.most(number) * percent / FASTEST,
                "acceleration": self.speeds.acceleration(number),
                "share": slow,
            }
        targets = [0.0] * len(self.axes)
        targets[number] = way
        unreferenced = not state.flags & AxisFlag.REFERENCED
        answer = await self.services_link.command("ptp_relative", 1 << number, targets=targets, first_try=unreferenced, **rest)
        self._pace = (int(answer["job"]), float(str(rest.get("share", 1.0))))
        return answer

    async def let_go(self) -> None:
        """The key was released, or its browser is gone: stop on the path and drop the rest."""
        async with self._held_lock:
            if self._held is None:
                return
            self._release()
            with contextlib.suppress(Gone, Refused):
                await self.services_link.command("stop")
                await self._at_rest()
                if self.regions.state.motion is Motion.STOPPED:
                    await self.services_link.command("abandon")

    async def forget(self) -> None:
        """Stop was pressed: the axes rest, the key no longer counts."""
        async with self._held_lock:
            self._release()

    def _release(self) -> None:
        if self._held is not None and self._held[0] == "jog" and self.speeds is not None:
            self.speeds.keys.release(self._held[1])
        self._held = None

    async def _at_rest(self) -> None:
        for _ in range(100):
            await asyncio.sleep(0.02)
            self.regions.look()
            if self.regions.state.motion not in (Motion.RUNNING, Motion.STOPPING):
                return
