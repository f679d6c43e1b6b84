"""SERVODYN: set positions are followed, latched and held; parameters over the bus (AX-083, AX-266)."""

from gateway.conformance.suites.servodyn.booster import BoosterTester, answer_words, words
from gateway.conformance.suites.servodyn.cycle import BASIC, REST
from gateway.conformance.suites.servodyn.power import CONTROL, ON
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.servodyn.parameters import Status

NEAR = 40  # increments at rest
WIDE, STRIDE = 34_000, 40  # increments: beyond 16 bits with a sign, and of one cycle
EACH = 50  # SYNCs
FOLLOWS, BACK = "SERVO_MOV_BV_01", "SERVO_MOV_BV_02"
MOV = Purposes[BoosterTester]("SERVO_MOV", "booster", "AX-083", condition=("may_move",), preamble=(BASIC, REST, ON, CONTROL))
PAR = Purposes[BoosterTester]("SERVO_PAR", "booster", "AX-266", condition=("parameters", "may_store"), preamble=(BASIC, REST))
POSITION_GAIN, USUAL, UNKNOWN_NUMBER = 7, 80.0, 56


def arrived(t: BoosterTester, wanted: int, what: str) -> None:
    found = t.turn()
    if found.fault:
        raise Fail(f"{what}: fault code {found.fault_code}", f"position {wanted}", f"fault code {found.fault_code}")
    if abs(found.position_inc - wanted) > NEAR:
        raise Fail(f"{what}: position {found.position_inc}", f"{wanted}, within {NEAR}", str(found.position_inc))


@MOV.case("BV_01", "it follows its set position, forwards", "er folgt dem Lagesollwert vorwärts")
def forwards(t: BoosterTester) -> None:
    with t.powered(True):
        start = t.value.position_inc
        t.move(t.setup.way)
        arrived(t, start + t.setup.way, "forwards")


@MOV.case("BV_02", "and backwards", "und rückwärts", preamble=(BASIC, REST, ON, CONTROL, FOLLOWS))
def backwards(t: BoosterTester) -> None:
    with t.powered(True):
        start = t.value.position_inc
        t.move(-t.setup.way)
        arrived(t, start - t.setup.way, "backwards")


