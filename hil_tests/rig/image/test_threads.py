"""Regions and rings of one process in several threads: the services' masters of CANopen buses read and write beside the main loop."""

import os
import sys
import threading
from collections.abc import Iterator

import pytest

from gateway.runtime.regions import RegionReader, RegionWriter, create_region

ROUNDS, THREADS = 20000, 8


@pytest.fixture
def impatient() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def test_threads_with_regions_of_their_own_do_not_meet(impatient: None) -> None:
    failed: list[BaseException] = []

    def play(number: int) -> None:
        fd = create_region("own", 8)
        try:
            writer, reader = RegionWriter(fd, "own"), RegionReader(fd, "own")
            for count in range(ROUNDS):
                octets = (number << 32 | count).to_bytes(8, "little")
                writer.write(octets, count)
                assert reader.read() == octets
        except BaseException as error:
            failed.append(error)
        finally:
            os.close(fd)

    threads = [threading.Thread(target=play, args=(number,)) for number in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert not failed, failed
    assert not any(thread.is_alive() for thread in threads)
