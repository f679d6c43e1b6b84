"""Writers that die by SIGKILL at a chosen store, in a child process; payloads that show a tear."""

import os
import signal
import zlib
from collections.abc import Callable

from gateway.runtime.regions import RegionWriter, RingWriter

PAYLOAD = 1024  # bytes of a payload or record: number (8), filling, CRC (4)


def payload(number: int, size: int = PAYLOAD) -> bytes:
    """A payload nobody can mix from two others without being noticed."""
    body = number.to_bytes(8, "little") + bytes([number % 251]) * (size - 12)
    return body + zlib.crc32(body).to_bytes(4, "little")


def number_of(octets: bytes) -> int:
    """Its number; AssertionError when it is torn."""
    assert zlib.crc32(octets[:-4]) == int.from_bytes(octets[-4:], "little"), f"torn: {octets[:16].hex(' ')} ... {octets[-16:].hex(' ')}"
    return int.from_bytes(octets[:8], "little")


class Executioner:
    """Counts stores and ends the process at the chosen one: before it, or in the middle of a payload."""

    def __init__(self, fatal: int, half: bool) -> None:
        self.fatal, self.half, self.stores = fatal, half, 0

    def __call__(self, store: Callable[[], None], half_store: Callable[[], None]) -> None:
        self.stores += 1
        if self.stores == self.fatal:
            if self.half:
                half_store()
            os.kill(os.getpid(), signal.SIGKILL)
        store()


def _nothing() -> None:
    """A 64-bit store has no middle."""


class DyingRegion(RegionWriter):
    """A region's writer under the executioner, its take-over of the region included."""

    executioner: Executioner

    def _store(self, view: memoryview, at: int, value: int) -> None:
        self.executioner(lambda: super(DyingRegion, self)._store(view, at, value), _nothing)

    def _fill(self, at: int, octets: bytes | bytearray | memoryview) -> None:
        whole, half = super()._fill, octets[: len(octets) // 2]
        self.executioner(lambda: whole(at, octets), lambda: whole(at, half))


class DyingRing(RingWriter):
    """A ring's writer under the executioner."""

    executioner: Executioner

    def _store(self, view: memoryview, at: int, value: int) -> None:
        self.executioner(lambda: super(DyingRing, self)._store(view, at, value), _nothing)

    def _fill(self, at: int, octets: bytes | bytearray | memoryview) -> None:
        whole, half = super()._fill, octets[: len(octets) // 2]
        self.executioner(lambda: whole(at, octets), lambda: whole(at, half))


def dies(action: Callable[[Executioner], None], fatal: int, half: bool) -> bool:
    """Run `action` in a child; True: it died at store `fatal`, False: it lived to its end (that store does not exist)."""
    child = os.fork()
    if not child:
        try:
            action(Executioner(fatal, half))
        except BaseException:
            os._exit(9)
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    code = os.waitstatus_to_exitcode(status)
    assert code in (0, -signal.SIGKILL), f"the writing child ended with {code}"
    return code != 0
