"""The ring between a bus' master and the cycle: what leaves with a burst, nothing that proves life, clean sheets for the SDO client."""

import os
import time
from collections.abc import Iterator

import can
import pytest

from drivers.drives.cia402 import Cia402Set
from drivers.drives.cia402_family import Cia402Family
from drivers.ports.can import cycle_bus
from drivers.ports.can.memory import memory_pair
from gateway.cycle.bus_link import BusLink
from gateway.files.eds import canopen_dictionary, clean_sheet
from gateway.links.canopen.ring_link import Rings
from gateway.pure.image.records.aside import ACYCLIC_RECORDS, ASIDE_BYTES, ASIDE_LAYOUT, Aside, AsideRecord, pack_aside, unpack_aside
from gateway.runtime.regions import RingReader, RingWriter, create_ring
from protocols.base.machine import Frame
from protocols.canopen import eds

DIRTY = """[DeviceInfo]
VendorName=Maker X
VendorNumber=
ProductNumber=0x402
this line is nothing
[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=
[6040]
ParameterName=Controlword; the word
ObjectType=0x7
DataType=6
AccessType=rww
PDOMapping=1
[60C2]
ParameterName=Interpolation time
SubNumber=3
ObjectType=9
[60C2sub1]
ParameterName=
DataType=0x0005
AccessType=rw
"""


@pytest.fixture
def rings() -> Iterator[tuple[Rings, RingReader, RingWriter]]:
    """The services' end, and what the cycle has of both rings."""
    out = create_ring("acyclic", ASIDE_BYTES, ACYCLIC_RECORDS, ASIDE_LAYOUT)
    back = create_ring("heard", ASIDE_BYTES, ACYCLIC_RECORDS, ASIDE_LAYOUT)
    try:
        yield Rings(out, back, 2), RingReader(out, "acyclic"), RingWriter(back, "heard")
    finally:
        os.close(out)
        os.close(back)


def test_python_can_speaks_through_the_ring_and_hears_its_own_bus_only(rings: tuple[Rings, RingReader, RingWriter]) -> None:
    own, to_cycle, from_cycle = rings
    cycle_bus.attach("second", own.links[1])
    bus = can.Bus(interface="cycle", channel="second")
    try:
        bus.send(can.Message(arbitration_id=0x605, data=b"\x40\x00\x10\x00\0\0\0\0", is_extended_id=False))
        own.links[0].release(5, 8)
        assert [unpack_aside(data)[:4] for _, data in to_cycle.take()] == [
            (Aside.FRAME, 1, 0x605, b"\x40\x00\x10\x00\0\0\0\0"),
            (Aside.RELEASE, 0, 5, b"\x08"),
        ]
        for number, identifier in ((0, 0x581), (1, 0x585), (1, 0x705)):
            from_cycle.put(pack_aside(AsideRecord(Aside.FRAME, number, identifier, b"\x7f", 5_000_000_000)))
        heard = [bus.recv(1.0), bus.recv(1.0)]
        assert [(message.arbitration_id, message.timestamp) for message in heard if message] == [(0x585, 5.0), (0x705, 5.0)]
        assert bus.recv(0.02) is None
    finally:
        bus.shutdown()
        cycle_bus.detach("second")


@pytest.mark.parametrize("identifier", [0x080, 0x185, 0x205, 0x57F, 0x77F])
def test_what_proves_life_leaves_from_a_completed_cycle_only(identifier: int, rings: tuple[Rings, RingReader, RingWriter]) -> None:
    own, to_cycle, _ = rings
    cycle_bus.attach("first", own.links[0])
    bus = can.Bus(interface="cycle", channel="first")
    try:
        with pytest.raises(can.CanOperationError, match="completed cycle only"):
            bus.send(can.Message(arbitration_id=identifier, data=b"", is_extended_id=False))
        assert not own.links[0].send(0x080, b"") and to_cycle.take() == []
    finally:
        bus.shutdown()
        cycle_bus.detach("first")


def test_one_acyclic_frame_leaves_with_each_burst_after_the_set_values() -> None:
    ours, theirs = memory_pair(time.monotonic_ns)
    link = BusLink("memory:", Cia402Family([], 1_000_000, 1_000_000))
    link.port = ours
    link.acyclic.extend(Frame(0x600 + n, bytes(8)) for n in (1, 2, 3))
    for n in (1, 2, 3):
        link.prepare([])
        assert link.send(time.monotonic_ns())
        assert [frame.identifier for frame in theirs.receive()] == [0x080, 0x600 + n]
    theirs.send([Frame(0x581, bytes(8)), Frame(0x081, bytes(8)), Frame(0x701, b"\x05"), Frame(0x0F0, bytes(8)), Frame(0x521, b"")])
    link.receive([])
    assert [frame.identifier for frame in link.family.aside] == [0x581, 0x081, 0x701, 0x0F0]
    assert link.foreign == 1, "a PDO nobody knows"
    link.close()
    theirs.close()


def test_axes_that_are_not_configured_yet_leave_their_places_in_the_burst_to_the_master() -> None:
    ours, theirs = memory_pair(time.monotonic_ns)
    link = BusLink("memory:", Cia402Family([(0, 1), (1, 2), (2, 3)], 1_000_000, 1_000_000))
    link.port = ours
    link.family.release(2, 8)
    link.acyclic.extend(Frame(0x600 + n, bytes(8)) for n in range(8))
    sets = [Cia402Set() for _ in range(3)]
    for released, leave in ((2, [0x600, 0x601, 0x602]), (3, [0x603, 0x604]), (1, [0x605]), (1, [0x606])):
        link.family.release(released, 8)
        link.prepare(sets)
        assert link.send(time.monotonic_ns())
        assert [frame.identifier for frame in theirs.receive() if frame.identifier >= 0x600] == leave
    link.close()
    theirs.close()


def test_a_dirty_data_sheet_is_reported_by_line_and_still_serves_the_sdo_client() -> None:
    with pytest.raises(ValueError, match="invalid literal for int"):
        canopen_raw(DIRTY)
    dictionary, faults = eds.parse(DIRTY)
    told = [str(fault) for fault in faults]
    assert any("line 5" in text and "ignored" in text for text in told) and any(
        "vendornumber is missing or empty" in text for text in told
    ), told
    read = canopen_dictionary(dictionary, 3)
    assert read[0x6040].name.startswith("Controlword") and len(read[0x6040]) == 16
    part = read.get_variable(0x60C2, 1)
    assert part is not None and len(part) == 8
    assert "VendorNumber" not in clean_sheet(dictionary)


def canopen_raw(text: str) -> object:
    """The file as it is, read by the `canopen` package alone."""
    import io

    from canopen.objectdictionary import import_od

    class Sheet(io.StringIO):
        name = "dirty.eds"

    return import_od(Sheet("\n".join(line for line in text.splitlines() if "this line" not in line)), 3)
