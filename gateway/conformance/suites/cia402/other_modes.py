"""CiA 402, quick stop and option codes in profile position and homing, the statusword in a TPDO (CiA 402-2)."""

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.canopen301.pdo import TX, mapping, transmission
from gateway.conformance.suites.cia402.drive import (
    BIT12,
    DECELERATION,
    DISABLE_OPTION,
    DISABLED,
    ENABLED,
    NAMES,
    ON,
    QUICK_DECELERATION,
    QUICK_OPTION,
    READY,
    STATUS,
    at_standstill,
    brought_to,
    choose,
    control,
    named,
    patience,
    plan,
    reaches,
    speed,
    state_of,
    status,
    until,
)
from gateway.conformance.suites.cia402.faults import POWER, RAMPED, ramp
from gateway.conformance.suites.cia402.modes import INDEX, homing
from gateway.conformance.suites.cia402.positioning import MOVES, order, positioning
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import ms
from protocols.canopen.dictionary import Key

PWR = Purposes[NodeTester]("CIA402_PWR", "drive", "CiA 402-2, 6041h", condition=("may_power", "tpdo", "tpdo_setup", "sync"), preamble=POWER)
OPT = Purposes[NodeTester](
    "CIA402_OPT", "drive", "CiA 402-2, option codes", condition=("pp", "may_move", "velocity"), preamble=(*MOVES, "CIA402_PWR_BV_05")
)
HOM = Purposes[NodeTester](
    "CIA402_HOM", "drive", "CiA 402-2, homing", condition=("hm", "may_move", "homing_moves"), preamble=(*POWER, "CIA402_HOM_BV_01")
)


@PWR.case(
    "BV_19",
    "the statusword in a TPDO shows each state, as the one by SDO does",
    "das Statusword in einem TPDO zeigt jeden Zustand wie das per SDO",
)
def in_a_pdo(t: NodeTester) -> None:
    with brought_to(t, DISABLED), transmission(t, 1) as identifier:
        place = 0
        for part in mapping(t, 0x1A00):
            if (part.index, part.sub) == STATUS:
                break
            place += part.bits
        else:
            raise NotApplicable(f"TPDO 1 ({TX:04X}h) does not carry the statusword")
        for word, state in ((0, DISABLED), (6, READY), (7, ON), (15, ENABLED), (0, DISABLED)):
            with t.given():
                control(t, word)
                reaches(t, state, f"controlword {word:04X}h")
            t.drain()
            t.sync()
            frame = t.hear((identifier,), t.setup.wait)
            shown = int.from_bytes(frame.data, "little") >> place & 0xFFFF if frame is not None else 0
            if frame is None or state_of(shown) != state:
                got = named(shown) if frame is not None else "nothing"
                raise Fail(f"TPDO 1 shows the statusword {got}", f"{NAMES[state]} (xx{state:02X}h)", got)


def _stops(number: int, key: Key, option: int, word: int, rate: Key, end: int, item: str, words: tuple[str, str]) -> None:
    @OPT.case(
        f"BV_{number}",
        f"{key[0]:04X}h = {option} counts in profile position as well: {words[0]} along {rate[0]:04X}h",
        f"{key[0]:04X}h = {option} gilt auch in Profile Position: {words[1]} an der Rampe {rate[0]:04X}h",
        condition=(item,),
        beside=RAMPED,
    )
    def body(t: NodeTester) -> None:
        chosen = plan(t)[0]
        with t.kept(key, rate), positioning(t) as (start, way):
            with t.given():
                choose(t, key, option)
            order(t, start + 4 * way)
            begin = t.now()
            while speed(t) < chosen * 95 // 100:
                if t.now() - begin > patience(t) or (t.now() - begin > ms(100) and at_standstill(t)):
                    raise NotApplicable(f"606Ch does not reach {chosen * 95 // 100} within four times the distance")
                t.pause(ms(1))
            with t.given():
                t.download(rate, max(4 * chosen, 1), 4)  # a quarter of a second, and an eighth of its way
            control(t, word)
            ramp(t, chosen, rate, f"{words[0]}, {key[0]:04X}h = {option}")
            reaches(t, end, words[0])


_stops(15, QUICK_OPTION, 2, 0x02, QUICK_DECELERATION, DISABLED, "quick_option", ("quick stop", "Quick Stop"))
_stops(16, DISABLE_OPTION, 1, 0x07, DECELERATION, ON, "disable_option", ("disable operation", "Disable Operation"))


@HOM.case(
    "BO_04",
    "quick stop ends homing, without bit 12",
    "Quick Stop beendet das Referenzieren, ohne Bit 12",
    preamble=(*POWER, "CIA402_HOM_BV_01", "CIA402_PWR_BV_13"),
)
def stopped(t: NodeTester) -> None:
    with homing(t, INDEX):
        control(t, 0x1F)
        t.pause(ms(20))
        if status(t) & BIT12 and at_standstill(t):
            raise NotApplicable("homing was over before quick stop")
        control(t, 0x02)
        until(t, lambda: state_of(status(t)) != ENABLED and at_standstill(t), "quick stop in homing", ms(3000))
