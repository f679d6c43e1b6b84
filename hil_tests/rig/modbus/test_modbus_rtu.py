"""RTU on a real port, read by clients we did not write; RTU over TCP; and our clients against servers we did not write."""

import asyncio
import pathlib
import subprocess
import threading
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any

import pytest
from pymodbus import FramerType
from pymodbus.client import ModbusTcpClient
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext
from pymodbus.server import ModbusTcpServer

from drivers.ports.serial.line_format import parse_format
from drivers.ports.serial.pty import PtyPort
from gateway.links.modbus.client import Device, Group, Kind, Link, ModbusClient, ModbusRefused, ModbusSilent
from hil_tests.lab.running.modbus_line_running import RunningLine
from hil_tests.lab.running.modbus_running import Running
from hil_tests.lab.virtual.modbus_view import MemoryView
from hil_tests.rig.modbus.test_modbus_judges import libmodbus_client, patterned  # noqa: F401 - the fixture
from protocols.base.machine import Ns, ms
from protocols.modbus.mbap import Why

HOLDING = Kind.HOLDING_REGISTERS


def whole() -> MemoryView:
    view = patterned()
    view.bits[Kind.COILS] = [False] * 2000
    view.words[HOLDING] = [0] * 2000
    return view


@pytest.mark.cref
def test_libmodbus_agrees_over_rtu(libmodbus_client: pathlib.Path) -> None:  # noqa: F811
    with RunningLine(whole()) as line:
        done = subprocess.run([str(libmodbus_client), line.device], capture_output=True, text=True, timeout=60, check=False)
        verdicts = done.stdout.splitlines()
        assert [verdict for verdict in verdicts if not verdict.startswith("ok ")] == [] and done.returncode == 0
        assert len(verdicts) == 36
        assert line.server.counters.foreign == 1, "unit 9 was passed over"


@pytest.mark.mbpoll
def test_mbpoll_reads_and_writes_over_rtu() -> None:
    with RunningLine(patterned()) as line:
        command = ["mbpoll", "-m", "rtu", "-b", "115200", "-P", "none", "-a", "1", "-0", "-1", "-o", "5"]
        read = subprocess.run(
            [*command, "-t", "4", "-r", "7", "-c", "3", line.device], capture_output=True, text=True, timeout=30, check=False
        )
        assert "60007" in read.stdout and "60009" in read.stdout and read.returncode == 0
        subprocess.run([*command[:-3], "-o", "5", "-t", "4", "-r", "7", line.device, "4711"], capture_output=True, timeout=30, check=False)
        assert line.view.words[HOLDING][7] == 4711


def test_pymodbus_speaks_rtu_over_tcp_with_our_server() -> None:
    with Running(view=patterned(), rtu=True) as running:
        client: Any = ModbusTcpClient("127.0.0.1", port=running.port, framer=FramerType.RTU, timeout=10)
        assert client.connect()
        assert client.read_holding_registers(5, count=3, device_id=1).registers == [60005, 60006, 60007]
        assert not client.write_registers(5, [1, 2, 3], device_id=1).isError()
        assert client.read_holding_registers(5, count=125, device_id=1).registers[:4] == [1, 2, 3, 60008]
        assert client.read_coils(1, count=3, device_id=1).bits[:3] == [True, False, False]
        assert client.readwrite_registers(read_address=0, read_count=2, write_address=0, values=[9], device_id=1).registers == [9, 60001]
        assert client.mask_write_register(address=0, and_mask=0xFFF0, or_mask=5, device_id=1).isError() is False
        assert running.view.words[HOLDING][0] == 5
        client.close()


def test_garbage_in_rtu_over_tcp_closes_that_connection_only() -> None:
    with Running(view=patterned(), rtu=True) as running, running.client() as bad, running.client() as good:
        bad.send(bytes(range(200)))
        assert bad.closed_after_s() < 5
        good.send(bytes.fromhex("01 03 00 05 00 01 94 0B"))
        assert good.take(7).hex(" ") == "01 03 02 ea 65 37 0f"
        running.until(lambda: running.server.counters.closed == {Why.CHECK: 1}, "the bad one is counted")


# ----------------------------------------------------------------------------------------------------------- our clients


