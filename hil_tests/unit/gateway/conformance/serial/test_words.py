"""What the line tools say and write: no word that sends its reader the wrong way, nothing written that was not read."""

from dataclasses import replace

import pytest

from gateway.conformance.serial.cases_rk512 import Place
from gateway.conformance.serial.partners import make
from gateway.conformance.serial.run import Settings, all_cases, probe
from gateway.links.serial.line_monitor import Monitor
from gateway.links.serial.tool_wire import VirtualWire
from gateway.pure.lines.decoder import LineReport
from gateway.pure.lines.diagnosis import Evidence, judge
from gateway.pure.lines.learning import draft, is_test, learn
from gateway.tools.line import client as job
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, SIEMENS_CP340, Priority, Profile

CHAR = 11_000_000_000 // 9600


def run(place: Place, *only: str) -> tuple[dict[str, tuple[str, str]], list[bytes]]:
    """Verdicts against the good partner, and the SENDs that reached it."""
    station = make("good", RHO3, Priority.LOW)
    wire = VirtualWire(station, CHAR)
    said: list[int] = []
    write = wire.write

    def note(data: bytes) -> None:
        said.extend(data)
        write(data)

    wire.write = note  # type: ignore[method-assign]  # a tap in the wire
    results = probe(wire, Settings(RHO3, Priority.LOW, place=place, only=only))
    sends = [part for part in bytes(said).split(b"\x02\x00\x00") if part.startswith(b"AD")]
    return {result.case.name: (result.verdict, result.reason) for result in results}, sends


def test_nothing_is_written_that_was_not_read() -> None:
    """DB 77 is not there: its FETCH is refused, so no SEND to it may go out, and least of all one that announces words and has none."""
    verdicts, sends = run(Place(db=77, write=True), "rk512.send")
    assert verdicts["rk512.send"][0] == "NOT RUN" and "00 00 00 14" in verdicts["rk512.send"][1]
    assert sends == []


def test_a_missing_block_that_is_there_is_not_written_into() -> None:
    verdicts, sends = run(Place(missing=10), "rk512")
    for name in ("missing-block-send", "send-too-short", "send-too-long", "send-odd"):
        assert verdicts[f"rk512.{name}"][0] == "NOT RUN" and "--missing-db" in verdicts[f"rk512.{name}"][1]
    assert sends == []
    assert run(Place(), "rk512.missing-block-send")[0]["rk512.missing-block-send"][0] == "PASS"


def test_the_titles_name_the_words_that_are_allowed() -> None:
    titles = {case.name: str(case.title) for case in all_cases(Settings(RHO3, Priority.LOW, place=Place(words=32)))}
    assert titles["rk512.fetch"].startswith("FETCH of one word and of 32 words (64 bytes)")


def test_a_longer_buffer_than_the_profile_s_is_a_warning() -> None:
    def judged(ours: Profile) -> tuple[str, str]:
        (result,) = probe(
            VirtualWire(make("raw", replace(SIEMENS_CP340), Priority.LOW), CHAR),
            Settings(ours, Priority.LOW, "raw", only=("receive.length-over",)),
        )
        return result.verdict, result.reason

    assert judged(RHO3) == ("WARN", "the station takes more than this profile's 138 characters")
    assert judged(SIEMENS_CP340)[0] == "PASS"


def test_one_attempt_is_one() -> None:
    station = make("two-attempts", RHO3, Priority.LOW)
    station.link = Link(replace(RHO3, connect_attempts=1), Priority.LOW)
    results = probe(VirtualWire(station, CHAR), Settings(RHO3, Priority.LOW, only=("send.nak-to-stx",)))
    assert "1 connection attempt when" in results[0].reason, results[0].reason


def test_a_block_too_long_is_no_full_buffer() -> None:
    client = job.Client(VirtualWire(make("raw", replace(RHO3, max_data=40), Priority.HIGH), CHAR), RHO3, Priority.LOW)
    with pytest.raises(job.Refused, match="or its 138 characters are more than the partner accepts"):
        client.send(10, 0, bytes(128))


def test_a_partner_that_polls_has_no_usb_timer() -> None:
    seen = Evidence(answers={"9600 8E1": [0x10]}, answer_times=[ms(20)] * 5, hidden_adapter=False)
    assert [finding.name for finding in judge(seen) if "ms" in finding.text] == ["slow answers"]
    seen.hidden_adapter = True
    assert [finding.name for finding in judge(seen) if "ms" in finding.text] == ["USB latency timer"]


def test_our_own_test_blocks_teach_nothing() -> None:
    def told(data: bytes, side: str, at: Ns) -> LineReport:
        return LineReport(at, side, "BLOCK", "", data, True, first=at)

    fetch, reaction = bytes.fromhex("000045440A000001FFFF"), bytes(4) + b"\x12\x34"
    probing = [told(data, "B", ms(at)) for at, data in enumerate((b"UC", b"U\x10V", b'U !"#', bytes.fromhex("00004544FF000001FFFF")))]
    seen = learn([*probing, told(fetch, "A", ms(100)), told(reaction, "B", ms(120))])
    assert (seen.tests, seen.blocks, seen.active, seen.raw) == (4, 2, "A", [])
    assert "4 test blocks" in draft(seen, "x", 9600, "8E1") and "number  = 10" in draft(seen, "x", 9600, "8E1")
    assert not is_test(b"UP 12 34") and not is_test(b"") and is_test(b"U")


def test_a_monitor_says_that_nothing_comes() -> None:
    moments, now = list[Ns](), [0]

    class Dead:
        name, char_ns = "dead", 0

        def read(self) -> list[bytes | Damage]:
            return []

        def write(self, data: bytes) -> int:
            raise AssertionError("a monitor writes nothing")

        def unsent(self) -> int:
            return 0

        def wait(self, seconds: float) -> None:
            now[0] += ms(20)

        def spoil(self) -> bool:
            return False

        def send_break(self) -> bool:
            return False

        def close(self) -> None:
            pass

    Monitor([("A", Dead())], lambda: now[0], lambda told: None).run(ms(12_000), moments.append)
    assert moments == [ms(5000), ms(10_000), ms(12_000)]
