"""Further judges: modbus-serial of npm and the client of pymodbus talk to our server, tshark dissects what was said."""

import json
import os
import pathlib
import struct
import subprocess
from typing import Any

import pytest
from pymodbus.client import ModbusTcpClient

from hil_tests.lab.running.modbus_running import Running
from hil_tests.lanes import NODE_MODULES
from hil_tests.unit.protocols.modbus.test_6_7_to_6_21_other_functions import WholeView
from protocols.modbus.view import Kind

SCRIPT = pathlib.Path(__file__).with_name("npm_client.js")


def patterned() -> WholeView:
    view = WholeView()
    for n in range(2000):
        view.bits[Kind.DISCRETE_INPUTS][n], view.words[Kind.INPUT_REGISTERS][n] = n % 3 == 0, 1000 + n
    return view


@pytest.mark.npm
def test_modbus_serial_of_npm_agrees() -> None:
    with Running(view=patterned()) as running:
        environment = {**os.environ, "NODE_PATH": str(NODE_MODULES)}
        done = subprocess.run(
            ["node", str(SCRIPT), str(running.port)], capture_output=True, text=True, timeout=90, check=False, env=environment
        )
        verdicts = done.stdout.splitlines()
        assert [verdict for verdict in verdicts if not verdict.startswith("ok ")] == [] and done.returncode == 0, done.stderr
        assert len(verdicts) == 12


def test_the_client_of_pymodbus_agrees() -> None:
    view = patterned()
    view.status, view.queue = 0x6D, [0x01B8, 0x1284]
    view.files[4][1:3] = [0x0DFE, 0x0020]
    with Running(view=view) as running:
        client: Any = ModbusTcpClient("127.0.0.1", port=running.port, timeout=10)
        assert client.connect()
        assert client.read_exception_status().status == 0x6D
        assert client.diag_query_data(b"\xa5\x37").message == b"\xa5\x37"
        assert client.diag_read_bus_message_count().message == 3
        assert client.diag_get_comm_event_counter().count == 1
        assert client.diag_get_comm_event_log().message_count == 5
        assert client.report_device_id().identifier[0] == 1
        assert client.mask_write_register(address=4, and_mask=0xF2, or_mask=0x25).isError() is False
        written = client.readwrite_registers(read_address=4, read_count=2, write_address=5, values=[9])
        assert written.registers == [0x25 & ~0xF2, 9]
        assert client.read_fifo_queue(address=0x04DE).values == [0x01B8, 0x1284]
        assert client.read_device_information().information[0] == b"axisgate"
        assert client.read_holding_registers(1999, count=2).exception_code == 2
        client.close()


# --------------------------------------------------------------------------------------------------------------- tshark


def capture(packets: list[tuple[bool, bytes]]) -> bytes:
    """A pcap file (raw IPv4) of one TCP connection: (from the client?, bytes)."""
    data = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 101)
    sequence = {True: 1, False: 1}
    for n, (up, payload) in enumerate(packets):
        ports = (40000, 502) if up else (502, 40000)
        tcp = struct.pack(">HHIIBBHHH", *ports, sequence[up], sequence[not up], 0x50, 0x18, 65535, 0, 0) + payload
        sequence[up] += len(payload)
        addresses = (b"\x0a\0\0\x05", b"\x0a\0\0\x14") if up else (b"\x0a\0\0\x14", b"\x0a\0\0\x05")
        ip = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(tcp), n, 0, 64, 6, 0) + b"".join(addresses) + tcp
        data += struct.pack("<IIII", n, 0, len(ip), len(ip)) + ip
    return data


@pytest.mark.tshark
def test_tshark_reads_our_answers_as_they_are_meant(tmp_path: pathlib.Path) -> None:
    view, packets = patterned(), []
    view.words[Kind.HOLDING_REGISTERS][5:7] = [0x1234, 7]
    asked = ["03 0005 0002", "03 07CF 0002", "06 0005 BEEF", "16 0005 00F2 0025", "2B 0E 01 00", "08 0000 A537"]
    with Running(view=view) as running, running.client() as client:
        for n, text in enumerate(asked):
            pdu = bytes.fromhex(text)
            request = struct.pack(">HHHB", n + 1, 0, len(pdu) + 1, 1) + pdu
            client.send(request)
            head = client.take(6)
            packets += [(True, request), (False, head + client.take(struct.unpack(">H", head[4:])[0]))]
    file = tmp_path / "said.pcap"
    file.write_bytes(capture(packets))
    done = subprocess.run(
        ["tshark", "-r", str(file), "-T", "json", "--no-duplicate-keys"], capture_output=True, text=True, timeout=60, check=True
    )
    shown = [packet["_source"]["layers"] for packet in json.loads(done.stdout)]
    assert all("_ws.malformed" not in layers for layers in shown) and len(shown) == 12
    answers = [layers["modbus"] for layers in shown[1::2]]
    assert [answer["modbus.func_code"] for answer in answers] == ["3", "3", "6", "22", "43", "8"]
    assert [answer.get("modbus.exception_code") for answer in answers] == [None, "2", None, None, None, None]
    assert "4660" in json.dumps(answers[0]) and "axisgate" in json.dumps(answers[4])
