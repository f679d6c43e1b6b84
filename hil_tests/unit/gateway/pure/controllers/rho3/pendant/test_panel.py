"""The pendant's own lines and keys.  Source: rho 3 Releases L2743-2941, L3454-3560; AX-495."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import pytest

from gateway.pure.controllers.rho3.functions.addresses import Places
from gateway.pure.controllers.rho3.functions.display import Display, Layer
from gateway.pure.controllers.rho3.functions.phg_selection import PhgSelection
from gateway.pure.controllers.rho3.functions.processes import ALREADY_EXISTS, Process, ProcessFault, ProcessTable, Program, Turn
from gateway.pure.controllers.rho3.functions.status_display import StatusDisplay
from gateway.pure.controllers.rho3.pendant.infos import Condition
from gateway.pure.controllers.rho3.pendant.modes import Mode
from gateway.pure.controllers.rho3.pendant.panel import Panel
from gateway.pure.controllers.rho3.pendant.user_memory import PointFile
from motion.program.factors import FULL, Factors
from protocols.base.machine import ms

BLANK = " " * 20


@dataclass
class Control:
    """A control made of plain values."""

    processes: ProcessTable = field(default_factory=lambda: ProcessTable({"PICK": Program(lambda: lambda now: Turn.WAIT)}))
    factors: Factors = FULL
    places: list[tuple[str, str, float]] = field(default_factory=lambda: [("A1", "mm", 12.5), ("A2", "mm", -3.0), ("A3", "deg", 90.0)])
    errors: list[tuple[int, str]] = field(default_factory=list)
    auto: list[bool] = field(default_factory=lambda: [True, True])
    holding: set[Condition] = field(default_factory=set)
    boards: list[str] = field(default_factory=list)

    def set_factor(self, which: str, value: float, kinematic: int = 0) -> None:
        self.factors = replace(self.factors, **{which: value})

    def positions(self) -> Sequence[tuple[str, str, float]]:
        return self.places

    def faults(self) -> Sequence[tuple[int, str]]:
        return self.errors

    def automatic(self) -> Sequence[bool]:
        return self.auto

    def concerned(self) -> Sequence[int]:
        return self.manual()

    def manual(self) -> Sequence[int]:
        return [number for number, auto in enumerate(self.auto, 1) if not auto]

    def fast_inputs(self) -> Sequence[str]:
        return self.boards

    def conditions(self) -> Collection[Condition]:
        return self.holding

    def order_memory(self, what: str) -> str:
        return ""

    def refusal(self) -> str:
        return ""

    def memory_outcome(self, what: str) -> str | None:
        return None

    def teach(self, file: str, point: str) -> str:
        return ""

    def define(self, shown: PointFile, point: str, place: int, size: int, value: float) -> str:
        return ""

    def component(self, shown: PointFile, point: str, place: int, size: int) -> str:
        return "-"

    def taught(self, file: str, point: str) -> str | None:
        return None

    def print_points(self, file: str) -> str:
        return ""

    def parameters(self) -> Sequence[tuple[str, str]]:
        return (("P2", "5"), ("P9", "200"))

    def locked(self) -> bool:
        return False

    def unlock(self, password: str) -> bool:
        return True

    def entered(self, mode: Mode) -> int:
        return 0

    def point_files(self) -> Sequence[str]:
        return []

    def point_file(self) -> PointFile | None:
        return None

    def open_points(self, file: str) -> str:
        return ""

    def movement(self) -> bool:
        return True

    def order_test(self, what: str, **facts: str | int | float | bool) -> None:
        pass

    def tested(self) -> Sequence[tuple[int, str, int, bool]]:
        return []

    def __post_init__(self) -> None:
        self.start: Callable[[str], Process] = self.processes.start


class Bench:
    """Panel, display and control; each key is followed by one step."""

    def __init__(self, language: str = "en") -> None:
        places = Places()
        self.control, self.display = Control(), Display()
        self.selection = PhgSelection(places, None)
        self.panel = Panel(self.display, self.selection, StatusDisplay(places, None), self.control, language)
        self.now = 0
        self.step()

    def step(self, milliseconds: int = 5) -> None:
        self.now += ms(milliseconds)
        self.panel.step(self.now)

    def types(self, *keys: str) -> "Bench":
        """A name of more than one letter is one key, else every character is one."""
        for key in keys:
            for each in [key] if key.isalpha() else key:
                self.display.press(each)
                self.step()
        return self

    @property
    def lines(self) -> list[str]:
        return [line.rstrip() for line in self.display.screen()]


def test_the_basic_level_says_automatic_only_when_all_kinematics_are() -> None:
    bench = Bench()
    assert bench.lines == ["Basic level", "Automatic", "", ""]
    bench.control.auto[1] = False
    bench.step(200)
    assert bench.lines[1] == "Manual"


@pytest.mark.requirement(
    "RHO-PHG-11", by=("gateway.pure.controllers.rho3.pendant.panel:Panel.go", "gateway.pure.controllers.rho3.pendant.panel:Panel._edit")
)
def test_modes_are_chosen_directly_by_keys_from_any_level() -> None:
    bench = Bench().types("MODE", "7.3.2")
    assert bench.lines[3] == "Mode=7.3.2"
    bench.types("ENTER")
    assert (bench.selection.mode, bench.lines[0]) == ("7.3.2", "7.3.2 Process condit")
    assert bench.types("MODE", "0.11.4", "ENTER").selection.mode == "11.4"
    assert bench.types("MODE", "0", "ENTER", "MODE", "9.4.10", "ENTER").selection.mode == "9.4", "stuck at the last valid level"
    assert bench.types("1", "ENTER").selection.mode == "9.4.1", "a sub-mode also without MODE"
    assert bench.types("LEFT", "LEFT").selection.mode == "9"
    assert bench.types("MODE", "4.2", "DELETE", "1", "ENTER").selection.mode == "9.4.1"


def test_what_cannot_be_a_mode_is_not_typed_and_left_gives_the_entry_up() -> None:
    bench = Bench().types("MODE", "7", "A", "-", "LEFT")
    assert (bench.selection.mode, bench.lines[3]) == ("0", "")
    bench.types("MODE", "1" * 40)
    assert bench.lines[3] == "Mode=" + "1" * 15
    bench.types(*["DELETE"] * 20)
    assert bench.lines[3] == "Mode="


def test_a_menu_lists_its_sub_modes_and_scrolls_as_a_ring() -> None:
    bench = Bench().types("MODE", "7", "ENTER")
    assert bench.lines[:3] == ["7 Diagnosis", "1 Axis display", "2 Errors, warnings"]
    assert bench.types("DOWN").lines[1:3] == ["2 Errors, warnings", "3 System conditions"]
    assert bench.types("UP", "UP").lines[1:3] == ["15 CAN outputs", "1 Axis display"]


def test_positions_follow_the_axes_five_times_a_second() -> None:
    bench = Bench().types("MODE", "7.1", "ENTER")
    assert bench.display.screen()[1:3] == ("A1        12.500 mm ", "A2        -3.000 mm ")
    bench.control.places[0] = ("A1", "mm", 13.0)
    bench.step(100)
    assert "12.500" in bench.lines[1]
    bench.step(100)
    assert "13.000" in bench.lines[1]
    assert bench.types("DOWN", "DOWN").lines[1:3] == ["A3        90.000 deg", "A1        13.000 mm"]


def test_errors_and_operating_modes() -> None:
    bench = Bench().types("MODE", "7.2", "ENTER")
    assert bench.lines[1] == "no error, no warning"
    bench.control.errors += [(528, "EMERGENCY STOP"), (768, "drive fault, axis 1 A1")]
    bench.step(200)
    assert bench.lines[1:3] == [" 528 EMERGENCY STOP", " 768 drive fault, ax"]
    bench.control.auto[0] = False
    assert bench.types("MODE", "0.7.3.3", "ENTER").lines[1:3] == ["Kin. 1: Manual", "Kin. 2: Automatic"]


def test_processes_are_started_shown_and_stopped() -> None:
    bench = Bench().types("MODE", "10.1", "ENTER", "ENTER")
    assert [process.name for process in bench.control.processes.processes] == ["PICK"]
    assert bench.lines[1:3] == ["no program", "started"]
    assert bench.types("MODE", "0.7.3.2", "ENTER").lines[1] == "PICK        ready"
    assert bench.types("MODE", "0.10.2", "ENTER").lines[1] == "PICK"
    assert bench.types("ENTER").lines[1:3] == ["no process", "stopped"]
    assert bench.control.processes.processes == ()


def test_a_start_that_is_refused_shows_its_number() -> None:
    bench = Bench().types("MODE", "10.1", "ENTER")

    def refuses(name: str) -> Process:
        raise ProcessFault(ALREADY_EXISTS, name)

    bench.control.start = refuses
    assert bench.types("ENTER").lines[2] == "PICK 1051"


def test_global_factors_are_typed_in_their_modes() -> None:
    bench = Bench().types("MODE", "11.4", "ENTER")
    assert bench.lines[:2] == ["11.4 VFACTOR", "1.000"]
    bench.types("0.25")
    assert bench.lines[3] == "=0.25"
    assert bench.types("ENTER").lines[1:] == ["0.250", "done", ""]
    assert bench.types("1.01", "ENTER").lines[1:3] == ["0.250", "0 to 1.0"]
    assert bench.types("0..1", "ENTER").lines[1:3] == ["0.250", "0 to 1.0"]
    bench.types("MODE", "0.11.6", "ENTER", "0.5", "ENTER")
    assert bench.control.factors == Factors(0.25, 1.0, 0.5)


def test_a_reset_is_asked_for_and_the_mode_not_entered_before_it_is_granted() -> None:
    bench = Bench().types("MODE", "11.1", "ENTER")
    assert bench.panel.reset_wanted and bench.selection.mode == "0"
    bench.panel.reset_wanted = False
    bench.panel.refuse("not the owner")
    bench.step(200)
    assert bench.lines[2] == "not the owner"
    bench.panel.enter((11, 1))
    bench.step()
    assert bench.lines[:3] == ["11.1 Reset", "done", ""]
    assert not bench.types("MODE", "0", "ENTER").panel.reset_wanted


@pytest.mark.requirement("RHO-PHG-12", by="gateway.pure.controllers.rho3.pendant.panel:Panel._open_info")
def test_info_shows_why_and_goes_back_to_where_it_was_called() -> None:
    bench = Bench().types("MODE", "1", "ENTER")
    bench.control.holding = {Condition.NO_CONTROL_ALLOW, Condition.NOT_REFERENCED, Condition.FEED_HOLD}
    bench.types("INFO")
    assert bench.lines == ["INFO", "no reference points", "FEED HOLD", ""]
    assert bench.types("DOWN").lines[1:3] == ["FEED HOLD", "CONTRL.ALLOW n.avail"]
    assert bench.types("LEFT").lines[0] == "1 Reference points" and bench.selection.mode == "1"
    bench.control.holding = set()
    assert bench.types("INFO").lines[1] == "No info available"


@pytest.mark.requirement("RHO-PHG-13", by="gateway.pure.controllers.rho3.pendant.panel:Panel._write")
def test_standard_operation_is_below_info_and_coded_text_and_what_is_let_go_stays_until_there_is_news() -> None:
    bench = Bench().types("MODE", "7.1", "ENTER")
    assert bench.lines[0] == "7.1 Axis display", "standard operation writes its lines"
    bench.display.hold(Layer.CODED)
    bench.display.write(Layer.CODED, 2, "PLEASE LOAD")
    bench.control.places[0] = ("A1", "mm", 14.0)
    bench.step(200)
    assert bench.lines[1] == "PLEASE LOAD"
    bench.types("INFO")
    assert bench.lines[0] == "INFO" and bench.lines[1] == "PLEASE LOAD", "coded text over INFO"
    bench.types("LEFT")
    bench.display.release(Layer.CODED)
    bench.step(200)
    bench.step(200)
    assert bench.lines[1] == "PLEASE LOAD", "let go, and nothing new"
    bench.control.places[0] = ("A1", "mm", 15.0)
    bench.step(200)
    assert "15.000" in bench.lines[1]


def test_keys_wait_while_the_plc_has_the_display_and_count_afterwards() -> None:
    bench = Bench()
    bench.display.disable(True)
    bench.types("MODE", "7.1", "ENTER")
    assert (bench.selection.mode, bench.display.read()) == ("0", "MODE"), "a program reads them first"
    bench.display.disable(False)
    bench.types("ENTER")
    assert bench.selection.mode == "7.1", "7.1 ENTER is still there for the system; digits without MODE are an entry too"


def test_modes_without_a_function_say_so_in_both_languages() -> None:
    assert Bench().types("MODE", "9.4.3", "ENTER").lines[:2] == ["9.4.3 Print file lis", "no function here"]
    assert Bench("de").types("MODE", "9.4.3", "ENTER").lines[1] == "hier ohne Funktion"
    assert Bench("de").lines == ["Grundebene", "Automatik", "", ""]


def test_a_mode_the_plc_selects_takes_the_entry_away() -> None:
    bench = Bench().types("MODE", "7.3")
    bench.selection.mode = "7.1"
    bench.step()
    assert bench.lines == ["7.1 Axis display", "A1        12.500 mm", "A2        -3.000 mm", ""]
