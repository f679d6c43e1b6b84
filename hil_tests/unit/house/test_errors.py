"""The catalogue of errors against lists made by hand from the manuals, and against every text the code itself says."""

import re

import pytest

from drivers.drives.cia402_words import GERMAN
from drivers.drives.servodyn_download import TEXTS as PARAMETERS
from drivers.drives.servodyn_words import FAULTS
from gateway.files.error_catalogue import catalogue, explain, lookup
from gateway.pure.controllers.reis.regulator import TEXTS as REGULATOR
from gateway.pure.controllers.rho3.can.messages import FIRST_NUMBER
from gateway.pure.controllers.rho3.signals.codes import CAUSES, EMERGENCY_STOP, PLC_SILENT, code_text
from gateway.pure.controllers.rho3.signals.errors import RESETS, kind_of
from gateway.pure.image.error_entries import CatalogueError, Entry, family_of
from gateway.pure.image.reasons import Reason, text
from gateway.pure.lines.diagnosis import CP341_EVENTS
from motion.files.errors import TEXTS as MOVE_FILE
from motion.sync.errors import TEXTS as BELTS
from motion.val3.errors import TEXTS as VAL3
from protocols.canopen.emcy import MEANINGS
from protocols.p3964r.events import Failure, Refusal
from protocols.rk512.header import ErrorNumber


def span(first: int, last: int) -> list[int]:
    return list(range(first, last + 1))


# Read out of the manuals by hand, chapter by chapter; line numbers of the texts at hand.
RHO3_CODED = [
    *(20, 23),  # belts of types 2 and 3, L6114, L6326
    *(38, 63, *span(95, 102)),  # MOVE_FILE, L7144, L7202-7212
    *(89, 90, 91, 92, 93),  # belts and path recording, L5255, L5319, L6077, L6081, L6127
    *span(380, 381),  # CAN at run time, L7504-7527
    528,  # L6112
    *(*span(928, 937), *span(944, 953)),  # belts, by kinematic, L6113-6128
    *(1051, 1057, 1073, 1079, 1085, 1092, 1112),  # START of special function 4, L5862-5873
    *span(1408, 1427),  # disabled axes, L7941
    *(3716, 3732, 3733, 3734),  # CAN at start-up, L7485-7500
    *(3583 + 22, 3583 + 23, 3583 + 39, 3583 + 83, 3583 + 300),  # system errors, L743, L7848, L11435, L11436
]
REIS_SERVO = [number for number in span(643, 684) if number != 655]  # L4692-4744
REIS_PATH = [6, 102, 105, 504, 505, 611, *span(615, 625), 706, 810, 811, 903]  # L4753-4770
REIS_TRAFO = [
    *(*span(1, 15), 50, 51, *span(101, 115), 150, 151),  # L3834-3876
    *(*span(201, 206), 301, 302, 401, 402, 403, *span(501, 507)),  # L3877-3903
]
VAL3_RUN_TIME = [
    *(-1, 10, 11, 20, 21, 23, 25, 29, 30, 31, 32, 33, 34, 40, 41, 45, 60, 61, 70, 71, 80, 81, 82, 90),  # L6611-6636; 0 and 1 are none
    *(*span(100, 106), *span(122, 126), 150, 153, 154, *span(160, 165), 170, 171, 250, 270, 271, 290, 301),  # L6637-6666, L3687
    *(513, 514, 515, 520, 525, *span(530, 536), *span(540, 544), *span(550, 554)),  # L6667-6688
    *(*span(560, 565), *span(570, 574), 580, 581, 582, 590, 600, 610, 611, 999),  # L6689-6710
]
MANUALS = {  # manual -> number space -> (numbers, how many)
    "rho 3": {
        "rho3": (RHO3_CODED, 76),
        "rho3-condition": (span(-11, -1), 11),  # L2213-2226
        "rho3-command": (span(-7, -1), 7),  # L5841-5855
        "rho3-convert": (span(-7, -1), 7),  # L2284-2421
        "rho3-select": ([*span(1, 5), 11, 12, 13], 8),  # L10800-10807
        "rho3-pc": ([2, 152], 2),  # L3229-3243
    },
    "ROBOTstar V": {
        "reis-servo": (REIS_SERVO, 41),
        "reis-path": (REIS_PATH, 21),
        "reis-trafo": (REIS_TRAFO, 52),
        "reis-plc": ([7000, 7001, 7003, 7004], 4),  # L2801-2821
        "reis": ([1052, 4017], 2),  # L2243, L209-211
    },
    "VAL 3": {
        "val3": (VAL3_RUN_TIME, 93),
        "val3-io": (span(-3, -1), 3),  # L2385-2414
        "val3-sio": (span(-5, -1), 5),  # L2769-2778
        "val3-alter": (span(-3, -1), 3),  # L6355-6456
        "val3-library": ([*span(10, 14), *span(20, 24), *span(30, 48)], 29),  # L3970-4006
    },
}
TOTALS = {"rho 3": 111, "ROBOTstar V": 120, "VAL 3": 133}


