"""PLC 1 of the demo at a running cell for some seconds; its recorded line becomes a draft that `axisgate check` takes."""

import os
import pathlib
import signal
import subprocess
import sys
import time
import tomllib

import pytest

from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.rig.line_tools.conftest import ROOT, axisgate
from hil_tests.rig.line_tools.test_tutorial import free_port

TARGETS = (400, 1200, -350, 800, 655)


@pytest.mark.slow
def test_the_demo_s_line_is_learned(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path / "run"))
    words = ("run", "demo", "--sim", "--record", str(tmp_path / "trace"), "--modbus-port", str(free_port()), "--die-with-parent")
    cell = subprocess.Popen(
        [sys.executable, "-m", "gateway", *words], cwd=ROOT, env=dict(os.environ), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    plc = S5Plc(str(tmp_path / "run" / "demo-plc1-a"), ("A1",))
    try:
        limit = time.monotonic() + 30
        while not (tmp_path / "run" / "demo-services.sock").exists() and time.monotonic() < limit:
            time.sleep(0.1)
        plc.start()
        for number, target in enumerate(TARGETS):
            plc.word(2, target)
            plc.bit(0, 5, number % 2 == 0)
            plc.wait_cycles(3)
    finally:
        plc.stop()
        cell.send_signal(signal.SIGTERM)
        cell.wait(15)
    trace, draft = tmp_path / "trace" / "line-plc1.rec", tmp_path / "draft.toml"
    learned = axisgate("learn", "line", str(trace), "-o", str(draft))
    assert learned.returncode == 0, learned.stderr
    text = draft.read_text()
    parsed = tomllib.loads(text)
    assert [(db["number"], db["words"], db["writer"]) for db in parsed["db"]] == [(10, 32, "plc"), (11, 32, "axisgate")]
    assert parsed["line"][0]["supervision"]["life_word"] == "DB10.DW31"
    assert {"at": "DW 31", "type": "KF", "to": "line.plc.life"} in parsed["db"][0]["entries"]
    assert 'at = "DW 2", type = "KF", to = "..."' in text and "-350..1200" in text
    assert 'at = "D 0.n", type = "bit", to = "..."' in text and "bits 5 change" in text
    assert "# constant all the time: DW 1, 3..30" in text
    checked = axisgate("check", str(draft))
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert "0 errors" in checked.stdout
