"""An arm and a SCARA of one cell that run different programs at once, each ordered by a PLC of its own: real processes, ten emulated
CiA 402 drives on one bus, judged by the emulator's own record (AX-920)."""

import contextlib
import pathlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.arm_and_scara import both
from hil_tests.lab.partners.plc2 import DONE, ENABLE, OVERRIDE, REFUSED, REQUEST, ModbusPlc
from hil_tests.lab.running.cell_running import free_port
from hil_tests.lab.running.program_run import PROGRAM, ProgramRun, program_run
from hil_tests.lab.virtual.planned_bench import Driven

ARM, SCARA = 0b111111, 0b1111 << 6
NOT_OWNER = 1
ARMS = (
    "robot tx60-like\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\n"
    + 3 * "ptp joints 80 30 90 0 60 0\nptp joints -40 30 90 0 60 0\n"
)
SCARAS = "robot sr60-like\naxes deg deg mm deg\nstart 0 90 -200 0\n" + 2 * "ptp joints 70 90 -200 0\nptp joints 10 60 -250 0\n"
SECOND = """[[modbus]]
name           = "plc-scara"
role           = "server"
bind           = "127.0.0.1:{port}"
unit           = 1
view           = "rho3"
command_block  = true
max_silence_ms = 500
on_loss        = "stop_on_path"

[[robot]]"""


@contextlib.contextmanager
def two_plcs(folder: pathlib.Path) -> Iterator[tuple[ProgramRun, ModbusPlc, ModbusPlc]]:
    """The run; the PLC of the arm, the PLC of the SCARA."""
    port = free_port()

    def cell(text: str) -> str:
        return both(text).replace("[[robot]]", SECOND.format(port=port), 1)

    with program_run(folder, "arm6", {1: ARMS, 2: SCARAS}, "two-arms", change=cell) as run:
        second = ModbusPlc("127.0.0.1", port)
        second.start()
        try:
            second.wait(lambda status: True, 20.0)
            second.synchronise()
            yield run, run.plc, second
        finally:
            second.stop()


def test_two_plcs_run_different_programs_of_two_arms_at_once(tmp_path: pathlib.Path) -> None:
    with two_plcs(tmp_path) as (run, first, second):
        run.watch("drives are started up", lambda s: s.cycle > 0 and not any(a.flags & 0x110 for a in s.axes[:10]), 60.0)
        for plc, mask in ((first, ARM), (second, SCARA)):
            for code in (REQUEST, OVERRIDE, ENABLE):
                status = plc.command(code, mask)
                assert status.state == DONE, (code, status, run.run.words())
        assert (first.command(PROGRAM, 2).state, first.command(PROGRAM, 2).reason) == (REFUSED, NOT_OWNER)
        since = run.run.record().rows[-1].stamp_ns
        first.send(PROGRAM, 1)
        second.send(PROGRAM, 2)
        run.watch("both move", lambda s: all(lane.piece > 0 for lane in s.lanes), 30.0)
        run.watch("the SCARA is done", lambda s: s.lanes[1].motion is Motion.IDLE, 60.0)
        assert run.state().lanes[0].motion is Motion.RUNNING, "the arm goes on"
        run.watch("all rest", lambda s: s.motion is Motion.IDLE, 60.0)
        for plc in (first, second):
            assert plc.wait(lambda status: status.state == DONE, 10.0).state == DONE
        record = run.run.record()
    made = Driven(run.cell, replace(record, rows=tuple(row for row in record.rows if row.stamp_ns >= since)), run.run.p5_ms / 1e3)
    moving = np.abs(np.diff(made.sets, axis=0)) > 1e-7
    arm, scara = moving[:, :6].any(axis=1), moving[:, 6:].any(axis=1)
    assert int((arm & scara).sum()) > 0.8 * int(scara.sum()) > 50, "most of the SCARA's way was run while the arm moved"
    assert np.rad2deg(made.sets[-1][:2]) == pytest.approx((-40.0, 30.0), abs=1e-2)
    assert np.rad2deg(made.sets[-1][6:8]) == pytest.approx((10.0, 60.0), abs=1e-2)
    assert np.abs(made.actual[-1] - made.sets[-1]).max() < 1e-3
    speed, accel = made.shares()
    assert max(speed, accel) < 1.02
