"""Timers and counters follow STEP 5."""

import pytest

from gateway.pure.languages.plc.plc import Plc
from hil_tests.unit.languages.plc.rig import TICK, Rig

START = "gateway.pure.languages.plc.cells:Cells.start"


def timer(kind: str, time: int, extra: str = "") -> Rig:
    return Rig(f"L {time}\nU E0.0\nST {kind}, T 5\n{extra}\nU T5\n= A0.0")


def states(rig: Rig, *phases: tuple[str, int]) -> list[bool]:
    """The state at each scan of 10 ms."""
    found = []
    for inputs, count in phases:
        for _ in range(count):
            found.append(rig.scan(*inputs.split()).output("A0.0"))
    return found


@pytest.mark.requirement("RSV-PLC-14", by=START)
def test_a_pulse_ends_with_its_time_or_with_the_result() -> None:
    assert states(timer("I", 100), ("E0.0", 50), ("", 10)) == [True] * 50 + [False] * 10
    assert states(timer("I", 100), ("E0.0", 200)) == [True] * 100 + [False] * 100
    reset = timer("I", 100, "U E0.1\nR T5")
    assert states(reset, ("E0.0", 3), ("E0.0 E0.1", 1), ("E0.0", 5), ("", 1), ("E0.0", 1)) == [True] * 3 + [False] * 7 + [True]


@pytest.mark.requirement("RSV-PLC-15", by=START)
def test_an_extended_pulse_has_its_full_time_and_begins_again_with_each_edge() -> None:
    assert states(timer("V", 100), ("E0.0", 10), ("", 120)) == [True] * 100 + [False] * 30
    assert states(timer("V", 10), ("E0.0", 1), ("", 4), ("E0.0", 1), ("", 12)) == [True] * 15 + [False] * 3


@pytest.mark.requirement("RSV-PLC-16", by=START)
def test_switch_on_delay() -> None:
    assert states(timer("E", 1000), ("E0.0", 1003), ("", 2)) == [False] * 1000 + [True] * 3 + [False] * 2
    assert not any(states(timer("E", 10), ("E0.0", 9), ("", 1), ("E0.0", 9), ("", 5)))


@pytest.mark.requirement("RSV-PLC-17", by=START)
def test_switch_off_delay() -> None:
    assert states(timer("A", 200), ("E0.0", 5), ("", 210)) == [True] * 205 + [False] * 10
    assert all(states(timer("A", 10), ("E0.0", 1), ("", 8), ("E0.0", 20), ("", 9)))
    reset = timer("A", 10, "U E0.1\nR T5")
    assert states(reset, ("E0.0", 1), ("", 3), ("E0.1", 1), ("", 9)) == [True] * 4 + [False] * 10


def test_a_timer_that_is_still_fed_does_not_begin_anew_after_its_reset() -> None:
    rig = timer("E", 2, "U E0.1\nR T5")
    assert states(rig, ("E0.0", 4), ("E0.0 E0.1", 1), ("E0.0", 9)) == [False, False, True, True] + [False] * 10


@pytest.mark.requirement("RSV-PLC-18", by="gateway.pure.languages.plc.cells:Cells._counter")
def test_timers_and_counters_share_their_cells() -> None:
    rig = Rig("U E0.0\nL 100\nST V,T3\nL 7\nU E0.1\nS Z3\nU T3\n= A0.0\nU Z3\n= A0.1")
    assert rig.scan("E0.0").outputs[0] == 3
    assert rig.scan("E0.0", "E0.1").outputs[0] == 2
    assert rig.plc.data.cells.content(3) == 7


@pytest.mark.requirement("RSV-PLC-19", by="gateway.pure.languages.plc.cells:Cells.count")
def test_counters_count_edges_between_0_and_999() -> None:
    rig = Rig("U E0.0\nZV Z1,1\nU E0.1\nZR Z 1 , 1\nU E0.2\nR Z1\nL 999\nU E0.3\nS Z1\nU Z1\n= A0.0")
    content = rig.plc.data.cells.content
    for _ in range(3):
        rig.scan("E0.0").scan("E0.0").scan()
    assert (content(1), rig.output("A0.0")) == (3, True)
    assert rig.scan("E0.1").plc.data.cells.content(1) == 2
    assert not rig.scan("E0.2").output("A0.0")
    rig.scan("E0.1").scan("E0.3").scan("E0.0")
    assert content(1) == 999


@pytest.mark.requirement("RSV-PLC-38", by="gateway.pure.languages.plc.plc:Plc.retained")
def test_markers_timers_and_counters_outlive_power_off() -> None:
    rig = Rig("L 100\nU E0.0\nST V,T5\nU E0.0\nZV Z6,1\nU T5\n= A0.0")
    rig.plc.set_marker(100, 7)
    for _ in range(40):
        rig.scan("E0.0")
    kept = rig.plc.retained(40 * TICK)
    again = Plc(rig.sources)
    again.power_on(kept, 0)
    again.start("MAIN")
    assert (again.marker(100), again.data.cells.content(6), again.bit(1020, 4)) == (7, 1, True)
    seen = [bool(again.scan(tick * TICK, bytes([1]) + bytes(39))[0]) for tick in range(70)]
    assert seen == [True] * 60 + [False] * 10
    with pytest.raises(ValueError, match="retained data"):
        again.power_on(kept[:-1], 0)
    with pytest.raises(ValueError, match="no timer"):
        again.power_on(kept[:1968] + b"\xff" * (len(kept) - 1968), 0)


def test_a_counter_that_takes_the_cell_of_a_timer_goes_on_from_the_rest_of_its_time() -> None:
    """Timers and counters are one range of long words (L2440); the start command is jumped over meanwhile."""
    rig = Rig("U E0.1\nSP X,1\nL 500\nU E0.0\nST V,T3\nM X\nU E0.1\nZV Z3,1")
    rig.scan("E0.0").scan("E0.0")
    assert rig.plc.data.cells.content(3) == 499
    assert rig.scan("E0.1").plc.data.cells.content(3) == 499, "498 left, and one more"
    assert rig.plc.data.cells.is_counter(3)
