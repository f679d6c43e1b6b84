"""Boot user-mode-linux on the host's own file system, run one command in it and return its exit code.

    python -m hil_tests.rig.uml.guest [--folder build/uml/hand] [--limit 600] [--serial-pair] COMMAND ...

The guest sees the host's files (hostfs), so the same Python and the same work tree run in it; result files written below the
project are host files.  /tmp, /run and /dev/shm are memory of the guest: Unix sockets and locks do not work on hostfs.  It has
lo, vcan0 and, with a serial pair, /dev/ttyS1 crossed with /dev/ttyS2 (what these can and cannot show: docs/guest.md).

Its kernel is the one kernel.sh built, where there is one: its time passes only while all its processes sleep, so a busy host makes
nothing late in it (AX-562).  Otherwise it is Debian's, on the host's clock.
"""

import argparse
import contextlib
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from hil_tests.background import to_background

KERNEL = "linux.uml"  # Debian's
ROOT = pathlib.Path(__file__).resolve().parents[3]
OWN_KERNEL = ROOT / "build" / "guest-kernel"  # kernel.sh's; CAN is built in
OWN_TIME = "AXISGATE_GUEST_TIME"  # set to "own" inside a guest that has its own clock
MODULES = pathlib.Path("/usr/lib/uml/modules")
BEGIN, END = "axisgate guest: begin", "axisgate guest: end"  # console lines around the command's output
MEMORY_MB = 1024
HOST_NICE = -18
HIDDEN = (
    "/tmp",
    "/run",
    "/dev/shm",
)  # memory of the guest is mounted over these; folders below them that the command needs are mounted again


class GuestError(RuntimeError):
    """The guest did not boot or ended without a result; the message ends with the last lines of its console."""


@dataclass(frozen=True, slots=True)
class Guest:
    """One run: the folder of its files, its time limit, and its devices besides vcan0."""

    folder: pathlib.Path  # console.log, order.json, exit_code
    limit_s: float = 600.0
    serial_pair: bool = False
    host_time: bool = False  # use Debian's kernel even where there is one with a clock of its own
    environment: Mapping[str, str] = field(default_factory=dict)

    @property
    def own_time(self) -> bool:
        return own_time() and not self.host_time

    def run(self, command: Sequence[str], on_line: Callable[[str], None] = print) -> int:
        """Run a command and return its exit code; each line it prints is passed to `on_line` at once.  Raises GuestError."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "exit_code").unlink(missing_ok=True)
        init, started = self._write_order(command), time.monotonic()
        with contextlib.ExitStack() as stack:
            cable = stack.enter_context(crossed_sockets()) if self.serial_pair else ()
            console = self._boot(init, cable, on_line)
        written = self.folder / "exit_code"
        if not written.exists():
            took = time.monotonic() - started
            raise GuestError(
                f"the guest ended after {took:.1f} s (limit {self.limit_s:.0f} s) without a result; its last lines:\n{console}"
            )
        return int(written.read_text())

    def _write_order(self, command: Sequence[str]) -> pathlib.Path:
        mode = {OWN_TIME: "own"} if self.own_time else {}
        order = {
            "command": list(command),
            "environment": {"PATH": search_path(), "HOME": str(self.folder.absolute()), "LANG": "C.UTF-8", **mode, **self.environment},
            "cwd": os.getcwd(),
            "modules": None if self.own_time else str(newest_modules()),
            "exit_code": str((self.folder / "exit_code").absolute()),
        }
        path = (self.folder / "order.json").absolute()
        path.write_text(json.dumps(order, indent=1))
        init = path.with_name("init.sh")
        init.write_text(
            init_script(path, seen=[pathlib.Path.cwd(), ROOT, self.folder.absolute(), *map(pathlib.Path, (sys.prefix, sys.base_prefix))])
        )
        init.chmod(0o755)
        return init

    def _boot(self, init: pathlib.Path, cable: Sequence[int], on_line: Callable[[str], None]) -> str:
        lines = [f"ssl{number}=fd:{fd},fd:{fd}" for number, fd in enumerate(cable, start=1)]
        arguments = [f"mem={MEMORY_MB}M", "root=/dev/root", "rootfstype=hostfs", "rootflags=/", "rw", f"init={init}", "quiet"]
        clock = ["time-travel=inf-cpu"] if self.own_time else []
        process = subprocess.Popen(
            [str(OWN_KERNEL) if self.own_time else kernel(), *arguments, *clock, "con=null", "con0=null,fd:1", *lines],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, pass_fds=cable, start_new_session=True,
            env={"PATH": os.environ["PATH"], "HOME": str(self.folder), "TMPDIR": str(memory_folder(self.folder))},
        )  # fmt: skip
        if self.own_time:
            to_background(process.pid)
        else:
            favour(process.pid)
        watchdog = threading.Timer(self.limit_s, end_group, [process.pid])
        watchdog.start()
        try:
            return self._listen(process, on_line)
        finally:
            watchdog.cancel()
            end_group(process.pid)  # the helper threads of a kernel that died alone
            process.wait()

    def _listen(self, process: "subprocess.Popen[bytes]", on_line: Callable[[str], None]) -> str:
        begun, last = False, list[str]()
        assert process.stdout is not None
        with (self.folder / "console.log").open("w", encoding="utf-8") as log:
            for raw in process.stdout:
                line = raw.decode("utf-8", "replace").rstrip("\r\n")
                print(line, file=log, flush=True)
                last = [*last[-19:], line]
                if line in (BEGIN, END):
                    begun = line == BEGIN
                elif begun:
                    on_line(line)
        return "\n".join(last)


def favour(pid: int) -> None:
    """Raise the priority of this process and its children (as root), so that a busy host does not delay them for long."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, HOST_NICE)
        pathlib.Path(f"/proc/{pid}/autogroup").write_text(str(HOST_NICE))  # where the host groups by session, nice alone counts within it


