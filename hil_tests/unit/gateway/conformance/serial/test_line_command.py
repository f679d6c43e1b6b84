"""`axisgate line` as it is typed: what is not a number, no port, no record; what a pulled adapter, a full disk and Ctrl-C leave behind."""

import contextlib
import errno
import io
import json
import os
import pathlib
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import parse_format
from drivers.ports.serial.pty import PtyPort
from gateway.commands import line
from gateway.conformance.serial.run import Settings, probe
from gateway.links.serial.line_monitor import Recorder, replay
from gateway.tools.line.client import Client
from gateway.tools.line.learn import characters


def axisgate(*words: str) -> tuple[int, str, str]:
    """Exit code, standard output, standard error."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = line.main(list(words))
        except SystemExit as end:
            code = int(str(end.code))
    return code, out.getvalue(), err.getvalue()


@pytest.fixture
def pty() -> Iterator[tuple[int, str]]:
    """The far end, and the name of a foreign terminal nobody answers at."""
    master, slave = os.openpty()
    yield master, os.ttyname(slave)
    for fd in (master, slave):
        with contextlib.suppress(OSError):
            os.close(fd)


@pytest.mark.parametrize(
    "words, expected",
    [
        (("fetch", "sim:good", "FFFF"), "'FFFF': a data word expected, such as DB10.DW2 or DB10.DD2\n"),
        (("fetch", "sim:good", "DB10"), "'DB10': a data word expected, such as DB10.DW2 or DB10.DD2\n"),
        (("fetch", "sim:good", "DB10.DW300"), "data words are 0..255"),
        (("fetch", "sim:good", "DB10.DW200", "--count", "65"), "65 data words from DW200 on: at most 64; a telegram begins at DW 0..255"),
        (("fetch", "sim:good", "DB10.DW0", "--count", "999999999999"), "at most 256; a telegram begins at DW 0..255 and has 64 words"),
        (("send", "sim:good", "DB10.DW255", "--type", "KF", *["1"] * 65), "65 data words from DW255 on: at most 64"),
        (("fetch", "sim:good", "DB10.DW0", "--wait", "nan"), "'nan': seconds above 0 expected, at most 31536000"),
        (("fetch", "sim:good", "DB10.DW0", "--wait", "1e300"), "'1e300': seconds above 0 expected"),
        (("fetch", "sim:good", "DB10.DW0", "--wait", "-1"), "'-1': seconds above 0 expected"),
        (("monitor", "sim:good", "--seconds", "soon"), "'soon': seconds above 0 expected"),
        (("probe", "sim:good", "--db", "300"), "'300': number of a data block expected, 0..255"),
        (("probe", "sim:good", "--missing-db", "-1"), "'-1': number of a data block expected, 0..255"),
        (("monitor", "--record", __file__), "neither a line record nor a journal"),
        (("monitor", "--tap", "/dev/pts/9,/dev/pts/9"), "two different ports expected, one in each wire"),
        (("learn", "--tap", "COM5,COM5"), "two different ports expected, one in each wire"),
        (("learn", "/tmp"), "/tmp: a file expected; --tap A,B listens live"),
    ],
)
def test_what_cannot_be_is_a_usage_fault_in_words(words: tuple[str, ...], expected: str) -> None:
    code, _, told = axisgate(*words)
    assert code == 2 and expected in told, told


def test_a_device_in_the_place_of_a_trace_is_not_read_for_ever(pty: tuple[int, str]) -> None:
    for words in (("learn", pty[1]), ("monitor", "--record", pty[1])):
        code, _, told = axisgate(*words)
        assert code == 2 and "a file expected; --tap A,B listens live" in told


@pytest.mark.parametrize("port, why", [("/dev/null", "is not a serial port"), ("/dev", "is a folder; name a serial port")])
def test_what_is_no_serial_port_is_named_so(port: str, why: str) -> None:
    code, _, told = axisgate("fetch", port, "DB10.DW0")
    assert code == 3 and f"serial port {port}: {why}" in told


def test_a_record_on_a_full_disk_is_named(pty: tuple[int, str]) -> None:
    code, _, told = axisgate("monitor", pty[1], "--save", "/dev/full", "--seconds", "5")
    assert code == 3 and told == "axisgate line monitor: /dev/full: nothing more can be kept: No space left on device\n"


def test_a_pulled_adapter_is_not_said_to_be_opened_again(pty: tuple[int, str]) -> None:
    threading.Timer(0.2, os.close, (pty[0],)).start()
    code, _, told = axisgate("fetch", pty[1], "DB10.DW0")
    assert code == 3 and told == f"axisgate line fetch: serial port {pty[1]}: lost (hung up)\n"


def test_what_was_heard_before_an_adapter_was_pulled_is_learned(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    record = tmp_path / "line.rec"
    block = bytes.fromhex("02000045440A000001FFFF100319")
    reaction = bytes.fromhex("0200000000123410033" + "5")
    at, lines = 0, list[str]()
    for side, data in (("A", block[:1]), ("B", b"\x10"), ("A", block[1:]), ("B", b"\x10"), ("B", reaction[:1]), ("A", b"\x10"),
                       ("B", reaction[1:]), ("A", b"\x10")):  # fmt: skip
        for byte in data:
            at += 2_000_000
            lines.append(f"{at} {side} {byte:02x}\n")
    record.write_text("".join(lines))

    def listen(arguments: object, names: object, tell: Any) -> None:
        replay(characters(record.read_text()), tell)
        raise PortError(errno.EIO, "serial port x: lost (hung up); it is opened again when the adapter is back")

    monkeypatch.setattr(line, "_listen", listen)
    code, draft, told = axisgate("learn", "--tap", "COM5,COM6")
    assert told == "axisgate line learn: serial port x: lost (hung up): learned from what was received until then\n"
    assert code == 0 and "number  = 10" in draft


class FullDisk(io.StringIO):
    name = "line.rec"
    room = 1  # lines

    def write(self, text: str) -> int:
        if not self.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.room -= 1
        return super().write(text)


@pytest.mark.parametrize("room", [0, 1])
def test_a_full_disk_is_named_with_its_file(room: int) -> None:
    disk = FullDisk()
    disk.room = room
    with pytest.raises(OSError, match="nothing more can be kept: No space left") as told:
        Recorder(disk, "tap", parse_format("9600 8E1"), 0)(1, "A", 2)
    assert told.value.filename == "line.rec"


def test_a_pty_of_another_user_is_not_called_absent(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: str, flags: int) -> int:
        raise PermissionError(errno.EACCES, "Permission denied", path)

    monkeypatch.setattr("drivers.ports.serial.pty.os.open", refuse)
    with pytest.raises(PortError, match=r"Permission denied; it belongs to another user \(ls -l\)"):
        PtyPort("/dev/pts/0", parse_format("9600 8E1"))


def test_a_probe_refuses_each_name_of_only_that_is_no_test() -> None:
    code, out, told = axisgate("probe", "sim:good", "--only", "idle.nak", "--only", "nonsense")
    assert (code, out) == (2, "") and "--only nonsense: no such test" in told


def test_a_probe_whose_report_cannot_be_kept_still_says_what_it_found(tmp_path: pathlib.Path) -> None:
    code, out, told = axisgate("probe", "sim:good", "--only", "idle.nak", "--report", str(tmp_path / "missing" / "r"))
    assert code == 3 and "1 PASS" in out and "report:" not in out
    assert told == f"axisgate line probe: report {tmp_path / 'missing' / 'r.json'} cannot be written: No such file or directory\n"


def interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_ctrl_c_in_a_job_is_no_success(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Client, "ask", interrupt)
    for words in (("fetch", "sim:good", "DB10.DW0"), ("send", "sim:good", "DB10.DW0", "--type", "KF", "1")):
        assert axisgate(*words)[::2] == (130, f"axisgate line {words[0]}: interrupted before its end\n")


def test_ctrl_c_in_a_probe_leaves_its_report(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    def broken(wire: Any, settings: Settings, operator: Any, told: Any) -> None:
        probe(wire, settings, operator, told)
        raise KeyboardInterrupt

    monkeypatch.setattr(line, "probe", broken)
    code, out, _ = axisgate("probe", "sim:good", "--only", "idle.nak", "--report", str(tmp_path / "r"))
    assert code == 130 and "1 PASS" in out
    assert json.loads((tmp_path / "r.json").read_text())["device"]["Broken off"] == "after 1 test: Ctrl-C"
