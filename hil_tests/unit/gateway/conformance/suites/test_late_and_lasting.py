"""Modbus servers with one fault that many cases meet: refusals without the top bit, none after some refusals, late answers (AX-1853)."""

from collections.abc import Callable, Sequence

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers.modbus_devices import Device
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.modbus.tester import ModbusSetup, ModbusTester
from gateway.conformance.suites.registry import SUITES
from gateway.links.serial.tool_wire import VirtualWire
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Ns, ms
from protocols.modbus.mbap import Request

MOST = 12  # FAILs of one fault
LATE = ms(1300)


class Late(Device):
    """Each `every`-th answer comes after 1.3 s."""

    def __init__(self, rtu: bool, every: int) -> None:
        super().__init__(rtu)
        self._every, self._requests = every, 0

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        self._requests += bool(events)
        self._late = LATE if events and self._requests % self._every == 0 else 0
        return super()._take(events, now)


class Counting(Device):
    """Makes its fault at each `every`-th answer."""

    def __init__(self, rtu: bool, every: int) -> None:
        super().__init__(rtu)
        self._every, self._answers = every, 0

    def due(self) -> bool:
        self._answers += 1
        return self._answers % self._every == 0


class Twice(Counting):
    def framed(self, said: bytes) -> bytes:
        return said + said if self.due() else said


class FailsOnce(Counting):
    def serve(self, request: Request, now: Ns) -> bytes:
        return bytes((request.pdu[0] | 0x80, 4)) if self.due() else super().serve(request, now)


class Hangs(Device):
    """Answers no refusal after the fourth one of a connection."""

    def __init__(self) -> None:
        super().__init__(False, self._said)
        self._refusals = 0

    def _said(self, device: Device, asked: bytes, right: bytes) -> bytes:
        self._refusals += right[0] >> 7
        return b"" if self._refusals > 4 else right


def judged(suite: str, make: Callable[[], Device]) -> list[Result]:
    return play(SUITES[suite], Variant("judged", "", make, {}, {}))


def no_top_bit(device: Device, asked: bytes, right: bytes) -> bytes:
    return bytes((right[0] & 0x7F,)) + right[1:]


@pytest.mark.parametrize("suite, case", [("modbus-tcp", "MBTCP_FUN_BI_04"), ("modbus-rtu", "MBRTU_FUN_BI_04")])
def test_refusals_without_the_top_bit_are_one_fail_that_the_other_cases_name(suite: str, case: str) -> None:
    results = judged(suite, lambda: Device(suite == "modbus-rtu", no_top_bit))
    assert fails(results) == (case,)
    named = [result for result in results if "a refusal without the top bit" in result.reason and result.verdict is Verdict.INCONC]
    assert len(named) > 20
    assert {result.caused_by for result in named} == {case}


def test_refusals_that_end_after_some_are_judged_once() -> None:
    results = {result.purpose.id: result for result in judged("modbus-tcp", Hangs)}
    found = fails(list(results.values()))
    assert "MBTCP_TCP_RC_03" in found
    assert len(found) <= 3
    behind = [result for result in results.values() if "after several refusals it answers no more of them" in result.reason]
    assert behind
    assert {result.caused_by for result in behind} == {"MBTCP_TCP_RC_03"}


@pytest.mark.parametrize("suite", ["modbus-tcp", "modbus-rtu"])
@pytest.mark.parametrize("every", [7, 40])
def test_answers_that_are_late_now_and_then_are_few_fails_which_say_so(suite: str, every: int) -> None:
    results = judged(suite, lambda: Late(suite == "modbus-rtu", every))
    found = [result for result in results if result.verdict is Verdict.FAIL]
    assert "was answered only after 1.3 s" in found[0].reason
    assert 1 < len(found) <= MOST
    again = [result for result in results if result.verdict is Verdict.WARN and "was answered only after" in result.reason]
    assert again
    assert all(f"as in {found[0].purpose.id}" in result.reason or result.purpose.id.endswith("FUN_BV_01") for result in again)


@pytest.mark.parametrize("suite, case", [("modbus-tcp", "MBTCP_FUN_BV_01"), ("modbus-rtu", "MBRTU_FUN_BV_01")])
def test_a_server_whose_answers_are_all_late_has_one_fail(suite: str, case: str) -> None:
    results = judged(suite, lambda: Late(suite == "modbus-rtu", 1))
    assert fails(results) == (case,)
    (found,) = [result for result in results if result.verdict is Verdict.FAIL]
    assert (found.reason, found.expected) == ("function 01h was answered only after 1.3 s", "an answer within 1000 ms")


def test_an_answer_to_the_request_before_is_named_as_such() -> None:
    results = judged("modbus-rtu", lambda: Late(True, 7))
    (found,) = [result for result in results if result.purpose.id == "MBRTU_ANS_BV_01"]
    assert found.reason.startswith("the answer to the request before, function ")


@pytest.mark.parametrize("every", [1, 9])
def test_an_answer_that_comes_twice_is_a_fail(every: int) -> None:
    """On TCP: on a line it spoils its own frame."""
    results = judged("modbus-tcp", lambda: Twice(False, every))
    found = [result for result in results if result.verdict is Verdict.FAIL]
    assert found[0].reason == f"bytes that were not asked for follow an answer: {found[0].got}"
    assert found[0].expected == "one answer to each request"
    assert len(found) <= 3


@pytest.mark.parametrize("suite", ["modbus-tcp", "modbus-rtu"])
def test_a_failure_of_the_server_now_and_then_is_few_fails(suite: str) -> None:
    results = judged(suite, lambda: FailsOnce(suite == "modbus-rtu", 15))
    found = [result for result in results if result.verdict is Verdict.FAIL]
    assert "was refused with 04h, and not when it was repeated" in found[0].reason
    assert "exception 04h" in found[0].got
    assert len(found) <= MOST


def test_a_case_that_is_repeated_judges_missed_answers_anew() -> None:
    """A host that was late may have caused the first finding: no other case may refer to it."""
    tester = ModbusTester(lambda: VirtualWire(Device(False), 0), ModbusSetup(unsteady="A", refusals_end="A"), rtu=False)
    tester.case = "B"
    tester.begin()
    assert (tester.setup.unsteady, tester.setup.refusals_end) == ("A", "A")
    tester.case = "A"
    tester.begin()
    assert (tester.setup.unsteady, tester.setup.refusals_end) == ("", "")
