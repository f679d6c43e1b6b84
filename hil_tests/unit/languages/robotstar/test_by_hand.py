"""The robot moved by hand in a cell of emulated drives: movement keys, Position Control, 6D mouse (L175-193, L1302-1337, L3003-3168)."""

import itertools
import math
from dataclasses import replace

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import Motion
from gateway.pure.languages.robotstar.mouse import MouseData
from hil_tests.lab.virtual.reis_bench import AUTO, CELL, ReisCell, at, main
from hil_tests.unit.languages.robotstar.memory import run

HERE = (884.0, 0.0, 591.0)
REIS = "gateway.pure.controllers.reis."
HAND = "gateway.pure.languages.robotstar.hand:Hand."
MOUSE = "gateway.pure.languages.robotstar.mouse:"
# readings of a mouse that is turned by 90 degrees about Z, guided against the movement, as a calibration at the tool leaves them
VECTORS = ((0, 200, 0), (-260, 0, 0), (0, 0, 220), (260, 0, 0), (0, 200, 0), (0, 0, 225))
CALIBRATED = (
    "".join(
        f"COPY {value}, VM.{name}\n" + (f"COPY VM, V_KAL[{number}]\n" if place == 2 else "")
        for number, vector in enumerate(VECTORS, 1)
        for place, (name, value) in enumerate(zip("XYZ" if number < 4 else "ABC", vector, strict=True))
    )
    + "MAUS_KALIB V_KAL\n"
)
KEPT = main("VAR VM\nVAR V_KAL[6]", "V")


def in_hand(body: str = "", coord: int = 1, files: dict[str, str] | None = None, cell: Cell = CELL) -> ReisCell:
    """At HERE, in HAND."""
    made = ReisCell(main(f"{body}{at(*HERE)}\nSTOP") | (files or {}), cell=cell)
    assert made.run()[0] == "ended", made.told
    to_hand(made)
    made.control.put("reis.coord", coord)
    return made


def to_hand(cell: ReisCell) -> None:
    cell.bench.permit(AUTO, value=False)
    cell.until(lambda: cell.control.status()["mode"] == "0101")


def pressed(cell: ReisCell, seconds: float, **keys: float) -> tuple[float, ...]:
    """Position of the tool once keys (jog_1=1) were held so long, released, and the axes rest."""
    for name, value in keys.items():
        cell.control.put(f"reis.{name.replace('_', '.')}", value)
    cell.bench.run(seconds)
    for name in keys:
        cell.control.put(f"reis.{name.replace('_', '.')}", 0.0)
    rests(cell)
    return cell.places[-1]


def rests(cell: ReisCell) -> None:
    cell.bench.cycle(5)
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE)
    here = cell.joints[-1]
    cell.bench.run(0.3)
    assert cell.joints[-1] == here


def speed(cell: ReisCell, since: int) -> float:
    """Highest, mm/s."""
    places = cell.places[since:]
    return max(math.dist(a[:3], b[:3]) for a, b in itertools.pairwise(places)) / 0.004


@pytest.mark.requirement("RSV-PLC-34", by=REIS + "programs:ReisPrograms.code")
@pytest.mark.requirement("RSV-PLC-34", by=REIS + "hand_keys:HandKeys.code")
def test_m1022_has_the_mode() -> None:
    cell = ReisCell(main("STOP"))

    def shown() -> str:
        cell.bench.cycle(3)
        return cell.control.flag_bytes()[1022:1024].hex()

    assert shown() == "0300"
    cell.bench.permit(AUTO, value=False)
    found = []
    for test in (1, 2, 3, 4, 0):
        cell.control.put("reis.mode", test)
        found.append(shown())
    assert found == ["0201", "0202", "0203", "0204", "0101"]
    found = []
    for coord in (1, 2, 3):
        cell.control.put("reis.coord", coord)
        found.append(shown())
    assert found == ["0102", "0102", "0101"], "tXYZ, tUVW, AXIS 7-12"
    cell.control.put("reis.coord", 1)
    cell.control.put("reis.jog.5", -1)
    assert shown() == "0103"
    flags = cell.control.flag_bytes()
    assert flags[1021] & 0b11000 == 0b10000, "the minus key, M1021.4"


