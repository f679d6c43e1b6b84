"""AX-820: Ctrl-Z and the other signals of a terminal suspend no process of a run, at a real shell with job control."""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Iterator
from fcntl import ioctl

import pytest

from drivers.ports.base import runtime_dir
from gateway.runtime.supervisor_client import ask, wait_up
from hil_tests.lab.running.cell_running import COMES_UP_S, P5_MS, runtime_folder

SLUG = "suspended"
SHELL = shutil.which("bash")
OF_A_TERMINAL = (signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU)

pytestmark = pytest.mark.skipif(SHELL is None, reason="no shell with job control")


class Terminal:
    """An interactive shell at a terminal, and what stands on its screen."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.master, slave = os.openpty()
        self.screen = b""

        def own_terminal() -> None:
            ioctl(0, termios.TIOCSCTTY, 0)

        self.shell = subprocess.Popen(
            [str(SHELL), "--norc", "--noprofile", "-i"],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            cwd=folder,
            start_new_session=True,
            preexec_fn=own_terminal,  # noqa: PLW1509 the reader's thread starts after it
        )
        os.close(slave)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError):
            while data := os.read(self.master, 65536):
                self.screen += data

    def type(self, text: bytes) -> None:
        os.write(self.master, text)

    def close(self) -> None:
        self.shell.kill()
        self.shell.wait()
        os.close(self.master)


@contextlib.contextmanager
def typed_run() -> Iterator[tuple[Terminal, int]]:
    """`axisgate run` typed at a shell, and the supervisor's pid."""
    with runtime_folder() as folder:
        terminal = Terminal(folder)
        command = f"{sys.executable} -m gateway run demo --sim --name {SLUG} --p5 {max(P5_MS, 20)} --die-with-parent\n"
        try:
            terminal.type(command.encode())
            assert wait_up(SLUG, COMES_UP_S), terminal.screen
            yield terminal, supervisor()
        finally:
            with contextlib.suppress(OSError, AssertionError), ask(SLUG, "stop"):
                pass
            terminal.close()


def status() -> dict[str, dict[str, object]]:
    with ask(SLUG, "status") as connection:
        return {each["name"]: each for each in json.loads(connection.makefile().readline())["processes"]}


def supervisor() -> int:
    """The parent of a child."""
    return int(stat(int(str(status()["cycle"]["pid"])))[1])


def stat(pid: int) -> list[str]:
    """State and parent.  Source: proc(5), fields 3 and 4 of stat."""
    return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[:2]


def back(name: str, dead: int) -> None:
    until = time.monotonic() + 10
    while status()[name]["pid"] in (dead, None):
        assert time.monotonic() < until, f"{name} did not come back: nobody watches it"
        time.sleep(0.05)


def killed(name: str) -> int:
    pid = int(str(status()[name]["pid"]))
    os.kill(pid, signal.SIGKILL)
    return pid


def journal() -> list[str]:
    return [json.loads(line)["text"] for line in (runtime_dir() / SLUG / "journal.jsonl").read_text().splitlines() if line]


def test_ctrl_z_leaves_no_process_unwatched_and_says_so_once() -> None:
    with typed_run() as (terminal, pid):
        for _ in range(3):
            terminal.type(b"\x1a")
            time.sleep(0.3)
        assert stat(pid)[0] != "T", "the supervisor is suspended, and its processes move axes"
        back("line-plc1", killed("line-plc1"))
        assert [words for words in journal() if "SIGTSTP" in words] == [
            "Ctrl-Z (SIGTSTP) does not suspend a run, because its processes would go on unwatched; the run continues; "
            f"to end it: axisgate stop {SLUG}, or Ctrl-C"
        ]
        assert b"Ctrl-Z (SIGTSTP) does not suspend a run" in terminal.screen
        terminal.type(b"\x03")
        until = time.monotonic() + 20
        while pathlib.Path(f"/proc/{pid}").exists() and stat(pid)[0] != "Z":
            assert time.monotonic() < until, "Ctrl-C ends it"
            time.sleep(0.05)


def test_no_signal_of_a_terminal_suspends_a_process_of_the_run() -> None:
    with typed_run() as (_, pid):
        time.sleep(2.0)  # what stands by is there as well
        pids = [pid]
        for each in status().values():
            pids += [int(str(each[key])) for key in ("pid", "spare") if each[key] is not None]
        before = {name: each["pid"] for name, each in status().items()}
        for number in OF_A_TERMINAL:
            for each_pid in pids:
                os.kill(each_pid, number)
        time.sleep(1.0)
        assert [each_pid for each_pid in pids if stat(each_pid)[0] == "T"] == []
        assert {name: each["pid"] for name, each in status().items()} == before
        back("services", killed("services"))


def test_after_a_stop_that_cannot_be_ignored_the_supervisor_watches_again_and_ends_nothing() -> None:
    with typed_run() as (_, pid):
        before = {name: each["pid"] for name, each in status().items()}
        os.kill(pid, signal.SIGSTOP)
        time.sleep(3.0)
        os.kill(pid, signal.SIGCONT)
        time.sleep(0.5)
        assert {name: each["pid"] for name, each in status().items()} == before, "the processes were alive all the time"
        dead = int(str(before["line-plc1"]))
        os.kill(pid, signal.SIGSTOP)
        os.kill(dead, signal.SIGKILL)
        time.sleep(0.5)
        os.kill(pid, signal.SIGCONT)
        back("line-plc1", dead)
