"""A running cell with all kinds of [[modbus]]: registers of the cell, RTU on a simulated line, a client with a foreign device."""

import asyncio
import pathlib
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pymodbus.client import ModbusTcpClient
from pymodbus.pdu.file_message import FileRecord

import gateway
from drivers.ports.base import runtime_dir
from gateway.conformance.modbus.probe import Prober, probe
from gateway.tools.client import ToolClient
from hil_tests.lab.running.cell_running import CellRun, free_port, running_cell
from hil_tests.lab.running.modbus_running import RawClient
from hil_tests.rig.modbus.test_modbus_rtu import pymodbus_server
from protocols.modbus.probing import Verdict, cases

pytestmark = pytest.mark.mbpoll
CELL = """
[[modbus]]
name = "rtu"
framing = "rtu"
port = "sim"
format = "115200 8E1"
unit = 3
patience_ms = 300
[[modbus.registers]]
at = 200
from = "cell.life"

[[modbus]]
name = "coupler"
role = "client"
port = "tcp://127.0.0.1:{port}"
[[modbus.device]]
name = "tank"
probe_ms = 500
[[modbus.value]]
device = "tank"
table = "input"
at = 5
type = "UINT16"
to = "tank.level"
every_ms = 50
[[modbus.value]]
device = "tank"
table = "holding"
at = 9
type = "UINT16"
from = "tank.level"
every_ms = 200
[[db]]
number = 40
words = 4
writer = "plc2"
line = "plc1"
[[route]]
name = "recipe"
from = "DB40.DW 2"
type = "u16"
to = "AW 40"
valid = "A 42.0"
"""


class Tank:
    """A device of pymodbus' making that can be switched off and on again."""

    def __init__(self) -> None:
        self.port = free_port()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._server: Any = None

    def on(self) -> None:
        self._server = pymodbus_server(port=self.port)
        asyncio.run_coroutine_threadsafe(self._server.__aenter__(), self._loop).result(10)

    def off(self) -> None:
        asyncio.run_coroutine_threadsafe(self._server.__aexit__(None, None, None), self._loop).result(10)

    def register(self, address: int) -> int:
        client: Any = ModbusTcpClient("127.0.0.1", port=self.port, timeout=5)
        assert client.connect()
        found: int = client.read_holding_registers(address, count=1).registers[0]
        client.close()
        return found


@pytest.fixture(scope="module")
def tank() -> Tank:
    tank = Tank()
    tank.on()
    return tank


@pytest.fixture(scope="module")
def run(tank: Tank, tmp_path_factory: pytest.TempPathFactory) -> Iterator[CellRun]:
    demo = pathlib.Path(gateway.__file__).parents[1] / "configs/cells/demo.toml"
    registers = '[[modbus.registers]]\nat = 2100\nfrom = "axis.*.actual"\n'
    text = demo.read_text().replace("# ---- drives ---", f"{registers}\n# ---- drives ---", 1)
    assert registers in text
    file = tmp_path_factory.mktemp("cell") / "modbus.toml"
    file.write_text(text + CELL.replace("{port}", str(tank.port)))
    with running_cell(str(file), "mbcell", plc=False) as run:
        yield run


def until(holds: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + 30
    while not holds():
        assert time.monotonic() < end, f"{what}: not within 30 s"
        time.sleep(0.05)


def rtu(*words: str, values: tuple[str, ...] = ()) -> subprocess.CompletedProcess[str]:
    device = str(runtime_dir() / "mbcell-rtu-a")
    command = ["mbpoll", "-m", "rtu", "-b", "115200", "-P", "none", "-0", "-1", "-o", "5", "-a", "3", *words, device, *values]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)


def value(run: CellRun, name: str) -> str:
    client = ToolClient(run.name)
    try:
        return str(client.ask("get", address=name))
    finally:
        client.close()


def test_registers_of_the_cell_hold_the_axes_places(run: CellRun) -> None:
    client: Any = ModbusTcpClient("127.0.0.1", port=run.port, timeout=10)
    assert client.connect()
    words = client.read_input_registers(2100, count=12).registers
    places = struct.unpack(">6f", struct.pack(">12H", *words))
    state = run.state()
    assert places[0] == pytest.approx(state.axes[0].actual * 1000, abs=0.5)
    assert client.read_holding_registers(2112, count=1).isError()
    identity = client.read_device_information(read_code=3).information
    assert identity[0] == b"axisgate" and identity[6] == b"plc2"
    client.close()


def test_the_probe_finds_nothing_on_the_server_of_a_running_cell(run: CellRun) -> None:
    asked = cases(writes=True)
    found = {result.case.name: (result.verdict, result.why) for result in probe(Prober("127.0.0.1", run.port, 1.0), asked, lambda _: None)}
    assert {name: told for name, told in found.items() if told[0] in (Verdict.WARN, Verdict.FAIL)} == {} and len(found) == len(asked) > 60


def test_a_file_of_this_server_is_written_read_back_and_joined_and_no_other(run: CellRun) -> None:
    """AX-479: FC 21 by pymodbus and by hand; DB 40 is the Modbus PLC's, DB 11 is ours, DB 10 is the PLC's on the line."""
    judge: Any = ModbusTcpClient("127.0.0.1", port=run.port, timeout=10)
    assert judge.connect() and not judge.write_file_record([FileRecord(40, 1, b"\x12\x34\x00\x4d")]).isError()
    judge.close()
    with RawClient(run.port) as plc:
        whole = "14 0A 09 06 00 00 12 34 00 4D 00 00"
        assert plc.ask("14 07 06 0028 0000 0004") == whole
        until(lambda: plc.ask("03 0014 0002") == "03 04 00 4D 01 00", "the route has word 2, and its valid bit")
        for file, first in ((10, 0), (11, 0), (41, 0), (40, 3), (40, 4)):
            assert plc.ask(f"15 0B 06 {file:04x} {first:04x} 0002 ffff ffff") == "95 02", (file, first)
        assert plc.ask("15 12 06 0028 0000 0001 ffff 06 000A 0000 0001 ffff") == "95 02"
        assert plc.ask("14 07 06 0028 0000 0004") == whole, "what is refused writes nothing"
    until(lambda: "'value': 0" in value(run, "A 42.0"), "silent: what it wrote is old")


def test_a_judge_on_the_simulated_line_reads_the_cell_over_rtu(run: CellRun) -> None:
    until(lambda: rtu("-t", "3", "-r", "0", "-c", "64").returncode == 0, "the line answers")
    first, second = rtu("-t", "4", "-r", "200", "-c", "1"), rtu("-t", "4", "-r", "200", "-c", "1")
    assert "[200]" in first.stdout and "[200]" in second.stdout and first.stdout != second.stdout, "the life counter counts"
    refused = rtu("-t", "0", "-r", "24", values=("1",))
    assert refused.returncode != 0 and "Illegal data address" in refused.stdout + refused.stderr, "byte 3 is another command source's"


def test_a_client_carries_values_both_ways_and_comes_back(run: CellRun, tank: Tank) -> None:
    until(lambda: tank.register(9) == 5, "input register 5 has become tank.level and gone to holding register 9")
    tank.off()
    until(lambda: "stale" in value(run, "tank.level").lower(), "the value is marked old")
    tank.on()
    until(lambda: tank.register(9) == 5, "the new device (it starts with 9) is written again")
    until(lambda: "stale" not in value(run, "tank.level").lower(), "fresh again")
    tank.off()
