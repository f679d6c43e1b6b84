"""A Modbus server that takes what arrives at once for a request: right with whole requests, its fault is one that comes in pieces."""

import struct

from gateway.conformance.peers.score import play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.pure.conformance.verdict import Verdict


class PlainServer:
    """FC 3, registers 0 to 19, each with its number."""

    def __init__(self) -> None:
        self._output = b""

    def receive(self, data: bytes, now: int) -> list[object]:
        if len(data) >= 12:
            start, count = struct.unpack_from(">HH", data, 8)
            good = data[7] == 3 and 1 <= count <= 125 and start + count <= 20
            values = b"".join(struct.pack(">H", start + n) for n in range(count)) if good else b""
            body = bytes((3, 2 * count)) + values if good else bytes((data[7] | 0x80, 1 if data[7] != 3 else 2))
            self._output += data[:4] + struct.pack(">HB", len(body) + 1, data[6]) + body
        return []

    def take_output(self) -> bytes:
        said, self._output = self._output, b""
        return said

    def deadline(self) -> int | None:
        return None

    def wake(self, now: int) -> list[object]:
        return []

    sent = lost = wake

    def damaged(self, kind: object, now: int) -> list[object]:
        return []


def test_a_request_that_is_written_at_once_arrives_at_once() -> None:
    device = Variant("plain-server", "", PlainServer, {}, {})
    found = {one.purpose.id: one.verdict for one in play(SUITES["modbus-tcp"], device, ("MBTCP_FUN_BV_01", "MBTCP_TCP_BV_03"))}
    assert found["MBTCP_FUN_BV_01"] is Verdict.PASS
    assert found["MBTCP_TCP_BV_03"] is Verdict.FAIL, "cut in two it is not answered"
