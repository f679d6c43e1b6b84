"""Sixteen robots and 32 axes as real processes: PLC, services, planner, cycle, 32 emulated CiA 402 drives on one bus (AX-572).

One program moves all of them on one clock, slowed down, stopped and resumed; then its planner is killed under way, and the services
beside drives that are on.  Judged by the emulator's own record.  Their limits, where every SYNC is looked at:
hil_tests/unit/motion/program.
"""

import contextlib
import json
from collections.abc import Iterator

import numpy as np
import pytest

from gateway.assembly.axis_signals import INPUT_SIGNALS
from gateway.commands import monitor
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import AxisFlag, Motion
from hil_tests.lab.cells.many_robots import FOLLOWED, ROBOTS, cell_file, judge_lines, judge_one_clock, points, program
from hil_tests.lab.partners.plc2 import ABORTED, DONE
from hil_tests.lab.running.cell_running import running_cell
from hil_tests.lab.running.program_run import NOT_THERE, PROGRAM, ProgramRun
from hil_tests.lab.virtual.planned_bench import Driven

P5_MS = 20  # what such a run costs are changes of process, so many a cycle
LAST = 2 * ROBOTS - 2  # X of the last one
FAR = points(ROBOTS - 1)[0][0] * 1e-3
ENDS = np.array([points(n)[1] for n in range(ROBOTS)]).reshape(-1) * 1e-3
STANDS = 2e-6  # m: an increment
pytestmark = pytest.mark.timeout(600)


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ProgramRun]:
    path = cell_file(tmp_path_factory.mktemp("many"), cycle_ms=P5_MS)
    path.write_text(path.read_text().replace('owner = { "3" = "plc" }', f"assume = {list(INPUT_SIGNALS)}"))
    with running_cell(str(path), "many", p5_ms=P5_MS) as run, contextlib.closing(ProgramRun(run, {1: program()})) as made:
        assert made.axes == 32
        yield made


def under_way(robots: ProgramRun) -> bool:
    """The last of them is in the middle of its first line, and so are all."""
    places = robots.sets()
    return 0.3 * FAR < places[LAST] < 0.9 * FAR and all(0.02 < place < 0.25 for place in places[::2])


def test_sixteen_robots_keep_their_lines_on_one_clock_through_a_slow_stretch_and_a_stop(robots: ProgramRun) -> None:
    made = robots.slowed_stopped_resumed(lambda: under_way(robots), lambda: under_way(robots))
    judge_lines(made)
    judge_one_clock(made)


def test_what_was_handed_on_is_run_to_its_end_by_all_when_their_planner_is_killed(
    robots: ProgramRun, capsys: pytest.CaptureFixture[str]
) -> None:
    robots.ready()
    robots.plc.send(PROGRAM, 1)
    robots.watch("it moves", lambda s: s.motion is Motion.RUNNING and s.piece > 0)
    dead, _ = robots.run.kill("planner")
    robots.watch("at rest", lambda s: s.motion is Motion.IDLE)
    robots.run.back("planner", dead)
    assert robots.plc.wait(lambda s: s.state == ABORTED, 5).reason == Reason.PLANNER_LOST
    assert robots.still()
    driven = Driven(robots.cell, robots.run.record(), P5_MS / 1e3)
    assert driven.sets[-1] == pytest.approx(ENDS, abs=STANDS) and driven.actual[-1] == pytest.approx(ENDS, abs=FOLLOWED)
    assert monitor.main(["many", "--tab", "axes", "--json"]) == 0
    last = json.loads(capsys.readouterr().out)["axes"][-1]
    assert (last["axis"], last["set"], last["state"]) == ("Y16", "120.000", "enabled, referenced, in position")
    assert robots.command(PROGRAM, 1).state == DONE, robots.run.words()


def test_services_that_are_killed_find_all_drives_as_they_were(robots: ProgramRun) -> None:
    robots.ready()
    before, told = robots.sets(), len(robots.run.journal())
    dead, _ = robots.run.kill("services")
    robots.run.back("services", dead)
    taken = "(taken over as it was)"
    robots.watch("all are looked at", lambda s: sum(taken in entry["text"] for entry in robots.run.journal("drive")[-40:]) == 32)
    flags = [axis.flags for axis in robots.state().axes]
    assert all(each & AxisFlag.ENABLED and not each & NOT_THERE for each in flags), "none was started up again"
    assert robots.sets() == before
    assert not [entry for entry in robots.run.journal()[told:] if entry["kind"] == "alarm" and "node" in entry]
