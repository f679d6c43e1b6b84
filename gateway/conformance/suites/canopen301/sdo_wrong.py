"""CANopen, SDO server: requests that must be refused, with which code, and without effect (CiA 301, table 22)."""

from collections.abc import Callable
from typing import NamedTuple

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.blocks import block_upload, write_block
from gateway.conformance.suites.can.node import HEARTBEAT, NodeTester
from gateway.conformance.suites.canopen301.sdo import BASIC, BLOCKS, LONG, SEGMENTED, VALUE, WRITE, effect, segmented
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort, Answer, Request

REFUSED = Purposes[NodeTester]("CO301_SDO", "server", "CiA 301, 7.2.4", preamble=(BASIC,))
LENGTHS = (Abort.LENGTH, Abort.TOO_LONG, Abort.TOO_SHORT)
DOWNLOAD = ("heartbeat", "segmented")


@REFUSED.case(
    "BI_01",
    "a wrong toggle bit in an upload: 05030000h",
    "ein falsches Toggle-Bit im Upload: 05030000h",
    condition=LONG,
    preamble=SEGMENTED,
)
def toggle_up(t: NodeTester) -> None:
    with t.given():
        t.asked(sdo.initiate(Request.INITIATE_UPLOAD, t.setup.text), "upload", t.setup.text)
    t.refused(sdo.short(Request.UPLOAD_SEGMENT, sdo.TOGGLE), (Abort.TOGGLE,), "a wrong toggle bit", (Abort.COMMAND, Abort.GENERAL))


class Row(NamedTuple):
    """A refused write to 1017h.  act: sends it and returns the last answer."""

    number: int
    what: str
    what_de: str
    codes: tuple[int, ...]
    condition: tuple[str, ...]
    preamble: tuple[str, ...]
    act: Callable[[NodeTester], bytes]


def _two(value: int) -> bytes:
    return value.to_bytes(2, "little")


ROWS = (
    Row(
        *(2, "a wrong toggle bit in a download", "ein falsches Toggle-Bit im Download", (Abort.TOGGLE,), DOWNLOAD),
        *((BASIC, WRITE, "CO301_SDO_BV_05"), lambda t: segmented(t, _two(VALUE), 2, toggle=True)),
    ),
    Row(
        *(
            3,
            "a download of four bytes to an object of two",
            "vier Bytes für ein Objekt von zwei",
            (Abort.TOO_LONG, Abort.LENGTH),
            ("heartbeat",),
        ),
        *((BASIC, WRITE), lambda t: t.ask(sdo.expedited(Request.INITIATE_DOWNLOAD, HEARTBEAT, _two(VALUE) + bytes(2)))),
    ),
    Row(
        *(
            4,
            "a download of one byte to an object of two",
            "ein Byte für ein Objekt von zwei",
            (Abort.TOO_SHORT, Abort.LENGTH),
            ("heartbeat",),
        ),
        *((BASIC, WRITE), lambda t: t.ask(sdo.expedited(Request.INITIATE_DOWNLOAD, HEARTBEAT, b"\x7b"))),
    ),
    Row(
        *(5, "a segmented download longer than announced", "ein segmentierter Download länger als angekündigt", LENGTHS, DOWNLOAD),
        *((BASIC, WRITE, "CO301_SDO_BV_05"), lambda t: segmented(t, _two(VALUE) + b"\x01", 2)),
    ),
    Row(
        *(6, "a block download with a wrong CRC", "ein Block-Download mit falscher CRC", (Abort.CRC,), ("heartbeat", "block")),
        *((BASIC, WRITE, "CO301_SDO_BV_09"), lambda t: write_block(t, HEARTBEAT, _two(VALUE), sdo.crc(_two(VALUE)) ^ 0x0100)),
    ),
)


def _refused(row: Row) -> None:
    codes = ", ".join(f"{code:08X}h" for code in row.codes)

    @REFUSED.case(
        f"BI_{row.number:02}",
        f"{row.what} is refused ({codes}), without effect",
        f"{row.what_de} wird abgelehnt ({codes}), wirkungslos",
        clause="CiA 301, table 22",
        condition=row.condition,
        preamble=row.preamble,
    )
    def body(t: NodeTester) -> None:
        with t.kept(HEARTBEAT) as before:
            t.judge_refusal(row.act(t), row.codes, row.what, (Abort.GENERAL, Abort.COMMAND, Abort.INCOMPATIBLE))
            effect(t, before[0], row.what)


for _row in ROWS:
    _refused(_row)


@REFUSED.case("BI_07", "an unknown command specifier: 05040001h", "ein unbekannter Befehl: 05040001h", clause="CiA 301, table 22")
def unknown(t: NodeTester) -> None:
    t.refused(b"\xe0" + bytes(7), (Abort.COMMAND,), "command byte E0h", (Abort.GENERAL,))


@REFUSED.case("BI_08", "a segment without an upload: 05040001h", "ein Segment ohne Upload: 05040001h", clause="CiA 301, table 22")
def segment_alone(t: NodeTester) -> None:
    t.refused(sdo.short(Request.UPLOAD_SEGMENT), (Abort.COMMAND,), "a segment request without an upload", (Abort.TOGGLE, Abort.GENERAL))


@REFUSED.case(
    "BI_09",
    "a block size of 0 or 128: 05040002h",
    "eine Blockgröße von 0 oder 128: 05040002h",
    condition=BLOCKS,
    preamble=(BASIC, "CO301_SDO_BV_04", "CO301_SDO_BV_06"),
)
def block_size(t: NodeTester) -> None:
    for size in (0, 128):
        t.refused(block_upload(t.setup.long, size), (Abort.BLOCK_SIZE,), f"a block size of {size}", (Abort.COMMAND, Abort.GENERAL))


@REFUSED.case(
    "BI_10",
    "a refused initiate opens no transfer",
    "ein abgelehnter Beginn eröffnet keinen Transfer",
    condition=LONG,
    preamble=(*SEGMENTED, "CO301_DIC_BI_01"),
)
def nothing_open(t: NodeTester) -> None:
    got = t.ask(sdo.initiate(Request.INITIATE_UPLOAD, (0x1FF0, 0)))
    if got[:1] != b"\x80":
        raise Fail("1FF0h is not refused", "an abort", hexed(got))
    got = t.ask(sdo.short(Request.UPLOAD_SEGMENT))
    if len(got) != 8 or got[0] != Answer.ABORT << 5:
        raise Fail("a segment after a refused upload", "an abort", hexed(got))
