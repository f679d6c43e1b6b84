"""A station that answers a reaction telegram with 34h (disputed: WARN), and one that never sends again: what other cases make of it."""

from collections.abc import Sequence

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers import p3964r
from gateway.conformance.peers.p3964r_stations import Drops
from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Built, Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Ns
from protocols.p3964r.profiles import RHO3, Priority

REACTION = bytes(4)  # no error, no data: what a postamble sends


class Replies(Built):
    def _serve(self, data: bytes, now: Ns) -> None:
        if data == REACTION:
            self.link.send(b"\0\0\0\x34", now)
        else:
            super()._serve(data, now)


class RepliesAndDrops(Drops, Replies):
    """Loses its job in a conflict; its answer comes in its place."""


class Stops(Replies):
    """After a FETCH of flags no reaction comes any more."""

    over = False

    def _serve(self, data: bytes, now: Ns) -> None:
        if not self.over:
            super()._serve(data, now)
            self.over = data[:4] == b"\0\0EM"  # FETCH of flags


def played(suite: str, make: type[Built], only: tuple[str, ...], power: bool = True) -> list[Result]:
    def fresh() -> Built:
        return make(RHO3, Priority.LOW)

    device = Variant("replies", "", (lambda: Powered(fresh)) if power else fresh, p3964r.MUTANTS[0].link, {})
    return play(SUITES[suite], device, only)


def test_an_answer_is_not_the_job_that_gave_way() -> None:
    assert fails(played("3964r", RepliesAndDrops, ("3964R_CON_BV_02",))) == ("3964R_CON_BV_02",)
    assert fails(played("3964r", Replies, ("3964R_CON_BV_02",))) == ()


def test_an_answer_after_a_power_failure_is_not_a_reaction_from_before_it() -> None:
    assert fails(played("rk512", Replies, ("RK512_SUP_RC_01",))) == ()


def test_a_station_that_stops_is_one_fail() -> None:
    results = played("rk512", Stops, ("RK512_PAS_BV_*", "RK512_PAS_CA_*", "RK512_PAS_BI_*"), power=False)
    assert len(fails(results)) <= 3
    assert [one for one in results if one.verdict is Verdict.INCONC and one.caused_by in fails(results)]


@pytest.mark.parametrize("seed", [None, 3])
def test_a_station_that_never_sends_again_is_one_fail(seed: int | None) -> None:
    mutant = next(one for one in p3964r.MUTANTS if one.id == "gives-up-for-ever")
    results: Sequence[Result] = play(SUITES["3964r"], mutant, ("3964R_SND_*",), seed)
    failed = [one for one in results if one.verdict is Verdict.FAIL]
    assert [one.reason for one in failed] == ["it sends no job any more; it sent the last one in 3964R_SND_BI_01"]
    assert {one.caused_by for one in results if one.verdict is Verdict.INCONC} == {failed[0].purpose.id}
