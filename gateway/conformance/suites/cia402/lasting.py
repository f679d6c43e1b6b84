"""CiA 402, between two states or modes: PDO and reset, NMT stop, continuation afterwards, limits in other modes (CiA 402-2)."""

from collections.abc import Iterator
from contextlib import contextmanager

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.canopen301.pdo import RX, mapping, offered_types
from gateway.conformance.suites.cia402.drive import (
    ABORT_OPTION,
    ACCELERATION,
    BIT12,
    BIT13,
    CONTROL,
    DISABLED,
    ENABLED,
    ERROR_CODE,
    FAULT,
    LIMIT_HIGH,
    LIMIT_LOW,
    MODE,
    ON,
    PP,
    PROFILE_SPEED,
    PV,
    QUICK,
    QUICK_OPTION,
    REACHED,
    READY,
    TARGET,
    TARGET_SPEED,
    at_standstill,
    brought_to,
    choose,
    control,
    moving,
    named,
    patience,
    plan,
    position,
    reaches,
    speed,
    state_of,
    status,
    stays,
    until,
)
from gateway.conformance.suites.cia402.faults import FAULTS, LOST, POWER, beat, cyclic, faulty, reset_by
from gateway.conformance.suites.cia402.modes import OFFSET, homing, runs, shown_mode, turning
from gateway.conformance.suites.cia402.positioning import MOVES, order, positioning
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.emcy import decode
from protocols.canopen.nmt import Command

PWR = Purposes[NodeTester]("CIA402_PWR", "drive", "CiA 402-2, power states", condition=("may_power",), preamble=POWER)
FLT = Purposes[NodeTester]("CIA402_FLT", "drive", "CiA 402-2, faults", condition=("may_power",), preamble=POWER)
MOD = Purposes[NodeTester]("CIA402_MOD", "drive", "CiA 402-2, modes of operation", condition=("may_power", "modes"), preamble=POWER)
POS = Purposes[NodeTester]("CIA402_POS", "drive", "CiA 402-2, profile position", condition=("pp", "may_move"), preamble=MOVES)
RUNS = (*POWER, "CIA402_VEL_BV_01")
VEL = Purposes[NodeTester]("CIA402_VEL", "drive", "CiA 402-2, profile velocity", condition=("pv", "may_move"), preamble=RUNS)
FOLLOWS = (*POWER, "CIA402_CSP_BV_01")
CYC = Purposes[NodeTester]("CIA402_CSP", "drive", "CiA 402-2, CSP", condition=("csp", "sync", "may_move"), preamble=FOLLOWS)
HOM = Purposes[NodeTester]("CIA402_HOM", "drive", "CiA 402-2, homing", condition=("hm", "may_move"), preamble=POWER)
ERROR_REGISTER, GENERIC = (0x1001, 0), 1
TOP_SPEED, SPEED_WINDOW = (0x607F, 0), (0x606D, 0)
ALL_AT_ONCE = 255
GONE = ms(100)  # for EMCY 0000h after the reset of a fault


# ---- power states
@PWR.case(
    "BV_16",
    "605Ah = 5: it stays in quick stop active; transition 16 leads back",
    "605Ah = 5: er bleibt in Quick Stop Active; Übergang 16 führt zurück",
    condition=("quick_option",),
)
def slow_stop_stays(t: NodeTester) -> None:
    with t.kept(QUICK_OPTION), brought_to(t, ENABLED):
        choose(t, QUICK_OPTION, 5)
        control(t, 0x02)
        reaches(t, QUICK, "quick stop, 605Ah = 5")
        stays(t, QUICK, "quick stop, 605Ah = 5", ms(500))
        control(t, 0x0F)
        reaches(t, ENABLED, "enable operation in quick stop active")


