"""The local bus with a modelled wire: order and stamps of arbitration, exact frame times, hand-over within 1 ms, a full bus is told."""

import itertools
import pathlib
import time

import pytest

from hil_tests.lab.running.bus_running import receive, running_bus
from protocols.base.can_bits import frame_bits
from protocols.base.machine import Frame

BURST = [Frame(200 + 10 * n, bytes([n] * 8)) for n in range(6, 0, -1)]


def test_frames_follow_each_other_bit_for_bit_and_arrive_when_they_should(tmp_path: pathlib.Path) -> None:
    with running_bus(tmp_path, "--bitrate", "1000000") as bus:
        sender, listener = bus.port(), bus.port()
        sent = time.monotonic_ns()
        sender.send([Frame(100), *BURST])
        heard: list[Frame] = []
        late: list[int] = []
        while len(heard) < 7:
            frames = receive(listener, 1)
            now = time.monotonic_ns()
            late += [now - frame.stamp_ns for frame in frames]
            heard += frames
    assert [frame.identifier for frame in heard] == [100, 260, 250, 240, 230, 220, 210], "one node sends in its own order"
    for before, after in itertools.pairwise(heard):
        assert after.stamp_ns - before.stamp_ns == frame_bits(after.identifier, after.data) * 1000
    assert heard[0].stamp_ns > sent and min(late) >= 0, "never before its last bit"
    assert sorted(late)[len(late) // 2] < 1_000_000, late


def test_the_lowest_identifier_of_two_nodes_goes_first(tmp_path: pathlib.Path) -> None:
    with running_bus(tmp_path, "--bitrate", "125000") as bus:
        one, other, listener = bus.port(), bus.port(), bus.port()
        one.send([Frame(0x300, bytes(8))] * 8)  # 8 ms of wire
        other.send([Frame(0x100), Frame(0x101)])
        heard = receive(listener, 10)
    order = [frame.identifier for frame in heard]
    assert order[0] == 0x300 and set(order[1:3]) == {0x100, 0x101}, order
    gaps = [after.stamp_ns - before.stamp_ns for before, after in itertools.pairwise(heard)]
    assert min(gaps) >= 47 * 8000, "nothing overlaps on the wire"


def test_a_full_bus_is_reported_and_nothing_is_lost(tmp_path: pathlib.Path) -> None:
    with running_bus(tmp_path, "--bitrate", "125000") as bus:
        sender, listener = bus.port(), bus.port()
        sender.send([Frame(0x300, bytes(8))] * 60)
        assert len(receive(listener, 60)) == 60
        code, words = bus.stop()
    assert code == 0 and "the modelled bus is full" in words
    assert any("the modelled bus is full" in line for line in bus.log_lines())


def test_a_bit_rate_that_is_none_is_refused(tmp_path: pathlib.Path) -> None:
    with pytest.raises(AssertionError, match="bit rate 3 bit/s"), running_bus(tmp_path, "--bitrate", "3"):
        pass
