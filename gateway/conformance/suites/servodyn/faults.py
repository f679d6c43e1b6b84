"""SERVODYN: loss of SYNC and of the life counter, jumps, reset (AX-081 to AX-083)."""

from gateway.conformance.suites.servodyn.booster import BoosterTester, words
from gateway.conformance.suites.servodyn.cycle import BASIC, REST
from gateway.conformance.suites.servodyn.power import CLOSES, CONTROL, ON
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, Warn
from protocols.base.machine import ms
from protocols.servodyn.codec import ActualValue

LOST, RESET = "SERVO_FLT_BV_01", "SERVO_FLT_BV_04"
FLT = Purposes[BoosterTester]("SERVO_FLT", "booster", "AX-081", condition=("may_move",), preamble=(BASIC, REST, ON))
SYNC_LOST, LIFE_LOST, SET_JUMP = 1, 2, 4
JUMP = 40_000  # increments, more than two turns


def coded(found: ActualValue, code: int, what: str) -> None:
    """Judged: in fault; another number is disputed."""
    if not found.fault or found.ready:
        raise Fail(f"{what}: {words(found)}", "fault, not ready", words(found))
    if found.fault_code != code:
        raise Warn(f"{what}: fault code {found.fault_code}", f"fault code {code}", str(found.fault_code))


def faulted(found: ActualValue, what: str) -> None:
    """As preparation: in fault, whatever its number is; the case of the fault judges that."""
    coded(found, found.fault_code, what)


def lose_sync(t: BoosterTester) -> ActualValue:
    """Omit SYNC for ten cycles; return the reports after that."""
    t.turn()
    t.pause(10 * t.setup.cycle)
    t.drain()
    return t.turn()


