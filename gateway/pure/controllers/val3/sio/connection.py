"""One connection with its buffer and the instructions that wait on it, first come, first served (AX-187)."""

from collections import deque
from enum import Enum, auto

from gateway.pure.controllers.val3.sio.calls import AnyCall, AnyRead, AnyWrite, Step, Write
from gateway.pure.controllers.val3.sio.inbox import Inbox, Mark


class State(Enum):
    OPENING = auto()
    OPEN = auto()
    BROKEN = auto()  # gone; what came before can still be read


class Connection:
    """Knows no channels; `serve` is called after every change."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.state = State.OPENING
        self.inbox = Inbox()
        self.readers: deque[AnyRead] = deque()
        self.writers: deque[AnyWrite] = deque()

    @property
    def idle(self) -> bool:
        """No call waits here."""
        return not self.readers and not self.writers

    def add(self, call: AnyCall) -> None:
        """Behind those who came earlier."""
        if isinstance(call, Write):
            self.writers.append(call)
        else:
            self.readers.append(call)

    def serve(self) -> tuple[list[AnyCall], bool]:
        """The calls that are done now, and whether one met an error that closes the connection."""
        done: list[AnyCall] = []
        while self.writers and (self.writers[0].left() == b"" or self.state is State.BROKEN):
            if self.state is State.BROKEN:
                return done, True
            self.writers[0].took(0)
            done.append(self.writers.popleft())
        while self.readers:
            step = self.readers[0].advance(self.inbox)
            if step is not Step.DONE:
                return done, step is Step.ENDED
            done.append(self.readers.popleft())
        return done, False

    def output(self) -> bytes:
        """What wants to leave: the rest of the oldest write (on UDP: one datagram)."""
        return self.writers[0].left() if self.writers and self.state is State.OPEN else b""

    def took(self, count: int) -> list[AnyCall]:
        """Record that the channel accepted `count` bytes of `output()`; return the calls that end with them."""
        return [self.writers.popleft()] if self.writers and self.writers[0].took(count) else []

    def expire(self, now: int) -> list[AnyCall]:
        """Calls whose time is over; no later call was served before them."""
        late = [call for call in (*self.readers, *self.writers) if call.deadline is not None and now >= call.deadline]
        for call in late:
            call.expire(connected=True)
        self.readers = deque(call for call in self.readers if not call.done)
        self.writers = deque(call for call in self.writers if not call.done)
        return late

    def fail(self, why: str) -> list[AnyCall]:
        """Every call that waits here ends with an error."""
        failed: list[AnyCall] = [*self.readers, *self.writers]
        for call in failed:
            call.fail(why)
        self.readers.clear()
        self.writers.clear()
        return failed

    def remove(self, call: object) -> None:
        """Its task does not wait any more."""
        self.readers = deque(waiting for waiting in self.readers if waiting is not call)
        self.writers = deque(waiting for waiting in self.writers if waiting is not call)

    def broke(self) -> None:
        """Nothing goes in or out any more."""
        self.state = State.BROKEN
        self.inbox.mark(Mark.ENDED)
