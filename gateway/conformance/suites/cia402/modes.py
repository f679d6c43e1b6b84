"""CiA 402, modes: which there are, profile velocity, homing, cyclic position (CiA 402-2, -3)."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.can.node import named as object_name
from gateway.conformance.suites.cia402.drive import (
    ACCELERATION,
    BIT12,
    BIT13,
    DISPLAY,
    ENABLED,
    HM,
    MODE,
    MODE_SHOWN,
    MODES_OFFERED,
    PROFILE_SPEED,
    REACHED,
    STEP,
    TARGET,
    TARGET_SPEED,
    at_standstill,
    brought_to,
    control,
    named,
    plan,
    position,
    speed,
    state_of,
    status,
    there,
    until,
)
from gateway.conformance.suites.cia402.faults import POWER, cyclic
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import Ns, ms
from protocols.canopen import sdo
from protocols.canopen.dictionary import Key
from protocols.canopen.sdo import Abort, Request

BASIC = "CIA402_PWR_BV_01"
MOD = Purposes[NodeTester]("CIA402_MOD", "drive", "CiA 402-2, modes of operation", condition=("modes",), preamble=(BASIC,))
OFFERED = {1: 0, 2: 1, 3: 2, 4: 3, 6: 5, 7: 6, 8: 7, 9: 8, 10: 9}  # mode: bit of 6502h
METHOD, OFFSET = (0x6098, 0), (0x607C, 0)
INDEX = 34  # homing method


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


NEEDED: dict[str, tuple[Key, ...]] = {"pp": (TARGET, PROFILE_SPEED), "pv": (TARGET_SPEED,), "hm": (METHOD,), "csp": (TARGET,)}


@MOD.case(
    "BV_04",
    "each mode that is offered has its mandatory objects",
    "jede angebotene Betriebsart hat ihre vorgeschriebenen Objekte",
)
def complete(t: NodeTester) -> None:
    for item, keys in NEEDED.items():
        missing = [key for key in keys if t.setup.pics.get(item) and not t.exists(key)]
        if missing:
            shown = ", ".join(object_name(key) for key in missing)
            raise Fail(f"the drive offers {item} without {shown}", shown, "the object does not exist")


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
    return until(t, lambda: abs(speed(t) - wanted) < allowed, f"speed {wanted} in 606Ch", beside=lambda: f"606Ch = {speed(t)}")


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
    """60FFh was reset in between."""
    with turning(t) as chosen, t.given():
        t.download(TARGET_SPEED, chosen, 4)
        until(t, lambda: abs(speed(t)) > chosen // 2, "motion")
    with brought_to(t, ENABLED, 3):
        t.pause(ms(100))
        if not at_standstill(t):
            raise Fail("it moves although 60FFh was set back to its former value", "standstill", f"606Ch = {speed(t)}")


# ---- homing
HOM = Purposes[NodeTester]("CIA402_HOM", "drive", "CiA 402-2, homing", condition=("hm", "may_move"), preamble=POWER)


@contextmanager
def homing(t: NodeTester, method: int) -> Iterator[None]:
    with t.kept(METHOD, *there(t, OFFSET)):
        with t.given():
            try:
                t.download(METHOD, method, 1)
            except Aborted as refused:
                raise NotApplicable(f"method {method} is not offered: {refused.got}") from refused
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
    offsets = there(t, OFFSET)
    for wanted in (-4321, 1234) if offsets else (0,):
        with homing(t, _here(t)):
            with t.given():
                for key in offsets:
                    t.download(key, wanted, 4)
            control(t, 0x1F)
            until(t, lambda: status(t) & (BIT12 | BIT13) == BIT12 and bool(status(t) & REACHED), "homing attained (bits 10 and 12)")
            if abs((got := position(t)) - wanted) > max(plan(t)[1] // 100, 20):
                raise Fail(f"6064h is {got} after homing", f"{wanted}, as 607Ch", str(got))


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
            raise Fail("bit 10 or 12 is set while homing is under way", "bits 10 and 12 clear", named(status(t)))
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
        if status(t) & BIT12 and at_standstill(t):
            raise Inconclusive("homing was over before it could be interrupted", "a motion", named(status(t)))
        control(t, 0x0F)
        until(t, lambda: at_standstill(t), "standstill after the interruption", ms(3000))
        if status(t) & (BIT12 | BIT13):
            raise Fail("bit 12 or 13 is set after an interruption", "both clear", named(status(t)))


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


@HOM.case(
    "BO_03",
    "without bit 4 homing does not start",
    "ohne Bit 4 beginnt kein Referenzieren",
    preamble=(*POWER, "CIA402_HOM_BV_01"),
)
def not_started(t: NodeTester) -> None:
    """On the spot with another offset, and to the index: neither position nor motion changes."""
    offsets = there(t, OFFSET)
    for method in (_here(t), INDEX) if t.setup.pics.get("homing_moves") else (_here(t),):
        with t.kept(*offsets):
            with t.given():
                before = position(t)
                for key in offsets:
                    t.download(key, before + plan(t)[1], 4)
            with homing(t, method):
                for _ in range(3):
                    t.pause(ms(100))
                    if abs((got := position(t)) - before) > max(plan(t)[1] // 100, 20) or not at_standstill(t):
                        raise Fail(f"homing by method {method} starts without bit 4: 6064h is {got}", f"{before}, standstill", str(got))
                    control(t, 0x0F)


# ---- cyclic synchronous position
CYC = Purposes[NodeTester](
    "CIA402_CSP", "drive", "CiA 402-2, cyclic synchronous position", condition=("csp", "sync", "may_move"), preamble=POWER
)
CYCLES = 60
RPDOS = 4
SYNCHRONOUS = 240  # the highest transmission type that waits for SYNC


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
        if state_of(word := status(t)) != ENABLED:
            raise Fail(f"operation enabled ends while it follows SYNC: {named(word)}", "operation enabled", named(word))
        if abs((got := position(t)) - start - way) > allowed:
            raise Fail(f"it is at {got} after {CYCLES} set values", f"{start + way} +- {allowed}", str(got))


@CYC.case("BV_02", "bit 12 shows that it follows", "Bit 12 zeigt, dass er folgt", preamble=(*POWER, "CIA402_CSP_BV_01"))
def follows_bit(t: NodeTester) -> None:
    with cyclic(t):
        if not (got := status(t)) & BIT12:
            raise Fail("bit 12 is clear in CSP", "bit 12 set", named(got))


def _waits_for_sync(t: NodeTester) -> bool:
    """The RPDO that carries 607Ah is of a synchronous type."""
    for number in range(RPDOS):
        with suppress(Ended):
            words = [t.number((0x1600 + number, sub + 1)) for sub in range(t.number((0x1600 + number, 0)))]
            if any(word >> 8 == TARGET[0] << 8 for word in words) and t.number((0x1400 + number, 2)) <= SYNCHRONOUS:
                return True
    return False


@CYC.case("BO_01", "a set value without SYNC moves nothing", "ein Sollwert ohne SYNC bewegt nichts", preamble=(*POWER, "CIA402_CSP_BV_01"))
def without_sync(t: NodeTester) -> None:
    with cyclic(t):
        start, way = position(t), max(plan(t)[1] // 20, 100)
        t.download(TARGET, start + way, 4)
        t.pause(t.period * 8 // 10)  # the next SYNC is not overdue yet
        if abs((got := position(t)) - start) <= max(way // 10, 20):
            return
        if not _waits_for_sync(t):
            raise Warn("a set value written by SDO acts before SYNC; no RPDO carries 607Ah with SYNC", str(start), str(got))
        raise Fail(f"it moved to {got} before SYNC", str(start), str(got))
