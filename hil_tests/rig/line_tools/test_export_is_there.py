"""`axisgate line export` is reached through the command; what it writes is judged by tshark elsewhere."""

import pathlib
import subprocess
import sys

RECORD = "# 1000 ready name=x baud=9600 bits=11 scheduling=fifo\n2000000 A 02\n4000000 B 10\n"
PCAPNG = bytes.fromhex("0A0D0D0A")


def test_a_record_becomes_a_capture(tmp_path: pathlib.Path) -> None:
    trace, capture = tmp_path / "line.rec", tmp_path / "line.pcapng"
    trace.write_text(RECORD)
    command = [sys.executable, "-m", "gateway", "line", "export", str(trace), "-o", str(capture)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert capture.read_bytes()[:4] == PCAPNG
