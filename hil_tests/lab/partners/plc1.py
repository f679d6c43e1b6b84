"""PLC 1 of the demo: an S5-style program on a 3964R line, high priority, active RK512 partner, DB 10 out and DB 11 in.

Its program knows nothing of axisgate's own blocks: it sets bits and KF words in DB 10 and looks at bits and KF words in DB 11.
"""

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from drivers.ports.open import open_bytes
from hil_tests.lab.partners.rk512_active import ActiveStation, Done, Event, Unasked
from hil_tests.lab.partners.sync_line import SyncLine
from protocols.base.machine import ms
from protocols.p3964r.profiles import SIEMENS_CP525, Priority

COMMAND_DB, STATUS_DB, WORDS, LIFE = 10, 11, 32, 31
PROFILE = replace(SIEMENS_CP525, name="cp525, QVZ 550 ms", ack_delay=ms(550))  # set to the rho 3's QVZ, as both ends must have the same
PATIENCE_S = 30.0  # six attempts of 2 s each and the reaction: then the job has failed


class Block:
    """DB 11 as it was fetched."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def word(self, number: int) -> int:
        """DW number as KF."""
        return int.from_bytes(self.data[2 * number : 2 * number + 2], "big", signed=True)

    def bit(self, word: int, bit: int) -> bool:
        """D word.bit."""
        return bool(self.word(word) >> bit & 1)


class S5Plc:
    """SEND DB 10, FETCH DB 11, and again; whatever its program changes goes out with the next SEND."""

    def __init__(self, port: str, axes: Sequence[str]) -> None:
        self.axes = tuple(axes)
        self.status = Block(bytes(2 * WORDS))
        self.cycles = 0  # SEND and FETCH both done
        self.failures = 0  # jobs given up
        self._port = port
        self._words = [0] * WORDS
        self._extra: list[tuple[int, int, bytes]] = []
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="plc1", daemon=True)

    # ---- its program -------------------------------------------------------------------------------------------------
    def word(self, number: int, value: int) -> None:
        """DW number of DB 10."""
        with self._lock:
            self._words[number] = value & 0xFFFF

    def word_value(self, number: int) -> int:
        """Return the word `number` of DB 10."""
        return self._words[number]

    def bit(self, word: int, bit: int, value: bool) -> None:
        """D word.bit of DB 10."""
        with self._lock:
            self._words[word] = self._words[word] | 1 << bit if value else self._words[word] & ~(1 << bit)

    def pulse(self, word: int, bit: int) -> None:
        """Set a bit for two cycles."""
        self.bit(word, bit, True)
        self.wait_cycles(2)
        self.bit(word, bit, False)

    def send(self, *telegrams: tuple[int, int, bytes]) -> None:
        """Send SENDs (db, word, data) in addition to the cyclic ones, without pauses; return when all are acknowledged."""
        with self._lock:
            self._extra += telegrams
        self.wait(lambda s: not self._extra, PATIENCE_S, f"{len(telegrams)} SENDs")

    def wait(self, holds: Callable[[Block], bool], timeout_s: float, what: str) -> Block:
        """Until the fetched DB 11 fits; TimeoutError names what was waited for."""
        until = time.monotonic() + timeout_s
        while time.monotonic() < until:
            status = self.status
            if holds(status):
                return status
            time.sleep(0.005)
        words = " ".join(f"{self.status.word(n) & 0xFFFF:04X}" for n in range(9))
        raise TimeoutError(
            f"PLC 1 waited {timeout_s:g} s in vain for {what}; DB 11: {words}, {self.cycles} cycles, {self.failures} failed jobs"
        )

    def wait_cycles(self, count: int) -> None:
        """So many whole cycles from now: what was set before has been sent."""
        target = self.cycles + count
        self.wait(lambda s: self.cycles >= target, PATIENCE_S, f"{count} cycles")

    # ---- its communication processor ---------------------------------------------------------------------------------
    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(5)

    def _run(self) -> None:
        active = ActiveStation(9600, PROFILE, Priority.HIGH)
        with SyncLine(lambda: open_bytes(f"pty:{self._port}", "9600 8E1"), active) as line:
            while not self._stop.is_set():
                self._cycle(line, active)

    def _cycle(self, line: SyncLine[Event], active: ActiveStation) -> None:
        with self._lock:
            self._words[LIFE] = (self._words[LIFE] + 1) & 0x7FFF
            image = b"".join(word.to_bytes(2, "big") for word in self._words)
            extra = list(self._extra)
        done = self._job(line, active.send(COMMAND_DB, 0, image, time.monotonic_ns()))
        for item in extra:
            if self._job(line, active.send(*item, time.monotonic_ns())):
                with self._lock:
                    self._extra.remove(item)
        fetched = self._job(line, active.fetch(STATUS_DB, 0, WORDS, time.monotonic_ns()))
        if fetched is not None:
            self.status = Block(fetched.data)
            self.cycles += done is not None

    def _job(self, line: SyncLine[Event], job: int) -> Done | None:
        """Serve the line until this job has an outcome."""
        found: list[Event] = []

        def over() -> bool:
            found.extend(event for _, event in line.events if not isinstance(event, Unasked) and event.job == job)
            line.events.clear()
            return bool(found) or self._stop.is_set()

        line.run_until(over, PATIENCE_S)
        if found and isinstance(found[0], Done):
            return found[0]
        self.failures += 1
        return None
