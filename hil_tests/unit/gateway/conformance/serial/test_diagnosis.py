"""Each diagnosis with a partner or a line that has that very fault; and what an S5 or a CP 341 shows, in words."""

import re
from dataclasses import replace

import pytest

from gateway.conformance.serial.partners import Late, Station, make
from gateway.links.serial.tool_wire import VirtualWire
from gateway.pure.lines.diagnosis import Evidence, Finding, anzw, cp341, judge, pafe
from gateway.tools.line.diagnose import OWN_BLOCKS, gather
from gateway.tools.line.ports import open_wire
from protocols.base.machine import ms
from protocols.p3964r.profiles import RHO3, Priority


def diagnosed(partner: str, priority: str = "low") -> dict[str, Finding]:
    seen = gather(lambda line_format: open_wire(f"sim:{partner}", line_format), "9600 8E1", RHO3, priority)
    return {finding.name: finding for finding in judge(seen)}


@pytest.mark.parametrize(
    "partner, name, level, words",
    [
        ("good", "RK512", "ok", "RK512 runs on 3964R"),
        ("raw", "raw 3964R", "ok", "no reaction telegram"),
        ("echo", "echo", "fault", "every character is returned (16 of 16)"),
        ("cross-talk", "cross-talk", "fault", "cross-talk on an open line, not an echo"),
        ("inverted", "wires crossed", "fault", "polarity"),
        ("speed-4800", "wrong speed", "fault", "the partner answers at 4800 8E1, not at 9600 8E1"),
        ("parity-odd", "wrong parity or frame", "fault", "the partner answers at 9600 8O1"),
        ("latency-16ms", "USB latency timer", "warn", "as through a USB adapter whose latency timer is set to 16 ms"),
        ("silent", "partner silent", "fault", "nothing answers at 9600 8E1"),
        ("slow-3s", "partner slow", "fault", "STX is answered with DLE after 3.0 s: later than"),
        ("includes-stx", "BCC off by 02h", "fault", "begins the exclusive or with STX"),
        ("counts-once", "BCC counts 10h once", "fault", "counts a doubled 10h once"),
        ("naks-conflicts", "refuses conflicts", "warn", "answers a conflicting STX with NAK"),
        ("good,rho3,low", "same priority", "fault", "both stations have the same priority (low)"),
        ("good", "priority", "ok", "the partner has priority high, this side low"),
    ],
)
def test_the_fault_is_named_and_no_other_beside_it(partner: str, name: str, level: str, words: str) -> None:
    found = diagnosed(partner)
    assert name in found, found
    assert found[name].level == level
    assert words in found[name].text
    assert {other for other, finding in found.items() if finding.level == "fault"} <= {name}


def test_both_high_is_the_same_priority_too() -> None:
    assert diagnosed("good", "high")["same priority"].todo == 'set this side to priority = "low"'


def test_no_retry_after_a_fault_hides_the_line() -> None:
    assert diagnosed("echo").keys() == {"echo"}


def test_a_partner_of_3964_without_check() -> None:
    seen = Evidence(answers={"9600 8E1": [0x10]}, checks={"right": 0x15, "none": 0x10})
    assert "3964 without R" in {finding.name for finding in judge(seen)}


