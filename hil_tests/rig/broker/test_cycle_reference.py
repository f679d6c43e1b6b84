"""The C reference of the bench `cycle` on a real broker with a small answering slave, and the judge of the log."""

import json
import os
import pathlib
import subprocess
import threading

import pytest

from drivers.ports.can.broker import BrokerPort
from hil_tests.bench.cycle_judge import judge
from hil_tests.lab.running.bus_running import running_bus, wait_readable
from hil_tests.lanes import REFERENCES
from protocols.base.machine import Frame

REFERENCE = REFERENCES / "cycle_ref"
PERIOD_NS = 4_000_000
P5_MS = int(os.environ.get("AXISGATE_TEST_P5", "4"))  # of the reference; longer when it is played again (AX-563)


def answer(port: BrokerPort, syncs: list[list[Frame]], end: threading.Event, silent: int) -> None:
    """Six actual values for every SYNC, but the SYNC number `silent`; position = 1000 x axis."""
    while not end.is_set():
        try:
            wait_readable(port, 0.2)
        except AssertionError:
            continue
        for frame in port.receive():
            if frame.identifier != 100:
                syncs[-1].append(frame)
                continue
            syncs.append([frame])
            if len(syncs) != silent:
                port.send([Frame(600 + 10 * n, b"\1\0" + (1000 * n).to_bytes(4, "little") + b"\0\0") for n in range(1, 7)])


@pytest.mark.cref
def test_the_reference_sends_its_seven_frames_and_the_judge_counts_the_cycle_without_answers(tmp_path: pathlib.Path) -> None:
    with running_bus(tmp_path) as bus:
        slave, syncs, end = bus.port(), list[list[Frame]](), threading.Event()
        thread = threading.Thread(target=answer, args=(slave, syncs, end, 50))
        thread.start()
        command = [str(REFERENCE), "--name", bus.name, "--cycles", "200", "--period-us", str(1000 * P5_MS), "--enable"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=20)
        end.set()
        thread.join()
        bus.stop()
        (verdict,) = judge(bus.log_lines(), P5_MS * 1_000_000)
    told = json.loads(done.stdout)
    assert told["cycles"] == 200 and told["period_us"] == 1000 * P5_MS and told["refused"] == 0
    assert told["incomplete"] >= 1, "cycle 50 had no answers"
    assert verdict.pid == told["pid"] and verdict.cycles == 199 and verdict.lost == 0
    assert verdict.incomplete >= 1 and abs(verdict.incomplete - told["incomplete"]) <= 5 and abs(verdict.skipped - told["skipped"]) <= 2
    assert verdict.sync_error_p50 < 1000
    for number, frames in enumerate(syncs, 1):
        assert [frame.identifier for frame in frames] == [100, 210, 220, 230, 240, 250, 260]
        assert {(frame.data[0], frame.data[1]) for frame in frames[1:]} == {(3, number % 256)}
    assert [int.from_bytes(frame.data[2:6], "little") for frame in syncs[-1][1:]] == [1000, 2000, 3000, 4000, 5000, 6000]


def cycle(at_ns: int, answers: int = 6, sender: int = 1) -> list[str]:
    def line(identifier: int, who: int, ns: int) -> str:
        payload = "" if identifier == 100 else "0000000000000000"
        return f"({ns // 10**9}.{ns // 1000 % 10**6:06d}) t {identifier:03X}#{payload} {who} 1 {ns % 1000:03d}\n"

    ours = [line(identifier, sender, at_ns) for identifier in (100, *range(210, 261, 10))]
    return ours + [line(610 + 10 * n, 9, at_ns + 200_000) for n in range(answers)]


def test_the_judge_measures_errors_skips_and_missing_frames_to_the_nanosecond() -> None:
    instants = [0, 4_000_000, 8_000_250, 11_999_000, 20_000_000, 24_000_000]  # errors 0, 250, 1250 ns; one instant skipped; 0
    lines = [text for number, at in enumerate(instants) for text in cycle(10**9 + at, 5 if number == 1 else 6)]
    lines.insert(30, "# (1.000000) lost 3 frames: the log could not be written in time\n")
    lines.insert(0, "# (0.000001) client 1 connected, pid 4711\n")
    (verdict,) = judge(lines, PERIOD_NS)
    assert (verdict.sender, verdict.pid, verdict.cycles, verdict.skipped, verdict.incomplete, verdict.lost) == (1, 4711, 5, 1, 1, 3)
    assert (verdict.sync_error_max, verdict.sync_error_p50) == (1.25, 0.0)
    (part,) = judge(lines, PERIOD_NS, 10**9 + 8_000_000, 10**9 + 13_000_000)
    assert (part.cycles, part.incomplete, part.sync_error_max) == (1, 0, 1.25)
    other = [text for at in (0, 4_000_000) for text in cycle(3 * 10**9 + at, sender=2)]
    assert [(one.sender, one.cycles) for one in judge(lines + other, PERIOD_NS)] == [(1, 5), (2, 1)]
    doubled = cycle(10**9) + cycle(10**9)[1:2] + cycle(10**9 + 4_000_000)
    assert judge(doubled, PERIOD_NS)[0].incomplete == 1
