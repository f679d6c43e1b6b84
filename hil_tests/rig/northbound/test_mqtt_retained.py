"""Who subscribes late hears all values at once: the broker keeps the last message with all of them (AX-643); mosquitto is the judge."""

import asyncio
import importlib
import json
import pathlib
import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from gateway.northbound.mqtt import MqttOut
from gateway.northbound.snapshot import Value
from gateway.pure.cell.northbound import NorthMqtt
from hil_tests.lab.running.cell_running import free_port

paho: Any = importlib.import_module("paho.mqtt.client")  # its stubs are those of version 1
MOSQUITTO = shutil.which("mosquitto") or "/usr/sbin/mosquitto"


@pytest.fixture
def broker() -> Iterator[int]:
    port = free_port()
    process = subprocess.Popen([MOSQUITTO, "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 20
    while socket.socket().connect_ex(("127.0.0.1", port)):
        assert time.monotonic() < end, "mosquitto does not listen within 20 s"
        time.sleep(0.05)
    yield port
    process.kill()
    process.wait()


async def until(holds: Callable[[], object], what: str) -> None:
    end = time.monotonic() + 20
    while not holds():
        assert time.monotonic() < end, f"not within 20 s: {what}"
        await asyncio.sleep(0.02)


def test_a_late_subscriber_gets_every_value_as_it_is_now(broker: int, tmp_path: pathlib.Path) -> None:
    heard: list[tuple[bool, dict[str, Any]]] = []

    async def play() -> None:
        out = MqttOut(NorthMqtt(f"127.0.0.1:{broker}", "plant"), "hall3", tmp_path, asyncio.get_running_loop())
        out.start()
        values: dict[str, Value] = {f"axis.A{n}.actual": 0.0 for n in range(1, 7)}
        out.publish(values)
        await until(lambda: out.connected and not len(out.box), "the first message")
        for n in range(5):  # changes of one value, and the other ones stay
            values = {**values, "axis.A6.actual": float(n)}
            out.publish(values)
            await asyncio.sleep(0.02)
        end = time.monotonic() + 1.5
        while time.monotonic() < end:  # nothing changes any more
            out.publish(values)
            await asyncio.sleep(0.05)
        await until(lambda: not len(out.box), "everything is taken")
        eyes: Any = paho.Client(paho.CallbackAPIVersion.VERSION2)
        eyes.on_connect = lambda client, *_: client.subscribe("plant/hall3/values", qos=1)
        eyes.on_message = lambda _client, _userdata, message: heard.append((message.retain, json.loads(message.payload)))
        eyes.connect("127.0.0.1", broker)
        eyes.loop_start()
        await until(lambda: heard, "what the broker keeps")
        eyes.disconnect()
        eyes.loop_stop()
        out.close()

    asyncio.run(play())
    retained, message = heard[0]
    assert retained and message["values"] == {**{f"axis.A{n}.actual": 0.0 for n in range(1, 6)}, "axis.A6.actual": 4.0}
