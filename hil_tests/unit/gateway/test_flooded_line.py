"""A flooded line takes its share of a turn and no more: the services that serve it keep their sign of life (AX-622)."""

import sys
from types import FrameType
from typing import Any

import pytest

from drivers.ports.serial.descriptor import READ_SIZE
from drivers.ports.serial.memory import memory_pair
from gateway.links.serial.machine_loop import LineCore
from gateway.pure.lines.rk512_link import Rk512Link
from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.machine import ms
from protocols.p3964r.characters import wire_block
from protocols.p3964r.profiles import SIEMENS_CP341, Priority

CALLS_A_CHARACTER = 12  # a read of 4,096 takes some 10 ms then; a sign of life is due every 250 ms
FETCH = b"\x02" + wire_block(b"\0\0ED\x0a\0\0\x01\xff\xff")
FLOODS = {
    "STX": b"\x02",
    "DLE": b"\x10",
    "NAK": b"\x15",
    "FF": b"\xff",
    "stray": b"Z",
    "all": bytes(range(256)),
    "empty blocks": b"\x02\x10\x03\x13",
    "refused": b"\x02A\x10\x03Z",
    "commands": FETCH,
}


@pytest.mark.parametrize("flood", list(FLOODS))
def test_one_turn_of_a_flooded_line_is_bounded(flood: str) -> None:
    core = LineCore[Any](Rk512Link(SIEMENS_CP341, Priority.HIGH, Blocks({10: 10})), lambda event, now: None, _never)
    near, far = memory_pair()
    core.connect(near, 0)
    pattern = FLOODS[flood]
    calls = 0

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += event == "call"

    for turn in range(2):
        far.write((pattern * (READ_SIZE // len(pattern) + 1))[:READ_SIZE])
        calls = 0
        sys.setprofile(count)
        try:
            core.readable(ms(1 + turn))
        finally:
            sys.setprofile(None)
        far.read()
        assert calls <= CALLS_A_CHARACTER * READ_SIZE, f"{calls} calls for {READ_SIZE} characters"
    assert core.state.counters.machine_faults == 0 and core.state.connected


def _never(error: Exception) -> None:
    raise AssertionError(error)
