"""Coded error output: groups, parity, strobe.  Source: rho 3 Releases, coded error output (L2945-3065); rho3 3.3, AX-534.

The list of errors (gateway.pure.image.error_list) stores and clears; this shows its entries to the PLC, one code after the other.
"""

from collections import deque
from collections.abc import Hashable, Mapping, Sequence

from gateway.pure.controllers.rho3.functions.addresses import Places, even, put_number
from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.image.error_list import ErrorRecord
from gateway.pure.image.records.cell import set_bit
from gateway.pure.image.system_errors import MOST_SYSTEM, system_code
from protocols.base.machine import Ns

FIRST_SYSTEM_ERROR, LAST_CODE = system_code(1), system_code(MOST_SYSTEM)  # groups 14 and 15 are system errors (L3007-3017)


def group(code: int) -> int | None:
    """Group 0..15 of a code 1..4095 (L2953-3017); None: no code of the rho 3."""
    return code >> 8 if 0 < code <= LAST_CODE else None


def group_text(number: int, language: str) -> str:
    """What the errors of group 0..15 are about."""
    return say("group_unused" if 6 <= number <= 12 else f"group_{number}", language)


def code_of(record: ErrorRecord) -> int | None:
    """The number shown; None for errors with foreign numbers: those have no code of the rho 3."""
    return record.code if record.source == "rho3" and group(record.code) is not None else None


class CodedErrors:
    """Shows all active codes once, all again when one is added; system errors wait for a key of the panel."""

    def __init__(self, places: Places, strobe_time: Ns) -> None:
        self._places, self._time = places, strobe_time
        self._known: frozenset[Hashable] = frozenset()
        self._queue: deque[Hashable] = deque()
        self._shown = 0  # code on the channel, 0: none
        self._key = False  # a key was pressed since this code is active
        self._since: Ns | None = None  # of the level of the strobe; None: low for long enough

    def step(self, records: Sequence[ErrorRecord], outputs: bytearray, now: Ns, *, key: bool = False) -> None:
        """records: the present error list; key: a key of the panel was pressed since the last step."""
        self.show(
            {(r.code, r.source, r.where, r.first_ns): code for r in records if (code := code_of(r)) is not None}, outputs, now, key=key
        )

    def show(self, active: Mapping[Hashable, int], outputs: bytearray, now: Ns, *, key: bool = False) -> None:
        """The same for errors kept elsewhere: identity of one occurrence -> code, in the order they came."""
        self._learn(active)
        if self._over(now, key):
            self._since = now if self._shown else None
            self._shown = 0
        if self._since is None and not self._shown and self._queue:
            self._shown, self._since, self._key = active[self._queue.popleft()], now, False
        self._write(outputs)

    def _learn(self, active: Mapping[Hashable, int]) -> None:
        """Learn a new error: all active codes are output once more (L3057); cleared ones are not shown."""
        marks = frozenset(active)
        if marks - self._known:
            self._queue = deque(active)
        else:
            self._queue = deque(mark for mark in self._queue if mark in marks)
        self._known = marks

    def _over(self, now: Ns, key: bool) -> bool:
        """Whether the level of the strobe ends: after P9, with a system error only by a key (L3061-3065)."""
        if self._since is None:
            return False
        self._key = self._key or key
        static = self._shown >= FIRST_SYSTEM_ERROR
        return (self._key or not static) and now - self._since >= self._time

    def _write(self, outputs: bytearray) -> None:
        put_number(outputs, self._places.error_code, 16, self._shown)
        set_bit(outputs, self._places.error_parity, even(self._shown))
        set_bit(outputs, self._places.error_strobe, self._shown != 0)
