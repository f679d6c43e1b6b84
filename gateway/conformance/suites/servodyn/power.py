"""SERVODYN: power, control and brake; conditions that must not switch it on (AX-080)."""

from gateway.conformance.suites.servodyn.booster import BoosterTester, words
from gateway.conformance.suites.servodyn.cycle import BASIC, REST
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail
from protocols.base.machine import ms

ON, CONTROL, CLOSES, OFF = (f"SERVO_PWR_BV_0{number}" for number in range(1, 5))
PWR = Purposes[BoosterTester]("SERVO_PWR", "booster", "AX-080", condition=("may_move",), preamble=(BASIC, REST))
SUP = Purposes[BoosterTester]("SERVO_SUP", "booster", "AX-080", condition=("power", "may_move"), preamble=(BASIC, REST, ON))
LIMIT = Particulars(limits="within 8 s")


@PWR.case("BV_01", "drive on switches power on, not control", "Antrieb Ein schaltet die Leistung ein, nicht die Regelung", beside=LIMIT)
def power_on(t: BoosterTester) -> None:
    t.rest()
    t.give(drive_on=True)
    begin = t.now()
    found = t.until(lambda actual: actual.power_on, "power on")
    t.timed("drive on to power on", t.now() - begin, None, ms(8000))
    t.stays(lambda actual: actual.power_on and not actual.enabled and not actual.brake_open, "power without control")
    if not found.ready:
        raise Fail("ready drops when power is switched on", "ready and power on", words(found))


@PWR.case("BV_02", "enable: control, brake open", "Freigabe: Regelung, Bremse offen", preamble=(BASIC, REST, ON), beside=LIMIT)
def control(t: BoosterTester) -> None:
    with t.powered():
        t.give(enable=True)
        begin = t.now()
        found = t.until(lambda actual: actual.enabled, "enabled")
        t.timed("enable to enabled", t.now() - begin, None, ms(8000))
        if not found.power_on:
            raise Fail(f"power is not on when control begins: {words(found)}", "enabled and power on", words(found))
        t.stays(lambda actual: actual.enabled and actual.brake_open and actual.power_on, "enabled with the brake open")


@PWR.case(
    "BV_03",
    "when enable drops, the brake closes and power stays on",
    "fällt die Freigabe weg, schließt die Bremse, und die Leistung bleibt ein",
    preamble=(BASIC, REST, ON, CONTROL),
)
def control_gone(t: BoosterTester) -> None:
    with t.powered(True):
        t.give(enable=False)
        t.until(lambda actual: not actual.enabled, "not enabled")
        t.until(lambda actual: not actual.brake_open, "brake closed")
        t.stays(lambda actual: actual.power_on and not actual.enabled and not actual.fault, "power without control")


@PWR.case("BV_04", "when drive on drops, power goes off", "fällt Antrieb Ein weg, geht die Leistung aus", preamble=(BASIC, REST, ON))
def power_gone(t: BoosterTester) -> None:
    with t.powered():
        t.give(drive_on=False)
        t.until(lambda actual: not actual.power_on, "no power", ms(2000))
        t.stays(lambda actual: actual.ready and not actual.power_on, "ready without power")


@PWR.case(
    "BV_05",
    "when drive on drops under control, the booster stops, closes the brake, then switches power off",
    "fällt Antrieb Ein unter Regelung weg, hält er an, schließt die Bremse und schaltet die Leistung aus",
    preamble=(BASIC, REST, ON, CONTROL, CLOSES),
)
def power_gone_enabled(t: BoosterTester) -> None:
    with t.powered(True):
        t.give(drive_on=False)
        found = t.until(lambda actual: not actual.power_on, "no power", ms(5000))
        if found.brake_open or found.enabled or found.fault:
            raise Fail(f"after drive on dropped: {words(found)}", "no power, brake closed, no fault", words(found))


@PWR.case("BI_01", "enable without drive on does nothing", "Freigabe ohne Antrieb Ein bewirkt nichts", preamble=(BASIC, REST, CLOSES))
def no_drive_on(t: BoosterTester) -> None:
    t.rest()
    t.give(enable=True)
    t.stays(lambda actual: not actual.power_on and not actual.enabled and not actual.brake_open, "no power without drive on", ms(1500))


@PWR.case(
    "BI_02",
    "the brake request alone does not open the brake without power",
    "die Bremsanforderung allein öffnet die Bremse ohne Leistung nicht",
    preamble=(BASIC, REST, CLOSES),
)
def brake_request(t: BoosterTester) -> None:
    t.rest()
    t.give(brake_open=True)
    t.stays(lambda actual: not actual.brake_open, "brake closed without power", ms(1000))


@PWR.case("RC_01", "five times on and off", "fünfmal ein und aus", preamble=(BASIC, REST, ON, CONTROL, OFF))
def five_times(t: BoosterTester) -> None:
    for _ in range(5):
        with t.powered(True):
            t.turn(5)


@SUP.case(
    "RC_01",
    "after a power failure it is without power, though drive on is still set",
    "nach Netzausfall ist er ohne Leistung, obwohl Antrieb Ein ansteht",
)
def not_by_itself(t: BoosterTester) -> None:
    with t.powered():
        t.power.turn(False)
        t.pause(ms(1000))
        for _ in range(5):
            t.sync()
            t.drain()
            heard = t.hear((t.actual_id,), t.limit)
            if heard is not None:
                raise Fail("it sends without supply", "nothing", words(t.read(heard)))
        t.power.turn(True)
        until = t.now() + max(t.setup.boot, t.power.back)
        t.sync()
        while t.hear((t.actual_id,), t.limit) is None:
            if t.now() > until:
                raise Fail("no actual value after power-on", "an actual value", "nothing")
            t.say_set()
            t.sync()
        t.stays(lambda actual: not actual.power_on, "no power after a power failure", ms(3000))
