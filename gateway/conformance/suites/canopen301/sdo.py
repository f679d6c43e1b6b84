"""CANopen, SDO server: expedited, segmented and block transfers, their times and their long runs (CiA 301, 7.2.4)."""

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.blocks import Upload, write_block
from gateway.conformance.suites.can.node import DEVICE_TYPE, HEARTBEAT, NodeTester, named
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort, Answer, Request

BASIC, WRITE = "CO301_SDO_BV_01", "CO301_SDO_BV_03"
SDO = Purposes[NodeTester]("CO301_SDO", "server", "CiA 301, 7.2.4", preamble=(BASIC,))
LONG, BLOCKS = ("segmented",), ("segmented", "block")
SEGMENTED, BLOCKED = (BASIC, "CO301_SDO_BV_04"), (BASIC, "CO301_SDO_BV_04", "CO301_SDO_BV_06")
VALUE = 1234  # for 1017h: a heartbeat is not due while a case lasts


def effect(t: NodeTester, value: int, what: str) -> None:
    got = t.number(HEARTBEAT)
    if got != value:
        raise Fail(f"1017h after {what} is {got}", str(value), str(got))


@SDO.case(
    "BV_01",
    "an expedited upload of 1000h is answered with 43h, index and sub-index",
    "ein Expedited-Upload von 1000h wird mit 43h, Index und Sub-Index beantwortet",
    preamble=(),
    beside=Particulars(limits="within [link] answer_ms, 1000 ms unless stated", postamble=False),
)
def upload(t: NodeTester) -> None:
    got = t.asked(sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE), "upload of 1000h", DEVICE_TYPE)
    t.timed("SDO answer", t.answered_at - t.asked_at, None, t.setup.wait)
    judge_form(t, got, "1000h", 4)


def judge_form(t: NodeTester, got: bytes, name: str, size: int) -> None:
    """WARN for the other forms a server may choose: expedited without its size, or in segments (CiA 301, 7.2.4.3.5)."""
    wanted = f"{Answer.INITIATE_UPLOAD << 5 | 4 - size << 2 | sdo.EXPEDITED | sdo.SIZED:02X}h"
    expected = f"{wanted}: expedited, {({1: 'one byte', 2: 'two bytes'}).get(size, 'four bytes')}"
    if f"{got[0]:02X}h" == wanted:
        return
    what = f"upload of {name}: command byte {got[0]:02X}h"
    if got[0] == Answer.INITIATE_UPLOAD << 5 | sdo.EXPEDITED:
        raise Warn(f"{what}; its size is missing, and a master needs it", expected, hexed(got))
    if got[0] & ~sdo.SIZED == Answer.INITIATE_UPLOAD << 5:
        if len(data := t.segments(f"upload of {name}")) == size:
            raise Warn(f"{what}; in segments, which some masters cannot read for so few bytes", expected, hexed(got))
        raise Fail(f"upload of {name}: {len(data)} bytes in segments", f"{size} bytes", hexed(data))
    raise Fail(what, expected, hexed(got))


@SDO.case("BV_02", "an upload of one byte is answered with 4Fh", "ein Upload von einem Byte wird mit 4Fh beantwortet")
def one_byte(t: NodeTester) -> None:
    got = t.asked(sdo.initiate(Request.INITIATE_UPLOAD, (0x1001, 0)), "upload of 1001h", (0x1001, 0))
    judge_form(t, got, "1001h", 1)


@SDO.case(
    "BV_14", "an upload of two bytes is answered with 4Bh", "ein Upload von zwei Byte wird mit 4Bh beantwortet", condition=("heartbeat",)
)
def two_bytes(t: NodeTester) -> None:
    got = t.asked(sdo.initiate(Request.INITIATE_UPLOAD, HEARTBEAT), "upload of 1017h", HEARTBEAT)
    judge_form(t, got, "1017h", 2)


@SDO.case(
    "BI_12",
    "an abort has 8 bytes, with a code of the standard",
    "ein Abbruch hat 8 Byte, mit einem Code der Norm",
    clause="CiA 301, 7.2.4.3.17",
)
def abort_form(t: NodeTester) -> None:
    got = t.ask(sdo.initiate(Request.INITIATE_UPLOAD, (0x1FF0, 0)))
    if got[:1] != bytes((Answer.ABORT << 5,)):
        return  # judged by CO301_DIC_BI_01
    if len(got) != 8:
        raise Fail(f"an abort of {len(got)} bytes", "8 bytes", hexed(got))
    if (code := sdo.abort_of(got).code) not in sdo.TEXTS:
        raise Fail(f"abort code {code:08X}h", "a code of CiA 301, table 22, low byte first", hexed(got))


