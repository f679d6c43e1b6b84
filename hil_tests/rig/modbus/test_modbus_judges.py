"""Clients we did not write read and write our server: Debian's mbpoll, and libmodbus.  And the load of the benches, judged itself.

mbpoll counts references from 1 (`-r 1` is protocol address 0, the "40001" of manuals); with `-0` it counts from 0 as the protocol,
the cell file and these tests do.
"""

import json
import pathlib
import shutil
import subprocess

import pytest

from hil_tests.lab.partners import mbpoll as client
from hil_tests.lab.partners.mbpoll import values_of
from hil_tests.lab.running.modbus_running import Running
from hil_tests.lab.virtual.modbus_view import MemoryView
from hil_tests.lanes import REFERENCES, required
from protocols.modbus.view import ExceptionCode, Kind

SOURCE = pathlib.Path(__file__).with_name("libmodbus_client.c")
TABLES = {"0": Kind.COILS, "1": Kind.DISCRETE_INPUTS, "3": Kind.INPUT_REGISTERS, "4": Kind.HOLDING_REGISTERS}


def mbpoll(running: Running, *options: str, values: tuple[int, ...] = (), unit: int = 1) -> tuple[int, str]:
    return client.mbpoll(running.port, *options, values=values, unit=unit)


def patterned() -> MemoryView:
    view = MemoryView(size=2000)
    for n in range(2000):
        view.bits[Kind.COILS][n], view.bits[Kind.DISCRETE_INPUTS][n] = n % 4 == 1, n % 3 == 0
        view.words[Kind.HOLDING_REGISTERS][n], view.words[Kind.INPUT_REGISTERS][n] = 60_000 + n, 1000 + n
    return view


@pytest.mark.mbpoll
@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("reference, options", [(1, ()), (8, ()), (0, ("-0",)), (1875, ())])
def test_mbpoll_reads_each_table(table: str, reference: int, options: tuple[str, ...]) -> None:
    kind, first = TABLES[table], reference if options else reference - 1
    with Running(view=patterned()) as running:
        code, text = mbpoll(running, "-t", table, "-r", str(reference), "-c", "125", *options)
        source: list[bool] | list[int] = running.view.bits[kind] if table in "01" else running.view.words[kind]
        assert (code, values_of(text)) == (0, {reference + n: int(source[first + n]) for n in range(125)})


@pytest.mark.mbpoll
@pytest.mark.parametrize("values", [(1,), (1, 0, 1, 1, 0, 1, 0, 0, 1)])
def test_mbpoll_writes_coils(values: tuple[int, ...]) -> None:
    """One value is FC 5, several are FC 15."""
    with Running() as running:
        assert mbpoll(running, "-t", "0", "-r", "8", values=values)[0] == 0
        assert running.view.bits[Kind.COILS] == [False] * 7 + [bool(value) for value in values] + [False] * (193 - len(values))


@pytest.mark.mbpoll
@pytest.mark.parametrize("values", [(54321,), (1, 65535, 0, 258)])
def test_mbpoll_writes_registers(values: tuple[int, ...]) -> None:
    """One value is FC 6, several are FC 16."""
    with Running() as running:
        assert mbpoll(running, "-t", "4", "-r", "20", values=values)[0] == 0
        assert running.view.words[Kind.HOLDING_REGISTERS] == [0] * 19 + list(values) + [0] * (181 - len(values))


@pytest.mark.mbpoll
def test_mbpoll_reads_a_real_high_word_first_with_its_option_b() -> None:
    """AX-010: 32-bit values have their high word first, which mbpoll calls big endian."""
    with Running() as running:
        running.view.words[Kind.INPUT_REGISTERS][10:12] = [0x42F6, 0xE979]  # 123.456
        _, text = mbpoll(running, "-t", "3:float", "-B", "-r", "11")
        assert "[11]: \t123.456" in text


@pytest.mark.mbpoll
def test_mbpoll_names_our_exceptions() -> None:
    with Running() as running:
        assert "Illegal data address" in mbpoll(running, "-t", "4", "-r", "201")[1]
        assert "Target device failed to respond" in mbpoll(running, unit=17)[1]
        running.view.fails = ExceptionCode.SERVER_DEVICE_FAILURE
        assert "Slave device or server failure" in mbpoll(running)[1]


@pytest.fixture(scope="module")
def libmodbus_client() -> pathlib.Path:
    """Built here when make has not: it needs gcc and libmodbus-dev."""
    program = REFERENCES / SOURCE.stem
    if program.exists() and program.stat().st_mtime >= SOURCE.stat().st_mtime:
        return program
    REFERENCES.mkdir(exist_ok=True)
    command = ["gcc", "-O2", "-Wall", "-o", str(program), str(SOURCE), "-lmodbus"]
    built = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False) if shutil.which("gcc") else None
    if built is None or built.returncode:
        reason = f"{program.name} cannot be built (Debian: apt-get install gcc libmodbus-dev): {built.stderr if built else 'no gcc'}"
        pytest.fail(reason) if required() else pytest.skip(reason)
    return program


@pytest.mark.cref
def test_libmodbus_agrees_with_every_function_code_limit_and_exception(libmodbus_client: pathlib.Path) -> None:
    view = patterned()
    view.bits[Kind.COILS] = [False] * 2000
    view.words[Kind.HOLDING_REGISTERS] = [0] * 2000
    with Running(view=view) as running:
        done = subprocess.run([str(libmodbus_client), str(running.port)], capture_output=True, text=True, timeout=60, check=False)
        verdicts = done.stdout.splitlines()
        assert [line for line in verdicts if not line.startswith("ok ")] == [] and done.returncode == 0
        assert len(verdicts) == 38 and running.server.counters.closed == {}


def load(running: Running, *options: str) -> tuple[int, dict[str, float]]:
    command = [str(REFERENCES / "modbus_load"), "-p", str(running.port), "-t", "0.3", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    return done.returncode, json.loads(done.stdout)


@pytest.mark.cref
@pytest.mark.parametrize("function, count", [(1, 2000), (2, 9), (3, 10), (4, 125)])
@pytest.mark.parametrize("depth", [1, 4])
def test_the_load_counts_what_the_server_answers(function: int, count: int, depth: int) -> None:
    with Running(view=patterned()) as running:
        code, told = load(running, "-f", str(function), "-c", str(count), "-d", str(depth))
        assert (code, told["errors"], told["requests"]) == (0, 0, running.server.counters.requests)
        assert told["requests"] > 100 and running.server.counters.connections == 8
        assert 0 < told["p50_us"] <= told["p99_us"]


@pytest.mark.cref
def test_the_load_sees_wrong_answers() -> None:
    with Running() as running:
        code, told = load(running, "-f", "3", "-a", "199", "-c", "2", "-n", "3")  # beyond the table: exceptions
        assert (code, told["errors"], told["requests"]) == (1, 3, 0)
