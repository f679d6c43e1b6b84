"""The parts of the cycle in C against their Python twins, on cells and on values no cell has: the same bit for bit (AX-320)."""

import copy
import os
import random
import shutil
import struct
import time
from collections.abc import Sequence
from dataclasses import fields
from operator import attrgetter
from pathlib import Path
from typing import cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.drives.demand_edges import DemandEdges
from drivers.drives.family import Actual, Event, Power, SetRecord
from drivers.drives.held import HeldPosition
from drivers.drives.limits import LagMonitor, LagState
from drivers.drives.scaling import Scaling
from drivers.drives.servodyn import Drive, DriveSettings, Phase
from drivers.drives.tracking import Tracking
from gateway.assembly.axes import core_axes
from gateway.cycle.native import built
from gateway.cycle.native.built import PYTHON_ONLY
from gateway.cycle.native.quick import NativeParts
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cycle.axis import CoreAxis, HeldAxis
from gateway.pure.cycle.axis_loops import PYTHON
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.cell import FLAGS, MOST_AXES, RC_BYTES, AxisState, CellState, Motion, cell_state_packer
from gateway.runtime.realtime import Alarm
from gateway.runtime.regions import ImageError, RegionReader, RegionWriter, RingReader, RingWriter, create_region, create_ring
from hil_tests.lab.cells.native import ENDS, FLAG, native_parts
from hil_tests.lab.virtual.cell_bench import DEMO, FAMILY, CellBench
from protocols.servodyn.codec import ActualValue

pytestmark = pytest.mark.cref
REALS = st.one_of(st.floats(), st.floats(-1e3, 1e3), st.sampled_from([0.0, -0.0, 0.5, 1.5, 2.5, 1e-9]))
INC = st.one_of(st.sampled_from(ENDS), st.integers(-(2**33), 2**33), st.integers(-40_000, 40_000))


@pytest.fixture(scope="module")
def quick() -> NativeParts:
    return native_parts()


# ---- the loops over the axes -------------------------------------------------------------------------------------------


def twin_of(axis: HeldAxis) -> HeldAxis:
    """The same axis, nothing that changes shared."""
    other = copy.copy(axis)
    other.drive, other.tracking = copy.copy(axis.drive), copy.copy(axis.tracking)
    other.drive.events = list(axis.drive.events)
    if isinstance(other.drive, Drive):
        other.drive._edges, other.drive._held = copy.copy(other.drive._edges), copy.copy(other.drive._held)
    other.tracking.lag = copy.copy(axis.tracking.lag)
    return other


FIXED = ("plan", "drive", "tracking", "scaling", "lag", "_settings", "_edges", "_held", "_warn", "_trip", "_standstill", "_settle")


def told(thing: object) -> list[str]:
    """Everything an object with slots holds that can change, to the bit."""
    names = getattr(type(thing), "__slots__", ())
    return [f"{name}={getattr(thing, name)!r} {type(getattr(thing, name)).__name__}" for name in names if name not in FIXED]


def whole(axis: HeldAxis) -> list[list[str]]:
    drive = cast(Drive, axis.drive)
    return [told(part) for part in (axis, drive, drive._edges, drive._held, axis.tracking, axis.tracking.lag)]


AXIS, DRIVE, EDGES, HELD, TRACKING, LAG = (
    attrgetter(*(name for name in kind.__dict__["__slots__"] if name not in FIXED))
    for kind in (HeldAxis, Drive, DemandEdges, HeldPosition, Tracking, LagMonitor)
)


def quick_look(axis: HeldAxis) -> list[object]:
    """The same for many cycles: no number tells 1 from 1.0 or True here."""
    drive = cast(Drive, axis.drive)
    return [AXIS(axis), DRIVE(drive), EDGES(drive._edges), HELD(drive._held), TRACKING(axis.tracking), LAG(axis.tracking.lag)]