def own_time() -> bool:
    """Return whether guests boot a kernel whose time passes only while all its processes sleep."""
    return OWN_KERNEL.exists()


def missing() -> str | None:
    """Return in one line what this machine lacks for a guest; None: nothing."""
    kernels = () if own_time() else (KERNEL,)
    lacking = [name for name in (*kernels, "ip", "candump") if shutil.which(name, path=search_path()) is None]
    if lacking:
        return f"{', '.join(lacking)} not found (Debian: apt-get install user-mode-linux iproute2 can-utils)"
    return None if own_time() or MODULES.is_dir() else f"{MODULES} not found"


def search_path() -> str:
    return os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/sbin", "/sbin"])


def kernel() -> str:
    found = shutil.which(KERNEL, path=search_path())
    if found is None:
        raise GuestError(f"{KERNEL} not found (Debian: apt-get install user-mode-linux)")
    return found


def newest_modules() -> pathlib.Path:
    folders = sorted(MODULES.iterdir(), key=lambda folder: folder.stat().st_mtime) if MODULES.is_dir() else []
    if not folders:
        raise GuestError(f"no kernel modules in {MODULES}")
    return folders[-1]


def memory_folder(fallback: pathlib.Path) -> pathlib.Path:
    """Return a folder for the guest's memory file: it has enough room and allows programs."""
    for name in (os.environ.get("AXISGATE_GUEST_TMP"), "/dev/shm", os.environ.get("TMPDIR"), "/tmp", "/var/tmp"):
        if name and os.access(name, os.W_OK):
            room = os.statvfs(name)
            if not room.f_flag & os.ST_NOEXEC and room.f_bavail * room.f_frsize > 1.1 * MEMORY_MB * 2**20:
                return pathlib.Path(name)
    return fallback.absolute()


def init_script(order: pathlib.Path, seen: Sequence[pathlib.Path]) -> str:
    """Return the first program of the guest: mounts, then init.py, which needs no tool but `ip`."""
    again = dict.fromkeys(str(path) for path in seen if str(path).startswith(tuple(f"{hidden}/" for hidden in HIDDEN)))
    return "\n".join([
        "#!/bin/sh",
        "export PATH=/usr/sbin:/usr/bin:/sbin:/bin",
        "mount -t proc proc /proc; mount -t sysfs sys /sys",
        "mkdir -p /dev/pts /dev/shm; mount -t devpts -o mode=620,ptmxmode=666 devpts /dev/pts",
        *(f"mount -t tmpfs -o mode=1777 tmpfs {hidden}" for hidden in HIDDEN),
        *(f"mkdir -p '{path}'; mount -t hostfs -o '{path}' none '{path}'" for path in again),
        f"cd '{pathlib.Path.cwd()}' && exec '{sys.executable}' -m hil_tests.rig.uml.init '{order}'",
        "",
    ])  # fmt: skip


@contextlib.contextmanager
def crossed_sockets() -> Iterator[tuple[int, int]]:
    """Yield two connected descriptors, for the guest's ttyS1 and ttyS2."""
    one, other = socket.socketpair()
    with one, other:
        yield one.fileno(), other.fileno()


def end_group(leader: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(leader, signal.SIGKILL)


def main() -> int:
    parser = argparse.ArgumentParser(prog="guest", description="Runs COMMAND in a user-mode-linux guest with a real vcan0.")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("build/uml/hand"))
    parser.add_argument("--limit", type=float, default=600.0, metavar="SECONDS")
    parser.add_argument("--serial-pair", action="store_true", help="connect the guest's /dev/ttyS1 with its /dev/ttyS2")
    parser.add_argument("--host-time", action="store_true", help="Debian's kernel, on the host's clock")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    arguments = parser.parse_args()
    started = time.monotonic()
    try:
        guest = Guest(arguments.folder, arguments.limit, arguments.serial_pair, arguments.host_time)
        code = guest.run(arguments.command, lambda line: print(line, flush=True))
    except GuestError as error:
        print(f"guest: {error}", file=sys.stderr)
        return 3
    print(f"guest: exit {code} after {time.monotonic() - started:.1f} s", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
