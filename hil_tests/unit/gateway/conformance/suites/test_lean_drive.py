"""Drives without objects that CiA 402 leaves to the maker: what needs one is N/A, and what does not need it is judged all the same."""

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers.can_devices import Drive
from gateway.conformance.peers.cia402 import LINK, MUTANTS
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict

FAULTS = ("CIA402_FLT_BV_07", "CIA402_FLT_BV_02", "CIA402_FLT_BI_02")


def played(only: tuple[str, ...], *lacks: int) -> dict[str, Result]:
    device = Variant("lean", "", lambda: Drive(lacks=lacks), LINK, {})
    return {result.purpose.id: result for result in play(SUITES["cia402"], device, only)}


def test_following_errors_and_fault_resets_are_judged_without_6007h_and_6066h() -> None:
    found = played(FAULTS, 0x6007, 0x6066)
    assert {name: found[name].verdict for name in FAULTS} == dict.fromkeys(FAULTS, Verdict.PASS)
    level = next(mutant for mutant in MUTANTS if mutant.id == "fault-reset-by-level")
    assert fails(list(play(SUITES["cia402"], level, FAULTS))) == ("CIA402_FLT_BI_02",)


@pytest.mark.parametrize(("case", "missing"), [("CIA402_OPT_BV_02", 0x6085), ("CIA402_FLT_BI_04", 0x6066), ("CIA402_HOM_BV_03", 0x607C)])
def test_a_case_of_an_optional_object_is_not_applicable_without_it(case: str, missing: int) -> None:
    found = played((case,), missing)[case]
    assert (found.verdict, found.reason) == (Verdict.NA, f"the device has no {missing:04X}h:00")


def test_homing_needs_no_home_offset() -> None:
    assert played(("CIA402_HOM_BV_01",), 0x607C)["CIA402_HOM_BV_01"].verdict is Verdict.PASS


def test_modes_are_found_by_6060h_where_6502h_is_missing() -> None:
    assert played(("CIA402_VEL_BV_01",), 0x6502)["CIA402_VEL_BV_01"].verdict is Verdict.PASS


def test_a_mode_without_its_mandatory_object_is_one_fail() -> None:
    found = played(("CIA402_MOD_BV_04", "CIA402_POS_BV_01"), 0x6081)
    assert fails(list(found.values())) == ("CIA402_MOD_BV_04",) and "pp without 6081h:00" in found["CIA402_MOD_BV_04"].reason


def test_a_drive_without_emergency_messages_is_judged_by_its_state() -> None:
    """CiA 301 leaves 1014h to the maker: two cases were FAIL, one of them with a code that was not said."""
    found = played(("CIA402_FLT_BV_01", "CIA402_FLT_BV_07", "CIA402_FLT_BV_09"), 0x1003, 0x1014, 0x1015)
    assert fails(list(found.values())) == ()
    assert [found[f"CIA402_FLT_BV_0{number}"].verdict for number in (1, 7, 9)] == [Verdict.PASS, Verdict.PASS, Verdict.NA]
