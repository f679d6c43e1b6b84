"""A writer killed at every store of a region write, a beat, a ring put and a new generation: readers go on with whole copies."""

import os
from collections.abc import Callable

import pytest

from gateway.runtime.regions import ImageError, RegionReader, RegionWriter, RingReader, RingWriter, create_region, create_ring
from hil_tests.rig.image.dying import PAYLOAD, DyingRegion, DyingRing, Executioner, dies, number_of, payload

Action = Callable[[Executioner], None]


def region_action(fd: int, number: int) -> Action:
    def act(executioner: Executioner) -> None:
        DyingRegion.executioner = executioner
        writer = DyingRegion(fd, "axes")
        writer.beat(number)
        writer.write(payload(number), number)

    return act


def ring_action(fd: int, number: int, generation: bool) -> Action:
    def act(executioner: Executioner) -> None:
        DyingRing.executioner = executioner
        writer = DyingRing(fd, "pieces")
        if generation:
            writer.new_generation()
        writer.put(payload(number))

    return act


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("before", [1, 2, 3, 4, 7])
def test_a_region_is_whole_after_its_writer_died_at_any_store(before: int, half: bool) -> None:
    for fatal in range(1, 30):
        fd = create_region("axes", PAYLOAD, "v1")
        try:
            writer = RegionWriter(fd, "axes")
            for number in range(1, before + 1):
                writer.beat(number)
                writer.write(payload(number), number)
            writer.close()
            reader = RegionReader(fd, "axes", "v1")
            late = RegionReader(fd, "axes", "v1")
            assert number_of(reader.read() or b"") == before
            died = dies(region_action(fd, before + 1), fatal, half)
            for one in (reader, late):
                octets = one.read()
                assert octets is not None
                assert number_of(octets) == one.stamp_ns == one.index
                assert one.index == (before if died else before + 1)
                assert (one.overtaken, one.kept) == (0, 0)
                count, stamp = one.life
                assert count == stamp, "count and stamp of different beats"
            heir = RegionWriter(fd, "axes")
            assert number_of(heir.latest() or b"") == reader.index
            assert heir.write(payload(99), 99) == reader.index + 1
            assert number_of(reader.read() or b"") == 99
            for one_map in (heir, reader, late):
                one_map.close()
        finally:
            os.close(fd)
        if not died:
            break
    assert not died and fatal == 7, f"stores of take-over, beat and write: 6 expected, {fatal - 1} seen"


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("generation", [False, True])
@pytest.mark.parametrize("before", [2, 7, 8, 21])
def test_a_ring_is_whole_after_its_writer_died_at_any_store(before: int, generation: bool, half: bool) -> None:
    for fatal in range(1, 30):
        fd = create_ring("pieces", PAYLOAD, 8, "v1")
        try:
            writer = RingWriter(fd, "pieces")
            early = RingReader(fd, "pieces", "v1")
            for number in range(1, before + 1):
                writer.put(payload(number))
            writer.close()
            died = dies(ring_action(fd, before + 1, generation), fatal, half)
            taken = early.take()
            assert [number_of(octets) for _, octets in taken] == [number for number, _ in taken]
            told = len(taken) + early.gaps + early.voided
            assert told == early.position == (before if died else before + 1), "every record is taken, lost or void"
            heir = RingWriter(fd, "pieces")
            assert heir.put(payload(early.position + 1)) == early.position + 1
            assert [number for number, _ in early.take()] == [heir.published]
            late = RingReader(fd, "pieces", "v1")
            assert late.take() == [], "old records never replay"
            for one_map in (heir, early, late):
                one_map.close()
        finally:
            os.close(fd)
        if not died:
            break
    assert not died and fatal == (6 if generation else 4)


def test_a_living_writer_is_not_replaced_and_a_dead_one_is() -> None:
    fd = create_region("axes", 8)
    ours = RegionWriter(fd)

    def intrude(_: Executioner) -> None:
        with pytest.raises(ImageError, match=f"living writer, pid {os.getppid()};"):
            RegionWriter(fd)

    assert not dies(intrude, 99, False)
    ours.close()
    assert not dies(lambda _: RegionWriter(fd).beat(7), 99, False), "a closed writer may be followed"
    RegionWriter(fd).beat(8)
    assert RegionReader(fd).life == (2, 8)
    os.close(fd)