class SideBySide:
    """Loops that do everything twice and compare."""

    def __init__(self, quick: NativeParts, closely: int = 1) -> None:
        self.native, self.closely = quick.loops, closely  # every so many calls
        self.calls = 0

    def _same(self, axes: list[HeldAxis], twins: list[HeldAxis]) -> None:
        self.calls += 1
        for axis, twin in zip(axes, twins, strict=True):
            if self.calls % self.closely == 0 or quick_look(axis) != quick_look(twin):
                assert whole(axis) == whole(twin)

    def drive_axes(
        self, axes: list[HeldAxis], actuals: Sequence[Actual | None], q: Sequence[float], speeds: Sequence[float], reset: bool, /
    ) -> tuple[list[SetRecord], bool, bool]:
        twins = [twin_of(axis) for axis in axes]
        asked = PYTHON.drive_axes(twins, actuals, q, speeds, reset)
        done = self.native.drive_axes(axes, actuals, q, speeds, reset)
        assert done == asked or repr(done) == repr(asked)
        self._same(axes, twins)
        return done

    def watch_axes(self, axes: list[HeldAxis], actuals: Sequence[Actual | None], first: int, /) -> int:
        twins = [twin_of(axis) for axis in axes]
        asked = PYTHON.watch_axes(twins, actuals, first)
        done = self.native.watch_axes(axes, actuals, first)
        assert done == asked
        self._same(axes, twins)
        return done

    def show_axes(self, states: list[AxisState], axes: list[HeldAxis], at_rest: bool, period_s: float, /) -> tuple[int, int, int, int]:
        twins, others = [twin_of(axis) for axis in axes], [copy.copy(state) for state in states]
        asked = PYTHON.show_axes(others, twins, at_rest, period_s)
        done = self.native.show_axes(states, axes, at_rest, period_s)
        assert done == asked
        if self.calls % self.closely == 0 or states != others:
            assert [told(state) for state in states] == [told(state) for state in others]
        self._same(axes, twins)
        return done


class Cell(CellBench):
    """A whole cell whose loops run twice."""

    def __init__(self, quick: NativeParts) -> None:
        self.loops = SideBySide(quick, closely=50)
        super().__init__()

    def ready(self) -> "Cell":
        super().ready()
        return self

    def _new_core(self) -> CycleLogic:
        return CycleLogic(core_axes(DEMO, self.period_ns / 1e6), self.period_ns / 1e9, self.generation, loops=self.loops)


def test_a_cell_that_is_teased_lives_the_same_life_in_both(quick: NativeParts) -> None:
    chance = random.Random(1)
    cell = Cell(quick).ready()
    for _ in range(20):
        match chance.randrange(7):
            case 0:
                cell.silent = {n for n in range(1, 7) if chance.random() < 0.3}
            case 1:
                cell.permit(chance.randrange(24, 29), value=chance.random() < 0.6)
            case 2:
                cell.late = {n for n in range(1, 7) if chance.random() < 0.3}
            case 3:
                code = chance.choice([Code.ENABLE, Code.REFERENCE, Code.FAULT_RESET, Code.STOP, Code.RESUME, Code.ABANDON, Code.DISABLE])
                cell.give(code)
            case _:
                cell.give(Code.PTP_ABSOLUTE, velocity=chance.random(), targets=tuple(chance.uniform(-50, 300) for _ in range(6)))
        cell.cycle(chance.randrange(1, 60))
        cell.silent, cell.late = set(), set()
        cell.cycle(chance.randrange(1, 60))
    assert cell.loops.calls > 3_000


@st.composite
def held_axes(draw: st.DrawFn) -> HeldAxis:
    """An axis in any state at all."""
    settings_ = DriveSettings(jump_inc=draw(st.sampled_from([0, 8192])), step_inc=draw(st.sampled_from([0, 100, 32768])))
    drive = Drive(settings_)
    drive._go(draw(st.sampled_from([Phase.ENABLED, Phase.ENABLED, *Phase])))
    drive.events = draw(st.lists(st.sampled_from(Event), max_size=2))
    edges, held = drive._edges, drive._held
    edges.on_before, edges.reset_before, edges.asked = draw(st.booleans()), draw(st.booleans()), draw(st.booleans())
    held.fresh, held.refused, drive.warning = draw(st.booleans()), draw(st.booleans()), draw(st.booleans())
    edges.reset_left, drive._life = draw(st.sampled_from([0, 0, 3])), draw(st.integers(0, 255))
    drive.position_inc, held.inc = draw(INC), draw(INC)
    drive.epoch, drive.missing = draw(st.integers(0, 2)), draw(st.integers(0, 2))
    tracking = Tracking(draw(REALS), draw(REALS), draw(REALS), draw(st.integers(0, 3)))
    tracking._last, tracking._still = draw(st.one_of(st.none(), INC)), draw(st.integers(0, 5))
    tracking.number = draw(st.sampled_from([0, 0, 647, 648]))
    tracking.lag.state, tracking.lag.worst = draw(st.sampled_from(LagState)), draw(REALS)
    scaling = Scaling(gear=draw(st.floats(0.1, 100)), direction=draw(st.sampled_from([1, -1])), zero_inc=draw(st.floats(-1e6, 1e6)))
    axis = HeldAxis(CoreAxis("A1", scaling, None, draw(REALS), settings_), drive, tracking, scaling)
    for name in ("wanted", "referenced", "led", "by_drive", "gap", "limited"):
        setattr(axis, name, draw(st.booleans()))
    axis.set, axis.speed, axis.behind = draw(st.floats(-1e3, 1e3)), draw(st.floats(-1e3, 1e3)), draw(REALS)
    axis.active_inc, axis.received_inc, axis.sent_inc = draw(INC), draw(INC), draw(INC)
    axis.epoch, axis.quiet, axis.power = draw(st.integers(0, 2)), draw(st.integers(0, 30)), draw(st.sampled_from(Power))
    axis.power_number, axis.finding = axis.power.value, draw(st.sampled_from([0, 647]))
    return axis


