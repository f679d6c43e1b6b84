"""Common base of the command sources of serial lines: the machine of their protocols on a port that may be lost and return, counters,
journal texts.
"""

from collections import Counter
from collections.abc import Iterable

from drivers.ports.open import open_bytes
from gateway.links.serial.dialogue_log import journaled
from gateway.links.serial.runner import LineRunner
from gateway.links.serial.tap import Tap
from gateway.pure.cell.cell import Line
from gateway.pure.lines.fault_texts import fault_words
from gateway.pure.recording.messages import Source
from gateway.services.sources.base import BaseSource, SourceContext
from protocols.base.machine import Damage, Machine, Ns
from protocols.p3964r.events import SamePriority

REPORT_EVERY: Ns = 1_000_000_000  # shortest interval of a partner's faults in the journal; all are counted


class SerialSource(BaseSource):
    """One [[line]].  Below it: `machine`, made by the command source of its layer."""

    medium = "lines"
    machine: Machine[object]
    counted: Iterable[str] = ()  # names of its counters

    def __init__(self, context: SourceContext, line: Line) -> None:
        super().__init__(context)
        self.line = line
        self._partner: Counter[str] = Counter(dict.fromkeys((*self.counted, "same_priority"), 0))
        self._advice = ""  # a setting to correct by hand
        self._runner: LineRunner[object] | None = None
        self.tap: Tap[object] | None = None  # recent traffic, for the page
        self._journal_next: Ns = 0
        self._journal(
            "link",
            f"command source {self.number} {self.name}: {self.procedure} on {self._run.plan.lines[line.name]}",
            source=self.number,
        )

    async def start(self) -> None:
        """Opens the line; inside the running loop."""
        url = self._run.plan.lines[self.name]
        self.tap = Tap(journaled(self.machine, self._run.plan, self.line), self._record)
        self._runner = LineRunner[object](lambda: open_bytes(url, self.line.format), self.tap, self._on_event)

    def _record(self, now: Ns, side: str, data: bytes) -> None:
        self._run.recorder.put(now, Source.HEARD if side == "A" else Source.SAID, self.number, data)

    async def close(self) -> None:
        """Release the port."""
        if self._runner is not None:
            self._runner.close()

    @property
    def connected(self) -> bool:
        """The port is open."""
        return self._runner is not None and self._runner.state.connected

    @property
    def procedure(self) -> str:
        """Protocol and profile of the line for the journal; a source that is not on 3964(R) overrides it."""
        return f"{self.line.protocol} {self.line.profile}"

    def step(self, now: Ns) -> None:
        super().step(now)
        self.settle()

    def settle(self) -> None:
        """At each tick."""

    def passed(self, number: int) -> list[list[object]] | None:
        """Number, stamp, side, characters in hex or the kind of damage."""
        if self.tap is None:
            return None
        pieces = self.tap.since(number)
        return [[n, at, side, f"!{what.name}" if isinstance(what, Damage) else what.hex()] for n, at, side, what in pieces]

    def kick(self) -> None:
        """The machine got new work."""
        if self._runner is not None:
            self._runner.kick()

    def counters(self) -> dict[str, object]:
        """For tools."""
        state = self._runner.state if self._runner is not None else None
        connected, why = (state.connected, state.why) if state else (False, "")
        return {**self._partner, "connected": connected, "why": why, "advice": self._advice}

    def _on_event(self, event: object, now: Ns) -> None:
        raise NotImplementedError

    def _link_fault(self, event: object, now: Ns) -> None:
        """A report of the link: the one fault to correct by hand has a counter and a text of its own."""
        if isinstance(event, SamePriority):
            self._advice = f"both stations have the same priority ({event.priority.name.lower()}): set one to high, the other to low"
            self._fault("same_priority", self._advice, now)
        else:
            self._fault("bad_blocks", fault_words(event), now)

    def _fault(self, counter: str, words: str, now: Ns) -> None:
        """A partner's faults are counted; the journal is informed of them at most once a second."""
        self._partner[counter] += 1
        if now >= self._journal_next:
            self._journal_next = now + REPORT_EVERY
            self._journal("line", f"{self.name}: {words}", source=self.number)
