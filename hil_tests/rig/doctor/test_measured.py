"""doctor measures: a line that gives back late, a bus, this machine; really, with real ports."""

import json
import os
import pathlib
import pty
import select
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from gateway.commands.doctor import main
from hil_tests.lab.running.bus_running import running_bus

HELD_S = 0.005


@pytest.fixture
def loop() -> Iterator[str]:
    """A line whose far end gives each character back after 5 ms, as an adapter with a latency timer does."""
    master, slave = pty.openpty()
    ended = threading.Event()

    def give_back() -> None:
        while not ended.is_set():
            if select.select([master], [], [], 0.05)[0]:
                data = os.read(master, 64)
                time.sleep(HELD_S)
                os.write(master, data)

    thread = threading.Thread(target=give_back, daemon=True)
    thread.start()
    yield f"pty:{os.ttyname(slave)}"
    ended.set()
    thread.join()
    os.close(master)
    os.close(slave)


def told(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, Any]]:
    code = main([*words, "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_the_echo_of_a_line_is_measured_and_judged(loop: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = told(capsys, "serial", loop, "--count", "40", "--seconds", "0.2", "--clock", "4")
    assert code == 1, "5 ms are too long for a clock of 4 ms"
    assert found["figures"]["adapter echo"]["p50"] >= HELD_S * 1000
    assert found["good_for_ms"] is None or found["good_for_ms"] >= 8
    assert "p99.9 = " in str(found["verdict"]) and found["wanted_ms"] == 4


def test_without_a_loop_plug_it_says_which_pins(capsys: pytest.CaptureFixture[str]) -> None:
    master, slave = pty.openpty()
    assert main(["serial", f"pty:{os.ttyname(slave)}", "--count", "1", "--seconds", "0.1"]) == 3
    assert "no echo within 1 s; bridge" in capsys.readouterr().err
    os.close(master)
    os.close(slave)
    assert main(["serial", "/dev/no-such-adapter", "--count", "1"]) == 3
    assert "next: axisgate doctor" in capsys.readouterr().err
    assert main(["serial", "pty:/x", "--count", "0"]) == 2


def test_the_local_bus_gives_frames_to_another_listener(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    with running_bus(tmp_path, name="doc"):
        _, found = told(capsys, "can", "broker:doc", "--count", "20", "--seconds", "0.1")
    echo = found["figures"]["adapter echo"]
    assert echo["count"] == 20 and 0 < echo["p50"] < 1000


def test_a_real_bus_is_not_sent_to_unasked(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["can", "socketcan:can0"]) == 2
    assert "axisgate doctor can socketcan:can0 --send" in capsys.readouterr().err


def test_an_hour_in_a_second_judges_the_clock_of_the_cell(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = told(capsys, "--hour", "demo", "--seconds", "0.5")
    assert code in (0, 1) and found["wanted_ms"] == 4
    late = found["figures"]["scheduling of this machine"]
    assert 1 <= late["count"] <= 500 and 0 <= late["p50"] <= late["max"]
    assert (code == 0) is (found["good_for_ms"] is not None and int(str(found["good_for_ms"])) <= 4)
    assert main(["--hour", "demo", "--seconds", "0"]) == 2
