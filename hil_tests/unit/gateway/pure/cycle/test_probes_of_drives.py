"""AX-569: touch probes inside CiA 402 drives (60B8h .. 60BBh) measure for programs: start-up, telegrams, core, planner in virtual time."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.drives.cia402 import Cia402Drive
from drivers.drives.cia402_boot import BootRefused, boot
from drivers.drives.cia402_family import Cia402Family
from gateway.assembly.canopen_nodes import node_plans
from gateway.assembly.programs import measuring_facts
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.axes import Span
from gateway.pure.cell.belts import Measuring
from gateway.pure.cell.cell import Home, Plant
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState
from hil_tests.lab.virtual.cell_402_bench import DEMO_402, Cell402Bench, Dialogue
from hil_tests.lab.virtual.program_bench import WithPlanner, joints
from protocols.base.machine import Frame

NODE = 3
FREE_INPUT = 300
AT, BEYOND = 20.0, 40.0  # of axis 1: its probe is actuated between
EDGE = AT + 10.0 / 16384  # half an increment further: there no rounding decides which of two increments the drive shows
FIRST, SECOND = DEMO_402.axis[0].name, DEMO_402.axis[1].name
PLANT = DEMO_402.plant or Plant()
CELL = replace(
    DEMO_402,
    axis=tuple(replace(axis, home=Home(by="none")) for axis in DEMO_402.axis),
    plant=replace(
        PLANT,
        axis={name: replace(axis, start=2.0, probe=Span(EDGE, BEYOND) if name == FIRST else None) for name, axis in PLANT.axis.items()},
    ),
    measuring=(Measuring(610, drives=(FIRST,)),),
)


class Probes(WithPlanner):
    """seen: (axis 1, axis 2) at every SYNC, in their units."""

    def __init__(self) -> None:
        super().__init__(Cell402Bench(cell=CELL))
        self.programs.cell.channels = measuring_facts(CELL)
        self.seen: list[tuple[float, float]] = []

    def turn(self) -> None:
        super().turn()
        if hasattr(self, "seen"):
            one, two = (axis.actual / fact.si for axis, fact in zip(self.cell.core.state.axes[:2], self.cell.dispatcher.axes, strict=False))
            self.seen.append((one, two))

    def measured(self) -> list[float]:
        state = self.cell.core.state
        assert state.measured_mask == 0x3F
        return [axis.measured / fact.si for axis, fact in zip(state.axes, self.cell.dispatcher.axes, strict=False)]

    def second_at(self, place: float) -> float:
        """Axis 2 where axis 1 was there, on its way up."""
        rows = np.array(self.seen)
        up = rows[: int(np.argmax(rows[:, 0])) + 1]
        return float(np.interp(place, up[:, 0], up[:, 1]))


@pytest.fixture(scope="module")
def bench() -> Probes:
    return Probes()


@pytest.fixture
def both(bench: Probes) -> Probes:
    assert bench.finished(bench.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    bench.seen.clear()
    return bench


def done(both: Probes, job: Job) -> bool:
    return both.finished(job).state is CommandState.DONE


def test_a_drive_stops_the_axes_and_mpos_is_the_place_it_has_latched(both: Probes) -> None:
    assert done(both, both.order(f"ptp joints {joints(90)} until=ch610", "ptp mpos"))
    furthest = max(one for one, _ in both.seen)
    first, second, *_ = both.measured()
    assert first == pytest.approx(AT, abs=2e-4) and AT + 0.5 < furthest < 80.0, "they stopped behind it, within their limits"
    assert second == pytest.approx(both.second_at(AT), abs=0.02)
    assert both.places()[0] == pytest.approx(first, abs=1e-6), "MOVE TO @MPOS"


def test_the_same_place_is_measured_again_and_again(both: Probes) -> None:
    for _ in range(2):
        job = both.order(f"ptp joints {joints(90)} until=ch610", f"ptp joints {joints(2)}")
        assert done(both, job) and both.measured()[0] == pytest.approx(AT, abs=2e-4)
        assert max(one for one, _ in both.seen) < 80.0
        both.seen.clear()


def test_a_falling_edge_is_another_place(both: Probes) -> None:
    assert done(both, both.order(f"ptp joints {joints(30)}"))
    assert done(both, both.order(f"ptp joints {joints(3)} until=!ch610", velocity=0.5))
    assert both.measured()[0] == pytest.approx(AT, abs=2e-4) and 4.0 < both.places()[0] < AT


def test_an_edge_before_the_block_is_not_the_blocks(both: Probes) -> None:
    assert done(both, both.order(f"ptp joints {joints(30)}", f"ptp joints {joints(38)} until=ch610"))
    assert both.cell.core.state.measured_mask == 0 and both.at(38.0)


@pytest.mark.parametrize("behind", [0.005, 0.05])
@pytest.mark.parametrize("after", [(), ("label NONE", f"ptp joints {joints(21)}")], ids=["last", "with a block behind"])
def test_an_edge_the_drive_passes_when_its_path_has_ended_is_the_blocks(both: Probes, behind: float, after: tuple[str, ...]) -> None:
    """AX-566: it lags behind its set values, and its telegram comes some cycles later."""
    goes_on = " error=NONE" if after else ""
    way = f"ptp joints {joints(AT + behind)} until=ch610{goes_on}"
    assert done(both, both.order(way, *(("ptp mpos",) if after else ()), *after))
    assert both.measured()[0] == pytest.approx(AT, abs=2e-4)


def test_without_an_edge_the_drives_stand_before_the_program_goes_on(both: Probes) -> None:
    assert done(both, both.order(f"ptp joints {joints(19)} until=ch610 error=NONE", "ptp mpos", "label NONE", f"ptp joints {joints(18)}"))
    assert both.cell.core.state.measured_mask == 0 and both.at(18.0)


def test_a_program_that_fails_while_its_block_is_held_is_over_without_an_edge(both: Probes) -> None:
    both.cell.permit(FREE_INPUT, value=False)
    order = both.order(f"ptp joints {joints(5)}", f"ptp joints {joints(30)} wait={FREE_INPUT} until=ch610", f"ptp joints {joints(3)}")
    both.cell.run(1.0)
    both.cell.core.planner_lost()
    assert both.finished(order).state is CommandState.ABORTED
    both.cell.run(0.2)
    assert both.at(5.0) and not both.cell.core.lanes[0].mover.busy
    assert done(both, both.order(f"ptp joints {joints(4)}"))


def test_a_flying_measurement_takes_the_drives_place_too(both: Probes) -> None:
    assert done(both, both.order("measure_on ch610", f"ptp joints {joints(38)}", "measure_off ch610", f"ptp joints {joints(37)}"))
    assert both.measured()[0] == pytest.approx(AT, abs=2e-4) and both.at(37.0)
    assert both.measured()[1] == pytest.approx(both.second_at(AT), abs=0.02)


def test_a_drive_that_reports_its_status_at_its_start_alone_is_armed() -> None:
    """One without an event timer says it once, before the cycle hears that it is started up."""
    family = Cia402Family([(0, NODE)], heartbeat_cycles=12, quiet_cycles=12, probes={NODE: 1})
    family.hear(Frame(0x700 + NODE, b"\0"))
    family.hear(Frame(0x380 + NODE, bytes(7)))
    family.release(NODE, 8)
    assert Frame(0x400 + NODE, b"\x31\0") in family.burst([Cia402Drive().idle()])


def test_a_node_that_will_not_arm_its_probe_is_not_started() -> None:
    cell = Cell402Bench(cell=CELL)
    _, plan = node_plans(CELL, CELL.bus[0], 4, simulated=True)[0]
    dialogue = Dialogue(cell.slave, plan.node, cell.now)
    dialogue.refuse[0x60B8, 0] = 0x06020000
    with pytest.raises(BootRefused, match="60B8h:00 touch probe function"):
        dialogue.carry(boot(plan))


WORDS = {
    'drives = ["A1"]\ninput = 464': "name one",
    "": "name one",
    'drives = ["A9"]': "A9",
    'drives = ["A1"]\naxes = ["A2"]': "not among the axes of the board",
}


@pytest.mark.parametrize("keys", WORDS)
def test_check_says_what_cannot_be(keys: str) -> None:
    text = find_config("demo-402", "cells").read_text()
    with pytest.raises(CellFaults) as caught:
        load_cell("demo-402.toml", text + f"\n[[measuring]]\nchannel = 610\n{keys}\n")
    assert WORDS[keys] in str(caught.value)


def test_check_refuses_drives_without_a_probe_and_high_speed_inputs() -> None:
    old, new = (find_config(name, "cells").read_text() for name in ("demo", "demo-402"))
    with pytest.raises(CellFaults, match="has no touch probe"):
        load_cell("demo.toml", old + '\n[[measuring]]\nchannel = 610\ndrives = ["A1"]\n')
    with pytest.raises(CellFaults, match="needs its level"):
        load_cell("demo-402.toml", new + '\n[[measuring]]\nchannel = 611\ndrives = ["A1"]\n')
    good = load_cell("demo-402.toml", new + '\n[[measuring]]\nchannel = 610\ndrives = ["A1"]\n')
    assert any("touch probe 1 of A1 measures" in notice.text for notice in good.notes)
