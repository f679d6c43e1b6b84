"""Northbound of a running cell, judged by others: mosquitto, asyncua's client, a reader of Prometheus' text rules (AX-427 to AX-430)."""

import asyncio
import contextlib
import importlib
import json
import os
import re
import shutil
import signal
import subprocess
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import asyncua
import pytest
from asyncua.client.client import Client

from gateway.pure.image.records.cell import unpack_cell_state
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.tools.client import ToolClient
from hil_tests.lab.running.cell_running import free_port
from hil_tests.lab.running.joined_running import JoinedRun, cell_copy, running_joined

paho: Any = importlib.import_module("paho.mqtt.client")
ua: Any = asyncua.ua
MOSQUITTO = shutil.which("mosquitto") or "/usr/sbin/mosquitto"
PATIENCE_S = 30.0
NAME = "north"
KEEP = 8
MORE = """
[northbound]
period_ms = 100
[northbound.mqtt]
broker = "127.0.0.1:{broker}"
topic = "plant/hall3"
keep = {keep}
[northbound.opcua]
bind = "127.0.0.1:{opcua}"
[northbound.metrics]
bind = "127.0.0.1:{metrics}"
"""


def until(condition: Callable[[], object], what: str) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, f"not within {PATIENCE_S:g} s: {what}"
        time.sleep(0.02)