ACTUALS = st.one_of(
    st.none(),
    st.builds(
        ActualValue, FLAG, FLAG, st.just(True), st.just(False), FLAG, FLAG, FLAG, FLAG, st.integers(0, 255), INC, st.integers(-2000, 2000)
    ),
    st.builds(ActualValue, *[FLAG] * 8, st.integers(0, 255), INC, st.integers(-2000, 2000)),
)


@settings(max_examples=120, deadline=None)
@given(axis=held_axes(), actual=ACTUALS, q=st.floats(-1e4, 1e4), speed=REALS.filter(lambda value: value == value), reset=FLAG, rest=FLAG)
def test_an_axis_in_any_state_takes_the_same_step_in_both(
    quick: NativeParts, axis: HeldAxis, actual: Actual | None, q: float, speed: float, reset: bool, rest: bool
) -> None:
    loops = SideBySide(quick)
    loops.drive_axes([axis], [actual], (q,), (speed,), reset)
    loops.watch_axes([axis], [actual], 0)
    loops.show_axes([AxisState()], [axis], rest, 0.002)


@settings(max_examples=120, deadline=None)
@given(
    axis=held_axes(),
    refused=FLAG,
    still_for=st.integers(0, 4),
    far=st.sampled_from([0.0, 0.5, 1.0, 3.0, 20.0]),
    step=st.integers(-200, 200),
)
def test_an_axis_that_follows_takes_the_short_way_to_the_same_end(
    quick: NativeParts, axis: HeldAxis, refused: bool, still_for: int, far: float, step: int
) -> None:
    """What C does itself: a drive on and following, a set value within its step, an axis that stands for one cycle more."""
    drive, loops = Drive(DriveSettings(step_inc=100)), SideBySide(quick)
    drive._go(Phase.ENABLED)
    drive._held.fresh, drive._edges.reset_before, drive._edges.on_before, axis.led, axis.gap = False, False, True, False, False
    drive._held.refused, drive._held.inc, drive._life = refused, 1_000, 255
    axis.drive, axis.scaling, axis.wanted, axis.by_drive, axis.active_inc = drive, Scaling(), True, False, 1_000
    axis.tracking = Tracking(1.0, 10.0, 15.0, settle_cycles=2)
    axis.tracking._last, axis.tracking._still = 1_000, still_for
    axis.tracking.number, axis.behind = 0, far
    actual = ActualValue(True, True, True, False, False, False, False, True, 0, 1_000, 0)
    loops.watch_axes([axis], [actual], 0)
    loops.drive_axes([axis], [actual], (axis.scaling.to_si(1_000 + step),), (0.0,), False)


@pytest.mark.parametrize("q", [float("nan"), float("inf"), -float("inf")])
def test_a_position_that_is_no_number_raises_the_same_in_both(quick: NativeParts, q: float) -> None:
    axis = HeldAxis(CoreAxis("A1", Scaling(), None, 1.0, DriveSettings()), Drive(), Tracking(), Scaling(), set=q)
    raised = []
    for loops in (PYTHON, quick.loops):
        with pytest.raises((ValueError, OverflowError)) as caught:
            loops.drive_axes([twin_of(axis)], [None], (q,), (0.0,), False)
        raised.append(caught.type)
    assert raised[0] is raised[1]


def test_what_does_not_fit_is_refused(quick: NativeParts) -> None:
    axis = HeldAxis(CoreAxis("A1", Scaling(), None, 1.0, DriveSettings()), Drive(), Tracking(), Scaling())
    with pytest.raises(ValueError):
        quick.loops.drive_axes([axis], [None], (0.0, 0.0), (0.0,), False)
    with pytest.raises(TypeError):
        quick.loops.drive_axes([cast(HeldAxis, object())], [None], (0.0,), (0.0,), False)


# ---- memory ------------------------------------------------------------------------------------------------------------


@st.composite
def states(draw: st.DrawFn) -> CellState:
    """What a cycle may publish."""
    state = CellState(motion=draw(st.sampled_from(Motion)), emergency=draw(FLAG), met=draw(FLAG))
    for each in fields(CellState):
        if each.type == "int" or each.type is int:
            setattr(state, each.name, draw(st.sampled_from([0, 1, 255, 65_535])) if each.name != "permits" else draw(st.integers(0, 31)))
        elif each.type is float:
            setattr(state, each.name, draw(REALS))
    state.belt_axis = state.belt_code = state.stop_cause = 7
    reals = [[draw(REALS) for _ in range(5)] for _ in range(MOST_AXES)]
    flags = [FLAGS[draw(st.integers(0, 511))] for _ in range(MOST_AXES)]
    state.axes = [AxisState(a, b, c, d, e, flag, 65_535, 5, 647) for (a, b, c, d, e), flag in zip(reals, flags, strict=True)]
    return state


