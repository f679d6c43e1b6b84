"""The markers of a Reis in a running cell, over RK512, Modbus and `axisgate var`: robotstar 4.1, 5.2, 5.8; AX-336."""

import json
import pathlib
import socket

import pytest

from drivers.ports.base import runtime_dir
from drivers.ports.open import open_bytes
from hil_tests.lab.partners.mbpoll import mbpoll, values_of
from hil_tests.lab.partners.rk512_active import Done
from hil_tests.lab.partners.signal_plc import Rack, SignalPlc, signal_cell
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.running.cell_running import running_cell

PERMITS = (24, 25, 26, 27, 28)
REQUEST, RELEASE = 11, 12


@pytest.mark.mbpoll
def test_markers_are_one_area_for_every_source(tmp_path: pathlib.Path) -> None:
    with (
        running_cell(signal_cell(tmp_path, "rack", 'kind = "reis"\ndoor = "rack"'), "reis", plc=False, p5_ms=None) as run,
        SyncLine(lambda: open_bytes(Rack.port_of(run.name), "38400 8E1"), station := Rack.station()) as line,
    ):
        rack = Rack(line, station)
        plc = SignalPlc(rack)
        plc.put(*PERMITS)
        plc.until(lambda plc: rack.area("M", 1020, 2)[1] & 0b101 == 0b100, "initialised and without error")
        assert rack.area("M", 1020, 2)[0] & 0b0101_0000 == 0b0101_0000, "power-on, synchronous"
        assert rack.area("M", 1022, 2) == b"\x01\x01", "HAND/AXIS"

        def ask(**request: str) -> dict[str, object]:
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
                link.connect(str(runtime_dir() / f"{run.name}-services.sock"))
                link.sendall(json.dumps(request).encode() + b"\n")
                found: dict[str, object] = json.loads(link.makefile().readline())
                return found

        assert ask(op="get", address="M1020.4")["value"] == 1
        assert isinstance(rack.send(0, b"\x12\x34", block=30), Done)
        assert rack.area("M", 0, 2) == b"\x34\x12", "words have their lowest byte first (robotstar D-16)"
        assert ask(op="get", address="MW 0")["value"] == 0x1234
        assert values_of(mbpoll(run.port, "-0", "-t", "4", "-r", "3000", "-c", "1")[1]) == {3000: 0x3412}
        assert mbpoll(run.port, "-0", "-t", "4", "-r", str(3000 + 50), values=(0x0708,))[0] == 0
        assert rack.area("M", 100, 2) == b"\x07\x08"
        code, text = mbpoll(run.port, "-0", "-t", "4", "-r", str(3000 + 472), values=(1,))
        assert code != 0 and "Illegal data address" in text, "M944 is the robot's"
        assert ask(op="set", address="M2013.3", value="1")["value"] == 1
        plc.until(lambda plc: rack.read(88 + 4, 2) == b"\x00\x08", "output 5.3 in the image")
        assert ask(op="get", address="reis.ibin_out.2")["value"] == 0x800
        assert ask(op="set", address="MD 1436", value="40")["value"] == 40
        assert not any("override" in entry["text"] for entry in run.journal("command")), "a factor is not a command"
