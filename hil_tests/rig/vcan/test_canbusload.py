"""Our frame lengths against can-utils' canbusload on vcan0: within 2 %."""

import re
import signal
import subprocess
import time

import pytest

from drivers.ports.can.open import open_can
from protocols.base.can_bits import frame_bits, plain_bits, worst_bits
from protocols.base.machine import Frame

pytestmark = pytest.mark.vcan

CYCLE = [Frame(100)] + [Frame(200 + 10 * n, bytes([3, 17 * n & 255, n, 90, 0, 0, 1, n])) for n in range(1, 7)]
CYCLE += [Frame(600 + 10 * n, bytes([7, 17 * n & 255, n, 90, 255, 255, n, 0])) for n in range(1, 7)]
LINE = re.compile(r"vcan0@1000000\s+(\d+)\s+(\d+)\s+(\d+)\s+(\d+)%")


def told(option: str) -> tuple[float, int]:
    """(bits a frame, payload bits a frame) by canbusload, over whole seconds with traffic."""
    judge = subprocess.Popen(["canbusload", *([option] if option else []), "vcan0@1000000"], stdout=subprocess.PIPE, text=True)
    port = open_can("socketcan:vcan0")
    end = time.monotonic() + 3.3
    while time.monotonic() < end:
        assert port.send(CYCLE) == len(CYCLE)
        time.sleep(0.02)
    port.close()
    judge.send_signal(signal.SIGINT)
    out, _ = judge.communicate(timeout=10)
    rows = [tuple(map(int, found.groups())) for found in LINE.finditer(out)]
    frames = sum(row[0] for row in rows)
    assert frames >= 200, out
    return sum(row[1] for row in rows) / frames, round(sum(row[2] for row in rows) / frames)


def test_exact_bits_agree() -> None:
    ours = sum(frame_bits(frame.identifier, frame.data) for frame in CYCLE) / len(CYCLE)
    theirs, payload = told("-e")
    assert payload == pytest.approx(8 * 96 / len(CYCLE), abs=2)
    assert ours == pytest.approx(theirs, rel=0.02)


def test_bits_without_stuffing_and_the_worst_case_agree() -> None:
    assert sum(plain_bits(len(frame.data)) for frame in CYCLE) / len(CYCLE) == pytest.approx(told("-i")[0], rel=0.02)
    assert sum(worst_bits(len(frame.data)) for frame in CYCLE) / len(CYCLE) == pytest.approx(told("")[0], rel=0.02)
