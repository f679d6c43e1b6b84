"""SERVODYN: stops in motion, values kept over a fault, and the limits of life counter and set values (AX-080 to AX-083)."""

from collections.abc import Callable

from gateway.conformance.suites.servodyn.booster import BoosterTester, words
from gateway.conformance.suites.servodyn.cycle import BASIC, REST
from gateway.conformance.suites.servodyn.faults import JUMP, LIFE_LOST, LOST, RESET, coded, faulted, lose_sync
from gateway.conformance.suites.servodyn.motion import FOLLOWS, NEAR
from gateway.conformance.suites.servodyn.phase import RUN, advance, paced, step_of
from gateway.conformance.suites.servodyn.power import CLOSES, CONTROL, ON
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail
from protocols.base.machine import ms

MOVING = (BASIC, REST, ON, CONTROL, CLOSES, FOLLOWS)
FLT = Purposes[BoosterTester]("SERVO_FLT", "booster", "AX-081", condition=("may_move",), preamble=(BASIC, REST, ON, LOST))
RUNS = Purposes[BoosterTester]("SERVO_FLT", "booster", "AX-081, AX-082", condition=("may_move",), preamble=(*MOVING, LOST))
PWR = Purposes[BoosterTester]("SERVO_PWR", "booster", "AX-080", condition=("may_move",), preamble=MOVING)
LIFE = "SERVO_FLT_BV_02"
STOPS = Particulars(limits="standstill within [link] stop_ms, 500 ms unless stated")
SHIFTS = (16, 24)  # bits beyond which a narrower counter sees no difference


def direction(t: BoosterTester) -> int:
    """Cases that do not return alternate: the axis stays within one way of its first position."""
    position = t.turn().position_inc
    t.home = position if t.home is None else t.home
    return -1 if position > t.home else 1


def run_up(t: BoosterTester) -> int:
    """To constant speed; returns the values latched at the last SYNC."""
    step = direction(t) * step_of(t)
    position = t.value.position_inc
    for _ in range(RUN):
        advance(t, step)
        position = paced(t)
    return position


def _judge_standstill(t: BoosterTester, what: str) -> None:
    """Judge: soon its position no longer changes, and only then the brake closes."""
    begin, closed_at = t.now(), None
    before = t.turn().position_inc
    while True:
        found = t.turn(5)
        moved = abs(found.position_inc - before)
        before = found.position_inc
        if closed_at is not None and abs(found.position_inc - closed_at) > 2 * NEAR:
            raise Fail(f"{what}: the brake is closed and it moves on to {found.position_inc}", f"{closed_at}", words(found))
        if closed_at is None and not found.brake_open:
            closed_at = found.position_inc
        if moved <= NEAR // 8 and closed_at is not None:
            return
        if t.now() - begin > t.setup.stop:
            limit = f"standstill with the brake closed within {t.setup.stop / 1e6:.0f} ms"
            raise Fail(f"{what}: {moved} increments in five cycles after {t.setup.stop / 1e6:.0f} ms", limit, words(found))


@RUNS.case(
    "BV_06",
    "in motion a lost SYNC is a quick stop: it ends in time, the brake waits for it, code and position are those of the fault",
    "in Bewegung ist ein ausgebliebener SYNC ein Schnellhalt: er endet in der Zeit, die Bremse wartet, Code und Lage sind die des Fehlers",
    beside=STOPS,
)
def quick_stop(t: BoosterTester) -> None:
    with t.powered(True):
        last = run_up(t)
        t.say_set()
        begin = t.now()
        found = t.spontaneous(10 * t.setup.cycle)
        with t.given():
            if not found or not found[0][1].fault:
                raise Fail("no actual value at the fault", "one with the fault bit, without SYNC", "nothing")
        reported = found[0][1]
        if reported.position_inc != last:
            raise Fail(
                f"the actual value of the fault contains {reported.position_inc}", f"{last}, latched at the last SYNC", words(reported)
            )
        if not reported.brake_open:
            raise Fail("the brake closes while it moves", "brake open until standstill", words(reported))
        t.drain()
        _judge_standstill(t, "a lost SYNC in motion")
        t.remark(f"at rest {(t.now() - begin) / 1e6:.0f} ms after the last SYNC at the latest")
        now = t.turn()
        if now.fault_code != reported.fault_code:
            raise Fail(f"the fault code changes from {reported.fault_code} to {now.fault_code}", "the first code until reset", words(now))


def _stop(number: int, clear: str, summary: str, german: str) -> None:
    @PWR.case(f"BV_{number:02}", summary, german, beside=STOPS)
    def body(t: BoosterTester) -> None:
        with t.powered(True):
            run_up(t)
            t.give(**{clear: False})
            t.say_set()
            _judge_standstill(t, f"{clear.replace('_', ' ')} drops in motion")


