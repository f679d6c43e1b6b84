"""The probe against stations of ours in virtual time: the good one passes the whole list, each hostile one fails where its fault is."""

import dataclasses
import json
from collections.abc import Sequence

import pytest

from gateway.conformance.report import BANNER, TEXT, as_dict, to_html, to_json
from gateway.conformance.serial.cases_rk512 import Place
from gateway.conformance.serial.partners import Blocks, Late, Station, make
from gateway.conformance.serial.run import Result, Settings, all_cases, conclusion, counted, exit_code, probe
from gateway.links.serial.tool_wire import Heard, VirtualWire
from hil_tests.lab.partners.rk512_active import ActiveStation
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.profiles import PROFILES, RHO3, Priority, Profile

CHAR = 11_000_000_000 // 9600
PLACE = Place(words=128, write=True)


def probed(partner: str, profile: Profile = RHO3, priority: Priority = Priority.LOW, *only: str) -> dict[str, Result]:
    wire = VirtualWire(make(partner, profile, priority), CHAR)
    layer = "raw" if partner == "raw" else "rk512"
    return {result.case.name: result for result in probe(wire, Settings(profile, priority, layer, place=PLACE, only=only))}


def fails(results: dict[str, Result]) -> set[str]:
    return {name for name, result in results.items() if result.verdict == "FAIL"}


def told(results: dict[str, Result]) -> dict[str, str]:
    return {name: f"{result.verdict}: {result.reason}" for name, result in results.items() if result.verdict != "PASS"}


@pytest.mark.parametrize("priority", Priority)
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_our_passive_station_passes_the_whole_list_in_every_profile(profile: Profile, priority: Priority) -> None:
    results = probed("good", profile, priority)
    assert not told(results).keys() - {"rk512.follow-on-258", "send.just-too-late"}, told(results)
    assert len(results) >= 78
    assert exit_code(list(results.values())) == 0


def test_a_raw_station_passes_without_the_rk512_part() -> None:
    results = probed("raw")
    assert told(results) == {}
    assert not any(name.startswith("rk512") for name in results)


def test_a_station_without_block_check_is_not_asked_for_one() -> None:
    results = probed("good", RHO3.plain())
    checks = "gap-before-check wrong-check check-once check-with-stx check-missing check-10 check-15 check-02 check-03 parity-in-check"
    not_run = {name for name, text in told(results).items() if name.startswith(("receive", "idle")) and text.startswith("NOT RUN")}
    assert not_run == {f"receive.{name}" for name in checks.split()}
    assert fails(results) == set()


HOSTILE = {
    "no-nak": (
        {"idle.full", "receive.gap-after-stx", "receive.wrong-check", "receive.seven-bad", "send.silent", "send.nak-to-stx"},
        {"receive.length-1", "send.good", "rk512.fetch", "conflict.first"},
    ),
    "drops-its-job": ({"conflict.first", "conflict.in-repeat", "conflict.rounds"}, {"send.silent", "receive.wrong-check", "rk512.fetch"}),
    "slow-21ms": (
        {"idle.full", "receive.gap-after-stx", "receive.gap-in-data", "send.silent", "send.just-too-late", "send.silence-after-block"},
        {"receive.wrong-check", "send.nak-to-stx", "conflict.first", "rk512.send"},
    ),
    "naks-conflicts": ({"conflict.first", "conflict.in-repeat", "conflict.rounds"}, {"send.silent", "receive.seven-bad", "rk512.fetch"}),
    "two-attempts": (
        {"send.silent", "send.nak-to-stx", "send.other-to-stx", "send.damaged-to-stx", "send.all-blocks-refused"},
        {"receive.seven-bad", "conflict.first", "rk512.fetch", "send.just-too-late"},
    ),
    "includes-stx": ({"receive.check-with-stx", "receive.length-1", "send.good", "rk512.fetch"}, {"receive.gap-in-data", "send.silent"}),
    "counts-once": (
        {"receive.check-once", "receive.doubled-dle", "rk512.header-with-10h", "rk512.wrong-byte-1"},
        {"receive.wrong-check", "receive.all-dle", "send.good", "rk512.fetch"},
    ),
    "bad-partner": (
        {"receive.check-once", "receive.doubled-dle", "send.silent", "send.nak-to-stx"},
        {"receive.gap-in-data", "conflict.first", "rk512.fetch"},
    ),
}


@pytest.mark.parametrize("partner", HOSTILE)
def test_a_hostile_partner_fails_where_its_fault_is_and_nowhere_else(partner: str) -> None:
    results = probed(partner)
    must, must_not = HOSTILE[partner]
    assert must <= fails(results), told(results)
    assert not fails(results) & must_not, told(results)
    assert exit_code(list(results.values())) == 1


def test_a_silent_partner_answers_nothing() -> None:
    results = probed("silent")
    received = {name: result for name, result in results.items() if name.startswith("receive")}
    assert fails(received) == received.keys()
    assert results["receive.length-1"].reason == "after STX: nothing, expected DLE within 550 ms"
    assert results["send.good"].verdict == "INCONCLUSIVE"  # whether it had a job cannot be known


