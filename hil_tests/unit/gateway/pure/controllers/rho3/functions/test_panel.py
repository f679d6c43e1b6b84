"""Selection of panel functions by code, display layers, save and restore, key buffer."""

import pytest

from gateway.pure.controllers.rho3.functions.addresses import number_at
from gateway.pure.controllers.rho3.functions.display import KEYS, Display, Layer
from hil_tests.unit.gateway.pure.controllers.rho3.functions.plant import Plant, settings

OFF, STROBE, CODE, BASE, ERROR_CODE = 35, 49, 56, 104, 152


def select(plant: Plant, code: int) -> Plant:
    return plant.put(STROBE, False).cycle().number(CODE, 4, code).cycle().put(STROBE).cycle()


def back(plant: Plant) -> Plant:
    """Code 0 and the falling edge."""
    return plant.number(CODE, 4, 0).cycle().put(STROBE, False).cycle()


@pytest.mark.requirement(
    "RHO-PLC-19",
    by=(
        "gateway.pure.controllers.rho3.functions.phg_selection:PhgSelection.step",
        "gateway.pure.controllers.rho3.functions.phg_selection:PhgSelection._select",
    ),
)
def test_code_4_selects_mode_7_1_from_the_basic_level() -> None:
    plant = Plant()
    plant.number(CODE, 4, 4).cycle(3)
    assert (plant.out(BASE), plant.functions.phg.mode) == (True, "0"), "no strobe, no selection"
    plant.put(STROBE).cycle()
    assert (plant.out(BASE), plant.functions.phg.mode) == (False, "7.1")


@pytest.mark.requirement(
    "RHO-PLC-19",
    by=(
        "gateway.pure.controllers.rho3.functions.phg_selection:PhgSelection._go",
        "gateway.pure.controllers.rho3.functions.addresses:Edge.step",
    ),
)
def test_code_0_and_the_falling_edge_lead_back_and_only_the_basic_level_selects() -> None:
    plant = select(Plant(), 4)
    select(plant, 5)
    assert plant.functions.phg.mode == "7.1", "not at the basic level: ignored"
    plant.put(STROBE, False).cycle()
    assert plant.functions.phg.mode == "7.1", "falling edge with code 5"
    plant.put(STROBE).cycle()
    back(plant)
    assert (plant.out(BASE), plant.functions.phg.mode) == (True, "0")
    assert select(plant, 5).functions.phg.mode == "7.12.1"


def test_without_option_41_nothing_is_selected() -> None:
    plant = select(Plant(settings(phg_option=False)), 4)
    assert (plant.out(BASE), plant.functions.phg.mode) == (True, "0")


@pytest.mark.requirement(
    "RHO-PLC-20",
    by=(
        "gateway.pure.controllers.rho3.functions.phg_selection:PhgSelection._select",
        "gateway.pure.controllers.rho3.functions.plc:Functions._report",
    ),
)
@pytest.mark.parametrize("code", [0xB, 0xC])  # no line; a line that is wrong
def test_code_without_a_usable_line(code: int) -> None:
    plant = select(Plant(), code)
    assert plant.screen()[1] == "Error in PHGCODE.DAT"
    assert (plant.out(118), number_at(plant.outputs, ERROR_CODE, 16)) == (True, 1278)
    assert plant.functions.phg.mode == "0"
    plant.cycle(30)
    assert [record.count for record in plant.errors.records] == [1]
    assert select(plant, 4).functions.phg.mode == "7.1", "the good lines are used all the same"
    assert plant.screen()[1] == ""


def test_code_0_needs_no_line_and_a_missing_file_is_the_same_error() -> None:
    of = settings(language="de")
    of.modes = None
    plant = select(Plant(of), 0)
    assert plant.screen() == [""] * 4
    assert select(plant, 4).screen()[1] == "Fehler PHGKODE.DAT"


# ------------------------------------------------------------------------------------------------------------- the layers


