"""Frames of a broker's bus with its stamps, taken by a thread of their own."""

import abc
import select
import threading

from drivers.ports.can.open import open_can
from protocols.base.machine import Frame


class BusListener(abc.ABC):
    """The listener's thread begins with it: a subclass sets its own attributes first."""

    def __init__(self, bus: str) -> None:
        self._stop = threading.Event()
        self._port = open_can(f"broker:{bus}")
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while not self._stop.is_set():
            if select.select([self._port], (), (), 0.05)[0]:
                for frame in self._port.receive():
                    self._take(frame)

    @abc.abstractmethod
    def _take(self, frame: Frame) -> None:
        """Each frame as it comes, in the listener's thread."""

    def close(self) -> None:
        """Ends the thread and closes the port."""
        self._stop.set()
        self._thread.join(5)
        self._port.close()
