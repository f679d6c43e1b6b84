"""CANopen: SDO servers with one fault each (used by peers.canopen301)."""

from drivers.emulator.canopen.sdo import Phase, SdoServer
from gateway.conformance.peers.can_devices import Drive, Tune
from protocols.base.machine import Ns
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort


class NoToggleCheck(SdoServer):
    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase in (Phase.UPLOAD, Phase.DOWNLOAD) and request[0] >> 5 in (0, 3):
            request = bytes((request[0] & ~sdo.TOGGLE | sdo.TOGGLE * self._toggle,)) + request[1:]
        return super().handle(request, now)


class NoCrcCheck(SdoServer):
    def _block_download_end(self, request: bytes) -> list[bytes]:
        self._crc = False
        return super()._block_download_end(request)


class AnySize(SdoServer):
    """Takes more bytes than were announced, and cuts."""

    def _complete(self) -> int:
        self._size = None
        del self._data[2:]
        return super()._complete()


class AnyBlock(SdoServer):
    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if request[0] >> 5 == sdo.Request.BLOCK_UPLOAD and not request[0] & 3 and not 1 <= request[4] <= 127:
            request = request[:4] + b"\x40" + request[5:]
        return super().handle(request, now)


class NoRepeat(SdoServer):
    """Continues after what it sent, whatever was acknowledged."""

    def _acknowledged(self, good: int, block: int) -> list[bytes]:
        return super()._acknowledged(self._sequence, block)


class BigBlocks(SdoServer):
    """Ignores the block size of the client."""

    def _next_block(self) -> list[bytes]:
        self._wanted = 127
        return super()._next_block()


class Holds(SdoServer):
    """A transfer begun is carried on, whatever comes."""

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase is Phase.UPLOAD and request[0] >> 5 == sdo.Request.INITIATE_UPLOAD:
            return self._abort(Abort.COMMAND)
        return super().handle(request, now)


class AnswersAborts(SdoServer):
    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        said = super().handle(request, now)
        return said or [sdo.abort((0, 0), Abort.GENERAL)] if request[0] == 0x80 else said


class HangsInBlocks(SdoServer):
    """Keeps waiting for a client that aborted a block upload."""

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if self._phase is Phase.BLOCK_OUT_START and request[0] == 0x80:
            return []
        return [] if self._phase is Phase.BLOCK_OUT_START and request[0] >> 5 == 2 else super().handle(request, now)


def server(kind: type[SdoServer]) -> Tune:
    def tune(drive: Drive) -> None:
        drive.node.sdo = kind(drive.node.objects)

    return tune
