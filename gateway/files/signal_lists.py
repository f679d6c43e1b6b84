"""The signal list of a controller family, parsed once per state of its file: 600 signals cost most of a check's time."""

import functools
import pathlib

from gateway.files.find import find_config, read_signals
from gateway.pure.image.signals import SignalList, from_tables


def signal_list(name: str = "rho3") -> SignalList:
    """All signals the control can have.  ConfigNotFound, TOMLDecodeError, UnicodeDecodeError: of the file."""
    path = find_config(name, "signals").resolve()
    state = path.stat()
    return _parsed(path, state.st_mtime_ns, state.st_size)


@functools.lru_cache(maxsize=4)
def _parsed(path: pathlib.Path, changed_ns: int, octets: int) -> SignalList:
    """Kept as long as the file is the same one."""
    return from_tables(read_signals(str(path)))
