"""CiA 402, profile position: the ramps, set-points under way and during halt, the window in time (CiA 402-2)."""

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.can.node import named as object_name
from gateway.conformance.suites.cia402.drive import (
    ACCELERATION,
    BIT12,
    DECELERATION,
    REACHED,
    TARGET,
    at_standstill,
    control,
    named,
    patience,
    plan,
    position,
    speed,
    status,
    until,
)
from gateway.conformance.suites.cia402.positioning import MOVES, SHORTEST, WINDOW, arrives, order, positioning
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import Ns, ms
from protocols.canopen.dictionary import Key

POS = Purposes[NodeTester]("CIA402_POS", "drive", "CiA 402-2, profile position", condition=("pp", "may_move"), preamble=MOVES)
POSITION_TIME, RELATIVE_OPTION = (0x6068, 0), (0x60F2, 0)
RELATIVE, AT_ONCE, HALT = 0x40, 0x20, 0x100
RAMPED = Particulars(limits="70 to 150 % of speed by ramp, and 60 ms")


def back(t: NodeTester, start: int) -> None:
    """The axis is left where the case found it."""
    with t.given():
        order(t, start, AT_ONCE)  # whatever is under way or waits
        control(t, 0x0F)
        arrives(t, start, "back to the start")


def _slowed(t: NodeTester, key: Key, start: int, way: int) -> Ns:
    """This ramp lasts as long as a way took before; how long."""
    if not t.exists(key):
        raise NotApplicable(f"there is no {object_name(key)}")
    with t.given():
        order(t, start + way)
        lasts = max(arrives(t, start + way, "one way"), SHORTEST)
        back(t, start)
    try:
        t.download(key, max(round(plan(t)[0] * 1e9 / lasts), 1), 4)
    except Aborted as refused:
        raise NotApplicable(f"{object_name(key)} does not accept this ramp: {refused.got}") from refused
    return lasts


def _passes(t: NodeTester, faster: bool, bound: int, limit: Ns) -> Ns:
    """When 606Ch passes this bound."""
    begin = t.now()
    while (abs(speed(t)) >= bound) is not faster:
        if t.now() - begin > limit or (faster and status(t) & REACHED and at_standstill(t) and t.now() - begin > ms(100)):
            raise NotApplicable(f"606Ch does not reach {bound} within four times the distance")
        t.pause(ms(1))
    return t.now()


