"""An SDO upload with a limit: a device that sends segments for ever gets an abort after so many bytes or seconds."""

import time

from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoAbortedError

MOST_BYTES = 65_536  # of one object that does not announce its size
MOST_S = 20.0
OUT_OF_MEMORY, TIMED_OUT = 0x05040005, 0x05040000


def bounded_upload(client: SdoClient, index: int, sub: int, most: int = MOST_BYTES, most_s: float = MOST_S) -> bytes:
    """As SdoClient.upload; raises SdoAbortedError with the code sent to the device if it does not end, and the exceptions of upload."""
    end = time.monotonic() + most_s
    with client.open(index, sub, buffering=0) as stream:  # type: ignore[no-untyped-call]  # canopen has no types here
        announced = stream.size
        limit = most if announced is None else min(most, announced + 7)  # a last segment may be padded
        data = bytearray()
        while piece := stream.read(7):
            data += piece
            late = time.monotonic() > end
            if late or len(data) > limit:
                code = TIMED_OUT if late else OUT_OF_MEMORY
                client.abort(code)  # type: ignore[no-untyped-call]  # canopen has no types here
                raise SdoAbortedError(code)
    known = client.od.get_variable(index, sub)
    if known is not None and known.fixed_size and (announced is None or len(known) // 8 < announced):
        del data[len(known) // 8 :]  # some devices send 32 bits of a smaller object
    return bytes(data)
