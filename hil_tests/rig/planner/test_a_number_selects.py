"""AX-406 in a run: the S5's program selects a motion program of the portal by its number, over its 3964R line."""

import pathlib
import signal
import subprocess
import sys

from drivers.ports.base import runtime_dir
from gateway.runtime.supervisor_client import wait_up
from hil_tests.lab.cells.numbered_cell import numbered_cell
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.running.cell_running import P5_MS, runtime_folder

DRIVES_ON, FEED, REFERENCE = 0, 1, 3  # bits of DB 10, DW 0
REFERENCED, DONE = 1, 9  # bits of DB 11, DW 0
SPEED, NUMBER = 5, 6  # DW of DB 10
PROGRAM = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 10 10 5 0\nptp joints 60 30 25 5\nptp joints 80 20 15 0\n"


def test_an_old_program_selects_a_motion_program_by_its_number(tmp_path: pathlib.Path) -> None:
    (tmp_path / "cell.toml").write_text(numbered_cell("way.txt", 20))
    (tmp_path / "way.txt").write_text(PROGRAM)
    with runtime_folder():
        cell = str(tmp_path / "cell.toml")
        command = [sys.executable, "-m", "gateway", "run", cell, "--sim", "--name", "sel", "--p5", str(P5_MS), "--die-with-parent"]
        run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        plc = S5Plc(str(runtime_dir() / "sel-plc-a"), ["X", "Y", "Z"])

        try:
            assert wait_up("sel", 20.0)
            plc.start()
            plc.bit(0, FEED, True)
            plc.word(1, 100)
            plc.word(SPEED, 100)
            plc.wait_cycles(2)
            plc.bit(0, DRIVES_ON, True)
            plc.wait_cycles(4)
            plc.pulse(0, REFERENCE)
            plc.wait(lambda s: s.bit(0, REFERENCED), 30.0, "referenced")
            plc.word(NUMBER, 20)
            plc.wait(lambda s: s.bit(0, DONE), 30.0, "the program")
            plc.wait_cycles(2)
            assert [plc.status.word(word) for word in (2, 3, 4)] == [800, 200, 150], (
                "a standing number has run it once and left it at its end"
            )
        finally:
            plc.stop()
            run.send_signal(signal.SIGTERM)
            run.wait(15)
