"""Coded error output: groups, parity, strobes of P9, sequences, re-issue, static system errors, 64 errors."""

from collections.abc import Hashable

import pytest

from gateway.pure.controllers.rho3.functions.addresses import even, number_at
from gateway.pure.controllers.rho3.functions.coded_errors import group, group_text
from gateway.pure.image.error_list import Reset
from hil_tests.unit.gateway.pure.controllers.rho3.functions.plant import CYCLE, P9, Plant

STROBE, PARITY, CODE = 118, 119, 152
HALF = P9 // CYCLE  # cycles of one level


def report(plant: Plant, code: int, where: str = "MAIN", reset: Reset = Reset.ACKNOWLEDGE) -> None:
    assert plant.errors.report(code, where, plant.now, source="rho3", reset=reset) is True


def code(plant: Plant) -> int:
    return number_at(plant.outputs, CODE, 16)


def codes(plant: Plant, cycles: int) -> list[int]:
    """Codes in the order their strobes begin; each strobe has to last P9 and the pause behind it P9."""
    levels = plant.pulses(STROBE, cycles, lambda: code(plant))
    for position, (level, length, _) in enumerate(levels[:-1]):
        assert (level == 0 and position == 0) or length == HALF, levels
    return [shown for level, _, shown in levels if level]


@pytest.mark.requirement(
    "RHO-PLC-07",
    by=(
        "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors.step",
        "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors._write",
    ),
)
def test_error_91_is_shown_with_its_strobe_for_p9() -> None:
    plant = Plant()
    report(plant, 91)
    assert plant.pulses(STROBE, 3 * HALF, lambda: code(plant)) == [(1, HALF, 0x005B), (0, 2 * HALF, 0)]


@pytest.mark.requirement(
    "RHO-PLC-07",
    by=(
        "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors._over",
        "gateway.pure.controllers.rho3.functions.coded_errors:code_of",
    ),
)
def test_strobe_is_low_for_p9_before_the_next_code() -> None:
    plant = Plant()
    report(plant, 91)
    report(plant, 528, "")
    report(plant, 1408, "axis 1")
    levels = plant.pulses(STROBE, 7 * HALF, lambda: code(plant))
    assert levels[:-1] == [(1, HALF, 91), (0, HALF, 0), (1, HALF, 528), (0, HALF, 0), (1, HALF, 1408)]


@pytest.mark.requirement(
    "RHO-PLC-08",
    by=(
        "gateway.pure.controllers.rho3.functions.addresses:even",
        "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors._write",
    ),
)
def test_parity_is_even_over_16_bits() -> None:
    for number in (0x5B, 0x0F, 0x210, 0xFFF, 0x801, 3716):
        plant = Plant()
        report(plant, number)
        plant.cycle()
        assert code(plant) == number and plant.out(STROBE)
        assert plant.out(PARITY) is (bin(number).count("1") % 2 == 1)
    assert even(0x5B) is True and even(0x8000) is True and even(0x8001) is False


@pytest.mark.requirement("RHO-PLC-09", by="gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors._learn")
def test_a_second_error_repeats_both_codes_and_reset_ends_it() -> None:
    plant = Plant()
    report(plant, 528, "", Reset.CONTROL_RESET)
    assert codes(plant, 4 * HALF) == [528]
    report(plant, 928, "axis 1", Reset.CONTROL_RESET)
    assert codes(plant, 8 * HALF) == [528, 928]
    plant.errors.acknowledge(Reset.CONTROL_RESET)
    report(plant, 91)
    assert codes(plant, 8 * HALF) == [528, 928, 91], "their causes stand: the reset clears nothing"
    plant.errors.gone(528, "", "rho3")
    plant.errors.gone(928, "axis 1", "rho3")
    plant.errors.acknowledge(Reset.CONTROL_RESET)
    report(plant, 92)
    assert codes(plant, 8 * HALF) == [91, 92]


