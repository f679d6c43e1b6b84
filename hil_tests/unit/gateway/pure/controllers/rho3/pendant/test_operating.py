"""Direct selection, INFO texts, P35.  Source: rho 3 Releases L2743-2921, L3454-3560, L9166-9202."""

from collections.abc import Callable

import pytest

from gateway.pure.controllers.rho3.pendant.infos import SIGNALS, Condition, conditions_of, infos
from gateway.pure.controllers.rho3.pendant.modes import Mode, select, spoken, up
from gateway.pure.controllers.rho3.pendant.operation import PhgError, PhgMode, operation
from gateway.pure.image.records.cell import Permit

ALL_GOOD = {name: while_off for _, name, while_off in SIGNALS}  # allowances 1, disabling signals 0


def reached(level: Mode, entry: str) -> str:
    return spoken(select(level, entry))


@pytest.mark.requirement("RHO-PHG-11", by="gateway.pure.controllers.rho3.pendant.modes:select")
@pytest.mark.parametrize(
    "level, entry, expected",
    [
        ((), "7.3.2", "7.3.2"),
        ((3, 2), "2.1", "3.2.2.1"),
        ((7, 3, 2), "0", "0"),
        ((7,), "0.11.4", "11.4"),
        ((3, 2, 2, 1), "0.11.4", "11.4"),
        ((), "9.4.10", "9.4"),
        ((), "9.4.1", "9.4.1"),
        ((7,), "11.4", "7"),  # crosswise only through the basic level
        ((), "12", "0"),
        ((7, 3), "0.99", "0"),
    ],
)
def test_direct_selection_goes_as_far_as_the_modes_go(level: Mode, entry: str, expected: str) -> None:
    assert reached(level, entry) == expected


@pytest.mark.parametrize("entry", ["", ".", "7.", ".7", "7..3", "7a", "7,3", "-1", "7.3 ", "²"])
def test_anything_but_digits_and_single_points_leaves_the_level(entry: str) -> None:
    assert reached((3, 2), entry) == "3.2"


def test_cursor_left_goes_one_level_back() -> None:
    assert [up((7, 3, 2)), up((7,)), up(())] == [(7, 3), (), ()]


def holding(**signals: bool) -> set[Condition]:
    values = ALL_GOOD | signals
    found: Callable[[str], bool] = values.__getitem__
    return conditions_of(found, referenced=True, in_position=True)


def shown(mode: Mode, conditions: set[Condition], kinematics: tuple[int, ...] = (), selected: str = "") -> list[str]:
    return infos(mode, conditions, kinematics, selected)


@pytest.mark.requirement("RHO-PHG-12", by="gateway.pure.controllers.rho3.pendant.infos:infos")
def test_mode_1_without_control_enable_says_so() -> None:
    assert shown((1,), holding(CTRL_ALLOW_RCI=False)) == ["CONTRL.ALLOW n.avail"]
    assert shown((1,), holding()) == ["No info available"]
    assert shown((6, 1), holding(CTRL_ALLOW_RCI=False)) == ["No info available"], "mode 6.1 has no such text"
    assert shown((7, 9), holding()) == ["no INFO messages"]
    several = holding(CTRL_ALLOW_RCI=False, TRAVEL_ALLOW_RCI=False)
    both = ["CONTRL.ALLOW n.avail", "TRAVEL ALLOW n.avail"]
    assert shown((1,), several, selected="PORTAL") == both
    assert shown((2,), several, (1, 2), "PORTAL") == ["Kinem.: PORTAL......", *both, "kinematics:", "1;2;"]
    assert shown((2,), {*several, Condition.KEYS_DISABLED}) == [Condition.KEYS_DISABLED.value, *both]


@pytest.mark.requirement("RHO-PHG-12", by="gateway.pure.controllers.rho3.pendant.infos:conditions_of")
@pytest.mark.parametrize(
    "signal, value, text",
    [
        ("FEED_ALLOW_RCI", False, "FEED ALLOW n.avail."),
        ("FEED_HOLD_N_RCI", False, "FEED HOLD"),
        ("TRAVEL_ALLOW_RCI", False, "TRAVEL ALLOW n.avail"),
        ("DRIVE_ON_RCI", False, "DRIVE ON not avail."),
        ("EMERGOP_RCI", True, "emerg.op. without RC"),
        ("DISSER_3_RCI", True, "READ/WR. SER 3 disab"),
        ("DISCOUPL_RCI", True, "Disable coupling PG"),
    ],
)
def test_each_signal_has_its_text(signal: str, value: bool, text: str) -> None:
    conditions = holding(**{signal: value})
    assert shown((1,), conditions) == [text]


@pytest.mark.requirement("RHO-PHG-12", by="gateway.pure.controllers.rho3.pendant.infos:infos")
def test_texts_are_in_the_printed_order_with_the_kinematics_concerned() -> None:
    conditions = holding(CTRL_ALLOW_RCI=False, FEED_HOLD_N_RCI=False) | {Condition.NOT_REFERENCED, Condition.NO_COORDINATES}
    assert shown((2,), conditions, (1, 3), "ROBI_1") == [
        "Kinem.: ROBI_1......",
        "no reference points",
        "Coord. not selected",
        "FEED HOLD",
        "CONTRL.ALLOW n.avail",
        "kinematics:",
        "1;3;",
    ]


def test_every_text_fits_the_panel() -> None:
    assert [condition for condition in Condition if len(condition.value) > 20] == []


def test_axes_and_test_bit_give_conditions() -> None:
    found = conditions_of(ALL_GOOD.__getitem__, referenced=False, in_position=False, test=False)
    assert found == {Condition.NOT_REFERENCED, Condition.NOT_IN_POSITION, Condition.NO_TEST_BIT}


def test_a_feed_input_of_one_kinematic_is_a_condition_as_that_of_all() -> None:
    found = conditions_of(ALL_GOOD.__getitem__, referenced=True, in_position=True, withheld=Permit.RUN | Permit.FEED)
    assert found == {Condition.FEED_HOLD, Condition.NO_FEED_ALLOW}


@pytest.mark.requirement("RHO-PHG-17", by="gateway.pure.controllers.rho3.pendant.operation:operation")
def test_p35_decides_between_4_x_20_characters_and_pixels() -> None:
    old, new, own = operation(1), operation(0), operation(0, display_disabled=True)
    assert None not in (old, new, own)
    assert (old.mode, old.baud, old.lines, old.columns, old.transparent, old.control_leads) == (PhgMode.PHG3, 4800, 4, 20, False, True)
    assert (new.mode, new.baud, new.lines, new.columns, new.pixels, new.control_leads) == (
        PhgMode.TRANSPARENT,
        9600,
        4,
        20,
        (256, 128),
        True,
    )
    assert (own.transparent, own.control_leads) == (True, False), "the pendant's own masks lead when its display is disabled in the PLC"
    assert operation(1, display_disabled=True).control_leads, "a PHG 3 has no masks of its own"


def test_another_p35_is_refused_with_its_range() -> None:
    with pytest.raises(PhgError, match=r"P35 = 2: 0 \(transparent, 9600 baud\) or 1"):
        operation(2)
