"""A child that is a copy of its parent behaves like a new program (AX-1740)."""

import json
import os
import pathlib
import signal
import subprocess
import sys
from collections.abc import Generator

import pytest

from gateway.runtime.copied import start_copy

PROGRAM = """
import json, os, signal, sys, threading, time

def main(argv):
    match argv[0]:
        case "look":
            fds = [fd for fd in range(1024) if os.path.exists(f"/proc/self/fd/{fd}")]
            print(json.dumps({
                "argv": sys.argv, "fds": fds, "session": os.getsid(0), "stdin": sys.stdin.read(), "extra": os.environ["EXTRA"],
                "handlers": [repr(signal.getsignal(number)) for number in (signal.SIGTERM, signal.SIGINT, signal.SIGPIPE)],
                "blocked": len(signal.pthread_sigmask(signal.SIG_BLOCK, ())), "main": threading.current_thread() is threading.main_thread(),
                "comm": open("/proc/self/comm").read().strip(), "cmdline": open("/proc/self/cmdline").read().split(chr(0))[1:3],
            }))
        case "raise":
            raise ValueError("a fault of the child")
        case "exit":
            sys.exit("a last word")
        case "wait":
            print("ready", flush=True)
            time.sleep(60)
    return 7
"""


@pytest.fixture
def module(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> Generator[str, None, None]:
    (tmp_path / "copied_child.py").write_text(PROGRAM)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield "copied_child"
    sys.modules.pop("copied_child", None)


def start(module: str, *arguments: str, keep: tuple[int, ...] = ()) -> "subprocess.Popen[bytes]":
    return start_copy(module, arguments, stdin=subprocess.DEVNULL, keep=keep, environment={"EXTRA": "new"}, first=lambda: None)


def test_it_has_streams_files_signals_environment_and_name_of_its_own(module: str) -> None:
    before = signal.signal(signal.SIGTERM, lambda number, frame: None)
    read, write = os.pipe()
    try:
        with start(module, "look", keep=(write,)) as child:
            words, _ = child.communicate(timeout=30)
    finally:
        signal.signal(signal.SIGTERM, before)
        os.close(read)
        os.close(write)
    seen = json.loads(words)
    assert seen["argv"] == [module, "look"] and seen["extra"] == "new" and "EXTRA" not in os.environ
    assert seen["fds"] == [0, 1, 2, write] and seen["stdin"] == ""
    assert seen["session"] == child.pid and seen["main"] and seen["blocked"] == 0
    assert ["SIG_DFL" in seen["handlers"][0], "default_int_handler" in seen["handlers"][1], "SIG_IGN" in seen["handlers"][2]] == [True] * 3
    assert seen["comm"] == module and seen["cmdline"] == ["-m", module]
    assert child.returncode == 7


def test_its_faults_and_last_words_come_out_of_its_pipe(module: str) -> None:
    with start(module, "raise") as child:
        words, _ = child.communicate(timeout=30)
    assert child.returncode == 1 and b"ValueError: a fault of the child" in words
    with start(module, "exit") as child:
        words, _ = child.communicate(timeout=30)
    assert child.returncode == 1 and words == b"a last word\n"


def test_a_signal_ends_it_although_its_parent_handles_that_signal(module: str) -> None:
    caught: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: caught.append(number))
    try:
        with start(module, "wait") as child:
            assert child.stdout is not None and child.stdout.readline() == b"ready\n"
            child.terminate()
            assert child.wait(10) == -signal.SIGTERM
    finally:
        signal.signal(signal.SIGTERM, before)
    assert not caught and signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set()


def test_what_the_parent_has_not_written_yet_is_written_once(module: str, tmp_path: pathlib.Path) -> None:
    with (tmp_path / "kept").open("w") as file:
        file.write("half a line")
        with start(module, "raise") as child:
            child.communicate(timeout=30)
    assert (tmp_path / "kept").read_text() == "half a line"


def test_a_module_that_is_not_there_is_reported(module: str) -> None:
    with start("no_such_module") as child:
        words, _ = child.communicate(timeout=30)
    assert child.returncode == 1 and b"ModuleNotFoundError" in words