@SDO.case(
    "BV_03",
    "an expedited download is answered with 60h and has effect",
    "ein Expedited-Download wird mit 60h beantwortet und wirkt",
    condition=("heartbeat",),
)
def download(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        for value in (VALUE, 0x3039, 7001):
            t.download(HEARTBEAT, value, 2)
            effect(t, value, f"a download of {value}")


@SDO.case(
    "BV_04",
    "a segmented upload: size, toggle bits, last segment",
    "ein segmentierter Upload: Länge, Toggle-Bits, letztes Segment",
    condition=LONG,
)
def segmented_upload(t: NodeTester) -> None:
    key = t.setup.text
    got = t.asked(sdo.initiate(Request.INITIATE_UPLOAD, key), f"upload of {named(key)}", key)
    if got[0] not in (0x40, 0x41):
        raise Fail(f"upload of {named(key)}: command byte {got[0]:02X}h", "41h or 40h: segmented", hexed(got))
    data = t.segments(f"upload of {named(key)}")
    if got[0] & sdo.SIZED and sdo.size_of(got) != len(data):
        raise Fail(f"{len(data)} bytes received", f"{sdo.size_of(got)} bytes, as announced", f"{len(data)} bytes")


@SDO.case(
    "BV_05",
    "a segmented download has effect",
    "ein segmentierter Download wirkt",
    condition=("heartbeat", "segmented"),
    preamble=(BASIC, WRITE),
)
def segmented_download(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        got = segmented(t, VALUE.to_bytes(2, "little"), 2)
        if len(got) != 8 or got[0] != Answer.DOWNLOAD_SEGMENT << 5:
            raise Fail("the segment of a download is not acknowledged", "20h", hexed(got))
        effect(t, VALUE, "a segmented download")


def segmented(t: NodeTester, data: bytes, announced: int, toggle: bool = False) -> bytes:
    """A segmented download to 1017h; the answer to its segment."""
    got = t.asked(sdo.initiate(Request.INITIATE_DOWNLOAD, HEARTBEAT, announced), "segmented download to 1017h", HEARTBEAT)
    if got[0] != Answer.INITIATE_DOWNLOAD << 5:
        raise Fail(f"segmented download: command byte {got[0]:02X}h", "60h", hexed(got))
    return t.ask(sdo.segment(Request.DOWNLOAD_SEGMENT, toggle, data, True))


@SDO.case("BV_06", "a block upload: size, order, CRC, same bytes", "ein Block-Upload: Länge, Folge, CRC, gleiche Bytes", condition=BLOCKS)
def block_upload(t: NodeTester) -> None:
    _same(t, Upload(t, t.setup.long, sdo.MOST_BLOCK).run())


def _same(t: NodeTester, got: bytes) -> None:
    with t.given():
        wanted = t.upload(t.setup.long)
        if got != wanted and t.upload(t.setup.long) != wanted:
            raise NotApplicable(f"the value of {named(t.setup.long)} changes by itself")
    if got != wanted:
        raise Fail("a block upload returns other bytes than a segmented one", hexed(wanted), hexed(got))


@SDO.case(
    "BV_07",
    "a block upload in blocks of 1 and 2 segments",
    "ein Block-Upload in Blöcken von 1 und 2 Segmenten",
    condition=BLOCKS,
    preamble=BLOCKED,
)
def small_blocks(t: NodeTester) -> None:
    for size in (1, 2):
        _same(t, Upload(t, t.setup.long, size).run())


@SDO.case(
    "BV_08",
    "a segment that was not acknowledged comes again",
    "ein nicht quittiertes Segment kommt noch einmal",
    condition=BLOCKS,
    preamble=BLOCKED,
)
def again(t: NodeTester) -> None:
    _same(t, Upload(t, t.setup.long, 2, resend=True).run())


def block_ended(t: NodeTester, got: bytes, what: str) -> None:
    """The end of a block download of VALUE was answered so; judged: the answer, and the effect."""
    if len(got) != 8 or got[0] != Answer.BLOCK_DOWNLOAD << 5 | sdo.BLOCK_END:
        raise Fail(f"the end of {what} is not acknowledged", "A1h", hexed(got))
    effect(t, VALUE, what)


@SDO.case("BV_09", "a block download has effect", "ein Block-Download wirkt", condition=("heartbeat", "block"), preamble=(BASIC, WRITE))
def block_download(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        got = write_block(t, HEARTBEAT, VALUE.to_bytes(2, "little"))
        block_ended(t, got, "a block download")


@SDO.case(
    "BV_10",
    "an expedited download that names no size is taken as the object's",
    "ein Expedited-Download ohne Länge gilt in der Länge des Objekts",
    condition=("heartbeat",),
    preamble=(BASIC, WRITE),
)
def no_size(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        got = t.ask(sdo.initiate(Request.INITIATE_DOWNLOAD, HEARTBEAT, flags=sdo.EXPEDITED)[:4] + VALUE.to_bytes(4, "little"))
        if got[:1] == b"\x80":
            raise Warn("a download without size is refused; older masters send them", "60h", hexed(got))
        if got[:1] != b"\x60":
            raise Fail("a download without size is not answered", "60h", hexed(got))
        effect(t, VALUE, "a download without size")


@SDO.case(
    "BO_01",
    "an abort of the client ends a transfer and is not answered",
    "ein Abbruch des Clients beendet einen Transfer ohne Antwort",
    condition=LONG,
    preamble=SEGMENTED,
)
def client_abort(t: NodeTester) -> None:
    key = t.setup.text
    with t.given():
        t.asked(sdo.initiate(Request.INITIATE_UPLOAD, key), "upload", key)
    t.say(cobid.sdo_request(t.setup.node), sdo.abort(key, Abort.GENERAL))
    t.silence(cobid.sdo_answer(t.setup.node), ms(50), "an abort of the client")
    t.refused(sdo.short(Request.UPLOAD_SEGMENT), (Abort.COMMAND,), "a segment after the abort", (Abort.TOGGLE, Abort.GENERAL))


@SDO.case(
    "BO_02",
    "a new request ends a segmented upload",
    "eine neue Anfrage beendet einen segmentierten Upload",
    condition=LONG,
    preamble=SEGMENTED,
)
def new_request(t: NodeTester) -> None:
    with t.given():
        wanted = t.upload(t.setup.text)
        t.asked(sdo.initiate(Request.INITIATE_UPLOAD, t.setup.text), "upload", t.setup.text)
        t.asked(sdo.short(Request.UPLOAD_SEGMENT), "its first segment")
    if len(t.upload(DEVICE_TYPE)) != 4:
        raise Fail("1000h during another upload", "four bytes", "another length")
    if (got := t.upload(t.setup.text)) != wanted:
        raise Fail("the next upload returns other bytes", hexed(wanted), hexed(got))


@SDO.case("BO_03", "a request of seven bytes is not executed", "eine Anfrage mit sieben Bytes wird nicht ausgeführt")
def short_request(t: NodeTester) -> None:
    got = t.ask(sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE)[:7], ms(100))
    if got and got[0] != Answer.ABORT << 5:
        raise Warn("a request of seven bytes is answered", "nothing, or an abort", hexed(got))


@SDO.case("BO_04", "a request to another node is not answered", "eine Anfrage an einen anderen Knoten wird nicht beantwortet")
def other_node(t: NodeTester) -> None:
    other = t.setup.node % cobid.MAX_NODE + 1
    t.say(cobid.sdo_request(other), sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))
    t.silence(cobid.sdo_answer(t.setup.node), ms(100), f"a request to node {other}")


@SDO.case(
    "RC_01",
    "a block upload that is given up leaves the server usable",
    "ein aufgegebener Block-Upload lässt den Server brauchbar",
    condition=BLOCKS,
    preamble=BLOCKED,
)
def given_up(t: NodeTester) -> None:
    from gateway.conformance.suites.can.blocks import block_upload as initiate

    with t.given():
        t.asked(initiate(t.setup.long), "block upload", t.setup.long)
    t.say(cobid.sdo_request(t.setup.node), sdo.abort(t.setup.long, Abort.GENERAL))
    t.pause(ms(20))
    if len(t.upload(DEVICE_TYPE)) != 4:
        raise Fail("1000h after a block upload that was abandoned", "four bytes", "another length")


@SDO.case(
    "TI_01",
    "20 uploads, each answered in time",
    "20 Uploads, jeder rechtzeitig beantwortet",
    beside=Particulars(limits="within [link] answer_ms, 1000 ms unless stated"),
)
def times(t: NodeTester) -> None:
    for _ in range(20):
        t.asked(sdo.initiate(Request.INITIATE_UPLOAD, (0x1001, 0)), "upload of 1001h")
        t.timed("SDO answer", t.answered_at - t.asked_at, None, t.setup.wait)


@SDO.case("ST_01", "300 uploads one after the other, each of them right", "300 Uploads nacheinander, jeder richtig")
def many(t: NodeTester) -> None:
    with t.given():
        wanted = t.upload(DEVICE_TYPE)
    for turn in range(300):
        if (got := t.upload(DEVICE_TYPE)) != wanted:
            raise Fail(f"upload {turn + 1} of 1000h", hexed(wanted), hexed(got))