@pytest.mark.parametrize(
    "partner, name, reason",
    [
        ("two-attempts", "send.nak-to-stx", "2 connection attempts when STX is answered with NAK, expected 6"),
        ("no-nak", "send.silent", "after the last attempt: nothing, expected NAK when it gives up"),
        ("slow-21ms", "receive.gap-in-data", "NAK after silence in the data: 242.1 ms, expected 220 ms, tolerance 21.1 ms"),
        ("drops-its-job", "conflict.first", "after our block it must send its own job: nothing, its job is lost"),
        ("naks-conflicts", "conflict.first", "it refuses a conflicting STX"),
        ("counts-once", "rk512.wrong-byte-1", "the station counts a doubled DLE once"),
        ("includes-stx", "send.good", "off by 02h, the station includes STX"),
    ],
)
def test_the_reason_names_the_fault(partner: str, name: str, reason: str) -> None:
    assert reason in probed(partner, RHO3, Priority.LOW, name)[name].reason


def test_twenty_milliseconds_late_is_within_the_tolerance() -> None:
    wire = VirtualWire(Late(RHO3, Priority.LOW, late=ms(19)), CHAR)
    results = probe(wire, Settings(RHO3, Priority.LOW, only=("receive.gap-in-data",)))
    assert [result.verdict for result in results] == ["PASS"]


def test_times_and_characters_are_measured() -> None:
    result = probed("good", RHO3, Priority.LOW, "send.silent")["send.silent"]
    measured = [round(time.ns / 1e6, 1) for time in result.notes.times if time.what.startswith("STX")]
    assert measured == [551.1] * 5  # QVZ and one character
    report = as_dict([result], Settings(RHO3, Priority.LOW), "sim:good", "9600 8E1", "now", True, {})
    tests = report["tests"]
    assert isinstance(tests, list)
    assert tests[0]["characters"] == {"us": 0, "station": 7}  # six STX and the NAK
    assert tests[0]["wire"] == "< 02 02 02 02 02 02 15"


class HeldUp(VirtualWire):
    """This program itself stands still for 25 ms in every wait."""

    def hear(self, until: Ns) -> Heard | None:
        self.late_ns = ms(25)
        return super().hear(until)


def test_a_late_bench_is_inconclusive_not_a_verdict() -> None:
    wire = HeldUp(make("two-attempts", RHO3, Priority.LOW), CHAR)
    results = probe(wire, Settings(RHO3, Priority.LOW, only=("send.nak-to-stx", "receive.length-1")))
    assert {result.verdict for result in results} == {"INCONCLUSIVE"}
    assert "the bench itself was 25 ms late" in results[0].reason


def test_without_a_stimulus_sending_is_not_run() -> None:
    wire = VirtualWire(make("good", RHO3, Priority.LOW), CHAR)
    results = probe(wire, Settings(RHO3, Priority.LOW, stimulus="none", only=("send", "receive.length-1")))
    assert counted(results) == {"PASS": 1, "FAIL": 0, "WARN": 0, "INCONCLUSIVE": 0, "NOT RUN": len(results) - 1}


@pytest.mark.parametrize("priority", Priority)
def test_fetch_makes_a_passive_station_send(priority: Priority) -> None:
    wire = VirtualWire(make("good", RHO3, priority), CHAR)
    results = probe(wire, Settings(RHO3, priority, stimulus="fetch", only=("send", "conflict")))
    assert {result.case.name: result.reason for result in results if result.verdict != "PASS"} == {}
    assert len(results) >= 17


def test_writing_needs_permission() -> None:
    wire = VirtualWire(make("good", RHO3, Priority.LOW), CHAR)
    (result,) = probe(wire, Settings(RHO3, Priority.LOW, place=dataclasses.replace(PLACE, write=False), only=("rk512.send",)))
    assert result.verdict == "NOT RUN"


class Active(ActiveStation):
    """A job whenever it is stimulated."""

    def stimulate(self, now: Ns) -> None:
        self.fetch(10, 0, 4, now)


def test_an_active_station_survives_every_wrong_reaction() -> None:
    station = Active(profile=RHO3)
    wire = VirtualWire(station, CHAR)
    settings = Settings(RHO3, Priority.HIGH, stimulus="operator", active=True, only=("active",))
    results = probe(wire, settings, lambda: wire.act(station.stimulate))
    assert {result.case.name: f"{result.verdict} {result.reason}" for result in results if result.verdict != "PASS"} == {}
    assert len(results) == 7


class Mute(Active):
    """Asks once and never again: an active station that hangs after a wrong reaction."""

    def stimulate(self, now: Ns) -> None:
        if not self.counts["BlockSent"]:
            super().stimulate(now)


def test_an_active_station_that_hangs_is_found() -> None:
    station = Mute(profile=RHO3)
    wire = VirtualWire(station, CHAR)
    settings = Settings(RHO3, Priority.HIGH, stimulus="operator", active=True, only=("active.error-number",))
    (result,) = probe(wire, settings, lambda: wire.act(station.stimulate))
    assert result.verdict == "INCONCLUSIVE"
    assert "the job after that" in result.reason


