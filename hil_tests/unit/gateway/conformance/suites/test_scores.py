"""Every faulty device is found by a case that is expected to find it, every correct one passes; in virtual time."""

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import pytest

from gateway.conformance.framework.run import ordered
from gateway.conformance.peers.modbus_devices import Device
from gateway.conformance.peers.score import fails, peers, play
from gateway.conformance.peers.stations import Chatty, Mutant, Variant, link_of
from gateway.conformance.suites.registry import SUITES
from gateway.conformance.suites.scores import SCORES
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Ns, ms
from protocols.modbus.mbap import Request
from protocols.modbus.view import Kind
from protocols.p3964r.profiles import RHO3, Priority

MUTANTS = [pytest.param(name, mutant, id=f"{name}-{mutant.id}") for name, suite in SUITES.items() for mutant in peers(suite)[0]]
VARIANTS = [pytest.param(name, variant, id=f"{name}-{variant.id}") for name, suite in SUITES.items() for variant in peers(suite)[1]]


@pytest.mark.parametrize("name, mutant", MUTANTS)
def test_a_faulty_device_is_found_by_an_expected_case(name: str, mutant: Mutant) -> None:
    found = fails(play(SUITES[name], mutant, mutant.expects))
    assert set(found) & set(mutant.expects)


@pytest.mark.parametrize("name, variant", VARIANTS)
def test_a_correct_device_has_no_fail(name: str, variant: Variant) -> None:
    results = play(SUITES[name], variant)
    assert fails(results) == ()
    assert not [result.purpose.id for result in results if result.verdict in (Verdict.ERROR, Verdict.INCONC)]


@pytest.mark.parametrize("name", SUITES)
def test_the_recorded_score_counts_the_mutants_there_are(name: str) -> None:
    mutants, variants = peers(SUITES[name])
    assert SCORES[name] == (len(mutants), len(mutants))
    assert len(mutants) >= 40 and len(variants) >= 8
    assert len({mutant.id for mutant in mutants}) == len(mutants)
    ids = {purpose.id for purpose in SUITES[name].purposes()}
    assert {expected for mutant in mutants for expected in mutant.expects} <= ids


@pytest.mark.parametrize("name", SUITES)
def test_purposes_are_whole_data(name: str) -> None:
    purposes = SUITES[name].purposes()
    ids = [purpose.id for purpose in purposes]
    assert len(ids) == len(set(ids))
    for purpose in purposes:
        assert purpose.summary and purpose.summary_de and purpose.clause and purpose.role
        assert set(purpose.preamble) <= set(ids) - {purpose.id}
    for seed in (None, 1):
        placed = {purpose.id: at for at, purpose in enumerate(ordered(purposes, seed))}
        early = [(purpose.id, before) for purpose in purposes for before in purpose.preamble if placed[before] > placed[purpose.id]]
        assert len(placed) == len(ids) and early == []


@pytest.mark.parametrize("kind, fails_are", [("silent", 1), ("empty-hangs", 1)])
def test_one_fault_is_one_fail_and_the_rest_names_it(kind: str, fails_are: int) -> None:
    suite = SUITES["3964r"]
    mutant = next(one for one in peers(suite)[0] if one.id == kind)
    results = play(suite, mutant)
    failed = fails(results)
    assert len(failed) == fails_are
    behind = [result for result in results if result.verdict is Verdict.INCONC]
    assert behind and {result.caused_by for result in behind} == set(failed)


def test_a_station_whose_blocks_never_end_is_not_blamed_for_what_follows() -> None:
    """Its jobs meet our STX again and again: a conflict, not an answer while its buffer is full.  At most 12 FAILs for one fault."""
    suite = SUITES["3964r"]
    results = play(suite, next(one for one in peers(suite)[0] if one.id == "no-end"))
    assert "3964R_SND_BV_01" in fails(results) and len(fails(results)) <= 12
    assert not {"3964R_RCV_BO_06", "3964R_RCV_BO_07"} & set(fails(results))


