"""How late this host is: a small process for each core, which sleeps two milliseconds again and again and notes when it woke late.

It keeps the worst of each twentieth of a second: on a busy host it is late all the time, and a long case must not lose the worst of it.
"""

import contextlib
import mmap
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

from protocols.base.machine import Ns, ms

SPAN = 50_000_000  # of one entry
ENTRIES = 2400  # two minutes
ASLEEP = 2_000_000  # at a time
AWAKE = 1_000_000  # so late is not late
EARLIER = 20  # entries: who woke after the beginning may have gone to sleep a second before it
ENTRY = struct.Struct("qq")  # moment, lateness
SIZE = ENTRIES * ENTRY.size
PROGRAM = f"""
import mmap, os, struct, sys, time
entry, core, bed, parent = struct.Struct("qq"), int(sys.argv[2]), int(sys.argv[3]), os.getppid()
file = open(sys.argv[1], "r+b")
kept = mmap.mmap(file.fileno(), 0)
try:
    os.sched_setaffinity(0, {{core}})
except (AttributeError, OSError):
    pass
while os.getppid() == parent:
    start = time.monotonic_ns()
    entry.pack_into(kept, bed, start, 0)
    time.sleep(0.002)
    late = time.monotonic_ns() - start - 2_000_000
    if late > 1_000_000:
        place = core * {SIZE} + start // {SPAN} % {ENTRIES} * {ENTRY.size}
        before, worst = entry.unpack_from(kept, place)
        if before // {SPAN} != start // {SPAN} or late > worst:
            entry.pack_into(kept, place, start, late)
"""
MOST_CORES = 16


class Witness:
    """`late()` since the last `begin()`, or since a moment after it; without processes where they cannot be started."""

    def __init__(self) -> None:
        self._cores = min(os.cpu_count() or 1, MOST_CORES)
        handle, name = tempfile.mkstemp(prefix="axisgate-witness-")
        self._path = pathlib.Path(name)
        with os.fdopen(handle, "r+b") as file:
            file.write(bytes((SIZE + ENTRY.size) * self._cores))
            file.flush()
            self._kept = mmap.mmap(file.fileno(), 0)
        self._children: list[subprocess.Popen[bytes]] = []
        with contextlib.suppress(OSError):
            for core in range(self._cores):
                self._children.append(
                    subprocess.Popen(
                        [sys.executable, "-I", "-S", "-c", PROGRAM, name, str(core), str(self._bed(core))], stderr=subprocess.DEVNULL
                    )
                )
        self._since = time.monotonic_ns()

    def begin(self) -> None:
        self._since = time.monotonic_ns()

    def late(self, since: Ns | None = None) -> Ns:
        """The worst of all cores since then; wakes of less than one millisecond are none.  One that has not woken yet is late already."""
        begin = self._since if since is None else since
        now = time.monotonic_ns()
        worst, last = max((now - asleep - ASLEEP for asleep in self._asleep()), default=0), now // SPAN
        worst = worst if worst > AWAKE else 0
        for span in range(max(begin // SPAN - EARLIER, last - ENTRIES + 1), last + 1):
            for core in range(self._cores):
                moment, late = ENTRY.unpack_from(self._kept, core * SIZE + span % ENTRIES * ENTRY.size)
                if moment + late >= begin and late > worst:
                    worst = late
        return min(worst, ms(60_000))

    def _asleep(self) -> list[Ns]:
        """Since when each one sleeps."""
        return [moment for core in range(self._cores) if (moment := ENTRY.unpack_from(self._kept, self._bed(core))[0])]

    def _bed(self, core: int) -> int:
        return SIZE * self._cores + core * ENTRY.size

    def close(self) -> None:
        for child in self._children:
            child.kill()
            child.wait()
        self._kept.close()
        with contextlib.suppress(OSError):
            self._path.unlink()
