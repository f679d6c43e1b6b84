"""The live connection of one open page: looks go out ten times a second, keys held down come in."""

import asyncio
import contextlib
import json
import time
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from gateway.observer.tool_link import Gone, Refused
from gateway.web.access import Access, Denied, Person
from gateway.web.catalogue import said
from gateway.web.german import says
from gateway.web.live import MOST_WATCHED, Live, Viewer
from gateway.web.operator_control import NotYours, OperatorControl
from gateway.web.store import Role

LONGEST = 32768
LATE_MS = 1000.0
LATE = ["the connection is too slow to move an axis: release the key", "die Verbindung ist zu langsam zum Verfahren: Taste loslassen"]
MOST_VIEWERS = 64
LIFE = ("alive", "jog", "reference", "release")  # messages that show that the holder is there; reading does not
JUDGED_S = 0.25  # users are also changed from the command line
REFUSED, TOO_MANY = 4403, 4429  # close codes: the page requests a login, or waits


class Sockets:
    """All of them."""

    def __init__(self, live: Live, operator_control: OperatorControl, access: Access) -> None:
        self.live, self.operator_control, self.access = live, operator_control, access
        self._open: dict[Viewer, tuple[WebSocket, Person]] = {}
        operator_control.role_of = access.role_of

    async def serve(self, socket: WebSocket) -> None:
        """From its opening to its end; nothing a browser sends ends anything but its own connection."""
        try:
            self.access.host(socket)
            self.access.origin(socket)
            person = self.access.person(socket)
            self.access.role(person, Role.VIEWER)
        except Denied as denied:
            await socket.accept()
            await socket.close(REFUSED, denied.words[:100])
            return
        await socket.accept()
        if len(self.live.viewers) >= MOST_VIEWERS:
            await socket.close(TOO_MANY, "too many pages are open")
            return
        viewer = Viewer()
        self.live.viewers.add(viewer)
        self._open[viewer] = (socket, person)
        sender = asyncio.create_task(self._send(socket, viewer))
        try:
            await self._hear(socket, viewer, person)
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            self.live.viewers.discard(viewer)
            self._open.pop(viewer, None)
            if person.key and person.key == self.operator_control.holder:
                if viewer.holding:  # a key of a lost browser is released
                    await self.operator_control.let_go()
                if all(other.key != person.key for _, other in self._open.values()):  # control ends with the last page of the session
                    await self.operator_control.lose()
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await sender

    async def run(self) -> None:
        """Until cancelled: connections of people that may no longer look are closed."""
        while True:
            await asyncio.sleep(JUDGED_S)
            await self.judge()

    async def judge(self) -> None:
        """At once after a change of users; a lowered one keeps its view with the present role only."""
        for viewer, (socket, person) in list(self._open.items()):
            if not person.key:
                continue
            role = self.access.role_of(person.key)
            if role is person.role:
                continue
            if person.key == self.operator_control.holder and role < Role.OPERATOR:
                await self.operator_control.lose()
            self._open.pop(viewer, None)
            with contextlib.suppress(RuntimeError, OSError):
                await socket.close(REFUSED, "this login has ended, or its role has changed")

    async def _send(self, socket: WebSocket, viewer: Viewer) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, OSError):
            while True:
                await viewer.tick.wait()
                viewer.tick.clear()
                await socket.send_text(self.live.text(viewer))

    async def _hear(self, socket: WebSocket, viewer: Viewer, person: Person) -> None:
        while True:
            text = await socket.receive_text()
            if len(text) > LONGEST:
                return
            try:
                message = json.loads(text)
            except ValueError:
                continue
            if isinstance(message, dict):
                if message.get("t") in LIFE:
                    self.operator_control.heard(person.key)
                answer = await self._take(message, viewer, person)
                if answer is not None:
                    say = {"say": says(answer["error"])} if "error" in answer else {}
                    await socket.send_text(json.dumps({"t": "answer", **answer, **say}))

    async def _take(self, message: dict[str, Any], viewer: Viewer, person: Person) -> dict[str, Any] | None:
        match message.get("t"):
            case "page":
                viewer.page, viewer.versions = str(message.get("name"))[:20], {}
                watch = message.get("watch")
                viewer.watch = tuple(str(each)[:100] for each in watch[:MOST_WATCHED]) if isinstance(watch, list) else ()
            case "jog" | "reference" as what:
                return await self._held(what, message, viewer, person)
            case "panel":
                return await self._panel(message, person)
            case "release":
                viewer.holding = viewer.pressed = False
                if person.key == self.operator_control.holder:
                    await self.operator_control.let_go()
        return None

    async def _held(self, what: str, message: dict[str, Any], viewer: Viewer, person: Person) -> dict[str, Any]:
        """A key is held.  Refusals are reported; the key is not."""
        try:
            if self.access.web.read_only:
                return {"error": "the page is read-only"}
            self.access.role(person, Role.OPERATOR)
            first = bool(message.get("first", not viewer.pressed))
            viewer.pressed = True
            if _late(message):
                return {"held": {"state": "REFUSED", "detail": LATE[0], "say": LATE}}
            answer = await (self._jog(message, person, first) if what == "jog" else self._reference(message, person, first))
            viewer.holding = viewer.holding or answer["state"] not in ("REFUSED", "ABORTED", "ENDED")
            return {"held": said(answer)}
        except (KeyError, ValueError, TypeError):
            return {"error": "jog: axis, direction, percent; reference: mask"}
        except Denied as denied:
            return {"error": denied.words}
        except (NotYours, Gone, Refused) as why:
            return {"error": str(why)}

    async def _panel(self, message: dict[str, Any], person: Person) -> dict[str, Any] | None:
        """A key of the hand-held unit of the old controller is pressed, held or released.  Refusals are reported."""
        try:
            act, key, first = str(message["act"]), str(message["key"])[:16], bool(message.get("first", True))
            if act not in ("key", "hold", "release"):
                raise ValueError(act)
            if self.access.web.read_only:
                return {"error": "the page is read-only"}
            self.access.role(person, Role.OPERATOR)
            self.operator_control.free(person.key)
            if act == "hold" and _late(message):
                return {"held": {"state": "REFUSED", "detail": LATE[0], "say": LATE}}
            answer = await self.operator_control.services_link.ask("panel", first=first, **{act: key})
            if act != "release" and first and key in answer["unit"]["held"]:
                self.access.store.note(person.name, person.source, "pendant key", {"name": key})
        except (KeyError, ValueError, TypeError):
            return {"error": "panel: act = key, hold or release; key"}
        except Denied as denied:
            return {"error": denied.words}
        except (NotYours, Gone, Refused) as why:
            return {"error": str(why)}
        return None

    async def _jog(self, message: dict[str, Any], person: Person, first: bool) -> dict[str, Any]:
        axis, direction, percent = int(message["axis"]), int(message["direction"]), float(message["percent"])
        if not 0 <= axis < len(self.operator_control.axes) or direction not in (-1, 1) or percent != percent:
            raise ValueError("no such axis")
        return await self.operator_control.jog(person.key, axis, direction, percent, first=first)

    async def _reference(self, message: dict[str, Any], person: Person, first: bool) -> dict[str, Any]:
        mask = int(message["mask"])
        if not 0 < mask < 1 << len(self.operator_control.axes):
            raise ValueError("no such axes")
        return await self.operator_control.reference(person.key, mask, first=first)


def _late(message: dict[str, Any]) -> bool:
    """A page's message carries the time of its last look: a key pressed on an old view moves nothing."""
    at = message.get("at")
    return at is not None and time.monotonic() * 1e3 - float(at) > LATE_MS
