"""SERVODYN: SYNC and actual values, the bits at rest, the form of a set value (AX-001)."""

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.tester import shown
from gateway.conformance.suites.servodyn.booster import BoosterTester, words
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail
from protocols.base.machine import ms
from protocols.servodyn.parameters import answer_id

BASIC, REST = "SERVO_CYC_BV_01", "SERVO_CYC_BV_04"
CYC = Purposes[BoosterTester]("SERVO_CYC", "booster", "AX-001", preamble=(BASIC,))
MANY = 200
FEW = 3  # of these may be missing here: CYC_ST_01 judges single ones


@CYC.case("BV_01", "a SYNC is answered with one actual value of 8 bytes", "auf einen SYNC folgt ein Istwert von 8 Byte", preamble=())
def answers(t: BoosterTester) -> None:
    t.sync()
    start = t.asked_at
    frame = t.hear((t.actual_id,), t.setup.cycle)
    if frame is None:
        raise Fail("no actual value after SYNC", f"8 bytes on {t.actual_id:03X}h", "nothing")
    if len(frame.data) != 8:
        raise Fail(f"an actual value of {len(frame.data)} bytes", "8 bytes", hexed(frame.data))
    t.read(frame)
    t.timed("SYNC to actual value", t.answered_at - start, None, t.limit)
    again = t.hear((t.actual_id,), t.setup.cycle // 2)
    if again is not None:
        raise Fail("a second actual value for one SYNC", "one actual value", shown(again))


@CYC.case(
    "TI_01",
    f"{MANY} SYNCs bring {MANY} actual values, each within its cycle",
    f"{MANY} SYNC bringen {MANY} Istwerte, jeder in seinem Zyklus",
    beside=Particulars(limits="within three quarters of P5"),
)
def many(t: BoosterTester) -> None:
    longest, before = 0, t.missing
    for _ in range(MANY):
        t.turn()
        longest = max(longest, t.answered_after)
    if (lost := t.missing - before) > FEW:
        raise Fail(f"{lost} of {MANY} SYNCs without an actual value", "one actual value after each SYNC", "nothing")
    t.timed("SYNC to actual value, the longest", longest, None, t.limit)


@CYC.case("BO_01", "without SYNC it sends nothing", "ohne SYNC sendet er nichts")
def unasked(t: BoosterTester) -> None:
    t.turn(5)
    t.pause(t.setup.cycle)
    t.drain()
    t.silence(t.actual_id, 20 * t.setup.cycle + ms(100), "without SYNC and power")


@CYC.case("BO_02", "a set value alone is not answered", "ein Sollwert allein wird nicht beantwortet")
def set_alone(t: BoosterTester) -> None:
    t.turn(2)
    t.drain()
    t.say_set()
    t.silence(t.actual_id, t.setup.cycle // 2, "a set value without SYNC")


@CYC.case(
    "BV_04",
    "at rest: ready, no power, not enabled, no fault, brake closed",
    "in Ruhe: bereit, ohne Leistung, nicht freigegeben, kein Fehler, Bremse zu",
)
def at_rest(t: BoosterTester) -> None:
    t.rest()
    found = t.turn(3)
    if not found.ready or found.power_on or found.enabled or found.fault or found.brake_open or found.fault_code:
        raise Fail(f"at rest it reports {words(found)}", "ready alone of these bits, fault code 0", words(found))


@CYC.case("BV_05", "the position stands still at rest", "die Position steht in Ruhe", preamble=(BASIC, REST))
def constant_at_rest(t: BoosterTester) -> None:
    first = t.turn(3).position_inc
    for _ in range(50):
        found = t.turn()
        if abs(found.position_inc - first) > 16:
            raise Fail(f"position {found.position_inc} at rest, {first} before", f"{first}, within 16", str(found.position_inc))


@CYC.case("BI_01", "a set value of seven bytes is not taken", "ein Sollwert von sieben Byte wird nicht genommen", preamble=(BASIC, REST))
def short(t: BoosterTester) -> None:
    t.rest()
    frame = t.setup.codec.encode_set(t.setup.module, t.value._replace(drive_on=True))
    for _ in range(60):
        t.sync()
        found = t.answered()
        if found.power_on or found.fault:
            raise Fail("a set value of seven bytes is accepted", "no power, no fault", words(found))
        t.say_on(frame.identifier, frame.data[:7])


@CYC.case("BI_02", "a set value of another module is not taken", "ein fremder Sollwert wird nicht genommen", preamble=(BASIC, REST))
def foreign(t: BoosterTester) -> None:
    others = [axis for axis in t.setup.codec.axes if axis != t.setup.module]
    t.rest()
    for _ in range(60):
        t.sync()
        found = t.answered()
        if found.power_on or found.fault:
            raise Fail("a set value of another module is accepted", "no power, no fault", words(found))
        t.say_set()
        for axis in others[:1]:
            frame = t.setup.codec.encode_set(axis, t.value._replace(drive_on=True))
            t.say_on(frame.identifier, frame.data)


@CYC.case("BV_06", "it sends on its own identifiers only", "er sendet nur auf seinen eigenen Identifiern")
def identifiers(t: BoosterTester) -> None:
    t.turn(50)
    own = {t.actual_id, answer_id(t.setup.module)}
    others = {t.setup.codec.actual_id(axis) for axis in t.setup.codec.axes} | {answer_id(axis) for axis in range(1, 7)}
    strange = [frame for frame in t.heard if frame.identifier not in own | others]
    if strange:
        raise Fail(
            "a frame on a strange identifier", f"identifier {t.actual_id:03X}h or {answer_id(t.setup.module):03X}h", shown(strange[0])
        )


@CYC.case("ST_01", "2000 cycles; in the whole run no actual value is missing", "2000 Zyklen; im ganzen Lauf fehlt kein Istwert")
def long_run(t: BoosterTester) -> None:
    t.turn(2000)
    if t.missing:
        raise Fail(f"{t.missing} of {t.syncs} SYNCs without an actual value", "one actual value after each SYNC", "nothing")
    t.counted = True
