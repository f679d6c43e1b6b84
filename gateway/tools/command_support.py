"""Common parts of the commands: exit codes, the banner, an orderly end.  Loads nothing."""

import contextlib
import signal
from collections.abc import Callable, Iterator

DONE, FINDING, USAGE, ENVIRONMENT = 0, 1, 2, 3
INTERRUPTED = 130  # by Ctrl-C
BANNER = (
    "axisgate is not a safety device. It has no safety function, no performance level and no certificate. Emergency stop, safe torque\n"
    "off, guards, enabling devices and speed monitoring must be realised in certified hardware that works without axisgate.\n"
    "axisgate ist keine Sicherheitseinrichtung: Not-Halt, STO, Schutztueren, Zustimmung und sichere Geschwindigkeit gehoeren in\n"
    "zertifizierte Hardware, die ohne axisgate wirkt."
)


def of_file(error: Exception) -> str:
    """Fault of a file, without the errno that Python puts before it."""
    return f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename and error.strerror else str(error)


@contextlib.contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Within the block Ctrl-C and SIGTERM do not end the command; the yielded function reports whether one came."""
    came: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda got, frame: came.append(got)) for number in numbers]
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
