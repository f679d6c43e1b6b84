"""Boosters with fault codes of their own, and slow ones: a code is one WARN and hides no fault, a slow answer is one FAIL."""

import pytest

from gateway.conformance.peers.boosters import Booster, Late
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.servodyn import LINK, MUTANTS
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from protocols.servodyn.codec import ActualValue


def own_code(booster: Booster, value: ActualValue) -> ActualValue:
    return value._replace(fault_code=value.fault_code + 100 if value.fault_code else 0)


@pytest.mark.parametrize("name", ["reset-by-off", "reset-by-level", "restarts", "zero-at-reset", "set-24"])
def test_a_code_of_its_own_hides_no_fault(name: str) -> None:
    mutant = next(one for one in MUTANTS if one.id == name)

    def made() -> object:
        booster = mutant.make()
        assert isinstance(booster, Booster)
        booster._actual = own_code
        return booster

    results = play(SUITES["servodyn"], Variant(name, "", made, LINK, {}), mutant.expects)
    assert set(fails(results)) & set(mutant.expects)


@pytest.mark.parametrize(("late_us", "found"), [(2600, ()), (3400, ("SERVO_CYC_BV_01",))])
def test_a_slow_answer_is_one_fail_and_the_fault_may_take_as_long(late_us: int, found: tuple[str, ...]) -> None:
    device = Variant("late", "", lambda: Late(late_us * 1000), LINK, {})
    results = play(SUITES["servodyn"], device, ("SERVO_FLT_BV_0[1-3]", "SERVO_CYC_BV_0*"))
    assert fails(results) == found
    assert found or all(one.verdict is not Verdict.INCONC for one in results)