@MOV.case(
    "BV_03",
    "at constant speed the lag stays the same",
    "bei konstanter Geschwindigkeit bleibt der Schleppabstand gleich",
    preamble=(BASIC, REST, ON, CONTROL, FOLLOWS),
)
def lag(t: BoosterTester) -> None:
    step = max(t.setup.way // 200, 2)
    with t.powered(True):
        found = []
        for _ in range(200):
            wanted = t.value.position_inc
            found.append(wanted - t.turn().position_inc)
            t.give(position_inc=wanted + step)
        t.turn(100)
        late, early = found[190:], found[100:110]
        drift = abs(sum(late) / len(late) - sum(early) / len(early))
        if drift > 4 * step + NEAR:
            raise Fail(f"the lag changes by {drift:.0f} increments", f"at most {4 * step + NEAR}", f"lag {early[0]}, later {late[-1]}")
        t.move(-200 * step)


@MOV.case(
    "BV_04",
    "a SYNC without a new set value holds the last position",
    "ein SYNC ohne neuen Sollwert hält die letzte Lage",
    preamble=(BASIC, REST, ON, CONTROL, FOLLOWS),
)
def holds(t: BoosterTester) -> None:
    with t.powered(True):
        start = t.value.position_inc
        t.move(t.setup.way)
        for _ in range(10):
            t.turn(1, with_set=False)
            for _ in range(3):
                if not (found := t.turn()).enabled:
                    raise Fail("a missing set value ends control", "enabled", words(found))
        arrived(t, start + t.setup.way, "with set values missing")
        t.move(-t.setup.way)


@MOV.case("BV_05", "without motion it stays where it is under control", "ohne Sollwertänderung bleibt er unter Regelung stehen")
def still(t: BoosterTester) -> None:
    with t.powered(True):
        wanted = t.value.position_inc
        for _ in range(100):
            found = t.turn()
            if abs(found.position_inc - wanted) > 2 * NEAR:
                raise Fail(f"position {found.position_inc} at rest", f"{wanted}, within {2 * NEAR}", str(found.position_inc))


@MOV.case(
    "BV_13",
    "under control each SYNC brings one actual value",
    "unter Regelung bringt jeder SYNC einen Istwert",
    clause="AX-001",
)
def one_each(t: BoosterTester) -> None:
    with t.powered(True):
        t.turn()
        t.pause(t.setup.cycle // 2)
        begin = len(t.heard)
        t.turn(EACH)
        t.pause(t.setup.cycle // 2)
        count = sum(frame.identifier == t.actual_id for frame in t.heard[begin:])
        if count != EACH:
            raise Fail(f"{count} actual values after {EACH} SYNCs under control", str(EACH), str(count))


@MOV.case(
    "BV_06",
    "control that begins changes neither its position nor ready",
    "beginnende Regelung ändert weder die Lage noch Bereit",
    preamble=(BASIC, REST, ON, CONTROL, FOLLOWS),
)
def begins(t: BoosterTester) -> None:
    with t.powered(True):
        t.move(t.setup.way)
        with t.given():
            t.give(enable=False)
            t.until(lambda actual: not actual.enabled, "not enabled")
            before = t.turn(10).position_inc
            t.give(enable=True, position_inc=before)
            t.until(lambda actual: actual.enabled, "enabled")
        found = t.turn()
        t.move(-t.setup.way)
        if abs(found.position_inc - before) > NEAR:
            raise Fail(f"position {found.position_inc} when control begins", f"{before}, within {NEAR}", str(found.position_inc))
        if not found.ready:
            raise Fail("ready drops when control begins", "ready and enabled", words(found))


@MOV.case(
    "BV_07",
    "its position passes zero: it has a sign and more than 16 bits",
    "die Lage geht durch null: sie hat ein Vorzeichen und mehr als 16 Bit",
    preamble=(BASIC, REST, ON, CONTROL, FOLLOWS, BACK),
)
def through_zero(t: BoosterTester) -> None:
    with t.powered(True):
        start = t.value.position_inc
        if abs(start) > t.setup.way:
            raise NotApplicable(f"it is at {start}, farther from zero than its way of {t.setup.way}")
        reach = WIDE if t.wire.simulated and not t.setup.way_stated else t.setup.way
        for target in (reach, -reach, start):
            way = target - t.value.position_inc
            t.move(way, max(abs(way) // STRIDE, 200))
            arrived(t, target, f"set position {target}")
        if reach < 1 << 15:
            t.remark(f"positions beyond 16 bits were not reached: the way is {reach}")


@MOV.case(
    "BI_01",
    "set positions without enable do not move it",
    "Lagesollwerte ohne Freigabe bewegen ihn nicht",
    preamble=(BASIC, REST, ON),
)
def not_enabled(t: BoosterTester) -> None:
    with t.powered():
        before = t.turn().position_inc
        for at in range(50):
            t.sync()
            found = t.answered()
            t.give(position_inc=before + 20 * at)
            t.say_set()
        if abs(found.position_inc - before) > NEAR:
            raise Fail(f"it moves to {found.position_inc} without enable", f"{before}, within {NEAR}", str(found.position_inc))


@PAR.case("BV_01", "a parameter is taken and comes back in the answer", "ein Parameter wird genommen und kommt in der Antwort zurück")
def taken(t: BoosterTester) -> None:
    for value in (USUAL / 2, USUAL):
        answer = t.ask(POSITION_GAIN, value)
        if answer.status is not Status.TAKEN or answer.value != value:
            raise Fail(
                f"parameter {POSITION_GAIN} = {value}: {answer.status.name}, {answer.value}", f"TAKEN, {value}", answer_words(answer)
            )


@PAR.case("BI_01", "an unknown parameter has status 1", "ein unbekannter Parameter hat Status 1")
def unknown(t: BoosterTester) -> None:
    answer = t.ask(UNKNOWN_NUMBER, 0)
    if answer.status is not Status.UNKNOWN:
        raise Fail(f"parameter {UNKNOWN_NUMBER}: {answer.status.name}", "UNKNOWN (1)", answer_words(answer))


@PAR.case(
    "BI_02",
    "a value out of range has status 2 and the old value stays",
    "ein Wert außerhalb hat Status 2, der alte bleibt",
    preamble=(BASIC, REST, "SERVO_PAR_BV_01"),
)
def out_of_range(t: BoosterTester) -> None:
    with t.given():
        t.ask(POSITION_GAIN, USUAL)
    answer = t.ask(POSITION_GAIN, 1e30)
    if answer.status is not Status.RANGE or answer.value != USUAL:
        raise Fail(f"parameter {POSITION_GAIN} = 1e30: {answer.status.name}, {answer.value}", f"RANGE (2), {USUAL}", answer_words(answer))


@PAR.case(
    "BO_01",
    "with power on a parameter has status 3 and the old value stays",
    "mit Leistung hat ein Parameter Status 3, der alte Wert bleibt",
    condition=("may_move",),
    preamble=(BASIC, REST, ON, "SERVO_PAR_BV_01"),
)
def with_power(t: BoosterTester) -> None:
    with t.given():
        t.ask(POSITION_GAIN, USUAL)
    with t.powered():
        t.turn()
        answer = t.ask(POSITION_GAIN, USUAL / 2)
        t.say_set()
        if answer.status is not Status.DRIVES_ON or answer.value != USUAL:
            raise Fail(f"with power on: {answer.status.name}, {answer.value}", f"DRIVES_ON (3), {USUAL}", answer_words(answer))
