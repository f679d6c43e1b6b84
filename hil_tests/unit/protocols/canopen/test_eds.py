"""EDS files as plain tables: our own against the canopen package, its dirty twin fault by fault, the emulated drive from either."""

import dataclasses
import pathlib

import canopen
import pytest

from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings
from gateway.files.find import find_config
from hil_tests.lab.virtual.canopen_bus import DICTIONARY, CanopenBus, rpdo1, tpdo1
from protocols.canopen.dictionary import Access, Shape
from protocols.canopen.eds import number_of, parse
from protocols.canopen.sdo import Abort

OURS = find_config("axisgate_402.eds", "drives")
DIRTY = pathlib.Path(__file__).parents[3] / "vectors" / "axisgate_402_dirty.eds"
DIRTY_DICTIONARY, DIRTY_FAULTS = parse(DIRTY.read_bytes().decode("utf-8"))


def test_our_own_data_sheet_has_no_fault() -> None:
    _, faults = parse(OURS.read_text())
    assert faults == ()


def test_the_canopen_package_reads_the_same_from_our_data_sheet() -> None:
    theirs = canopen.import_od(str(OURS), 5)
    compared = 0
    for entry in DICTIONARY:
        foreign = theirs[entry.index]
        variable = foreign if isinstance(foreign, canopen.objectdictionary.ODVariable) else foreign[entry.sub]
        assert (variable.data_type, variable.access_type) == (entry.type.code, entry.access.value), str(entry)
        assert bool(variable.pdo_mappable) is entry.mappable
        if entry.low is not None:
            assert (variable.min, variable.max) == (entry.low, entry.high)
        if variable.default is not None:
            assert variable.default == entry.default_of(5), str(entry)
        compared += 1
    assert compared == len(DICTIONARY.entries) > 250
    assert set(theirs) == set(DICTIONARY.heads) | set(DICTIONARY.dummies) or set(theirs) >= set(DICTIONARY.heads)


def test_every_fault_of_a_dirty_file_is_named_with_line_and_consequence() -> None:
    lines = DIRTY.read_bytes().decode("utf-8").splitlines()
    told = [(fault.section, fault.what.split(" (")[0].split(":")[0], fault.taken) for fault in DIRTY_FAULTS]
    assert told == [
        ("DeviceInfo", "vendornumber is missing or empty", "read as 0"),
        ("DeviceInfo", "revisionnumber=1.0 is not a number", "read as 0"),
        ("1001", "ParameterName is missing or empty", "called 'object 1001h'"),
        ("OptionalObjects", "object 60E9h is listed but not described", "it does not exist"),
        ("1016SUB4", "section without closing bracket", "read as [1016SUB4]"),
        ("605A", "LowLimit 8 is above HighLimit 0", "no limits"),
        ("6067", "AccessType=read/write is unknown", "read as ro"),
        ("607D", "SubNumber=9, but 3 sub-indexes are described", "the described ones count"),
        ("6084", "DefaultValue=1,638,400", "ignored"),
        ("60E3", "object 60E3h is described but not listed", "it exists"),
        ("6083", "duplicate section", "its keys are added to the first"),
        ("6083", "duplicate key ParameterName", "the first one counts"),
        ("6083", "'this line says nothing' is neither section nor key=value", "ignored"),
        ("6402", "duplicate section", "its keys are added to the first"),
        ("6402", "duplicate key AccessType", "the first one counts"),
        ("2003", "DataType 00FEh is unknown", "read as DOMAIN"),
        ("2003", "DefaultValue=0", "ignored"),
        ("2004", "DataType is missing or empty", "left out"),
        ("2F01sub1", "section [2F01] is missing", "object made up as RECORD"),
    ]
    for fault in DIRTY_FAULTS:
        if fault.section == "6084":
            assert lines[fault.line - 1] == "DefaultValue=1,638,400"
        if fault.what.startswith("duplicate section"):
            assert lines[fault.line - 1] == f"[{fault.section}]"


