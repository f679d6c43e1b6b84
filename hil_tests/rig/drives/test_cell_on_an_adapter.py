"""A cell whose drive bus is an adapter of python-can: an slcan adapter of its own process on a pty moves the drives behind it (AX-435)."""

import time
from collections.abc import Callable, Iterator

import pytest

from gateway.pure.image.records.cell import AxisFlag
from hil_tests.lab.judges.bus_log import Logged, Remark, read
from hil_tests.lab.partners.plc2 import PTP
from hil_tests.lab.running.cell_running import ALL, HOME, TARGET, patience_s
from hil_tests.lab.running.real_running import Adapter, RealRun, running_real

LIMIT_S, BACK_S = 20.0, 2.0
pytestmark = pytest.mark.timeout(patience_s(12.0) + 2 * LIMIT_S)
TRAVEL_INC = round((TARGET[0] - HOME[0]) / 20.0 * 16384)  # of axis A1: 20 mm a turn
SYNC, ACTUALS = 100, (610, 620, 630, 640, 650, 660)


def wait(condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + LIMIT_S
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


@pytest.fixture(scope="module")
def metal() -> Iterator[tuple[RealRun, Adapter]]:
    with running_real(adapter=True) as (run, adapter):
        assert adapter is not None
        yield run, adapter


def said(run: RealRun, words: str) -> int:
    return sum(words in str(entry["text"]) for entry in run.journal("output"))


def far_frames(run: RealRun) -> list[Logged]:
    assert run.far.log is not None
    data = run.far.log.read_bytes()
    lines = data[: data.rfind(b"\n") + 1].decode().splitlines(keepends=True)
    return [entry for entry in read(lines) if not isinstance(entry, Remark)]


def said_last(run: RealRun) -> int:
    """Position the drive of axis A1 told last, in increments."""
    now = time.monotonic_ns()
    assert wait(lambda: far_frames(run)[-1].stamp_ns > now), "the log is handed over in batches"
    return int.from_bytes(
        next(frame.data[2:6] for frame in reversed(far_frames(run)) if frame.identifier == ACTUALS[0]), "little", signed=True
    )


def lost(run: RealRun) -> int:
    return sum(bool(axis.flags & AxisFlag.LOST) for axis in run.state().axes[:6])


def test_a_whole_cell_moves_its_drives_and_the_latency_is_reported(metal: tuple[RealRun, Adapter]) -> None:
    run, _ = metal
    assert wait(lambda: said(run, "first answer to a burst, ms: count 100") == 1), run.words()
    run.ready()

    def moved(_: int) -> None:
        before = said_last(run)
        run.command(PTP, ALL, 1.0, TARGET)
        run.arrived(TARGET)
        went = said_last(run) - before
        assert abs(went - TRAVEL_INC) <= 16, f"the drive of A1 went {went} increments by its own words on the far bus"

    run.repeat(1, moved, run.ready)
    heard = {frame.identifier for frame in far_frames(run)}
    assert heard == {SYNC, *ACTUALS, *range(210, 261, 10)}, "nothing else on the far bus: nothing is sent to measure"


def test_a_pulled_adapter_is_reported_and_taken_up_again(metal: tuple[RealRun, Adapter]) -> None:
    run, adapter = metal
    assert wait(lambda: lost(run) == 0)
    opened = said(run, ": open")
    adapter.pull()
    told = wait(lambda: lost(run) == 6) and wait(lambda: said(run, "it is opened again when it is back") > 0)
    adapter.plug()
    plugged = time.monotonic_ns()
    back = wait(lambda: said(run, ": open") > opened) and wait(lambda: lost(run) == 0)
    assert told and back, (told, back, run.words())
    assert wait(lambda: any(entry.stamp_ns > plugged and entry.identifier in ACTUALS for entry in far_frames(run)))
    first = next(entry.stamp_ns for entry in far_frames(run) if entry.stamp_ns > plugged and entry.identifier in ACTUALS)
    assert (first - plugged) / 1e9 < BACK_S, "by the stamps of the far bus"
    assert wait(lambda: said(run, "first answer to a burst, ms: count 100") > 1), "at each opening"
    run.ready()