@pytest.mark.parametrize("manual", MANUALS)
def test_every_number_of_a_manual_is_in_the_catalogue_and_no_other(manual: str) -> None:
    for family, (numbers, count) in MANUALS[manual].items():
        printed = {number for number, entry in catalogue()[family].entries.items() if not entry.ours}
        assert len(numbers) == len(set(numbers)) == count, family
        assert (set(numbers) - printed, printed - set(numbers)) == (set(), set()), family
    assert sum(count for _, count in MANUALS[manual].values()) == TOTALS[manual]


def test_the_catalogue_has_no_number_space_nobody_counted() -> None:
    counted = {family for families in MANUALS.values() for family in families}
    assert set(catalogue()) - counted == {"axisgate", "rk512", "3964r", "servodyn", "cia402"}


def entries() -> list[Entry]:
    return [entry for family in catalogue().values() for entry in family.entries.values()]


def test_every_entry_says_all_there_is_to_say_in_both_languages() -> None:
    for entry in entries():
        for words in (entry.text, entry.cause, entry.todo, entry.shown, entry.reset_words()):
            assert len(words.en) > 3 and len(words.de) > 3, entry
            assert not re.search(r"\{\w\}|see the text|siehe Text", words.en + words.de), entry
        assert entry.source, entry
        assert entry.text.de != entry.text.en or entry.number in (250, 251, 646, 664, 666, 3716) or len(entry.text.en) < 40, entry


def test_german_is_written_as_everywhere_in_the_project() -> None:
    assert [
        entry.number for entry in entries() if re.search("[äöüÄÖÜß]", entry.text.de + entry.cause.de + entry.todo.de + entry.shown.de)
    ] == []


# ---- the code says nothing else


def test_reasons_of_the_status_block_are_those_of_the_catalogue() -> None:
    for reason in Reason:
        if reason:
            entry = lookup("axisgate", reason)
            assert entry is not None, reason
            listed = tuple(re.sub(r"\[[^]]*\]", "..", words) for words in (entry.text.en, entry.text.de))  # a placeholder names its detail
            assert listed == (text(reason, "en", ".."), text(reason, "de", "..")), reason
            assert not re.search(r"[^0-9]\.\.", entry.text.en + entry.text.de), reason
    assert set(catalogue()["axisgate"].entries) == set(map(int, Reason)) - {0}


def test_coded_errors_of_the_interface_are_those_of_the_catalogue() -> None:
    ours = {number for number, entry in catalogue()["rho3"].entries.items() if entry.ours}
    assert {*CAUSES.values(), PLC_SILENT} <= ours
    for number in (*ours, EMERGENCY_STOP):
        entry = lookup("rho3", number)
        assert entry is not None
        assert (code_text(number, "en").replace(",", ""), code_text(number, "de")) == (entry.text.en.replace(",", ""), entry.text.de), (
            number
        )


def test_reset_rules_of_the_rho_3_are_those_of_its_groups() -> None:
    for number, entry in catalogue()["rho3"].entries.items():
        assert entry.reset == RESETS[kind_of(number)].name.lower(), number


def test_belts_and_move_file_say_what_the_catalogue_says() -> None:
    for number, said in {**BELTS, **MOVE_FILE}.items():
        entry = lookup("rho3", number)
        assert entry is not None
        assert entry.text.en.split(", kinematic")[0].replace("MOD flag not init.", "MOD-Flag n. init.") == said, number
    assert lookup("rho3", FIRST_NUMBER) is not None and lookup("rho3", FIRST_NUMBER + 1) is not None


