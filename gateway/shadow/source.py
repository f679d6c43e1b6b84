"""A line's command source without a line: the PLC's telegrams to the old controller are processed here as well, and the answers of both
are compared.  Nothing is written (AX-493).
"""

import time
from collections.abc import Mapping

from gateway.pure.arbitration.block_keys import KINDS, block_key, block_name
from gateway.pure.arbitration.own_jobs import OwnJobs
from gateway.pure.cell.cell import Line
from gateway.pure.lines.decoder import LineReport, telegram_of
from gateway.pure.shadow.addresses import places_of, rest_of
from gateway.pure.shadow.compare import Answer, Comparison, as_data
from gateway.pure.shadow.conversation import Answered, Asked, Conversation
from gateway.services.sources.base import SourceContext
from gateway.services.sources.rk512 import Rk512Source
from gateway.shadow.known_outputs import state_is_known
from gateway.shadow.taps import TapPair
from protocols.base.machine import Ns
from protocols.rk512.header import REACTION_BYTES


class ShadowSource(Rk512Source):
    """One tapped line."""

    def __init__(self, post: SourceContext, line: Line) -> None:
        super().__init__(post, line)
        self._own = OwnJobs(())  # jobs of ours would need a partner that answers
        self.comparison = Comparison()
        self.telegrams = {"heard": 0, "answered": 0, "other_number": 0}
        self.first_other_number = ""
        self._conversation = Conversation()
        self._taps: TapPair | None = None
        self._reaction = b""  # ours, to the last command of the PLC
        self.since: Ns = time.monotonic_ns()
        self._settled = False  # our own state is known: before that nothing can be compared
        self._closed = self._connected = False

    async def start(self) -> None:
        """The taps instead of the line."""
        ports, check = self._run.plan.taps[self.name], self.line.protocol == "3964R"
        self._taps = TapPair(ports, self.line.format, time.monotonic_ns, self._reported, block_check=check)

    async def close(self) -> None:
        if self._taps is not None:
            self._connected = self._taps.connected
            self._taps.close()
            self._closed = True

    @property
    def connected(self) -> bool:
        """Both taps are there; after the end: they were."""
        return self._connected if self._closed else self._taps is not None and self._taps.connected

    def counters(self) -> dict[str, object]:
        """For tools."""
        return {**self._partner, "connected": self.connected, "why": self._taps.why if self._taps else "", "advice": ""}

    def settle(self) -> None:
        """At each tick: read the taps and the present content of our blocks."""
        if self._taps is not None:
            self._taps.turn()
        super().settle()
        now = time.monotonic_ns()
        self._settled = self._settled or state_is_known(self._image, len(self._run.cell.axis), self.since, now)
        for key in self.comparison.blocks:
            assert isinstance(key, int)
            content = self._content_of(key)
            if content is not None:
                self.comparison.ours(key, content, now)
        self.comparison.settle(now)

    # ---- traffic
    def _reported(self, report: LineReport) -> None:
        for exchange in self._conversation.take(report):
            if isinstance(exchange, Asked):
                self._asked(exchange)
            elif exchange.side == "B":
                self._old_answers(exchange)
            else:
                self._plc_answers(exchange)

    def _asked(self, asked: Asked) -> None:
        if asked.side == "B":
            self._old_sends(asked)
            return
        self.telegrams["heard"] += 1
        self._link.passive.take_output()
        if not self._settled and self.data is not None:
            self.data.restart()  # until our own state is known, a telegram only sets the initial state of the bits (AX-141)
        for event in self._link.passive.telegram(asked.data, asked.stamp):
            self._on_event(event, asked.stamp)
        self._reaction = self._link.passive.take_output() or b""
        telegram = telegram_of(asked.data)
        if telegram is not None and telegram.job == "FETCH" and self._settled:
            self._known(telegram.kind, telegram.db, asked.stamp)

    def _old_answers(self, answered: Answered) -> None:
        """The old controller's reaction; ours was computed at the PLC's request."""
        ours, self._reaction = self._reaction, b""
        self.telegrams["answered"] += 1
        if ours[:REACTION_BYTES] != answered.data[:REACTION_BYTES]:
            self.telegrams["other_number"] += 1
            there, here = answered.data[3], ours[3] if len(ours) > 3 else None
            job = answered.job[:10].hex(" ")
            self.first_other_number = self.first_other_number or f"{job}: there {there:02X}h, here {_number(here)}"
        self._said(answered.job, answered.at, answered.data[REACTION_BYTES:], answered.asked, answered.stamp)

    def _old_sends(self, asked: Asked) -> None:
        """A SEND of the old controller reports the state of its block."""
        telegram = telegram_of(asked.data)
        if telegram is not None and telegram.job == "SEND" and self._settled:
            self._known(telegram.kind, telegram.db, asked.stamp)
            self._said(asked.data, 0, telegram.data, asked.stamp, asked.stamp, job_word="SEND")

    def _plc_answers(self, answered: Answered) -> None:
        """Data that the old controller fetched from the PLC are processed as if we had fetched them."""
        telegram = telegram_of(answered.job)
        data = answered.data[REACTION_BYTES:]
        if telegram is None or telegram.job != "FETCH" or telegram.kind not in ("DB", "DX") or len(data) % 2:
            return
        self.write_block(_key(telegram.kind, telegram.db), telegram.word + answered.at // 2, data, answered.stamp)
        self.heard(answered.stamp, None)
        self._image.pass_on()

    def _said(self, job: bytes, at: int, data: bytes, asked: Ns, answered: Ns, *, job_word: str = "FETCH") -> None:
        telegram = telegram_of(job)
        if telegram is None or telegram.job != job_word or not data:
            return
        key = _key(telegram.kind, telegram.db)
        if key not in self.comparison.blocks:
            return
        unit = 1 if telegram.kind in ("E", "A", "M") else 2
        address = telegram.word if telegram.kind in ("DB", "DX") else telegram.db << 8 | telegram.word
        self.comparison.theirs(Answer(key, asked, answered, address * unit + at, data))

    # ---- our blocks --------------------------------------------------------------------------------------------------
    def _content_of(self, key: int) -> bytes | None:
        kind, number = KINDS[key >> 8], key & 0xFF
        if self.refused(kind) is not None:
            return None
        return self.block_bytes(number) if kind == "D" else self._areas.content(kind, number)

    def _known(self, kind: str, number: int, now: Ns) -> None:
        """From the first mention of a block on, ours is watched."""
        key = _key(kind, number)
        content = self._content_of(key)
        if content is None:
            return
        if key not in self.comparison.blocks:
            declared = self.data.blocks.get(key) if self.data is not None else None
            if declared is not None and declared.from_plc:
                return  # it only repeats what the PLC wrote itself
            places = places_of(declared) if declared is not None else rest_of(b"\xff" * (len(content) & ~1))
            self.comparison.declare(key, block_name(key), places)
        self.comparison.ours(key, content, now)

    def result(self, now: Ns) -> Mapping[str, object]:
        """For the report."""
        return {
            "line": self.name,
            "kind": "line",
            "taps": list(self._run.plan.taps[self.name]),
            "connected": self.connected,
            "comparing": self._settled,
            "characters": self._taps.characters if self._taps is not None else 0,
            "telegrams": dict(self.telegrams),
            "first_other_number": self.first_other_number,
            "blocks": as_data(self.comparison, self.since, now),
        }


def _key(kind: str, number: int) -> int:
    letter = {"DB": "D", "DX": "X"}.get(kind, kind)
    return block_key(letter, number)


def _number(value: int | None) -> str:
    return "no answer" if value is None else f"{value:02X}h"
