"""A host that is late: what is only seen then is not a FAIL; what is the same each time is one."""

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import pytest

from gateway.conformance.framework import base
from gateway.conformance.framework.result import Result
from gateway.conformance.framework.run import Runner
from gateway.conformance.peers.stations import Built
from gateway.conformance.suites.line import LineSetup, LineTester
from gateway.links.serial.tool_wire import Heard, VirtualWire
from gateway.pure.conformance.purpose import Purpose
from gateway.pure.conformance.verdict import Fail, Verdict
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.profiles import RHO3, Priority


class Late(base.Tester):
    """Held up by so much in every case."""

    def __init__(self, late: Ns) -> None:
        super().__init__()
        self._late = late

    def late(self) -> Ns:
        return self._late


@dataclass
class Session:
    tester: base.Tester
    assumed: list[str] = field(default_factory=list)

    def discover(self) -> Mapping[str, object]:
        return {}

    def self_check(self) -> Mapping[str, object]:
        return {}

    def begin(self, clean: bool) -> None:
        """Nothing is to be made idle."""

    def alive(self) -> None:
        """It is."""

    def now(self) -> Ns:
        return 0

    def close(self) -> None:
        """Nothing is held."""


def played(late: Ns, body: Callable[[base.Tester], None]) -> Result:
    purpose = Purpose("X_BV_01", "server", "one", "eins", "1", body)
    (result,) = Runner(Session(Late(late)), [purpose]).run()
    return result


def says(answers: Iterator[str]) -> Callable[[base.Tester], None]:
    def body(t: base.Tester) -> None:
        said = next(answers)
        if said:
            raise Fail(f"said {said}", "nothing", said)

    return body


def test_the_same_wrong_answer_in_each_try_is_a_fail_of_the_device() -> None:
    result = played(ms(30), says(itertools.repeat("0F 00")))
    assert (result.verdict, result.reason, result.got) == (Verdict.FAIL, "said 0F 00", "0F 00")
    assert "late in each of 3 tries" in " ".join(result.notes.remarks)


@pytest.mark.parametrize(
    "late, answers, verdict",
    [
        (ms(30), ["a", "b", "a"], Verdict.INCONC),
        (ms(400), ["a", "a", "a"], Verdict.INCONC),
        (ms(30), ["a", ""], Verdict.PASS),
        (ms(60), ["NAK (15h)"] * 3, Verdict.INCONC),
        (ms(30), ["NAK (15h)"] * 3, Verdict.FAIL),
    ],
    ids=["each-time-another", "far-too-late", "not-again", "a-time-that-ran-out", "hardly-late"],
)
def test_what_a_late_host_can_explain_is_none(late: Ns, answers: list[str], verdict: Verdict) -> None:
    assert played(late, says(iter(answers))).verdict is verdict


class Busy(Session):
    """A host on which the device cannot be reached for a while."""

    vain = 0

    def alive(self) -> None:
        if self.vain:
            self.vain -= 1
            raise Fail("nothing is answered", "an answer", "NAK (15h)")


def leaves_it_busy(session: Busy, vain: int) -> Callable[[base.Tester], None]:
    def body(t: base.Tester) -> None:
        session.vain = vain

    return body


@pytest.mark.parametrize("late, verdict", [(ms(60), Verdict.PASS), (0, Verdict.INCONC)], ids=["late", "in-time"])
def test_a_device_that_a_late_host_hid_for_a_while_is_found_again(late: Ns, verdict: Verdict) -> None:
    """Thirty-five cases were not run because a station had not been reached nine times on a host that was very late."""
    session = Busy(Late(late))
    session.alive()
    first: Purpose[base.Tester] = Purpose("X_BV_01", "server", "one", "eins", "1", lambda t: None)
    second = Purpose("X_BV_02", "server", "two", "zwei", "1", leaves_it_busy(session, 30))
    others: list[Purpose[base.Tester]] = [
        Purpose(f"X_BV_{number:02}", "server", "more", "mehr", "1", lambda t: None) for number in range(3, 12)
    ]
    results = Runner(session, [first, second, *others]).run()
    assert results[-1].verdict is verdict


def prepares(answers: Iterator[str]) -> Callable[[base.Tester], None]:
    said = says(answers)

    def body(t: base.Tester) -> None:
        with t.given():
            said(t)

    return body


@pytest.mark.parametrize("late, verdict", [(ms(50), Verdict.PASS), (0, Verdict.WARN)], ids=["late", "in-time"])
def test_a_preparing_step_that_a_late_host_can_explain_is_tried_again(late: Ns, verdict: Verdict) -> None:
    assert played(late, prepares(iter(["nothing", ""]))).verdict is verdict


def test_what_rests_on_a_case_whose_time_lies_across_its_limit_is_run() -> None:
    def across(t: base.Tester) -> None:
        t.timed("NAK after silence", ms(225), ms(199), ms(241))

    first = Purpose("X_TI_01", "receiver", "one", "eins", "1", across)
    second = Purpose("X_TI_02", "receiver", "two", "zwei", "1", says(iter([""])), preamble=("X_TI_01",))
    results = Runner(Session(Late(ms(40))), [first, second]).run()
    assert [result.verdict for result in results] == [Verdict.INCONC, Verdict.PASS]


class HeldUp(VirtualWire):
    """A wire in real time whose host is held up within the wait for an answer."""

    simulated = False

    def hear(self, until: Ns) -> Heard | None:
        heard = super().hear(until)
        self.late_ns = ms(200)
        return heard


@pytest.mark.parametrize("pause, comes", [(ms(420), True), (ms(700), False)])
def test_a_wait_in_which_the_host_was_late_goes_on_by_as_much(pause: Ns, comes: bool) -> None:
    """By as much, and no longer."""
    station = Built(replace(RHO3, retry_pause=pause))
    wire = HeldUp(station, ms(1))
    tester = LineTester(wire, LineSetup(RHO3, Priority.LOW, lambda t: wire.act(station.stimulate)))
    tester.starts_sending()
    wire.late_ns = 0
    tester.say(b"\x15")
    if comes:
        assert tester.expect(Char.STX, ms(250), "NAK to STX") >= pause
        return
    with pytest.raises(Fail, match="after NAK to STX: nothing"):
        tester.expect(Char.STX, ms(250), "NAK to STX")
