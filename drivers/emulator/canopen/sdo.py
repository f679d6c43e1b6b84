"""SDO server of an emulated device: expedited, segmented and block transfers both ways.  Source: CiA 301, 7.2.4.

One transfer at a time; a new initiate ends the old one (it is not answered any more), an abort of the client ends it in silence.
"""

from enum import Enum, auto

from drivers.emulator.canopen.objects import MOST_BYTES, Objects, writable
from protocols.base.machine import Ns, ms
from protocols.canopen import sdo
from protocols.canopen.dictionary import Key
from protocols.canopen.sdo import Abort, Answer, BlockUpload, Request

NEVER: Ns = 1 << 62
TIME_OUT_NS = ms(1000)  # between two requests of one transfer (AX-281)


class Phase(Enum):
    IDLE = auto()
    DOWNLOAD = auto()  # segments come
    UPLOAD = auto()  # segments are fetched
    BLOCK_IN = auto()  # segments of a block come
    BLOCK_IN_END = auto()  # the last block is in, waiting for its end
    BLOCK_OUT_START = auto()  # upload initiated, waiting for the start
    BLOCK_OUT = auto()  # a block was sent, waiting for its acknowledgement
    BLOCK_OUT_END = auto()  # end sent, waiting for the client's


class SdoServer:
    """`handle` accepts an 8-byte request and returns the messages to send; never raises on what the client sends."""

    def __init__(self, objects: Objects, block_size: int = sdo.MOST_BLOCK) -> None:
        self._objects, self._block = objects, block_size
        self.due: Ns = NEVER
        self._forget()

    def _forget(self) -> None:
        self._phase, self.due = Phase.IDLE, NEVER
        self._key: Key = (0, 0)
        self._data = bytearray()
        self._size: int | None = None
        self._toggle = self._crc = self._final = False
        self._sequence = self._sent = self._wanted = 0

    def reset(self) -> None:
        self._forget()

    def wake(self, now: Ns) -> list[bytes]:
        """The client was silent too long."""
        return self._abort(Abort.TIMED_OUT) if now >= self.due else []

    def handle(self, request: bytes, now: Ns) -> list[bytes]:
        if len(request) != 8:
            return self._abort(Abort.COMMAND) if self._phase is not Phase.IDLE else []
        if self._phase is Phase.BLOCK_IN and request[0] != Request.ABORT << 5:
            before = len(self._data)
            answers = self._block_segment(request)
            if not answers and len(self._data) == before:
                return []  # no segment of this transfer: requests of a client that knows nothing of it must not keep it alive
        else:
            answers = self._command(request)
        self.due = NEVER if self._phase is Phase.IDLE else now + TIME_OUT_NS
        return answers

    def _command(self, request: bytes) -> list[bytes]:
        match request[0] >> 5:
            case Request.INITIATE_DOWNLOAD:
                return self._initiate_download(request)
            case Request.DOWNLOAD_SEGMENT:
                return self._download_segment(request)
            case Request.INITIATE_UPLOAD:
                return self._initiate_upload(request)
            case Request.UPLOAD_SEGMENT:
                return self._upload_segment(request)
            case Request.BLOCK_DOWNLOAD:
                return self._block_download(request)
            case Request.BLOCK_UPLOAD:
                return self._block_upload(request)
            case Request.ABORT:
                self._forget()
                return []
            case _:
                return self._abort(Abort.COMMAND, sdo.key_of(request))

    def _abort(self, code: int, key: Key | None = None) -> list[bytes]:
        key = self._key if key is None else key
        self._forget()
        return [sdo.abort(key, code)]

    def _begin(self, phase: Phase, key: Key) -> None:
        self._forget()
        self._phase, self._key = phase, key

    # -- download -------------------------------------------------------------------------------

    def _initiate_download(self, request: bytes) -> list[bytes]:
        key, flags = sdo.key_of(request), request[0]
        self._forget()
        if not flags & sdo.EXPEDITED:
            size = sdo.size_of(request) if flags & sdo.SIZED else None
            if code := self._download_refused(key, size):
                return self._abort(code, key)
            self._begin(Phase.DOWNLOAD, key)
            self._size = size
            return [sdo.initiate(Answer.INITIATE_DOWNLOAD, key)]
        data = sdo.expedited_data(request)
        entry = self._objects.dictionary.entries.get(key)
        if entry is not None and not flags & sdo.SIZED and 0 < entry.type.size < 4:
            data = data[: entry.type.size]  # a client that does not state the size means the object's
        if code := self._objects.download(key, data):
            return self._abort(code, key)
        return [sdo.initiate(Answer.INITIATE_DOWNLOAD, key)]

    def _download_refused(self, key: Key, size: int | None) -> int:
        """Check what is known before any data arrive."""
        entry = self._objects.dictionary.entries.get(key)
        if entry is None:
            return self._objects.missing(key)
        return writable(entry, entry.type.size if size is None else size)

    def _download_segment(self, request: bytes) -> list[bytes]:
        if self._phase is not Phase.DOWNLOAD:
            return self._abort(Abort.COMMAND, (0, 0) if self._phase is Phase.IDLE else None)
        toggle = bool(request[0] & sdo.TOGGLE)
        if toggle is not self._toggle:
            return self._abort(Abort.TOGGLE)
        self._data += sdo.segment_data(request)
        if len(self._data) > MOST_BYTES:
            return self._abort(Abort.MEMORY)
        if request[0] & sdo.LAST:
            if code := self._complete():
                return self._abort(code)
            self._forget()
        else:
            self._toggle = not toggle
        return [sdo.short(Answer.DOWNLOAD_SEGMENT, sdo.TOGGLE * toggle)]

    def _complete(self) -> int:
        if self._size is not None and self._size != len(self._data):
            return Abort.LENGTH
        return self._objects.download(self._key, bytes(self._data))

    # -- upload ---------------------------------------------------------------------------------

    def _initiate_upload(self, request: bytes) -> list[bytes]:
        return self._upload(sdo.key_of(request))

    def _upload(self, key: Key) -> list[bytes]:
        data = self._objects.upload(key)
        self._forget()
        if not isinstance(data, bytes):
            return self._abort(data, key)
        if 1 <= len(data) <= 4:
            return [sdo.expedited(Answer.INITIATE_UPLOAD, key, data)]
        self._begin(Phase.UPLOAD, key)
        self._data += data
        return [sdo.initiate(Answer.INITIATE_UPLOAD, key, len(data))]

    def _upload_segment(self, request: bytes) -> list[bytes]:
        if self._phase is not Phase.UPLOAD:
            return self._abort(Abort.COMMAND, (0, 0) if self._phase is Phase.IDLE else None)
        toggle = bool(request[0] & sdo.TOGGLE)
        if toggle is not self._toggle:
            return self._abort(Abort.TOGGLE)
        piece = bytes(self._data[self._sent : self._sent + sdo.SEGMENT_BYTES])
        self._sent += len(piece)
        last = self._sent >= len(self._data)
        self._toggle = not toggle
        if last:
            self._forget()
        return [sdo.segment(Answer.UPLOAD_SEGMENT, toggle, piece, last)]

    # -- block download -------------------------------------------------------------------------

    def _block_download(self, request: bytes) -> list[bytes]:
        if request[0] & sdo.BLOCK_END:
            return self._block_download_end(request)
        key = sdo.key_of(request)
        size = sdo.size_of(request) if request[0] & sdo.BLOCK_SIZED else None
        if code := self._download_refused(key, size):
            return self._abort(code, key)
        self._begin(Phase.BLOCK_IN, key)
        self._size, self._crc = size, bool(request[0] & sdo.CRC_SUPPORT)
        return [sdo.short(Answer.BLOCK_DOWNLOAD, sdo.CRC_SUPPORT, *request[1:4], self._block)]

    def _block_segment(self, segment: bytes) -> list[bytes]:
        """Segments out of order are skipped; the acknowledgement names where to continue."""
        number, final = segment[0] & ~sdo.FINAL_SEGMENT, bool(segment[0] & sdo.FINAL_SEGMENT)
        if number == 0 or number > self._block:
            return self._abort(Abort.SEQUENCE)
        if number == self._sequence + 1:
            self._sequence = number
            self._data += segment[1:]
            self._final = final
            if len(self._data) > MOST_BYTES + sdo.SEGMENT_BYTES:
                return self._abort(Abort.MEMORY)
        if number < self._block and not final:
            return []
        good, self._sequence = self._sequence, 0
        if self._final:
            self._phase = Phase.BLOCK_IN_END
        return [sdo.short(Answer.BLOCK_DOWNLOAD, 2, good, self._block)]

    def _block_download_end(self, request: bytes) -> list[bytes]:
        if self._phase is not Phase.BLOCK_IN_END:
            return self._abort(Abort.COMMAND, (0, 0) if self._phase is Phase.IDLE else None)
        unused = request[0] >> 2 & 7
        if unused:
            del self._data[-unused:]
        if self._crc and sdo.crc(bytes(self._data)) != int.from_bytes(request[1:3], "little"):
            return self._abort(Abort.CRC)
        if code := self._complete():
            return self._abort(code)
        self._forget()
        return [sdo.short(Answer.BLOCK_DOWNLOAD, sdo.BLOCK_END)]

    # -- block upload ---------------------------------------------------------------------------

    def _block_upload(self, request: bytes) -> list[bytes]:
        match request[0] & 3:
            case BlockUpload.INITIATE:
                return self._block_upload_initiate(request)
            case BlockUpload.START if self._phase is Phase.BLOCK_OUT_START:
                self._phase = Phase.BLOCK_OUT
                return self._next_block()
            case BlockUpload.RESPONSE if self._phase is Phase.BLOCK_OUT:
                return self._acknowledged(request[1], request[2])
            case BlockUpload.END if self._phase is Phase.BLOCK_OUT_END:
                self._forget()
                return []
            case _:
                return self._abort(Abort.COMMAND, (0, 0) if self._phase is Phase.IDLE else None)

    def _block_upload_initiate(self, request: bytes) -> list[bytes]:
        key, block, threshold = sdo.key_of(request), request[4], request[5]
        if not 1 <= block <= sdo.MOST_BLOCK:
            return self._abort(Abort.BLOCK_SIZE, key)
        data = self._objects.upload(key)
        if not isinstance(data, bytes):
            return self._abort(data, key)
        if threshold and len(data) <= threshold:
            return self._upload(key)  # so short that the client prefers the plain protocol
        self._begin(Phase.BLOCK_OUT_START, key)
        self._data += data
        self._wanted, self._crc = block, bool(request[0] & sdo.CRC_SUPPORT)
        return [sdo.initiate_block(Answer.BLOCK_UPLOAD, key, len(data), True)]

    def _next_block(self) -> list[bytes]:
        """Up to the wanted number of segments from the first byte not yet acknowledged."""
        messages = []
        for number in range(1, self._wanted + 1):
            at = self._sent + (number - 1) * sdo.SEGMENT_BYTES
            final = at + sdo.SEGMENT_BYTES >= len(self._data)
            messages.append(sdo.block_segment(number, bytes(self._data[at : at + sdo.SEGMENT_BYTES]), final))
            if final:
                break
        self._sequence = len(messages)
        return messages

    def _acknowledged(self, good: int, block: int) -> list[bytes]:
        if good > self._sequence:
            return self._abort(Abort.SEQUENCE)
        if not 1 <= block <= sdo.MOST_BLOCK:
            return self._abort(Abort.BLOCK_SIZE)
        self._sent += good * sdo.SEGMENT_BYTES
        self._wanted = block
        if self._sent < len(self._data) or (not self._data and not good):
            return self._next_block()
        self._phase = Phase.BLOCK_OUT_END
        unused = self._sent - len(self._data)
        return [sdo.block_end(Answer.BLOCK_UPLOAD, unused, sdo.crc(bytes(self._data)) if self._crc else 0)]
