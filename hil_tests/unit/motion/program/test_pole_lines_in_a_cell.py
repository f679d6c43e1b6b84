"""Lines beside the wrist pole: `check`, `plot` and a cell agree on each, and what runs keeps its limits and its line."""

import math
import random
from collections.abc import Iterator

import numpy as np
import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config
from gateway.pure.image.reasons import CommandState
from hil_tests.lab.cells.arms import shares
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned, off_segment
from motion.errors import MotionError
from motion.planner.duration_check import too_long
from motion.planner.robot import Machine
from motion.planner.trace import route_of, trace
from motion.program.text.reader import read

CELL = load_cell(str(find_config("arm6", "cells")))
RUN, REFUSED = 2, 1  # lines of each kind that are tried in the cell: the first that is run is 1e-6 m beside the pole


def programs(machine: Machine) -> Iterator[str]:
    """A PTP to the beginning of a line of about 150 mm, and the line, 1e-6 .. 30 mm beside the pole."""
    chance = random.Random(11)
    while True:
        q = [math.radians(chance.uniform(*span)) for span in ((-60, 60), (0, 40), (50, 100), (-100, 100))] + [0.0, 0.3]
        along, other = (np.array([chance.gauss(0, 1) for _ in range(3)]) for _ in range(2))
        along /= np.linalg.norm(along)
        aside = np.cross(along, other)
        aside *= 10 ** chance.uniform(-9, -1.5) / np.linalg.norm(aside)
        at = machine.forward(q)
        px, py, pz = (np.array(at.position) + aside - 0.08 * along).tolist()
        begin = at._replace(position=(px, py, pz))
        try:
            start = machine.inverse(begin, q)
        except MotionError:
            continue
        joints = " ".join(f"{math.degrees(v):.6f}" for v in start)
        x, y, z = (150.0 * along).tolist()
        head = f"angles val3\naxes deg deg deg deg deg deg\nstart {joints}\nptp joints {joints}\n"
        yield f"{head}linear rel pose {x:.4f} {y:.4f} {z:.4f} 0 0 0 path=200\n"


@pytest.mark.timeout(240)
def test_check_plot_and_cell_agree_on_lines_beside_the_pole() -> None:
    planned, machine = Planned(Cell402Bench(6, cell=CELL)), machine_of_cell(CELL)
    ran = refused = 0
    for text in programs(machine):
        if ran >= RUN and refused >= REFUSED:
            break
        found = route_of(read(text), machine)
        faults = [*found.faults, *too_long(found.stretches, machine)]
        if (refused >= REFUSED) if faults else (ran >= RUN):
            continue
        job, rows = planned.order(text), []
        while job.open:
            planned.bench.cycle()
            rows.append([axis.set for axis in planned.state.axes[:6]])
            assert len(rows) < 20_000
        if faults:
            refused += 1
            assert job.state is CommandState.REFUSED and str(faults[0]).partition(": ")[2] in job.detail, (job.detail, faults)
            assert np.ptp(np.array(rows), axis=0).max() < 1e-9, "nothing moves"
            continue
        ran += 1
        assert job.state is CommandState.DONE, (job.state, job.reason, job.detail, text)
        plotted = trace(found.stretches, machine).q
        assert max(shares(machine, plotted, 1e-3)) <= 1.06
        assert max(shares(machine, np.array(rows), planned.bench.period_ns / 1e9)[:2]) <= 1.02
        assert np.abs(np.array(rows[-1]) - plotted[-1]).max() < 1e-6
        end = np.array(machine.forward(list(plotted[-1])).position)
        start = np.array(machine.forward(list(found.stretches[-1].path.q(0.0))).position)
        line = [row for row in rows if np.abs(np.array(row) - plotted[-1]).max() > 1e-9][-150:]
        places = np.array([machine.forward(row).position for row in line])
        assert off_segment(places, start.tolist(), end.tolist()).max() < 1e-4
    assert (ran, refused) == (RUN, REFUSED)
