"""SERVODYN: values latched and accepted at SYNC, feed-forward and torque, observed in motion (AX-001, AX-083)."""

from collections.abc import Sequence

from gateway.conformance.suites.servodyn.booster import BoosterTester, words
from gateway.conformance.suites.servodyn.cycle import BASIC, REST
from gateway.conformance.suites.servodyn.motion import BACK, FOLLOWS, NEAR
from gateway.conformance.suites.servodyn.power import CONTROL, ON
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import Ns

PHASE = Purposes[BoosterTester](
    "SERVO_MOV", "booster", "AX-001, phase", condition=("may_move",), preamble=(BASIC, REST, ON, CONTROL, FOLLOWS)
)
SWING = Purposes[BoosterTester](
    "SERVO_MOV", "booster", "AX-001", condition=("may_move",), preamble=(BASIC, REST, ON, CONTROL, FOLLOWS, BACK)
)
RUN = 40  # cycles of a motion at constant speed
LATES, BETWEEN = 5, 6  # SYNCs that come late, and cycles from one to the next
JERK = 24  # cycles of a motion that speeds up and slows down
SPREAD = 0.6  # of a step, between late SYNCs
LARGEST_TORQUE = 10_000  # 0.1 % of rated: ten times the rated torque


def paced(t: BoosterTester, late: Ns = 0) -> int:
    """One cycle further by a step, its SYNC late by so much; returns the latched position."""
    if late:
        t.pause(t.setup.cycle + late)
    found = t.turn(1, with_set=False)
    if found.fault or not found.enabled:
        raise Fail(f"it does not stay under control: {words(found)}", "enabled, no fault", words(found))
    return found.position_inc


