"""Issue 6, retained data: a death at any write leaves the old or the new state; a damaged file is set aside and named (AX-423, AX-424)."""

import pathlib
import random
import shutil
import sqlite3
import subprocess
import sys
import time

import pytest

from gateway.runtime.retained import store as retainfile
from gateway.runtime.retained import writer as retain
from gateway.runtime.retained.store import FOR_GOOD, HISTORY, RetainError, RetainFile, open_file
from gateway.runtime.retained.writer import Retained, append, history
from hil_tests.lab.running.retain_writer import NAMES

KILLS = 10
PATTERNS = ("flags.M*", "counter.*", "order.*")


def whole_state(file: RetainFile) -> int:
    """The number all values hold; 0: nothing was ever written.  Asserts that no write is there by half."""
    values, spoiled = file.values()
    assert spoiled == []
    if not values:
        return 0
    assert len(set(values.values())) == 1 and len(values) == len(NAMES), "a mixture of two writes"
    number = int(str(values[NAMES[0]]))
    assert [int(str(record["number"])) for record in file.history("error")][-1] == number
    return number


def test_a_writer_killed_at_any_moment_leaves_the_old_or_the_new_state(tmp_path: pathlib.Path) -> None:
    path, dice, reached = tmp_path / "kept.sqlite", random.Random(424), 0
    for _ in range(KILLS):
        command = [sys.executable, "-m", "hil_tests.lab.running.retain_writer", str(path), str(reached)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as writer:
            assert writer.stdout is not None
            first = writer.stdout.readline()
            time.sleep(dice.uniform(0.0, 0.03))
            writer.kill()
            told = [int(line) for line in (first + writer.stdout.read()).split(b"\n")[:-1]]
        opened = open_file(path)
        found = whole_state(opened.file)
        opened.file.close()
        assert opened.events == ()
        assert told and found in (told[-1], told[-1] + 1), "what was told to be on the disk is there, and at most the write after it"
        reached = found
    assert reached >= KILLS


def test_a_log_cut_or_spoiled_at_any_byte_gives_one_of_the_written_states(tmp_path: pathlib.Path) -> None:
    path, cut = tmp_path / "kept.sqlite", tmp_path / "cut.sqlite"
    file = open_file(path).file
    for number in range(1, 7):
        file.write(dict.fromkeys(NAMES, number), [("error", {"number": number})])
    log = path.with_name(path.name + "-wal").read_bytes()
    dice, seen = random.Random(6), set()
    for at in sorted(dice.sample(range(len(log)), 40)):
        for spoiled in (log[:at], log[:at] + bytes([log[at] ^ 0x5A]) + log[at + 1 :]):
            shutil.copy(path, cut)
            cut.with_name(cut.name + "-wal").write_bytes(spoiled)
            cut.with_name(cut.name + "-shm").unlink(missing_ok=True)
            opened = open_file(cut)
            seen.add(whole_state(opened.file))
            opened.file.close()
            assert opened.events == ()
    file.close()
    assert {1, 2, 3, 4, 5} <= seen <= set(range(7))


@pytest.mark.parametrize("damage", ["garbage", "cut", "page", "stranger", "older"])
def test_a_damaged_file_is_set_aside_and_named_and_defaults_count(tmp_path: pathlib.Path, damage: str) -> None:
    path = tmp_path / "kept.sqlite"
    kept = Retained(path, PATTERNS)
    kept.keep("counter.1", 77)
    kept.close()
    body = path.read_bytes()
    match damage:
        case "garbage":
            path.write_bytes(b"no database at all" * 400)
        case "cut":
            path.write_bytes(body[: len(body) // 2])
        case "page":
            path.write_bytes(body[:100] + bytes(4096 - 100) + body[4096:])
        case "stranger" | "older":
            with sqlite3.connect(path) as connection:
                connection.execute("PRAGMA application_id = 4711" if damage == "stranger" else "PRAGMA user_version = 99")
            connection.close()
    told: list[str] = []
    with pytest.raises(RetainError, match="damaged"):
        history(path, "error")  # a tool that only reads touches nothing
    again = Retained(path, PATTERNS, told.append)
    assert again.value("counter.1", 5) == 5
    again.keep("counter.1", 6)
    assert again.flush()
    again.close()
    aside = [each.name for each in tmp_path.iterdir() if ".damaged-" in each.name and not each.name.endswith("-wal")]
    assert len(aside) == 1 and len(told) == 1 and str(path) in told[0] and aside[0] in told[0]
    assert Retained(path, PATTERNS).value("counter.1", 5) == 6


def test_a_changed_byte_sqlite_does_not_see_is_named_and_its_default_counts(tmp_path: pathlib.Path) -> None:
    path, told = tmp_path / "kept.sqlite", list[str]()
    kept = Retained(path, PATTERNS)
    kept.keep_all({"order.text": "PALLET-A", "counter.1": 3})
    kept.close()
    path.write_bytes(path.read_bytes().replace(b"PALLET-A", b"PALLET-B"))
    again = Retained(path, PATTERNS, told.append)
    assert (again.value("order.text", "none"), again.value("counter.1", 0)) == ("none", 3)
    again.close()
    assert len(told) == 1 and "order.text" in told[0]


def test_only_what_changed_is_written_and_only_what_the_cell_names(tmp_path: pathlib.Path) -> None:
    kept = Retained(tmp_path / "kept.sqlite", ("flags.M1*", "counter.*"))
    kept.keep_block("flags.M", bytes(range(30)))
    kept.keep_all({"counter.1": 1, "counter.2": float("nan"), "counter.3": 1 << 70})
    assert kept.flush() and kept.writes >= 1
    writes = kept.writes
    kept.keep_block("flags.M", bytes(range(30)))
    kept.keep("counter.1", 1)
    assert kept.flush() and kept.writes == writes
    kept.close()
    values, _ = open_file(tmp_path / "kept.sqlite").file.values()
    assert values == {"flags.M1": 1, **{f"flags.M{n}": n for n in range(10, 20)}, "counter.1": 1}
    again = Retained(tmp_path / "kept.sqlite", ("flags.M1*",))
    assert again.block("flags.M", 21) == bytes([0, 1, *[0] * 8, *range(10, 20), 0])
    assert again.value("counter.1", 9) == 9, "no longer named by the cell"
    for forbidden in ("move.start", "rc_in.26", "drives.on"):
        with pytest.raises(ValueError, match="not kept over a restart"):
            again.keep(forbidden, 1)


def test_a_folder_that_cannot_be_written_is_reported_and_nothing_stops(tmp_path: pathlib.Path) -> None:
    (tmp_path / "in_the_way").write_text("a file where the folder should be")
    told: list[str] = []
    kept = Retained(tmp_path / "in_the_way" / "kept.sqlite", PATTERNS, told.append)
    kept.keep("counter.1", 1)
    assert (kept.on, kept.flush(), len(told)) == (False, False, 1)
    assert "nothing of this run is retained" in told[0]
    kept.close()


def test_a_locked_file_is_tried_again_and_nobody_waits(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retainfile, "BUSY_S", 0.05)
    monkeypatch.setattr(retain, "RETRY_S", 0.1)
    path, told = tmp_path / "kept.sqlite", list[str]()
    kept = Retained(path, PATTERNS, told.append)
    lock = sqlite3.connect(path, isolation_level=None)
    lock.execute("BEGIN IMMEDIATE")
    kept.keep("counter.1", 1)
    until = time.monotonic() + 20
    while not told and time.monotonic() < until:
        kept.keep("counter.1", kept.value("counter.1", 0))
        time.sleep(0.05)
    assert len(told) == 1 and "locked" in told[0] and kept.failures >= 1
    kept.keep("counter.1", 2)
    lock.execute("ROLLBACK")
    lock.close()
    assert kept.flush(20.0) and told[-1] == "retained data: written again"
    kept.close()
    assert Retained(path, PATTERNS).value("counter.1", 0) == 2


def test_histories_keep_the_newest_and_zeros_for_good(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "kept.sqlite"
    file = open_file(path).file
    file.write({}, [(kind, {"n": n}) for kind in ("error", "zero") for n in range(HISTORY + 50)])
    file.close()
    append(path, "error", {"n": HISTORY + 50})
    append(path, "zero", {"n": HISTORY + 50})
    assert "zero" in FOR_GOOD
    assert [record["n"] for record in history(path, "error")] == list(range(51, HISTORY + 51))
    assert [record["n"] for record in history(path, "zero")] == list(range(HISTORY + 51))
