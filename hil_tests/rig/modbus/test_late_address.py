"""A Modbus server whose port is taken or not there at power-up listens as soon as it is (AX-624)."""

import socket
import time

import pytest

from hil_tests.lab.running import cell_running
from hil_tests.lab.running.cell_running import P5_MS, running_cell


def test_a_port_that_comes_late_is_taken_when_it_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        monkeypatch.setattr(cell_running, "free_port", lambda: port)
        with running_cell(name="late", plc=False, p5_ms=max(P5_MS, 20)) as run:
            until = time.monotonic() + 20
            while not (told := [entry for entry in run.journal("alarm") if entry.get("source")]):
                assert time.monotonic() < until, run.words()
                time.sleep(0.1)
            assert str(port) in told[0]["text"] and told[0]["text"].endswith("it is tried again every second")
            time.sleep(2.5)  # far beyond what was tried at a start before
            other.close()
            run.plc.start()
            run.plc.wait(lambda status: True, 10)
            assert [entry["text"] for entry in run.journal("link") if "listens now" in entry["text"]] == ["Modbus server plc2 listens now"]
            assert len([entry for entry in run.journal("alarm") if entry.get("source")]) == 1
