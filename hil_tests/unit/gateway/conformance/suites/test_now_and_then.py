"""A station that answers STX wrongly now and then, a booster that loses one actual value: the long run finds it, no other case FAILs."""

import pytest

from gateway.conformance.peers import p3964r, servodyn
from gateway.conformance.peers.boosters import Booster
from gateway.conformance.peers.score import play
from gateway.conformance.peers.stations import DLE, Built, Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from protocols.servodyn.codec import ActualValue


@pytest.mark.parametrize("every", [23, 31])
def test_a_wrong_answer_to_a_late_stx_is_a_fail_of_the_long_run(every: int) -> None:
    class Stumbles(Built):
        count = 0

        def take_output(self) -> bytes:
            output = super().take_output()
            self.count += output == DLE
            return b"U" if output == DLE and self.count % every == 0 else output

    results = play(SUITES["3964r"], Variant("stumbles", "", Stumbles, p3964r.MUTANTS[0].link, {}), ("3964R_RCV_BV_*", "3964R_RCV_ST_01"))
    assert [one.purpose.id for one in results if one.verdict is Verdict.FAIL] == ["3964R_RCV_ST_01"]
    assert not [one.purpose.id for one in results if one.verdict is Verdict.INCONC and not one.caused_by]


class LosesOne(Booster):
    """A single actual value is lost: the one of this SYNC."""

    def __init__(self, at: int) -> None:
        super().__init__(actual=lambda booster, value: self._counted(value, at))

    def _counted(self, value: ActualValue, at: int) -> ActualValue | None:
        self.tally += 1
        return None if self.tally == at else value


ONLY = ("SERVO_CYC_ST_01", "SERVO_CYC_BV_05", "SERVO_CYC_BV_06")


@pytest.mark.parametrize(
    ("lost", "case", "warned"),
    [
        pytest.param(100, "SERVO_CYC_ST_01", "SERVO_CYC_TI_01", id="before the long run"),
        pytest.param(1000, "SERVO_CYC_ST_01", "", id="in the long run"),
        pytest.param(2360, "SERVO_CYC_BV_05", "", id="after the long run"),
    ],
)
def test_one_lost_actual_value_is_one_fail(lost: int, case: str, warned: str) -> None:
    """In this order of the cases, by a shuffle: the long run, then those at rest."""
    results = play(SUITES["servodyn"], Variant("loses", "", lambda: LosesOne(lost), servodyn.MUTANTS[0].link, {}), ONLY, 2)
    assert [one.purpose.id for one in results if one.verdict is Verdict.FAIL] == [case]
    assert "".join(one.purpose.id for one in results if one.verdict is Verdict.WARN) == warned
