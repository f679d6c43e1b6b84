"""Files that could not be written, for example because the disk was full: they are tried again until they can be."""

import contextlib
import pathlib
import time
from collections.abc import Callable

from gateway.files.safe_file import write_whole

AGAIN_S = 1.0

Stamp = tuple[int, int] | None


def stamp_of(path: pathlib.Path) -> Stamp:
    """Time and size of a file; None: it cannot be read."""
    with contextlib.suppress(OSError):
        found = path.stat()
        return found.st_mtime_ns, found.st_size
    return None


class UnwrittenFiles:
    """Call `failed` and `written` after each write, `again` at any time."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._due = clock, 0.0
        self._files: dict[pathlib.Path, tuple[bytes | None, Stamp, pathlib.Path | None]] = {}

    def failed(self, path: pathlib.Path, octets: bytes | None, aside: pathlib.Path | None = None) -> None:
        """It has to have this content; None: it has to be deleted.  `aside`: what is there has to be kept under this name first."""
        self._files[path] = octets, stamp_of(path), aside
        self._due = self._clock() + AGAIN_S

    def written(self, path: pathlib.Path) -> None:
        """It has a newer content."""
        self._files.pop(path, None)

    def again(self) -> list[pathlib.Path]:
        """Files that have been written now.  A file that was replaced meanwhile stays as it is."""
        if not self._files or self._clock() < self._due:
            return []
        self._due, done = self._clock() + AGAIN_S, []
        for path, (octets, stamp, aside) in list(self._files.items()):
            if stamp_of(path) == stamp:
                try:
                    if aside is not None:
                        write_whole(aside, path.read_bytes())
                    path.unlink(missing_ok=True) if octets is None else write_whole(path, octets)
                except OSError:
                    continue
                done.append(path)
            del self._files[path]
        return done
