"""Each diagnosis with a partner or a line that has that very fault; and what an S5 or a CP 341 shows, in words."""

import pytest

from gateway.pure.lines.diagnosis import Evidence, Finding, anzw, cp341, judge, pafe
from gateway.tools.line.diagnose import gather
from gateway.tools.line.ports import open_wire
from protocols.base.machine import ms
from protocols.p3964r.profiles import RHO3


def diagnosed(partner: str, priority: str = "low") -> dict[str, Finding]:
    seen = gather(lambda line_format: open_wire(f"sim:{partner}", line_format), "9600 8E1", RHO3, priority)
    return {finding.name: finding for finding in judge(seen)}


@pytest.mark.parametrize(
    "partner, name, level, words",
    [
        ("good", "RK512", "ok", "RK512 rides on 3964R"),
        ("raw", "raw 3964R", "ok", "no reaction telegram"),
        ("echo", "echo", "fault", "every character comes back (16 of 16)"),
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
        ("good", "priority", "ok", "the partner has priority high, we low"),
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
