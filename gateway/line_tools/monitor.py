"""`axisgate line monitor`: a line decoded, with times in ms; one port, or two receive-only taps.  Never writes a character."""

import json
from collections.abc import Callable, Iterator, Sequence

from gateway.line_tools.wire import ToolPort
from gateway.pure.line_decoder import LineDecoder, Told, telegram_of
from protocols.base.machine import Damage, Ns, ms

TURN = 0.002  # seconds at one of two taps: the order of the characters is known so exactly
IDLE = 0.02


class Monitor:
    """Reads ports called by their side; `tell` gets every sentence."""

    def __init__(
        self, ports: Sequence[tuple[str, ToolPort]], clock: Callable[[], Ns], tell: Callable[[Told], None], check: bool = True
    ) -> None:
        self._ports, self._clock, self._tell = ports, clock, tell
        self._decoder = LineDecoder(both=len(ports) == 2, block_check=check)
        self.characters = 0

    def run(self, how_long: Ns | None) -> None:
        """So long, or until interrupted."""
        start = self._clock()
        while how_long is None or self._clock() - start < how_long:
            for _, port in self._ports:
                port.wait(TURN if len(self._ports) > 1 else IDLE)
            self._take()
        for told in self._decoder.flush(self._clock() + ms(1000)):
            self._tell(told)

    def _take(self) -> None:
        now = self._clock()
        for side, port in self._ports:
            for item in port.read():
                for what in item if isinstance(item, bytes) else (item,):
                    self.characters += 1
                    for told in self._decoder.take(now, side, what):
                        self._tell(told)
        for told in self._decoder.flush(now):
            self._tell(told)


class Printer:
    """Sentences as lines for a person or as JSON lines for a program."""

    def __init__(self, write: Callable[[str], None], as_json: bool, start: Ns | None = None) -> None:
        self._write, self._json, self._start = write, as_json, start
        self._last: Ns | None = None

    def __call__(self, told: Told) -> None:
        self._start = told.first or told.stamp if self._start is None else self._start
        since = (told.first or told.stamp) - (self._last if self._last is not None else self._start)
        self._last = told.stamp
        at, gap = (told.stamp - self._start) / 1e6, max(0, since) / 1e6
        if not self._json:
            self._write(f"{at:11.1f} ms  {'+' + format(gap, '.1f'):>8}  {told.side}  {told.text}")
            return
        record: dict[str, object] = {"ms": round(at, 3), "after_ms": round(gap, 3), "side": told.side, "kind": told.kind, "text": told.text}
        if told.kind in ("BLOCK", "BROKEN"):
            record |= {"data": told.data.hex(), "check_ok": told.check_ok}
        telegram = telegram_of(told.data) if told.kind == "BLOCK" else None
        if telegram is not None:
            record |= {"job": telegram.job, "db": telegram.db, "word": telegram.word, "amount": telegram.amount, "error": telegram.number}
        self._write(json.dumps(record))


def replay(characters: Iterator[tuple[Ns, str, int | Damage]], tell: Callable[[Told], None]) -> None:
    """A recording instead of a line."""
    decoder, last = LineDecoder(), 0
    for stamp, side, what in characters:
        last = stamp
        for told in decoder.take(stamp, side, what):
            tell(told)
    for told in decoder.flush(last + ms(1000)):
        tell(told)
