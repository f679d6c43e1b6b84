"""Long work in slices: a generator that yields wherever it may be interrupted, and returns its result."""

from collections.abc import Generator
from typing import Generic, TypeVar

T = TypeVar("T")
Work = Generator[None, None, T]


class Slices(Generic[T]):
    """One piece of work, a slice at a time.  made: the result, empty until it is done."""

    def __init__(self, work: Work[T]) -> None:
        self.made: list[T] = []
        self._rest = self._kept(work)

    def _kept(self, work: Work[T]) -> Work[None]:
        self.made.append((yield from work))

    def go(self) -> bool:
        """One slice more; True: it is done.  Raises what the work raises."""
        for _ in self._rest:
            return False
        return True


def whole(work: Work[T]) -> T:
    """All of it at once."""
    slices = Slices(work)
    while not slices.go():
        pass
    return slices.made[0]