@pytest.mark.parametrize("period", [300, 700, 900])
def test_a_station_that_sends_the_same_block_cyclically_is_not_said_to_repeat_it(period: int) -> None:
    """Its next block begins behind our DLE by chance, and is the same."""
    only = ("3964R_SND_BV_03", "3964R_SND_TI_05", "3964R_CON_BO_02")
    cyclic = Variant("cyclic", "", lambda: Chatty(period=ms(period)), link_of(RHO3, Priority.LOW), {})
    results = play(SUITES["3964r"], cyclic, only)
    assert not [result.reason for result in results if result.verdict not in (Verdict.PASS, Verdict.NA)]


class ClosesAfterRefusals(Device):
    """The ninth refusal in a row is not sent: the connection is closed, and the next one begins anew."""

    def serve(self, request: Request, now: Ns) -> bytes:
        said = super().serve(request, now)
        self.refused = self.refused + 1 if said[:1] >= b"\x80" else 0
        if self.refused < 9:
            return said
        self.refused = 0
        return b""


def test_a_server_that_closes_a_connection_with_many_refusals_lives_on() -> None:
    device = Variant("closes", "", lambda: ClosesAfterRefusals(False), {}, {})
    assert play(SUITES["modbus-tcp"], device, ("MBTCP_TCP_RC_03",))[-1].verdict is Verdict.PASS


@pytest.mark.parametrize("name", ["modbus-tcp", "modbus-rtu"])
def test_a_limit_of_registers_is_a_fail_that_names_the_key_of_the_pics(name: str) -> None:
    suite = SUITES[name]
    only = ("MB???_FUN_BV_32",)
    mutant, variant = (next(one for one in peers(suite)[at] if one.id == "limit-100") for at in (0, 1))
    result = play(suite, mutant, only)[-1]
    assert (result.verdict, "most_registers = 100" in result.expected) == (Verdict.FAIL, True)
    assert play(suite, variant, only)[-1].verdict is Verdict.PASS


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_shuffled_run_has_the_same_verdicts(seed: int) -> None:
    suite = SUITES["3964r"]
    mutant = next(one for one in peers(suite)[0] if one.id == "no-nak")
    plain = {result.purpose.id: result.verdict for result in play(suite, mutant)}
    assert {result.purpose.id: result.verdict for result in play(suite, mutant, seed=seed)} == plain


def test_no_order_changes_a_verdict_of_a_drive_that_keeps_the_error_of_a_lost_master() -> None:
    """It reports no second loss while the first one is present: a case that ends with a lost master brings it back."""
    suite = SUITES["cia402"]
    variant, only = peers(suite)[1][0], ("CIA402_FLT_BI_03", "CIA402_FLT_BV_09")
    results = {seed: {each.purpose.id: each.verdict for each in play(suite, variant, only, seed=seed)} for seed in (1, 2)}
    assert {seed: found["CIA402_FLT_BV_09"] for seed, found in results.items()} == dict.fromkeys(results, Verdict.PASS)


@pytest.mark.parametrize("kind", ["all", "any-coil-value", "longer-fc6", "writes-bad"])
def test_what_a_modbus_suite_wrote_it_writes_back_whatever_the_server_executes(kind: str) -> None:
    suite = SUITES["modbus-tcp"]
    every: list[Mutant | Variant] = [*peers(suite)[0], *peers(suite)[1]]
    device = next(one for one in every if one.id == kind)
    made = list[Device]()

    def make() -> Device:
        made.append(cast(Device, device.make()))
        made[-1].tables.write_bits(0, [True, False, True])
        made[-1].tables.write_words(0, [0x1234, 0x2345])
        return made[-1]

    play(suite, replace(device, make=make), ("MBTCP_FUN_BI_5?", "MBTCP_FUN_BI_6?", "MBTCP_FUN_BI_7?", "MBTCP_LEN_*"))
    tables = made[-1].tables
    assert list(cast(Sequence[bool], tables.read_bits(Kind.COILS, 0, 3))) == [True, False, True]
    assert list(cast(Sequence[int], tables.read_words(Kind.HOLDING_REGISTERS, 0, 2))) == [0x1234, 0x2345]
