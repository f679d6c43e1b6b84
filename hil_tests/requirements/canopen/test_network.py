"""CiA 301 and 305 around the PDOs: NMT states, boot-up, heartbeat, node guarding, emergencies, LSS, store and restore."""

import pytest

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import START, AbortedError, CanopenBus, Master
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss, nmt
from protocols.canopen.lss import Service
from protocols.canopen.sdo import Abort

SAVE, LOAD = 0x65766173, 0x64616F6C


def ready(*drives: DriveSettings) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(*drives)
    bus.run(0.1)
    return bus, bus.node()


# -- NMT and life -------------------------------------------------------------------------------------


def test_the_boot_up_message_comes_once_and_by_itself() -> None:
    bus, _ = ready()
    assert [(frame.data, frame.stamp_ns - START) for frame in bus.heard(0x701)] == [(b"\0", 10_000_000)]


@pytest.mark.parametrize(
    ("command", "state"),
    [(nmt.Command.START, 5), (nmt.Command.STOP, 4), (nmt.Command.PRE_OPERATIONAL, 127)],
)
def test_nmt_commands_lead_from_every_state_to_theirs(command: nmt.Command, state: int) -> None:
    for first in (nmt.Command.START, nmt.Command.STOP, nmt.Command.PRE_OPERATIONAL):
        for addressed in (0, 1):
            bus, node = ready()
            node.set(0x1017, 10)
            bus.hand(nmt.command(first, 1))
            bus.hand(nmt.command(command, addressed))
            bus.run(0.015)
            assert bus.heard(0x701)[-1].data == bytes((state,))


def test_commands_to_others_and_unknown_ones_are_left_aside() -> None:
    bus, node = ready()
    node.set(0x1017, 10)
    for data in (b"\x01\x02", b"\x07\x01", b"\x01", b"\x01\x01\x01"):
        bus.hand(Frame(0, data))
    bus.run(0.015)
    assert bus.heard(0x701)[-1].data == b"\x7f"


def test_reset_communication_takes_back_what_was_written_and_boots() -> None:
    bus, node = ready()
    node.set(0x1017, 10)
    node.set(0x6081, 777)
    node.nmt(nmt.Command.RESET_COMMUNICATION)
    bus.run(0.05)
    assert bus.heard(0x701)[-1].data == b"\0" and node.read(0x1017) == 0
    assert node.read(0x6081) == 777, "the application keeps its objects"
    node.nmt(nmt.Command.RESET_NODE)
    bus.run(0.05)
    assert node.read(0x6081) == 163840


def test_the_heartbeat_keeps_its_period() -> None:
    bus, node = ready()
    node.set(0x1017, 20)
    start = bus.now
    bus.run(0.1001)
    assert [frame.stamp_ns - start for frame in bus.heard(0x701)[1:]] == [number * 20_000_000 for number in range(6)]


def test_node_guarding_toggles_and_its_loss_is_reported() -> None:
    bus, node = ready()
    node.set(0x100C, 100)
    node.set(0x100D, 3)
    guard = Frame(cobid.heartbeat(1) | cobid.REMOTE)
    assert [bus.hand(guard)[0].data[0] for _ in range(3)] == [0x7F, 0xFF, 0x7F]
    bus.run(0.2999)
    assert not bus.heard(0x81)
    bus.run(0.0002)
    assert bus.heard(0x81)[-1].data[:2] == (0x8130).to_bytes(2, "little")


# -- emergencies --------------------------------------------------------------------------------------


def test_the_history_keeps_the_newest_first_and_is_cleared_by_0_only() -> None:
    bus, node = ready()
    for code in (0x4210, 0x3130, 0x9000):
        bus.slave.force_fault(1, code)
    assert node.read(0x1003, 0) == 3
    assert [node.read(0x1003, sub) & 0xFFFF for sub in (1, 2, 3)] == [0x9000, 0x3130, 0x4210]
    with pytest.raises(AbortedError) as caught:
        node.set(0x1003, 1)
    assert caught.value.code == Abort.VALUE
    node.set(0x1003, 0)
    assert node.read(0x1003, 0) == 0


def test_an_error_that_persists_is_reported_once() -> None:
    bus, node = ready()
    bus.slave.force_fault(1, 0x4210)
    bus.slave.force_fault(1, 0x4210)
    assert len(bus.heard(0x81)) == 0 and node.read(0x1003, 0) == 1
    bus.wake(bus.now)
    assert len(bus.heard(0x81)) == 1


