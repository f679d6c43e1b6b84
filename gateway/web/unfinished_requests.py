"""Limits for requests that never end: each has five seconds for headers and body, and none blocks the place of another visitor (AX-613).

Visitors at the gateway itself are never refused: a manual stop must get through whatever others leave unfinished.  Where the places
are taken, the oldest unfinished request goes, those from elsewhere first.
"""

import asyncio
import time
from functools import partial
from socket import socket

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from gateway.web.access import is_local

REQUEST_S = 5.0  # from the first byte, or from the connection, to the last byte of the request; the same for a TLS handshake
PLACES = 150  # connections at once; beyond them the oldest unfinished one ends


class PatientHttp(H11Protocol):
    """One connection."""

    _timer: asyncio.TimerHandle | None = None
    _began = 0.0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # uvicorn narrows the transport
        super().connection_made(transport)
        if self.at_gateway:
            self.limit_concurrency = None
        self._begin()
        if len(self.connections) > PLACES:
            self._make_room()

    def connection_lost(self, exc: Exception | None) -> None:
        self._end()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        if self._timer is None:
            self._begin()
        super().data_received(data)
        self._look()

    def on_response_complete(self) -> None:
        super().on_response_complete()
        if self._timer is None and self.conn.trailing_data[0]:  # the next request has begun after this one
            self._begin()
            self._look()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """From now on a live connection: its request was complete, and h11 is no longer used."""
        self._end()
        super().handle_websocket_upgrade(event)

    @property
    def unfinished(self) -> float:
        """Since when its request is under way; 0: none is."""
        return self._began if self._timer is not None else 0.0

    @property
    def at_gateway(self) -> bool:
        """The visitor sits at this computer."""
        return self.client is not None and is_local(self.client[0])

    def give_up(self) -> None:
        """Without an answer: a client that did not finish its request does not listen."""
        self._end()
        self.transport.abort()

    def _begin(self) -> None:
        self._began = time.monotonic()
        self._timer = self.loop.call_later(REQUEST_S, self.give_up)

    def _end(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _look(self) -> None:
        """The request is complete or was refused."""
        if self.conn.their_state not in (h11.IDLE, h11.SEND_BODY):
            self._end()

    def _make_room(self) -> None:
        others = [each for each in self.connections if isinstance(each, PatientHttp) and each is not self and each.unfinished]
        if others:
            min(others, key=lambda each: (each.at_gateway, each.unfinished)).give_up()


class PatientServer(uvicorn.Server):
    """Ends TLS handshakes that do not end, too."""

    async def startup(self, sockets: list[socket] | None = None) -> None:
        if self.config.is_ssl:
            loop = asyncio.get_running_loop()
            setattr(loop, "create_server", partial(loop.create_server, ssl_handshake_timeout=REQUEST_S))  # noqa: B010
        await super().startup(sockets)
