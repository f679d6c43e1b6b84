"""The buses of a run as a listener sees them: rates, periods, load, decoded frames.  Open only while a page looks."""

import asyncio
import time
from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from drivers.ports.base import CanPort, PortError
from drivers.ports.can.open import open_can
from gateway.pure.cell.cell import Bus
from gateway.registry import BUS_PROTOCOLS
from gateway.web.german import says
from protocols.base.can_bits import frame_bits
from protocols.base.machine import Frame, Ns

if TYPE_CHECKING:
    from gateway.files.frame_decoder import Decode

KEPT = 80  # frames of the list
RATE_NS: Ns = 1_000_000_000  # rates and load over this window
AGAIN_S = 1.0
Row = dict[str, Any]


@dataclass(slots=True)
class Identifier:
    """Statistics of one identifier."""

    count: int = 0
    last: Frame | None = None
    shortest: Ns = 0
    longest: Ns = 0
    counted: int = 0  # at the beginning of the window
    rate: float = 0.0

    def take(self, frame: Frame) -> None:
        if self.last is not None:
            gap = frame.stamp_ns - self.last.stamp_ns
            self.shortest = min(self.shortest or gap, gap)
            self.longest = max(self.longest, gap)
        self.count, self.last = self.count + 1, frame


@dataclass(slots=True)
class BusView:
    """One bus."""

    bus: Bus
    url: str
    port: CanPort | None = None
    why: str = "not opened yet"
    seen: dict[int, Identifier] = field(default_factory=dict)
    recent: deque[Frame] = field(default_factory=lambda: deque(maxlen=KEPT))
    faults: int = 0
    started: float = 0.0
    _decode: "Decode | None" = None
    _window: float = 0.0
    _next_try: float = 0.0

    def open(self) -> None:
        """Listen; a bus that is away is tried again each second."""
        now = time.monotonic()
        if self.port is not None or now < self._next_try:
            return
        self._next_try = now + AGAIN_S
        try:
            self.port = open_can(self.url)
        except PortError as error:
            self.why = str(error)
            return
        self.why, self.started, self._window = "", now, now
        self.seen.clear()
        self.recent.clear()
        asyncio.get_running_loop().add_reader(self.port.fileno(), self._hear)

    def close(self) -> None:
        if self.port is not None:
            asyncio.get_running_loop().remove_reader(self.port.fileno())
            self.port.close()
            self.port = None
            self.why = "not opened yet"

    def _hear(self) -> None:
        assert self.port is not None
        try:
            frames = self.port.receive()
            self.faults += len(self.port.take_faults())
        except PortError as error:
            self.close()
            self.why = str(error)
            return
        for frame in frames:
            self.seen.setdefault(frame.identifier, Identifier()).take(frame)
        self.recent.extend(frames)

    def row(self) -> Row:
        """Rows of the page."""
        from gateway.assembly.bus_frames import bitrate
        from gateway.files.frame_decoder import named  # the decoders' libraries take half a second to load: only when somebody looks

        now = time.monotonic()
        if now - self._window >= RATE_NS / 1e9:
            for one in self.seen.values():
                one.rate, one.counted = (one.count - one.counted) / (now - self._window), one.count
            self._window = now
        decode = self._decoder()
        bits = sum(one.rate * frame_bits(one.last.identifier & 0x1FFFFFFF, one.last.data) for one in self.seen.values() if one.last)
        rows = [
            {
                "id": named(identifier),
                "count": one.count,
                "rate": round(one.rate, 1),
                "min_ms": round(one.shortest / 1e6, 2),
                "max_ms": round(one.longest / 1e6, 2),
                "data": one.last.data.hex(" ") if one.last else "",
                "say": says(decode(one.last)) if one.last else ["", ""],
            }
            for identifier, one in sorted(self.seen.items())
        ]
        first = self.recent[0].stamp_ns if self.recent else 0
        frames = [
            [round((frame.stamp_ns - first) / 1e6, 3), named(frame.identifier), frame.data.hex(" "), says(decode(frame))]
            for frame in list(self.recent)[-40:]
        ]
        return {
            "name": self.bus.name,
            "protocol": self.bus.protocol,
            "bitrate": self.bus.bitrate,
            "url": self.url,
            "open": self.port is not None,
            "why": says(self.why),
            "load": round(100.0 * bits / bitrate(self.bus), 1),
            "rate": round(sum(one.rate for one in self.seen.values())),
            "faults": self.faults,
            "seconds": round(now - self.started) if self.port else 0,
            "rows": rows,
            "frames": frames,
        }

    def _decoder(self) -> "Decode":
        if self._decode is None:
            from gateway.files.frame_decoder import decoder

            canopen = BUS_PROTOCOLS[self.bus.protocol].nodes
            self._decode = decoder(None if canopen else self.bus.layout, canopen=canopen)
        return self._decode
