"""A station that answers STX wrongly now and then: the long run finds it, and names nothing that is right."""

import pytest

from gateway.conformance.peers import p3964r
from gateway.conformance.peers.score import play
from gateway.conformance.peers.stations import DLE, Built, Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict


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
