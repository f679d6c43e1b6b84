"""The supply of an RK512 station fails in the midst of a job: the next reaction belongs to the next command."""

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.p3964r.supply import works_again
from gateway.conformance.suites.rk512.telegrams import ask, fetch, looks_like_reaction
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail

SUP = Purposes[LineTester]("RK512_SUP", "station", "power failure", condition=("power", "passive"), preamble=("RK512_PAS_BV_01",))


@SUP.case(
    "RC_01",
    "the supply fails between a command and its reaction: the next FETCH has its own reaction",
    "Netzausfall zwischen Auftrag und Reaktion: das nächste FETCH erhält seine eigene Reaktion",
)
def between(t: LineTester) -> None:
    words = max(1, min(4, t.setup.words))
    with t.given():
        t.good(fetch(t.setup.db, 0, 1), "a command telegram")
    stale: list[bytes] = []
    t.on_block = stale.append
    try:
        t.power.cycle()
        works_again(t, "a power failure before the reaction")
        t.settle()
    finally:
        t.on_block = None
    late = next((block for block in stale if looks_like_reaction(block) and not block[3]), None)  # else it refuses the block of works_again
    if late is not None:
        raise Fail("it reacts to a command from before the power failure", "no reaction", hexed(late))
    found = ask(t, fetch(t.setup.db, 0, words))
    if found.number or len(found.data) != 2 * words:
        raise Fail(f"FETCH of {words} words after a power failure: {found.words()}", f"00h and {2 * words} data bytes", found.words())
