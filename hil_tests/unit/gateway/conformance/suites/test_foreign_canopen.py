"""CANopen devices nobody of axisgate wrote get the verdicts they deserve: the findings are in docs/guide/conformance-can.md."""

import logging
from collections.abc import Callable

import pytest

from gateway.conformance.framework.result import Result
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
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
