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
HOLD = 161  # KIN_2_FEED_HOLD_N_RCI (AX-1787)
WIRED = '[rc_inputs]\nwired = ["KIN_2_FEED_HOLD_N_RCI"]\n'


@contextlib.contextmanager
def two_plcs(folder: pathlib.Path) -> Iterator[tuple[ProgramRun, ModbusPlc, ModbusPlc]]:
    """The run; the PLC of the arm, the PLC of the SCARA, which may hold the feed of the SCARA."""
    port = free_port()

    def cell(text: str) -> str:
        text = both(text).replace("[[robot]]", SECOND.format(port=port), 1)
        return text.replace("[rc_inputs]\n", WIRED, 1).replace("owner = {", f'owner = {{ "{HOLD >> 3}" = "plc-scara",', 1)

    with program_run(folder, "arm6", {1: ARMS, 2: SCARAS}, "two-arms", change=cell) as run:
        second = ModbusPlc("127.0.0.1", port)
        second.start()
        try:
            second.wait(lambda status: True, 20.0)
            second.synchronise()
            yield run, run.plc, second
        finally:
            second.stop()


def hold(plc: ModbusPlc, *, value: bool) -> None:
    """Not feed hold of the SCARA, as its PLC sets it."""
    with plc._lock:
        assert not plc._client.write_coil(HOLD, value).isError()


def hold_and_go_on(run: ProgramRun, plc: ModbusPlc) -> tuple[int, int]:
    """The SCARA is held under way and let go; between which stamps of the record it rested."""
    hold(plc, value=False)
    run.watch("the SCARA is held", lambda s: s.lanes[1].withheld != 0, 10.0)
    places = run.state()
    run.watch("it rests", lambda s: all(abs(axis.speed) < 1e-6 for axis in s.axes[6:10]) and s.cycle > places.cycle + 60, 10.0)
    first = run.run.record().rows[-1].stamp_ns
    cycle = run.state().cycle
    run.watch("a while goes by", lambda s: s.cycle > cycle + 40, 10.0)
    last = run.run.record().rows[-1].stamp_ns
    hold(plc, value=True)
    return first, last


def test_two_plcs_run_different_programs_of_two_arms_at_once(tmp_path: pathlib.Path) -> None:
    with two_plcs(tmp_path) as (run, first, second):
        run.watch("drives are started up", lambda s: s.cycle > 0 and not any(a.flags & 0x110 for a in s.axes[:10]), 60.0)
        for plc, mask in ((first, ARM), (second, SCARA)):
            for code in (REQUEST, OVERRIDE, ENABLE):
                status = plc.command(code, mask)
                assert status.state == DONE, (code, status, run.run.words())
        assert (first.command(PROGRAM, 2).state, first.command(PROGRAM, 2).reason) == (REFUSED, NOT_OWNER)
        hold(second, value=True)
        since = run.run.record().rows[-1].stamp_ns
        first.send(PROGRAM, 1)
        second.send(PROGRAM, 2)
        run.watch("both move", lambda s: all(lane.piece > 0 for lane in s.lanes), 30.0)
        held_ns = hold_and_go_on(run, second)
        run.watch("the SCARA is done", lambda s: s.lanes[1].motion is Motion.IDLE, 60.0)
        assert run.state().lanes[0].motion is Motion.RUNNING, "the arm goes on"
        run.watch("all rest", lambda s: s.motion is Motion.IDLE, 60.0)
        for plc in (first, second):
            assert plc.wait(lambda status: status.state == DONE, 10.0).state == DONE
        record = run.run.record()
    made = Driven(run.cell, replace(record, rows=tuple(row for row in record.rows if row.stamp_ns >= since)), run.run.p5_ms / 1e3)
    moving = np.abs(np.diff(made.sets, axis=0)) > 1e-7
    arm, scara = np.asarray(moving[:, :6].any(axis=1)), np.asarray(moving[:, 6:].any(axis=1))
    stamps = [row.stamp_ns for row in record.rows if row.stamp_ns >= since][1:]
    held = np.array([held_ns[0] <= stamp < held_ns[1] for stamp in stamps])
    assert int(held.sum()) > 20 and not scara[held].any() and arm[held].all(), "a feed hold of the SCARA holds no axis of the arm"
    assert int((arm & scara).sum()) > 0.8 * int(scara.sum()) > 50, "most of the SCARA's way was run while the arm moved"
    assert np.rad2deg(made.sets[-1][:2]) == pytest.approx((-40.0, 30.0), abs=1e-2)
    assert np.rad2deg(made.sets[-1][6:8]) == pytest.approx((10.0, 60.0), abs=1e-2)
    assert np.abs(made.actual[-1] - made.sets[-1]).max() < 1e-3
    speed, accel = made.shares()
    assert max(speed, accel) < 1.02
