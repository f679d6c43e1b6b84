"""What a restart brings back and what it must not, in a whole run (issue 6, retained data; AX-423, AX-425)."""

import contextlib
import json
import os
import pathlib
import signal
import sqlite3

import pytest

from gateway.cell_file.load import load_cell
from gateway.commands.backup import main as backup_command
from gateway.commands.restore import main as restore_command
from gateway.pure.cell.faults import CellFaults
from gateway.runtime.retained.writer import history
from gateway.runtime.supervisor_client import ask
from hil_tests.lab.running.cell_running import P5_MS, runtime_folder
from hil_tests.lab.running.joined_running import JoinedRun, cell_copy

NAME = "kept"
MORE = """
[controller]
kind = "rho3"
[rho3]
P14 = [9]
[retain]
values = ["order.*", "flags.M*", "counter.*"]
"""


def started(cell: pathlib.Path, folder: pathlib.Path) -> JoinedRun:
    return JoinedRun(cell, NAME, folder, "--p5", str(P5_MS))


def services_pid() -> int:
    with ask(NAME, "status") as connection:
        status = json.loads(connection.makefile().readline())
    return next(int(each["pid"] or 0) for each in status["processes"] if each["name"] == "services")


def kept_values(folder: pathlib.Path) -> dict[str, object]:
    """As they stand in the file now."""
    path = folder / "run" / NAME / "retain.sqlite"
    with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        return dict(connection.execute("SELECT name, data FROM value").fetchall())


def assert_back(run: JoinedRun) -> None:
    """Data as they were, marked stale; what starts something is not there."""
    number = run.ask(op="get", address="order.number")
    assert (number["value"], number["quality"], number["source"]) == (4711, "STALE", "retained")
    assert [run.value(address) for address in ("M 100.3", "M 100.4", "M 0.0", "Z 0")] == [1, 0, 1, 8], "a flag that stands counts nothing"
    assert run.value("order.new") == 0, "a signal is given by nobody"
    done = run.ask(op="get", address="order.done")
    assert done["quality"] == "BAD", "what sends a telegram"
    assert run.value("I 8.2") == 0 and run.ask(op="axes")["axes"][0]["flags"] == 0, "drives are off"


def test_values_come_back_after_a_kill_and_after_a_stop_and_start_bits_never(capsys: pytest.CaptureFixture[str]) -> None:
    with runtime_folder() as folder:
        cell, path = cell_copy("host-telegrams", folder, more=MORE), folder / "run" / NAME / "retain.sqlite"
        path.parent.mkdir(parents=True)
        path.write_bytes(b"spoiled" * 1000)  # the cell comes up all the same
        run = started(cell, folder)
        try:
            assert_told(path)
            assert run.value("Z 0") == 9, "its preset"
            for address, value in (("order.number", 4711), ("order.new", 1), ("order.done", 1), ("M 100.3", 1), ("M 0.0", 1)):
                answer = run.ask(op="set", address=address, value=str(value))
                assert answer.get("value") == value, answer
            run.until(lambda: run.value("Z 0") == 8, "the decrement flag counts")
            wanted = {"order.number": 4711, "counter.0": 8, "flags.M100": 8, "order.done": 1}
            run.until(lambda: wanted.items() <= kept_values(folder).items(), "it is on the disk")
            os.kill(services_pid(), signal.SIGKILL)
            run.until(lambda: run.value("order.number") == 4711, "services are back", 60.0)
            assert_back(run)
            assert run.ask(op="set", address="order.pallet", value="12")["value"] == 12
            assert backup_command([str(cell), "--to", str(folder / "saved.zip")]) == 0, "a running gateway goes on"
            assert restore_command([str(folder / "saved.zip"), "--to", str(folder), "--dry-run"]) == 3
            assert f"{NAME} is running this cell" in capsys.readouterr().err
        finally:
            run.stop()
        assert kept_values(folder)["order.pallet"] == 12, "an end in order writes what was new"
        run = started(cell, folder)
        try:
            assert_back(run)
        finally:
            run.stop()
        kept = history(path, "configuration")
        assert [record["text"] for record in kept] == [cell.read_text()], "the cell file did not change"


def assert_told(path: pathlib.Path) -> None:
    """The journal names the spoiled file and where it went."""
    told = [json.loads(line) for line in (path.parent / "journal.jsonl").read_text().splitlines()]
    named = [each["text"] for each in told if each["kind"] == "retain"]
    assert len(named) == 1 and str(path) in named[0] and ".damaged-" in named[0]


@pytest.mark.parametrize("pattern", ["move.*", "*", "rc_in.26", "drives.on", "order"])
def test_check_refuses_to_keep_what_may_start_something(tmp_path: pathlib.Path, pattern: str) -> None:
    cell = cell_copy("host-telegrams", tmp_path, more=MORE.replace("order.*", pattern))
    with pytest.raises(CellFaults) as refused:
        load_cell(str(cell))
    assert [(fault.key, pattern in str(fault)) for fault in refused.value.faults] == [("retain.values[1]", True)]


def test_check_says_what_a_cell_cannot_keep(tmp_path: pathlib.Path) -> None:
    cell = load_cell(str(cell_copy("demo", tmp_path, more='[retain]\nvalues = ["order.*", "flags.M*", "counter.*", "belt.*"]')))
    assert [notice.where for notice in cell.notes if notice.where.startswith("retain")] == [f"retain.values[{n}]" for n in (1, 2, 3, 4)]