@POS.case(
    "BV_09",
    "6083h is the ramp of a set-point",
    "6083h ist die Rampe eines Sollwerts",
    clause="CiA 402-2, 6083h",
    condition=("velocity",),
    beside=RAMPED,
)
def speeds_up(t: NodeTester) -> None:
    chosen = plan(t)[0]
    with t.kept(*_there(t, ACCELERATION)), positioning(t) as (start, way):
        lasts = _slowed(t, ACCELERATION, start, way)
        t.download(TARGET, start + 4 * way, 4)
        control(t, 0x1F)
        begin = t.asked_at
        took = _passes(t, True, chosen * 9 // 10, patience(t)) - begin
        control(t, 0x0F)
        with t.given():
            arrives(t, start + 4 * way, "four ways")
        back(t, start)
        t.timed("profile position, 0 to 90 % of 6081h along 6083h", took, round(0.63 * lasts), round(1.35 * lasts) + ms(60))


@POS.case(
    "BV_10",
    "6084h is the ramp to the target",
    "6084h ist die Rampe zum Ziel",
    clause="CiA 402-2, 6084h",
    condition=("velocity",),
    beside=RAMPED,
)
def slows_down(t: NodeTester) -> None:
    chosen = plan(t)[0]
    with t.kept(*_there(t, DECELERATION)), positioning(t) as (start, way):
        lasts = _slowed(t, DECELERATION, start, way)
        order(t, start + 4 * way)
        _passes(t, True, chosen * 95 // 100, patience(t))
        begin = _passes(t, False, chosen * 9 // 10, patience(t))
        took = _passes(t, False, max(chosen // 10, 1), 20 * lasts) - begin
        with t.given():
            arrives(t, start + 4 * way, "four ways")
        back(t, start)
        t.timed("profile position, 90 to 10 % of 6081h along 6084h", took, round(0.56 * lasts), round(1.2 * lasts) + ms(60))


def _there(t: NodeTester, *keys: Key) -> list[Key]:
    return [key for key in keys if t.exists(key)]


@POS.case(
    "BV_11",
    "a relative set-point under way counts from the target under way, at once and one after the other",
    "ein relativer Sollwert unterwegs zählt vom laufenden Ziel, sofort und nacheinander",
    clause="CiA 402-2, 607Ah and 60F2h",
)
def relative_under_way(t: NodeTester) -> None:
    if t.exists(RELATIVE_OPTION) and t.number(RELATIVE_OPTION) & 3:
        raise NotApplicable("60F2h selects another reference than the last target")
    with positioning(t) as (start, way):
        for bits, words in ((RELATIVE | AT_ONCE, "at once"), (RELATIVE, "after the target under way")):
            order(t, start + 2 * way)
            with t.given():
                until(t, lambda: abs(position(t) - start) > way // 10, "motion")
            if status(t) & REACHED:
                raise NotApplicable("the motion is over before a second set-point; state [link] way")
            t.download(TARGET, way, 4)
            control(t, 0x1F | bits)
            goal, allowed = start + 3 * way, max(way // 50, 50)
            limit, begin = 2 * patience(t), t.now()
            while not (abs((got := position(t)) - goal) <= allowed and at_standstill(t)):
                if t.now() - begin > limit or (t.now() - begin > ms(300) and _rests(t, got)):
                    raise Fail(
                        f"a relative set-point of {way} under way to {start + 2 * way}, {words}: it is at {got}", str(goal), str(got)
                    )
                t.pause(ms(5))
            control(t, 0x0F)
            back(t, start)


def _rests(t: NodeTester, before: int) -> bool:
    """Not between two set-points."""
    t.pause(ms(300))
    return at_standstill(t) and position(t) == before


@POS.case(
    "BV_12",
    "bit 10 shows standstill during halt",
    "Bit 10 zeigt Stillstand während Halt",
    clause="CiA 402-2, bit 10 with bit 8 of the controlword",
    preamble=(*MOVES, "CIA402_POS_BV_06"),
)
def halted_shown(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        order(t, start + 4 * way)
        with t.given():
            until(t, lambda: abs(position(t) - start) > way // 10, "motion")
        control(t, 0x0F | HALT)
        with t.given():
            until(t, lambda: at_standstill(t), "standstill after halt", ms(3000))
        until(t, lambda: bool(status(t) & REACHED), "bit 10 at standstill during halt", ms(1000))
        control(t, 0x0F)
        t.pause(ms(50))
        with t.given():
            arrives(t, start + 4 * way, "the set-point after halt")
        back(t, start)


@POS.case(
    "BO_03", "a set-point during halt moves nothing", "ein Sollwert während Halt bewegt nichts", preamble=(*MOVES, "CIA402_POS_BV_06")
)
def during_halt(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        control(t, 0x0F | HALT)
        t.download(TARGET, start + way, 4)
        control(t, 0x1F | HALT)
        t.pause(ms(300))
        got = position(t)
        control(t, 0x0F | HALT)
        control(t, 0x0F)
        t.pause(ms(100))
        with t.given():
            until(t, lambda: at_standstill(t), "standstill", patience(t))
        if abs(got - start) > max(way // 10, 50):
            raise Fail(f"it moved to {got} during halt", f"{start}, standstill", str(got))
        back(t, start)


@POS.case(
    "BI_04",
    "a second target while bit 4 stays set moves nothing: a set-point is an edge",
    "ein zweites Ziel bei stehendem Bit 4 bewegt nichts: ein Sollwert ist eine Flanke",
)
def held(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        t.download(TARGET, start + way, 4)
        control(t, 0x1F)
        with t.given():
            arrives(t, start + way, "the first target")
        t.download(TARGET, start, 4)
        control(t, 0x1F)
        t.pause(ms(200))
        got = position(t)
        control(t, 0x0F)
        back(t, start)
        if abs(got - start - way) > max(way // 20, 50):
            raise Fail(f"it moved to {got} though bit 4 was set already", str(start + way), str(got))


@POS.case(
    "BV_13",
    "6068h is how long it is inside 6067h before bit 10",
    "6068h ist, wie lange er in 6067h steht, bevor Bit 10 kommt",
    clause="CiA 402-2, 6067h and 6068h",
    condition=("window", "window_time"),
    beside=Particulars(limits="6068h = 400 ms, more for slow SDO answers: 80 % to 600 ms more"),
)
def window_time(t: NodeTester) -> None:
    with t.kept(POSITION_TIME), positioning(t) as (start, way):
        time = 400 + 10 * t.setup.took // 1_000_000
        with t.given():
            t.download(POSITION_TIME, time, 2)
            window = max(t.number(WINDOW), 1)
        target = start + way
        order(t, target)
        with t.given():
            until(t, lambda: abs(position(t) - target) <= window and at_standstill(t), f"inside 6067h of {target}", patience(t))
        inside = t.now()
        if status(t) & REACHED and not status(t) & BIT12:
            raise Fail("bit 10 is set as soon as it is at rest", f"{time} ms later (6068h)", named(status(t)))
        until(t, lambda: bool(status(t) & REACHED), "target reached", ms(time + 2000))
        took = t.now() - inside
        t.download(POSITION_TIME, 0, 2)
        back(t, start)
        t.timed(f"inside 6067h to bit 10, 6068h = {time}", took, ms(0.8 * time), ms(time + 600))
