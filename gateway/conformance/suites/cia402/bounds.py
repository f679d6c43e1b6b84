"""CiA 402, bounds on both sides and in each mode: lower limits, 607Fh in velocity, a lag that is over in time (CiA 402-2)."""

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.cia402.drive import (
    ENABLED,
    LIMIT_HIGH,
    LIMIT_LOW,
    TARGET,
    TARGET_SPEED,
    WINDOW,
    WINDOW_TIME,
    control,
    named,
    plan,
    position,
    speed,
    state_of,
    status,
)
from gateway.conformance.suites.cia402.faults import POWER, cyclic
from gateway.conformance.suites.cia402.lasting import FOLLOWS, RUNS, TOP_SPEED, between_limits
from gateway.conformance.suites.cia402.modes import turning
from gateway.conformance.suites.cia402.positioning import MOVES, positioning
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail
from protocols.base.machine import ms

POS = Purposes[NodeTester]("CIA402_POS", "drive", "CiA 402-2, 607Dh", condition=("pp", "may_move", "limits"), preamble=MOVES)
VEL = Purposes[NodeTester]("CIA402_VEL", "drive", "CiA 402-2, 607Fh", condition=("pv", "may_move", "top_speed", "velocity"), preamble=RUNS)
CYC = Purposes[NodeTester]("CIA402_CSP", "drive", "CiA 402-2, 607Dh", condition=("csp", "sync", "may_move", "limits"), preamble=FOLLOWS)
FLT = Purposes[NodeTester](
    "CIA402_FLT", "drive", "CiA 402-2, 6066h", condition=("csp", "following", "may_move"), preamble=(*POWER, "CIA402_FLT_BV_07")
)
LONG_LAG = 1000  # 6066h in ms, ten times as long as the lag of the case


@POS.case("BI_03", "a target below 607Dh:01 is not passed", "ein Ziel unter 607Dh:01 wird nicht überfahren")
def lower_limit(t: NodeTester) -> None:
    with t.kept(LIMIT_LOW, LIMIT_HIGH), positioning(t) as (start, way):
        with t.given():
            t.download(LIMIT_LOW, start - way, 4)
            t.download(LIMIT_HIGH, start + way, 4)
        t.download(TARGET, start - 3 * way, 4)
        control(t, 0x1F)
        lowest, begin = start, t.now()
        while t.now() - begin < ms(1500):
            lowest = min(lowest, position(t))
            t.pause(ms(5))
        control(t, 0x0F)
        if lowest < start - way - max(way // 20, 50):
            raise Fail(f"it passed the limit and reached {lowest}", f"at least {start - way}", str(lowest))


@CYC.case("BI_02", "set values below 607Dh:01 are not followed", "Sollwerten unter 607Dh:01 folgt er nicht")
def lower_limited(t: NodeTester) -> None:
    with between_limits(t) as (start, way):
        for turn in range(1, 41):
            t.download(TARGET, start - 2 * way * turn // 40, 4)
            t.on_grid()
        t.on_grid(10)
        if (got := position(t)) < start - way - max(way // 10, 50):
            raise Fail(f"it passed the limit and reached {got}", f"at least {start - way}", str(got))


@VEL.case(
    "BV_07",
    "607Fh bounds profile velocity in both directions",
    "607Fh begrenzt Profile Velocity in beiden Richtungen",
)
def velocity_bounded(t: NodeTester) -> None:
    with t.kept(TOP_SPEED), turning(t) as chosen:
        with t.given():
            t.download(TOP_SPEED, chosen // 2, 4)
        for wanted in (chosen, -chosen):
            t.download(TARGET_SPEED, wanted, 4)
            top, begin = 0, t.now()
            while t.now() - begin < ms(1000):
                top = max(top, abs(speed(t)))
                t.pause(ms(5))
            if top > chosen * 6 // 10:
                raise Fail(f"606Ch was {top} with 607Fh = {chosen // 2} and 60FFh = {wanted}", f"at most {chosen // 2}", str(top))
        t.download(TARGET_SPEED, 0, 4)


@FLT.case(
    "BI_04",
    "a lag beyond 6065h that is over before 6066h is not a fault",
    "ein Schleppabstand über 6065h, der vor 6066h vorbei ist, ist kein Fehler",
)
def short_lag(t: NodeTester) -> None:
    way = plan(t)[1]
    with t.kept(WINDOW, WINDOW_TIME, TARGET), cyclic(t):
        with t.given():
            t.download(WINDOW, max(way // 20, 1), 4)
            t.download(WINDOW_TIME, LONG_LAG, 2)
        t.download(TARGET, position(t) + 4 * way, 4)
        begin = t.now()
        while t.now() - begin < ms(LONG_LAG // 10):
            t.on_grid()
            if state_of(got := status(t)) != ENABLED:
                took = (t.now() - begin) // 1_000_000
                raise Fail(f"fault {took} ms after the jump, 6066h = {LONG_LAG} ms", "operation enabled", named(got))
            t.download(TARGET, position(t), 4)
