"""Any CAN adapter supported by python-can as a CanPort: slcan, PCAN, Kvaser, socketcand, ...

Opening and reading such an adapter may block for as long as its library likes, and most of them have no descriptor to wait for.  So a
thread reads, and the cycle never opens this port: gateway.processes.can_adapter joins it to the local bus of the cycle (AX-435).
"""

import contextlib
import os
import socket
import threading
import time
from collections import deque
from collections.abc import Sequence

import can

from drivers.ports.base import PortError
from drivers.ports.can.adapter_url import Adapter, adapter_of
from drivers.ports.can.wire import CanCounters, check_frame
from protocols.base.machine import Frame, FrameFault, Ns

READ_S, SEND_S = 0.1, 0.1  # patience of one call into the library
BAD_IN_A_ROW = 50  # things the library could not read: then the adapter counts as gone
SAMPLES = 100  # of one figure of latency
MARK_OWN = ("kvaser", "vector", "nixnet", "etas", "virtual")  # return and mark own frames on request; others do so always or never
GOES_WRONG = (can.CanError, OSError, ImportError, ValueError, TypeError, NotImplementedError, AttributeError)
DEFAULTS: dict[str, dict[str, float]] = {
    "slcan": {"sleep_after_open": 0.0, "timeout": 0.02},  # 2 s for boards that restart when opened: ?sleep_after_open=2
}
LISTEN: dict[str, dict[str, object]] = {"slcan": {"listen_only": True}, "pcan": {"state": can.BusState.PASSIVE}}


