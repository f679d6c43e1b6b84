"""What `run --record` keeps: bounded whatever floods it, and a full disk is counted (AX-623)."""

import os
import pathlib

from drivers.ports.can.wire import RECORD
from drivers.ports.serial.line_format import Note
from gateway.links.serial.dialogue_log import JournalFile
from gateway.runtime.bounded_file import BoundedFile
from gateway.simulation.bus.log import log_file, write_log
from gateway.simulation.line.cable import Recorder

LIMIT, BUS_LIMIT = 8192, 200_000


def remark(lines: int, reason: str) -> bytes:
    return f"# {lines} lost: {reason}\n".encode()


def test_a_flood_stays_within_its_bound_and_the_newest_is_kept(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "bus.log"
    file = BoundedFile(path, b"# head\n", remark, LIMIT)
    for n in range(5000):
        file.write(f"line {n}\n".encode())
        assert sum(each.stat().st_size for each in tmp_path.iterdir()) <= 2 * LIMIT
    file.close()
    old, new = (tmp_path / "bus.log.1").read_text().splitlines(), path.read_text().splitlines()
    assert old[0] == new[0] == "# head"
    kept = [int(line.split()[1]) for line in old[1:] + new[1:]]
    assert kept == list(range(kept[0], 5000)), "whole lines, none missing in between"


def test_a_full_disk_is_counted_and_said_when_there_is_room_again(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "bus.log"
    path.symlink_to("/dev/full")
    file = BoundedFile(path, b"# head\n", remark, LIMIT)
    for _ in range(10):
        file.write(b"a\nb\n", 2)
    assert file.lost == 21
    fd = os.open(tmp_path / "room", os.O_WRONLY | os.O_CREAT)
    os.dup2(fd, file._fd)
    file.write(b"c\n")
    assert (tmp_path / "room").read_bytes() == b"# 21 lost: No space left on device\nc\n" and file.lost == 0


def test_the_log_of_a_bus_is_bounded(tmp_path: pathlib.Path) -> None:
    inside, outside = os.pipe()
    if not (child := os.fork()):
        os.close(inside)
        for n in range(20_000):
            os.write(outside, RECORD.pack(0x85, 8, 1, bytes(8), n * 1000, n))
        os._exit(0)
    os.close(outside)
    write_log(inside, log_file(str(tmp_path / "bus.log"), "t", BUS_LIMIT), "t")
    os.waitpid(child, 0)
    os.close(inside)
    assert sum(each.stat().st_size for each in tmp_path.iterdir()) <= 2 * BUS_LIMIT
    assert (tmp_path / "bus.log").read_text().startswith("# axisgate broker:t;")
    assert " 19999 " in (tmp_path / "bus.log").read_text()


def test_each_part_of_a_line_s_journal_begins_with_its_head(tmp_path: pathlib.Path) -> None:
    file = JournalFile(tmp_path / "line-plc.txt")
    file.write("dialogue plc\n")
    file.write("0 hears 02\n")
    assert (tmp_path / "line-plc.txt").read_text() == "dialogue plc\n0 hears 02\n"


def test_the_record_of_a_simulated_line_outlives_a_full_disk() -> None:
    with open("/dev/full", "w", encoding="ascii") as file:
        recorder = Recorder(file, 1000)
        recorder.add(Note(5, "unplugged"))
        recorder.flush()
        assert recorder.unrecorded == 1 and not recorder.waiting
