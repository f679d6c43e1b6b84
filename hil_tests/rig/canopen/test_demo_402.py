"""The demo with CiA 402 drives as real processes: start-up through the cycle's ring, a move, deaths, the path of both families."""

import struct
import time
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from gateway.pure.image.records.cell import AxisFlag
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.partners.plc2 import DONE, PTP
from hil_tests.lab.running.cell_running import ALL, HOME, P5_NS, TARGET, CellRun, Disturbed, running_cell

START_UP_S = 25.0
SLOW = 0.3
SET_IDS = {*range(210, 261, 10), *range(0x201, 0x207)}  # SERVODYN, RPDO1


def configured(run: CellRun, timeout_s: float = START_UP_S) -> float:
    """Every drive was started up; how long it took."""
    begin = time.monotonic()
    while time.monotonic() < begin + timeout_s:
        flags = [axis.flags for axis in run.state().axes[:6]]
        if not any(flag & (AxisFlag.UNCONFIGURED | AxisFlag.LOST) for flag in flags):
            return time.monotonic() - begin
        time.sleep(0.05)
    raise AssertionError(f"not started up: {[str(entry['text']) for entry in run.journal()][-8:]}")


def path_of(run: CellRun) -> list[tuple[int, ...]]:
    """Set positions of one move as they left on the bus, from the first that moves; both families have them in bytes 2..5."""
    run.command(PTP, ALL, SLOW, HOME)
    run.arrived(HOME)
    before = len(run.bus())
    run.command(PTP, ALL, SLOW, TARGET)
    run.arrived(TARGET)
    steps: list[tuple[int, ...]] = []
    burst: list[int] = []
    for entry in run.bus()[before:]:
        if not isinstance(entry, Logged):
            continue
        if entry.identifier in SET_IDS:
            burst.append(struct.unpack_from("<i", entry.data, 2)[0])
        if len(burst) == 6:
            steps.append(tuple(burst))
            burst = []
    return [tuple(a - b for a, b in zip(step, steps[0], strict=True)) for n, step in enumerate(steps) if n and step != steps[n - 1]]


def undisturbed(run: CellRun) -> list[tuple[int, ...]]:
    """A busy machine may take drives off before or in a move: then it is played again, at most three times."""
    for spare in (3, 2, 1, 0):
        try:
            run.ready()
            return path_of(run)
        except (Disturbed, AssertionError):
            if not spare:
                raise
    raise AssertionError("not reached")


@dataclass
class Both:
    """The path on SERVODYN drives, and the run with CiA 402 drives that is up."""

    old: list[tuple[int, ...]]
    run: CellRun
    took_s: float


@pytest.fixture(scope="module")
def both() -> Iterator[Both]:
    with running_cell("demo", "family") as run:
        old = undisturbed(run)
    with running_cell("demo-402", "family") as run:
        yield Both(old, run, configured(run))


def test_the_same_script_on_both_families_asks_for_the_same_path(both: Both) -> None:
    old, new = both.old, undisturbed(both.run)
    assert both.took_s < START_UP_S and sum("ready" in str(entry["text"]) for entry in both.run.journal("drive")) >= 6
    assert abs(len(old) - len(new)) <= 1 and len(old) > 20
    worst = max(abs(a - b) for x, y in zip(old, new, strict=False) for a, b in zip(x, y, strict=True))
    assert worst <= 1


def test_dead_services_take_over_living_drives_and_a_dead_cycle_starts_them_up_again(both: Both) -> None:
    run = both.run
    run.ready()
    dead, _ = run.kill("services")
    run.back("services", dead)
    time.sleep(1.0)
    assert not any(axis.flags & AxisFlag.UNCONFIGURED for axis in run.state().axes[:6]), "the drives were not disturbed"
    assert any("taken over as it was" in entry["text"] for entry in run.journal("drive"))
    run.plc.synchronise()
    dead, stamp = run.kill("cycle")
    run.hold("cycle")  # a quick machine has the next one up before the drives miss a heartbeat
    time.sleep(1.0)
    rows = [row for row in run.record().rows if row.stamp_ns > stamp]
    off = next((row.stamp_ns for row in rows if all(axis.state not in (4, 5) for axis in row.axes)), None)
    supervision = 3 * 50_000_000 + P5_NS
    assert off is not None and off - stamp < supervision + 500_000_000, "quick stop and standstill after the heartbeat stayed away"
    run.forgive("cycle")
    run.back("cycle", dead)
    configured(run)
    run.plc.synchronise()
    run.ready()
    status = run.plc.command(PTP, ALL, SLOW, TARGET)
    assert status.state == DONE
