"""A CANopen device whose LSS does not know the identity of 1018h: it has LSS all the same, and the case of the selection fails."""

from collections.abc import Sequence

from gateway.conformance.peers.can_devices import Drive
from gateway.conformance.peers.canopen301 import MUTANTS
from gateway.conformance.peers.score import play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen.lss import Service


def never_selected(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [] if frame.identifier == cobid.LSS_MASTER and frame.data[:1] == bytes((Service.SELECT_SERIAL,)) else [frame]


def test_lss_that_cannot_be_selected_is_a_fail_and_not_taken_for_missing() -> None:
    device = Variant("unselected", "", lambda: Drive(hears=never_selected), MUTANTS[0].link, {})
    found = {result.purpose.id: result for result in play(SUITES["canopen-301"], device, ("CO301_LSS_BV_01",))}
    assert found["CO301_LSS_BV_01"].verdict is Verdict.FAIL
