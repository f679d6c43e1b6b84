"""CiA 402, modes: which there are, profile position, profile velocity, homing, cyclic position, limits (CiA 402-2, -3)."""

from collections.abc import Iterator
from contextlib import contextmanager

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.cia402.drive import (
    ACCELERATION,
    BIT12,
    BIT13,
    ENABLED,
    HM,
    INTERNAL,
    LIMIT_HIGH,
    LIMIT_LOW,
    MODE,
    MODE_SHOWN,
    MODES_OFFERED,
    PP,
    PROFILE_SPEED,
    REACHED,
    STEP,
    TARGET,
    TARGET_SPEED,
    brought_to,
    control,
    named,
    plan,
    position,
    speed,
    standing,
    status,
    until,
)
from gateway.conformance.suites.cia402.faults import POWER, cyclic
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import Ns, ms
from protocols.canopen import sdo
from protocols.canopen.sdo import Abort, Request

BASIC = "CIA402_PWR_BV_01"
MOD = Purposes[NodeTester]("CIA402_MOD", "drive", "CiA 402-2, modes of operation", condition=("modes",), preamble=(BASIC,))
OFFERED = {1: 0, 2: 1, 3: 2, 4: 3, 6: 5, 7: 6, 8: 7, 9: 8, 10: 9}  # mode: bit of 6502h
DISPLAY = ms(1000)
METHOD, OFFSET, WINDOW = (0x6098, 0), (0x607C, 0), (0x6067, 0)


def shown_mode(t: NodeTester, wanted: int) -> int:
    """6061h; a drive may need a moment to change."""
    begin = t.now()
    while (got := t.number(MODE_SHOWN, signed=True)) != wanted and t.now() - begin < DISPLAY:
        t.pause(STEP)
    return got


@MOD.case("BV_01", "6061h shows each mode that 6502h offers", "6061h zeigt jede Betriebsart, die 6502h anbietet")
def shown_modes(t: NodeTester) -> None:
    offered = t.number(MODES_OFFERED)
    with t.kept(MODE):
        for mode, bit in OFFERED.items():
            if offered >> bit & 1:
                t.download(MODE, mode, 1)
                if (got := shown_mode(t, mode)) != mode:
                    raise Fail(f"6061h is {got} after 6060h = {mode}", str(mode), str(got))


@MOD.case(
    "BI_01",
    "a mode that 6502h does not offer is refused, or not shown",
    "eine nicht angebotene Betriebsart wird abgelehnt oder nicht angezeigt",
    preamble=(BASIC, "CIA402_MOD_BV_01"),
)
def other_modes(t: NodeTester) -> None:
    with t.given():
        offered = t.number(MODES_OFFERED)
    with t.kept(MODE):
        for mode in (*(mode for mode, bit in OFFERED.items() if not offered >> bit & 1), 5, 120):
            got = t.ask(sdo.expedited(Request.INITIATE_DOWNLOAD, MODE, bytes((mode,))))
            if got[:1] == b"\x80":
                if sdo.abort_of(got).code not in (Abort.VALUE, Abort.TOO_HIGH, Abort.TOO_LOW, Abort.GENERAL, Abort.DEVICE_STATE):
                    t.judge_refusal(got, (Abort.VALUE,), f"mode {mode}")
                continue
            t.pause(ms(10))
            if (shown := t.number(MODE_SHOWN, signed=True)) == mode:
                raise Fail(f"mode {mode} is shown, 6502h does not offer it", "a refusal, or another 6061h", f"6061h = {shown}")


# ---- profile position
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
    took = until(t, lambda: bool(status(t) & REACHED) and standing(t), f"{what}: target reached")
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
        while not (status(t) & REACHED and standing(t)) and t.now() - begin < ms(8000):
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
        farthest = start
        begin = t.now()
        while t.now() - begin < ms(8000):
            farthest = max(farthest, position(t))
            if farthest > start + way * 9 // 10 and status(t) & REACHED and standing(t) and position(t) < start + way // 2:
                break
            t.pause(ms(2))
        control(t, 0x0F)
        if farthest < start + way * 9 // 10:
            raise Fail(f"the first target was left at {farthest}", f"{start + way}", str(farthest))
        arrives(t, start, "the second set-point")