def seen_of(station: Station) -> dict[str, Finding]:
    seen = gather(lambda line_format: VirtualWire(station, 11_000_000_000 // 9600), "9600 8E1", RHO3, "low")
    return {finding.name: finding for finding in judge(seen)}


@pytest.mark.parametrize("priority", list(Priority))
def test_a_partner_that_sends_by_itself_is_no_cross_talk(priority: Priority) -> None:
    """Its STX came back for the pattern: "0 right and 0 damaged" of 16."""
    station = make("good", RHO3, priority)
    for number in range(OWN_BLOCKS + 3):
        station.stimulate(0, b"U" + bytes((number,)))
    found = seen_of(station)
    assert re.fullmatch(r"blocks that the partner sent unprompted were acknowledged and not used: \d+", found["line in use"].text)
    assert "RK512" in found and "cross-talk" not in found
    assert ("same priority" in found) is (priority is Priority.LOW)


def test_a_partner_of_3964_that_takes_the_end_for_the_end() -> None:
    """It acknowledges at DLE ETX, so a block with a check is acknowledged as well; no number is made up for its reaction."""
    found = seen_of(make("good", replace(RHO3, block_check=False), Priority.HIGH))
    assert found["3964 without R"].text == "blocks are taken without their check: the partner is set to 3964"
    assert not {"RK512", "reaction spoilt"} & found.keys()


def test_a_slow_partner_within_qvz_is_looked_at_to_the_end() -> None:
    assert seen_of(Late(RHO3, Priority.HIGH, late=ms(200)))["RK512"].text == "RK512 runs on 3964R, it answered 14h"


def test_characters_that_are_no_echo_are_shown() -> None:
    seen = Evidence(pattern=b"UZ3fLqwE", returned=[0x3F, 0x0D], answers={"9600 8E1": [0x10]})
    (found,) = [one for one in judge(seen) if one.name == "other characters"]
    assert (found.level, found.text) == ("note", "8 characters without a meaning were answered with others: 3F 0D")
    assert [one.level for one in judge(replace(seen, answers={"9600 8E1": []}))] == ["fault"]


def test_a_reaction_that_is_spoilt_is_a_fault_with_its_reason() -> None:
    seen = Evidence(answers={"9600 8E1": [0x10]}, checks={"right": 0x10}, spoilt="block check 55h, expected 13h")
    assert [one.text for one in judge(seen) if one.level == "fault"] == [
        "the reaction to a FETCH is no good block: block check 55h, expected 13h"
    ]


def test_a_partner_that_is_not_ready() -> None:
    assert {finding.name for finding in judge(Evidence(answers={"9600 8E1": [0x15]}))} == {"not ready"}


def test_something_that_is_no_3964r() -> None:
    found = judge(Evidence(answers={"9600 8E1": [0x3F, 0x0D]}))
    assert [finding.name for finding in found] == ["no 3964R"]
    assert "9600 8E1: 3F 0D" in found[0].text


def test_the_system_s_own_word_on_the_latency_timer_is_believed() -> None:
    seen = Evidence(answers={"9600 8E1": [0x10]}, answer_times=[ms(2)], latency_timer_ms=16, latency_file="/sys/x/latency_timer")
    (found,) = [finding for finding in judge(seen) if finding.name == "USB latency timer"]
    assert found.todo == "echo 1 | sudo tee /sys/x/latency_timer"
    seen.latency_timer_ms = 1
    assert not [finding for finding in judge(seen) if finding.name == "USB latency timer"]


def test_pafe_in_words() -> None:
    assert pafe(0x00).level == "ok"
    assert pafe(0x81).text.startswith("interface not ready")
    assert pafe(0x21).text.startswith("area does not exist")
    assert "does not acknowledge" in pafe(0xC1).text


def test_anzw_bit_by_bit() -> None:
    assert [finding.name for finding in anzw(0x0004)] == ["ANZW bit 2"]
    found = anzw(0x0308)
    assert [finding.name for finding in found] == ["ANZW bit 3", "ANZW error 3h"]
    assert found[1].text == "area too short"
    assert anzw(0)[0].text.startswith("no bit is set")
    assert "error of the CP" in anzw(0x0908)[1].text


@pytest.mark.parametrize(
    "event, level, words",
    [
        ((7, 0x0C), "fault", "both stations have priority low"),
        ((7, 0x03), "fault", "QVZ/ADT"),
        ((8, 0x06), "fault", "ZVZ/CDT exceeded"),
        ((8, 0x08), "fault", "BCC"),
        ((9, 0x09), "fault", "coordination flag"),
        ((10, 0x05), "fault", "no reaction"),
        ((8, 0x02), "note", "normal when the partner is switched on"),
        ((10, 0x01), "note", "normal after a restart"),
        ((12, 0x01), "note", "not in the table"),
    ],
)
def test_cp_341_events_in_words_and_normal_ones_are_not_red(event: tuple[int, int], level: str, words: str) -> None:
    found = cp341(*event)
    assert found.level == level
    assert words in found.text
