"""A kernel timer as a file descriptor: wakes an epoll at an absolute moment of CLOCK_MONOTONIC, to some 50 us instead of a millisecond.

Python has os.timerfd_create from 3.13 on only; until then ctypes calls the three functions of the C library.
"""

import contextlib
import ctypes
import os

_CLOCK_MONOTONIC = 1
_ABSOLUTE = 1
_libc = ctypes.CDLL(None, use_errno=True)


class _Setting(ctypes.Structure):
    """struct itimerspec: interval, then value."""

    _fields_ = (("interval_s", ctypes.c_long), ("interval_ns", ctypes.c_long), ("value_s", ctypes.c_long), ("value_ns", ctypes.c_long))


class Timer:
    """One shot at an absolute moment."""

    def __init__(self) -> None:
        self._fd: int = _libc.timerfd_create(_CLOCK_MONOTONIC, os.O_NONBLOCK | os.O_CLOEXEC)
        if self._fd < 0:
            raise OSError(ctypes.get_errno(), "timerfd_create failed")
        self._setting = _Setting()
        self._pointer = ctypes.byref(self._setting)
        self._settime = _libc.timerfd_settime
        self._settime.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)

    def fileno(self) -> int:
        """Readable when the moment has come."""
        return self._fd

    def arm(self, at_ns: int) -> None:
        """Fire at `at_ns` (at once if it has passed)."""
        self._setting.value_s, self._setting.value_ns = divmod(max(at_ns, 1), 1_000_000_000)
        if self._settime(self._fd, _ABSOLUTE, self._pointer, None):
            raise OSError(ctypes.get_errno(), "timerfd_settime failed")

    def clear(self) -> None:
        """Take note that it fired."""
        with contextlib.suppress(BlockingIOError):
            os.read(self._fd, 8)

    def close(self) -> None:
        """Release the descriptor; a second call is harmless."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