@POS.case("BV_06", "halt stops the motion, and its end continues it", "Halt hält die Bewegung an, sein Ende setzt sie fort", preamble=MOVES)
def halt(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        order(t, start + 4 * way)
        with t.given():
            until(t, lambda: abs(speed(t)) > plan(t)[0] // 2, "motion")
        control(t, 0x10F)
        until(t, lambda: standing(t), "standstill after halt", ms(3000))
        held = position(t)
        t.pause(ms(50))
        if abs(position(t) - held) > max(way // 20, 20) or held > start + 4 * way - way // 4:
            raise Fail("it moves on during halt", f"it stays at {held}", str(position(t)))
        control(t, 0x0F)
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
        while not (status(t) & REACHED and standing(t)) and t.now() - begin < ms(10_000):
            top = max(top, now := abs(speed(t)))
            if now > chosen * 95 // 100:
                seen.append((t.now(), position(t)))
            t.pause(ms(1))
        nominal = round((4 * way / (chosen * _unit(t, seen, chosen)) + chosen / max(min(ramps), 1)) * 1e9)
        if top > chosen * 11 // 10:
            raise Fail(f"606Ch was {top} on the way", f"at most {chosen * 11 // 10}", str(top))
        t.timed("profile position, 4 times the way", t.now() - begin, round(0.8 * nominal), round(1.6 * nominal) + ms(100))


def _unit(t: NodeTester, seen: list[tuple[Ns, int]], chosen: int) -> float:
    """Units of 6064h a second in one unit of 606Ch: a drive may count speeds in a unit of its own."""
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


# ---- profile velocity
VEL = Purposes[NodeTester]("CIA402_VEL", "drive", "CiA 402-2, profile velocity", condition=("pv", "may_move"), preamble=POWER)
RUNS = (*POWER, "CIA402_VEL_BV_01")


@contextmanager
def turning(t: NodeTester) -> Iterator[int]:
    with t.kept(TARGET_SPEED), brought_to(t, ENABLED, 3):
        yield plan(t)[0]


def runs(t: NodeTester, wanted: int) -> Ns:
    """Judged: this speed, soon."""
    allowed = max(plan(t)[0] // 15, 20)
    return until(t, lambda: abs(speed(t) - wanted) < allowed, f"speed {wanted} in 606Ch")


@VEL.case("BV_01", "60FFh is reached in both directions, with bit 10", "60FFh wird in beiden Richtungen erreicht, mit Bit 10")
def velocity(t: NodeTester) -> None:
    with turning(t) as chosen:
        for wanted in (chosen, -chosen, 0):
            t.download(TARGET_SPEED, wanted, 4)
            runs(t, wanted)
            until(t, lambda: bool(status(t) & REACHED), f"bit 10 at speed {wanted}", ms(1000))


@VEL.case(
    "BV_02",
    "6083h and 6084h are its ramps",
    "6083h und 6084h sind seine Rampen",
    preamble=RUNS,
    beside=Particulars(limits="70 to 150 % of speed by ramp, and 60 ms"),
)
def ramps(t: NodeTester) -> None:
    with t.kept(ACCELERATION, (0x6084, 0)), turning(t) as chosen:
        with t.given():
            t.download(ACCELERATION, 2 * chosen, 4)
            t.download((0x6084, 0), 4 * chosen, 4)
        for wanted, nominal, words in ((chosen, ms(500), "acceleration, 6083h"), (0, ms(250), "deceleration, 6084h")):
            t.download(TARGET_SPEED, wanted, 4)
            took = runs(t, wanted)
            t.timed(words, took, round(0.7 * nominal), round(1.5 * nominal) + ms(60))


@VEL.case("BV_03", "bit 12 shows standstill", "Bit 12 zeigt Stillstand", preamble=RUNS)
def standstill(t: NodeTester) -> None:
    with turning(t) as chosen:
        t.download(TARGET_SPEED, 0, 4)
        until(t, lambda: bool(status(t) & BIT12), "bit 12 at standstill", ms(2000))
        t.download(TARGET_SPEED, chosen, 4)
        with t.given():
            until(t, lambda: abs(speed(t)) > chosen * 9 // 10, "motion")
        if status(t) & BIT12:
            raise Fail("bit 12 (speed is zero) in motion", "bit 12 clear", named(status(t)))


@VEL.case(
    "BO_01",
    "a speed of before is not resumed by enabling",
    "eine Geschwindigkeit von vorher läuft beim Freigeben nicht wieder an",
    preamble=RUNS,
)
def no_restart(t: NodeTester) -> None:
    """60FFh was set back meanwhile."""
    with turning(t) as chosen, t.given():
        t.download(TARGET_SPEED, chosen, 4)
        until(t, lambda: abs(speed(t)) > chosen // 2, "motion")
    with brought_to(t, ENABLED, 3):
        t.pause(ms(100))
        if not standing(t):
            raise Fail("it moves although 60FFh was set back to its value of before", "standstill", f"606Ch = {speed(t)}")


# ---- homing
HOM = Purposes[NodeTester]("CIA402_HOM", "drive", "CiA 402-2, homing", condition=("hm", "may_move"), preamble=POWER)


@contextmanager
def homing(t: NodeTester, method: int) -> Iterator[None]:
    with t.kept(METHOD, OFFSET):
        with t.given():
            t.download(METHOD, method, 1)
        with brought_to(t, ENABLED, HM):
            yield


def _here(t: NodeTester) -> int:
    """37, or 35 of older drives."""
    for method in (37, 35):
        with t.kept(METHOD):
            try:
                t.download(METHOD, method, 1)
            except Aborted:
                continue
            return method
    raise NotApplicable("methods 35 and 37 are not offered")


@HOM.case("BV_01", "homing on the spot: bit 12, and 6064h is 607Ch", "Referenzieren auf der Stelle: Bit 12, und 6064h ist 607Ch")
def on_the_spot(t: NodeTester) -> None:
    with homing(t, _here(t)):
        with t.given():
            t.download(OFFSET, 1234, 4)
        control(t, 0x1F)
        until(t, lambda: status(t) & (BIT12 | BIT13) == BIT12 and bool(status(t) & REACHED), "homing attained (bits 10 and 12)")
        if abs((got := position(t)) - 1234) > max(plan(t)[1] // 100, 20):
            raise Fail(f"6064h is {got} after homing", "1234, as 607Ch", str(got))


@HOM.case(
    "BV_02",
    "bit 12 falls when homing begins again",
    "Bit 12 fällt, wenn neu referenziert wird",
    condition=("homing_moves",),
    preamble=(*POWER, "CIA402_HOM_BV_01"),
)
def begins_again(t: NodeTester) -> None:
    with homing(t, _here(t)), t.given():
        control(t, 0x1F)
        until(t, lambda: bool(status(t) & BIT12), "homing attained")
        control(t, 0x0F)
    with homing(t, 34):
        control(t, 0x1F)
        if status(t) & (BIT12 | REACHED):
            raise Fail("bits 10 or 12 are set while homing searches", "bits 10 and 12 clear", named(status(t)))
        until(t, lambda: status(t) & (BIT12 | BIT13) == BIT12, "homing to the index attained")


@HOM.case(
    "BO_01",
    "bit 4 that falls interrupts homing: neither attained nor error",
    "ein fallendes Bit 4 unterbricht das Referenzieren: weder erreicht noch Fehler",
    condition=("homing_moves",),
    preamble=(*POWER, "CIA402_HOM_BV_01"),
)
def interrupted(t: NodeTester) -> None:
    with homing(t, 34):
        control(t, 0x1F)
        t.pause(ms(20))
        control(t, 0x0F)
        until(t, lambda: standing(t), "standstill after the interruption", ms(3000))
        if status(t) & (BIT12 | BIT13):
            raise Fail("bits 12 or 13 after an interruption", "both clear", named(status(t)))


@HOM.case(
    "BI_01",
    "a method that is not offered is refused, or ends with bit 13",
    "ein nicht angebotenes Verfahren wird abgelehnt oder endet mit Bit 13",
)
def no_method(t: NodeTester) -> None:
    with homing(t, _here(t)):
        got = t.ask(sdo.expedited(Request.INITIATE_DOWNLOAD, METHOD, b"\x0f"))
        if got[:1] == b"\x80":
            return
        control(t, 0x1F)
        until(t, lambda: bool(status(t) & BIT13), "homing error (bit 13)", ms(3000))


# ---- cyclic synchronous position
CYC = Purposes[NodeTester](
    "CIA402_CSP", "drive", "CiA 402-2, cyclic synchronous position", condition=("csp", "sync", "may_move"), preamble=POWER
)
CYCLES = 60


def _follow(t: NodeTester, start: int, way: int) -> None:
    for turn in range(1, CYCLES + 1):
        t.download(TARGET, start + way * turn // CYCLES, 4)
        t.on_grid()


@CYC.case("BV_01", "it follows the set values of SYNC and arrives", "er folgt den Sollwerten von SYNC und kommt an")
def follows(t: NodeTester) -> None:
    with cyclic(t):
        start, way = position(t), plan(t)[1] // 2
        _follow(t, start, way)
        t.on_grid(40)
        allowed = max(way // 20, 50)
        if abs((got := position(t)) - start - way) > allowed:
            raise Fail(f"it is at {got} after {CYCLES} set values", f"{start + way} +- {allowed}", str(got))


@CYC.case("BV_02", "bit 12 shows that it follows", "Bit 12 zeigt, dass er folgt", preamble=(*POWER, "CIA402_CSP_BV_01"))
def follows_bit(t: NodeTester) -> None:
    with cyclic(t):
        if not (got := status(t)) & BIT12:
            raise Fail("bit 12 is clear in CSP", "bit 12 set", named(got))


@CYC.case("BO_01", "a set value without SYNC moves nothing", "ein Sollwert ohne SYNC bewegt nichts", preamble=(*POWER, "CIA402_CSP_BV_01"))
def without_sync(t: NodeTester) -> None:
    with cyclic(t):
        start, way = position(t), max(plan(t)[1] // 20, 100)
        t.download(TARGET, start + way, 4)
        t.pause(t.period * 8 // 10)  # the next SYNC is not overdue yet
        if abs((got := position(t)) - start) > max(way // 10, 20):
            raise Fail(f"it moved to {got} before SYNC", str(start), str(got))
