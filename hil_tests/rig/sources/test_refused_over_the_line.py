"""AX-610 over a real line: an S5 that starts with a refused speed reads its refused bit and reason 5, and nothing moves."""

from collections.abc import Iterator

import pytest

from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import Motion
from gateway.simulation.line.control import LineControl
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.running.cell_running import P5_MS, CellRun, running_cell

START, REFUSED, SPEED, CODE = (0, 8), (0, 15), 8, 1


@pytest.fixture(scope="module")
def cell() -> Iterator[tuple[CellRun, S5Plc]]:
    with running_cell("demo", "refuse", plc=False, p5_ms=max(10, P5_MS)) as run:
        plc = S5Plc(LineControl.path("refuse-plc1", "a"), [axis.name for axis in run.demo.axis])
        plc.start()
        try:
            plc.wait_cycles(2)
            yield run, plc
        finally:
            plc.stop()


@pytest.mark.parametrize("speed", [0, 101, -1])
def test_a_refused_speed_is_bit_and_reason_5(cell: tuple[CellRun, S5Plc], speed: int) -> None:
    run, plc = cell
    plc.word(SPEED, 50)
    plc.wait_cycles(2)
    before = [axis.set for axis in run.state().axes]
    plc.word(2, 500)
    plc.word(SPEED, speed)
    plc.bit(*START, True)
    status = plc.wait(lambda s: s.bit(*REFUSED) and s.word(CODE) == Reason.FORMAT_SUSPICION, 10.0, "refused with reason 5")
    assert not status.bit(0, 8) and not status.bit(0, 9), "neither busy nor done"
    assert run.state().motion is Motion.IDLE and [axis.set for axis in run.state().axes] == pytest.approx(before, abs=1e-6)
    plc.bit(*START, False)
    plc.wait_cycles(2)
