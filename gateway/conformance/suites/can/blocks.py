"""SDO block transfers of the tester's side, step by step.  Source: CiA 301, 7.2.4.3.9 to 7.2.4.3.16."""

import struct

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import NodeTester, named
from gateway.pure.conformance.verdict import Fail
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.dictionary import Key
from protocols.canopen.sdo import Answer, BlockUpload, Request

MOST_BLOCKS = 500


def block_upload(key: Key, size: int = sdo.MOST_BLOCK, threshold: int = 0) -> bytes:
    """Initiate: block size and protocol switch threshold in the last four bytes."""
    return struct.pack("<BHBBBH", Request.BLOCK_UPLOAD << 5 | sdo.CRC_SUPPORT, *key, size, threshold, 0)


def block_download(key: Key, size: int) -> bytes:
    return sdo.initiate_block(Request.BLOCK_DOWNLOAD, key, size, True)


class Upload:
    """One block upload; `resend`: the first block is acknowledged but for its last segment, which must come again."""

    def __init__(self, t: NodeTester, key: Key, block: int, resend: bool = False) -> None:
        self._t, self._what, self._block, self._resend = t, f"block upload of {named(key)}", block, resend
        self._key = key
        self._data = b""

    def run(self) -> bytes:
        t, what = self._t, self._what
        got = t.asked(block_upload(self._key, self._block), what, self._key)
        if got[0] >> 5 != Answer.BLOCK_UPLOAD or got[0] & sdo.BLOCK_END:
            raise Fail(f"{what}: command byte {got[0]:02X}h", "C0h to C6h", hexed(got))
        size = sdo.size_of(got) if got[0] & sdo.BLOCK_SIZED else None
        t.say(cobid.sdo_request(t.setup.node), sdo.short(Request.BLOCK_UPLOAD, BlockUpload.START))
        for _ in range(MOST_BLOCKS):
            if self._one_block():
                break
        self._end(bool(got[0] & sdo.CRC_SUPPORT))
        if size is not None and size != len(self._data):
            raise Fail(f"{what}: {len(self._data)} bytes received", f"{size} bytes, as announced", f"{len(self._data)} bytes")
        return self._data

    def _one_block(self) -> bool:
        """True after the last one."""
        t, what = self._t, self._what
        pieces, final = list[bytes](), False
        while len(pieces) < self._block and not final:
            frame = t.hear((cobid.sdo_answer(t.setup.node),), t.setup.wait)
            if frame is None or len(frame.data) != 8 or frame.data[0] & 0x7F != len(pieces) + 1:
                got = "nothing" if frame is None else hexed(frame.data)
                raise Fail(f"{what}: segment {len(pieces) + 1} of a block", f"sequence number {len(pieces) + 1}", got)
            pieces.append(frame.data[1:])
            final = bool(frame.data[0] & sdo.FINAL_SEGMENT)
        good = len(pieces)
        if self._resend and good > 1:
            self._resend, good, final = False, good - 1, False
        self._data += b"".join(pieces[:good])
        t.say(cobid.sdo_request(t.setup.node), sdo.short(Request.BLOCK_UPLOAD, BlockUpload.RESPONSE, good, self._block))
        return final

    def _end(self, checked: bool) -> None:
        t, what = self._t, self._what
        frame = t.hear((cobid.sdo_answer(t.setup.node),), t.setup.wait)
        got = b"" if frame is None else frame.data
        if len(got) != 8 or got[0] & 0xE3 != Answer.BLOCK_UPLOAD << 5 | sdo.BLOCK_END:
            raise Fail(f"{what}: no end after the last block", "C1h to DDh", hexed(got))
        unused = got[0] >> 2 & 7
        self._data = self._data[: len(self._data) - unused] if unused else self._data
        crc = int.from_bytes(got[1:3], "little")
        if checked and crc != sdo.crc(self._data):
            raise Fail(f"{what}: CRC {crc:04X}h", f"CRC {sdo.crc(self._data):04X}h", hexed(got))
        t.say(cobid.sdo_request(t.setup.node), sdo.short(Request.BLOCK_UPLOAD, BlockUpload.END))


def write_block(t: NodeTester, key: Key, data: bytes, crc: int | None = None) -> bytes:
    """A download of one block; the answer to its end."""
    what = f"block download to {named(key)}"
    got = t.asked(block_download(key, len(data)), what, key)
    if got[0] >> 5 != Answer.BLOCK_DOWNLOAD or not 1 <= got[4] <= sdo.MOST_BLOCK:
        raise Fail(f"{what}: initiate answered with {hexed(got)}", "A0h or A4h, a block size 1 to 127", hexed(got))
    got = t.asked(sdo.block_segment(1, data, True), f"{what}, its segment")
    if got[0] != Answer.BLOCK_DOWNLOAD << 5 | 2 or got[1] != 1:
        raise Fail(f"{what}: the segment is acknowledged with {hexed(got)}", "A2h 01", hexed(got))
    return t.ask(sdo.block_end(Request.BLOCK_DOWNLOAD, 7 - len(data), sdo.crc(data) if crc is None else crc))
