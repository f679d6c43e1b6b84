"""What a block of 128 bytes costs two stations and their loops, in function calls: a count that no busy machine changes."""

import sys
from collections.abc import Callable
from types import FrameType

import pytest

from drivers.ports.serial.memory import memory_pair
from gateway.links.serial.machine_loop import LineCore
from protocols.p3964r.characters import DLE
from protocols.p3964r.events import BlockReceived, BlockSent, Event
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority

BLOCKS = 20
COUNTED = ("/protocols/p3964r/", "/gateway/links/serial/")
PLAIN, DOUBLED = bytes(range(DLE + 1, DLE + 129)), bytes(range(128))  # without a DLE; with one, which is doubled on the line


def broken(error: Exception) -> None:
    raise error


def exchange(block: bytes, count: int) -> Callable[[], list[Event]]:
    """A function that sends so many blocks from one station to the other and gives what both report."""
    one, other = memory_pair()
    told: list[Event] = []
    sending, receiving = Link(RHO3, Priority.HIGH), Link(RHO3, Priority.LOW)
    cores = [LineCore(link, lambda event, now: told.append(event), broken) for link in (sending, receiving)]
    for core, port in zip(cores, (one, other), strict=True):
        core.connect(port, 0)

    def run() -> list[Event]:
        for number in range(count):
            now = number * 1_000_000
            sending.send(block, now)
            cores[0].pump(now)
            for _ in range(2):  # STX and DLE, block and DLE
                for core in reversed(cores):
                    core.readable(now)
                    core.next_wake()
        return told

    return run


def calls_of(run: Callable[[], list[Event]]) -> tuple[int, list[Event]]:
    """How many functions of the line were entered, and what was reported."""
    entered = 0

    def look(frame: FrameType, event: str, argument: object) -> None:
        nonlocal entered
        entered += event == "call" and any(part in frame.f_code.co_filename for part in COUNTED)

    before = sys.getprofile()
    sys.setprofile(look)
    try:
        told = run()
    finally:
        sys.setprofile(before)
    return entered, told


@pytest.mark.parametrize(("block", "most"), [(PLAIN, 115), (DOUBLED, 125)], ids=["plain", "with a DLE"])
def test_a_block_from_station_to_station_is_a_little_more_than_a_hundred_calls(block: bytes, most: int) -> None:
    """There were 170 and 180 before the end of a block was taken at once and timers were read without a call."""
    entered, told = calls_of(exchange(block, BLOCKS))
    expected: list[Event] = []
    for number in range(1, BLOCKS + 1):
        expected += [BlockReceived(block), BlockSent(number)]
    assert told == expected
    assert entered / BLOCKS <= most
