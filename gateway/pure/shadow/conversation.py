"""Pairs the telegrams on a tapped RK512 line: requests, their senders and the answers.  Sides as the line decoder's: A the PLC, B the old
control.  A telegram counts when the other side has acknowledged its block: a refused one is repeated.
"""

from dataclasses import dataclass

from gateway.pure.lines.decoder import LineReport
from protocols.base.machine import Ns
from protocols.rk512.header import FOLLOW_ON, MOST_BYTES, is_reaction


@dataclass(frozen=True, slots=True)
class Asked:
    """A command telegram came."""

    side: str
    data: bytes
    stamp: Ns


@dataclass(frozen=True, slots=True)
class Answered:
    """The reaction to the last command of the other side."""

    side: str  # who answers
    job: bytes  # the first telegram of the job
    at: int  # data bytes of this job that were exchanged before
    data: bytes
    asked: Ns  # last character of the command
    stamp: Ns  # first character of the reaction


Exchange = Asked | Answered


@dataclass(slots=True)
class _Open:
    """A command that waits for its reaction."""

    job: bytes
    data: bytes
    asked: Ns
    at: int = 0


class Conversation:
    """Both directions of one line."""

    def __init__(self) -> None:
        self._unconfirmed: dict[str, LineReport] = {}
        self._open: dict[str, _Open] = {}  # by the side that asked
        self._jobs: dict[str, tuple[bytes, int]] = {}  # first telegram of the job, data bytes exchanged before the last one

    def take(self, report: LineReport) -> list[Exchange]:
        """The next sentence of the line decoder."""
        other = "B" if report.side == "A" else "A"
        if report.kind == "BLOCK" and report.check_ok is not False:
            self._unconfirmed[report.side] = report
        elif report.kind == "DLE" and other in self._unconfirmed:
            return self._telegram(self._unconfirmed.pop(other))
        elif report.kind in ("NAK", "BROKEN"):
            self._unconfirmed.pop(other, None)
        return []

    def _telegram(self, block: LineReport) -> list[Exchange]:
        side, data = block.side, block.data
        other = "B" if side == "A" else "A"
        if is_reaction(data):
            job = self._open.pop(other, None)
            return [] if job is None else [Answered(side, job.job, job.at, data, job.asked, block.first)]
        before = self._open.get(side)
        if before is not None and before.data == data:
            return []  # repeated while its reaction is on its way
        self._open[side] = self._next(side, data, block.stamp)
        return [Asked(side, data, block.stamp)]

    def _next(self, side: str, data: bytes, stamp: Ns) -> _Open:
        first = self._jobs.get(side) if data[:1] == bytes((FOLLOW_ON,)) else None
        if first is None:
            self._jobs[side] = (data, 0)
            return _Open(data, data, stamp)
        job, at = first
        self._jobs[side] = (job, at + MOST_BYTES)
        return _Open(job, data, stamp, at + MOST_BYTES)
