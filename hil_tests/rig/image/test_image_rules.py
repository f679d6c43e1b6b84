"""Regions and rings by their rules: opening, overtaken readers, gaps, generations, fds handed over; two processes at full speed."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable

import pytest

from gateway.runtime.record_reader import RecordReader
from gateway.runtime.regions import (
    ImageError,
    RegionReader,
    RegionWriter,
    RingReader,
    RingWriter,
    create_region,
    create_ring,
    fds_from_text,
    fds_to_text,
    recv_fds,
    send_fds,
)
from hil_tests.rig.image.dying import number_of, payload


class Overtaken(RegionReader):
    """A reader in whose copy the writer publishes."""

    between: Callable[[], object]

    def _take(self, at: int) -> bytes:
        octets = super()._take(at)
        self.between()
        return octets


class OvertakenRing(RingReader):
    """A ring reader in whose copy the writer puts."""

    between: Callable[[], object]

    def _take(self, at: int) -> bytes:
        octets = super()._take(at)
        self.between()
        return octets


@pytest.mark.parametrize(("publishes", "kept"), [(0, False), (2, False), (3, True), (9, True)])
def test_a_reader_overtaken_twice_keeps_its_last_copy_and_counts(publishes: int, kept: bool) -> None:
    fd = create_region("axes", 64)
    writer, reader = RegionWriter(fd), Overtaken(fd)
    reader.between = lambda: None
    writer.write(payload(1, 64), 1)
    assert number_of(reader.read() or b"") == 1
    numbers = iter(range(3, 100))

    def publish() -> None:
        for _ in range(publishes):
            number = next(numbers)
            writer.write(payload(number, 64), number)

    writer.write(payload(2, 64), 2)
    reader.between = publish
    octets = reader.read()
    assert number_of(octets or b"") == reader.stamp_ns == (1 if kept else 2)
    assert (reader.overtaken, reader.kept) == ((2, 1) if kept else (0, 0))
    reader.between = lambda: None
    assert number_of(reader.read() or b"") == writer.published
    os.close(fd)


def test_a_region_read_before_the_first_write_is_none() -> None:
    fd = create_region("axes", 64)
    reader = RegionReader(fd)
    assert (reader.read(), reader.life, reader.writer_pid) == (None, (0, 0), 0)
    writer = RegionWriter(fd)
    writer.beat(5)
    writer.beat(9)
    assert (reader.read(), reader.life, reader.writer_pid) == (None, (2, 9), os.getpid())
    os.close(fd)


def test_a_ring_reader_that_lags_counts_what_it_missed() -> None:
    fd = create_ring("pieces", 16, 8)
    writer = RingWriter(fd)
    writer.put(b"before the start")
    reader = RingReader(fd)
    for number in range(2, 5):
        assert writer.put(number.to_bytes(16, "little")) == number
    assert reader.take(2) == [(2, (2).to_bytes(16, "little")), (3, (3).to_bytes(16, "little"))]
    for number in range(5, 25):
        writer.put(number.to_bytes(16, "little"))
    taken = reader.take()
    assert [number for number, _ in taken] == list(range(18, 25)), "capacity - 1 newest"
    assert all(int.from_bytes(octets, "little") == number for number, octets in taken)
    assert (reader.gaps, reader.position) == (14, 24)
    assert reader.take() == []
    os.close(fd)


def test_a_ring_reader_overtaken_while_it_copies_returns_only_whole_records() -> None:
    fd = create_ring("pieces", 64, 8)
    writer, reader = RingWriter(fd), OvertakenRing(fd)
    numbers = iter(range(6, 1000))
    for number in range(1, 6):
        writer.put(payload(number, 64))
    reader.between = lambda: [writer.put(payload(next(numbers), 64)) for _ in range(1)]
    taken = reader.take()
    assert [number_of(octets) for _, octets in taken] == [number for number, _ in taken] == [4, 5]
    assert reader.gaps == 3
    reader.between = lambda: [writer.put(payload(next(numbers), 64)) for _ in range(9)]
    assert reader.take() == []
    assert reader.overtaken == 2
    reader.between = lambda: None
    assert [number_of(octets) for _, octets in reader.take()][-1] == writer.published
    os.close(fd)


def test_a_new_generation_voids_what_was_not_taken() -> None:
    fd = create_ring("commands", 8, 16)
    writer, reader = RingWriter(fd), RingReader(fd)
    for number in (1, 2, 3):
        writer.put(bytes([number] * 8))
    assert [number for number, _ in reader.take(1)] == [1]
    assert writer.new_generation() == 2
    assert reader.take() == [] and reader.voided == 2
    writer.put(b"8 bytes.")
    assert reader.take() == [(4, b"8 bytes.")] and reader.generation == 2 and reader.gaps == 0
    os.close(fd)


def test_a_generation_that_changes_while_a_reader_copies_voids_its_copy() -> None:
    fd = create_ring("commands", 8, 16)
    writer, reader = RingWriter(fd), OvertakenRing(fd)
    writer.put(b"8 bytes.")
    once = iter([True])
    reader.between = lambda: writer.new_generation() if next(once, False) else None
    assert reader.take() == [] and reader.voided == 1
    os.close(fd)


def test_memory_that_is_something_else_is_refused_and_both_are_named() -> None:
    region, ring = create_region("axes", 64, "positions v1"), create_ring("pieces", 64, 8)
    for opened, words in (
        (lambda: RegionReader(region, "axes", "positions v2"), ("positions v2", "positions v1")),
        (lambda: RegionReader(region, "rc_in"), ("rc_in", "axes")),
        (lambda: RegionWriter(ring), ("magic", "0x4e4f494745525841")),
        (lambda: RingReader(region), ("magic", "0x5f5f474e49525841")),
        (lambda: RegionWriter(region).write(bytes(63), 1), ("64", "63")),
        (lambda: RingWriter(ring).put(bytes(65)), ("64", "65")),
        (lambda: RegionReader(os.memfd_create("small")), ("0 bytes",)),
        (lambda: create_region("axes", 0), ("0 bytes",)),
        (lambda: create_region("n" * 33, 8), ("32",)),
    ):
        with pytest.raises(ImageError) as caught:
            opened()
        assert all(word in str(caught.value) for word in words), caught.value
    with pytest.raises(PermissionError):
        os.ftruncate(region, 8)  # sealed: nobody shrinks it under a reader
    with pytest.raises(TypeError):
        RegionReader(region)._octets[0] = 1  # readers cannot write
    os.close(region)
    os.close(ring)


def test_fds_travel_by_name_over_a_socket_and_over_a_command_line() -> None:
    fds = {"axes": create_region("axes", 64), "links": create_region("links", 32)}
    RegionWriter(fds["axes"], "axes").write(payload(7, 64), 7)
    ours, theirs = socket.socketpair()
    send_fds(ours, fds)
    send_fds(ours, {"links": fds["links"]})
    received = recv_fds(theirs)
    assert list(received) == ["axes", "links"] and list(recv_fds(theirs)) == ["links"]
    assert number_of(RegionReader(received["axes"], "axes").read() or b"") == 7
    assert fds_from_text(fds_to_text(fds)) == fds and fds_from_text("") == {}
    with pytest.raises(ImageError, match="axes=x"):
        fds_from_text("links=3,axes=x")
    ours.close()
    with pytest.raises(ImageError, match="closed"):
        recv_fds(theirs)
    program = (
        "import sys; from gateway.runtime.regions import *; print(len(RegionReader(fds_from_text(sys.argv[1])['axes'], 'axes').read()))"
    )
    child = subprocess.run([sys.executable, "-c", program, fds_to_text(fds)], pass_fds=list(fds.values()), capture_output=True, check=True)
    assert child.stdout == b"64\n"


def test_two_processes_at_full_speed_never_show_a_torn_payload_or_record() -> None:
    region, ring = create_region("axes", 4096), create_ring("pieces", 512, 64)
    child = os.fork()
    if not child:
        try:
            region_writer, ring_writer, number = RegionWriter(region), RingWriter(ring), 0
            while True:
                number += 1
                region_writer.write(payload(number, 4096), number)
                ring_writer.put(payload(number, 512))
        finally:
            os._exit(9)
    try:
        reader, follower = RegionReader(region), RingReader(ring)
        end, seen, taken, last = time.monotonic() + 2.0, 0, 0, follower.position
        while time.monotonic() < end:
            octets = reader.read()
            if octets is not None:
                number = number_of(octets)
                assert number == reader.stamp_ns == reader.index >= seen
                seen = number
            for sequence, record in follower.take(16):
                assert number_of(record) == sequence > last
                last, taken = sequence, taken + 1
        assert seen > 1000 and taken > 1000
        assert taken + follower.gaps == follower.position
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)
        os.close(region)
        os.close(ring)


def test_a_record_is_unpacked_again_only_when_its_bytes_have_changed() -> None:
    fd = create_region("axes", 64)
    writer, unpacked = RegionWriter(fd), list[bytes]()

    def unpack(data: bytes) -> int:
        unpacked.append(data)
        return number_of(data)

    reader = RecordReader(RegionReader(fd), unpack, -1)
    assert reader.read() == -1, "nothing was published"
    seen = []
    for number in (7, 7, 7, 8, 7):
        writer.write(payload(number, 64), number)
        seen.append(reader.read())
    assert seen == [7, 7, 7, 8, 7]
    assert unpacked == [payload(number, 64) for number in (7, 8, 7)]