def test_a_key_leads_the_tool_straight_with_its_orientation_until_it_is_released() -> None:
    cell = in_hand()
    began = len(cell.places)
    x, y, z, *angles = pressed(cell, 1.0, jog_2=1)
    assert (x, z) == pytest.approx(HERE[::2], abs=0.02) and 150 < y < 260
    assert speed(cell, began) == pytest.approx(250, rel=0.02), "_RVEL_KART at an override of 100 %"
    off = [math.dist(place[::2][:2], HERE[::2]) for place in cell.places[began:]]
    assert max(off) < 0.05
    before = [math.cos(math.radians(value)) for value in cell.places[began][3:]]
    assert [math.cos(math.radians(value)) for value in angles] == pytest.approx(before, abs=1e-4)
    both = pressed(cell, 1.0, jog_1=-1, jog_3=1)
    assert both[1] == pytest.approx(y, abs=0.02) and both[0] - x == pytest.approx(z - both[2], abs=0.05), "two keys at once"
    assert speed(cell, began) < 256


def test_the_override_acts_during_the_movement() -> None:
    cell = in_hand()
    cell.control.put("reis.jog.2", 1)
    cell.bench.run(0.6)
    job = cell.bench.settle(cell.bench.give(Code.OVERRIDE, velocity=0.2))
    assert job.state.name == "DONE"
    cell.bench.run(0.5)
    began = len(cell.places)
    cell.bench.run(0.4)
    assert speed(cell, began) == pytest.approx(50, rel=0.03)


def test_an_orientation_key_turns_about_the_tool_centre_point() -> None:
    cell = in_hand("TOOL T1\n", files=main("VAR T1, X:0, Y:0, Z:100, RX:0, RY:0, RZ:0", "V"))
    tool = cell.hosted.tool
    before = cell.arm.actual(cell.joints[-1], tool).pose
    began = len(cell.joints)
    pressed(cell, 1.0, jog_6=1)
    after = cell.arm.actual(cell.joints[-1], tool).pose
    assert after[:3] == pytest.approx(before[:3], abs=0.05)
    turned = (after[5] - before[5] + 180) % 360 - 180
    assert 20 < turned < 46, "_RVEL_ORI is 45 degrees/s"
    assert all(math.dist(cell.arm.actual(joints, tool).pose[:3], before[:3]) < 0.1 for joints in cell.joints[began:])


def test_tuvw_moves_along_the_axes_of_the_hand() -> None:
    cell = in_hand(coord=2)
    assert pressed(cell, 0.5, jog_3=1)[2] < HERE[2] - 50, "the tool points down: +Z of the hand is down"


def test_axis_keys_move_their_axes_together_and_stop_in_front_of_the_limit() -> None:
    cell = in_hand(coord=0)
    before = cell.joints[-1]
    pressed(cell, 0.8, jog_1=1, jog_6=-1)
    ways = [b - a for a, b in zip(before, cell.joints[-1], strict=True)]
    assert ways[0] > 3 and ways[5] < -3 * 240 / 100 and ways[1:5] == pytest.approx([0.0] * 4, abs=1e-6)
    assert ways[5] / ways[0] == pytest.approx(-240 / 100, rel=1e-3), "each at its own speed"
    end = cell.arm.machine.limits[4].upper
    pressed(cell, 15.0, jog_5=1)
    assert 0.3 < math.degrees(end) - cell.joints[-1][4] < 0.7
    cell.control.put("reis.coord", 3)
    pressed(cell, 0.2, jog_1=1)
    assert cell.told[-1] == "the robot cannot be moved by hand: this robot has 6 axes"


def test_a_key_leads_as_far_as_the_robot_reaches_and_its_first_piece_is_planned_at_once() -> None:
    cell = in_hand()
    began, handed_on = len(cell.places), len(cell.lines)
    x, y, z, *_ = pressed(cell, 6.0, jog_3=-1)
    assert z < -480 and (x, y) == pytest.approx(HERE[:2], abs=0.05)
    pieces = [line for line in cell.lines[handed_on:] if line.startswith("linear")]
    assert HERE[2] - float(pieces[0].split()[4]) <= 50 and len(pieces) > 3, "a second of planning is a second without movement"
    speeds = [math.dist(a[:3], b[:3]) / 0.004 for a, b in itertools.pairwise(cell.places[began:])]
    fast = [number for number, each in enumerate(speeds) if each > 249]
    assert len(fast) == fast[-1] - fast[0] + 1, "one movement: no piece of it slows down"


