"""`axisgate line monitor`: a line decoded, with times in ms; one port, or two receive-only taps.  Never writes a character."""

import json
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TextIO

from drivers.ports.serial.line_format import LineFormat, Note, Run
from gateway.links.serial.tool_wire import ToolPort
from gateway.pure.lines.decoder import LineDecoder, LineReport, telegram_of
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char

TURN = 0.002  # seconds at one of two taps
IDLE = 0.02
QUIET: Ns = ms(5000)
HOLD: Ns = ms(20)  # longest wait of a character for an earlier one of the other tap: adapters deliver late


def forget(stamp: Ns, side: str, what: int | Damage) -> None:
    """Nothing is kept."""


class Monitor:
    """Reads ports called by their side; `on_report` gets every sentence."""

    def __init__(
        self,
        ports: Sequence[tuple[str, ToolPort]],
        clock: Callable[[], Ns],
        on_report: Callable[[LineReport], None],
        check: bool = True,
        keep: Callable[[Ns, str, int | Damage], None] = forget,
    ) -> None:
        """`keep` gets every character as well."""
        self._ports, self._clock, self._on_report, self._keep = ports, clock, on_report, keep
        self._decoder = LineDecoder(both=len(ports) == 2, block_check=check)
        self._heard: dict[str, deque[tuple[Ns, int | Damage]]] = {side: deque() for side, _ in ports}
        self._latest: Ns = 0
        self.characters = 0

    def run(self, how_long: Ns | None, quiet: Callable[[Ns], None] = lambda silence: None) -> None:
        """For this time, or until interrupted.  `quiet` is called with the time without a byte: after QUIET, then each time
        it has doubled.
        """
        start = since = self._clock()
        count, due = 0, QUIET
        while how_long is None or self._clock() - start < how_long:
            for _, port in self._ports:
                port.wait(TURN if len(self._ports) > 1 else IDLE)
            self.take()
            if self.characters != count:
                count, since, due = self.characters, self._clock(), QUIET
            elif self._clock() - since >= due:
                quiet(due)
                due *= 2
        if not count:
            quiet(self._clock() - start)
        self._decode(self._clock() + HOLD)
        for report in self._decoder.flush(self._clock() + ms(1000)):
            self._on_report(report)

    def take(self) -> None:
        """Read what waits at the ports."""
        now = self._clock()
        for side, port in self._ports:
            for item in port.read():
                self._heard[side] += [(now, what) for what in (item if isinstance(item, bytes) else (item,))]
        self._decode(now)
        if not any(self._heard.values()):
            for report in self._decoder.flush(now):
                self._on_report(report)

    def _decode(self, now: Ns) -> None:
        """In the order of the line: two taps are read in turn, and the protocol decides whose turn it was."""
        while (side := self._next_side(now)) is not None:
            stamp, what = self._heard[side].popleft()
            self.characters += 1
            self._latest = stamp = max(stamp, self._latest)  # delayed characters came before, whatever the stamp of the adapter
            self._keep(stamp, side, what)
            for report in self._decoder.take(stamp, side, what):
                self._on_report(report)

    def _next_side(self, now: Ns) -> str | None:
        waiting = [side for side, heard in self._heard.items() if heard]
        expected = self._decoder.expected()
        if not waiting or expected in waiting:
            return expected if waiting else None
        first = min(waiting, key=lambda side: (self._heard[side][0][0], self._heard[side][0][1] != Char.STX))  # STX opens, nothing else
        held = expected and len(self._heard) > 1 and now - self._heard[first][0][0] < HOLD
        return None if held else first


class Recorder:
    """Writes received characters as a line record: `learn`, `monitor --record` and `export` read it, also if it is incomplete."""

    def __init__(self, out: TextIO, name: str, line_format: LineFormat, now: Ns) -> None:
        self._out = out
        self._put(Note(now, f"ready name={name} baud={line_format.baud} bits={line_format.char_bits} scheduling=tap").line())

    def __call__(self, stamp: Ns, side: str, what: int | Damage) -> None:
        run = Run(stamp, side, b"\0", what.name.lower()) if isinstance(what, Damage) else Run(stamp, side, bytes((what,)))
        self._put(run.line())

    def _put(self, text: str) -> None:
        try:
            self._out.write(text)
        except OSError as error:  # a full disk: the exception names no file
            raise OSError(error.errno, f"nothing more can be kept: {error.strerror}", self._out.name) from error


class Printer:
    """Sentences as lines for a person or as JSON lines for a program."""

    def __init__(self, write: Callable[[str], None], as_json: bool, start: Ns | None = None) -> None:
        self._write, self._json, self._start = write, as_json, start
        self._last: Ns | None = None

    def __call__(self, report: LineReport) -> None:
        self._start = report.first or report.stamp if self._start is None else self._start
        since = (report.first or report.stamp) - (self._last if self._last is not None else self._start)
        self._last = report.stamp
        at, gap = (report.stamp - self._start) / 1e6, max(0, since) / 1e6
        if not self._json:
            self._write(f"{at:11.1f} ms  {'+' + format(gap, '.1f'):>8}  {report.side}  {report.text}")
            return
        record: dict[str, object] = {
            "ms": round(at, 3),
            "after_ms": round(gap, 3),
            "side": report.side,
            "kind": report.kind,
            "text": report.text,
        }
        if report.kind in ("BLOCK", "BROKEN"):
            record |= {"data": report.data.hex(), "check_ok": report.check_ok}
        telegram = telegram_of(report.data) if report.kind == "BLOCK" else None
        if telegram is not None:
            record |= {"job": telegram.job, "db": telegram.db, "word": telegram.word, "amount": telegram.amount, "error": telegram.number}
        self._write(json.dumps(record))


def replay(characters: Iterator[tuple[Ns, str, int | Damage]], on_report: Callable[[LineReport], None]) -> None:
    """A recording instead of a line."""
    decoder, last = LineDecoder(), 0
    for stamp, side, what in characters:
        last = stamp
        for report in decoder.take(stamp, side, what):
            on_report(report)
    for report in decoder.flush(last + ms(1000)):
        on_report(report)
