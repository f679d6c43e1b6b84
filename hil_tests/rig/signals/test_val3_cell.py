"""dio, aio and ioStatus of a VAL 3 controller in a running cell, by mbpoll and by `axisgate var`: val3 3.5; AX-338, AX-408."""

import json
import pathlib
import socket
import struct
import time
from collections.abc import Callable

import pytest

from drivers.ports.base import runtime_dir
from hil_tests.lab.partners.mbpoll import mbpoll, values_of
from hil_tests.lab.partners.signal_plc import signal_cell
from hil_tests.lab.running.cell_running import running_cell

POINT = '[[controller.point]]\nname = "{}"\nboard = "B"\nmodule = "M"\naddress = "{}"\n{}\n'
POINTS = "".join(
    POINT.format(*row)
    for row in (
        ("start", "%I0", "bit = 64"),
        ("lamp", "%Q0", "bit = 704\noutput = true"),
        ("level", "%IW0", "byte = 10\nsteps = 100\nmin = -10.0\nmax = 10.0"),
        ("speed", "%QW0", "byte = 100\nsteps = 10\nmin = -20.0\nmax = 20.0\noutput = true"),
    )
)
PICTURE = 5  # unit
BITS, INPUT_BITS, WORDS, INPUT_WORDS = "0", "1", "4", "3"  # mbpoll's -t


def services_ask(run: str, **request: str) -> dict[str, object]:
    """As `axisgate var` asks."""
    with socket.socket(socket.AF_UNIX) as link:
        link.connect(str(runtime_dir() / f"{run}-services.sock"))
        link.sendall(json.dumps(request).encode() + b"\n")
        found: dict[str, object] = json.loads(link.makefile().readline())
        return found


def until(holds: Callable[[], object], what: str) -> None:
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.05)


@pytest.mark.mbpoll
def test_points_are_one_picture_for_plc_and_program(tmp_path: pathlib.Path) -> None:
    cell = pathlib.Path(signal_cell(tmp_path, "net", f'kind = "val3"\n{POINTS}'))
    text = cell.read_text().replace('name = "net"', f'name = "net"\nunits = [ {{ unit = {PICTURE}, view = "val3" }} ]')
    cell.write_text(text.replace('entries = [\n  { at = "DW 0", type = "KH", to = "MW 0" },', "entries = ["))
    with running_cell(str(cell), "val3", plc=False, p5_ms=None) as run:

        def read(table: str, at: int, count: int = 1) -> list[int]:
            found = values_of(mbpoll(run.port, "-0", "-t", table, "-r", str(at), "-c", str(count), unit=PICTURE)[1])
            return [found[at + n] for n in range(count)]

        def value(name: str) -> object:
            return services_ask(run.name, op="get", address=name).get("value")

        code, said = mbpoll(run.port, "-0", "-t", BITS, "-r", "0", "-c", "1", unit=PICTURE)
        assert code != 0 and "Slave device or server failure" in said, "no input has been given yet: the board is in fault"
        assert mbpoll(run.port, "-0", "-t", WORDS, "-r", "0", values=(0x4048, 0xF5C3), unit=PICTURE)[0] == 0
        assert mbpoll(run.port, "-0", "-t", BITS, "-r", "0", values=(1,), unit=PICTURE)[0] == 0
        until(lambda: value("dio.start") == 1, "the program sees the input")
        assert read(INPUT_WORDS, 1000, 4) == [0, 0, 0, 0], "all of them work"
        services_ask(run.name, op="set", address="dio.lamp", value="1")
        services_ask(run.name, op="set", address="aio.speed", value="-7.5")
        until(lambda: read(INPUT_BITS, 0) == [1], "the output at the PLC")
        assert read(INPUT_WORDS, 0, 2) == list(struct.unpack(">2H", struct.pack(">f", -7.5)))
        until(lambda: value("aio.level") == 3.14, "the analog input")
        services_ask(run.name, op="set", address="dio.lamp.lock", value="1")
        services_ask(run.name, op="set", address="dio.lamp", value="0")
        assert read(INPUT_WORDS, 1000, 4) == [0, 1, 0, 0] and read(INPUT_BITS, 0) == [1], "locked: it keeps what it had"
        code, said = mbpoll(run.port, "-0", "-t", WORDS, "-r", "0", values=(0x4130, 0), unit=PICTURE)
        assert code != 0 and "Illegal data value" in said, "11.0 is beyond the input's range"
