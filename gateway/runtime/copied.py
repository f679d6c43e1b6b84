"""A child process that is a copy of this one instead of a new Python: most of its modules are loaded already (AX-1740).

A new Python loads them again in every process of a run; that is nearly all of a start.  The copy looks like a new process: standard
streams, open files, signals, environment and name are its own, and it ends without returning into its parent's code.
"""

import contextlib
import ctypes
import functools
import gc
import importlib
import io
import itertools
import os
import pathlib
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence

NAME_BYTES = 15  # of a process in `top`: proc(5), comm
ARGUMENTS = slice(45, 47)  # place of the begin and end of its command line: proc(5), stat, fields 48 and 49, counted after the name
ALL_SIGNALS = signal.valid_signals()


def can_copy() -> bool:
    """Only a process of one thread can be copied: a lock that another thread holds would stay locked in the copy."""
    return len(os.listdir("/proc/self/task")) == 1


def command_line(module: str, arguments: Sequence[str]) -> list[str]:
    """Command line of that module in a new Python, also shown by `ps` for a copy."""
    return [sys.executable, "-m", module, *arguments]


def start_copy(
    module: str,
    arguments: Sequence[str],
    *,
    stdin: int,
    keep: Collection[int],
    environment: Mapping[str, str],
    first: Callable[[], None],
) -> "subprocess.Popen[bytes]":
    """`main(arguments)` of that module in a copy of this process, a session of its own; standard output and error are a pipe.

    `keep`: files it gets, by their numbers; `environment` is added to that of this process; `first` is called first.
    OSError: no memory or no process left.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ALL_SIGNALS)  # a signal must find the child's own handlers, not ours in it
    try:
        return subprocess.Popen(
            command_line(module, arguments),
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=tuple(keep),
            start_new_session=True,
            preexec_fn=functools.partial(_become, module, arguments, frozenset(keep), environment, first, before),  # noqa: PLW1509
        )
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def name_process(name: str, command: Sequence[str]) -> None:
    """Set the name shown by `top` and `ps`; a command longer than that of the start of this process is cut."""
    with contextlib.suppress(OSError):
        pathlib.Path("/proc/self/comm").write_text(name[:NAME_BYTES])
    with contextlib.suppress(OSError, ValueError):
        start, end = map(int, pathlib.Path("/proc/self/stat").read_text().rpartition(")")[2].split()[ARGUMENTS])
        if 0 < start < end:
            text = b"\0".join(word.encode(errors="replace") for word in command)
            ctypes.memmove(start, text[: end - start - 1].ljust(end - start, b"\0"), end - start)


def _become(
    module: str,
    arguments: Sequence[str],
    keep: Collection[int],
    environment: Mapping[str, str],
    first: Callable[[], None],
    mask: Collection[int],
) -> None:
    """In the child, instead of a new program.  It never returns: the parent's frames remain below, unused."""
    code = 1
    try:
        first()
        _own_signals()
        _close_all_but({0, 1, 2, *keep})  # also the pipe on which Popen waits for the new program
        _own_streams()
        os.environ.update(environment)
        gc.freeze()  # the parent's objects are never garbage here, and a collection would copy their memory
        gc.enable()
        name_process(module.rpartition("gateway.")[2], command_line(module, arguments))
        sys.argv = [module, *arguments]
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        code = importlib.import_module(module).main(list(arguments))
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)


def _own_signals() -> None:
    """As in a new Python process: handled signals return to the default, ignored ones stay ignored."""
    for number in ALL_SIGNALS:
        if callable(signal.getsignal(number)):
            signal.signal(number, signal.SIG_DFL)
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGPIPE, signal.SIGXFSZ):
        signal.signal(number, signal.SIG_IGN)


def _close_all_but(keep: Collection[int]) -> None:
    ends = [*sorted(keep), os.sysconf("SC_OPEN_MAX")]
    for before, end in itertools.pairwise([-1, *ends]):
        if before + 1 < end:  # with an empty range at 0 closerange would close all
            os.closerange(before + 1, end)


def _own_streams() -> None:
    """Empty streams: unwritten output of the parent belongs to the parent."""
    sys.stdin = io.TextIOWrapper(io.BufferedReader(io.FileIO(0, closefd=False)), encoding="utf-8")
    sys.stdout, sys.stderr = (
        io.TextIOWrapper(
            io.BufferedWriter(io.FileIO(fd, "w", closefd=False)), encoding="utf-8", errors="backslashreplace", line_buffering=True
        )
        for fd in (1, 2)
    )