@dataclass
class Broker:
    """mosquitto, that can be stopped and started again, and what a subscriber of it heard."""

    port: int
    process: subprocess.Popen[bytes] | None = None
    messages: list[dict[str, Any]] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    subscriber: Any = None

    def start(self) -> None:
        self.process = subprocess.Popen([MOSQUITTO, "-p", str(self.port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        heard = threading.Event()
        self.subscriber = paho.Client(paho.CallbackAPIVersion.VERSION2)
        self.subscriber.on_message = self._on_message
        self.subscriber.on_connect = lambda client, *_: client.subscribe("plant/hall3/#", qos=1)
        self.subscriber.on_subscribe = lambda *_: heard.set()

        def connected() -> bool:
            with contextlib.suppress(OSError):
                self.subscriber.connect("127.0.0.1", self.port)
                return True
            return False

        until(connected, "mosquitto listens")
        self.subscriber.loop_start()
        assert heard.wait(PATIENCE_S)

    def _on_message(self, client: object, userdata: object, message: Any) -> None:
        if message.topic == f"plant/hall3/{NAME}/values":
            self.messages.append(json.loads(message.payload))
        elif message.topic == f"plant/hall3/{NAME}/state":
            self.states.append(message.payload.decode())

    def stop(self) -> None:
        if self.process is not None:
            self.subscriber.disconnect()
            self.subscriber.loop_stop()
            self.process.kill()
            self.process.wait()
            self.process = None


@dataclass
class North:
    """The run and who looks at it from above."""

    run: JoinedRun
    broker: Broker
    opcua: int
    metrics: int

    def get(self, path: str) -> tuple[int, str, str]:
        """Status, content type, body."""
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{self.metrics}{path}", timeout=10) as answer:
                return answer.status, answer.headers["Content-Type"], answer.read().decode()
        except urllib.error.HTTPError as answer:
            return answer.code, answer.headers["Content-Type"], answer.read().decode()

    def metric(self, name: str) -> float:
        found = {sample: value for sample, value in parsed(self.get("/metrics")[2]).items() if sample[0] == name}
        assert len(found) == 1, (name, found)
        return next(iter(found.values()))

    def pid(self, name: str) -> int:
        with ask(NAME, "status") as connection:
            status = json.loads(connection.makefile().readline())
        return next(int(each["pid"] or 0) for each in status["processes"] if each["name"] == name)


SAMPLE = re.compile(r'([a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{((?:[a-zA-Z_]\w*="(?:[^"\\\n]|\\\\|\\"|\\n)*",?)*)\})? (\S+)')


def parsed(text: str) -> dict[tuple[str, str], float]:
    """Every sample of a page; asserts the rules of the text format 0.0.4: one HELP and TYPE before each family, families together."""
    assert text.endswith("\n")
    samples: dict[tuple[str, str], float] = {}
    kinds: dict[str, str] = {}
    family = ""
    for line in text.splitlines():
        if line.startswith("# HELP "):
            family = line.split(" ")[2]
            assert family not in kinds and len(line.split(" ")) > 3, line
        elif line.startswith("# TYPE "):
            _, _, name, kind = line.split(" ")
            assert name == family and kind in ("gauge", "counter", "histogram"), line
            kinds[name] = kind
        else:
            match = SAMPLE.fullmatch(line)
            assert match is not None, line
            name, with_, value = match[1], match[2] or "", float(match[3])
            bare = re.sub(r"_(bucket|sum|count)$", "", name) if kinds[family] == "histogram" else name
            assert bare == family and (name, with_) not in samples, line
            assert kinds[family] != "counter" or (name.endswith("_total") and value >= 0), line
            samples[name, with_] = value
    for name in (name for name, kind in kinds.items() if kind == "histogram"):
        buckets = [value for (sample, _), value in samples.items() if sample == f"{name}_bucket"]
        assert buckets == sorted(buckets) and buckets[-1] == samples[f"{name}_count", ""]
    return samples


@pytest.fixture(scope="module")
def north() -> Iterator[North]:
    broker, opcua, metrics = Broker(free_port()), free_port(), free_port()
    more = MORE.format(broker=broker.port, keep=KEEP, opcua=opcua, metrics=metrics)
    with running_joined(lambda folder: cell_copy("host-telegrams", folder, more=more), NAME) as run:
        try:
            yield North(run, broker, opcua, metrics)
        finally:
            broker.stop()


def test_metrics_are_what_prometheus_reads_and_count_what_happens(north: North) -> None:
    def up() -> bool:
        with contextlib.suppress(OSError):
            return north.metric("axisgate_cycle_cycles_total") > 0
        return False

    until(up, "metrics are served")
    until(lambda: ("axisgate_process_up", 'process="cycle"') in parsed(north.get("/metrics")[2]), "the supervisor was asked")
    status, kind, body = north.get("/metrics")
    samples = parsed(body)
    assert (status, kind) == (200, "text/plain; version=0.0.4; charset=utf-8")
    assert samples["axisgate_cycle_alive", ""] == 1 and samples["axisgate_services_alive", ""] == 1
    assert samples["axisgate_link_up", 'command_source="V24_1",kind="line"'] == 0, "no host is there"
    assert samples["axisgate_process_up", 'process="northbound"'] == 1
    until(
        lambda: north.metric("axisgate_cycle_compute_seconds_count") > samples["axisgate_cycle_compute_seconds_count", ""], "it counts on"
    )
    assert north.metric("axisgate_cycle_cycles_total") > samples["axisgate_cycle_cycles_total", ""]


def test_health_and_ready_say_why(north: North) -> None:
    until(lambda: north.get("/health")[0] == 200, "healthy")
    assert json.loads(north.get("/health")[2]) == {"healthy": True, "cycle_alive": True, "services_alive": True, "down": []}
    status, kind, body = north.get("/ready")
    assert kind == "application/json" and status == (200 if json.loads(body)["ready"] else 503)
    assert north.get("/other")[0] == 404
    with pytest.raises(urllib.error.HTTPError, match="405"):
        urllib.request.urlopen(urllib.request.Request(f"http://127.0.0.1:{north.metrics}/metrics", data=b"x"), timeout=10)


def test_a_broker_that_was_away_gets_what_was_kept_and_how_much_was_dropped(north: North) -> None:
    until(lambda: north.metric("axisgate_mqtt_waiting") >= 1, "the first message waits for a broker that is not there")
    until(lambda: toggled(north) and north.metric("axisgate_mqtt_dropped_total") > 3, "more than it keeps")
    assert north.metric("axisgate_mqtt_dropped_total") > 3 and north.metric("axisgate_mqtt_waiting") == KEEP
    north.broker.start()
    until(lambda: north.metric("axisgate_mqtt_waiting") == 0, "everything kept was taken")
    until(lambda: len(north.broker.messages) >= KEEP, "and heard by a subscriber")
    numbers = [message["n"] for message in north.broker.messages]
    assert numbers == sorted(numbers) and numbers[0] > 3, "in their order, the oldest dropped"
    assert numbers[:KEEP] == list(range(numbers[0], numbers[0] + KEEP)), "and only the oldest"
    until(lambda: "online" in north.broker.states, "it says that it is there")
    toggled(north)
    until(lambda: north.broker.messages[-1]["dropped"] > 3, "the loss is told")
    whole = next(message["values"] for message in reversed(north.broker.messages) if "axis.A1.actual" in message["values"])
    assert {"cell.ready", "cell.override", "axis.A1.enabled", "command_source.V24_1.alive", "error.first.code"} <= set(whole)


def toggled(north: North) -> bool:
    """Control is asked for and ends with its connection: looks find another owner, twice."""
    with contextlib.closing(ToolClient(north.run.name)) as tool:
        tool.command("request_control")
        time.sleep(0.1)
    time.sleep(0.1)
    return True


def served(north: North) -> bool:
    with contextlib.suppress(OSError):
        return north.get("/health")[0] == 200
    return False


def cycles(run: JoinedRun) -> int:
    """SYNC sent so far."""
    with ask(run.name, "regions") as connection:
        fds = recv_fds(connection)
    try:
        payload = RegionReader(fds["axes"], "axes").read()
    finally:
        for fd in fds.values():
            os.close(fd)
    assert payload is not None
    return unpack_cell_state(payload).cycle


def test_an_opc_ua_client_reads_browses_and_subscribes_and_cannot_write(north: North) -> None:
    until(lambda: served(north), "the process is there")
    asyncio.run(asyncio.wait_for(_opcua(north), 60))


async def _opcua(north: North) -> None:
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            async with Client(f"opc.tcp://127.0.0.1:{north.opcua}/axisgate", timeout=10) as client:
                await _looked_at(client, north)
                return
        except (ConnectionError, OSError):
            assert time.monotonic() < end, "no OPC UA server"
            await asyncio.sleep(0.1)


async def _looked_at(client: Client, north: North) -> None:
    space = await client.get_namespace_index("urn:axisgate")
    folder = await client.nodes.objects.get_child([f"{space}:axisgate", f"{space}:{NAME}"])
    names = {(await node.read_browse_name()).Name for node in await folder.get_children()}
    assert {"cell.ready", "cell.override", "axis.A1.actual", "axis.A1.fault", "command_source.V24_1.alive"} <= names
    node: Any = client.get_node(ua.NodeId("axis.A1.actual", space))
    value = await node.read_data_value()
    assert value.StatusCode.is_good() and isinstance(value.Value.Value, float)
    with pytest.raises(ua.UaStatusCodeError):
        await node.write_value(1.0)
    heard: list[Any] = []

    class Handler:
        def datachange_notification(self, node: object, value: object, data: object) -> None:
            heard.append(value)

    subscription = await client.create_subscription(50, Handler())
    await subscription.subscribe_data_change(client.get_node(ua.NodeId("cell.cycle_alive", space)))
    end = time.monotonic() + PATIENCE_S
    while not heard:
        assert time.monotonic() < end
        await asyncio.sleep(0.02)
    assert heard[0] is True


def test_a_broker_that_hangs_or_dies_is_never_felt_below(north: North) -> None:
    if north.broker.process is None:
        north.broker.start()
    until(lambda: north.metric("axisgate_mqtt_connected") == 1, "connected")
    assert north.broker.process is not None
    os.kill(north.broker.process.pid, signal.SIGSTOP)
    before = cycles(north.run)
    until(lambda: cycles(north.run) > before + 50, "the cycle goes on beside a broker that hangs")
    os.kill(north.broker.process.pid, signal.SIGCONT)
    os.kill(north.pid("northbound"), signal.SIGSTOP)
    before = cycles(north.run)
    until(lambda: cycles(north.run) > before + 50, "and beside a northbound process that hangs")
    os.kill(north.pid("northbound"), signal.SIGKILL)
    until(lambda: served(north), "the supervisor starts it again")