def test_the_report_is_complete_and_self_contained() -> None:
    results = list(probed("bad-partner").values())
    report = as_dict(results, Settings(RHO3, Priority.LOW), "sim:bad-partner", "9600 8E1", "2026-11-21", True, {"name": "CW-4 <x>"})
    page = to_html(report)
    assert TEXT in page and BANNER in page
    assert "CW-4 &lt;x&gt;" in page and "CW-4 <x>" not in page
    assert all(result.case.name in page for result in results)
    assert "http" not in page and "<script" not in page and "src=" not in page
    loaded = json.loads(to_json(report))
    assert loaded["counts"]["FAIL"] >= 4
    assert loaded["profile"]["ack_delay_ms (QVZ/ADT)"] == 550.0
    assert loaded["text"] == TEXT


def test_only_takes_names_and_groups() -> None:
    names = [case.name for case in all_cases(Settings(RHO3, Priority.LOW, only=("idle", "send.good")))]
    assert names == ["idle.stray", "idle.nak", "idle.break", "idle.full", "idle.fill", "send.good"]


def test_every_line_of_the_specification_has_its_case() -> None:
    names = {case.name for case in all_cases(Settings(RHO3, Priority.LOW, active=True))}
    assert {f"receive.check-{value}" for value in ("10", "15", "02", "03")} <= names
    assert {f"receive.length-{length}" for length in ("1", "128", "limit", "over")} <= names
    assert {f"rk512.follow-on-{size}" for size in (130, 256, 258)} <= names
    assert {f"rk512.type-{kind}" for kind in "EAMTZX"} <= names
    assert {"send.late-dle", "conflict.same-priority", "receive.repeat-late", "active.never"} <= names


class Listener(Station):
    """Keeps what came spoiled."""

    heard: Sequence[Damage] = ()

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        self.heard = (*self.heard, kind)
        return super().damaged(kind, now)


def test_a_spoiled_character_reaches_the_station_as_one() -> None:
    station = Listener(RHO3, Priority.LOW)
    wire = VirtualWire(station, CHAR)
    assert wire.spoil() and wire.send_break()
    wire.hear(wire.now() + ms(10))
    assert station.heard == (Damage.PARITY, Damage.BREAK)


def probed_with(partner: str, write: bool, *only: str) -> tuple[dict[str, Result], Blocks]:
    station = make(partner, RHO3, Priority.LOW)
    before = bytes(station.blocks.content[10])
    place = dataclasses.replace(PLACE, write=write)
    results = probe(VirtualWire(station, CHAR), Settings(RHO3, Priority.LOW, place=place, only=only))
    assert bytes(station.blocks.content[10]) == before, "what was read is written back"
    return {result.case.name: result for result in results}, station.blocks


def test_a_station_that_never_doubles_dle_fails_once_10h_is_planted() -> None:
    """Without --write its blocks hold no 10h that could tell."""
    results, _ = probed_with("never-doubles", True, "rk512.send-10h")
    assert results["rk512.send-10h"].verdict == "FAIL" and "doubled" in results["rk512.send-10h"].reason, results
    assert probed_with("good", True, "rk512.send-10h")[0]["rk512.send-10h"].verdict == "PASS"
    asked = probed_with("good", False, "rk512.send-10h")[0]["rk512.send-10h"]
    assert (asked.verdict, asked.reason) == ("NOT RUN", "writes into the station; allowed with --write")


@pytest.mark.parametrize(
    ("partner", "only", "begins"),
    [
        ("good", ("rk512",), "Conclusion: the station speaks 3964R and RK512 in all"),
        (
            "never-doubles",
            ("rk512.fetch", "rk512.send-10h"),
            "not comply with 3964R and RK512: 1 of 2 tests fail, the first is rk512.send-10h",
        ),
        ("silent", ("rk512.fetch",), "the station does not speak 3964R and RK512 here: the one test did not pass"),
        ("good", ("rk512.follow-on-258",), "no statement about the station"),
        ("good", ("rk512.fetch", "rk512.follow-on-258"), "the station speaks 3964R and RK512 in the one test that was run."),
        ("good", ("idle.nak", "rk512.follow-on-258"), "the station speaks 3964R in the one test that was run."),
        ("good", ("idle.nak", "idle.break", "rk512.follow-on-258"), "the station speaks 3964R in all 2 tests that were run; not run: 1."),
    ],
)
def test_a_probe_ends_with_one_sentence(partner: str, only: tuple[str, ...], begins: str) -> None:
    settings = Settings(RHO3, Priority.LOW, place=PLACE, only=only)
    results = probe(VirtualWire(make(partner, RHO3, Priority.LOW), CHAR), settings)
    said = conclusion(results, settings)
    assert begins in said and said.startswith("Conclusion: ") and said.endswith(".")
    german = as_dict(results, settings, "sim:x", "9600 8E1", "now", True, {}, "de")
    assert str(german["conclusion"]).startswith("Ergebnis: ") and str(german["conclusion"]) in to_html(german).replace("&#x27;", "'")