def step_of(t: BoosterTester) -> int:
    """Increments a cycle: the way in 40 cycles."""
    return max(t.setup.way // RUN, 2)


def advance(t: BoosterTester, step: int) -> None:
    t.give(position_inc=t.value.position_inc + step)
    t.say_set()


@PHASE.case(
    "BV_08",
    "a position is latched at SYNC: with a SYNC half a cycle late it is that much farther, not with the next one",
    "die Lage wird beim SYNC gefasst: kommt er einen halben Zyklus später, ist sie entsprechend weiter, nicht erst beim nächsten",
)
def latched(t: BoosterTester) -> None:
    step = step_of(t)
    farther, next_one = list[float](), list[float]()
    with t.powered(True):
        start = t.value.position_inc
        t.turn()
        before, usual = paced(t), 0
        for at in range(RUN):
            advance(t, step)
            is_late = at >= BETWEEN and at % BETWEEN == 0 and len(farther) < LATES
            now = paced(t, t.setup.cycle // 2 if is_late else 0)
            if is_late:
                farther.append((now - before - usual) / step)
            elif len(next_one) < len(farther):
                next_one.append((now - before - usual) / step)
            else:
                usual = now - before  # the way of a cycle, which grows until the lag is constant
            before = now
        t.move(start - t.value.position_inc)
    _judge_latching(farther[: len(next_one)], next_one)


def _judge_latching(farther: Sequence[float], next_one: Sequence[float]) -> None:
    shown = ", ".join(f"{one:.2f}" for one in farther)
    late, after = sum(farther) / len(farther), sum(next_one) / len(next_one)
    got = f"{shown} steps more at the late SYNCs; {after:.2f} on average at those after them"
    if max(farther) - min(farther) > SPREAD:
        raise Fail(
            "the position it reports is not that of SYNC: a SYNC late by the same time adds different ways",
            "the same distance each time",
            got,
        )
    if after > late + 0.1:
        raise Fail("the position it reports is that of the SYNC before", "the longer distance in the answer to the late SYNC", got)


@PHASE.case(
    "BO_01", "a set value acts with the next SYNC, not when it comes", "ein Sollwert wirkt mit dem nächsten SYNC, nicht beim Empfang"
)
def waits(t: BoosterTester) -> None:
    way = _nudge(t)
    with t.powered(True):
        start = t.value.position_inc
        t.turn()
        t.sync()
        t.answered()
        t.give(position_inc=start + way)
        t.say_set()
        t.pause(t.setup.cycle * 17 // 10)
        t.sync()
        found = t.answered()
        t.give(position_inc=start)
        t.say_set()
        t.turn(20)
        if abs(found.position_inc - start) > NEAR:
            raise Fail(
                f"it is at {found.position_inc} already at the SYNC with which the set value takes effect",
                f"{start}, within {NEAR}",
                words(found),
            )


@PHASE.case(
    "BV_12",
    "a set value acts with the next SYNC, not with the one after it",
    "ein Sollwert wirkt mit dem nächsten SYNC, nicht mit dem übernächsten",
    beside=Particulars(limits="a twentieth of the step at the second SYNC"),
)
def acts(t: BoosterTester) -> None:
    """The first SYNC after the set value activates it, the second one latches what it did."""
    way = _nudge(t)
    with t.powered(True):
        start = t.value.position_inc
        for goal in (start + way, start):
            t.turn(20)
            before = t.turn(with_set=False).position_inc
            t.give(position_inc=goal)  # by the set value, then by two SYNCs
            t.say_set()
            t.sync()
            activated = t.asked_at
            t.answered()
            t.say_set()
            t.pause(activated + t.setup.cycle * 17 // 10 - t.now())
            t.sync()
            found = t.answered()
            t.say_set()
            t.turn(20)
            if (found.position_inc - before) * (goal - before) < abs(goal - before) * way // 20:
                raise Fail(
                    f"it is at {found.position_inc} at the second SYNC after the set value {goal}",
                    f"on the way from {before}",
                    words(found),
                )


@PHASE.case("BV_09", "of two set values between two SYNCs the last one counts", "von zwei Sollwerten zwischen zwei SYNC zählt der letzte")
def last_one(t: BoosterTester) -> None:
    way = _nudge(t)
    with t.powered(True):
        start = t.value.position_inc
        t.turn()
        for _ in range(3):
            t.sync()
            t.answered()
            t.give(position_inc=start + way)
            t.say_set()
            t.value = t.value._replace(position_inc=start, life=(t.value.life - 1) & 0xFF)
            t.say_set()
            for _ in range(5):
                found = t.turn()
                if abs(found.position_inc - start) > NEAR:
                    raise Fail(
                        f"it moves to {found.position_inc} by a set value that was replaced", f"{start}, within {NEAR}", words(found)
                    )


def _nudge(t: BoosterTester) -> int:
    """A step that a booster makes visibly in one cycle."""
    way = t.setup.way // 2
    if way < 10 * NEAR:
        raise NotApplicable(f"the way of {t.setup.way} is too short to see the effect of one set value")
    return way


@SWING.case(
    "BV_10",
    "the speed feed-forward has the direction and the unit of the motion: the lag does not grow with it",
    "die Drehzahlvorsteuerung hat Richtung und Einheit der Bewegung: der Schleppabstand wächst nicht mit ihr",
    beside=Particulars(limits="with feed-forward between -0.5 and 1 times the lag without it, and 40 increments"),
)
def feed_forward(t: BoosterTester) -> None:
    step = step_of(t)
    rpm = round(step * 60e9 / t.setup.cycle / t.setup.turn)
    if not rpm:
        raise NotApplicable("the motion is slower than 1 rpm")
    with t.powered(True):
        for sign in (1, -1):
            plain = _lag(t, sign * step, 0) * sign
            helped = _lag(t, -sign * step, -sign * rpm) * -sign
            if not -plain / 2 - NEAR <= helped <= plain + NEAR:
                limits = f"{-plain / 2 - NEAR:.0f} to {plain + NEAR:.0f} increments"
                raise Fail(
                    f"the lag with {-sign * rpm} rpm of feed-forward is {helped:.0f}, without it {plain:.0f}", limits, f"{helped:.0f}"
                )


def _lag(t: BoosterTester, step: int, rpm: int) -> float:
    """Mean of set minus actual position at constant speed."""
    found = list[int]()
    for _ in range(RUN):
        t.give(speed_rpm=rpm)
        wanted = t.value.position_inc
        advance(t, step)
        found.append(wanted - paced(t))
    t.give(speed_rpm=0)
    t.say_set()
    t.turn(60)
    return sum(found[RUN // 2 :]) / (RUN - RUN // 2)


@SWING.case(
    "BV_11",
    "the torque has the sign of the acceleration, forwards and backwards",
    "das Moment hat das Vorzeichen der Beschleunigung, vorwärts und rückwärts",
)
def torque(t: BoosterTester) -> None:
    with t.powered(True):
        for sign, words_of in ((1, "forwards"), (-1, "backwards")):
            speeds_up, slows_down = _torques(t, sign * t.setup.way)
            values = [*speeds_up, *slows_down]
            worst = max(values, key=abs)
            if abs(worst) > LARGEST_TORQUE:
                raise Fail(f"a torque of {worst}", f"0.1 % of rated: less than {LARGEST_TORQUE}", str(worst))
            if not any(values):
                raise Fail("the torque is always 0 while it moves", "the torque of friction and acceleration", "0")
            mean = sum(speeds_up) / len(speeds_up) - sum(slows_down) / len(slows_down)
            if mean * sign <= 0:
                got = f"{words_of}: {mean:.0f} more while it speeds up than while it slows down"
                raise Fail(f"the torque has the wrong sign {words_of}", "positive for an acceleration forwards", got)


def _torques(t: BoosterTester, way: int) -> tuple[list[int], list[int]]:
    """Along two parabolas; the torques of both halves, late by the lag of the booster."""
    start, half = t.value.position_inc, JERK // 2
    found = list[int]()
    for at in range(1, JERK + 1):
        part = at * at / (2 * half * half) if at <= half else 1 - (JERK - at) ** 2 / (2 * half * half)
        t.give(position_inc=start + round(way * part))
        found.append(t.turn().torque_permille)
    for _ in range(4):
        found.append(t.turn().torque_permille)
    t.turn(60)
    return found[2 : half + 1], found[half + 4 :]
