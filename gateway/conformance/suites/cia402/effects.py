"""CiA 402, reported values are in force: modes, limits and options by their effect, positions over a fault (CiA 402-2)."""

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.cia402.drive import (
    BIT12,
    BIT13,
    DECELERATION,
    DISPLAY,
    ENABLED,
    MODE,
    PP,
    PV,
    READY,
    SHUTDOWN_OPTION,
    TARGET,
    TARGET_SPEED,
    WINDOW,
    WINDOW_TIME,
    at_standstill,
    brought_to,
    choose,
    control,
    moving,
    named,
    plan,
    position,
    reaches,
    speed,
    state_of,
    status,
    stays,
    there,
    until,
)
from gateway.conformance.suites.cia402.faults import FAULTS, LOST, POWER, RAMPED, WATCHES, cyclic, fault_in_motion, faulty, reset_by
from gateway.conformance.suites.cia402.modes import RUNS, homing, runs, shown_mode, turning
from gateway.conformance.suites.cia402.positioning import MOVES, arrives, order, positioning
from gateway.conformance.suites.cia402.setpoints import HALT, back
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, Inconclusive, NotApplicable
from protocols.base.machine import ms

EFFECT = Purposes[NodeTester](
    "CIA402_MOD",
    "drive",
    "CiA 402-2, 6061h",
    condition=("may_move", "modes", "pp", "pv", "velocity"),
    preamble=(*POWER, "CIA402_MOD_BV_01", "CIA402_MOD_BV_02", "CIA402_VEL_BV_01"),
)
KEPT = Purposes[NodeTester](
    "CIA402_FLT", "drive", "CiA 402-2, 6064h", condition=(*FAULTS, "pp", "may_move"), preamble=(*MOVES, LOST, "CIA402_FLT_BV_02")
)
WIDE = Purposes[NodeTester](
    "CIA402_FLT", "drive", "CiA 402-2, 6065h", condition=("csp", "following", "may_move"), preamble=(*POWER, "CIA402_FLT_BV_07")
)
MOTOR = Purposes[NodeTester](
    "CIA402_VEL", "drive", "CiA 402-2, 6080h", condition=("pv", "may_move", "motor_speed", "velocity"), preamble=RUNS
)
OPTIONS = Purposes[NodeTester](
    "CIA402_OPT", "drive", "CiA 402-2, option codes", condition=("pv", "may_move"), preamble=(*POWER, "CIA402_VEL_BV_01")
)
STOPPED = Purposes[NodeTester](
    "CIA402_HOM", "drive", "CiA 402-2, homing", condition=("hm", "may_move", "homing_moves"), preamble=(*POWER, "CIA402_HOM_BV_01")
)
MOTOR_SPEED = (0x6080, 0)
SLOW_RPM = 1
AT_ONCE = Particulars(limits="within 200 ms")


@EFFECT.case(
    "BV_03",
    "a mode that 6061h shows in operation enabled is in force: its set value acts, that of the former mode does not",
    "eine Betriebsart, die 6061h in Operation Enabled zeigt, ist wirksam: ihr Sollwert wirkt, der der vorigen nicht",
)
def in_force(t: NodeTester) -> None:
    chosen = plan(t)[0]
    with t.kept(TARGET_SPEED, TARGET), brought_to(t, ENABLED, PP):
        with t.given():
            t.download(TARGET_SPEED, chosen, 4)
        _changes_to(t, PV)
        try:
            runs(t, chosen)
        except Fail as failed:
            raise Fail(f"6061h shows 3, but 60FFh does not act: {failed.reason}", failed.expected, failed.got) from failed
        _changes_to(t, PP)
        t.download(TARGET_SPEED, -chosen, 4)
        try:
            until(t, lambda: at_standstill(t), "standstill in profile position", ms(5000), lambda: f"606Ch = {speed(t)}")
        except Fail as failed:
            raise Fail(f"6061h shows 1, but 60FFh still acts: {failed.reason}", failed.expected, failed.got) from failed


def _changes_to(t: NodeTester, mode: int) -> None:
    try:
        t.download(MODE, mode, 1)
    except Aborted as refused:
        raise NotApplicable("6060h cannot be changed in operation enabled") from refused
    with t.given():
        if (got := shown_mode(t, mode)) != mode:
            raise Fail(f"6061h is {got} after 6060h = {mode}, {DISPLAY / 1e6:.0f} ms later", str(mode), str(got))


