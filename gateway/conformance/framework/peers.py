"""Programs on this host at the other end of a port: how long they waited for a processor.

Linux only (proc(5), pid/schedstat: its second number is the time on a run queue).  Elsewhere, and if no such program is found, the witness
processes are used instead.  A program is found by its open files: the other end of a pty, also through a simulated cable, or the listening
socket of a TCP address of this host.
"""

import contextlib
import os
import pathlib
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

from protocols.base.machine import Ns, ms

EDGE = ms(100)  # of a span: actions of a program at its begin and for its end fall in here
STEP = ms(250)  # of a dialogue: somewhat more than the longest gap within a block
APART = ms(1)  # least time between two samples
SAMPLES = 20_000
PTS, SOCKET, INDEX = re.compile(r"/dev/pts/(\d+)$"), re.compile(r"socket:\[(\d+)\]$"), re.compile(r"^tty-index:\s*(\d+)$", re.M)
LISTENS = "0A"
LOCAL = ("127.", "localhost", "[::1]", "::1")


@dataclass(frozen=True, slots=True)
class Sample:
    """waited: sum of all their threads; stuck: since this moment they have had no processor although they needed one."""

    now: Ns
    waited: Ns
    stuck: Ns
    own: Ns = 0  # the same of the tester


class Peers:
    """The programs at the other end of a bench's address."""

    def __init__(self, url: str, root: pathlib.Path = pathlib.Path("/proc")) -> None:
        self._url, self._root = url, root
        self._pids: tuple[int, ...] = ()
        self._kept: list[Sample] = []
        self._counters = ""

    @property
    def known(self) -> bool:
        return bool(self._pids)

    def look(self) -> None:
        """Find them; a restarted program counts as another one.  Takes some milliseconds: call it between two cases."""
        if any(not (self._root / str(pid)).exists() for pid in self._pids) or not self._pids:
            with contextlib.suppress(OSError):
                self._pids = tuple(sorted(self._holders() - {os.getpid()}))
            self._kept.clear()

    # ---- who holds the other end
    def _holders(self) -> set[int]:
        if self._url.startswith("tcp://"):
            host, _, port = self._url[6:].rpartition(":")
            inodes = self._listening(int(port)) if host.startswith(LOCAL) and port.isdecimal() else set()
            return {pid for pid, link, _ in self._links() if (found := SOCKET.search(link)) and found[1] in inodes} if inodes else set()
        found = PTS.match(os.path.realpath(self._url.removeprefix("pty:")))
        return self._of_pty(int(found[1])) if found else set()

    def _listening(self, port: int) -> set[str]:
        inodes = set()
        for name in ("tcp", "tcp6"):
            with contextlib.suppress(OSError):
                for line in (self._root / "net" / name).read_text().splitlines()[1:]:
                    fields = line.split()
                    if fields[3] == LISTENS and int(fields[1].rpartition(":")[2], 16) == port:
                        inodes.add(fields[9])
        return inodes

    def _of_pty(self, number: int) -> set[int]:
        """Programs that have its master open; for a cable, which has several masters, those at their other ends too."""
        masters: dict[int, set[int]] = {}
        slaves: dict[int, set[int]] = {}
        for pid, link, details in self._links():
            if found := PTS.search(link):
                slaves.setdefault(int(found[1]), set()).add(pid)
            elif link.endswith("ptmx") and (index := INDEX.search(details.read_text())):
                masters.setdefault(int(index[1]), set()).add(pid)
        holders = set(masters.get(number, ()))
        beyond = {pid for other, held in masters.items() if other != number and held & holders for pid in slaves.get(other, ())}
        return holders | beyond

    def _links(self) -> Iterator[tuple[int, str, pathlib.Path]]:
        """Every readable open file of every process: process, target, details."""
        for folder in self._root.iterdir():
            if folder.name.isdecimal():
                with contextlib.suppress(OSError):
                    for descriptor in (folder / "fd").iterdir():
                        with contextlib.suppress(OSError):
                            yield int(folder.name), os.readlink(descriptor), folder / "fdinfo" / descriptor.name

    # ---- how long they waited
    def sample(self, now: Ns, own: Ns = 0) -> None:
        """Again and again; two within a millisecond are one.  own: how long the tester has waited so far."""
        if not self._pids or (self._kept and now - self._kept[-1].now < APART):
            return
        before = self._kept[-1] if self._kept else Sample(now, 0, now)
        counters, waited, wants = [], 0, False
        for pid in self._pids:
            with contextlib.suppress(OSError, ValueError, IndexError):
                for task in (self._root / str(pid) / "task").iterdir():
                    text = (task / "schedstat").read_text()
                    waited += int(text.split()[1])
                    counters.append(text)
                    wants = wants or (task / "stat").read_text().rpartition(")")[2].split()[0] == "R"
        shown = "".join(counters)
        stuck = before.stuck if wants and shown == self._counters else now
        self._counters = shown
        del self._kept[: max(0, len(self._kept) - SAMPLES)]
        self._kept.append(Sample(now, max(waited, before.waited), stuck, own))

    def within(self, since: Ns) -> Ns:
        """All they waited since then."""
        if not self._kept:
            return 0
        last = self._kept[-1]
        return last.waited - self._at(since).waited + (last.now - max(last.stuck, since) if last.now > since else 0)

    def worst(self, since: Ns) -> Ns:
        """The most that tester and device waited together within a quarter of a second, since then."""
        found, first = 0, bisect_left(self._kept, since, key=_moment)
        start = first
        for sample in self._kept[first:]:
            while sample.now - self._kept[start].now > STEP:
                start += 1
            then = self._kept[start]
            stuck = sample.now - max(sample.stuck, then.now)
            found = max(found, sample.waited - then.waited + sample.own - then.own + max(stuck, 0))
        return found

    def ends(self, since: Ns) -> Ns:
        """Waits at the begin and at the end of the span: those between do not shift what the programs do."""
        if not self._kept:
            return 0
        last = self._kept[-1]
        if last.now - since <= 2 * EDGE:
            return self.within(since)
        return self._at(since + EDGE, later=True).waited - self._at(since).waited + self.within(last.now - EDGE)

    def _at(self, moment: Ns, later: bool = False) -> Sample:
        """The last sample until that moment, or the first one from it on."""
        place = bisect_left(self._kept, moment, key=_moment) if later else bisect_right(self._kept, moment, key=_moment) - 1
        return self._kept[min(max(place, 0), len(self._kept) - 1)]


def _moment(sample: Sample) -> Ns:
    return sample.now
