"""Ten times a second: one look at the regions, one text for each kind of open page, the same to all of them.

A slow browser misses updates; no one waits for it, and nothing is queued for it.
"""

import asyncio
import contextlib
import json
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

from gateway.assembly.run import RunPlan
from gateway.observer.names import Names
from gateway.observer.regions import Regions
from gateway.observer.tool_link import Gone, Refused, ServicesLink, supervisor
from gateway.observer.values import Watched
from gateway.services.alarm_file import path_of
from gateway.web.alarms import AlarmHistory
from gateway.web.bus_view import BusView
from gateway.web.catalogue import advice
from gateway.web.events import Events
from gateway.web.german import both, says, umlauts
from gateway.web.line_view import LineViews, asked_links, shown_sources
from gateway.web.operator_control import OperatorControl
from gateway.web.plant_view import Plant
from gateway.web.plc_view import PlcView
from gateway.web.programs import ProgramView
from gateway.web.scope import Scope
from gateway.web.skeleton import Skeleton
from gateway.web.trends import Trends
from gateway.web.val3_view import Val3View

TICK_S = 0.1
TREND_TICKS = 10  # one look a second, with or without viewers
MOST_WATCHED = 400  # values of one page
Row = dict[str, Any]
Look = Callable[[], Awaitable[Row]]


@dataclass(eq=False, slots=True)
class Viewer:
    """One open page."""

    page: str = "overview"
    watch: tuple[str, ...] = ()
    holding: bool = False  # it holds a key that moves something
    pressed: bool = False  # it reported a held key, and not yet its release
    tick: asyncio.Event = field(default_factory=asyncio.Event)
    versions: dict[str, int] = field(default_factory=dict)


@dataclass(slots=True)
class Topic:
    """Content of one page: its lookup, its interval in ticks, and its last text."""

    look: Look
    every: int = 1
    text: str = "null"
    version: int = 0