@asynccontextmanager
async def pymodbus_server(framer: FramerType = FramerType.SOCKET, port: int = 0) -> AsyncIterator[int]:
    """A server we did not write; unit 1, 200 of everything, register N = N."""
    from pymodbus.datastore import ModbusDeviceContext

    made: Any = ModbusSequentialDataBlock  # comes without types

    def block() -> Any:
        return made(1, [n & 0xFFFF for n in range(200)])  # its own addresses begin at 1

    context = ModbusServerContext(devices={1: ModbusDeviceContext(di=block(), co=block(), hr=block(), ir=block())}, single=False)
    server: Any = ModbusTcpServer(context, framer=framer, address=("127.0.0.1", port))
    await server.listen()
    try:
        yield server.transport.sockets[0].getsockname()[1]
    finally:
        await server.shutdown()


def play(scene: Callable[[], Coroutine[object, object, None]]) -> None:
    asyncio.run(asyncio.wait_for(scene(), 60))


async def until(holds: Callable[[], object], what: str) -> None:
    for _ in range(3000):
        if holds():
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"{what}: not within 30 s")


@pytest.mark.parametrize("framing, framer", [("tcp", FramerType.SOCKET), ("rtu", FramerType.RTU)])
def test_our_client_reads_and_writes_a_server_of_pymodbus(framing: str, framer: FramerType) -> None:
    async def scene() -> None:
        async with pymodbus_server(framer) as port:
            client = ModbusClient(Link(f"tcp://127.0.0.1:{port}", framing), [Device("a", timeout=ms(5000))])
            client.start()
            await until(lambda: client.connected, "connected")
            assert await client.read("a", HOLDING, 5, 3) == (5, 6, 7)
            await client.write_words("a", 5, [700])
            await client.write_words("a", 6, [701, 702])
            assert await client.read("a", HOLDING, 5, 4) == (700, 701, 702, 8)
            await client.write_bits("a", 3, [False])
            await client.write_bits("a", 4, [True, False, True])
            assert await client.read("a", Kind.COILS, 3, 4) == (0, 1, 0, 1)
            with pytest.raises(ModbusRefused) as refused:
                await client.read("a", HOLDING, 199, 2)
            assert refused.value.code == 2
            client.close()
            with pytest.raises(RuntimeError):
                client.order("a", b"\x07")

    play(scene)


def test_our_client_comes_back_by_itself_and_marks_what_is_old() -> None:
    async def scene() -> None:
        values: list[tuple[int, ...] | None] = []
        alive: list[tuple[str, bool]] = []

        def on_values(found: tuple[int, ...] | None, now: Ns) -> None:
            values.append(found)

        async with pymodbus_server() as port:
            client = ModbusClient(Link(f"tcp://127.0.0.1:{port}"), [Device("a")], lambda name, is_alive: alive.append((name, is_alive)))
            client.poll(Group("g", "a", HOLDING, 1, 2, ms(20)), on_values)
            client.start()
            await until(lambda: values.count((1, 2)) > 3, "polled")
        await until(lambda: values[-1] is None and not client.connected, "told that it is old")
        with pytest.raises(ModbusSilent):
            await client.read("a", HOLDING, 0, 1)
        before = len(values)
        async with pymodbus_server(port=port):
            await until(lambda: (1, 2) in values[before:], "back")
            assert alive == [("a", True), ("a", False), ("a", True)]
            client.close()

    play(scene)


def test_our_client_on_a_line_reads_our_server_on_its_other_end() -> None:
    """Both sides ours: the line, the timers and the loop are the matter here; the bytes were judged above."""
    results: list[object] = []
    with RunningLine(patterned()) as line:

        async def scene() -> None:
            client = ModbusClient(
                Link(f"pty:{line.device}", "rtu", "115200 8N1", ms(300)),
                [Device("a", timeout=ms(3000)), Device("nobody", unit=9, timeout=ms(100), retries=0, demote_after=1)],
                open_port=lambda: PtyPort(line.device, parse_format("115200 8N1"), marks=False),
            )
            client.start()
            await until(lambda: client.connected, "open")
            results.append(await client.read("a", HOLDING, 0, 2))
            await client.write_words("a", 0, [1, 2])
            results.append(await client.read("a", HOLDING, 0, 3))
            with pytest.raises(ModbusSilent):
                await client.read("nobody", HOLDING, 0, 1)
            results.append(client.devices["nobody"].dead)
            client.close()

        thread = threading.Thread(target=play, args=(scene,))
        thread.start()
        thread.join(90)
    assert results == [(60000, 60001), (1, 2, 60002), True]