def test_an_error_while_another_one_is_shown_waits_for_the_pause_and_repeats_it() -> None:
    plant = Plant()
    report(plant, 528)
    plant.cycle(HALF // 2)
    report(plant, 928)
    levels = plant.pulses(STROBE, 8 * HALF, lambda: code(plant))
    assert [(level, shown) for level, _, shown in levels if level] == [(1, 528), (1, 528), (1, 928)]
    assert levels[0][1] == HALF - HALF // 2 and levels[1] == (0, HALF, 0)


def test_reset_in_the_middle_of_a_sequence_ends_it() -> None:
    plant = Plant()
    for number in (10, 11, 12):
        report(plant, number)
        plant.errors.gone(number, "MAIN", "rho3")
    plant.cycle(2)
    plant.errors.acknowledge(Reset.ACKNOWLEDGE)
    assert plant.pulses(STROBE, 8 * HALF, lambda: code(plant)) == [(1, HALF - 2, 10), (0, 7 * HALF + 2, 0)]
    report(plant, 10)
    assert codes(plant, 4 * HALF) == [10], "come again it is shown again"


@pytest.mark.requirement(
    "RHO-PLC-10",
    by=("gateway.pure.controllers.rho3.functions.coded_errors:group", "gateway.pure.controllers.rho3.functions.coded_errors:group_text"),
)
def test_groups_of_the_manual() -> None:
    assert [group(number) for number in (528, 1408, 3716)] == [2, 5, 14]
    borders = {
        1: 0,
        255: 0,
        256: 1,
        511: 1,
        512: 2,
        767: 2,
        768: 3,
        1023: 3,
        1024: 4,
        1279: 4,
        1280: 5,
        1535: 5,
        1536: 6,
        3327: 12,
        3328: 13,
    }
    borders |= {3583: 13, 3584: 14, 3839: 14, 3840: 15, 4095: 15}
    assert {number: group(number) for number in borders} == borders
    assert [group(number) for number in (0, -1, 4096, 65535)] == [None] * 4
    assert group_text(2, "en") == "P2 cycle, measuring system, travel limit, emergency stop"
    assert "nicht belegt" not in {group_text(number, "de") for number in (*range(6), *range(13, 16))}
    assert group_text(5, "de") == "Warnungen" and {group_text(number, "de") for number in range(6, 13)} == {"nicht belegt"}


@pytest.mark.requirement(
    "RHO-PLC-11",
    by=(
        "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors._over",
        "gateway.pure.controllers.rho3.functions.plc:Functions.press",
    ),
)
def test_the_strobe_of_a_system_error_is_set_until_a_key() -> None:
    plant = Plant()
    report(plant, 3716, "", Reset.RESTART)
    report(plant, 91)
    assert plant.pulses(STROBE, 50 * HALF, lambda: code(plant)) == [(1, 50 * HALF, 3716)]
    plant.functions.press("7")
    levels = plant.pulses(STROBE, 4 * HALF, lambda: code(plant))
    assert levels == [(0, HALF, 0), (1, HALF, 91), (0, 2 * HALF, 0)]


@pytest.mark.requirement(
    "RHO-PLC-11",
    by=("gateway.pure.image.error_list:ErrorList.report", "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors.step"),
)
def test_only_a_restart_acknowledges_a_system_error() -> None:
    plant = Plant()
    report(plant, 3732, "", Reset.RESTART)
    plant.errors.gone(3732, "", "rho3")
    plant.errors.acknowledge(Reset.CONTROL_RESET)
    assert [record.code for record in plant.errors.records] == [3732]
    plant.wait(2 * P9)
    plant.functions.press("1")
    plant.wait(3 * P9)
    report(plant, 91)
    plant.wait(5 * P9)
    assert (plant.out(STROBE), code(plant)) == (True, 3732), "with the next error it is issued again, and stands again"
    plant.errors.acknowledge(Reset.RESTART)
    assert [record.code for record in plant.errors.records] == [91]


@pytest.mark.requirement(
    "RHO-PLC-12",
    by=("gateway.pure.image.error_list:ErrorList.report", "gateway.pure.controllers.rho3.functions.coded_errors:CodedErrors._learn"),
)
def test_of_65_errors_64_are_stored_and_shown_in_order() -> None:
    plant = Plant()
    for number in range(1, 65):
        report(plant, number)
    assert plant.errors.report(65, "MAIN", plant.now, source="rho3") is False
    assert len(plant.errors.records) == 64 and plant.errors.lost == 1
    assert codes(plant, 130 * HALF) == list(range(1, 65))


def test_errors_without_a_code_of_the_rho_3_are_not_shown() -> None:
    plant = Plant()
    plant.errors.report(91, "x", plant.now, source="axisgate")
    plant.errors.report(4096, "x", plant.now, source="rho3")
    assert codes(plant, 4 * HALF) == []


def test_a_key_before_p9_is_over_counts_and_one_before_the_code_does_not() -> None:
    plant = Plant()
    plant.functions.press("1")
    plant.cycle()
    report(plant, 3716, "", Reset.RESTART)
    plant.cycle(3 * HALF)
    assert plant.out(STROBE)
    report(plant, 3732, "", Reset.RESTART)
    plant.functions.press("1")
    plant.cycle(2 * HALF)
    assert (plant.out(STROBE), code(plant)) == (True, 3716), "all once more, from the first"
    plant.functions.press("1")
    plant.cycle(HALF + 2)
    assert (plant.out(STROBE), code(plant)) == (True, 3732)
    plant.functions.press("2")
    levels = plant.pulses(STROBE, 3 * HALF, lambda: code(plant))
    assert levels == [(1, HALF - 2, 3732), (0, 2 * HALF + 2, 0)], "a key within P9 ends it with P9"


def test_errors_of_another_list_are_shown_by_their_codes() -> None:
    plant = Plant()
    shown: list[int] = []
    for count in range(8 * HALF):
        plant.functions.coded.show({number: number for number in (91, 528)}, plant.outputs, count * CYCLE)
        shown += [code(plant)] if plant.out(STROBE) else []
    assert shown == [91] * HALF + [528] * HALF


def test_an_error_that_goes_repeats_nothing_and_one_that_comes_again_does() -> None:
    plant = Plant()
    coded = plant.functions.coded
    standing: dict[Hashable, int] = {10: 10, 11: 11}
    shown: list[int] = []

    def run(cycles: int) -> list[int]:
        shown.clear()
        for _ in range(cycles):
            plant.now += CYCLE
            coded.show(standing, plant.outputs, plant.now)
            if plant.out(STROBE) and (not shown or shown[-1] != code(plant)):
                shown.append(code(plant))
        return list(shown)

    assert run(6 * HALF) == [10, 11]
    del standing[10]
    assert run(6 * HALF) == []
    standing[10] = 10
    assert run(6 * HALF) == [11, 10]