@pytest.mark.requirement("RSV-UI-02", by=(HAND + "_go_on", REIS + "hand_keys:HandKeys.push"))
def test_position_control_gives_54_mm_a_turn_of_the_wheel() -> None:
    cell = in_hand()
    cell.control.put("reis.position", 54.0)
    cell.control.put("reis.jog.1", 1)
    cell.bench.run(0.5)
    assert cell.where() == HERE, "key I: the key alone moves nothing"
    for step in range(1, 21):
        cell.control.put("reis.wheel", step / 20)
        cell.bench.run(0.05)
    cell.bench.run(1.0)
    assert cell.where() == pytest.approx((HERE[0] + 54, *HERE[1:]), abs=0.05)
    cell.control.put("reis.wheel", 0.5)
    cell.bench.run(1.0)
    assert cell.where() == pytest.approx((HERE[0] + 27, *HERE[1:]), abs=0.05), "to the left is back"
    cell.control.put("reis.jog.1", 0)
    cell.control.put("reis.wheel", 3.0)
    cell.bench.run(0.5)
    assert cell.where() == pytest.approx((HERE[0] + 27, *HERE[1:]), abs=0.05), "no key is held"
    cell.control.put("reis.position", 0)
    assert pressed(cell, 0.5, jog_1=1)[0] > HERE[0] + 60, "key O: override mode"


@pytest.mark.requirement("RSV-MSE-01", by=MOUSE + "MouseData.shares")
def test_dead_zone_and_limits_of_the_mouse() -> None:
    data = MouseData()
    assert data.shares((29, -29, 30, 520, 400, -450)) == (0, 0, 30 / 440, 1, 1, -1)
    assert data.shares((520, -400, 440, 9999, -9999, 29.9)) == (1, -1, 1, 1, -1, 0)


