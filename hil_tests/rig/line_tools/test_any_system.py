"""The tools load where Linux-only modules do not exist; the monitor has nothing to write with."""

import subprocess
import sys

from gateway.line_tools.monitor import Monitor
from gateway.pure.line_decoder import Told
from hil_tests.rig.line_tools.conftest import ROOT
from protocols.base.machine import Damage, Ns

BARE = """
import builtins, importlib, pkgutil, select, sys
GONE = {"fcntl", "termios", "pty", "tty", "resource", "pwd", "grp"}
for name in list(sys.modules):
    if name in GONE: del sys.modules[name]
real = builtins.__import__
def without(name, *rest, **more):
    if name.split(".")[0] in GONE: raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return real(name, *rest, **more)
builtins.__import__ = without
for name in ("epoll", "poll"): hasattr(select, name) and delattr(select, name)
import os
for name in ("eventfd", "openpty", "memfd_create", "sched_setscheduler", "getuid"): hasattr(os, name) and delattr(os, name)
import gateway.line_tools
for module in pkgutil.iter_modules(gateway.line_tools.__path__): importlib.import_module(f"gateway.line_tools.{module.name}")
from gateway.commands.line import main
assert not GONE & set(sys.modules), GONE & set(sys.modules)
sys.exit(main(sys.argv[1:]))
"""


def bare(*words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, "-c", BARE, *words], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)


def test_the_tools_run_without_linux_only_modules() -> None:
    probed = bare("probe", "sim:good", "--no-report")
    assert probed.returncode == 0, probed.stdout[-2000:] + probed.stderr
    assert " 0 FAIL" not in probed.stdout and "FAIL " not in probed.stdout
    fetched = bare("fetch", "sim:good", "DB10.DW0", "--type", "KF")
    assert (fetched.returncode, fetched.stderr) == (0, "")
    assert bare("diagnose", "sim:good").returncode == 0


def test_a_port_this_system_cannot_open_is_an_answer_not_a_traceback() -> None:
    failed = bare("fetch", "pty:/dev/pts/9", "DB10.DW0")
    assert failed.returncode == 3
    assert failed.stderr.startswith("axisgate line fetch: this port needs fcntl")
    assert "Traceback" not in failed.stderr


class Tap:
    """A port that counts what a monitor must never do."""

    def __init__(self, data: bytes) -> None:
        self.name, self.char_ns, self._data, self.touched = "tap", 1_000_000, data, list[str]()

    def read(self) -> list[bytes | Damage]:
        data, self._data = self._data, b""
        return [data] if data else []

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
    told: list[Told] = []
    moments = iter(range(0, 10**12, 50_000_000))
    taps = Tap(b"\x02"), Tap(b"\x10\x02\x15")

    def clock() -> Ns:
        return next(moments)

    Monitor([("A", taps[0]), ("B", taps[1])], clock, told.append).run(1_000_000_000)
    assert [(one.side, one.kind) for one in told] == [("A", "STX"), ("B", "DLE"), ("B", "STX"), ("A", "BROKEN"), ("B", "NAK")]
    assert taps[0].touched == taps[1].touched == []