@pytest.mark.requirement(
    "RHO-PHG-13",
    by=("gateway.pure.controllers.rho3.functions.display:Display.write", "gateway.pure.controllers.rho3.functions.display:Display.screen"),
)
def test_test_message_over_write_phg_over_coded_text_over_info_over_standard() -> None:
    display = Display()
    for layer in (Layer.WRITE, Layer.STANDARD, Layer.TEST, Layer.INFO, Layer.CODED):  # in no order of theirs
        display.hold(layer)
        display.write(layer, 2, layer.name)
    shown = []
    for layer in Layer:
        screen = display.screen()
        shown.append(screen[1].rstrip() if screen else "")
        display.close(layer)
    assert shown == ["TEST", "WRITE", "CODED", "INFO", "STANDARD"]
    assert display.screen() == (" " * 20,) * 4


@pytest.mark.requirement(
    "RHO-PHG-13",
    by=("gateway.pure.controllers.rho3.functions.display:Display._uncover", "gateway.pure.controllers.rho3.functions.display:Display.hold"),
)
def test_what_is_held_stays_what_was_let_go_is_overwritten_from_below() -> None:
    display = Display()
    display.hold(Layer.WRITE)
    display.write(Layer.WRITE, 3, "question")
    display.write(Layer.STANDARD, 3, "axis 1")
    assert display.screen()[2].rstrip() == "question"
    display.release(Layer.WRITE)
    assert display.screen()[2].rstrip() == "question"
    display.write(Layer.STANDARD, 3, "axis 1")
    assert display.screen()[2].rstrip() == "axis 1"


# --------------------------------------------------------------------------------------------------------- save and restore


def talking() -> Plant:
    """The panel shows an axis; the PLC takes the display, a program writes on all four lines."""
    plant = Plant()
    for line, text in enumerate(("Axes", "1   10.000", "2   20.000", "Mode ="), 1):
        plant.display.write(Layer.STANDARD, line, text)
    plant.put(OFF).cycle()
    plant.display.hold(Layer.WRITE)
    for line in range(1, 5):
        plant.display.write(Layer.WRITE, line, f"message {line}")
    assert plant.screen() == [f"message {line}" for line in range(1, 5)]
    plant.display.release(Layer.WRITE)
    return plant


@pytest.mark.requirement(
    "RHO-PLC-21",
    by=(
        "gateway.pure.controllers.rho3.functions.display:Display.disable",
        "gateway.pure.controllers.rho3.functions.display:Display._give_back",
    ),
)
def test_falling_edge_of_bit_35_restores_what_the_rising_one_saved() -> None:
    plant = talking()
    plant.cycle(50)
    assert plant.screen()[1] == "message 2"
    plant.put(OFF, False).cycle()
    assert plant.screen() == ["Axes", "1   10.000", "2   20.000", "Mode ="]


@pytest.mark.requirement(
    "RHO-PLC-21",
    by=(
        "gateway.pure.controllers.rho3.functions.display:Display.selected",
        "gateway.pure.controllers.rho3.functions.display:Display.disable",
    ),
)
def test_a_selection_in_between_suppresses_it_and_shows_the_new_function() -> None:
    plant = talking()
    plant.put(464).number(CODE, 4, 5).put(STROBE).cycle(3)
    assert plant.functions.phg.mode == "7.12.1"
    assert plant.screen()[1] == "message 2"
    plant.put(OFF, False).cycle()
    assert plant.screen() == ["Machine statuses", "01 first status", "", "message 4"], "line 4 is nobody's: nothing is restored"


def test_a_dynamic_display_shows_its_newest_values_at_once() -> None:
    plant = talking()
    plant.display.write(Layer.STANDARD, 2, "1   11.000")
    assert plant.screen()[1] == "message 2"
    plant.put(OFF, False).cycle()
    assert plant.screen() == ["Axes", "1   11.000", "2   20.000", "Mode ="]


def test_system_messages_stay_off_lines_2_and_3_only() -> None:
    plant = Plant()
    plant.display.write(Layer.STANDARD, 2, "before")
    plant.put(OFF).cycle()
    for line in range(1, 5):
        plant.display.write(Layer.INFO, line, "system")
    assert plant.screen() == ["system", "before", "", "system"]


# ----------------------------------------------------------------------------------------------------------------- keys