@settings(max_examples=25, deadline=None)
@given(state=states(), axes=st.integers(1, MOST_AXES))
def test_a_state_is_packed_the_same_in_both(quick: NativeParts, state: CellState, axes: int) -> None:
    outcomes = []
    for packer in (cell_state_packer(axes), quick.packer(axes)):
        try:
            outcomes.append(packer(state).hex())
        except (struct.error, OverflowError):
            outcomes.append("does not fit")
    assert outcomes[0] == outcomes[1]


def test_regions_and_rings_are_written_the_same_in_both(quick: NativeParts) -> None:
    chance = random.Random(3)
    fds = [create_region("r", RC_BYTES, "x") for _ in range(2)] + [create_ring("g", 41, 5, "x") for _ in range(2)]
    regions = [RegionWriter(fds[0]), quick.region(fds[1])]
    rings = [RingWriter(fds[2]), quick.ring(fds[3])]
    reader, taker = RegionReader(fds[1]), RingReader(fds[3])
    assert [type(each) for each in (regions[1], rings[1])] != [RegionWriter, RingWriter]
    for n in range(1, 40):
        octets, record = chance.randbytes(RC_BYTES), chance.randbytes(41)
        assert [region.write(bytearray(octets), n) for region in regions] == [n, n]
        assert [ring.put(record) for ring in rings] == [n, n]
        for region in regions:
            region.beat(1000 + n)
        assert (reader.read(), reader.stamp_ns, reader.life) == (octets, n, (n, 1000 + n))
        assert taker.take() == [(n, record)]
    for a, b in ((fds[0], fds[1]), (fds[2], fds[3])):
        assert os.pread(a, 1 << 16, 0) == os.pread(b, 1 << 16, 0)
    for ring in rings:
        with pytest.raises((ValueError, ImageError)):
            ring.put(bytes(40))


def test_what_others_wrote_is_seen_the_same_in_both(quick: NativeParts) -> None:
    links, planner, image = (create_region(name, 24, "x") for name in ("l", "p", "i"))
    pieces, orders = (create_ring(name, 24, 5, "x") for name in ("s", "o"))
    readers = (RegionReader(links), RegionReader(planner), RingReader(pieces), RingReader(orders), RegionReader(image))
    quickly, slowly = quick.looker(*readers), NativeParts(python=True).looker(*readers)
    assert quickly() == slowly() == (0, 0, 0, 0, 0, 0)
    RegionWriter(links).beat(77)
    RegionWriter(planner)
    for fd, count in ((pieces, 3), (orders, 2)):
        ring = RingWriter(fd)
        for _ in range(count):
            ring.put(bytes(24))
    RegionWriter(image).write(bytes(24), 1)
    assert quickly() == slowly() == (os.getpid(), 77, os.getpid(), 3, 2, 1)
    assert quick.looker(readers[0], None, None, *readers[3:])() == (os.getpid(), 77, 0, 0, 2, 1)


def test_the_alarm_wakes_and_learns_in_both(quick: NativeParts) -> None:
    for alarm in (Alarm(), quick.alarm()):
        due = time.monotonic_ns() + 20_000_000
        assert alarm.until(due) >= due
        before = alarm.ahead_ns
        assert alarm.until(due) >= due
        assert alarm.ahead_ns == min(before + Alarm.GROW_NS, Alarm.LONGEST_NS)


# ---- without them ------------------------------------------------------------------------------------------------------


def test_whoever_asks_for_python_gets_the_twins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PYTHON_ONLY, "1")
    quick = NativeParts()
    assert (quick.loops, quick.region, quick.ring, quick.telegrams(FAMILY), quick.missing) == (PYTHON, RegionWriter, RingWriter, None, [])
    assert (quick.collect, quick.alarm) == (None, Alarm)


def test_a_library_of_other_sources_is_not_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in (*(f"{part}.c" for part in built.PARTS), built.HEADER):
        (tmp_path / name).write_text((built.FOLDER / name).read_text() + "/* changed */")
    for part in built.PARTS:
        shutil.copy(built.library(part), tmp_path)
    monkeypatch.setattr(built, "FOLDER", tmp_path)
    quick = NativeParts(python=False)
    assert quick.loops is PYTHON
    assert len(quick.missing) == len(built.PARTS) - 1, "the servo step belongs to the emulator"
