"""The journal and the standard output of a run: a full disk, a reader that left and a stopped terminal end nothing and hold up nothing."""

import json
import os
import pathlib
import pty
import select
import termios
import time

import pytest

from gateway.runtime.console import Console
from gateway.runtime.journal import Journal, JournalReader, turn_over

LIMIT = 4096


def texts(path: pathlib.Path) -> list[str]:
    return [json.loads(line)["text"] for line in path.read_text().splitlines() if line]


def test_a_full_disk_is_counted_and_reported_when_it_is_over(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.symlink_to("/dev/full")
    journal, other = Journal(path, "services"), Journal(path, "planner")
    for n in range(5):
        journal.write("link", f"lost {n}")
    assert (journal.lost, journal.lost_in_all) == (5, 5)
    path.unlink()  # room again
    journal.write("link", "back")
    other.write("link", "was never full here")
    assert texts(path) == [
        "the journal is written again; 5 records of services are lost (No space left on device)",
        "back",
        "was never full here",
    ]
    assert (journal.lost, journal.lost_in_all) == (0, 5)
    journal.write("link", "after")
    assert texts(path)[-1] == "after", "reported once"


def test_a_folder_that_is_gone_stops_nobody(tmp_path: pathlib.Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    journal = Journal(folder / "journal.jsonl", "cycle")
    journal.write("process", "one")
    (folder / "journal.jsonl").unlink()
    folder.rmdir()
    journal.write("process", "two")
    folder.mkdir()
    journal.write("process", "three")
    assert [text.partition(";")[0] for text in texts(folder / "journal.jsonl")] == ["the journal is written again", "three"]


def test_a_torn_last_line_stays_a_line_of_its_own(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b'{"text": "whole"}\n{"text": "cut by a power fai')
    Journal(path, "supervisor").write("process", "the next run")
    lines = path.read_text().splitlines()
    assert len(lines) == 3 and json.loads(lines[2])["text"] == "the next run"


def test_the_journal_turns_over_while_several_processes_write_and_keeps_its_bound(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "journal.jsonl"
    writers = [Journal(path, f"process {n}", limit=LIMIT) for n in range(3)]
    reader = JournalReader(path)
    seen: list[str] = []
    for n in range(300):
        writers[n % 3].write("link", f"entry {n}")
        seen += [json.loads(line)["text"] for line in reader.lines()]
        assert sum(each.stat().st_size for each in tmp_path.iterdir()) <= 2 * (LIMIT + 512)
    seen += [json.loads(line)["text"] for line in reader.lines()]
    assert seen == [f"entry {n}" for n in range(300)], "a reader that follows misses none"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["journal.jsonl", "journal.jsonl.1"]
    assert texts(path.with_suffix(".jsonl.1"))[-1:] + texts(path)[:1], "both hold whole lines"


def test_only_a_journal_beyond_its_limit_is_turned_over(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_text("x" * 100)
    turn_over(path, 101)
    assert path.exists()
    turn_over(path, 100)
    assert not path.exists()


def test_a_reader_that_went_away_ends_nothing_and_is_reported_once() -> None:
    read, write = os.pipe()
    console = Console(write)
    console.say("one")
    assert os.read(read, 100) == b"one\n"
    os.close(read)
    for n in range(100):
        console.say(f"line {n}")
    assert console.lost == 100
    assert console.take_news() == ["standard output accepts no more lines (Broken pipe); the run continues, the journal is complete"]
    assert console.take_news() == []
    console.close()
    os.close(write)


def test_a_pipe_nobody_reads_holds_up_nothing_and_says_how_many_lines_are_missing() -> None:
    read, write = os.pipe()
    console = Console(write)
    began = time.monotonic()
    for _ in range(2000):
        console.say("x" * 99)
    assert time.monotonic() - began < 5
    assert 1200 < console.lost < 1500, "64 KiB went into the pipe"
    taken = b""
    while select.select((read,), (), (), 0)[0]:
        taken += os.read(read, 65536)
    console.say("it is read again")
    taken += os.read(read, 65536)
    assert taken.splitlines()[-2:] == [b"(" + str(2000 - len(taken.splitlines()[:-2])).encode() + b" lines were not shown: it is stopped)",
                                       b"it is read again"]  # fmt: skip
    assert [news.partition(" (")[0].partition(";")[0] for news in console.take_news()] == [
        "standard output accepts no more lines",
        "standard output accepts lines again",
    ]
    assert os.get_blocking(write), "the open file that others share is as it was"
    console.close()
    os.close(read)
    os.close(write)


def test_a_stopped_terminal_holds_up_nothing() -> None:
    ours, theirs = pty.openpty()
    console = Console(theirs)
    termios.tcflow(theirs, termios.TCOOFF)  # as Ctrl-S
    began = time.monotonic()
    for _ in range(1000):
        console.say("x" * 99)
    assert time.monotonic() - began < 5 and console.lost >= 990
    termios.tcflow(theirs, termios.TCOON)
    os.close(ours)  # and the terminal hangs up
    console.say("hung up")
    console.close()
    os.close(theirs)


@pytest.mark.parametrize("wanted", ["/dev/full"])
def test_a_full_disk_behind_standard_output_ends_nothing(wanted: str) -> None:
    fd = os.open(wanted, os.O_WRONLY)
    console = Console(fd)
    console.say("one")
    console.say("two")
    assert console.lost == 2 and "No space left" in console.take_news()[0]
    console.close()
    os.close(fd)
    Console(fd).say("closed: nobody is there, nothing is raised")
