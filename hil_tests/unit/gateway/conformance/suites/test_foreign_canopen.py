"""CANopen devices nobody of axisgate wrote get the verdicts they deserve: the findings are in docs/guide/conformance-can.md."""

import logging
import pathlib
from collections.abc import Callable

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers.can_devices import Drive
from gateway.conformance.peers.score import fails, peers, play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.files.find import find_config
from gateway.pure.conformance.verdict import Verdict
from hil_tests.lab.partners.canopen_machines import NODE, DurandMachine, LocalNodeMachine

ITEMS = "tpdo rpdo sync emcy consumer store restore guarding history error_behaviour sync_counter mapping reset".split()
NOTHING_BUT_SDO: dict[str, object] = dict.fromkeys(ITEMS, False)  # what the README of canopen promises of a LocalNode
DURAND: dict[str, object] = {"consumer": False}


def played(make: Callable[[], object], pics: dict[str, object]) -> list[Result]:
    logging.disable(logging.CRITICAL)
    try:
        return play(SUITES["canopen-301"], Variant("foreign", "", make, {"node": NODE}, pics))
    finally:
        logging.disable(logging.NOTSET)


def test_a_local_node_of_canopen() -> None:
    results = played(LocalNodeMachine, NOTHING_BUT_SDO)
    assert set(fails(results)) == {"CO301_SDO_BO_01", "CO301_SDO_BI_08"}
    assert sum(result.verdict is Verdict.PASS for result in results) >= 25


def test_a_node_of_durand() -> None:
    results = played(DurandMachine, DURAND)
    wrong = {"NMT_BV_06", "NMT_BV_09", "ERR_BI_03", "PDO_BV_02", "PDO_BV_14", "PDO_BV_17", "PDO_BI_11", "PDO_BI_12", "LSS_BV_05"}
    wrong |= {f"PDO_BI_0{number}" for number in range(2, 9)}
    assert set(fails(results)) == {f"CO301_{name}" for name in wrong}
    assert sum(result.verdict is Verdict.PASS for result in results) >= 60


@pytest.mark.parametrize("item", ["sync", "tpdo", "lss", "block"])
def test_what_the_pics_denies_is_not_asked(item: str) -> None:
    """N/A before anything is sent."""
    results = played(DurandMachine, DURAND | {item: False})
    denied = [result for result in results if item in result.purpose.condition]
    assert denied and all(result.verdict is Verdict.NA and not result.notes.trace for result in denied)


def test_a_value_below_the_lower_limit_of_the_eds_must_be_refused(tmp_path: pathlib.Path) -> None:
    """The drive knows no lower limit of 607Ah, its data sheet states one."""
    sheet = find_config("axisgate_402.eds", "drives").read_text(encoding="utf-8")
    (tmp_path / "limited.eds").write_text(sheet.replace("[607A]\n", "[607A]\nLowLimit=-1000\n"), encoding="utf-8")
    device = Variant("limited", "", Drive, {"node": 1, "eds": str(tmp_path / "limited.eds")}, {})
    result = play(SUITES["canopen-301"], device, ("CO301_DIC_BI_05",))[-1]
    assert (result.verdict, result.reason) == (Verdict.FAIL, "17 FC FF FF to 607Ah:00 Target position is not refused")


@pytest.mark.parametrize("name", ["state-13th", "toggle-29th", "content-31st", "rpdo-17th"])
def test_a_fault_that_comes_now_and_then_is_at_most_three_fails(name: str) -> None:
    mutant = next(one for one in peers(SUITES["canopen-301"])[0] if one.id == name)
    assert 1 <= len(fails(play(SUITES["canopen-301"], mutant))) <= 3
