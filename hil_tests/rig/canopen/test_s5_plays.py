"""The shipped S5 cell under --sim: its PLC program switches three CiA 402 drives on, references them (two by themselves) and moves them."""

import signal
import subprocess
import sys
import time

from drivers.ports.base import runtime_dir
from gateway.runtime.supervisor_client import wait_up
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.running.cell_running import P5_MS, runtime_folder

DRIVES_ON, FEED, RESET, REFERENCE, START = 0, 1, 2, 3, 8  # bits of DB 10, DW 0
READY, REFERENCED, DONE, ERROR = 0, 1, 9, 15  # bits of DB 11, DW 0
START_UP_S = 25.0


def test_the_program_of_the_s5_example_moves_its_axes_without_metal() -> None:
    with runtime_folder():
        command = [sys.executable, "-m", "gateway", "run", "s5-rk512", "--sim", "--name", "s5", "--p5", str(P5_MS), "--die-with-parent"]
        run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        plc = S5Plc(str(runtime_dir() / "s5-plc-a"), ["X", "Y", "Z"])
        try:
            assert wait_up("s5", 20.0)
            time.sleep(0.5)
            plc.start()
            plc.wait(lambda s: s.bit(0, READY) and not s.bit(0, ERROR), START_UP_S, "all drives started up")
            plc.bit(0, FEED, True)
            plc.word(1, 100)
            plc.word(5, 40)
            plc.pulse(0, RESET)
            plc.bit(0, DRIVES_ON, True)
            plc.wait_cycles(4)
            plc.pulse(0, REFERENCE)
            status = plc.wait(lambda s: s.bit(0, REFERENCED), 20.0, "referenced")
            assert abs(status.word(2) - 124) <= 2, "home of X reads its offset, 12.35 mm, and the next index pulse is home"
            for word, target in ((2, 3000), (3, 2000), (4, 1000)):
                plc.word(word, target)
            plc.wait_cycles(1)
            plc.bit(0, START, True)
            done = plc.wait(lambda s: s.bit(0, DONE) or s.bit(0, ERROR), 20.0, "done")
            assert done.bit(0, DONE)
            plc.wait_cycles(2)
            assert [plc.status.word(word) for word in (2, 3, 4)] == [3000, 2000, 1000]
        finally:
            plc.stop()
            run.send_signal(signal.SIGTERM)
            run.wait(15)
