"""Blocks of reactions in a wrong form: one FAIL, in the case of the form; what depends on it names that case."""

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers import interop, p3964r, rk512
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Built, Mutant, Variant
from gateway.conformance.suites.registry import SUITES
from gateway.conformance.suites.rk512.forms import PATTERNS
from gateway.pure.conformance.verdict import Verdict


def played(suite: str, device: Mutant | Variant, only: tuple[str, ...] = ()) -> dict[str, Result]:
    return {result.purpose.id: result for result in play(SUITES[suite], device, only)}


def mutant(name: str) -> Mutant:
    return next(one for one in rk512.MUTANTS if one.id == name)


@pytest.mark.parametrize("name", ["never-doubles", "check-counts-once", "check-doubled"])
def test_a_wrong_form_is_one_fail_of_rk512_and_the_cause_of_the_others(name: str) -> None:
    results = list(played("rk512", mutant(name), ("RK512_PAS_*",)).values())
    assert fails(results) == ("RK512_PAS_BV_21",)
    causes = {one.caused_by for one in results if one.verdict is Verdict.INCONC}
    assert causes == {"RK512_PAS_BV_21"}


def test_the_same_in_the_suite_of_the_line() -> None:
    device = Variant("check-doubled", "", mutant("check-doubled").make, p3964r.MUTANTS[0].link, {})
    found = played("3964r", device, ("3964R_SND_BV_06",))["3964R_SND_BV_06"]
    assert found.verdict is Verdict.FAIL and "DLE (10h) follows the block check" in found.reason


def test_what_was_planted_is_restored() -> None:
    """Every second SEND writes back what was there."""
    device = Variant("good", "", Built, p3964r.MUTANTS[0].link, {})
    found = played("rk512", device, ("RK512_PAS_BV_21",))["RK512_PAS_BV_21"]
    sends = [piece.data for piece in found.notes.trace if piece.side == "tester" and piece.data.startswith(b"\0\0AD")]
    planted, restored = sends[::2], sends[1::2]
    assert found.verdict is Verdict.PASS and len(planted) == len(restored) == len(PATTERNS)
    assert len({data[-7:-3] if len(data) < 20 else b"" for data in restored} - {b""}) == 1


def test_words_that_cannot_be_read_back_are_restored_before_the_next_maker() -> None:
    """They hold one 10h: each maker after the first met it in its FETCH."""
    device = Variant("once", "", mutant("check-counts-once").make, interop.MUTANTS[0].link, {})
    results = list(played("interop", device, ("INTEROP_*_BV_1[12]",)).values())
    assert fails(results) == ("INTEROP_SIEMENSCP341_BV_12",)
