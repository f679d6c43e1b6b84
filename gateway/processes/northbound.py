"""The northbound process: the services of [northbound] in the cell, off by default (AX-427).

It reads the regions and writes none, at the lowest priority: a broker, a client or this process itself cannot disturb the machine's side.
It may die at any time; the supervisor starts it again.
"""

import argparse
import asyncio
import contextlib
import json
import os
import pathlib
import signal
from collections.abc import Coroutine
from typing import TYPE_CHECKING

from drivers.ports.base import PortError
from gateway.assembly.run import RunPlan, load_plan
from gateway.northbound.journald import Journald, there
from gateway.northbound.metrics import Metrics
from gateway.northbound.snapshot import values
from gateway.observer.regions import Regions
from gateway.pure.cell.northbound import Northbound, place_of
from gateway.runtime.journal import Journal
from gateway.runtime.late_address import patiently
from gateway.runtime.life import BEAT_S, Life
from gateway.runtime.realtime import die_with_parent
from gateway.runtime.regions import fds_from_text
from gateway.runtime.supervisor_client import ask

if TYPE_CHECKING:
    from gateway.northbound.opcua import OpcuaOut

NICE = 19
SAMPLE_S = 0.1
STATUS_S = 2.0


class Northside:
    """Everything of one run."""

    def __init__(self, plan: RunPlan, settings: Northbound, fds: dict[str, int]) -> None:
        self.plan, self.settings = plan, settings
        self.regions = Regions(plan, fds)
        self.metrics = Metrics(self.regions)
        self.journal = Journal(plan.journal, "northbound")
        self._done = asyncio.Event()

    async def run(self) -> None:
        """Until SIGTERM."""
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, self._done.set)
        beats = asyncio.create_task(self._beats())
        while self.regions.axes.read() is None and not self._done.is_set():
            await asyncio.sleep(SAMPLE_S)
        self.regions.look()
        tasks = [asyncio.create_task(part) for part in self._parts()]
        for task in tasks:
            task.add_done_callback(self._ended)
        await self._done.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        beats.cancel()
        self.journal.close()

    async def _beats(self) -> None:
        life = Life()
        while True:
            life.beat()
            await asyncio.sleep(BEAT_S)

    def _parts(self) -> list[Coroutine[object, object, None]]:
        settings = self.settings
        parts = [self._sample()]
        if settings.mqtt is not None:
            parts.append(self._mqtt())
        if settings.opcua is not None:
            parts.append(self._opcua())
        if settings.metrics is not None:
            parts += [self._serve_metrics(), self._ask_supervisor()]
        if settings.journald:
            parts.append(self._journald())
        return parts

    def _ended(self, task: "asyncio.Task[None]") -> None:
        """One part failed: the complete process ends, and the supervisor restarts it."""
        if not task.cancelled() and (error := task.exception()) is not None:
            self.journal.write("alarm", f"northbound: {type(error).__name__}: {error}")
            self._done.set()

    async def _sample(self) -> None:
        while True:
            self.regions.look()
            self.metrics.sample()
            await asyncio.sleep(SAMPLE_S)

    async def _mqtt(self) -> None:
        from gateway.northbound.mqtt import MqttOut

        assert self.settings.mqtt is not None
        folder = pathlib.Path(self.plan.cell.file).parent
        out = MqttOut(self.settings.mqtt, self.plan.slug, folder, asyncio.get_running_loop())
        self.metrics.outbox = lambda: {
            "connected": float(out.connected), "waiting": float(len(out.box)), "dropped_total": float(out.box.dropped)
        }  # fmt: skip
        out.start()
        try:
            while True:
                out.publish(values(self.regions))
                await asyncio.sleep(self.settings.period_ms / 1e3)
        finally:
            out.close()

    async def _opcua(self) -> None:
        assert self.settings.opcua is not None
        while not self.regions.status and not self._done.is_set():
            await asyncio.sleep(SAMPLE_S)  # the command sources are named by the services
        out = await patiently(f"OPC UA on {self.settings.opcua.bind}", self._opcua_started, self._alarm)
        assert out is not None
        try:
            while True:
                await out.publish(values(self.regions), stale=not self.regions.head()["cycle_alive"])
                await asyncio.sleep(self.settings.period_ms / 1e3)
        finally:
            await out.stop()

    async def _opcua_started(self) -> "OpcuaOut":
        from gateway.northbound.opcua import OpcuaOut

        assert self.settings.opcua is not None
        out = OpcuaOut(self.settings.opcua, self.plan.slug, self.plan.cell.cell.name)
        try:
            await out.start(values(self.regions))
        except OSError:
            with contextlib.suppress(Exception):  # half started: stop what has begun; report only the first reason
                await out.stop()
            raise
        return out

    def _alarm(self, text: str) -> None:
        self.journal.write("alarm", text)

    async def _serve_metrics(self) -> None:
        assert self.settings.metrics is not None
        host, port = place_of(self.settings.metrics.bind)
        server = await patiently(f"metrics on {self.settings.metrics.bind}", lambda: self.metrics.serve(host, port), self._alarm)
        assert server is not None
        async with server:
            await server.serve_forever()

    async def _ask_supervisor(self) -> None:
        while True:
            with contextlib.suppress(OSError, ValueError, PortError):
                self.metrics.processes = await asyncio.to_thread(self._processes)
            await asyncio.sleep(STATUS_S)

    def _processes(self) -> list[dict[str, object]]:
        with ask(self.plan.slug, "status", 1.0) as connection:
            status = json.loads(connection.makefile().readline())
        return [each for each in status["processes"] if isinstance(each, dict)]

    async def _journald(self) -> None:
        out = Journald(self.plan.journal, self.plan.slug)
        if not there():
            self.journal.write("northbound", "no journald on this computer; the journal of the run is kept in its file")
        try:
            while True:
                out.look()
                await asyncio.sleep(SAMPLE_S)
        finally:
            out.close()


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate northbound process", description="the northbound process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    plan = load_plan(arguments.plan)
    assert plan.cell.northbound is not None
    os.nice(NICE)
    asyncio.run(Northside(plan, plan.cell.northbound, fds_from_text(arguments.fds)).run())
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
