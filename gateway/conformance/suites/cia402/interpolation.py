"""CiA 402, cyclic position: when a set value acts, and how long its way takes (CiA 402-2, 60C2h)."""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.cia402.drive import ENABLED, TARGET, named, plan, position, state_of, status, there
from gateway.conformance.suites.cia402.faults import PERIOD, cyclic, in_ms
from gateway.conformance.suites.cia402.lasting import FOLLOWS
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import ms

CYC = Purposes[NodeTester]("CIA402_CSP", "drive", "CiA 402-2, 60C2h", condition=("csp", "sync", "may_move", "period"), preamble=FOLLOWS)
CYCLE_PERIOD = (0x1006, 0)
LONG_MS = 100  # one SYNC cycle of these cases: much longer than a servo lags
LONGEST_MS = 255  # 60C2h:01 is one byte
LOOKS = 8  # SDO answers in one cycle, at least
SETTLES, JUDGED = 4, 8  # cycles at constant speed
LEAST = 40  # increments of a cycle that can be judged
HALVES = 0.35, 0.72  # of the way of a cycle, made in its first half


@contextmanager
def _long_cycles(t: NodeTester) -> Iterator[int]:
    """CSP with a cycle of 100 ms, longer for slow SDO answers; the increments of a cycle at a quarter of the speed."""
    period = max(LONG_MS, LOOKS * t.setup.took // 1_000_000)
    if period > LONGEST_MS:
        raise NotApplicable(f"its SDO answers take {t.setup.took / 1e6:.0f} ms: too slow to look at it within {LONGEST_MS} ms")
    step = plan(t)[0] * period // 4000
    if step < LEAST:
        raise NotApplicable(f"a cycle of {period} ms is {step} increments at this speed; state [link] speed")
    with t.kept(*PERIOD, *there(t, CYCLE_PERIOD)) as before:
        try:
            if any(before[len(PERIOD) :]):
                t.download(CYCLE_PERIOD, 1000 * period, 4)
            in_ms(t, period)
        except Aborted as refused:
            raise NotApplicable(f"60C2h does not accept {period} ms: {refused.got}") from refused
        with cyclic(t, ms(period)):
            yield step


def _enabled(t: NodeTester) -> None:
    if state_of(got := status(t)) != ENABLED:
        raise Fail(f"a cycle of {t.period / 1e6:.0f} ms, as in 60C2h, ends operation enabled", "operation enabled", named(got))


@CYC.case(
    "BV_03",
    "a set value acts with the next SYNC, not with a later one",
    "ein Sollwert wirkt mit dem nächsten SYNC, nicht mit einem späteren",
    beside=Particulars(limits="a tenth of the way before the second SYNC"),
)
def at_the_next(t: NodeTester) -> None:
    with _long_cycles(t) as step:
        for way in (step, -step):
            start = position(t)
            t.download(TARGET, start + way, 4)
            t.on_grid()
            t.pause(t.period * 8 // 10)
            got = position(t)
            _enabled(t)
            t.on_grid(10)
            if (got - start) * way < 0 or abs(got - start) < step // 10:
                reason = f"it is at {got} at the end of the cycle whose SYNC took the set value {start + way}"
                raise Fail(reason, f"on the way from {start} to {start + way}", str(got))


@CYC.case(
    "BV_04",
    "each set value is reached in the time of 60C2h: half its way in half the cycle",
    "jeder Sollwert wird in der Zeit von 60C2h erreicht: der halbe Weg im halben Zyklus",
    beside=Particulars(limits="35 to 72 % of the way of a cycle in its first half; each cycle 50 to 150 % of its way"),
)
def in_its_time(t: NodeTester) -> None:
    with _long_cycles(t) as step:
        start, first, begins = position(t), 0, list[int]()
        for turn in range(1, SETTLES + JUDGED + 1):
            t.download(TARGET, start + step * turn, 4)
            t.on_grid()
            before, half = _ends_of_half(t)
            if turn > SETTLES:
                first, begins = first + half - before, [*begins, before]
        _enabled(t)
        t.on_grid(10)
        _back(t, start)
        ways = [later - before for before, later in itertools.pairwise(begins)]
        odd = max(ways, key=lambda way: abs(way - step))
        if abs(odd - step) > step // 2:
            raise Fail(f"one of {len(ways)} cycles at constant speed has a way of {odd}", f"{step} in each", ", ".join(map(str, ways)))
        part = first / (JUDGED * step)
        if not HALVES[0] <= part <= HALVES[1]:
            got = f"{100 * part:.0f} % of it in the first half"
            raise Fail(f"the way of a cycle is not spread over 60C2h = {t.period / 1e6:.0f} ms: {got}", "about 50 % in each half", got)


def _ends_of_half(t: NodeTester) -> tuple[int, int]:
    """Positions just after a SYNC and half a cycle later."""
    begin = t.now()
    before = position(t)
    t.pause(begin + t.period // 2 - t.now())
    return before, position(t)


def _back(t: NodeTester, start: int) -> None:
    """At the same speed."""
    goal = position(t)
    turns = SETTLES + JUDGED
    for turn in range(1, turns + 1):
        t.download(TARGET, goal + (start - goal) * turn // turns, 4)
        t.on_grid()
