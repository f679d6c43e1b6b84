"""Command source of a serial line with layer = "telegrams": 3964R, with raw blocks declared by [[telegram]] that read and write named
values.

It commands no axes: a program (or another command source) acts on the values and signals.  Blocks that match no telegram are counted and
reported.
"""

from gateway.assembly.telegrams import incoming, is_incoming, outgoing
from gateway.pure.cell.cell import Line
from gateway.pure.lines.line_profiles import link_profile
from gateway.services.sources.base import SourceContext
from gateway.services.sources.serial import SerialSource
from protocols.base.errors import EncodeError
from protocols.base.machine import Ns
from protocols.p3964r.events import BlockReceived, BlockSent, SendFailed
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import Priority
from protocols.telegrams.builder import Edge, EdgeWatch, When, build, parse_when
from protocols.telegrams.fields import Value
from protocols.telegrams.layout import Outgoing, Received, Refused
from protocols.telegrams.reader import Reader


class TelegramSource(SerialSource):
    """One serial line to a host computer."""

    counted = ("received", "refused", "unknown", "bad_blocks", "sent", "failed", "unbuilt")

    def __init__(self, context: SourceContext, line: Line) -> None:
        super().__init__(context, line)
        self._named = context.values.named
        mine = [telegram for telegram in context.run.cell.telegram if telegram.line == line.name]
        self.reader = Reader([incoming(telegram, line) for telegram in mine if is_incoming(telegram)])
        self._rules = [(self._watch(telegram.when), outgoing(telegram, line)) for telegram in mine if not is_incoming(telegram)]
        self.link = Link(link_profile(line), Priority.HIGH if line.priority == "high" else Priority.LOW)
        self.machine = self.link
        self._jobs: dict[int, str] = {}
        context.values.listen(self.settle)

    def _watch(self, text: str) -> EdgeWatch:
        when = parse_when(text)
        assert when is not None  # the cell's checks have seen to it
        return EdgeWatch(When(Edge.CHANGE, when.name) if when.name in self._named.signals else when)  # a signal counts: each one is an edge

    # ---- life --------------------------------------------------------------------------------------------------------
    def wake(self, now: Ns) -> None:
        """A host may be quiet for hours: without max_silence_ms only a lost port is a loss (AX-195)."""
        was = self.watch.alive
        if self.watch.max_silence:
            super().wake(now)
        elif self.watch.alive and not self.connected:
            self.watch.alive, self.watch.losses = False, self.watch.losses + 1
            self.dispatcher.link(self.number, self.on_loss, alive=False)
            self._journal("link", f"command source {self.number} {self.name}: the port was lost", source=self.number)
        if was and not self.watch.alive:
            self._named.source_gone(self.name)

    def settle(self) -> None:
        """At each tick and after each written value: build and queue telegrams with an edge."""
        for watch, telegram in self._rules:
            try:
                value: Value | None = self._value(watch.when.name)
            except KeyError:
                value = None
            if watch.fires(value):
                self._send(telegram, self._run.clock())

    # ---- out ---------------------------------------------------------------------------------------------------------
    def _value(self, name: str) -> Value:
        return self._named.get(name) if name in self._named else self._values.number(name, self)

    def _send(self, telegram: Outgoing, now: Ns) -> None:
        try:
            block = build(telegram, self._value)
        except EncodeError as error:
            self._named.give(f"telegram.{telegram.name}.failed", now, self.name)
            self._fault("unbuilt", str(error), now)
            return
        self._jobs[self.link.send(block, now)] = telegram.name
        self.kick()

    # ---- in ----------------------------------------------------------------------------------------------------------
    def _on_event(self, event: object, now: Ns) -> None:
        match event:
            case BlockReceived(data):
                self._block(data, now)
            case BlockSent(job):
                self._named.give(f"telegram.{self._jobs.pop(job)}.sent", now, self.name)
                self._partner["sent"] += 1
                self.heard(now)  # it was acknowledged: the partner is alive
            case SendFailed(job):
                name = self._jobs.pop(job)
                self._named.give(f"telegram.{name}.failed", now, self.name)
                self._fault("failed", f"{name} not delivered: {event}", now)
            case _:
                self._link_fault(event, now)
        self._values.changed()
        self._image.pass_on()

    def _block(self, data: bytes, now: Ns) -> None:
        self.heard(now)
        event = self.reader.block(data)
        if isinstance(event, Received):
            source = f"{self.name}/{event.name}"
            for name, value in event.values:
                self._named.put(name, value, now, source)
            if event.signal:
                self._named.give(event.signal, now, source)
            self._named.give(f"telegram.{event.name}.received", now, self.name)
            self._partner["received"] += 1
        elif isinstance(event, Refused):
            self._named.give(f"telegram.{event.name}.refused", now, self.name)
            self._fault("refused", f"{event.name}: {event.why}: {data.hex(' ')}", now)
        else:
            self._fault("unknown", f"no telegram has these {len(data)} bytes: {data.hex(' ')}", now)
