"""A whole simulated run that a correction moves: PLC 2 orders a program of a portal and writes the correction into registers.

The bus log is the witness of set values.  Everything else about alter is proved in virtual time: hil_tests/unit/gateway/pure/cycle/alter.
"""

import struct
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from gateway.assembly.axis_scaling import scaling_of
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import CellState, Motion
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.partners.plc2 import ABORTED, DONE
from hil_tests.lab.running.program_run import PROGRAM, ProgramRun, program_run
from hil_tests.lab.virtual.alter_bench import ALTER, HEAD, INPUT, LIFE, STATUS, with_alter
from protocols.servodyn.plan import SYNC_ID, set_id

PATIENT = ALTER.replace("every_ms = 16", "every_ms = 40\nsilence_ms = 1000")  # a PLC that writes every 10 to 30 ms
PROGRAMS = {
    1: HEAD + "ptp joints 100 100 50 0\n",
    2: HEAD + "alter frame - path=500\nlinear pose 500 100 50 0 0 0 path=100\nalter_end\nlinear pose 500 120 50 0 0 0 path=100\n",
    3: HEAD + "alter frame - path=500\n" + "linear pose 500 100 50 0 0 0 path=100\nlinear pose 100 100 50 0 0 0 path=100\n" * 20,
}


@pytest.fixture(scope="module")
def portal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ProgramRun]:
    with program_run(tmp_path_factory.mktemp("cell"), "portal", PROGRAMS, "alter", lambda text: with_alter(text, PATIENT)) as run:
        run.ready()
        yield run


def steered(run: ProgramRun, z_mm: Callable[[CellState], float], holds: Callable[[CellState], bool]) -> list[tuple[int, int]]:
    """PLC 2 writes corrections until it holds; what it read of answer and mode."""
    told, until, life = [], time.monotonic() + 60, 0
    while not holds(state := run.state()):
        assert time.monotonic() < until, f"{state}\n{run.run.words()}"
        life = (life + 1) & 0xFF
        words = struct.unpack(">6H", struct.pack(">6h", 0, 0, round(100.0 * z_mm(state)), 0, 0, 0))
        with run.plc._lock:
            client = run.plc._client
            assert not client.write_registers(INPUT >> 4, [*words, life]).isError()
            answer = client.read_input_registers(STATUS >> 4, count=1).registers[0]
        told.append(struct.unpack(">bB", struct.pack(">H", answer)))
        time.sleep(0.01)
    return told


def rising(top: float, step: float) -> Callable[[CellState], float]:
    """From X = 150 mm on a step more with every write."""
    now = [0.0]

    def value(state: CellState) -> float:
        now[0] = min(now[0] + step, top) if state.axes[0].set > 0.15 else now[0]
        return now[0]

    return value


def begun(run: ProgramRun, number: int) -> None:
    """From the place programs begin at, with a correction that is alive."""
    run.ready()
    assert run.command(PROGRAM, 1).state == DONE, run.run.words()
    count = [0]

    def some(_: CellState) -> bool:
        count[0] += 1
        return count[0] > 3

    steered(run, lambda _: 0.0, some)
    run.plc.send(PROGRAM, number)


def test_registers_correct_a_path_on_the_bus_and_the_next_block_begins_beside_it(portal: ProgramRun) -> None:
    assert LIFE >> 3 == 2 * ((INPUT >> 4) + 6) + 1, "the byte of life is the low byte of the register behind the correction"
    begun(portal, 2)
    told = steered(portal, rising(6.0, 0.2), lambda s: s.axes[1].set > 0.1199)
    assert portal.plc.wait(lambda s: s.state in (DONE, ABORTED), 20).state == DONE, portal.run.words()
    assert (1, 2) in told and (-1, 0) in told, "alter answered 1 while it was active, -1 behind its path"
    scalings = [scaling_of(axis) for axis in portal.cell.axis[:3]]
    rows: list[list[float]] = []
    for frame in portal.run.bus():
        if not isinstance(frame, Logged):
            continue
        if frame.identifier == SYNC_ID:
            rows.append([np.nan] * 3)
        for n, scaling in enumerate(scalings):
            if rows and frame.identifier == set_id(n + 1):
                rows[-1][n] = scaling.to_si(struct.unpack_from("<i", frame.data, 2)[0])
    sets = np.array([row for row in rows if not np.isnan(row).any()])
    on = sets[(np.abs(sets[:, 2] - 0.056) < 5e-6) & (np.abs(sets[:, 1] - 0.1) < 5e-6)]
    assert len(on) > 20 and np.ptp(on[:, 0]) > 0.05, "the path goes on, 6 mm higher"
    assert np.array(portal.sets()[:3]) == pytest.approx([0.5, 0.12, 0.05], abs=1e-6)


def test_a_plc_that_stops_correcting_leaves_the_axes_at_rest_on_the_path(portal: ProgramRun) -> None:
    begun(portal, 3)
    steered(portal, rising(4.0, 0.2), lambda s: s.axes[2].set > 0.0539)
    portal.watch("at rest", lambda s: s.motion is Motion.IDLE and s.job == 0, 60.0)
    status = portal.plc.wait(lambda s: s.state in (DONE, ABORTED), 20)
    assert (status.state, status.reason) == (ABORTED, Reason.ALTER_FAULT)
    assert portal.still() and abs(portal.sets()[1] - 0.1) < 1e-6 and 0.0538 < portal.sets()[2] <= 0.0541
    assert "the correction is silent" in [entry["text"] for entry in portal.run.journal("command")][-1]
