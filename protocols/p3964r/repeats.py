"""Consecutive refused blocks, and the repeat the partner owes.  Source: rho 3 Releases part 1, section 7.1; AX-008."""

from protocols.base.machine import Ns
from protocols.p3964r.events import Outbox, ReceptionFailed, Refusal


class Repeats:
    """Counts refusals; after so many, or without a repeat in time, the reception has failed."""

    def __init__(self, box: Outbox, attempts: int, wait: Ns) -> None:
        self._box, self._attempts, self._wait = box, attempts, wait
        self._refusals, self._first_why = 0, Refusal.GAP
        self.awaited = False
        self.due: Ns | None = None  # end of the wait for the repeat

    def opened(self) -> None:
        """A block begins: the repeat, or another one."""
        self.awaited, self.due = False, None

    def delivered(self) -> None:
        """A block was good."""
        self._refusals = 0

    def refused(self, why: Refusal) -> None:
        """The wait for the repeat runs from when our NAK has left."""
        if self._refusals == 0:
            self._first_why = why
        self._refusals += 1
        self.awaited = True
        if self._refusals == self._attempts:
            self.fail()

    def left(self, now: Ns) -> None:
        """Our output has left the line."""
        if self.awaited and self.due is None:
            self.due = now + self._wait

    def fail(self) -> None:
        """No repeat, or too many."""
        self._box.report(ReceptionFailed(self._first_why, self._refusals))
        self.forget()

    def forget(self) -> None:
        """The port is lost, or it was reported."""
        self._refusals, self.awaited, self.due = 0, False, None
