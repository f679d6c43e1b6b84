"""`check` of CANopen buses: identifiers with two senders, the gateway's own node, a controlword mapped twice by a DCF."""

import pathlib

import pytest

import configs
from drivers.drives.canopen_plan import dictionary_map_faults
from gateway.assembly.canopen_nodes import node_plans
from gateway.cell_file.load import CellFaults, load_cell
from gateway.checks.playable import not_playable
from protocols.canopen import eds

CELLS = pathlib.Path(configs.__path__[0]) / "cells"
DEMO_402 = (CELLS / "demo-402.toml").read_text()


def faults_of(text: str) -> list[str]:
    with pytest.raises(CellFaults) as caught:
        load_cell("cell.toml", text)
    return [f"{fault.key} {fault.hint}" for fault in caught.value.faults]


def test_both_protocols_on_one_port_are_refused_with_the_list_of_identifiers() -> None:
    text = DEMO_402.replace('port     = "sim"                     # the broker', 'port     = "socketcan:vcan0"         # the broker')
    text = text.replace('{ type = "cia402", bus = "drives", node = 6,', '{ type = "servodyn", bus = "old", module = 6,').replace(
        'module = 6, eds = "axisgate_402.eds",', "module = 6,"
    )
    text = text.replace('{ type = "cia402", bus = "drives", node = 5,', '{ type = "cia402", bus = "drives", node = 20,')
    second = '[[bus]]\nname = "old"\nport = "socketcan:vcan0"\nprotocol = "servodyn"\n\n[defaults.axis]'
    found = faults_of(text.replace("[defaults.axis]", second))
    assert "bus.old 660 (294h) is TPDO2 of axis A5 and actual value of axis A6" in found


def test_node_127_is_the_gateways() -> None:
    found = faults_of(DEMO_402.replace("node = 6,", "node = 127,"))
    assert any("axis.A6.drive.node" in text and "heartbeat" in text for text in found)
    assert any("77Fh" in text for text in found)


def test_a_dcf_that_maps_the_controlword_twice_is_refused_with_both_places() -> None:
    rows = []
    for number, words in ((0, (0x60400010, 0x607A0020)), (1, (0x60400010, 0x60600008))):
        rows += [f"[16{number:02X}]", "ParameterName=map", "ObjectType=9", "SubNumber=3"]
        for sub, word in enumerate(words, 1):
            rows += [f"[16{number:02X}sub{sub}]", "ParameterName=entry", "DataType=7", "AccessType=rw", f"ParameterValue={word:#010x}"]
    dictionary, _ = eds.parse("[DeviceInfo]\n" + "\n".join(rows))
    assert dictionary_map_faults(dictionary, 1) == [
        "6040h is mapped in RPDO1 and RPDO2: one of them would switch the drive off with its stale copy"
    ]


def test_a_serial_number_of_0_pins_nothing_and_check_says_so() -> None:
    text = DEMO_402.replace("node = 2,", 'node = 2, serial = "0x0",').replace("node = 3,", 'node = 3, serial = "7",')
    cell = load_cell("cell.toml", text)
    said = {notice.where: notice.text for notice in cell.warnings if "does not identify a drive" in notice.text}
    assert list(said) == ["axis.A2.drive.serial"]
    plans = dict(node_plans(cell, cell.bus[0], 4, simulated=False))
    assert plans["A2"].identity.serial is None and plans["A3"].identity.serial == 7


def test_our_data_sheet_maps_no_domain() -> None:
    """CiA 306: an object of type DOMAIN has no PDOMapping."""
    sections = (CELLS.parent / "drives" / "axisgate_402.eds").read_text().split("\n[")
    domains = [section for section in sections if "ObjectType=0x2\n" in section or "DataType=0x000F" in section]
    assert domains and not [section for section in domains if "PDOMapping" in section]


def test_the_shipped_cells_have_no_collision() -> None:
    assert not_playable(load_cell("demo-402")) == [] and not_playable(load_cell("s5-rk512")) == []