def test_1015_keeps_emergencies_apart_and_1014_moves_or_silences_them() -> None:
    bus, node = ready()
    node.set(0x1015, 500)  # 50 ms
    start = bus.now
    for code in (0x4210, 0x3130, 0x9000):
        bus.slave.force_fault(1, code)
    bus.wake(bus.now)
    bus.run(0.2)
    assert [(frame.stamp_ns - start) // 1_000_000 for frame in bus.heard(0x81)] == [0, 50, 100]
    node.set(0x1014, 0x80000081)
    node.set(0x1014, 0x000000F1)
    bus.slave.force_fault(1, 0x5530)
    bus.run(0.1)
    assert len(bus.heard(0xF1)) == 1
    node.set(0x1014, 0x800000F1)
    bus.slave.force_fault(1, 0x7121)
    bus.run(0.1)
    assert len(bus.heard(0xF1)) == 1 and len(bus.heard(0x81)) == 3


def test_an_emergency_waits_until_its_state_allows_it() -> None:
    bus, node = ready()
    node.nmt(nmt.Command.STOP)
    bus.slave.force_fault(1, 0x4210)
    bus.run(0.5)
    assert not bus.heard(0x81)
    node.nmt(nmt.Command.PRE_OPERATIONAL)
    assert [frame.data[:2] for frame in bus.heard(0x81)] == [(0x4210).to_bytes(2, "little")]


def test_a_drive_that_boots_says_nothing_before_its_boot_up() -> None:
    bus = CanopenBus()
    for frame in (Frame(0x80, b"\x01"), Frame(0x601, bytes.fromhex("4000100000000000")), Frame(0, b"\x01\x00"), Frame(0x201, bytes(6))):
        assert not bus.hand(frame)
    bus.slave.force_fault(1, 0x4210)
    bus.run(0.1)
    assert bus.said[0].identifier == 0x701 and bus.said[0].data == b"\0"


def test_the_identifier_of_a_living_emergency_object_does_not_change() -> None:
    _, node = ready()
    with pytest.raises(AbortedError) as caught:
        node.set(0x1014, 0xF1)
    assert caught.value.code == Abort.VALUE


# -- store and restore --------------------------------------------------------------------------------


def test_what_was_stored_survives_power_and_restore_takes_it_back() -> None:
    bus, node = ready()
    node.set(0x1017, 500)
    node.set(0x6081, 777)
    node.set(0x1010, SAVE, 1)
    assert node.read(0x1010, 1) == 1, "the signature is an order, no value"
    bus.slave.power_off(1)
    bus.run(0.1)
    bus.slave.power_on(1)
    bus.run(0.1)
    assert node.read(0x1017) == 500 and node.read(0x6081) == 777
    node.set(0x1011, LOAD, 1)
    assert node.read(0x6081) == 777, "not before the reset"
    node.nmt(nmt.Command.RESET_NODE)
    bus.run(0.1)
    assert node.read(0x1017) == 0 and node.read(0x6081) == 163840


def test_sub_indexes_2_and_3_store_communication_and_application() -> None:
    for sub, expected in ((2, (500, 163840)), (3, (0, 777))):
        bus, node = ready()
        node.set(0x1017, 500)
        node.set(0x6081, 777)
        node.set(0x1010, SAVE, sub)
        node.nmt(nmt.Command.RESET_NODE)
        bus.run(0.1)
        assert (node.read(0x1017), node.read(0x6081)) == expected


def test_set_values_are_not_stored() -> None:
    bus, node = ready()
    node.set(0x607A, 5000)
    node.set(0x1010, SAVE, 1)
    node.nmt(nmt.Command.RESET_NODE)
    bus.run(0.1)
    assert node.read(0x607A) == 0 and node.read(0x6040) == 0


# -- LSS ------------------------------------------------------------------------------------------------


def answers(bus: CanopenBus, frame: Frame) -> list[bytes]:
    return [answer.data for answer in bus.hand(frame) if answer.identifier == 0x7E4]


def select(bus: CanopenBus, *numbers: int) -> list[bytes]:
    services = (Service.SELECT_VENDOR, Service.SELECT_PRODUCT, Service.SELECT_REVISION, Service.SELECT_SERIAL)
    return [data for service, number in zip(services, numbers, strict=True) for data in answers(bus, lss.request(service, number))]


IDENTITY = (0, 0x402, 0x10000, 77)
DRIVE = DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0), serial=77)


def test_lss_selects_one_slave_by_its_four_numbers() -> None:
    bus, _ = ready(DRIVE, DriveSettings(ServoSettings(boot_s=0.01), serial=78))
    assert select(bus, *IDENTITY[:3], 99) == []
    assert select(bus, *IDENTITY) == [b"\x44" + bytes(7)]
    assert answers(bus, lss.request(Service.INQUIRE_SERIAL)) == [b"\x5d" + (77).to_bytes(4, "little") + bytes(3)]
    assert answers(bus, lss.request(Service.INQUIRE_NODE)) == [b"\x5e\x01" + bytes(6)]


