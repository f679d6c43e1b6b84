"""CANopen, SDO server: downloads in several segments, aborted, with a gap, without CRC; the object named by an abort (CiA 301, 7.2.4)."""

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.blocks import block_download
from gateway.conformance.suites.can.node import HEARTBEAT, Aborted, NodeTester, named
from gateway.conformance.suites.canopen301.sdo import BASIC, VALUE, WRITE, block_ended, effect
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, Warn
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort, Answer, Request

MORE = Purposes[NodeTester]("CO301_SDO", "server", "CiA 301, 7.2.4", preamble=(BASIC, WRITE))
NAMES = Purposes[NodeTester]("CO301_DIC", "server", "CiA 301, 7.2.4.3.17", preamble=(BASIC, "CO301_DIC_BI_01"))
SEGMENTS, BLOCKS = ("heartbeat", "segmented"), ("heartbeat", "block")
ONE_SEGMENT, ONE_BLOCK = (BASIC, WRITE, "CO301_SDO_BV_05"), (BASIC, WRITE, "CO301_SDO_BV_09")
DATA = VALUE.to_bytes(2, "little")


def _segment(t: NodeTester, request: bytes, what: str, toggle: int) -> None:
    wanted = Answer.DOWNLOAD_SEGMENT << 5 | toggle
    if (got := t.asked(request, what))[0] != wanted:
        raise Fail(f"{what} is acknowledged wrongly", f"{wanted:02X}h", hexed(got))


def _begun(t: NodeTester) -> None:
    """A segmented download to 1017h is open, its first byte acknowledged."""
    with t.given():
        t.asked(sdo.initiate(Request.INITIATE_DOWNLOAD, HEARTBEAT, 2), "segmented download to 1017h", HEARTBEAT)
    _segment(t, sdo.segment(Request.DOWNLOAD_SEGMENT, False, DATA[:1], False), "the first of two segments", 0)


@MORE.case(
    "BV_11",
    "a download in two segments: the toggle bit alternates in the answers as well",
    "ein Download in zwei Segmenten: das Toggle-Bit wechselt auch in den Antworten",
    condition=SEGMENTS,
    preamble=ONE_SEGMENT,
)
def two_segments(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        _begun(t)
        _segment(t, sdo.segment(Request.DOWNLOAD_SEGMENT, True, DATA[1:], True), "the second of two segments", sdo.TOGGLE)
        effect(t, VALUE, "a download in two segments")


@MORE.case(
    "BI_11",
    "a segment of a download that is sent twice is refused (05030000h), without effect",
    "ein doppelt gesendetes Segment eines Downloads wird abgelehnt (05030000h), wirkungslos",
    clause="CiA 301, table 22",
    condition=SEGMENTS,
    preamble=ONE_SEGMENT,
)
def twice(t: NodeTester) -> None:
    with t.kept(HEARTBEAT) as before:
        _begun(t)
        got = t.ask(sdo.segment(Request.DOWNLOAD_SEGMENT, False, DATA[1:], True))
        t.judge_refusal(got, (Abort.TOGGLE,), "a second segment with the toggle bit of the first", (Abort.COMMAND, Abort.GENERAL))
        effect(t, before[0], "a segment that was sent twice")


@MORE.case(
    "BO_05",
    "a segmented download that the client aborts has no effect",
    "ein vom Client abgebrochener segmentierter Download wirkt nicht",
    condition=SEGMENTS,
    preamble=ONE_SEGMENT,
)
def given_up(t: NodeTester) -> None:
    with t.kept(HEARTBEAT) as before:
        _begun(t)
        t.say(cobid.sdo_request(t.setup.node), sdo.abort(HEARTBEAT, Abort.GENERAL))
        t.silence(cobid.sdo_answer(t.setup.node), ms(50), "an abort of the client")
        effect(t, before[0], "a download that was aborted")


def _opened(t: NodeTester, request: bytes) -> None:
    got = t.asked(request, "block download to 1017h", HEARTBEAT)
    if got[0] >> 5 != Answer.BLOCK_DOWNLOAD or got[0] & 3:
        raise Fail("a block download is opened wrongly", "A0h or A4h", hexed(got))


def _acknowledged(t: NodeTester, number: int, good: int) -> None:
    got = t.asked(sdo.block_segment(number, DATA, True), f"segment {number} of a block download")
    if got[0] != Answer.BLOCK_DOWNLOAD << 5 | 2 or got[1] != good:
        raise Fail(f"segment {number} is acknowledged with {hexed(got)}", f"A2h {good:02X}h", hexed(got))


@MORE.case(
    "BV_12",
    "a block download whose first segment is lost: the acknowledgement asks for it again",
    "ein Block-Download ohne sein erstes Segment: die Quittung fordert es noch einmal an",
    clause="CiA 301, 7.2.4.3.10",
    condition=BLOCKS,
    preamble=ONE_BLOCK,
)
def gap(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        with t.given():
            _opened(t, block_download(HEARTBEAT, 2))
        try:
            _acknowledged(t, 2, 0)
        except Aborted as refused:
            if refused.code != Abort.SEQUENCE:
                raise
            raise Warn("a lost segment ends the transfer; the client must start again", "A2h 00h", refused.got) from refused
        _acknowledged(t, 1, 1)
        got = t.asked(sdo.block_end(Request.BLOCK_DOWNLOAD, 5, sdo.crc(DATA)), "the end of a block download")
        block_ended(t, got, "a block download with a repeated segment")


@MORE.case(
    "BV_13",
    "a block download of a client without CRC is not checked",
    "ein Block-Download eines Clients ohne CRC wird nicht geprüft",
    clause="CiA 301, 7.2.4.3.9",
    condition=BLOCKS,
    preamble=ONE_BLOCK,
)
def no_crc(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        with t.given():
            _opened(t, sdo.initiate_block(Request.BLOCK_DOWNLOAD, HEARTBEAT, 2, False))
            _acknowledged(t, 1, 1)
        got = t.asked(sdo.block_end(Request.BLOCK_DOWNLOAD, 5, 0), "the end of a block download without CRC")
        block_ended(t, got, "a block download without CRC")


@NAMES.case("BI_07", "an abort names the object that was asked for", "ein Abbruch nennt das angefragte Objekt")
def named_object(t: NodeTester) -> None:
    key = (0x1FF0, 0x12)
    for request in (sdo.initiate(Request.INITIATE_UPLOAD, key), sdo.expedited(Request.INITIATE_DOWNLOAD, key, b"\x01")):
        got = t.ask(request)
        if len(got) != 8 or got[0] != Answer.ABORT << 5:
            raise Warn(f"{named(key)} is not refused", "an abort", hexed(got))
        if (found := sdo.key_of(got)) != key:
            raise Fail(f"the abort names {named(found)}", named(key), hexed(got))