class AdapterPort:
    """CanPort of one adapter.  Own frames are ignored except to measure latency."""

    def __init__(self, url: str, bitrate: int = 1_000_000, *, listen_only: bool = False) -> None:
        self.name = url
        self.counters = CanCounters()
        self.fd = 0  # frames of CAN FD among those ignored
        self.own_ns: list[Ns] = []  # from sending a frame until the adapter gave it back; the first SAMPLES
        self.answer_ns: list[Ns] = []  # from a burst to the first frame of another node; the first SAMPLES
        self._faults: list[tuple[FrameFault, Ns]] = []
        self._waiting: deque[tuple[can.Message, Ns]] = deque()
        self._on_their_way: deque[tuple[int, bytes, Ns]] = deque(maxlen=256)
        self._burst_ns = 0  # 0: it was answered
        self._gone: Exception | None = None
        self._closing = False
        self._bus = _open(url, adapter_of(url), bitrate, listen_only=listen_only)
        self._more = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._thread = threading.Thread(target=self._read, name=f"reads {url}", daemon=True)
        self._thread.start()

    def fileno(self) -> int:
        return self._more

    def send(self, frames: Sequence[Frame]) -> int:
        """Number of frames accepted, in order; the library may take SEND_S for each.  PortError when the adapter is gone."""
        for frame in frames:
            check_frame(frame)
        if self._gone is not None:
            raise self._lost(self._gone)
        self._burst_ns = time.monotonic_ns() if len(self.answer_ns) < SAMPLES else 0
        for taken, (identifier, data, _) in enumerate(frames):
            self._on_their_way.append((identifier, bytes(data), time.monotonic_ns()))
            try:
                self._bus.send(can.Message(arbitration_id=identifier, is_extended_id=False, data=data), SEND_S)
            except can.CanTimeoutError:
                self.counters.sent += taken
                self.counters.refused += len(frames) - taken
                return taken
            except GOES_WRONG as error:
                raise self._lost(error) from error
        self.counters.sent += len(frames)
        return len(frames)

    def receive(self) -> list[Frame]:
        """All waiting frames, stamped when read; PortError when the adapter is gone."""
        with contextlib.suppress(BlockingIOError):
            os.eventfd_read(self._more)
        frames: list[Frame] = []
        while self._waiting:
            message, now = self._waiting.popleft()
            if message.is_error_frame:
                self.counters.faults += 1
                self._faults.append((FrameFault.OTHER, now))
            elif not message.is_rx:
                self._echo(message, now)
            elif message.is_extended_id or message.is_remote_frame or message.is_fd:
                self.counters.ignored += 1
                self.fd += message.is_fd
            else:
                frames.append(Frame(message.arbitration_id, bytes(message.data), now))
        if frames and self._burst_ns and frames[-1].stamp_ns > self._burst_ns:
            first = next(frame.stamp_ns for frame in frames if frame.stamp_ns > self._burst_ns)
            self.answer_ns.append(first - self._burst_ns)
            self._burst_ns = 0
        self.counters.received += len(frames)
        if self._gone is not None and not frames:
            raise self._lost(self._gone)
        return frames

    def _echo(self, message: can.Message, now: Ns) -> None:
        while self._on_their_way:
            identifier, data, sent = self._on_their_way.popleft()
            if (identifier, data) == (message.arbitration_id, bytes(message.data)):
                if len(self.own_ns) < SAMPLES:
                    self.own_ns.append(now - sent)
                return

    def receive_next(self) -> list[Frame]:
        """Everything: to leave some of it would be no cheaper here."""
        return self.receive()

    def take_faults(self) -> list[tuple[FrameFault, Ns]]:
        faults, self._faults = self._faults, []
        return faults

    def close(self) -> None:
        self._closing = True
        self._thread.join(5.0)
        with contextlib.suppress(*GOES_WRONG):
            self._bus.shutdown()
        if self._more >= 0:
            os.close(self._more)
            self._more = -1

    def _read(self) -> None:
        with contextlib.suppress(OSError):  # as urgent as its process; a new thread does not inherit that
            os.sched_setscheduler(0, os.sched_getscheduler(os.getpid()), os.sched_getparam(os.getpid()))
        bad = 0
        while not self._closing:
            try:
                message = self._bus.recv(READ_S)
                bad = 0
            except (can.CanError, OSError) as error:
                self._gone = error
            except (ValueError, IndexError, TypeError, AttributeError) as error:  # half a line of an adapter that was just plugged in
                self.counters.ignored += 1
                bad += 1
                message, self._gone = None, error if bad >= BAD_IN_A_ROW else None
            if self._gone is not None:
                os.eventfd_write(self._more, 1)
                return
            if message is not None:
                self._waiting.append((message, time.monotonic_ns()))
                os.eventfd_write(self._more, 1)

    def _lost(self, error: Exception) -> PortError:
        return PortError(f"{self.name}: {' '.join(str(error).split()) or type(error).__name__}; it is opened again when it is back")


def _open(url: str, adapter: Adapter, bitrate: int, *, listen_only: bool) -> can.BusABC:
    if adapter.interface not in can.VALID_INTERFACES:
        known = ", ".join(sorted(can.VALID_INTERFACES - {"cycle"}))
        raise PortError(f"{url}: python-can has no interface {adapter.interface!r}; it has {known}")
    options: dict[str, object] = {"bitrate": adapter.bitrate or bitrate, **DEFAULTS.get(adapter.interface, {})}
    options |= {"receive_own_messages": True} if adapter.interface in MARK_OWN else {}
    options |= LISTEN.get(adapter.interface, {}) if listen_only else {}
    options |= adapter.options
    if adapter.interface == "socketcand":
        _knock(url, adapter)
    try:
        return can.Bus(interface=adapter.interface, channel=adapter.channel, **options)  # type: ignore[arg-type]  # each adapter has its own options
    except GOES_WRONG as error:
        raise PortError(f"{url}: {' '.join(str(error).split()) or type(error).__name__}") from error


def _knock(url: str, adapter: Adapter) -> None:
    """python-can calls a server that is not there without a pause for 10 s; one call is enough to know."""
    try:
        socket.create_connection((str(adapter.options.get("host", "127.0.0.1")), int(adapter.options.get("port", 29536))), 1.0).close()
    except (OSError, ValueError) as error:
        raise PortError(f"{url}: {error}; is socketcand running there?") from error