class Live:
    """The ticking heart of the page."""

    def __init__(
        self,
        plan: RunPlan,
        regions: Regions,
        services_link: ServicesLink,
        operator_control: OperatorControl,
        plant: Plant,
        scope: Scope,
        names: Names,
    ) -> None:
        self.scope = scope
        self.plan, self.regions, self.services_link, self.operator_control, self.plant = (
            plan,
            regions,
            services_link,
            operator_control,
            plant,
        )
        self.viewers: set[Viewer] = set()
        self.events = Events(plan.journal)
        self.alarms = AlarmHistory(path_of(plan))
        self.lines = LineViews(plan.cell, services_link)
        self.buses = [BusView(bus, plan.buses[bus.name]) for bus in plan.cell.bus if bus.name in plan.buses]
        self.skeleton = Skeleton(plan.cell)
        self.programs = ProgramView(plan.cell, services_link)
        self.plc = PlcView(plan.cell, services_link)
        self.val3 = Val3View(plan.cell, services_link)
        self.processes: Row = {}
        self.head = "null"
        self.values: Row = {}  # of everything watched
        self.watched = Watched(regions)
        self.trends = Trends(names, self.watched)
        self._ticks = 0
        self.topics = {
            "overview": Topic(self._overview, 2),
            "axes": Topic(self._axes),
            "signals": Topic(self._signals, 5),
            "scope": Topic(self._scope, 3),
            "lines": Topic(self._lines, 3),
            "bus": Topic(self._bus, 5),
            "motion": Topic(self._motion),
            "programs": Topic(self.programs.look, 2),
            "val3": Topic(self.val3.look, 2),
            "plc": Topic(self.plc.look, 3),
            "pendant": Topic(self._pendant, 2),
            "events": Topic(self._events, 3),
            "emulator": Topic(self._emulator, 5),
            "cell": Topic(self._overview, 10),
        }

    async def _pendant(self) -> Row:
        """The display and the keys of the hand-held unit.  Gone, Refused."""
        return await self.services_link.ask("panel")

    async def run(self) -> None:
        """Until cancelled."""
        due = time.monotonic()
        while True:
            due = max(due + TICK_S, time.monotonic())
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            self._ticks += 1
            await self._turn()

    async def _turn(self) -> None:
        self.regions.look()
        if self._ticks % 5 == 1:
            await self._ask_supervisor()
        if self._ticks % TREND_TICKS == 1:
            await self.trends.look(self.services_link)
        if not self.viewers:
            self._close_buses()
            return
        pages = {viewer.page for viewer in self.viewers}
        if "bus" not in pages:
            self._close_buses()
        if any(viewer.watch for viewer in self.viewers):
            await self._watch()
        self.head = json.dumps(self._head(), separators=(",", ":"))
        for name in self.topics.keys() - pages:
            self.topics[name].text = "null"  # a later viewer must not get the old text
        for name in pages & self.topics.keys():
            topic = self.topics[name]
            if self._ticks % topic.every == 0 or topic.text == "null":
                await self._renew(topic)
        for viewer in self.viewers:
            viewer.tick.set()

    @staticmethod
    async def _renew(topic: Topic) -> None:
        try:
            found = await topic.look()
        except (Gone, Refused) as why:
            found = {"gone": str(why)}
        text = json.dumps(found, separators=(",", ":"))
        if text != topic.text:
            topic.text, topic.version = text, topic.version + 1

    def text(self, viewer: Viewer) -> str:
        """Messages for this viewer: the head always, its page when it changed, its watched values."""
        topic = self.topics.get(viewer.page)
        page = "null"
        if topic is not None and viewer.versions.get(viewer.page) != topic.version:
            viewer.versions = {viewer.page: topic.version}
            page = topic.text
        watched = json.dumps({name: self.values[name] for name in viewer.watch if name in self.values}, separators=(",", ":"))
        at = round(time.monotonic() * 1e3)
        return f'{{"t":"live","at":{at},"name":"{viewer.page}","head":{self.head},"page":{page},"values":{watched}}}'

    async def _ask_supervisor(self) -> None:
        with contextlib.suppress(Gone):
            self.processes = await supervisor(self.plan.slug, "status")

    def _close_buses(self) -> None:
        for view in self.buses:
            view.close()

    # ---- pages -----------------------------------------------------------------------------------------------------------
    def _head(self) -> Row:
        head = self.regions.head()
        head["errors"] = [self._with_texts(error) for error in head["errors"]]
        head["stop_text"] = [head["stop_text"][0], umlauts(head["stop_text"][1])]
        head["holder"] = self.operator_control.name
        known = head["services_alive"]  # without the services the state of their links is unknown
        head["links"] = [[source["name"], source["alive"] if known else None] for source in self.regions.status.get("command_sources", [])]
        head["links"] += [[link["name"], link["alive"] if known else None] for link in asked_links(self.regions.status)]
        return head

    @staticmethod
    def _with_texts(error: Row) -> Row:
        code = int(error.get("code", 0))
        return {**error, "say": both(code, str(error.get("text", ""))), **advice(code)}

    async def _overview(self) -> Row:
        return {
            "processes": self.processes.get("processes", []),
            "alarms": self.processes.get("alarms", []),
            "command_sources": shown_sources(self.regions.status),
            "drives": self.regions.drives(),
            "cycle": self.regions.counters(),
        }

    async def _axes(self) -> Row:
        return {"axes": self.regions.drives(), "ns": self.regions.state.sync_ns}

    async def _signals(self) -> Row:
        return {"forced": self.watched.looked["forced"]}

    async def _scope(self) -> Row:
        return self.scope.row()

    async def _lines(self) -> Row:
        status = self.regions.status
        clock_ms = round((time.time() - time.monotonic()) * 1e3, -1)  # stamps of lines are of the monotonic clock
        found = {"lines": await self.lines.look(), "command_sources": shown_sources(status), "asked": asked_links(status)}
        return {**found, "clock_ms": clock_ms}

    async def _bus(self) -> Row:
        for view in self.buses:
            view.open()
        return {"buses": [view.row() for view in self.buses], "cycle": self.regions.counters()}

    async def _motion(self) -> Row:
        joints = [axis.set for axis in self.regions.state.axes[: len(self.regions.facts)]]
        state, queue = self.regions.state, self.regions.queue()
        tool = queue.get("tool", ())
        return {
            "axes": self.regions.drives(),
            "lines": self.skeleton.lines(joints, tool),
            "frames": self.skeleton.frames(joints, tool),
            "marks": self.skeleton.marks(joints),
            "queue": {key: says(value) if key in ("fault", "warning") else value for key, value in queue.items()},
            "job": state.job,
            "progress": round(state.progress, 3),
        }

    async def _events(self) -> Row:
        self.events.look()
        return {"events": [{**row, "say": says(row["text"])} for row in list(self.events.kept)[-200:]], "alarms": self.alarms.version}

    async def _emulator(self) -> Row:
        return {**await self.plant.look(), "command_sources": self.regions.status.get("command_sources", [])}

    # ---- watched values ----------------------------------------------------------------------------------------------------
    async def _watch(self) -> None:
        wanted = {name for viewer in self.viewers for name in viewer.watch}
        await self.watched.look(self.services_link)
        self.values = self.watched.values(wanted)