def test_regulator_errors_of_the_reis_are_those_of_the_catalogue() -> None:
    assert {number: entry.text.en for number, entry in catalogue()["reis-servo"].entries.items()} == dict(REGULATOR)


def test_run_time_errors_of_val_3_are_those_of_the_catalogue() -> None:
    for number, said in VAL3.items():
        entry = lookup("val3", number)
        assert entry is not None and entry.text.en == said, number


def test_drive_faults_are_those_of_the_catalogue() -> None:
    said = {code: (row.what.english, row.what.german, row.todo.english, row.todo.german) for code, row in FAULTS.items()}
    listed = catalogue()["servodyn"].entries
    assert {code: (e.text.en, e.text.de, e.todo.en, e.todo.de) for code, e in listed.items()} == said
    old = {row.number for row in FAULTS.values() if row.number} | {number for number, _, _ in PARAMETERS.values() if number}
    assert [number for number in sorted(old) if lookup("reis-servo", number) is None] == []
    assert {code: e.text.en for code, e in catalogue()["cia402"].entries.items()} == {c: m for c, m in MEANINGS.items() if c}
    for code, german in GERMAN.items():
        entry = lookup("cia402", code)
        assert code == 0 or (entry is not None and entry.text.de == german), code


def test_every_fault_of_a_line_is_in_the_catalogue_with_what_the_partner_logs() -> None:
    assert set(catalogue()["rk512"].entries) == {int(number) for number in ErrorNumber if number}
    for fault, first in ((Refusal, 1), (Failure, 11)):
        for place, member in enumerate(fault):
            entry = lookup("3964r", first + place)
            assert entry is not None and entry.text.en.startswith(member.name) and entry.text.de.startswith(member.name), member
    named = [
        (int(group), int(number, 16))
        for family in ("rk512", "3964r")
        for entry in catalogue()[family].entries.values()
        for group, number in re.findall(r"\((\d\d)\)([0-9A-F]{2})h", entry.shown.en + entry.shown.de)
    ]
    assert len(named) > 60 and [event for event in named if event not in CP341_EVENTS] == []


# ---- finding and reading


@pytest.mark.parametrize(
    ("key", "found"),
    [
        ("647", [("reis-servo", 647)]),
        ("reis 647", [("reis-servo", 647)]),
        ("regulator 647", [("reis-servo", 647)]),
        ("20", [("axisgate", 20), ("rho3", 20), ("val3", 20), ("val3-library", 20), ("rk512", 20)]),
        ("rho3 20", [("rho3", 20)]),
        ("rk512 14h", [("rk512", 20)]),
        ("reis trafo 102", [("reis-trafo", 102)]),
        ("reis 102", [("reis-path", 102), ("reis-trafo", 102)]),
        ("System Error 133", [("rho3", 3716)]),
        ("cia402 0x8611", [("cia402", 0x8611)]),
        ("rho3-condition -3", [("rho3-condition", -3)]),
        ("Schleppabstand", [("reis-servo", 647), ("servodyn", 3)]),
        ("nobody 647", []),
        ("65000", []),
        ("", []),
    ],
)
def test_an_error_is_found_by_number_by_world_and_by_words(key: str, found: list[tuple[str, int]]) -> None:
    assert [(entry.family, entry.number) for entry in explain(key)] == found


def test_a_range_names_each_of_its_numbers() -> None:
    entry = lookup("rho3", 930)
    assert entry is not None
    assert (entry.text.en, "930 on RC outputs" in entry.shown.en) == ("wrong belt direction, kinematic 3", True)


GOOD = {"family": "x", "title": ["a", "b"], "default": {key: ["a", "b"] for key in ("cause", "todo", "shown")} | {"reset": "itself"}}


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ({"number": 1, "text": ["only English"]}, "x 1: text"),
        ({"number": 1, "text": ["a", "b"], "reset": "never"}, "x 1: reset = 'never'"),
        ({"text": ["a", "b"]}, "without number"),
    ],
)
def test_a_table_that_is_wrong_is_named(row: dict[str, object], said: str) -> None:
    with pytest.raises(CatalogueError, match=said):
        family_of({**GOOD, "error": [row]})
    with pytest.raises(CatalogueError, match="x 7: defined twice"):
        family_of({**GOOD, "error": [{"number": 7, "text": ["a", "b"]}] * 2})