@pytest.mark.requirement(
    "RHO-PLC-22",
    by=(
        "gateway.pure.controllers.rho3.functions.display:Display.read",
        "gateway.pure.controllers.rho3.functions.display:Display.system_key",
    ),
)
def test_keys_pressed_while_disabled_are_read_by_read_phg_in_order() -> None:
    plant = Plant()
    plant.put(OFF).cycle()
    for key in "1230":
        plant.functions.press(key)
    plant.cycle()
    assert plant.display.system_key() is None, "the system does not meddle"
    assert [plant.display.read() for _ in range(3)] == ["1", "2", "3"]
    plant.put(OFF, False).cycle()
    assert plant.display.system_key() == "0", "what is left is the system's"
    assert plant.display.read() is None


@pytest.mark.requirement(
    "RHO-PLC-22",
    by=("gateway.pure.controllers.rho3.functions.plc:Functions.press", "gateway.pure.controllers.rho3.functions.display:Display.read"),
)
def test_keys_typed_before_a_process_reads_wait_for_it_and_the_system_gets_none_of_them() -> None:
    """L6715-6717: entered in advance with DIS_PHGM_RCI = 1, even where no process is at its READ PHG yet."""
    plant = Plant()
    plant.functions.press("A")
    assert plant.display.system_key() == "A", "before: a key is the system's at once"
    plant.put(OFF).cycle()
    for key in "12":
        plant.functions.press(key)
        plant.cycle(5)
        assert plant.display.system_key() is None
    got = [plant.display.read()]  # the process starts late, reads, and the operator types on
    plant.functions.press("3")
    plant.cycle()
    got += [plant.display.read(), plant.display.read(), plant.display.read()]
    assert got == ["1", "2", "3", None]
    plant.functions.press("4")
    plant.functions.press("5")
    plant.put(OFF, False).cycle()
    assert [plant.display.system_key() for _ in range(3)] == ["4", "5", None], "enabled again: the system reads what is left, in order"


@pytest.mark.requirement("RHO-PLC-22", by="gateway.pure.controllers.rho3.functions.display:Display.press")
def test_keys_are_bounded_and_read_begin_forgets_them() -> None:
    display = Display()
    for number in range(KEYS + 3):
        display.press(str(number))
    assert display.lost_keys == 3
    assert display.read() == "0"
    display.read_begin()
    assert display.read() is None


@pytest.mark.parametrize("line", [0, 5, -1])
def test_lines_that_are_none(line: int) -> None:
    with pytest.raises(ValueError, match="1 to 4"):
        Display().write(Layer.INFO, line, "x")


def shown(display: Display) -> list[str]:
    return [line.rstrip() for line in display.screen()]


def covered() -> Display:
    """Standard text under one a program let go."""
    display = Display()
    display.write(Layer.STANDARD, 2, "standard")
    display.hold(Layer.WRITE)
    display.write(Layer.WRITE, 2, "message")
    display.release(Layer.WRITE)
    display.disable(True)
    return display


def test_the_system_that_repeats_itself_uncovers_nothing_but_something_new_does_at_the_end() -> None:
    display = covered()
    display.write(Layer.STANDARD, 2, "standard")
    display.disable(False)
    assert shown(display)[1] == "message"
    display.disable(True)
    display.write(Layer.INFO, 2, "info")
    assert shown(display)[1] == "message"
    display.disable(False)
    assert shown(display)[1] == "info"


def test_a_selected_function_shows_also_what_was_there_before() -> None:
    display = covered()
    display.selected()
    display.write(Layer.STANDARD, 2, "standard")
    display.disable(False)
    assert shown(display)[1] == "standard"


def test_each_saving_begins_anew() -> None:
    display = covered()
    display.selected()
    display.write(Layer.STANDARD, 2, "selected")
    display.disable(False)
    display.disable(True)
    display.write(Layer.WRITE, 2, "question")
    display.disable(False)
    assert shown(display)[1] == "selected", "nothing was selected or written by the system this time"


def test_a_layer_does_not_occupy_the_panel_for_itself() -> None:
    display = Display()
    display.hold(Layer.CODED)
    assert not display.occupied(Layer.CODED) and display.occupied(Layer.INFO) and not display.occupied(Layer.WRITE)


def test_what_the_system_wrote_under_an_earlier_saving_does_not_count_again() -> None:
    display = covered()
    display.write(Layer.STANDARD, 2, "newer")
    display.disable(False)
    display.hold(Layer.WRITE)
    display.write(Layer.WRITE, 2, "second message")
    display.release(Layer.WRITE)
    display.disable(True)
    display.disable(False)
    assert shown(display)[1] == "second message"