@pytest.mark.requirement("RSV-MSE-02", by=MOUSE + "Mouse.calibrate")
def test_maus_kalib_gives_the_two_matrices_or_is_not_possible() -> None:
    ran = run({"P.MPR": CALIBRATED, "V.MPR": "VAR VM\nVAR V_KAL[6]"})
    assert ran.texts() == []
    mouse = ran.cell.robot.machine.mouse
    assert [list(row) for row in mouse.translation] == [pytest.approx(row) for row in ((0, 1, 0), (-1, 0, 0), (0, 0, 1))]
    assert [list(row) for row in mouse.rotation] == [pytest.approx(row) for row in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    for zero in (1, 4, 6):
        body = CALIBRATED
        names = "XYZ" if zero < 4 else "ABC"
        broken = "".join(f"COPY 0, VM.{name}\n" for name in names) + f"COPY VM, V_KAL[{zero}]\nMAUS_KALIB V_KAL\n"
        refused = run({"P.MPR": body + broken, "V.MPR": "VAR VM\nVAR V_KAL[6]"})
        assert refused.texts() == ["Calibration not possible"], zero
    assert run({"P.MPR": "MAUS_KALIB V_KAL", "V.MPR": "VAR V_KAL[5]"}).state == "error"


@pytest.mark.requirement("RSV-MSE-03", by=(HAND + "_slice", REIS + "hand_keys:HandKeys.push"))
@pytest.mark.requirement("RSV-MSE-01", by=HAND + "_slice")
def test_the_mouse_moves_in_its_modes_alone() -> None:
    cell = in_hand("COPY 2, _VERFAHR[3]\n" + CALIBRATED, coord=0, files=KEPT)
    full = {"mouse_2": 400.0, "mouse_6": 450.0}
    assert pressed(cell, 0.5, **full)[:3] == pytest.approx(HERE, abs=0.02), "AXIS: the mouse is ignored"
    cell.control.put("reis.coord", 1)
    assert pressed(cell, 0.5, **full)[:3] == pytest.approx(HERE, abs=0.02), "neither tXYZ mouse nor rABC mouse is chosen"
    cell.control.put("reis.mouse.t", 1)
    before, began = cell.places[-1], len(cell.places)
    after = pressed(cell, 1.0, **full)
    way = [b - a for a, b in zip(before[:3], after[:3], strict=True)]
    assert way[1:] == pytest.approx([0, 0], abs=0.05) and abs(way[0]) > 100, "coordinate 2 is X of the hand"
    assert [math.cos(math.radians(value)) for value in after[3:]] == pytest.approx(
        [math.cos(math.radians(value)) for value in before[3:]], abs=1e-4
    ), "translation only"
    assert speed(cell, began) == pytest.approx(250, rel=0.02)
    began = len(cell.places)
    pressed(cell, 1.0, mouse_2=200.0)
    assert speed(cell, began) == pytest.approx(125, rel=0.03), "in proportion to the deflection"
    cell.bench.settle(cell.bench.give(Code.DISABLE, mask=cell.mask))
    here = cell.joints[-1]
    cell.control.put("reis.mouse.2", 400.0)
    cell.bench.run(0.5)
    assert cell.joints[-1] == here, "drives off: no motion"


def test_the_mouse_turns_about_the_tool_and_its_way_may_change() -> None:
    cell = in_hand("COPY 2, _VERFAHR[3]\n" + CALIBRATED, files=KEPT)
    cell.control.put("reis.mouse.r", 1)
    before = cell.places[-1]
    after = pressed(cell, 1.0, mouse_6=450.0)
    assert after[:3] == pytest.approx(before[:3], abs=0.05) and abs((after[5] - before[5] + 180) % 360 - 180) > 15
    cell.control.put("reis.mouse.r", 0)
    cell.control.put("reis.mouse.t", 1)
    for name, value in (("2", 400.0), ("1", -520.0), ("2", 0.0)):
        cell.control.put(f"reis.mouse.{name}", value)
        cell.bench.run(0.8)
    cell.control.put("reis.mouse.1", 0.0)
    rests(cell)
    assert math.dist(cell.where(), HERE) > 100 and not cell.told


def test_a_stopped_program_is_led_back_after_movements_by_hand() -> None:
    cell = ReisCell(main(f"MOVE_MODE #LINEAR\nPATH_SPEED 200\n{at(884, 0, 591)}\n{at(884, 250, 591)}\nSTOP"))
    started = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    cell.stop()
    assert cell.ends(started)[0] == "stopped"
    left = cell.where()
    to_hand(cell)
    cell.control.put("reis.coord", 1)
    assert pressed(cell, 0.6, jog_3=1)[2] > 650
    cell.bench.permit(AUTO)
    cell.bench.run(0.1)
    began = len(cell.places)
    assert cell.ends(cell.start())[0] == "ended" and cell.where() == pytest.approx((884, 250, 591), abs=0.05)
    assert min(math.dist(place[:3], left) for place in cell.places[began:]) < 0.5, "first to where it was stopped"


@pytest.mark.parametrize("what", ["interpreter", "mode", "drives", "services"])
def test_whatever_goes_the_axes_rest_and_nothing_begins_with_a_key_that_is_still_held(what: str) -> None:
    cell = in_hand(cell=replace(CELL, cell=replace(CELL.cell, on_services_loss="finish_move")))  # of programs, not of a key
    cell.control.put("reis.jog.2", 1)
    cell.until(lambda: cell.places[-1][1] > 40)
    match what:
        case "interpreter":
            cell.dies()
        case "mode":
            cell.bench.permit(AUTO)
        case "drives":
            cell.bench.give(Code.DISABLE, mask=cell.mask)
        case _:
            cell.bench.core.services_lost()
    cell.bench.run(1.0)
    assert cell.bench.core.state.motion in (Motion.IDLE, Motion.STOPPED)
    here = cell.joints[-1]
    if what == "interpreter":
        cell.born(2)
    if what == "drives":
        cell.ready()
    cell.bench.run(1.0)
    assert cell.joints[-1] == here


@pytest.mark.parametrize(("name", "value"), [("coord", 4), ("jog.1", 0.5), ("position", 101), ("mouse.1", 40_000)])
def test_values_that_do_not_fit_are_refused(name: str, value: float) -> None:
    cell = ReisCell(main("STOP"))
    with pytest.raises(ValueError, match=f"reis.{name} "):
        cell.control.put(f"reis.{name}", value)
    assert cell.control.value(f"reis.{name}") == 0
