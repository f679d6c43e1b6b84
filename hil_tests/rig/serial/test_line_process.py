"""The line process over real ptys: pace, damage in line order, plug, adapters, nobody reading, its end."""

import os
import pathlib
import subprocess
import sys
import time
from collections.abc import Callable

import pytest

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import Run
from hil_tests.rig.serial.conftest import Rig, hear, pace_ns
from protocols.base.machine import Damage

CHAR_NS = 11_000_000_000 / 9600
LineStarter = Callable[..., Rig]


def said(items: list[bytes | Damage]) -> bytes:
    """The good characters."""
    return b"".join(item for item in items if isinstance(item, bytes))


def test_characters_take_their_time_on_the_line(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    a, b = rig.port("a"), rig.port("b")
    text = bytes(range(256))
    before = time.monotonic_ns()
    assert a.write(text) == 256
    assert said(hear(b, lambda items: len(items) == 256)) == text
    stamps = rig.record().stamps("A")
    assert len(stamps) == 256
    for index, stamp in enumerate(stamps, 1):
        assert stamp - before >= index * CHAR_NS, f"character {index} came before the end of its character time"
    assert abs(pace_ns(stamps) / CHAR_NS - 1) < 0.01


def test_both_directions_run_at_the_same_time(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    a, b = rig.port("a"), rig.port("b")
    a.write(b"A" * 100)
    b.write(b"B" * 100)
    hear(b, lambda items: len(items) == 100)
    hear(a, lambda items: len(items) == 100)
    runs = rig.record().runs
    spans = {side: [run.stamp_ns for run in runs if run.side == side] for side in "AB"}
    together = max(stamps[-1] for stamps in spans.values()) - min(stamps[0] for stamps in spans.values())
    assert together < 120 * CHAR_NS


def test_unsent_reports_when_the_last_character_has_left(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    a, b = rig.port("a"), rig.port("b")
    a.write(bytes(50))
    assert a.unsent() == 50
    while a.unsent():
        time.sleep(0.0005)
    empty_ns = time.monotonic_ns()
    hear(b, lambda items: len(items) == 50)
    last = rig.record().runs[-1].stamp_ns
    assert abs(empty_ns - last) < 20_000_000


def test_damage_comes_in_line_order_with_the_bytes(line: LineStarter) -> None:
    rig = line("--baud", "19200")
    a, b = rig.port("a"), rig.port("b")
    rig.control.damage("A", "parity", 2)
    rig.control.damage("A", "framing", 4)
    rig.control.damage("A", "overrun", 6)
    rig.control.damage("A", "break", 8)
    rig.control.damage("A", "drop", 10)
    a.write(b"1234567\xff9A\xff")
    items = hear(b, lambda items: len(items) >= 10)
    assert items == [b"1", Damage.PARITY, b"3", Damage.FRAMING, b"5", Damage.OVERRUN, b"7", Damage.BREAK, b"9", b"\xff"]
    marks = [run.mark for run in rig.record().runs for _ in run.data]
    assert marks == ["", "parity", "", "framing", "", "overrun", "", "break", "", "drop", ""]


def test_break_and_noise_come_as_if_the_sender_had_sent_them(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    b = rig.port("b")
    rig.control.noise("A", b"one")
    rig.control.send_break("A")
    rig.control.noise("A", b"two")
    assert hear(b, lambda items: len(items) == 7) == [b"o", b"n", b"e", Damage.BREAK, b"t", b"w", b"o"]


def test_bytes_vanish_at_the_unplugged_cable_and_are_recorded(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    a, b = rig.port("a"), rig.port("b")
    cut = rig.control.unplug()
    a.write(b"nobody")
    b.write(b"hears")
    hear(b, lambda items: rig.control.status()["lost"] == 11)
    back = rig.control.plug()
    a.write(b"again")
    assert said(hear(b, lambda items: len(items) == 5)) == b"again", "plugged: back at once, nothing old comes out"
    assert a.read() == []
    runs = rig.record().runs
    assert b"".join(run.data for run in runs if run.side == "A" and run.mark == "lost") == b"nobody"
    assert b"".join(run.data for run in runs if run.side == "B" and run.mark == "lost") == b"hears"
    assert all(cut < run.stamp_ns < back for run in runs if run.mark == "lost")
    assert [note.text for note in rig.record().notes][1:] == ["unplug", "plug"]
    assert runs[-1].mark == ""


def test_characters_under_way_are_lost_from_the_moment_of_the_break(line: LineStarter) -> None:
    rig = line("--baud", "1200")
    a, b = rig.port("a"), rig.port("b")
    text = bytes(range(48, 108))
    a.write(text)
    hear(b, lambda items: len(items) == 3)
    cut = rig.control.unplug()
    hear(b, lambda items: rig.control.status()["waiting"]["A"] == 0)
    runs = rig.record().runs
    assert b"".join(run.data for run in runs) == text
    assert [run.mark for run in runs] == ["lost" if run.stamp_ns > cut else "" for run in runs]
    assert 0 < sum(len(run.data) for run in runs if run.mark) <= 57


def test_a_removed_adapter_hangs_its_port_up_and_comes_back_under_the_same_path(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    a, b = rig.port("a"), rig.port("b")
    rig.control.remove("A")
    with pytest.raises(PortError, match="wire0-a"):
        a.read()
    with pytest.raises(PortError, match="wire0-a"):
        rig.port("a")
    b.write(b"gone")
    hear(b, lambda items: rig.control.status()["lost"] == 4)
    rig.control.insert("A")
    again = rig.port("a")
    b.write(b"here")
    assert said(hear(again, lambda items: len(items) == 4)) == b"here"
    assert "gone" in [run.mark for run in rig.record().runs]


def test_nobody_reading_neither_stops_nor_grows_anything(line: LineStarter) -> None:
    rig = line("--baud", "0")
    a = rig.port("a")
    b = rig.port("b")
    status = pathlib.Path(f"/proc/{rig.process.pid}/status")

    def resident_kb() -> int:
        return next(int(row.split()[1]) for row in status.read_text().splitlines() if row.startswith("VmRSS"))

    def push(count: int) -> None:
        for _ in range(count):
            a.write(bytes(1000))
            rig.control.status()

    push(200)
    before = resident_kb()
    push(1500)
    assert rig.control.status()["overflow"] > 500_000
    assert resident_kb() - before < 500
    b.close()
    time.sleep(0.1)  # the kernel hands over what was written last
    b = rig.port("b")
    assert b.read() == [], "what came before anybody opened is not for us"
    a.write(b"fresh")
    assert said(hear(b, lambda items: len(items) == 5)) == b"fresh"


def test_a_writer_faster_than_the_line_is_held_back_not_hoarded(line: LineStarter) -> None:
    rig = line("--baud", "9600")
    a = rig.port("a")
    taken = 0
    for _ in range(400):
        taken += a.write(bytes(1000))
    assert taken < 100_000
    assert rig.control.status()["waiting"]["A"] <= 2 * 4096


def test_a_killed_client_leaves_the_line_in_order(line: LineStarter) -> None:
    rig = line("--baud", "0")
    b = rig.port("b")
    script = f"from drivers.ports.open import open_bytes; import time; p = open_bytes({rig.url('a')!r}, '0'); p.write(b'x'); time.sleep(60)"
    client = subprocess.Popen([sys.executable, "-c", script])
    assert said(hear(b, lambda items: len(items) == 1)) == b"x"
    client.kill()
    client.wait()
    a = rig.port("a")
    a.write(b"y")
    assert said(hear(b, lambda items: len(items) == 1)) == b"y"


def test_a_pty_has_one_user(line: LineStarter) -> None:
    rig = line("--baud", "0")
    first = rig.port("a")
    with pytest.raises(PortError, match="used by another program"):
        rig.port("a")
    first.close()
    rig.port("a").close()


def test_bad_commands_are_answered_and_change_nothing(line: LineStarter) -> None:
    rig = line("--baud", "0")
    for bad in (
        {"do": "dance"},
        {"do": "remove", "side": "C"},
        {"do": "damage", "from": "A", "kind": "rust"},
        {"do": "noise", "from": "B", "hex": "x"},
    ):
        with pytest.raises(ValueError, match="wire0"):
            rig.control._ask(**bad)
    assert rig.control.status()["plugged"] is True


def test_sigterm_removes_links_and_socket_and_a_second_of_the_same_name_is_refused(line: LineStarter, runtime: pathlib.Path) -> None:
    rig = line("--baud", "0")
    assert sorted(os.listdir(runtime)) == ["line-wire0.sock", "wire0-a", "wire0-b"]
    second = subprocess.run(
        [sys.executable, "-m", "gateway.simulation.line.process", "--name", "wire0"],
        capture_output=True,
        text=True,
        timeout=10,
        check=False,
    )
    assert (second.returncode, "another line process" in second.stderr) == (3, True)
    assert sorted(os.listdir(runtime)) == ["line-wire0.sock", "wire0-a", "wire0-b"]
    assert rig.end() == 0
    assert os.listdir(runtime) == []


def test_what_a_killed_line_process_left_does_not_stop_the_next(line: LineStarter, runtime: pathlib.Path, tmp_path: pathlib.Path) -> None:
    rig = line("--baud", "0")
    rig.process.kill()
    rig.process.wait()
    assert len(os.listdir(runtime)) == 3
    again = Rig("wire0", tmp_path, "--baud", "0")
    a, b = again.port("a"), again.port("b")
    a.write(b"z")
    assert said(hear(b, lambda items: len(items) == 1)) == b"z"
    assert again.end() == 0
    assert os.listdir(runtime) == []


def test_a_foreign_program_at_a_side_that_offers_marks_reads_characters_as_they_are(line: LineStarter) -> None:
    """AX-1400: marks are for a port that asks, also where one was there before and ended, or was killed with its descriptor."""
    rig = line("--baud", "0")
    a = rig.port("a")
    rig.port("b").close()
    foreign = os.open(rig.url("b")[4:], os.O_RDWR | os.O_NOCTTY)
    a.write(b"\xff\x00A\xff\xff")
    assert os.read(foreign, 16) == b"\xff\x00A\xff\xff"
    rig.control.damage("A", "parity")
    a.write(b"Z")
    assert len(os.read(foreign, 16)) == 1, "a wrong character in place of a mark"
    os.close(foreign)
    b = rig.port("b")
    rig.control.damage("A", "parity", 2)
    a.write(b"\xffZ\xff")
    assert hear(b, lambda items: len(items) == 3) == [b"\xff", Damage.PARITY, b"\xff"]


def test_a_plain_side_reads_characters_as_they_are(line: LineStarter) -> None:
    rig = line("--baud", "0", "--plain", "B")
    a = rig.port("a")
    b = os.open(rig.url("b")[4:], os.O_RDWR | os.O_NOCTTY)
    a.write(b"\xff\xff\x10")
    assert os.read(b, 16) == b"\xff\xff\x10"
    os.write(b, b"\xff\x00\x41")
    assert said(hear(a, lambda items: len(items) == 3)) == b"\xff\x00\x41"
    os.close(b)
    assert [run[1:3] for run in rig.record().runs] == [Run(0, "A", b"\xff\xff\x10")[1:3], Run(0, "B", b"\xff\x00\x41")[1:3]]
