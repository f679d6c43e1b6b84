"""CiA 402, profile position: set-points, their handshake, halt, speed and limits (CiA 402-2)."""

from collections.abc import Iterator
from contextlib import contextmanager

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.cia402.drive import (
    ACCELERATION,
    BIT12,
    ENABLED,
    INTERNAL,
    LIMIT_HIGH,
    LIMIT_LOW,
    PP,
    PROFILE_SPEED,
    REACHED,
    TARGET,
    at_standstill,
    brought_to,
    control,
    named,
    patience,
    plan,
    position,
    speed,
    status,
    until,
)
from gateway.conformance.suites.cia402.faults import POWER
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import Ns, ms

WINDOW = (0x6067, 0)
SETTLES = ms(50)  # bit 10 shows standstill during halt, and falls with a cycle of the drive
SHORTEST, LENGTHS = ms(60), 6  # a motion that can be looked at, and how often the way is made four times as long


POS = Purposes[NodeTester]("CIA402_POS", "drive", "CiA 402-2, profile position", condition=("pp", "may_move"), preamble=POWER)
MOVES = (*POWER, "CIA402_POS_BV_01", "CIA402_POS_BV_02")


@contextmanager
def positioning(t: NodeTester) -> Iterator[tuple[int, int]]:
    """Profile position, enabled; where it is, and the way of the plan."""
    chosen, way = plan(t)
    windows = [WINDOW] if t.setup.pics.get("window") else []
    with t.kept(PROFILE_SPEED, TARGET, *windows), brought_to(t, ENABLED, PP):
        with t.given():
            t.download(PROFILE_SPEED, chosen, 4)
            for window in windows:
                t.download(window, max(way // 50, 20), 4)
        yield position(t), way


def order(t: NodeTester, target: int, bits: int = 0) -> None:
    """A set-point with its handshake."""
    t.download(TARGET, target, 4)
    control(t, 0x1F | bits)
    with t.given():
        until(t, lambda: bool(status(t) & BIT12), "set-point acknowledge", ms(1000))
    control(t, 0x0F | bits)


def arrives(t: NodeTester, target: int, what: str) -> Ns:
    took = until(
        t, lambda: bool(status(t) & REACHED) and at_standstill(t), f"{what}: target reached", patience(t), lambda: f"at {position(t)}"
    )
    allowed = max(plan(t)[1] // 50, 50)
    if abs((got := position(t)) - target) > allowed:
        raise Fail(f"{what}: it is at {got}", f"{target} +- {allowed}", str(got))
    return took


@POS.case("BV_01", "bit 12 acknowledges a set-point, and falls with bit 4", "Bit 12 quittiert einen Sollwert und fällt mit Bit 4")
def handshake(t: NodeTester) -> None:
    with positioning(t) as (start, _):
        if status(t) & BIT12:
            raise Fail("bit 12 is set before a set-point", "bit 12 clear", named(status(t)))
        with t.given():
            t.download(TARGET, start, 4)
        control(t, 0x1F)
        until(t, lambda: bool(status(t) & BIT12), "bit 12 after bit 4 of the controlword", ms(1000))
        control(t, 0x0F)
        until(t, lambda: not status(t) & BIT12, "bit 12 clear after bit 4 fell", ms(2000))


@POS.case(
    "BV_02",
    "an absolute set-point is reached, bit 10 is clear on the way",
    "ein absoluter Sollwert wird erreicht, unterwegs ist Bit 10 gelöscht",
    preamble=MOVES[:-1],
)
def absolute(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        for target in (start + way, start):
            order(t, target)
            if status(t) & REACHED and abs(position(t) - target) > way // 4:
                raise Fail("bit 10 is set on the way", "bit 10 clear", named(status(t)))
            arrives(t, target, f"set-point {target}")
        _lengthen(t, start)


def _lengthen(t: NodeTester, start: int) -> None:
    """A drive may count positions in finer units than speeds: the way of the plan is then over before it can be looked at.

    A stated way, and the one of a real axis, stay as they are.
    """
    way = plan(t)[1]
    if t.setup.pics.get("way_stated"):
        return
    for _ in range(LENGTHS):
        order(t, start + way)
        took = arrives(t, start + way, f"set-point {start + way}")
        order(t, start)
        arrives(t, start, f"set-point {start}")
        if took >= max(SHORTEST, 8 * t.setup.took):
            break
        if not t.wire.simulated:
            t.remark(f"a distance of {way} takes {took / 1e6:.0f} ms, too short; state [link] way")
            return
        way *= 4
    if way != plan(t)[1]:
        t.remark(f"the way of {plan(t)[1]} was over at once; {way} is used")
        t.setup.pics = {**t.setup.pics, "motion_way": way}


@POS.case("BV_03", "a relative set-point counts from the last target", "ein relativer Sollwert zählt vom letzten Ziel", preamble=MOVES)
def relative(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        with t.given():
            order(t, start)
            arrives(t, start, "the starting point")
        for turn in (1, 2):
            order(t, way // 2, 0x40)
            arrives(t, start + turn * way // 2, f"relative set-point {turn}")
        order(t, -way, 0x40)
        arrives(t, start, "a relative set-point backwards")


@POS.case(
    "BV_04", "change set immediately: the new target counts at once", "Change Set Immediately: das neue Ziel gilt sofort", preamble=MOVES
)
def immediately(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        order(t, start + 4 * way)
        t.pause(ms(20))
        order(t, start, 0x20)
        farthest, begin = start, t.now()
        while not (status(t) & REACHED and at_standstill(t)) and t.now() - begin < patience(t):
            farthest = max(farthest, position(t))
            t.pause(ms(2))
        if farthest > start + 3 * way:
            raise Fail(f"it went to {farthest} before the new target", "the new target at once", str(farthest))
        arrives(t, start, "the immediate set-point")


@POS.case(
    "BV_05",
    "without it the first target is reached before the second",
    "ohne es wird das erste Ziel vor dem zweiten erreicht",
    preamble=MOVES,
)
def one_after_the_other(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        order(t, start + way)
        t.pause(ms(20))
        t.download(TARGET, start, 4)
        control(t, 0x1F)
        farthest, gap, looked = start, 0, t.now()
        begin = t.now()
        while t.now() - begin < patience(t):
            farthest = max(farthest, position(t))
            gap, looked = max(gap, t.now() - looked), t.now()
            if farthest > start + way * 9 // 10 and status(t) & REACHED and at_standstill(t) and position(t) < start + way // 2:
                break
            t.pause(ms(2))
        control(t, 0x0F)
        unseen = min(plan(t)[0] * gap // 1_000_000_000, way // 2)  # between two looks at a drive that answers slowly
        if farthest < start + way * 9 // 10 - unseen:
            raise Fail(f"the first target was left at {farthest}", f"{start + way}", str(farthest))
        arrives(t, start, "the second set-point")


@POS.case("BV_06", "halt stops the motion, and its end continues it", "Halt hält die Bewegung an, sein Ende setzt sie fort", preamble=MOVES)
def halt(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        order(t, start + 4 * way)
        with t.given():
            until(t, lambda: abs(speed(t)) > plan(t)[0] // 2, "motion")
        control(t, 0x10F)
        until(t, lambda: at_standstill(t), "standstill after halt", ms(3000))
        held = position(t)
        t.pause(ms(50))
        if abs(position(t) - held) > max(way // 20, 20) or held > start + 4 * way - way // 4:
            raise Fail("it moves on during halt", f"it stays at {held}", str(position(t)))
        control(t, 0x0F)
        t.pause(SETTLES)
        arrives(t, start + 4 * way, "the set-point after halt")


@POS.case(
    "BI_01", "a new target without the edge of bit 4 moves nothing", "ein neues Ziel ohne Flanke von Bit 4 bewegt nichts", preamble=MOVES
)
def no_edge(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        t.download(TARGET, start + way, 4)
        control(t, 0x0F)
        t.pause(ms(200))
        if abs((got := position(t)) - start) > max(way // 20, 20):
            raise Fail(f"it moved to {got} without a set-point", str(start), str(got))


@POS.case(
    "BV_07",
    "it is never faster than 6081h, and needs the time of speed and ramps",
    "er ist nie schneller als 6081h und braucht die Zeit von Geschwindigkeit und Rampen",
    preamble=MOVES,
    beside=Particulars(limits="speed at most 110 % of 6081h; time 80 to 160 %"),
)
def profile(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        chosen = plan(t)[0]
        with t.given():
            ramps = [t.number(key) for key in (ACCELERATION, (0x6084, 0)) if t.exists(key)]
        if not ramps:
            raise NotApplicable("it has no 6083h")
        order(t, start + 4 * way)
        begin, top, seen = t.asked_at, 0, list[tuple[Ns, int]]()
        while not (status(t) & REACHED and at_standstill(t)) and t.now() - begin < patience(t):
            top = max(top, now := abs(speed(t)))
            if now > chosen * 95 // 100:
                seen.append((t.now(), position(t)))
            t.pause(ms(1))
        nominal = round((4 * way / (chosen * _unit(t, seen, chosen)) + chosen / max(min(ramps), 1)) * 1e9)
        if top > chosen * 11 // 10:
            raise Fail(f"606Ch was {top} on the way", f"at most {chosen * 11 // 10}", str(top))
        t.timed("profile position, 4 times the distance", t.now() - begin, round(0.8 * nominal), round(1.6 * nominal) + ms(100))


def _unit(t: NodeTester, seen: list[tuple[Ns, int]], chosen: int) -> float:
    """Units of 6064h per second in one unit of 606Ch: a drive may use a separate unit for speeds."""
    if len(seen) < 2 or not t.setup.pics.get("velocity") or seen[-1][0] - seen[0][0] < ms(10):
        return 1.0
    (begin, first), (end, last) = seen[0], seen[-1]
    found = abs(last - first) * 1e9 / (end - begin) / chosen
    if 0.7 < found < 1.5 or not found:
        return 1.0
    t.remark(f"one unit of 606Ch is about {found:.3g} units of 6064h a second")
    return found


@POS.case(
    "BI_02",
    "a target beyond 607Dh is not passed, and bit 11 shows it",
    "ein Ziel jenseits 607Dh wird nicht überfahren, Bit 11 zeigt es",
    condition=("limits",),
    preamble=MOVES,
)
def software_limit(t: NodeTester) -> None:
    with t.kept(LIMIT_LOW, LIMIT_HIGH), positioning(t) as (start, way):
        with t.given():
            t.download(LIMIT_LOW, start - way, 4)
            t.download(LIMIT_HIGH, start + way, 4)
        t.download(TARGET, start + 3 * way, 4)
        control(t, 0x1F)
        farthest, limited, begin = start, False, t.now()
        while t.now() - begin < ms(1500):
            farthest, limited = max(farthest, position(t)), limited or bool(status(t) & INTERNAL)
            t.pause(ms(5))
        control(t, 0x0F)
        if farthest > start + way + max(way // 20, 50):
            raise Fail(f"it passed the limit and reached {farthest}", f"at most {start + way}", str(farthest))
        if not limited:
            raise Warn("bit 11 internal limit active is not set", "bit 11 set", named(status(t)))
