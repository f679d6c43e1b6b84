"""User boards: both modes of their refresh, its ratio, an overrun (VAL 3 reference 5.7; AX-1060)."""

from dataclasses import replace

import pytest

from gateway.pure.languages.val3.boards import UserBoards, user_boards
from hil_tests.lab.virtual.val3_cell_bench import DONE, PART, Val3Cell
from hil_tests.unit.languages.val3.apps import App, datum, run, value

DATA = (
    datum("diPart", "dio", values=value(link="ValveIO\\part"))
    + datum("diFast", "dio", values=value(link="FastIO\\fIn0"))
    + datum("n", "num", "6")
    + datum("bPower", "bool", "3")
    + datum("bGo", "bool")
)
SEEN = "wait(diPart)\nn[0]=clock()\nwait(diFast)\nn[1]=clock()"
GUARD = """n[0]=ioStatus(diPart)
bPower[0]=isPowered()
delay(0.1)
n[1]=ioStatus(diPart)
n[2]=ioStatus(diFast)
bPower[1]=isPowered()
enablePower()
bPower[2]=isPowered()
wait(bGo)
n[3]=ioStatus(diPart)"""


def globals_after(program: str, *events: tuple[float, str]) -> dict[str, object]:
    found = run(App(data=DATA, programs={"start": program}), at=events)["globals"]
    assert isinstance(found, dict)
    return found


@pytest.mark.requirement("VAL-IOR-03", by="gateway.pure.languages.val3.boards:UserBoards.due")
@pytest.mark.parametrize(
    ("ratio", "at"), [("-1", 0.024), ("1", 0.024), ("2", 0.024), ("3", 0.024), ("4", 0.032), ("5", 0.04), ("7", 0.028), ("10", 0.04)]
)
def test_an_input_of_a_user_board_is_seen_with_the_next_refresh(ratio: str, at: float) -> None:
    found = globals_after(SEEN, (0, f"ratio={ratio}"), (0.0205, "dio.ValveIO\\part=1"), (0.0505, "dio.FastIO\\fIn0=1"))
    assert found["n"] == [pytest.approx(at), pytest.approx(0.048, abs=0.0041), 0, 0, 0, 0], "system boards in each cycle"


def test_ratio_minus_1_of_cell_cfx_is_1() -> None:
    assert [user_boards("default", given, {}).ratio for given in (-1, 1, 3)] == [1, 1, 3]


@pytest.mark.requirement("VAL-IOR-01", by="gateway.pure.languages.val3.virtual_io:VirtualIo.refresh")
def test_an_overrun_of_the_refresh_makes_user_inputs_invalid_until_the_ratio_is_raised() -> None:
    slow = [(0.05, "board.ValveIO=5000"), (1, "ratio=2"), (1.1, "bGo=1")]
    found = globals_after(GUARD, *slow)
    assert found["n"] == [0, -3, 0, 0, 0, 0] and found["bPower"] == [True, True, True]
    found = globals_after(GUARD, *slow[:1], (1, "ratio=1"), slow[2])
    assert found["n"] == [0, -3, 0, -3, 0, 0]


@pytest.mark.requirement("VAL-IOR-02", by="gateway.pure.languages.val3.robot_state:RobotState.overrun")
def test_an_overrun_of_the_synchro_task_stops_the_robot_until_the_controller_begins_anew() -> None:
    found = globals_after(GUARD, (0, "refresh=noJitter"), (0, "ratio=3"), (0.05, "board.ValveIO=5000"), (1, "bGo=1"))
    assert found["n"] == [0, 0, 0, 0, 0, 0] and found["bPower"] == [True, False, False]
    found = globals_after(GUARD, (0, "refresh=noJitter"), (0.05, "board.ValveIO=3900"), (1, "bGo=1"))
    assert found["bPower"] == [True, True, True]


def test_a_value_of_a_board_in_fault_stops_the_task_with_125() -> None:
    result = run(App(data=DATA, programs={"start": "delay(0.1)\nbGo=diPart"}), at=[(0, "board.ValveIO=9000")])
    assert result["tasks"] == {"demo~": {"status": 125, "program": "start", "line": 3}}


# ---- in a cell ------------------------------------------------------------------------------------------------------------------

CELL_DATA = (
    datum("diPart", "dio", values=value(link="part"))
    + datum("doDone", "dio", values=value(link="done"))
    + datum("nOne", "num")
    + datum("nCode", "num")
)


def cell_with(start: str, boards: UserBoards) -> Val3Cell:
    """A cell with such user boards."""
    cell = Val3Cell(App(data=CELL_DATA, programs={"start": start}).files(), "demo")
    cell.setup = replace(cell.setup, boards=boards)
    cell.born(1)
    return cell


def test_a_cell_refreshes_its_user_boards_in_their_ratio() -> None:
    cell = cell_with(
        "while true\nif diPart\nnOne=nOne+1\ndoDone=true\nwait(false)\nendIf\ndelay(0)\nendWhile", boards=user_boards("default", 25, {})
    )
    cell.start()
    cell.bench.run(0.3)
    cell.put(PART)
    since = cell.bench.now / 1e9
    cell.until(lambda: cell.value("nOne") == 1.0, 1.0)
    cell.until(lambda: (DONE, True) in [each[1:] for each in cell.outputs], 1.0)
    late = cell.outputs[-1][0] - since
    assert 0.1 <= late <= 0.21, "in with one refresh, out with the next one 100 ms later"


def test_a_cell_whose_boards_are_late_gives_codes_and_no_values() -> None:
    late = user_boards("default", 1, {"ValveIO": 9000, "PlcIO": 9000})
    cell = cell_with("delay(0.05)\nnCode=ioStatus(diPart)\nwait(diPart)", boards=late)
    cell.start()
    cell.until(lambda: bool(cell.programs.faults()), 1.0)
    assert cell.value("nCode") == -3.0 and "error 125" in cell.programs.faults()[0]


def test_the_operator_raises_the_ratio_and_the_values_are_valid_again() -> None:
    late = user_boards("default", 1, {"ValveIO": 9000})
    cell = cell_with("delay(0.05)\nnCode=ioStatus(diPart)\nwait(ioStatus(diPart)==0)\nnOne=1\nwait(diPart)", boards=late)
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nCode") == -3.0, 1.0)
    assert cell.programs.answer({"do": "act", "act": "ratio", "value": "3"}, 0) == {"ok": True}
    cell.until(lambda: cell.value("nOne") == 1.0, 1.0)


def test_a_cell_with_an_overrun_of_the_synchro_task_has_no_power() -> None:
    cell = cell_with("enablePower()\nnOne=1\nwait(isPowered())\nnOne=2", boards=user_boards("noJitter", 3, {"ValveIO": 4100}))
    cell.power()
    cell.start()
    cell.bench.run(1.0)
    assert cell.value("nOne") == 1.0 and any("overrun of the synchro task" in line for line in cell.words)
