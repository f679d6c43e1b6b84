"""RK512 stations with jobs of their own: each job waits for its reaction, some come in a cycle.  Correct ones get no FAIL."""

from collections.abc import Sequence

import pytest

from gateway.conformance.framework.bench_file import Bench
from gateway.conformance.framework.machine import Guarded
from gateway.conformance.framework.result import Result
from gateway.conformance.framework.run import Runner
from gateway.conformance.peers.rk512_active import CommandTwice, Patient
from gateway.conformance.peers.rk512_passive import ChangedReactions
from gateway.conformance.peers.score import with_preambles
from gateway.conformance.peers.stations import ActiveStation, Built, link_of
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.registry import SUITES
from gateway.links.serial.tool_wire import ToolPort
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.events import Failure, Stage
from protocols.p3964r.profiles import RHO3, Priority
from protocols.p3964r.sender import Sender


class Cyclic(ActiveStation):
    """Fetches the same two words in a cycle; the next job waits for the reaction, 20 s at most."""

    def __init__(self, period: Ns) -> None:
        super().__init__(active=Patient)
        self._period, self._next = period, period

    def deadline(self) -> Ns | None:
        due = super().deadline()
        return self._next if due is None else min(due, self._next)

    def wake(self, now: Ns) -> Sequence[object]:
        if now >= self._next:
            self._next = now + self._period
            if not self.active.awaiting and not self.link.pending:
                self.active.fetch(0, 2, block=5)
                self._hand_over(now)
        return super().wake(now)


def played(suite: str, device: Built, only: Sequence[str]) -> dict[str, Result]:
    bench = Bench(None, "machine:own", link=link_of(RHO3, Priority.LOW))

    def no_port(url: str, line_format: str) -> ToolPort:
        raise AssertionError(url)

    session = SUITES[suite].session(Opened(bench, {}, no_port, make=lambda: Guarded(device, "own")))
    results = Runner(session, with_preambles(SUITES[suite].purposes(), only)).run()
    return {result.purpose.id: result for result in results}


def undecided(results: dict[str, Result]) -> dict[str, str]:
    good = (Verdict.PASS, Verdict.NA, Verdict.WARN)
    return {name: result.reason for name, result in results.items() if result.verdict not in good}


def test_a_station_that_waits_for_reactions_is_judged_by_the_suite_of_its_link() -> None:
    """Without the reaction to its job the next one does not come: half of the cases were INCONC."""
    only = ("3964R_SND_BV_0?", "3964R_SND_TI_01", "3964R_SND_RC_01", "3964R_CON_BV_02", "3964R_CON_ST_01")
    assert undecided(played("3964r", ActiveStation(active=Patient, nesting=False), only)) == {}


@pytest.mark.parametrize("period", [ms(300), ms(2000)])
def test_commands_of_its_own_get_their_reactions_in_cases_of_the_passive_role(period: Ns) -> None:
    assert undecided(played("rk512", Cyclic(period), ("RK512_PAS_BI_0[1-4]", "RK512_PAS_RC_03", "RK512_ACT_B?_*"))) == {}


def test_a_cycle_of_the_same_command_is_no_repeat_and_a_repeat_is() -> None:
    cyclic = played("rk512", Cyclic(ms(100)), ("RK512_ACT_BV_02",))["RK512_ACT_BV_02"]
    assert (cyclic.verdict, cyclic.reason) == (Verdict.NA, "it also sends the same command unprompted")
    twice = played("rk512", CommandTwice(), ("RK512_ACT_BV_02",))["RK512_ACT_BV_02"]
    assert twice.verdict is Verdict.FAIL


class TwoNaks(Sender):
    """Gives up with two NAKs."""

    def _give_up(self, why: Failure, stage: Stage) -> None:
        super()._give_up(why, stage)
        self._box.output.append(Char.NAK)


class OddHeader(ActiveStation):
    """The first byte of its commands is 55h."""

    def _hand_over(self, now: Ns) -> None:
        while (block := self.roles.take_block()) is not None:
            self.link.send(b"U" + block[1:] if block[2:3] in (b"A", b"E") else block, now)


def seven_bits(said: bytes) -> bytes:
    """The block check of its own blocks has seven bits."""
    return said[:-1] + bytes((said[-1] & 0x7F,)) if len(said) > 3 and said[-3:-1] == b"\x10\x03" else said


def stop_for_flag(command: bytes, said: bytes) -> bytes:
    """A job with a coordination flag is refused with 2Ah."""
    return b"\0\0\0\x2a" if len(command) >= 10 and command[8] != 0xFF else said


@pytest.mark.parametrize(
    "suite, device, case, reason",
    [
        ("3964r", Built(sender=TwoNaks), "3964R_SND_BI_01", "after the NAK with which it gives up: NAK"),
        ("3964r", Built(says=seven_bits), "3964R_SND_BV_06", "block check 5Ah, DAh expected"),
        ("rk512", OddHeader(), "RK512_ACT_BV_01", "header 55 00 4"),
        (
            "rk512",
            Built(passive=lambda station: ChangedReactions(station.blocks, stop_for_flag)),
            "RK512_PAS_CA_07",
            "refused with a misleading number: 2Ah",
        ),
    ],
)
def test_a_fault_is_named_by_the_case_that_describes_it(suite: str, device: Built, case: str, reason: str) -> None:
    found = played(suite, device, (case,))[case]
    assert (found.verdict, reason in found.reason) == (Verdict.FAIL, True), found.reason


def test_characters_behind_a_block_are_not_taken_for_the_answer_to_another_stx() -> None:
    """The reaction to each block ends with CR LF: one case of the sender names that, the cases of the receiver pass."""
    device = Built(says=lambda said: said + b"\r\n" if len(said) > 3 else said)
    found = played("3964r", device, ("3964R_RCV_BV_*", "3964R_RCV_RC_*"))
    assert undecided(found) == {}