@FLT.case(
    "BV_01",
    "with power a lost SYNC is a fault, reported at once, 2 to 2.5 cycles after the last one",
    "mit Leistung ist ein ausgebliebener SYNC ein Fehler, sofort gemeldet, 2 bis 2,5 Zyklen nach dem letzten",
    beside=Particulars(limits="2 to 2.5 x P5"),
)
def sync_lost(t: BoosterTester) -> None:
    with t.powered():
        t.sync()
        start = t.asked_at
        t.answered()
        t.say_set()
        found = t.spontaneous(10 * t.setup.cycle)
        if not found:
            raise Fail("no actual value at the fault", "one actual value with the fault bit, without SYNC", "nothing")
        sending = max(ms(1), t.answered_after)  # as long as after a SYNC
        t.timed("last SYNC to the fault", found[0][0] - start, 2 * t.setup.cycle, t.setup.cycle * 5 // 2 + sending)
        coded(found[0][1], SYNC_LOST, "a lost SYNC")


@FLT.case(
    "BV_02",
    "an unchanged life counter is a fault",
    "ein stehender Lebenszähler ist ein Fehler",
    condition=("life",),
    beside=Particulars(limits="at the fourth SYNC after the last change"),
)
def life_lost(t: BoosterTester) -> None:
    with t.powered():
        t.life_runs = False
        found = t.turn(5)
        t.life_runs = True
        coded(found, LIFE_LOST, "an unchanged life counter")


@FLT.case(
    "BV_03",
    "under control a set position that jumps is a fault, and it does not move there",
    "unter Regelung ist ein springender Sollwert ein Fehler, und er fährt nicht dorthin",
    preamble=(BASIC, REST, ON, CONTROL),
)
def jump(t: BoosterTester) -> None:
    for way in (JUMP, -JUMP):
        with t.powered(True):
            before = t.turn().position_inc
            t.give(position_inc=before + way)
            found = t.turn(20)
            if abs(found.position_inc - before) > JUMP // 4:
                raise Fail(f"it moves from {before} to {found.position_inc}", "a fault, no motion", words(found))
            coded(found, SET_JUMP, f"a set position that jumps by {way}")


@FLT.case("BV_04", "the edge of fault reset ends the fault", "die Flanke von Fehler-Reset wirkt", preamble=(BASIC, REST, ON, LOST))
def reset(t: BoosterTester) -> None:
    with t.powered():
        with t.given():
            faulted(lose_sync(t), "a lost SYNC")
            t.give(drive_on=False)
            t.turn(100)
        t.give(fault_reset=True)
        t.until(lambda actual: actual.ready and not actual.fault and not actual.fault_code, "ready, fault code 0", ms(2000))
        t.give(fault_reset=False, drive_on=True)
        found = t.until(lambda actual: actual.power_on, "power on")
        if found.fault or found.fault_code:
            raise Fail(f"after the reset and drive on: {words(found)}", "power on, fault code 0", words(found))


@FLT.case("BI_01", "without reset the fault stays", "ohne Reset bleibt der Fehler", preamble=(BASIC, REST, ON, LOST))
def stays(t: BoosterTester) -> None:
    with t.powered():
        with t.given():
            first = lose_sync(t)
            faulted(first, "a lost SYNC")
        t.stays(lambda actual: actual.fault and not actual.power_on, "fault, no power", ms(500))
        t.stays(lambda actual: actual.fault_code == first.fault_code, f"fault code {first.fault_code} until reset", ms(100))
        t.give(drive_on=False)
        t.stays(lambda actual: actual.fault, "fault, drive on dropped", ms(300))
        t.give(drive_on=True, enable=True)
        t.stays(lambda actual: actual.fault and not actual.power_on, "fault, drive on again", ms(1000))


@FLT.case(
    "BI_02",
    "a fault reset that is already set when the fault comes does not reset it",
    "ein Fehler-Reset, der beim Fehler schon ansteht, setzt ihn nicht zurück",
    preamble=(BASIC, REST, ON, LOST),
)
def level(t: BoosterTester) -> None:
    with t.powered():
        t.give(fault_reset=True)
        t.turn(4)
        found = t.spontaneous(10 * t.setup.cycle)
        with t.given():
            if not found or not found[0][1].fault:
                raise Fail("no actual value at the fault", "one with the fault bit, without SYNC", "nothing")
        t.drain()
        t.stays(lambda actual: actual.fault, "fault, reset held", ms(600))


@FLT.case(
    "BI_03",
    "after the reset drive on counts only once it was 0",
    "nach dem Reset zählt Antrieb Ein erst, wenn es 0 war",
    preamble=(BASIC, REST, ON, LOST, RESET),
)
def held(t: BoosterTester) -> None:
    with t.powered():
        with t.given():
            faulted(lose_sync(t), "a lost SYNC")
            t.turn(100)
        t.give(fault_reset=True)
        t.until(lambda actual: not actual.fault, "no fault", ms(2000))
        t.give(fault_reset=False)
        t.stays(lambda actual: not actual.power_on, "no power, drive on held", ms(2000))


@FLT.case("BO_01", "one missing SYNC is not a fault", "ein einzelner fehlender SYNC ist kein Fehler")
def one_missing(t: BoosterTester) -> None:
    with t.powered():
        for _ in range(5):
            t.turn(4)
            t.say_set()
            t.pause(t.setup.cycle * 3 // 2)
            found = t.turn()
            if found.fault:
                raise Fail("one missing SYNC is treated as a loss", "no fault", words(found))


@FLT.case("BO_02", "one missing set value is not a fault", "ein einzelner fehlender Sollwert ist kein Fehler")
def one_set_missing(t: BoosterTester) -> None:
    with t.powered():
        for _ in range(5):
            t.turn(4)
            found = t.turn(1, with_set=False)
            found = t.turn()
            if found.fault:
                raise Fail("one missing set value is treated as a loss", "no fault", words(found))


@FLT.case(
    "BO_03", "without power a lost SYNC is not a fault", "ohne Leistung ist ein ausgebliebener SYNC kein Fehler", preamble=(BASIC, REST)
)
def idle_sync(t: BoosterTester) -> None:
    t.rest()
    found = lose_sync(t)
    if found.fault:
        raise Fail("a lost SYNC without power is a fault", "no fault; a warning is allowed", words(found))


@FLT.case(
    "BV_05",
    "under control a lost SYNC stops it: control ends, the brake closes",
    "unter Regelung hält ihn ein ausgebliebener SYNC an: Regelung aus, Bremse zu",
    preamble=(BASIC, REST, ON, CONTROL, CLOSES, LOST),
)
def stops(t: BoosterTester) -> None:
    with t.powered(True):
        with t.given():
            faulted(lose_sync(t), "a lost SYNC")
        t.until(lambda actual: not actual.enabled and not actual.brake_open and not actual.power_on, "stopped, brake closed", ms(5000))
