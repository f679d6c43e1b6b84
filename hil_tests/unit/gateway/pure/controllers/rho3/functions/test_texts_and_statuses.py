"""Coded text output and machine status display on the panel."""

import pytest

from gateway.pure.controllers.rho3.functions.display import Layer
from gateway.pure.image.records.cell import Quality
from hil_tests.unit.gateway.pure.controllers.rho3.functions.plant import CYCLE, P9, Plant, settings
from protocols.base.machine import ms

STROBE, OFF, OK, ERROR = 85, 35, 108, 109
HALF = P9 // CYCLE
MSD_ON, MSD_OPEN, STATUS_1 = 60, 115, 464


def text(plant: Plant, code: int) -> Plant:
    """The PLC's order: number, then strobe, until the answer is over."""
    return plant.number(104, 8, code).put(STROBE).cycle()


@pytest.mark.requirement(
    "RHO-PLC-05",
    by=(
        "gateway.pure.controllers.rho3.functions.coded_texts:CodedTexts.step",
        "gateway.pure.controllers.rho3.functions.coded_texts:CodedTexts._show",
    ),
)
def test_text_01_on_lines_2_and_3_and_a_pulse_of_p9() -> None:
    plant = Plant()
    text(plant, 1)
    assert plant.screen() == ["", "This text is forty", "characters, not long", ""]
    assert plant.outs(OK, ERROR) == [OK]
    assert plant.pulses(OK, 3 * HALF) == [(1, HALF - 1, 1), (0, 2 * HALF + 1, 1)]
    assert plant.outs(OK, ERROR) == [], "one order, one answer, though the strobe still stands"


@pytest.mark.requirement(
    "RHO-PLC-05",
    by=("gateway.pure.controllers.rho3.functions.addresses:Pulse.step", "gateway.pure.controllers.rho3.functions.addresses:Edge.step"),
)
def test_missing_file_gives_the_error_strobe() -> None:
    plant = Plant(settings(texts=None))
    text(plant, 1)
    assert plant.outs(OK, ERROR) == [ERROR] and plant.screen() == [""] * 4
    assert plant.pulses(ERROR, 3 * HALF) == [(1, HALF - 1, 1), (0, 2 * HALF + 1, 1)]
    assert plant.refused == ["no_file"]


@pytest.mark.parametrize("why", ["channel_busy", "channel_off", "no_code"])
def test_occupied_or_absent_panel_and_unknown_number(why: str) -> None:
    plant = Plant()
    plant.panel_ready = why != "channel_off"
    if why == "channel_busy":
        plant.display.hold(Layer.WRITE)
        plant.display.write(Layer.WRITE, 2, "a program asks")
    before = plant.screen()
    text(plant, 9 if why == "no_code" else 1)
    assert plant.outs(OK, ERROR) == [ERROR] and plant.refused == [why] and plant.screen() == before


@pytest.mark.requirement("RHO-PLC-06", by="gateway.pure.controllers.rho3.functions.coded_texts:CodedTexts._show")
def test_a_text_over_40_characters_is_cut_on_the_display() -> None:
    plant = Plant()
    text(plant, 255)
    assert plant.screen() == ["", "01234567890123456789", "01234567890123456789", ""]
    plant.put(STROBE, False).cycle(2 * HALF)
    text(plant, 2)
    assert plant.screen() == ["", "short", "", ""]


def test_a_text_stays_against_the_system_while_strobe_or_bit_35_is_set() -> None:
    plant = Plant()
    plant.put(OFF).cycle()
    text(plant, 2)
    plant.put(STROBE, False).cycle(20)
    plant.display.write(Layer.STANDARD, 2, "axis 1   17.000")
    plant.cycle()
    assert plant.screen()[1] == "short"
    plant.put(OFF, False).cycle()
    assert plant.screen()[1] == "axis 1   17.000"
    text(plant, 2)
    plant.display.write(Layer.STANDARD, 2, "axis 1   18.000")
    assert plant.cycle().screen()[1] == "short"
    plant.put(STROBE, False).cycle()
    plant.display.write(Layer.STANDARD, 2, "axis 1   18.000")
    assert plant.screen()[1] == "axis 1   18.000"


def test_orders_faster_than_their_answers_keep_p9_between_the_pulses() -> None:
    plant = Plant()
    text(plant, 2)
    plant.put(STROBE, False).cycle().put(STROBE).cycle()
    assert plant.pulses(OK, 4 * HALF) == [(1, HALF - 3, 1), (0, HALF, 1), (1, HALF, 1), (0, HALF + 3, 1)]


