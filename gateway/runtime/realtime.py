"""Real-time settings of a process: scheduling class, locked memory, absolute sleeping, timer file descriptors.

Source: docs/architecture.md, "The cycle owns its process"; clock_nanosleep(2), timerfd_create(2), mlockall(2), prctl(2).
Python 3.11 has neither clock_nanosleep nor os.timerfd, so both come from the C library by ctypes (AX-094).
"""

import contextlib
import ctypes
import errno
import gc
import os
import resource
import signal
import struct
import time

from gateway.runtime.huge_pages import use_huge_pages

CLOCK_MONOTONIC, TIMER_ABSTIME = 1, 1
MCL_CURRENT, MCL_FUTURE = 1, 2
PR_SET_PDEATHSIG = 1
SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}  # numbers of the system call; the C library has no function for it
_SCHED_ATTR = struct.Struct("=IIQiIQQQ")  # size, policy, flags, nice, priority, runtime, deadline, period
TURN_NS, AHEAD = 100_000, -10  # the shortest turn there is; nice value
SECOND_NS = 1_000_000_000

_libc = ctypes.CDLL(None, use_errno=True)


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


class _Itimerspec(ctypes.Structure):
    _fields_ = (("interval", _Timespec), ("value", _Timespec))


_libc.clock_nanosleep.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.POINTER(_Timespec), ctypes.POINTER(_Timespec))
_libc.timerfd_create.argtypes = (ctypes.c_int, ctypes.c_int)
_libc.timerfd_settime.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.POINTER(_Itimerspec), ctypes.POINTER(_Itimerspec))


def go_realtime(priority: int) -> list[str]:
    """Set SCHED_FIFO at `priority` (1..99), lock memory in huge pages, stop the garbage collector; return a warning for each refusal.

    Children start without the real-time class.  Call it when everything is imported and built: existing objects are frozen out of the
    collector. If the class is refused, it requests short time slices: on a busy computer the process wakes milliseconds earlier (AX-916).
    """
    refused = _fifo(priority)
    if refused:
        go_ahead()
    warnings = [text for text in (refused, _lock_memory()) if text]
    gc.collect()
    gc.freeze()
    gc.disable()
    use_huge_pages()
    return warnings


def realtime_allowed() -> bool:
    """Whether this user may use SCHED_FIFO; tried on this process and reset at once."""
    before = os.sched_getscheduler(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except OSError:
        return False
    os.sched_setscheduler(0, before, os.sched_param(0))
    return True


def go_ahead() -> None:
    """In the ordinary class, run soon after a wake-up: before other programs that need the processor, and in short time slices.

    Without it a partner's answer waits while others use up their slices, 4 ms each on kernels with 250 ticks a second.  Settings without
    permission stay as they are: short slices (sched_setattr(2), Linux 6.12) need no privilege, the nice value does.
    """
    number = SCHED_SETATTR.get(os.uname().machine)
    if number is not None:  # the nice value that is set is kept
        asked = _SCHED_ATTR.pack(_SCHED_ATTR.size, os.SCHED_OTHER, 0, os.getpriority(os.PRIO_PROCESS, 0), 0, TURN_NS, 0, 0)
        _libc.syscall(number, 0, asked, 0)
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, AHEAD)


def _fifo(priority: int) -> str | None:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except OSError as error:
        return f"no real-time priority {priority} ({error.strerror}): allow it with 'rtprio {priority}' in /etc/security/limits.conf"
    return None


def _lock_memory() -> str | None:
    soft, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    # A finite limit would make later allocations fail, not merely stay unlocked: then only existing memory is locked
    boundless = soft == resource.RLIM_INFINITY or os.geteuid() == 0
    if _libc.mlockall(MCL_CURRENT | (MCL_FUTURE if boundless else 0)):
        return f"memory not locked ({os.strerror(ctypes.get_errno())}): allow it with 'memlock unlimited' in /etc/security/limits.conf"
    return None


def sleep_until(due_ns: int, spin_ns: int = 0) -> int:
    """Sleep to `due_ns` of the monotonic clock, the last `spin_ns` awake; the time it is on return (>= due_ns)."""
    wake = due_ns - spin_ns
    timespec = _Timespec(wake // SECOND_NS, wake % SECOND_NS)
    now = time.monotonic_ns()
    while now < wake:  # again after a signal
        _libc.clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, ctypes.byref(timespec), None)
        now = time.monotonic_ns()
    while now < due_ns:
        now = time.monotonic_ns()
    return now


