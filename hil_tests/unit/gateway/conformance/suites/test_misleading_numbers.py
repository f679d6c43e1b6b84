"""A misleading error number of RK512 is one FAIL, in any order of the cases; the others that meet it name that case."""

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers import rk512
from gateway.conformance.peers.rk512_memories import WritesToTheEnd
from gateway.conformance.peers.rk512_passive import ChangedReactions
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Built, Mutant, Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from protocols.rk512.passive import Passive

ONLY = ("RK512_PAS_BI_*", "RK512_PAS_CA_0[1-6]")


def mutant(name: str) -> Mutant:
    return next(one for one in rk512.MUTANTS if one.id == name)


def played(device: Mutant | Variant, seed: int | None = None) -> list[Result]:
    return play(SUITES["rk512"], device, ONLY, seed)


@pytest.mark.parametrize("seed", [None, 4])
@pytest.mark.parametrize(
    ("name", "case", "others"),
    [
        ("stop-for-missing", "BI_02", {"BI_03", "BI_04", "BI_16"}),
        ("missing-for-length", "BI_09", {"BI_10", "BI_11", "BI_12", "BI_13", "BI_14", "BI_15"}),
        ("types-as-stop", "CA_01", {"CA_02", "CA_03", "CA_04", "CA_05", "CA_06"}),
    ],
)
def test_one_number_is_one_fail(name: str, case: str, others: set[str], seed: int | None) -> None:
    results = played(mutant(name), seed)
    named = {one.purpose.id.removeprefix("RK512_PAS_"): one.caused_by for one in results if one.verdict is Verdict.INCONC}
    assert fails(results) == (f"RK512_PAS_{case}",)
    assert named == dict.fromkeys(others, f"RK512_PAS_{case}")


def test_what_a_refused_send_writes_is_found_behind_a_known_number() -> None:
    def passive(built: Built) -> Passive:
        built.blocks = WritesToTheEnd()
        return ChangedReactions(built.blocks, lambda command, said: said[:3] + b"\x2a" + said[4:] if said[3] == 0x14 else said)

    device = Variant("writes", "", lambda: Built(passive=passive), mutant("stop-for-missing").link, {})
    assert fails(played(device)) == ("RK512_PAS_BI_02", "RK512_PAS_BI_16")
