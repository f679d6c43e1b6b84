"""The bus tools on a running local bus and on files; tshark reads our pcapng, the broker's own log is the witness."""

import json
import pathlib
import shutil
import subprocess
import sys
import threading
import time

import can
import pytest

import gateway.tools.bus.log  # loaded before a test's clock runs
from drivers.ports.can.wire import EFF_FLAG, RTR_FLAG
from gateway.commands.bus import main
from gateway.tools.bus.logs import LogWriter, read_log
from hil_tests.lab.running.bus_running import Bus, running_bus
from protocols.base.can_bits import frame_bits
from protocols.base.machine import Frame

assert gateway.tools.bus.log
CYCLE = [Frame(100)] + [Frame(200 + 10 * n, bytes([3, n, n, 0, 0, 0, 0, n])) for n in range(1, 7)]


def playing(bus: Bus, cycles: int = 40, pause: float = 0.01) -> threading.Thread:
    def play() -> None:
        port = bus.port()
        time.sleep(0.5)
        for _ in range(cycles):
            port.send(CYCLE)
            time.sleep(pause)
        port.close()

    thread = threading.Thread(target=play)
    thread.start()
    return thread


@pytest.mark.parametrize("ending", [".log", ".asc", ".blf", ".trc", ".csv"])
def test_a_bus_is_recorded_and_read_back_frame_by_frame(tmp_path: pathlib.Path, ending: str, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / f"bus{ending}"
    with running_bus(tmp_path) as bus:
        thread = playing(bus, 10)
        assert main(["log", f"broker:{bus.name}", "-o", str(target), "--seconds", "1.5"]) == 0
        thread.join()
    assert "70 frames" in capsys.readouterr().out
    assert main(["monitor", "--from", str(target), "--json"]) == 0
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [(one["id"], one["data"]) for one in told] == 10 * [(frame.identifier, frame.data.hex()) for frame in CYCLE]
    assert main(["load", "--log", str(target), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bits"] == 10 * sum(frame_bits(frame.identifier, frame.data) for frame in CYCLE)


def test_the_brokers_own_log_is_read(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    with running_bus(tmp_path) as bus:
        playing(bus, 5).join()
        bus.stop()
        assert bus.log is not None
        assert main(["monitor", "--from", str(bus.log), "--json"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 35


def test_monitor_decodes_by_dbc_and_sums_up(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    with running_bus(tmp_path) as bus:
        thread = playing(bus)
        assert main(["monitor", f"broker:{bus.name}", "--dbc", "servodyn_gc.dbc", "--summary", "--seconds", "1.6"]) == 0
        thread.join()
    out = capsys.readouterr().out
    row = next(line for line in out.splitlines() if "220 (DCh)" in line)
    assert row.split()[2] == "40" and 9.0 < float(row.split()[3]) < 20.0 and "=" in row, out
    assert "280 frames" in out


@pytest.mark.tshark
def test_tshark_reads_our_pcapng(tmp_path: pathlib.Path) -> None:
    target = tmp_path / "bus.pcapng"
    with running_bus(tmp_path) as bus:
        thread = playing(bus, 3)
        assert main(["log", f"broker:{bus.name}", "-o", str(target), "--seconds", "1.2"]) == 0
        thread.join()
    fields = ["-T", "fields", "-e", "can.id", "-e", "can.len"]
    done = subprocess.run([shutil.which("tshark") or "tshark", "-r", str(target), *fields], capture_output=True, text=True, check=True)
    assert [line.split() for line in done.stdout.splitlines()] == 3 * [[str(f.identifier), str(len(f.data))] for f in CYCLE]


def test_replay_keeps_the_pace_and_the_choice(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "old.log"
    lines = [f"({n * 0.02:.6f}) can0 {identifier:03X}#{n:02X}\n" for n in range(20) for identifier in (100, 210, 610)]
    source.write_text("".join(lines))
    with running_bus(tmp_path) as bus:
        assert main(["replay", str(source), f"broker:{bus.name}", "--only", "100,210"]) == 0
        bus.stop()
        heard = [line.split() for line in bus.log_lines() if "#" in line and not line.startswith("#")]
    assert "40 of 40 frames sent, 0 refused" in capsys.readouterr().out
    assert [word[2].split("#")[0] for word in heard] == 20 * ["064", "0D2"]
    stamps = [float(word[0].strip("()")) for word in heard]
    assert stamps[-1] - stamps[0] == pytest.approx(0.38, abs=0.1)


def test_send_puts_one_frame_on_the_bus(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    with running_bus(tmp_path) as bus:
        assert main(["send", f"broker:{bus.name}", "--frame", "201#0600"]) == 0
        assert main(["send", f"broker:{bus.name}", "--nmt", "start", "--node", "3"]) == 0
        assert main(["send", f"broker:{bus.name}", "--frame", "9201#0600"]) == 2
        assert main(["send", f"broker:{bus.name}", "--node", "0", "--read", "1018:1"]) == 2
        assert main(["send", f"broker:{bus.name}", "--echo", "3"]) == 3, "the local bus does not give own frames back"
        bus.stop()
        heard = [line.split()[2] for line in bus.log_lines() if "#" in line and not line.startswith("#")]
    assert heard == ["201#0600", "000#0103"]
    assert "0..7FFh" in capsys.readouterr().err


def test_load_of_cells_before_running(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["load", "demo.toml"]) == 0
    out = capsys.readouterr().out
    assert "1379 .. " in out and "1675 us of 4000 us: worst 42 %" in out and "fits" in out
    assert main(["load", "s5-rk512.toml", "--json"]) == 0
    (bus,) = [one for one in json.loads(capsys.readouterr().out) if one["bus"] == "can0"]
    assert {"RPDO1 X", "TPDO1 Z", "heartbeat gateway", "SDO answer"} <= {one["what"] for one in bus["frames"]}
    assert bus["fits"] and bus["shortest_cycle_ms"] <= 4


def test_bad_input_is_answered_in_words(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "x.blf"
    broken.write_bytes(b"not a BLF file at all")
    answers = {
        ("load",): "name either a cell or --log FILE",
        ("load", "--log", str(tmp_path / "x.zip")): "a recording ends in .log",
        ("monitor", "--from", str(broken)): "after 0 frames",
        ("replay", str(tmp_path / "none.log"), "broker:x"): "No such file",
        ("log", "broker:x", "-o", str(tmp_path / "x.mf4")): "a recording ends in",
        ("dance",): "no tool 'dance'",
    }
    for arguments, words in answers.items():
        assert main(list(arguments)) == 2, arguments
        assert words in capsys.readouterr().err, arguments
    for url, words in {
        "broker:nobody-there": "nobody-there",
        "nosuch:1": "knows no interface 'nosuch'",
        "can0": "INTERFACE:CHANNEL",
    }.items():
        assert main(["monitor", url]) == 3
        assert words in capsys.readouterr().err, url
    assert main([]) == 2 and main(["-h"]) == 0


def test_a_bus_that_is_not_there_is_named_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["send", "broker:nobody", "--frame", "201#0600"]) == 3
    assert capsys.readouterr().err.count("broker:nobody:") == 1


def test_a_recording_named_as_a_cell_is_reported_and_a_closed_pipe_is_no_fault(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["load", "x.log"]) == 2
    assert "is a recording: --log x.log" in capsys.readouterr().err
    source = tmp_path / "long.log"
    source.write_text("".join(f"({n * 0.001:.6f}) can0 064#{n & 255:02X}\n" for n in range(20_000)))
    order = f"{sys.executable} -m gateway bus monitor --from {source} | head -2"
    done = subprocess.run(order, shell=True, capture_output=True, text=True, check=True)
    assert len(done.stdout.splitlines()) == 2 and not done.stderr


def test_remote_frames_are_shown_counted_recorded_and_replayed(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Node guarding of an old master: 48 questions, by python-can."""
    target = tmp_path / "guarding.blf"

    def ask() -> None:
        time.sleep(0.5)
        with can.Bus(interface="broker", channel="remote") as port:
            for n in range(48):
                port.send(can.Message(arbitration_id=0x701 + n % 3, is_extended_id=False, is_remote_frame=True, dlc=1))
            time.sleep(0.2)

    with running_bus(tmp_path, name="remote", log=False):
        thread = threading.Thread(target=ask)
        thread.start()
        assert main(["log", "broker:remote", "-o", str(target), "--seconds", "1.5"]) == 0
        thread.join()
    assert "48 frames" in capsys.readouterr().out
    assert main(["monitor", "--from", str(target), "--summary"]) == 0
    told = capsys.readouterr().out
    assert "remote frames 48" in told and "1793 (701h)" in told and "remote frame, asks for 1 bytes" in told, told
    assert main(["monitor", "--from", str(target), "--canopen"]) == 0
    assert capsys.readouterr().out.count("remote frame") == 48
    assert main(["load", "--log", str(target), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 48
    with running_bus(tmp_path, name="again", log=False), can.Bus(interface="broker", channel="again") as listener:
        assert main(["replay", str(target), "broker:again", "--speed", "0"]) == 0
        heard = [listener.recv(1.0) for _ in range(48)]
    assert all(one is not None and one.is_remote_frame and one.dlc == 1 for one in heard)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("fd.log", "(1.000000) can0 123##1112233445566778899\n", "is CAN FD"),
        ("fdtext.log", "# ours\n(1.000000) can0 123##1112233445566778899\n", "line 2 is CAN FD"),
        ("relative.asc", "date Mon Nov 23 10:00:00 am 2026\nbase hex  timestamps relative\n   0.1 1  123  Rx d 1 00\n", "relative"),
        ("letter.log", "Dear Sir or Madam, this is a letter and no log\n" * 60, "none of its first 50 lines"),
        ("letter.blf", "no binary log at all, but long enough to be read as a head" * 10, "torn or no .blf recording"),
        ("letter.csv", "a;b;c\n1;2;3\n", "torn or no .csv recording"),
        ("damaged.trc", ";$FILEVERSION=1.1\n;$STARTTIME=46349.5\n;---+--\n     1)  xx\n garbage\n", "no frame in it"),
        ("letter.trc", "Dear Sir or Madam, this is a letter and no recording\n" * 3, "torn or no .trc recording"),
        ("nothing.asc", "", "no frame in it"),
        ("bytes.log", "\x00\xff\x80" * 100, ""),
    ],
)
def test_what_is_no_recording_of_classic_can_is_a_sentence(
    tmp_path: pathlib.Path, name: str, content: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    path.write_bytes(content.encode("latin-1"))
    for command in (["monitor", "--from", str(path)], ["load", "--log", str(path)]):
        code = main(command)
        told = capsys.readouterr().err
        assert code == 2 and str(path) in told and words in told and "Traceback" not in told, (command, told)


def test_a_candump_log_keeps_how_many_bytes_a_remote_frame_asks_for(tmp_path: pathlib.Path) -> None:
    """As candump -L and canplayer of can-utils write and read it: #R8; python-can reads it back too."""
    path = tmp_path / "asked.log"
    asked = [Frame(0x701 | RTR_FLAG, bytes(8), 1_000_000_000), Frame(0x12345 | EFF_FLAG | RTR_FLAG, bytes(3), 1_500_000_000)]
    frames = [*asked, Frame(0x702 | RTR_FLAG, b"", 2_000_000_000), Frame(0x201, b"\x06\x00", 3_000_000_000)]
    writer = LogWriter(path, "can0")
    for frame in frames:
        writer.put(frame)
    writer.close()
    lines = path.read_text().splitlines()
    assert lines[:2] == ["(1.000000) can0 701#R8 R", "(1.500000) can0 00012345#R3 R"]
    assert list(read_log(path)) == frames
    with can.LogReader(path) as reader:
        assert [(one.is_remote_frame, one.dlc) for one in reader] == [(True, 8), (True, 3), (True, 0), (False, 2)]


def test_a_torn_blf_says_after_how_many_frames(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "whole.blf"
    with can.Logger(str(path)) as writer:
        for n in range(2000):
            writer(can.Message(timestamp=n / 1000, arbitration_id=n % 100, data=bytes((n & 255,) * 8), is_extended_id=False))
    torn = tmp_path / "torn.blf"
    data = bytearray(path.read_bytes())
    data[200:260] = bytes(60)
    torn.write_bytes(data[: len(data) * 2 // 3])
    assert main(["load", "--log", str(torn)]) == 2
    assert "torn or no .blf recording" in capsys.readouterr().err
