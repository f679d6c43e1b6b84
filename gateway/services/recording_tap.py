"""The services' end of a recording: inputs of command sources and tools go into a ring, while a recorder runs."""

from collections.abc import Mapping

from gateway.pure.recording.messages import ASKED_LAYOUT, RECORDER_GONE, SERVICE_EVENT_LAYOUT, Source, pack_service_event
from gateway.runtime.regions import RegionReader, RingWriter
from protocols.base.machine import Ns


class ServicesTap:
    """Messages of command sources and tools; `put` returns at once without a recorder."""

    def __init__(self, fds: Mapping[str, int]) -> None:
        self._ring = RingWriter(fds["service_events"], "service_events", SERVICE_EVENT_LAYOUT)
        self._asked = RegionReader(fds["recorder"], "recorder", ASKED_LAYOUT)

    def put(self, now: Ns, source: Source, number: int, data: bytes) -> None:
        """Characters, octets, words or a request."""
        if not self._asked.published or now - self._asked.life[1] > RECORDER_GONE:
            return
        for record in pack_service_event(now, source, number, data):
            self._ring.put(record)