@KEPT.case("BV_10", "a fault and its reset keep the position", "ein Fehler und sein Reset behalten die Lage")
def kept(t: NodeTester) -> None:
    with positioning(t) as (start, way), t.given():
        order(t, start + way)
        arrives(t, start + way, "one way")
    with faulty(t):
        before = position(t)
        with t.given():
            reset_by(t, 0x80, "fault reset")
        got = position(t)
    with positioning(t):
        back(t, start)
    if abs(got - before) > max(way // 20, 50):
        raise Fail(f"6064h is {got} after the reset of a fault", f"{before}, as before it", str(got))


@WIDE.case(
    "BI_05",
    "a lag inside 6065h is not a fault, however long it lasts",
    "ein Schleppabstand innerhalb 6065h ist kein Fehler, wie lange er auch dauert",
)
def inside(t: NodeTester) -> None:
    way = plan(t)[1]
    times = there(t, WINDOW_TIME)
    with t.kept(WINDOW, *times, TARGET), cyclic(t):
        with t.given():
            t.download(WINDOW, 16 * way, 4)
            for key in times:
                t.download(key, 1, 2)
        t.download(TARGET, position(t) + 4 * way, 4)
        for _ in range(60):
            t.on_grid()
            if state_of(got := status(t)) != ENABLED:
                raise Fail(f"a lag of at most {4 * way} is a fault, 6065h = {16 * way}", "operation enabled", named(got))


@MOTOR.case("BV_08", "6080h bounds the speed as well", "auch 6080h begrenzt die Geschwindigkeit")
def motor_speed(t: NodeTester) -> None:
    with t.kept(MOTOR_SPEED):
        try:
            t.download(MOTOR_SPEED, SLOW_RPM, 4)
        except Aborted as refused:
            raise NotApplicable(f"6080h does not accept {SLOW_RPM}: {refused.got}") from refused
        with turning(t) as chosen:
            t.download(TARGET_SPEED, chosen, 4)
            top, begin = 0, t.now()
            while t.now() - begin < ms(1000):
                top = max(top, abs(speed(t)))
                t.pause(ms(5))
            t.download(TARGET_SPEED, 0, 4)
            if top >= chosen * 9 // 10 and chosen > 2 * SLOW_RPM:
                raise Fail(f"606Ch was {top} with 6080h = {SLOW_RPM} rpm", f"less than 60FFh = {chosen}", str(top))


# ---- option codes
@OPTIONS.case(
    "BV_12",
    "605Bh = 0: shutdown takes the torque away at once",
    "605Bh = 0: Shutdown nimmt sofort das Moment weg",
    condition=("shutdown_option",),
    beside=AT_ONCE,
)
def shutdown_at_once(t: NodeTester) -> None:
    with t.kept(SHUTDOWN_OPTION, DECELERATION), moving(t) as chosen:
        with t.given():
            choose(t, SHUTDOWN_OPTION, 0)
            t.download(DECELERATION, max(2 * chosen, 1), 4)
        control(t, 0x06)
        t.timed("shutdown, 605Bh = 0", reaches(t, READY, "shutdown, 605Bh = 0"), None, ms(200))


@OPTIONS.case(
    "BV_13",
    "605Eh = 1: a fault in motion stops along 6084h, then fault",
    "605Eh = 1: ein Fehler in Bewegung hält an der Rampe 6084h, dann Fehler",
    condition=("fault_option", *WATCHES),
    preamble=(*POWER, "CIA402_VEL_BV_01", LOST),
    beside=RAMPED,
)
def slow_reaction(t: NodeTester) -> None:
    fault_in_motion(t, 1, DECELERATION)


@OPTIONS.case(
    "BV_14",
    "605Eh = 0: a fault in motion takes the torque away at once",
    "605Eh = 0: ein Fehler in Bewegung nimmt sofort das Moment weg",
    condition=("fault_option", *WATCHES),
    preamble=(*POWER, "CIA402_VEL_BV_01", LOST),
    beside=AT_ONCE,
)
def no_reaction(t: NodeTester) -> None:
    fault_in_motion(t, 0, DECELERATION)


# ---- homing
@STOPPED.case(
    "BO_02",
    "halt stops homing, without bit 12",
    "Halt hält das Referenzieren an, ohne Bit 12",
    clause="CiA 402-2, homing, bit 8 of the controlword",
)
def homing_halted(t: NodeTester) -> None:
    with homing(t, 34):
        control(t, 0x1F)
        t.pause(ms(20))
        if status(t) & BIT12 and at_standstill(t):
            raise Inconclusive("homing was over before halt", "a motion", named(status(t)))
        control(t, 0x1F | HALT)
        until(t, lambda: at_standstill(t), "standstill after halt", ms(3000))
        stays(t, ENABLED, "halt in homing", ms(100))
        if (got := status(t)) & (BIT12 | BIT13):
            raise Fail("bit 12 or 13 is set after halt in homing", "both clear", named(got))
