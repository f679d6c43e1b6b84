"""The life of a tool that moves a drive without a cycle: the drive watches its heartbeat, and signals end a move in order."""

import signal
import threading
import time
from types import FrameType, TracebackType
from typing import Self

from drivers.drives.cia402_family import GATEWAY_NODE
from drivers.ports.base import PortError
from gateway.links.canopen.direct_link import DirectLink
from protocols.canopen.nmt import State, heartbeat

ALIVE_S = 1.5  # longest step of a dialogue: three tries of one SDO request and a pause
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Heartbeat:
    """The gateway's heartbeat from a thread, but only while the dialogue makes progress: a tool that hangs stops its drive too."""

    def __init__(self, link: DirectLink, period_s: float) -> None:
        self._link, self._period_s = link, period_s
        self._frame = heartbeat(GATEWAY_NODE, State.OPERATIONAL)
        self._until = 0.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._beat, name="heartbeat", daemon=True)

    def alive(self) -> None:
        """The dialogue makes progress: extend the heartbeat by one more step."""
        self._until = time.monotonic() + ALIVE_S

    def _beat(self) -> None:
        while not self._end.wait(self._period_s):
            if time.monotonic() < self._until:
                try:
                    self._link.send(self._frame.identifier, self._frame.data)
                except PortError:  # the dialogue reports it; the drive misses the heartbeat
                    return

    def __enter__(self) -> Self:
        self.alive()
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._end.set()
        self._thread.join(1.0)


class Signals:
    """Ctrl-C, SIGTERM and SIGHUP are noted while inside, so that the drive is stopped before the tool ends."""

    def __init__(self) -> None:
        self.why = ""
        self._before: dict[int, object] = {}

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.why = self.why or f"ended by {signal.Signals(number).name}"

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self._note) for number in SIGNALS}
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]  # what signal.signal() itself gave
