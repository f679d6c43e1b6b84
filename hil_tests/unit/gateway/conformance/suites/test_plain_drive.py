"""A drive that shares nothing with axisgate's emulator: its correct variants have no FAIL and nothing undecided, its fault one FAIL."""

from typing import Any

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from hil_tests.lab.partners.plain_drive import NODE, PlainDrive


def played(only: tuple[str, ...] = (), suite: str = "cia402", **settings: Any) -> dict[str, Result]:
    device = Variant("plain-drive", "", lambda: PlainDrive(**settings), {"node": NODE}, {})
    return {result.purpose.id: result for result in play(SUITES[suite], device, only)}


@pytest.mark.parametrize(
    "settings",
    [
        pytest.param({}, id="plain"),
        pytest.param({"answer_ms": 100}, id="slow"),
        pytest.param({"options_fixed": True}, id="options-fixed"),
        pytest.param({"options_fixed": True, "quick_option": 6}, id="stays-in-quick-stop"),
        pytest.param({"unit": 600.0}, id="speeds-in-a-unit-of-their-own"),
    ],
)
def test_a_correct_drive_has_no_fail_and_nothing_undecided(settings: dict[str, Any]) -> None:
    results = list(played(**settings).values())
    assert fails(results) == ()
    assert not [result.purpose.id for result in results if result.verdict in (Verdict.ERROR, Verdict.INCONC)]
    assert sum(result.verdict is Verdict.PASS for result in results) >= 25


def test_an_option_code_that_is_fixed_is_not_offered() -> None:
    found = played(("CIA402_PWR_BV_13", "CIA402_PWR_BV_14"), options_fixed=True, quick_option=6)
    assert found["CIA402_PWR_BV_13"].verdict is Verdict.NA and "605Ah:00 does not accept 2" in found["CIA402_PWR_BV_13"].reason
    assert found["CIA402_PWR_BV_14"].verdict is Verdict.PASS


def test_a_way_that_is_over_at_once_is_made_longer() -> None:
    found = played(("CIA402_POS_BV_07",), unit=600.0)
    assert "6400 is used" in " ".join(found["CIA402_POS_BV_02"].notes.remarks)
    assert found["CIA402_POS_BV_07"].verdict is Verdict.PASS


def test_a_halt_that_forgets_the_set_point_is_the_only_fail() -> None:
    results = list(played(forgets=True).values())
    assert fails(results) == ("CIA402_POS_BV_06",)


@pytest.mark.parametrize(("form", "first"), [("expedited", Verdict.PASS), ("no size", Verdict.WARN), ("segments", Verdict.WARN)])
def test_a_server_may_answer_in_any_form_of_the_standard(form: str, first: Verdict) -> None:
    """Without its size, or in segments: a remark for the maker, and no case is lost by it."""
    plain, found = (list(played(suite="canopen-301", form=each).values()) for each in ("expedited", form))
    verdicts = {result.purpose.id: result.verdict for result in found}
    assert verdicts["CO301_SDO_BV_01"] is first and fails(found) == fails(plain)
    forms = ("CO301_SDO_BV_01", "CO301_SDO_BV_02", "CO301_SDO_BV_14")
    others = [result for result in found if result.purpose.id not in forms]
    assert {one.purpose.id: one.verdict for one in others} == {one.purpose.id: one.verdict for one in plain if one.purpose.id not in forms}
