"""Parameters of CANopen drives written by routes: by SDO, in a separate thread, the newest value of each; again after each start-up."""

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from enum import Enum
from typing import Protocol

from drivers.drives.canopen_steps import Refused

LOOK_S = 0.05  # interval of looks at a drive that is not ready
Key = tuple[int, int]  # object, sub-index
WriteJournal = Callable[..., None]  # Journal.write


class DriveNode(Protocol):
    """A node as its master keeps it."""

    @property
    def lock(self) -> AbstractContextManager[object]:
        """One dialogue at a time."""

    @property
    def health(self) -> Enum:
        """READY: it is configured and answers."""

    @property
    def booted(self) -> object:
        """Its last start-up; None: there was none."""

    @property
    def why(self) -> str:
        """Why it is not ready."""


class Master(Protocol):
    """The master of a CANopen bus (gateway.links.canopen.master); loaded only where a cell has one."""

    @property
    def nodes(self) -> Mapping[int, DriveNode]:
        """By number."""

    def upload(self, number: int, index: int, sub: int) -> object:
        """bytes, or Refused."""

    def download(self, number: int, index: int, sub: int, data: bytes) -> object:
        """bytes, or Refused."""

    def start(self, adopted: Sequence[int] = ()) -> None:
        """`adopted`: nodes that run already."""

    def again(self, number: int | None = None) -> None:
        """All nodes are started up again."""

    def stop(self) -> None:
        """Nodes stay as they are."""

    def status(self) -> list[dict[str, object]]:
        """A row a node."""


Place = Callable[[str], tuple[Master, int]]


class Parameters:
    """Parameters of all drives of a run.  A drive loses its downloaded values at a reset; a node that was started up again
    gets them again.
    """

    def __init__(self, place: Place, write: WriteJournal) -> None:
        self._place, self._write = place, write
        self._wanted: dict[tuple[str, Key], bytes] = {}
        self._given: dict[tuple[str, Key], tuple[bytes, object]] = {}  # value, and number of the start-up after which it was sent
        self._news, self._stop = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

    def put(self, axis: str, key: Key, data: bytes) -> None:
        """Returns at once: the thread sends it to the drive."""
        self._wanted[axis, key] = data
        self._news.set()
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="drive parameters", daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """A value on its way still arrives."""
        self._stop.set()
        self._news.set()
        if self._thread is not None:
            self._thread.join(2.0)

    def _run(self) -> None:
        while not self._stop.is_set():
            self._news.wait(LOOK_S)
            self._news.clear()
            for (axis, key), data in list(self._wanted.items()):
                self._give(axis, key, data)

    def _give(self, axis: str, key: Key, data: bytes) -> None:
        """Once for each value and start-up; one that is refused is reported and not repeated."""
        try:
            master, number = self._place(axis)
        except KeyError:  # a shadow starts up no node and downloads nothing
            return
        node = master.nodes[number]
        booted = node.booted
        given, after = self._given.get((axis, key), (None, None))
        if node.health.name != "READY" or booted is None or (given == data and after is booted):
            return
        with node.lock:
            answer = master.download(number, *key, data)
        if isinstance(answer, bytes):
            self._given[axis, key] = data, booted
        elif isinstance(answer, Refused):
            self._given[axis, key] = data, booted
            name = f"{key[0]:04X}h:{key[1]:02X}"
            words = f"{axis} (node {number}): {name} = {int.from_bytes(data, 'little')} is refused: {answer}; the drive keeps its value"
            self._write("alarm", words, node=number, object=name)
