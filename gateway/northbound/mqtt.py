"""Publishes changed values to a broker, at least once, stored while it is away (AX-428).  paho-mqtt runs the protocol in a thread of its
own.
"""

import asyncio
import importlib
import json
import pathlib
import time
from typing import Any

from gateway.northbound.snapshot import Value
from gateway.pure.cell.northbound import NorthMqtt, place_of
from gateway.pure.reports.outbox import Outbox
from gateway.runtime.clock import wall

paho: Any = importlib.import_module("paho.mqtt.client")  # its stubs are those of version 1
RETAINED_S = 1.0  # the broker keeps a message with all values; after a change it is renewed within this
KEPT, PASSING = "+-"  # how a message in the outbox begins: the broker retains it, or passes it on only
WHOLE_EVERY = 60  # messages: one with all values, for subscribers that joined late or missed some
RECONNECT_S = (1, 8)


class MqttOut:
    """One broker.  All methods are called by the loop of the process."""

    def __init__(self, settings: NorthMqtt, slug: str, folder: pathlib.Path, loop: asyncio.AbstractEventLoop) -> None:
        self.box = Outbox(settings.keep)
        self.connected = False
        self.topic = f"{settings.topic}/{slug}"
        self._loop, self._last, self._numbers = loop, dict[str, Value](), dict[int, int]()
        self._dropped, self._since_whole = 0, WHOLE_EVERY
        self._whole_at = 0.0
        self._client = paho.Client(paho.CallbackAPIVersion.VERSION2, client_id=f"axisgate-{slug}", clean_session=True)
        self._client.max_inflight_messages_set(self.box.window)
        self._client.reconnect_delay_set(*RECONNECT_S)
        self._client.will_set(f"{self.topic}/state", "offline", qos=1, retain=True)
        if settings.user:
            secret = (folder / settings.password_file).read_text().strip() if settings.password_file else None
            self._client.username_pw_set(settings.user, secret)
        if settings.tls_ca:
            self._client.tls_set(ca_certs=str(folder / settings.tls_ca))
        self._client.on_connect = lambda _c, _u, _f, reason, _p: self._soon(self._on_connect, not reason.is_failure)
        self._client.on_disconnect = lambda *_: self._soon(self._on_disconnect)
        self._client.on_publish = lambda _c, _u, mid, *_: self._soon(self._on_confirmed, mid)
        self._place = place_of(settings.broker)

    def start(self) -> None:
        """Connects, and again whenever the broker went away; never waits for it."""
        self._client.connect_async(*self._place, keepalive=10)
        self._client.loop_start()

    def publish(self, values: dict[str, Value]) -> None:
        """Compare all values: the changed ones become one message."""
        now = time.monotonic()
        behind = self._since_whole > 0 and now - self._whole_at >= RETAINED_S  # the broker's retained values are old
        whole = self._since_whole >= WHOLE_EVERY or self.box.dropped != self._dropped or behind
        news = values if whole else {name: value for name, value in values.items() if self._last.get(name) != value}
        self._last = dict(values)
        if news:
            self._since_whole, self._dropped = 0 if whole else self._since_whole + 1, self.box.dropped
            number = self.box.number + 1
            if whole:
                self._whole_at = now
            message = {"n": number, "wall": wall(), "dropped": self.box.dropped, "values": news}
            self.box.put(number, (KEPT if whole else PASSING) + json.dumps(message, ensure_ascii=False))
        self._send()

    def close(self) -> None:
        """Disconnects cleanly if connected."""
        if self.connected:
            self._client.publish(f"{self.topic}/state", "offline", qos=1, retain=True).wait_for_publish(1.0)
        self._client.disconnect()
        self._client.loop_stop()

    def _send(self) -> None:
        while self.connected and (message := self.box.next()) is not None:
            number, text = message
            retain = text[0] == KEPT
            self._numbers[self._client.publish(f"{self.topic}/values", text[1:], qos=1, retain=retain).mid] = number

    def _soon(self, what: Any, *arguments: Any) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(what, *arguments)

    def _on_connect(self, good: bool) -> None:
        self.connected = good
        if good:
            self._client.publish(f"{self.topic}/state", "online", qos=1, retain=True)
            self._send()

    def _on_disconnect(self) -> None:
        self.connected = False  # paho sends pending messages again when the broker is back

    def _on_confirmed(self, mid: int) -> None:
        number = self._numbers.pop(mid, None)
        if number is not None:
            self.box.confirmed(number)
            self._send()
