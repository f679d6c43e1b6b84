"""Life counter of a process without a region of its own (broker, adapter, page, northbound).

The supervisor passes down a region whose descriptor is in $AXISGATE_LIFE.  The loop of the process beats, never a separate thread or timer:
a loop that hangs shows no life.
"""

import os
import time

from gateway.runtime.regions import ImageError, RegionWriter

VARIABLE = "AXISGATE_LIFE"
BEAT_S = 0.1  # longest interval of beats


class Life:
    """Life counter of this process; without a supervisor nothing happens."""

    def __init__(self) -> None:
        self._region: RegionWriter | None = None
        fd = os.environ.pop(VARIABLE, "")  # not inherited by children of this process
        if fd.isdecimal():
            try:
                self._region = RegionWriter(int(fd))
            except (ImageError, OSError):
                self._region = None  # a descriptor number of another file

    def beat(self) -> None:
        """The loop has come round."""
        if self._region is not None:
            self._region.beat(time.monotonic_ns())
