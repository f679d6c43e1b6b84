"""`axisgate run CELL --record FOLDER` on a port that is not simulated: the journal says what the station heard, said and reported."""

import os
import pathlib
import tempfile
import time

import pytest

from gateway.commands.line_export import main as export
from hil_tests.lab.partners.by_hand_partner import ByHandPartner, Gave
from hil_tests.lab.partners.pty_master import PtyMaster
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.rig.telegrams.conftest import cell_run, host_cell
from protocols.base.dialogue import parse

SAFETY = """
[safety]
emergency_stop  = "safety relay -K1"
sto_wired       = true
guard           = "fence"
limit_switches  = "hard-wired"
risk_assessment = "RB-1"
last_stop_test  = 2026-11-19

[[bus]]"""


def test_the_journal_of_a_real_port_is_a_dialogue_and_can_be_exported(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    master, host = PtyMaster(), ByHandPartner(priority=True)
    text = host_cell().replace('"/dev/ttyS0"', f'"pty:{master.path}"').replace("[[bus]]", SAFETY, 1)
    text = text.replace('replaces = "rho3.1"', 'replaces = "rho3.1"\ntarget = "machine"', 1)
    cell = tmp_path / "real.toml"
    cell.write_text(text, encoding="utf-8")
    record = tmp_path / "record"
    with tempfile.TemporaryDirectory(prefix="ag") as short:
        monkeypatch.setitem(os.environ, "AXISGATE_RUNTIME", f"{short}/run")
        with cell_run(str(cell), "real", record, sim=()), SyncLine(master, host) as line:
            host.give(b"\0\0XX", time.monotonic_ns())
            assert line.run_until(lambda: any(isinstance(event, Gave) for _, event in line.events), 10.0)
            journal = record / "line-V24_1.txt"
            wanted = [("hears", "02"), ("says", "10"), ("hears", "00 00 58 58 10 03 13"), ("reports", "BlockReceived data=00005858")]
            end = time.monotonic() + 5.0
            told: list[tuple[str, str]] = []
            while len(told) < 5 and time.monotonic() < end:
                (dialogue,) = parse(journal.read_text(encoding="ascii"))
                told = [(entry.verb, entry.what) for entry in dialogue.entries]
    assert told[:2] == wanted[:2] and set(told) >= set(wanted)
    assert (dialogue.name, dialogue.station["profile"], dialogue.station["priority"]) == ("V24_1", "rho3", "low")
    assert export([str(journal), "-o", str(tmp_path / "v24.pcapng")]) == 0
