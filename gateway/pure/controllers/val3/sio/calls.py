"""Running instructions: what each reads from or writes to a connection, and the effect of a time-out or an error.

Source: VAL 3 manual, 3.7.2 (operators) and 3.7.3 (sioGet, sioSet).  A call waits inside its task; all others continue.
"""

from collections.abc import Sequence
from enum import Enum, auto
from typing import Generic, TypeVar

from gateway.pure.controllers.val3.sio.errors import Rte, Val3Error
from gateway.pure.controllers.val3.sio.inbox import Inbox, Mark
from gateway.pure.controllers.val3.sio.text import encode_text, nearest_byte
from gateway.pure.controllers.val3.sio.variable import Sio
from protocols.base.machine import Ns

T = TypeVar("T")


class Step(Enum):
    WAIT = auto()  # needs more bytes
    DONE = auto()
    ENDED = auto()  # met the end of the connection


class Call(Generic[T]):
    """One instruction; `result()` once `done`."""

    def __init__(self, sio: Sio, deadline: Ns | None) -> None:
        self.sio, self.deadline = sio, deadline
        self.done = False
        self._value: T | None = None
        self._error: Val3Error | None = None

    def result(self) -> T:
        """What the instruction returns.  Raises Val3Error, or RuntimeError while it waits."""
        if self._error is not None:
            raise self._error
        if self._value is None:
            raise RuntimeError(f"{type(self).__name__} still waits; look at done first")
        return self._value

    def expire(self, connected: bool) -> None:
        """The time-out is over."""
        raise NotImplementedError

    def fail(self, why: str) -> None:
        """Read or write error, or the connection was closed."""
        raise NotImplementedError

    def stop(self, error: Val3Error) -> None:
        """Ends with a run-time error."""
        self.done, self._error = True, error

    def finish(self, value: T) -> None:
        """Ends with a value."""
        self.done, self._value = True, value


class Read(Call[T]):
    """Takes from the read buffer."""

    def advance(self, inbox: Inbox) -> Step:
        """Read what it needs if it is available."""
        raise NotImplementedError


class Get(Read[int]):
    """sioGet: one or more bytes, until the array is full or the buffer empty."""

    def __init__(self, sio: Sio, deadline: Ns | None, data: list[float], start: int) -> None:
        super().__init__(sio, deadline)
        self._data, self._start = data, start

    def advance(self, inbox: Inbox) -> Step:
        """Bytes go to data[start], data[start+1] and so on; the rest of the array stays as it was."""
        if mark := inbox.front():
            return _meet(self, inbox, mark)
        taken = inbox.take(len(self._data) - self._start)
        if not taken:
            return Step.WAIT
        self._data[self._start : self._start + len(taken)] = [float(byte) for byte in taken]
        self.finish(len(taken))
        return Step.DONE

    def expire(self, connected: bool) -> None:
        """Connected and nothing came: 0; not even a connection: -1."""
        self.finish(0 if connected else -1)

    def fail(self, why: str) -> None:
        """-1."""
        self.finish(-1)


class ReadNum(Read[float]):
    """`num = sio`: one byte."""

    def advance(self, inbox: Inbox) -> Step:
        """The next byte."""
        if mark := inbox.front():
            return _meet(self, inbox, mark)
        if taken := inbox.take(1):
            self.finish(float(taken[0]))
        return Step.DONE if taken else Step.WAIT

    def expire(self, connected: bool) -> None:
        """A run-time error (AX-180)."""
        self.fail("time-out" if connected else "no connection in time")

    def fail(self, why: str) -> None:
        """A run-time error."""
        self.stop(Val3Error(Rte.IO_FAULT, f"num = {self.sio}: {why}"))


class ReadText(Read[str]):
    """`string = sio`: all or nothing, so that a time-out leaves the bytes in the buffer (AX-181)."""

    def __init__(self, sio: Sio, deadline: Ns | None, end_of_string: int) -> None:
        super().__init__(sio, deadline)
        self._end_of_string = end_of_string

    def advance(self, inbox: Inbox) -> Step:
        """Read one complete string."""
        line = inbox.line(self._end_of_string)
        if line is None:
            return Step.ENDED if inbox.ended else Step.WAIT
        if line.damaged:
            self.fail("a character of the string was damaged")
        else:
            self.finish(line.text)
        return Step.DONE

    def expire(self, connected: bool) -> None:
        """A run-time error (AX-180)."""
        self.fail("time-out" if connected else "no connection in time")

    def fail(self, why: str) -> None:
        """A run-time error."""
        self.stop(Val3Error(Rte.IO_FAULT, f"string = {self.sio}: {why}"))


class Write(Call[T]):
    """Gives bytes to a connection; written is what the channel has taken (AX-185)."""

    def __init__(self, sio: Sio, deadline: Ns | None, payload: bytes) -> None:
        super().__init__(sio, deadline)
        self.payload, self.sent = payload, 0

    def left(self) -> bytes:
        """What the channel has not taken."""
        return self.payload[self.sent :]

    def took(self, count: int) -> bool:
        """The channel took that many; whether all is out."""
        self.sent += count
        if self.sent >= len(self.payload):
            self.complete()
        return self.done

    def complete(self) -> None:
        """All is out."""
        raise NotImplementedError


class Set(Write[int]):
    """sioSet."""

    def __init__(self, sio: Sio, deadline: Ns | None, values: Sequence[float]) -> None:
        super().__init__(sio, deadline, bytes(nearest_byte(value) for value in values))

    def complete(self) -> None:
        """How many were written."""
        self.finish(self.sent)

    def expire(self, connected: bool) -> None:
        """What went out until then; -1 when nothing did (AX-185)."""
        self.finish(self.sent or -1)

    def fail(self, why: str) -> None:
        """As at a time-out."""
        self.finish(self.sent or -1)


class WriteText(Write[str]):
    """`sio = string`: UTF-8 and the end character; its value is the string."""

    def __init__(self, sio: Sio, deadline: Ns | None, text: str, end_of_string: int) -> None:
        super().__init__(sio, deadline, encode_text(text, end_of_string))
        self._text = text

    def complete(self) -> None:
        """The string itself."""
        self.finish(self._text)

    def expire(self, connected: bool) -> None:
        """A run-time error (AX-180)."""
        self.fail("time-out" if connected else "no connection in time")

    def fail(self, why: str) -> None:
        """A run-time error."""
        self.stop(Val3Error(Rte.IO_FAULT, f"{self.sio} = string: {why}"))


class WriteNum(Write[float]):
    """`sio = num`: one byte; its value is the byte really sent."""

    def __init__(self, sio: Sio, deadline: Ns | None, value: float) -> None:
        super().__init__(sio, deadline, bytes((nearest_byte(value),)))

    def complete(self) -> None:
        """The byte."""
        self.finish(float(self.payload[0]))

    def expire(self, connected: bool) -> None:
        """A run-time error (AX-180)."""
        self.fail("time-out" if connected else "no connection in time")

    def fail(self, why: str) -> None:
        """A run-time error."""
        self.stop(Val3Error(Rte.IO_FAULT, f"{self.sio} = num: {why}"))


AnyRead = Get | ReadNum | ReadText
AnyWrite = Set | WriteText | WriteNum
AnyCall = AnyRead | AnyWrite


def _meet(call: AnyRead, inbox: Inbox, mark: Mark) -> Step:
    """A byte reader met a mark: a damage is reported once, the end stays."""
    if mark is Mark.ENDED:
        return Step.ENDED
    inbox.drop_front()
    call.fail("a character was damaged or lost")
    return Step.DONE
