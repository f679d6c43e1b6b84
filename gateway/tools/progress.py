"""A progress bar for slow work: one line on a terminal's standard error, nothing in a pipe."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sized
from types import TracebackType
from typing import TypeVar

WIDTH = 30
EVERY_S = 0.1
T = TypeVar("T")


class Progress:
    """`with Progress("replay", cycles) as done: done(n)`; the line is erased at the end.  `total` 0: the duration is unknown."""

    def __init__(self, what: str, total: float, now: Callable[[], float] = time.monotonic) -> None:
        self._what, self._total, self._now = what, total, now
        self._began, self._next = now(), 0.0
        self._shown = sys.stderr.isatty()

    def __call__(self, done: float, words: str = "") -> None:
        """So much of the total is done; `words` follow the bar."""
        now = self._now()
        if not self._shown or now < self._next:
            return
        self._next = now + EVERY_S
        print(f"\r\x1b[K{self.line(done, now - self._began)}{f'  {words}' if words else ''}", end="", file=sys.stderr, flush=True)

    def line(self, done: float, seconds: float) -> str:
        """Text on the terminal after `seconds`."""
        if self._total <= 0:
            return f"{self._what}: {done:g}"
        share = min(max(done / self._total, 0.0), 1.0)
        full = round(WIDTH * share)
        left = f"  {_clock(seconds * (1.0 - share) / share)} left" if share > 0.0 and seconds > 1.0 else ""
        return f"{self._what} [{'#' * full}{'.' * (WIDTH - full)}] {100.0 * share:3.0f} %{left}"

    def close(self) -> None:
        """The line is free again."""
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
            self._shown = False

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def steps(what: str, items: Iterable[T]) -> Iterator[T]:
    """The items, each shown when it is done."""
    with Progress(what, len(items) if isinstance(items, Sized) else 0) as done:
        done(0)
        for number, item in enumerate(items, 1):
            yield item
            done(number)


def waited(what: str, seconds: float) -> None:
    """Sleep for this time."""
    with Progress(what, seconds) as done:
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            done(seconds - left)
            time.sleep(min(left, EVERY_S))


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02}"