class Alarm:
    """Wakes on the instants of a grid: asleep as long as it can be, awake for the rest.

    How long it has to be awake is learned: an instant missed by some microseconds is answered by waking earlier from then on, one that
    is met by waking a little later, so that SHRINK / (GROW + SHRINK) of them, 1 %, are missed (AX-433).
    """

    FIRST_NS, LONGEST_NS, SHORTEST_NS = 60_000, 120_000, 5_000
    GROW_NS, SHRINK_NS = 4_000, 40

    def __init__(self) -> None:
        self.ahead_ns = self.FIRST_NS

    def until(self, due_ns: int) -> int:
        """Sleep to `due_ns` of the monotonic clock; the time it is on return (>= due_ns)."""
        wake = due_ns - self.ahead_ns
        while (now := time.monotonic_ns()) < wake:
            time.sleep((wake - now) * 1e-9)
        self.learn(now, due_ns)
        while now < due_ns:
            now = time.monotonic_ns()
        return now

    def learn(self, woke_ns: int, due_ns: int) -> None:
        """It was awake at `woke_ns`."""
        if woke_ns > due_ns:
            self.ahead_ns = min(self.ahead_ns + self.GROW_NS, self.LONGEST_NS)
        elif self.ahead_ns > self.SHORTEST_NS:
            self.ahead_ns = max(self.ahead_ns - self.SHRINK_NS, self.SHORTEST_NS)


def die_with_parent(parent_pid: int | None = None, number: int = signal.SIGTERM) -> None:
    """The kernel sends us `number` when our parent (the thread that started us) ends; at once if `parent_pid` is gone already."""
    _libc.prctl(PR_SET_PDEATHSIG, number, 0, 0, 0)
    if parent_pid is not None and os.getppid() != parent_pid:
        os.kill(os.getpid(), number)


def survive_terminal() -> None:
    """A terminal or session that ends, or its Ctrl-Z, ends and suspends no process of a run; ignored signals stay ignored over an exec.

    With SIGTTOU ignored a run in the background continues to write (termios(3), TOSTOP); with SIGTTIN ignored a read there fails.
    """
    for number in (signal.SIGHUP, signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU):
        signal.signal(number, signal.SIG_IGN)


def processor_ns(pid: int) -> int:
    """Processor time of all threads of a process so far.  OSError: there is none.  Source: clock_getcpuclockid(3)."""
    return time.clock_gettime_ns(~pid << 3 | 2)


def wants_processor(pid: int) -> bool:
    """A thread of that process is running or ready to run, or waits for a disk.  Source: proc(5), field 3 of stat."""
    for thread in os.listdir(f"/proc/{pid}/task"):
        with contextlib.suppress(OSError), open(f"/proc/{pid}/task/{thread}/stat", "rb") as file:
            if file.read().rpartition(b")")[2][1:2] in b"RD":
                return True
    return False


class Timerfd:
    """A timer that is a file descriptor, for epoll and asyncio.add_reader; absolute times of the monotonic clock in ns."""

    def __init__(self) -> None:
        self._fd: int = _libc.timerfd_create(CLOCK_MONOTONIC, os.O_NONBLOCK | os.O_CLOEXEC)
        if self._fd < 0:
            raise OSError(ctypes.get_errno(), "timerfd_create")

    def fileno(self) -> int:
        return self._fd

    def set(self, due_ns: int | None, period_ns: int = 0) -> None:
        """Readable at `due_ns` (the past: at once) and then every `period_ns`; None: switched off."""
        due = 0 if due_ns is None else max(1, due_ns)
        value = _Itimerspec(_Timespec(*divmod(period_ns, SECOND_NS)), _Timespec(*divmod(due, SECOND_NS)))
        if _libc.timerfd_settime(self._fd, TIMER_ABSTIME, ctypes.byref(value), None):
            raise OSError(ctypes.get_errno(), "timerfd_settime")

    def expired(self) -> int:
        """How often it ran out since the last call; 0: not yet.  Takes the readable state away."""
        try:
            return int.from_bytes(os.read(self._fd, 8), "little")
        except OSError as error:
            if error.errno != errno.EAGAIN:
                raise
            return 0

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
