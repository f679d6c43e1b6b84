"""/metrics for Prometheus, /health and /ready for service monitors: GET only, one answer a connection (AX-430)."""

import asyncio
import contextlib
import json
from collections.abc import Callable
from typing import Any

from gateway.northbound.snapshot import FLAGS, sources
from gateway.observer.regions import Regions
from gateway.pure.reports.prometheus import CONTENT_TYPE, Histogram, Page

BORDERS_S = (50e-6, 100e-6, 200e-6, 400e-6, 800e-6, 1.6e-3, 3.2e-3, 6.4e-3, 12.8e-3)
REQUEST_BYTES, REQUEST_S = 4096, 2.0
CONNECTIONS = 16
Answer = tuple[int, str, str]  # status, content type, body
PHRASES = {200: "OK", 404: "Not Found", 405: "Method Not Allowed", 400: "Bad Request", 503: "Service Unavailable"}


class Metrics:
    """Numbers of one run."""

    def __init__(self, regions: Regions) -> None:
        self._regions = regions
        self.compute = Histogram(BORDERS_S)
        self.processes: list[dict[str, Any]] = []  # as the supervisor reported them last
        self.outbox: Callable[[], dict[str, float]] = dict  # of the broker, where there is one
        self._cycle = -1

    def sample(self) -> None:
        """Ten times a second: the last cycle's time, once for each cycle seen."""
        state = self._regions.state
        if state.cycle != self._cycle and self._regions.head()["cycle_alive"]:
            self._cycle = state.cycle
            self.compute.see(state.compute_ns / 1e9)

    def health(self) -> tuple[bool, dict[str, Any]]:
        """Healthy: cycle and services live, and nothing stays down."""
        head = self._regions.head()
        down = [str(process.get("name")) for process in self.processes if process.get("state") == "down"]
        good = bool(head["cycle_alive"] and head["services_alive"] and not down)
        return good, {"healthy": good, "cycle_alive": head["cycle_alive"], "services_alive": head["services_alive"], "down": down}

    def ready(self) -> tuple[bool, dict[str, Any]]:
        """Ready: healthy, and the cell is ready."""
        healthy, facts = self.health()
        head = self._regions.head()
        good = healthy and bool(head["ready"])
        return good, {**facts, "ready": good, "emergency": head["emergency"], "errors": head["errors"]}

    def page(self) -> str:
        """The answer to /metrics."""
        regions, page = self._regions, Page()
        head, counters, (cycle_ms, services_ms) = regions.head(), regions.counters(), regions.ages()
        flags = [(name, head[name]) for name in ("cycle_alive", "services_alive", "ready", "emergency")]
        for name, value in flags:
            page.metric(f"axisgate_{name}", "gauge", f"1: {name.replace('_', ' ')}", [({}, float(bool(value)))])
        page.metric("axisgate_cycle_age_seconds", "gauge", "since the cycle showed life", [({}, cycle_ms / 1e3)])
        page.metric("axisgate_services_age_seconds", "gauge", "since the services showed life", [({}, services_ms / 1e3)])
        for name, words in (
            ("cycles", "SYNC sent since the cycle started"),
            ("skipped", "grid instants without SYNC"),
            ("incomplete", "cycles in which an actual value was missing"),
            ("late", "telegrams that arrived one cycle late"),
            ("services_lost", "times the life of the services stood still"),
        ):
            page.metric(f"axisgate_cycle_{name}_total", "counter", words, [({}, float(counters[name]))])
        page.histogram("axisgate_cycle_compute_seconds", "time of a cycle to its set values, sampled ten times a second", self.compute)
        self._axes(page)
        self._links(page)
        page.metric("axisgate_errors", "gauge", "active errors", [({}, float(len(head["errors"])))])
        page.metric("axisgate_error", "gauge", "1: this error is pending", _errors(head["errors"]))
        queue = regions.queue()
        page.metric("axisgate_planner_waiting", "gauge", "blocks that wait", [({}, float(queue["waiting"]))] if queue else [])
        for name, value in self.outbox().items():
            kind = "counter" if name.endswith("_total") else "gauge"
            page.metric(f"axisgate_mqtt_{name}", kind, "messages to the broker", [({}, value)])
        up = [({"process": str(each["name"])}, float(each.get("state") == "up")) for each in self.processes]
        again = [({"process": str(each["name"])}, float(each.get("restarts", 0))) for each in self.processes]
        page.metric("axisgate_process_up", "gauge", "1: the process runs", up)
        page.metric("axisgate_process_restarts_total", "counter", "times it was started again", again)
        return page.text()

    def _axes(self, page: Page) -> None:
        """Values of every axis of the cell; positions in its own unit."""
        units = {name: {"axis": name, "unit": unit} for name, unit, _ in self._regions.facts}
        rows = self._regions.drives()
        for name, words in (("actual", "position"), ("set", "set position"), ("lag", "position lag"), ("speed", "of the axis, per second")):
            per = "/s" if name == "speed" else ""
            labels = {axis: {**label, "unit": label["unit"] + per} for axis, label in units.items()}
            page.metric(f"axisgate_axis_{name}", "gauge", words, [(labels[row["name"]], float(row[name])) for row in rows])
        own = [({"axis": str(row["name"])}, row) for row in rows]
        page.metric(
            "axisgate_axis_torque_percent", "gauge", "share of the rated torque", [(axis, float(row["torque"])) for axis, row in own]
        )
        page.metric("axisgate_axis_fault_code", "gauge", "of the drive, 0: none", [(axis, float(row["fault"])) for axis, row in own])
        for name, flag in FLAGS.items():
            page.metric(f"axisgate_axis_{name}", "gauge", f"1: {name}", [(axis, float(bool(row["flags"] & flag))) for axis, row in own])

    def _links(self, page: Page) -> None:
        listed = sources(self._regions)
        for name, key, kind, words in (
            ("link_up", "alive", "gauge", "1: the partner of this command source lives"),
            ("link_losses_total", "losses", "counter", "times the partner fell silent"),
            ("link_requests_total", "requests", "counter", "requests of a Modbus server"),
            ("link_received_total", "received", "counter", "telegrams taken"),
            ("link_refused_total", "refused", "counter", "telegrams refused"),
            ("link_sent_total", "sent", "counter", "telegrams sent"),
            ("link_failed_total", "failed", "counter", "telegrams that could not be sent"),
        ):
            rows = [({"command_source": str(d["name"]), "kind": str(d.get("kind", ""))}, float(d[key])) for d in listed if key in d]
            page.metric(f"axisgate_{name}", kind, words, rows)

    # ---- HTTP --------------------------------------------------------------------------------------------------------
    def answer(self, request: bytes) -> Answer:
        """One request, its first line."""
        words = request.split(b"\r\n", 1)[0].split(b" ")
        if len(words) != 3 or not words[2].startswith(b"HTTP/"):
            return 400, "text/plain", "a request of HTTP is expected\n"
        if words[0] != b"GET":
            return 405, "text/plain", "GET alone\n"
        match words[1].partition(b"?")[0]:
            case b"/metrics":
                return 200, CONTENT_TYPE, self.page()
            case b"/health":
                good, facts = self.health()
            case b"/ready":
                good, facts = self.ready()
            case _:
                return 404, "text/plain", "/metrics, /health and /ready are here\n"
        return 200 if good else 503, "application/json", json.dumps(facts, ensure_ascii=False) + "\n"

    async def serve(self, host: str, port: int) -> asyncio.Server:
        """OSError: the port is in use."""
        gate = asyncio.Semaphore(CONNECTIONS)

        async def one(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            with contextlib.suppress(OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
                async with asyncio.timeout(REQUEST_S):
                    request = await reader.readuntil(b"\r\n\r\n")  # an incomplete one delays no other
                    async with gate:
                        status, kind, text = self.answer(request)
                        body = text.encode()
                        head = f"HTTP/1.1 {status} {PHRASES[status]}\r\nContent-Type: {kind}\r\nContent-Length: {len(body)}\r\n"
                        writer.write(f"{head}Connection: close\r\n\r\n".encode() + body)
                        await writer.drain()
            writer.close()

        return await asyncio.start_server(one, host, port, limit=REQUEST_BYTES)


def _errors(errors: list[dict[str, Any]]) -> list[tuple[dict[str, str], float]]:
    codes = dict.fromkeys(str(error.get("code", 0)) for error in errors)
    return [({"code": code}, 1.0) for code in codes]
