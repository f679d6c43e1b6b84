"""A full disk, a standard output nobody takes, a terminal that hangs up: no process of a run ends, and motion goes on (AX-620)."""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

from drivers.ports.base import runtime_dir
from gateway.runtime.supervisor_client import ask, wait_up
from hil_tests.lab.partners.plc2 import PTP
from hil_tests.lab.running.cell_running import ALL, COMES_UP_S, P5_MS, TARGET, left_over, running_cell, runtime_folder

SLUG = "hostile"


def entries(path: pathlib.Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text().splitlines() if line]


def test_a_hang_up_ends_no_process_and_stops_no_motion() -> None:
    with running_cell(name=SLUG) as run:
        run.ready()
        pids = {name: process["pid"] for name, process in run.processes().items()}
        start = run.under_way(0.3)
        for _ in range(3):
            for pid in (run.process.pid, *pids.values()):
                os.kill(int(str(pid)), signal.SIGHUP)
            time.sleep(0.1)
        run.plc.wait(lambda s: s.in_position == ALL, 20)
        assert {name: process["pid"] for name, process in run.processes().items()} == pids
        run.arrived(TARGET)
        told = [entry["text"] for entry in run.journal("process") if entry["ns"] > start]
        assert told == ["the terminal or session has ended (SIGHUP); the run continues; to end it: axisgate stop hostile"]
        run.command(PTP, ALL, 0.5, TARGET)


@contextlib.contextmanager
def raw_run(folder: pathlib.Path, stdout: int) -> "Iterator[subprocess.Popen[bytes]]":
    command = [sys.executable, "-m", "gateway", "run", "demo", "--sim", "--name", SLUG, "--p5", str(max(P5_MS, 20)), "--die-with-parent"]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        assert wait_up(SLUG, COMES_UP_S), process.poll()
        yield process
    finally:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(15)
        process.kill()
        process.wait()


def pids() -> dict[str, object]:
    with ask(SLUG, "status") as connection:
        return {each["name"]: each["pid"] for each in json.loads(connection.makefile().readline())["processes"]}


def restart(name: str) -> None:
    """A process dies: lines for the journal and for the person."""
    dead = pids()[name]
    assert isinstance(dead, int)
    os.kill(dead, signal.SIGKILL)
    until = time.monotonic() + 10
    while pids()[name] in (dead, None):
        assert time.monotonic() < until, f"{name} did not respond again"
        time.sleep(0.05)


def test_a_standard_output_that_is_closed_ends_nothing_and_is_reported_once() -> None:
    with runtime_folder() as folder:
        read, write = os.pipe()
        with raw_run(folder, write) as process:
            os.close(write)
            os.close(read)
            before = pids()
            restart("line-plc1")
            time.sleep(0.3)
            assert process.poll() is None
            assert {name: pid for name, pid in pids().items() if name != "line-plc1"} == {
                name: pid for name, pid in before.items() if name != "line-plc1"
            }
            said = [entry for entry in entries(runtime_dir() / SLUG / "journal.jsonl") if "standard output" in str(entry["text"])]
            assert [entry["text"] for entry in said] == [
                "standard output accepts no more lines (Broken pipe); the run continues, the journal is complete"
            ]
        assert process.returncode == 0
        assert not left_over(folder)


def test_a_full_disk_ends_nothing_and_the_journal_says_what_it_lacks_when_there_is_room_again() -> None:
    with runtime_folder() as folder:
        journal = runtime_dir() / SLUG / "journal.jsonl"
        journal.parent.mkdir(parents=True)
        journal.symlink_to("/dev/full")
        with (folder / "run.log").open("wb") as log, raw_run(folder, log.fileno()) as process:
            before = pids()
            restart("services")
            time.sleep(0.5)
            assert process.poll() is None
            assert {name: pid for name, pid in pids().items() if name != "services"} == {
                name: pid for name, pid in before.items() if name != "services"
            }
            words = (folder / "run.log").read_text()
            assert words.count(f"the journal {journal} is not written: No space left on device") == 1, words
            journal.unlink()  # somebody made room
            restart("services")
            found = [entry for entry in entries(journal) if entry["kind"] == "alarm"]
            assert any(str(entry["text"]).startswith("the journal is written again; ") and int(str(entry["lost"])) > 5 for entry in found)
        assert process.returncode == 0
