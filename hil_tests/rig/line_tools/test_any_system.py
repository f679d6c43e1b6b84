"""The tools load where Linux-only modules do not exist; the monitor has nothing to write with."""

import subprocess
import sys

from gateway.links.serial.line_monitor import Monitor
from gateway.pure.lines.decoder import LineReport
from hil_tests.rig.line_tools.conftest import ROOT
from protocols.base.machine import Damage, Ns

BARE = """
import asyncio, builtins, importlib, os, pkgutil, select, signal, socket, sys, sysconfig, time, zoneinfo
import pydantic.main
GONE = {"fcntl", "termios", "pty", "tty", "resource", "pwd", "grp", "syslog", "crypt", "spwd", "nis", "posix_ipc", "readline", "curses"}
for name in list(sys.modules):
    if name.split(".")[0] in GONE: del sys.modules[name]
real = builtins.__import__
def without(name, *rest, **more):
    if name.split(".")[0] in GONE: raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return real(name, *rest, **more)
builtins.__import__ = without
def take_away(module, *names):
    for name in names: hasattr(module, name) and delattr(module, name)
take_away(select, "epoll", "poll", "kqueue", "EPOLLIN", "POLLIN")
take_away(signal, "SIGKILL", "SIGHUP", "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGCHLD", "SIGSTOP", "setitimer", "alarm")
take_away(signal, "pthread_sigmask", "set_wakeup_fd")
take_away(socket, "AF_UNIX", "AF_CAN", "AF_PACKET", "SO_REUSEPORT", "TCP_USER_TIMEOUT", "TCP_KEEPIDLE", "SO_PEERCRED", "send_fds")
take_away(os, "eventfd", "openpty", "memfd_create", "sched_setscheduler", "sched_setaffinity", "sched_getaffinity", "getuid")
take_away(os, "geteuid", "getgid", "fork", "forkpty", "setsid", "getpgid", "killpg", "O_NOCTTY", "O_NONBLOCK", "O_CLOEXEC")
take_away(os, "O_DIRECTORY", "sysconf", "uname", "getloadavg", "statvfs", "chown", "mkfifo", "pread", "pwrite", "pidfd_open", "wait4")
take_away(time, "clock_gettime_ns", "clock_gettime", "CLOCK_MONOTONIC", "CLOCK_MONOTONIC_RAW", "pthread_getcpuclockid")
take_away(asyncio, "start_unix_server", "open_unix_connection")
sys.platform = "win32-like"
import gateway.conformance.serial, gateway.tools.line
rooms = (gateway.tools.line, gateway.conformance.serial)
modules = [f"{room.__name__}.{module.name}" for room in rooms for module in pkgutil.iter_modules(room.__path__)]
modules += ["gateway.conformance.report", "gateway.conformance.case", "gateway.links.serial.tool_wire", "gateway.links.serial.line_monitor"]
modules += ["gateway.commands." + name for name in ("line", "line_export", "learn", "explain", "check")]
for module in modules: importlib.import_module(module)
from gateway.commands.line import main
assert not GONE & {name.split(".")[0] for name in sys.modules}, GONE & set(sys.modules)
WORK = (
    "gateway.processes",
    "gateway.runtime.realtime",
    "gateway.runtime.regions",
    "drivers.ports.serial.pty",
    "drivers.ports.serial.device",
    "drivers.ports.timerfd",
)
loaded = [name for name in sys.modules if name.startswith(WORK)]
assert not loaded, loaded
print(f"{len(modules)} modules", file=sys.stderr)
sys.exit(main(sys.argv[1:]) if sys.argv[1:] else 0)
"""


def bare(*words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, "-c", BARE, *words], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)


def test_the_tools_run_without_linux_only_modules() -> None:
    probed = bare("probe", "sim:good", "--no-report")
    assert probed.returncode == 0, probed.stdout[-2000:] + probed.stderr
    assert " 0 FAIL" not in probed.stdout and "FAIL " not in probed.stdout
    fetched = bare("fetch", "sim:good", "DB10.DW0", "--type", "KF")
    assert fetched.returncode == 0, fetched.stderr
    assert bare("diagnose", "sim:good").returncode == 0


def test_a_port_this_system_cannot_open_is_an_answer_not_a_traceback() -> None:
    for port in ("pty:/dev/pts/9", "line:demo-plc1"):
        failed = bare("fetch", port, "DB10.DW0")
        assert failed.returncode == 3, failed.stderr
        assert "axisgate line fetch: " in failed.stderr and "Traceback" not in failed.stderr


def test_every_module_of_the_tools_loads_there() -> None:
    loaded = bare()
    assert loaded.returncode == 0, loaded.stderr
    assert int(loaded.stderr.split()[0]) >= 20


class Tap:
    """A port that counts what a monitor must never do."""

    def __init__(self, data: bytes) -> None:
        self.name, self.char_ns, self._data, self.touched = "tap", 1_000_000, data, list[str]()

    def read(self) -> list[bytes | Damage]:
        data, self._data = self._data, b""
        return [data] if data else []

    def unsent(self) -> int:
        return 0

    def wait(self, seconds: float) -> None:
        pass

    def write(self, data: bytes) -> int:
        self.touched.append("write")
        return len(data)

    def spoil(self) -> bool:
        self.touched.append("spoil")
        return True

    def send_break(self) -> bool:
        self.touched.append("break")
        return True

    def close(self) -> None:
        pass


def test_the_monitor_never_writes() -> None:
    told: list[LineReport] = []
    moments = iter(range(0, 10**12, 50_000_000))
    taps = Tap(b"\x02"), Tap(b"\x10\x02\x15")

    def clock() -> Ns:
        return next(moments)

    Monitor([("A", taps[0]), ("B", taps[1])], clock, told.append).run(1_000_000_000)
    assert [(one.side, one.kind) for one in told] == [("A", "STX"), ("B", "DLE"), ("B", "STX"), ("A", "BROKEN"), ("B", "NAK")]
    assert taps[0].touched == taps[1].touched == []
