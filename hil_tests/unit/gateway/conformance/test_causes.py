"""What an INCONC names: the case that judges the step it failed at, whatever failed before; nothing where no case does."""

import random
from collections.abc import Callable

import pytest

from drivers.ports.base import PortError
from gateway.conformance.framework import base
from gateway.conformance.framework.result import Result
from gateway.conformance.framework.run import Runner
from gateway.pure.conformance.purpose import Purpose
from gateway.pure.conformance.verdict import BenchFault, Fail, Verdict
from hil_tests.unit.gateway.conformance.test_late_host import Late, Session

Body = Callable[[base.Tester], None]


def case(name: str, body: Body, *preamble: str) -> Purpose[base.Tester]:
    return Purpose(name, "server", "one", "eins", "1", body, preamble=preamble)


def good(t: base.Tester) -> None:
    """Passes."""


def fails(reason: str, expected: str, got: str) -> Body:
    def body(t: base.Tester) -> None:
        raise Fail(reason, expected, got)

    return body


def prepares(reason: str, expected: str, got: str) -> Body:
    def body(t: base.Tester) -> None:
        with t.given():
            raise Fail(reason, expected, got)

    return body


def relay(t: base.Tester) -> None:
    raise BenchFault("[power] relay: no route", "the write is answered", "no route")


def dies(t: base.Tester) -> None:
    raise PortError(5, "unplugged")


def played(*purposes: Purpose[base.Tester]) -> dict[str, Result]:
    return {result.purpose.id: result for result in Runner(Session(Late(0)), purposes).run()}


STEP = ("after STX: nothing, expected DLE (10h) within 550 ms", "DLE (10h) within 550 ms", "nothing")
OTHER = fails("error 2Ah for a missing block", "14h", "2Ah")


@pytest.mark.parametrize("judge", [STEP, ("STX in idle", "DLE (10h)", "nothing")], ids=["same-words", "same-observation"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_case_that_judges_the_step_is_named_in_any_order(judge: tuple[str, str, str], seed: int) -> None:
    purposes = [case("A_ERR_BI_01", OTHER), case("A_RCV_BV_10", prepares(*STEP), "A_SND_BV_01"), case("A_SEQ_RC_01", fails(*judge))]
    random.Random(seed).shuffle(purposes)
    found = played(case("A_SND_BV_01", good), *purposes)
    assert found["A_RCV_BV_10"].verdict is Verdict.INCONC
    assert found["A_RCV_BV_10"].caused_by == "A_SEQ_RC_01"


def test_neither_a_passed_preamble_nor_an_unrelated_fail_is_named() -> None:
    found = played(case("A_SND_BV_01", good), case("A_ERR_BI_01", OTHER), case("A_RCV_BV_10", prepares(*STEP), "A_SND_BV_01"))
    assert (found["A_RCV_BV_10"].verdict, found["A_RCV_BV_10"].caused_by) == (Verdict.INCONC, "")


def test_what_needs_an_inconclusive_case_names_what_is_behind_that_one() -> None:
    found = played(case("A_RCV_BV_01", prepares(*STEP)), case("A_RCV_BV_02", good, "A_RCV_BV_01"), case("A_SEQ_RC_01", fails(*STEP)))
    assert {found[name].caused_by for name in ("A_RCV_BV_01", "A_RCV_BV_02")} == {"A_SEQ_RC_01"}


def test_a_relay_of_the_bench_that_fails_has_no_case_behind_it() -> None:
    found = played(case("A_SUP_BV_02", fails("no boot-up message", "700h", "nothing")), case("A_SUP_BV_01", relay))
    assert (found["A_SUP_BV_01"].verdict, found["A_SUP_BV_01"].caused_by) == (Verdict.INCONC, "")


def test_what_follows_an_unplugged_device_names_the_case_in_which_it_went() -> None:
    found = played(case("A_ERR_BI_01", OTHER), case("A_RCV_BV_01", dies), case("A_RCV_BV_02", good))
    assert (found["A_RCV_BV_02"].verdict, found["A_RCV_BV_02"].caused_by) == (Verdict.INCONC, "A_RCV_BV_01")


@pytest.mark.parametrize(("stumbles", "verdict"), [(1, Verdict.WARN), (99, Verdict.INCONC)])
def test_a_preparing_step_that_failed_once_hides_no_other_case(stumbles: int, verdict: Verdict) -> None:
    left = [prepares(*STEP)] * stumbles

    def body(t: base.Tester) -> None:
        if left:
            left.pop()(t)

    found = played(case("A_RCV_BV_01", good), case("A_RCV_BV_02", body), case("A_RCV_BV_03", good, "A_RCV_BV_02"))
    assert found["A_RCV_BV_02"].verdict is verdict and STEP[0] in found["A_RCV_BV_02"].reason
    assert found["A_RCV_BV_03"].verdict is (Verdict.PASS if verdict is Verdict.WARN else Verdict.INCONC)
    assert stumbles == 1 or len(left) == stumbles - 2
