"""An endless belt as real processes: a PLC orders a program whose axis rides on it while its encoder overflows (AX-573).

The bus log is the witness of set values and counts.  Everything else about it is proved in virtual time:
hil_tests/unit/gateway/pure/cycle/belts.
"""

import itertools
import pathlib
import struct

import numpy as np
import pytest

from gateway.assembly.axis_scaling import scaling_of
from gateway.pure.image.records.cell import CellState
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.partners.plc2 import ABORTED, DONE
from hil_tests.lab.running.belt_run import FIRST_ID, INCREMENT, BeltRun, belt_run, with_signals
from hil_tests.lab.running.cell_running import P5_MS
from hil_tests.lab.running.program_run import PROGRAM
from hil_tests.lab.virtual.endless_belt import FACTOR, HEAD, endless
from protocols.servodyn.plan import SYNC_ID, set_id

SPEED = 0.9  # m/s; eight metres are ridden: the encoder's 16 bits, 6.55 m, overflow meanwhile
CYCLE = SPEED * P5_MS * FACTOR  # deg the belt makes from one SYNC to the next
RIDES = ["sync B1 >= 1000mm"] * 4 + ["ptp rel joints 10 0 0 0 0"] + ["sync B1 >= 1000mm"] * 4
PROGRAMS = {1: HEAD + "\n".join(["sync B1 >= 0mm", "synchron B1", *RIDES, "synchron_end", "ptp joints 0 30 0 0 0"])}


def burst_rows(run: BeltRun) -> Array:
    """(SYNCs, 2): set value of M as the burst of a SYNC carries it, deg, and what the belt's encoder says after the next one, mm."""
    scaling, rows = scaling_of(run.programs.cell.axis[0]), []
    for frame in run.programs.run.bus():
        if not isinstance(frame, Logged):
            continue
        if frame.identifier == SYNC_ID:
            rows.append([np.nan] * 2)
        elif rows and frame.identifier == FIRST_ID + 1 and len(rows) > 1:
            rows[-2][1] = 0.1 * int.from_bytes(frame.data[:2], "little")
        elif rows and frame.identifier == set_id(1):
            rows[-1][0] = np.degrees(scaling.to_si(struct.unpack_from("<i", frame.data, 2)[0]))
    found = np.array(rows)
    whole: Array = found[~np.isnan(found).any(axis=1)]
    return whole


def test_an_axis_rides_for_rounds_on_an_endless_belt_whose_encoder_overflows(tmp_path: pathlib.Path) -> None:
    with belt_run(tmp_path, PROGRAMS, "endless", lambda text: with_signals(endless(text))) as belt:
        run = belt.programs
        belt.drive(1, SPEED)
        run.watch("the belt runs", lambda s: s.belt_speed > 0.99 * SPEED)
        belt.zero(1)
        run.plc.send(PROGRAM, 1)
        counters: list[float] = []

        def over(state: CellState) -> bool:
            if state.parts >= 3:  # no path before it, SYNC beside the belt, SYNCHRON
                counters.append(state.belt)
            return state.parts >= 11

        run.watch("eight times a metre", over, 60.0)
        falls = [b - a for a, b in itertools.pairwise(counters) if b < a]
        assert falls == pytest.approx([SPEED * P5_MS / 1e3 - 1.0] * 8, abs=INCREMENT), "lessened by a metre, and not set"
        assert run.plc.wait(lambda s: s.state in (DONE, ABORTED), 20).state == DONE, run.run.words()
        state, rows = run.state(), burst_rows(belt)
    assert np.degrees([axis.set for axis in state.axes[:2]]).round(6).tolist() == [0.0, 30.0]
    assert np.abs(np.diff(rows[:, 1])).max() > 6000.0, "the encoder has overflown"
    way = np.unwrap(rows[:, 1], period=6553.6)
    off = rows[:, 0] - FACTOR * way
    riding = np.abs(np.diff(rows[:, 0]) / np.maximum(np.diff(way), 1e-6) - FACTOR) < 0.05 * FACTOR
    beside = off[1:][riding & (np.diff(way) > 1.0)]
    first, second = np.median(beside[: len(beside) // 4]), np.median(beside[-len(beside) // 4 :])
    assert abs(second - first - 10.0) < 0.02 * CYCLE, "10 deg along the belt, over eight rounds"
    away = np.minimum(np.abs(beside - first), np.abs(beside - second))
    assert np.percentile(away, 90) < 0.02 * CYCLE, "it keeps its place on the belt from SYNC to SYNC"