def test_a_strobe_that_is_set_at_the_start_or_after_a_lost_source_starts_nothing() -> None:
    plant = Plant(started=False)
    text(plant, 1)
    assert plant.outs(OK, ERROR) == []
    plant.put(STROBE, False).cycle()
    plant.inputs.quality[STROBE >> 3] = Quality.STALE
    plant.put(STROBE).cycle()
    plant.inputs.quality[STROBE >> 3] = Quality.GOOD
    plant.cycle(3)
    assert plant.outs(OK, ERROR) == []
    plant.put(STROBE, False).cycle().put(STROBE).cycle()
    assert plant.outs(OK, ERROR) == [OK]


# ---------------------------------------------------------------------------------------------------- machine status display


def opened(plant: Plant, code: int) -> Plant:
    """The PLC opens mode 7.12.1 or 7.12.2."""
    return plant.number(56, 4, code).put(49).cycle()


@pytest.mark.requirement(
    "RHO-PLC-03",
    by=(
        "gateway.pure.controllers.rho3.functions.status_display:StatusDisplay.step",
        "gateway.pure.controllers.rho3.functions.status_display:StatusDisplay._show",
    ),
)
def test_status_8_is_shown_in_mode_7_12_1_and_bit_115_is_set_while_it_is_open() -> None:
    plant = Plant()
    plant.put(STATUS_1 + 7).cycle()
    assert plant.screen() == [""] * 4 and not plant.out(MSD_OPEN)
    opened(plant, 5)
    assert plant.screen() == ["Machine statuses", "08 this is a long te", "", ""]
    plant.cycle(100)
    assert plant.out(MSD_OPEN)
    plant.number(56, 4, 0).put(49, False).cycle()
    assert not plant.out(MSD_OPEN)


@pytest.mark.requirement("RHO-PLC-03", by="gateway.pure.controllers.rho3.functions.status_display:StatusDisplay.step")
def test_bit_60_shows_msd_in_line_4() -> None:
    plant = Plant()
    plant.display.write(Layer.STANDARD, 4, "Mode =")
    plant.put(MSD_ON).cycle()
    assert plant.screen()[3] == "Mode =           MSD"
    plant.put(MSD_ON, False).cycle()
    assert plant.screen()[3] == "Mode ="


@pytest.mark.requirement(
    "RHO-PLC-03",
    by=(
        "gateway.pure.controllers.rho3.functions.status_display:StatusDisplay.scroll",
        "gateway.pure.controllers.rho3.functions.status_display:StatusDisplay._turn",
    ),
)
def test_scrolling_by_hand_goes_forward_in_a_ring() -> None:
    plant = Plant()
    for number in (1, 8, 99, 50):  # 50 has no text
        plant.put(STATUS_1 + number - 1)
    opened(plant, 5)
    pages = []
    for _ in range(4):
        pages.append([line[:2] for line in plant.screen()[1:3]])
        plant.functions.statuses.scroll()
        plant.cycle()
    assert pages == [["01", "08"], ["08", "99"], ["99", "01"], ["01", "08"]]
    plant.put(STATUS_1 + 7, False).cycle()
    assert [line[:2] for line in plant.screen()[1:3]] == ["99", "01"], "a status that went away makes room for the next"


def test_automatic_display_turns_every_second_until_a_key() -> None:
    plant = Plant()
    for number in (1, 8, 99):
        plant.put(STATUS_1 + number - 1)
    opened(plant, 6)
    shown = []
    for _ in range(3):
        shown.append(plant.screen()[1][:2])
        plant.wait(ms(1000))
    assert shown == ["01", "08", "99"]
    plant.functions.statuses.scroll()
    assert plant.screen()[1][:2] == "01" and plant.out(MSD_OPEN)
    plant.wait(ms(1400))
    assert plant.screen()[1][:2] == "01"


def test_missing_file_and_no_status() -> None:
    plant = opened(Plant(settings(msd=None)), 5)
    assert plant.screen()[1] == "MSD.DAT not found" and plant.out(MSD_OPEN)
    assert opened(Plant(), 5).screen()[1] == "no status active"
    assert opened(Plant(settings(language="de")), 5).screen()[0] == "Maschinenzustaende"