def test_lss_gives_a_node_number_that_counts_after_reset_and_is_stored() -> None:
    bus, _ = ready(DRIVE)
    select(bus, *IDENTITY)
    assert answers(bus, lss.request(Service.CONFIGURE_NODE, 0)) == [b"\x11\x01" + bytes(6)], "out of range"
    assert answers(bus, lss.request(Service.CONFIGURE_NODE, 33)) == [b"\x11\x00" + bytes(6)]
    assert answers(bus, lss.request(Service.STORE)) == [b"\x17\x00" + bytes(6)]
    bus.hand(lss.request(Service.SWITCH_GLOBAL, 0))
    assert bus.node(1).read(0x1000) == 0x20192, "still node 1"
    bus.hand(nmt.command(nmt.Command.RESET_COMMUNICATION, 1))
    bus.run(0.05)
    assert bus.heard(cobid.heartbeat(33)) and bus.node(33).read(0x1000) == 0x20192
    assert bus.node(33).read(0x1014) == 0x80 + 33 and bus.node(33).read(0x1800, 1) == 0x40000180 + 33
    bus.slave.power_off(1)
    bus.run(0.05)
    bus.slave.power_on(1)
    bus.run(0.05)
    assert len(bus.heard(cobid.heartbeat(33))) == 2


def test_lss_bit_timing_knows_its_table() -> None:
    bus, _ = ready(DRIVE)
    bus.hand(lss.request(Service.SWITCH_GLOBAL, 1))
    for index in range(10):
        good = index not in (5, 9)
        assert answers(bus, lss.configure_bit_timing(index)) == [bytes((0x13, 0 if good else 1)) + bytes(6)]
    bus.slave.memory_broken(1, True)
    assert answers(bus, lss.request(Service.STORE)) == [b"\x17\x02" + bytes(6)]


def unconfigured() -> CanopenBus:
    bus, _ = ready(DRIVE)
    bus.hand(lss.request(Service.SWITCH_GLOBAL, 1))
    answers(bus, lss.request(Service.CONFIGURE_NODE, 255))
    bus.hand(lss.request(Service.SWITCH_GLOBAL, 0))
    bus.hand(nmt.command(nmt.Command.RESET_COMMUNICATION, 1))
    bus.run(0.05)
    return bus


def test_a_node_without_number_is_silent_and_found_by_fastscan() -> None:
    bus = unconfigured()
    assert not bus.hand(Frame(0x601, bytes.fromhex("4000100000000000")))
    assert answers(bus, lss.request(Service.IDENTIFY_UNCONFIGURED)) == [b"\x50" + bytes(7)]
    assert answers(bus, lss.fastscan(0, 128, 0, 0))
    found = []
    for sub in range(4):
        number = 0
        for bit in range(31, -1, -1):
            if not answers(bus, lss.fastscan(number, bit, sub, sub)):
                number |= 1 << bit
        assert answers(bus, lss.fastscan(number, 0, sub, (sub + 1) % 4))
        found.append(number)
    assert tuple(found) == IDENTITY
    assert answers(bus, lss.request(Service.CONFIGURE_NODE, 9)), "the scan has selected it"
    bus.hand(lss.request(Service.SWITCH_GLOBAL, 0))
    bus.run(0.05)
    assert bus.heard(cobid.heartbeat(9)), "it takes its number when it leaves configuration"
    assert not answers(bus, lss.fastscan(0, 128, 0, 0)), "a node with a number does not answer a scan"


def test_identify_remote_slave_answers_within_the_ranges_only() -> None:
    services = (
        *(Service.IDENTIFY_VENDOR, Service.IDENTIFY_PRODUCT, Service.IDENTIFY_REVISION_LOW, Service.IDENTIFY_REVISION_HIGH),
        *(Service.IDENTIFY_SERIAL_LOW, Service.IDENTIFY_SERIAL_HIGH),
    )
    for numbers, heard in (
        ((0, 0x402, 0x10000, 0x10000, 70, 80), 1),
        ((0, 0x402, 0x10000, 0x10000, 78, 80), 0),
        ((0, 0x402, 0, 5, 0, 99), 0),
    ):
        bus, _ = ready(DRIVE)
        said = [answers(bus, lss.request(service, number)) for service, number in zip(services, numbers, strict=True)]
        assert sum(map(len, said)) == heard
