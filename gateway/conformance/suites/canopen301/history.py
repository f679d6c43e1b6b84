"""CANopen, the error history 1003h in order, TPDOs of type 0, and a TPDO after power-on (CiA 301, 7.5.2.4, 7.5.2.37)."""

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.can.tester import shown
from gateway.conformance.suites.canopen301.life import CONSUMES, HISTORY, LOST, SUPERVISED_MS, emergency, watched_master
from gateway.conformance.suites.canopen301.pdo import RX, SENDS, mapped_value, mapping, synced, transmission
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.emcy import decode
from protocols.canopen.sdo import Abort, Request

BASIC, WRITE, FIRST = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_PDO_BV_01"
KEEPS = "CO301_ERR_BV_09"
ERR = Purposes[NodeTester]("CO301_ERR", "slave", "CiA 301, 7.5.2.4", condition=(*CONSUMES, "history"), preamble=(BASIC, WRITE, LOST, KEEPS))
EVENT = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.5.2.37", condition=SENDS, preamble=(BASIC, WRITE, FIRST))
SUP = Purposes[NodeTester](
    "CO301_SUP", "device", "CiA 301, 7.3.2.2.1", condition=("power", *SENDS), preamble=(BASIC, WRITE, FIRST, "CO301_PDO_BV_03")
)
ON_EVENT, SYNCS, FEW = 0, 12, 2


def _lost(t: NodeTester) -> None:
    """One error, of a history that was empty."""
    with t.given():
        t.download(HISTORY, 0, 1)
        emergency(t, 0x8130, ms(10 * SUPERVISED_MS), "the heartbeat stays away")


def _entries(t: NodeTester) -> list[int]:
    return [t.number((HISTORY[0], sub)) & 0xFFFF for sub in range(1, t.number(HISTORY) + 1)]


def _another(t: NodeTester) -> int:
    """A second error, by an RPDO or a SYNC of a wrong length; its code."""
    pics = t.setup.pics
    ways: list[tuple[int, bytes]] = []
    if pics.get("rpdo") and pics.get("write_pdo"):
        ways.append((t.number((RX, 1)) & cobid.ID_BITS, b""))
    if pics.get("sync") and not (pics.get("sync_counter") and t.number((0x1019, 0))):
        ways.append((cobid.SYNC, bytes(3)))
    for identifier, data in ways:
        t.say(identifier, data)
        frame = t.hear((t.emcy,), ms(50))
        if frame is not None and len(frame.data) == 8 and (code := decode(frame.data).code):
            return code
    raise NotApplicable("no second error can be caused: neither an RPDO nor a SYNC of a wrong length is reported")


@ERR.case(
    "BV_21",
    "of two errors in 1003h the newer one is in sub-index 1, the older one after it",
    "von zwei Fehlern in 1003h steht der neuere in Subindex 1, der ältere dahinter",
)
def newest_first(t: NodeTester) -> None:
    with watched_master(t), t.operational():
        _lost(t)
        before = _entries(t)
        code = _another(t)
        found = _entries(t)
        words = " ".join(f"{entry:04X}h" for entry in found) or "none"
        if not found or found[0] != code:
            raise Fail(f"after {code:04X}h 1003h holds {words}", f"{code:04X}h in 1003h:01", words)
        if len(found) > 1 and (0x8130 not in found[1:] or len(found) <= len(before)):
            raise Fail(f"after 8130h and {code:04X}h 1003h holds {words}", f"{code:04X}h, then 8130h, {len(before) + 1} errors", words)


@ERR.case(
    "BV_22",
    "1003h that was emptied has no entry: sub-index 1 is refused (08000024h)",
    "geleertes 1003h hat keinen Eintrag: Subindex 1 wird abgelehnt (08000024h)",
)
def emptied(t: NodeTester) -> None:
    with watched_master(t):
        _lost(t)
        t.download(HISTORY, 0, 1)
        got = t.ask(sdo.initiate(Request.INITIATE_UPLOAD, (HISTORY[0], 1)))
        t.end_transfer(got)
        if got[:1] != b"\x80" and any(got[4:6]):
            raise Fail("1003h:01 still holds an error after 0 was written to 1003h:00", "abort 08000024h", hexed(got))
        if got[:1] != b"\x80":
            raise Warn("1003h:01 of an empty history is 0", "abort 08000024h", hexed(got))
        codes = (Abort.NO_DATA, Abort.GENERAL)
        t.judge_refusal(got, codes, "1003h:01 of an empty history", (Abort.NO_SUB, Abort.DEVICE_STATE, Abort.NO_STORE))


@ERR.case(
    "BI_04",
    "a value that 1003h:00 refuses leaves the history as it is",
    "ein Wert, den 1003h:00 ablehnt, lässt die Liste, wie sie ist",
    preamble=(BASIC, WRITE, LOST, KEEPS, "CO301_ERR_BI_01"),
)
def refused_leaves(t: NodeTester) -> None:
    with watched_master(t):
        _lost(t)
        before = _entries(t)
        for value in (1, 2, 255):
            t.ask(sdo.expedited(Request.INITIATE_DOWNLOAD, HISTORY, bytes((value,))))
            if (got := _entries(t)) != before:
                words = " ".join(f"{entry:04X}h" for entry in got) or "none"
                raise Fail(f"1003h holds other errors after {value} was written to 1003h:00", f"{len(before)}, as before", words)


@EVENT.case(
    "BV_20",
    "transmission type 0: without an event SYNC sends nothing",
    "Übertragungsart 0: ohne Ereignis sendet SYNC nichts",
)
def no_event(t: NodeTester) -> None:
    with t.given():
        parts = mapping(t, 0x1A00)
    with transmission(t, ON_EVENT) as identifier:
        with t.given():
            before = mapped_value(t, parts)
        sent = [frames[0] for frames in synced(t, identifier, SYNCS) if frames]
        with t.given():
            after = mapped_value(t, parts)
    if before != after or len({frame.data for frame in sent}) > 1:
        raise NotApplicable("the contents of TPDO 1 change by themselves")
    if len(sent) > FEW:
        raise Fail(f"{len(sent)} TPDOs after {SYNCS} SYNCs though nothing changed", f"none, at most {FEW} at first", shown(sent[-1]))


@SUP.case(
    "RC_04",
    "after power-on TPDO 1 has its mapping and holds what an SDO reads",
    "nach dem Einschalten hat TPDO 1 sein Mapping und enthält, was ein SDO liest",
)
def same_contents(t: NodeTester) -> None:
    with t.given():
        words = [part.word for part in mapping(t, 0x1A00)]
        t.power.cycle()
        t.boot_up(max(t.setup.boot, t.power.back))
        t.ready()
        t.pause(ms(200))
    parts = mapping(t, 0x1A00)
    if [part.word for part in parts] != words:
        shown_words = " ".join(f"{part.word:08X}h" for part in parts)
        raise Fail("TPDO 1 has another mapping after power-on", " ".join(f"{word:08X}h" for word in words), shown_words)
    with transmission(t, 1) as identifier:
        for _ in range(3):
            with t.given():
                before = mapped_value(t, parts)
            frames = synced(t, identifier, 1)[0]
            with t.given():
                after = mapped_value(t, parts)
            got = frames[0].data if frames else b""
            if before == after and got != before:
                raise Fail("TPDO 1 holds other values than its objects after power-on", hexed(before), hexed(got))