class Commanding:
    """RPDO 1 carries the controlword; all else in it stays as it is."""

    def __init__(self, t: NodeTester) -> None:
        self._t = t
        self._parts = mapping(t, 0x1600)
        self.identifier = t.number((RX, 1)) & cobid.ID_BITS
        if CONTROL not in [(part.index, part.sub) for part in self._parts]:
            raise NotApplicable("RPDO 1 does not carry the controlword")
        self._held = {part.word: 0 if part.index < 0x1000 else self._value((part.index, part.sub)) for part in self._parts}

    def _value(self, key: tuple[int, int]) -> int:
        try:
            return self._t.number(key)
        except Aborted:
            return 0  # written only

    def say(self, word: int) -> None:
        total = place = 0
        for part in self._parts:
            value = word if (part.index, part.sub) == CONTROL else self._held[part.word]
            total |= (value & ((1 << part.bits) - 1)) << place
            place += part.bits
        self._t.say(self.identifier, total.to_bytes((place + 7) // 8, "little"))


@PWR.case(
    "BV_17",
    "the controlword in an RPDO acts like the one by SDO",
    "das Controlword in einem RPDO wirkt wie das per SDO",
    condition=("rpdo", "rpdo_setup"),
)
def by_pdo(t: NodeTester) -> None:
    with brought_to(t, DISABLED), t.kept((RX, 2)):
        with t.given():
            commanding = Commanding(t)
            if not offered_types(t, RX, ALL_AT_ONCE):
                raise NotApplicable("RPDO 1 does not offer transmission type 255")
        with t.operational():
            for word, state in ((6, READY), (7, ON), (15, ENABLED), (7, ON), (0, DISABLED)):
                commanding.say(word)
                reaches(t, state, f"controlword {word:04X}h in RPDO 1")


@PWR.case(
    "BV_18",
    "reset node in operation enabled: afterwards it is without power",
    "Reset Node in Operation Enabled: danach ist er ohne Leistung",
    clause="CiA 301, 7.3.2.2.1",
    condition=("reset",),
)
def reset_at_work(t: NodeTester) -> None:
    with brought_to(t, ENABLED):
        t.reset()
        until(t, lambda: state_of(status(t)) != 0, "a state after boot-up", t.setup.boot)
        if state_of(got := status(t)) == FAULT:
            raise Warn("it is in fault after reset node", "switch on disabled", named(got))
        if state_of(got) != DISABLED:
            raise Fail(f"after reset node: {named(got)}", "switch on disabled (xx40h)", named(got))


# ---- faults
@FLT.case(
    "BV_08",
    "6007h = 1: NMT stop in operation enabled is a fault as well",
    "6007h = 1: auch NMT-Stop in Operation Enabled ist ein Fehler",
    clause="CiA 402-2, 6007h",
    condition=("abort_option",),
)
def stopped(t: NodeTester) -> None:
    with t.kept(ABORT_OPTION), brought_to(t, ENABLED):
        with t.given():
            choose(t, ABORT_OPTION, 1)
        t.command(Command.START)
        t.pause(ms(10))
        t.command(Command.STOP)
        t.pause(ms(500))
        t.command(Command.PRE_OPERATIONAL)
        t.pause(ms(10))
        until(t, lambda: state_of(status(t)) != 0x0F, "the end of the fault reaction", ms(3000))
        if state_of(got := status(t)) == ENABLED:
            raise Fail("it is still in operation enabled after NMT stop", "fault (xx08h)", named(got))
        if state_of(got) != FAULT:
            raise Warn("it is not in fault after NMT stop", "fault (xx08h)", named(got))


@FLT.case(
    "BV_09",
    "603Fh is the code of the emergency message",
    "603Fh ist der Code der Emergency-Nachricht",
    clause="CiA 402-2, 603Fh",
    condition=(*FAULTS, "emcy"),
    preamble=(*POWER, LOST),
)
def same_code(t: NodeTester) -> None:
    with faulty(t):
        codes = {decode(frame.data).code for frame in t.heard if frame.identifier == t.emcy and len(frame.data) == 8} - {0}
        if (got := t.number(ERROR_CODE)) not in codes:
            raise Fail(f"603Fh is {got:04X}h", " or ".join(f"{code:04X}h" for code in sorted(codes)) or "a code", f"{got:04X}h")


def _reported(t: NodeTester) -> list[int]:
    """Codes of the emergency messages of this case."""
    return [decode(frame.data).code for frame in t.heard if frame.identifier == t.emcy and len(frame.data) == 8]


@FLT.case(
    "BV_11",
    "after the reset 1001h shows no error, and EMCY 0000h comes",
    "nach dem Reset zeigt 1001h keinen Fehler, und EMCY 0000h kommt",
    clause="CiA 301, 7.2.7.1 and 7.5.2.2",
    condition=FAULTS,
    preamble=(*POWER, LOST, "CIA402_FLT_BV_02"),
)
def no_error_left(t: NodeTester) -> None:
    with t.given():
        before = t.number(ERROR_REGISTER)
    if before:
        raise NotApplicable(f"1001h is {before:02X}h without a fault")
    with faulty(t):
        with t.given():
            t.number(ERROR_REGISTER)
            reset_by(t, 0x80, "fault reset")
            beat(t)  # else it is lost again
        if (got := t.number(ERROR_REGISTER)) & GENERIC:
            raise Fail(f"1001h is {got:02X}h after the reset of a fault", "00h, as before it", f"{got:02X}h")
        if 0 not in _reported(t):
            t.pause(GONE)
        codes = _reported(t)
        if any(codes) and 0 not in codes:
            raise Fail("no error reset message after the reset of a fault, though 1001h shows no error", "EMCY 0000h", "nothing")


@FLT.case(
    "BI_03",
    "a fault reset with 008Fh ends in switch on disabled, and does not make ready",
    "ein Fehler-Reset mit 008Fh endet in Einschaltsperre und macht nicht bereit",
    condition=FAULTS,
    preamble=(*POWER, LOST, "CIA402_FLT_BV_02"),
)
def reset_only(t: NodeTester) -> None:
    with faulty(t):
        reset_by(t, 0x8F, "fault reset with 008Fh")
        stays(t, DISABLED, "fault reset with 008Fh", ms(200))


# ---- modes
@MOD.case(
    "BV_02",
    "6061h follows 6060h in operation enabled as well",
    "6061h folgt 6060h auch in Operation Enabled",
    condition=("pp", "pv", "may_move"),
    preamble=(*POWER, "CIA402_MOD_BV_01"),
)
def other_mode_at_work(t: NodeTester) -> None:
    with t.kept(TARGET_SPEED, TARGET), brought_to(t, ENABLED, PP):
        with t.given():
            t.download(TARGET_SPEED, 0, 4)
        for mode in (PV, PP):
            try:
                t.download(MODE, mode, 1)
            except Aborted as refused:
                raise NotApplicable("6060h cannot be changed in operation enabled") from refused
            if (got := shown_mode(t, mode)) != mode:
                raise Fail(f"6061h is {got} after 6060h = {mode} in operation enabled", str(mode), str(got))


@POS.case(
    "BO_01",
    "what was under way is not resumed by enabling",
    "was unterwegs war, läuft beim Freigeben nicht weiter",
)
def not_resumed(t: NodeTester) -> None:
    with positioning(t) as (start, way):
        order(t, start + 4 * way)
        with t.given():
            until(t, lambda: abs(position(t) - start) > way // 10, "motion")
        control(t, 0x07)
        with t.given():
            reaches(t, ON, "disable operation")
            until(t, lambda: at_standstill(t), "standstill", ms(3000))
        control(t, 0x0F)
        with t.given():
            reaches(t, ENABLED, "enable operation")
            held = position(t)
        t.pause(ms(300))
        if abs((got := position(t)) - held) > max(way // 10, 50):
            raise Fail(f"it moved on from {held} to {got} without a new set-point", "standstill", str(got))


@POS.case(
    "BO_02",
    "a set-point in switched on moves nothing, nor does enabling afterwards",
    "ein Sollwert ohne Freigabe bewegt nichts, auch das Freigeben danach nicht",
)
def without_power(t: NodeTester) -> None:
    way = plan(t)[1]
    with t.kept(TARGET), brought_to(t, ON, PP):
        start = position(t)
        t.download(TARGET, start + 4 * way, 4)
        for word, what in ((0x17, "bit 4 in switched on"), (0x07, "bit 4 in switched on"), (0x0F, "enabling without bit 4")):
            control(t, word)
            t.pause(ms(300))
            if abs((got := position(t)) - start) > max(way // 10, 50):
                raise Fail(f"it moved from {start} to {got} after {what}", "standstill", str(got))


@POS.case(
    "BV_08",
    "it is never faster than 607Fh",
    "er ist nie schneller als 607Fh",
    clause="CiA 402-2, 607Fh",
    condition=("top_speed", "velocity"),
)
def top_speed(t: NodeTester) -> None:
    chosen = plan(t)[0]
    with t.kept(TOP_SPEED), positioning(t) as (start, way):
        with t.given():
            t.download(TOP_SPEED, chosen // 2, 4)
            t.download(PROFILE_SPEED, chosen, 4)
        order(t, start + 4 * way)
        top, begin = 0, t.now()
        while not (status(t) & REACHED and at_standstill(t)) and t.now() - begin < 2 * patience(t):
            top = max(top, abs(speed(t)))
            t.pause(max(ms(1), (t.now() - begin) // 200))  # a slow drive is at its speed for longer
        if top > chosen * 6 // 10:
            raise Fail(f"606Ch was {top} with 607Fh = {chosen // 2}", f"at most {chosen // 2}", str(top))


# ---- profile velocity
@VEL.case("BV_04", "halt stops it, and its end continues", "Halt hält ihn an, sein Ende setzt fort", condition=("velocity",))
def halts(t: NodeTester) -> None:
    with moving(t) as chosen:
        control(t, 0x10F)
        until(t, lambda: at_standstill(t), "standstill after halt (bit 8)", ms(3000))
        reaches(t, ENABLED, "halt")
        control(t, 0x0F)
        until(t, lambda: abs(speed(t)) > chosen // 2, "motion after the end of halt", ms(3000))


@VEL.case("BV_05", "6064h counts in the direction of 606Ch", "6064h zählt in der Richtung von 606Ch", condition=("velocity",))
def same_direction(t: NodeTester) -> None:
    with turning(t) as chosen:
        for wanted in (chosen, -chosen):
            t.download(TARGET_SPEED, wanted, 4)
            with t.given():
                runs(t, wanted)
            before = position(t)
            t.pause(ms(30))
            moved = position(t) - before
            if moved * wanted <= 0 and abs(moved) < 1 << 30:  # beyond that 6064h has wrapped
                raise Fail(f"606Ch is {wanted}, 6064h changed by {moved}", "both of one sign", str(moved))
        t.download(TARGET_SPEED, 0, 4)


@VEL.case(
    "BV_06",
    "bit 10 is clear until 60FFh is reached",
    "Bit 10 ist gelöscht, bis 60FFh erreicht ist",
    condition=("velocity",),
    preamble=(*RUNS, "CIA402_VEL_BV_02"),
)
def not_reached(t: NodeTester) -> None:
    with t.kept(ACCELERATION), turning(t) as chosen:
        with t.given():
            t.download(ACCELERATION, max(chosen, 1), 4)  # a second
            t.download(TARGET_SPEED, chosen, 4)
            until(t, lambda: abs(speed(t)) > chosen // 10, "motion")
        got, now = status(t), abs(speed(t))
        window = t.number(SPEED_WINDOW) if t.exists(SPEED_WINDOW) else 0
        if got & REACHED and now < min(chosen // 2, chosen - window):
            raise Fail(f"bit 10 is set at {now} of {chosen}", "bit 10 clear", named(got))
        t.download(TARGET_SPEED, 0, 4)


# ---- homing and cyclic position
@HOM.case(
    "BV_03",
    "homing to the index sets 6064h by 607Ch, and is not attained without it",
    "Referenzieren auf den Index setzt 6064h nach 607Ch und ist sonst nicht erreicht",
    condition=("homing_moves",),
    preamble=(*POWER, "CIA402_HOM_BV_01", "CIA402_HOM_BV_02"),
)
def index_sets(t: NodeTester) -> None:
    with t.kept(OFFSET), homing(t, 34):
        with t.given():
            way = plan(t)[1]
            wanted = position(t) + 40 * way
            t.download(OFFSET, wanted, 4)
        control(t, 0x1F)
        until(t, lambda: status(t) & (BIT12 | BIT13) == BIT12 and bool(status(t) & REACHED), "homing to the index attained")
        if abs((got := position(t)) - wanted) > 20 * way:
            raise Fail(f"homing is attained, but 6064h is {got}", f"about 607Ch = {wanted}", str(got))


@contextmanager
def between_limits(t: NodeTester) -> Iterator[tuple[int, int]]:
    """Cyclic, software limits a way to both sides; where it is, and the way."""
    with t.kept(LIMIT_LOW, LIMIT_HIGH):
        with t.given():
            start, way = position(t), max(plan(t)[1] // 4, 100)
            t.download(LIMIT_LOW, start - way, 4)
            t.download(LIMIT_HIGH, start + way, 4)
        with cyclic(t):
            yield start, way


@CYC.case(
    "BI_01",
    "set values beyond 607Dh are not followed",
    "Sollwerten jenseits 607Dh folgt er nicht",
    clause="CiA 402-2, 607Dh",
    condition=("limits",),
)
def limited(t: NodeTester) -> None:
    with between_limits(t) as (start, way):
        for turn in range(1, 41):
            t.download(TARGET, start + 2 * way * turn // 40, 4)
            t.on_grid()
        t.on_grid(10)
        if (got := position(t)) > start + way + max(way // 10, 50):
            raise Fail(f"it passed the limit and reached {got}", f"at most {start + way}", str(got))