_stop(
    6,
    "enable",
    "when enable drops in motion, the booster stops and then closes the brake",
    "fällt die Freigabe in Bewegung weg, hält er an und schließt dann die Bremse",
)
_stop(
    7,
    "drive_on",
    "when drive on drops in motion, the booster stops and then closes the brake",
    "fällt Antrieb Ein in Bewegung weg, hält er an und schließt dann die Bremse",
)


@PWR.case(
    "BV_08",
    "drive on and enable set together: power, then control; enable is not an edge",
    "Antrieb Ein und Freigabe zugleich: Leistung, dann Regelung; die Freigabe ist keine Flanke",
    preamble=(BASIC, REST, ON, CONTROL),
    beside=Particulars(limits="within 8 s"),
)
def together(t: BoosterTester) -> None:
    with t.powered():
        t.give(drive_on=False)
        t.until(lambda actual: not actual.power_on, "no power", ms(2000))
        t.give(drive_on=True, enable=True)
        t.until(lambda actual: actual.enabled and actual.power_on, "enabled, with drive on and enable set at once")


# ---- life counter and set values
@FLT.case(
    "BO_04",
    "a life counter that is once unchanged is not a fault",
    "ein Lebenszähler, der einmal steht, ist kein Fehler",
    condition=("life",),
)
def life_unchanged_once(t: BoosterTester) -> None:
    with t.powered():
        for _ in range(5):
            t.turn(4)
            t.life_runs = False
            t.turn()
            t.life_runs = True
            found = t.turn(2)
            if found.fault:
                raise Fail("a life counter that is once unchanged is treated as a loss", "no fault", words(found))


@FLT.case(
    "BV_07",
    "set values stay away while SYNC comes: a fault as with an unchanged life counter",
    "Sollwerte bleiben aus, SYNC kommt: ein Fehler wie bei stehendem Lebenszähler",
    condition=("life",),
    preamble=(BASIC, REST, ON, LIFE),
    beside=Particulars(limits="at the fifth SYNC without a new set value"),
)
def no_set_values(t: BoosterTester) -> None:
    with t.powered():
        t.turn()
        coded(t.turn(5, with_set=False), LIFE_LOST, "no set values")


# ---- set positions
def _refused(t: BoosterTester, goal: int, cycles: int, good: Callable[[], None], what: str) -> None:
    before = t.value.position_inc
    good()
    t.value = t.value._replace(position_inc=goal)
    for _ in range(cycles):
        t.sync()
        found = t.answered()
        if abs(found.position_inc - before) > JUMP // 4:
            raise Fail(f"{what}: it moves from {before} to {found.position_inc}", "a fault, no motion", words(found))
        if found.fault:
            return faulted(found, what)
        t.say_set()
    raise Fail(f"{what}: no fault", "fault, fault code 4", words(found))


@FLT.case(
    "BV_08",
    "a set position that differs in bit 16 or 24 alone is a jump: all 32 bits count",
    "ein Lagesollwert, der nur in Bit 16 oder 24 abweicht, ist ein Sprung: alle 32 Bit zählen",
    clause="AX-001, AX-083",
    preamble=(BASIC, REST, ON, CONTROL, "SERVO_FLT_BV_03"),
)
def upper_bits(t: BoosterTester) -> None:
    for shift in SHIFTS:
        with t.powered(True):
            t.turn()
            _refused(t, t.value.position_inc + (1 << shift), 20, lambda: None, f"a set position {1 << shift} farther")


@FLT.case(
    "BI_04",
    "a set position far away when control begins is a fault, and it does not move there",
    "ein weit entfernter Lagesollwert bei Beginn der Regelung ist ein Fehler, und er fährt nicht dorthin",
    clause="AX-083",
    preamble=(BASIC, REST, ON, CONTROL, "SERVO_FLT_BV_03"),
)
def far_at_control(t: BoosterTester) -> None:
    with t.powered():
        t.turn()
        cycles = max(ms(8000) // t.setup.cycle // 4, 50)
        _refused(t, t.value.position_inc + JUMP, cycles, lambda: t.give(enable=True), f"control that begins {JUMP} away")


@RUNS.case(
    "BV_09",
    "a fault and its reset keep the position",
    "ein Fehler und sein Reset behalten die Lage",
    clause="AX-001",
    preamble=(*MOVING, LOST, RESET),
)
def kept(t: BoosterTester) -> None:
    with t.powered(True):
        t.move(direction(t) * t.setup.way)
        with t.given():
            before = t.turn().position_inc
            faulted(lose_sync(t), "a lost SYNC")
            t.give(enable=False, drive_on=False)
            t.turn(100)
            t.give(fault_reset=True)
            t.until(lambda actual: not actual.fault, "no fault", ms(2000))
        found = t.turn()
        if abs(found.position_inc - before) > 2 * NEAR:
            raise Fail(f"position {found.position_inc} after fault and reset", f"{before}, within {2 * NEAR}", str(found.position_inc))
