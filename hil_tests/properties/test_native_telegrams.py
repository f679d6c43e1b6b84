"""Drive telegrams in C against their Python twins: bursts of set values, messages of actual values, one wait for several buses (AX-320)."""

import contextlib
import socket
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.drives.family import Actual, SetRecord
from drivers.ports.can.wire import RECORD, pack_records
from gateway.cycle.native.quick import Collect, NativeParts, QuickTelegrams
from hil_tests.lab.cells.native import ENDS, FLAG, native_parts
from hil_tests.lab.virtual.cell_bench import FAMILY
from protocols.base.errors import EncodeError
from protocols.base.machine import Frame
from protocols.servodyn.codec import ActualValue, SetValue

pytestmark = pytest.mark.cref


@pytest.fixture(scope="module")
def quick() -> NativeParts:
    return native_parts()


WIDE = st.one_of(st.sampled_from([*ENDS, 255, 256, 32767, -32768, -32769]), st.integers(-300, 300))
SETS = st.builds(SetValue, *[FLAG] * 5, WIDE, WIDE, WIDE)
USUAL = st.builds(SetValue, *[FLAG] * 5, st.integers(0, 255), st.integers(-(2**31), 2**31 - 1), st.integers(-32767, 32767))


@pytest.fixture(scope="module")
def telegrams(quick: NativeParts) -> QuickTelegrams:
    found = quick.telegrams(FAMILY)
    assert found is not None
    return found


@settings(max_examples=60, deadline=None)
@given(values=st.one_of(st.lists(USUAL, min_size=6, max_size=6), st.lists(SETS, min_size=6, max_size=6)))
def test_a_burst_is_the_same_in_both_or_left_to_the_twin(telegrams: QuickTelegrams, values: list[SetRecord]) -> None:
    made = telegrams.message(values)
    try:
        asked = FAMILY.burst(values)
    except EncodeError:
        assert made is None
    else:
        assert [made] == pack_records(asked)


ROWS = st.tuples(
    st.sampled_from([610, 620, 630, 640, 650, 660, 660, 610, 620, 611, 2047, 0x80000000, 0xE0000001]),
    st.sampled_from([8, 8, 8, 8, 8, 8, 7, 0]),
    st.binary(min_size=8, max_size=8),
    st.integers(995, 1005),
)


@settings(max_examples=80, deadline=None)
@given(messages=st.lists(st.lists(ROWS, min_size=1, max_size=7), min_size=1, max_size=3), before=st.lists(FLAG, min_size=6, max_size=6))
def test_messages_are_heard_the_same_in_both_or_left_to_the_twin(
    quick: NativeParts, telegrams: QuickTelegrams, messages: list[list[tuple[int, int, bytes, int]]], before: list[bool]
) -> None:
    """As long as an axis is missing, one after the other; what holds anything but actual values comes back untouched."""
    mine: list[Actual | None] = [ActualValue() if there else None for there in before]
    theirs, missing, late, odd = list(mine), 6, 0, None
    octets = [b"".join(RECORD.pack(*row[:2], 1, row[2], row[3], 7) for row in rows) for rows in messages]
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with near, far:
        for each in octets:
            far.send(each)
        far.close()  # after the last message the bus is gone
        for rows, message in zip(messages, octets, strict=True):
            if missing <= 0:
                break
            if not all(identifier in range(610, 661, 10) and size == 8 for identifier, size, *_ in rows):
                odd = (0, message)
                break
            for identifier, _, data, stamp in rows:
                heard = FAMILY.hear(Frame(identifier, data, stamp))
                assert heard is not None
                late += stamp < 1000
                if stamp >= 1000:
                    missing -= theirs[heard.axis] is None
                    theirs[heard.axis] = heard.actual
        gone = odd or ((0, None) if missing > 0 else None)
        said = collector(quick)([(telegrams.table, near.fileno(), 1000)], mine, 6, time.monotonic_ns() + 10_000_000_000)
    assert said == (missing, late, gone)
    assert repr(mine) == repr(theirs)


def collector(quick: NativeParts) -> Collect:
    assert quick.collect is not None
    return quick.collect


def test_what_is_there_when_the_time_is_up_is_taken_and_nothing_is_waited_for(quick: NativeParts, telegrams: QuickTelegrams) -> None:
    """A cycle that comes late to its telegrams does not blame the drives for it; a flood does not hold it."""
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with near, far:
        actuals: list[Actual | None] = [None] * 6
        bus, over = (telegrams.table, near.fileno(), 1000), time.monotonic_ns() - 1
        assert collector(quick)([bus], actuals, 6, over) == (6, 0, None)
        for axis in range(3):
            far.send(RECORD.pack(610 + 10 * axis, 8, 1, bytes(8), 2000, 1))
        assert collector(quick)([bus], actuals, 6, over) == (3, 0, None)
        assert [actual is None for actual in actuals] == [False] * 3 + [True] * 3
        for _ in range(40):
            far.send(RECORD.pack(610, 8, 1, bytes(8), 2000, 1))
        assert collector(quick)([bus], actuals, 3, over) == (3, 0, None)
        assert len(left_in(near)) > 30
        far.send(bytes(31))
        assert collector(quick)([bus], actuals, 3, time.monotonic_ns() + 10_000_000_000) == (3, 0, (0, bytes(31)))


def left_in(near: socket.socket) -> list[bytes]:
    near.setblocking(False)
    found = []
    with contextlib.suppress(BlockingIOError):
        while True:
            found.append(near.recv(4096))
    return found


def test_two_buses_are_heard_in_one_wait(quick: NativeParts, telegrams: QuickTelegrams) -> None:
    pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(2)]
    actuals: list[Actual | None] = [None] * 6
    for n, (_, far) in enumerate(pairs):
        far.send(b"".join(RECORD.pack(610 + 10 * axis, 8, 1, bytes(8), 2000, 1) for axis in range(3 * n, 3 * n + 3)))
    buses = [(telegrams.table, near.fileno(), 1000) for near, _ in pairs]
    assert collector(quick)(buses, actuals, 6, time.monotonic_ns() + 10_000_000_000) == (0, 0, None)
    assert None not in actuals
    for pair in pairs:
        for end in pair:
            end.close()