def test_what_is_only_unusual_is_read_without_a_word() -> None:
    """BOM, CR LF, spaces, remarks behind values, $NodeId after the number, h for hexadecimal, two's complement, octal, CompactSubObj."""
    entries = DIRTY_DICTIONARY.entries
    assert entries[0x1014, 0].default_of(5) == 0x85 and entries[0x1014, 0].relative
    assert entries[0x1400, 1].default_of(5) == 0x205
    assert entries[0x607D, 1].default == -(2**31)
    assert entries[0x6068, 0].default == 5 and number_of("010") == 8 and number_of("0x1F") == 31
    assert entries[0x6065, 0].default == 16384 and entries[0x6085, 0].access is Access.RWW
    assert [entries[0x1003, sub].name for sub in (1, 2)] == ["Pre-defined error field1", "Older"] and (0x1003, 8) in entries
    assert DIRTY_DICTIONARY.heads[0x1003].shape is Shape.ARRAY


def test_the_rest_of_a_dirty_file_is_as_good_as_that_of_a_clean_one() -> None:
    faulty = {0x1001, 0x1003, 0x1014, 0x1400, 0x605A, 0x6067, 0x6084, 0x6085, 0x2003, 0x2004, 0x2F01, 0x60E3}
    for entry in DICTIONARY:
        if entry.index not in faulty:
            assert DIRTY_DICTIONARY.entries[entry.key] == entry, str(entry)


def test_a_dcf_carries_values_and_the_node() -> None:
    text = "[1017]\nParameterName=Beat\nObjectType=7\nDataType=6\nAccessType=rw\nDefaultValue=0\nParameterValue=250\n"
    dictionary, _ = parse(
        text
        + "[1014]\nParameterName=E\nDataType=7\nAccessType=rw\nParameterValue=$NODEID+0x80\n[DeviceComissioning]\nNodeID=9\nBaudrate=500\n"
    )
    assert dictionary.entries[0x1017, 0].parameter_of(3) == 250 and dictionary.entries[0x1014, 0].parameter_of(9) == 0x89
    assert (dictionary.node, dictionary.bit_rate) == (9, 500_000)


def dirty_bus() -> CanopenBus:
    bus = CanopenBus(DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0, brake=False)))
    bus.slave = Cia402Slave(bus.settings, {1: DIRTY_DICTIONARY})
    bus.wake(bus.now)
    return bus


def test_a_drive_from_a_dirty_file_boots_and_moves() -> None:
    bus = dirty_bus()
    node = bus.node()
    node.in_cycle()
    for step in range(1, 101):
        answers = bus.cycle(rpdo1(1, 15, 50 * step))
    assert tpdo1(answers[0])[0] & 0x6F == 0x27 and tpdo1(answers[0])[1] > 4000
    assert bus.slave.seat(1).node.objects.upload((0x2003, 0)) == Abort.INTERNAL, "its type cannot carry its value"


@pytest.mark.parametrize(
    "gone", sorted({index for index in DICTIONARY.heads if index >= 0x2000} - {0x6040, 0x6041, 0x6064, 0x607A, 0x6060})
)
def test_a_drive_whose_data_sheet_lacks_an_object_works_without_it(gone: int) -> None:
    entries = {key: entry for key, entry in DICTIONARY.entries.items() if key[0] != gone}
    heads = {index: head for index, head in DICTIONARY.heads.items() if index != gone}
    bus = CanopenBus(DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0, brake=False)))
    lean = dataclasses.replace(DICTIONARY, entries=entries, heads=heads)
    bus.slave = Cia402Slave(BusSettings(4.0, 1, {}, bus.settings.nodes), {1: lean})
    bus.wake(bus.now)
    node = bus.node()
    node.in_cycle()
    for step in range(1, 21):
        answers = bus.cycle(rpdo1(1, 15, 50 * step))
    assert tpdo1(answers[0])[0] & 0x6F == 0x27 and tpdo1(answers[0])[1] > 200
    node.set(0x6060, 1)
    node.control(0x1F)
    bus.run(0.05)
    node.set(0x6060, 3)
    bus.run(0.02)
    node.set(0x6060, 6)
    node.control(0x0F)
    node.control(0x1F)
    bus.run(0.05)
    node.control(0x02)
    bus.run(0.1)
    assert node.status & 0x6F == 0x40
