"""CiA 402, faults: the master is lost, the reset of a fault, following error, option codes (CiA 402-2)."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.can.tester import shown
from gateway.conformance.suites.cia402.drive import (
    ABORT_OPTION,
    CSP,
    DECELERATION,
    DISABLE_OPTION,
    DISABLED,
    ENABLED,
    ERROR_CODE,
    FAULT,
    FAULT_OPTION,
    HALT_OPTION,
    ON,
    QUICK,
    QUICK_DECELERATION,
    QUICK_OPTION,
    READY,
    SHUTDOWN_OPTION,
    TARGET,
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
    state_of,
    status,
    stays,
    stop_time,
    there,
)
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive
from protocols.base.machine import Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import Key
from protocols.canopen.emcy import decode
from protocols.canopen.nmt import State

BASIC, ENABLE = "CIA402_PWR_BV_01", "CIA402_PWR_BV_04"
POWER = (BASIC, "CIA402_PWR_BV_02", "CIA402_PWR_BV_03", ENABLE)
LOST = "CIA402_FLT_BV_01"
FLT = Purposes[NodeTester]("CIA402_FLT", "drive", "CiA 402-2, faults", condition=("may_power",), preamble=POWER)
WATCHES = ("consumer", "abort_option")
FAULTS = ("fault_cause",)  # the tester can bring the drive into fault: by a lost master, or by a following error
MASTER, TIME_MS = 126, 100
CONSUMER = (0x1016, 1)
PERIOD, MILLI = ((0x60C2, 1), (0x60C2, 2)), -3


def watched_ms(t: NodeTester) -> int:
    """Consumer heartbeat time; the drive is looked at by SDO between two heartbeats, however slow it answers."""
    return max(TIME_MS, 6 * math.ceil(t.setup.took / 1e6))


@contextmanager
def supervised(t: NodeTester, option: int) -> Iterator[None]:
    """6007h = option, node 126 is watched and its heartbeat was received."""
    with t.kept(ABORT_OPTION, CONSUMER):
        with t.given():
            choose(t, ABORT_OPTION, option)
            t.download(CONSUMER, MASTER << 16 | watched_ms(t), 4)
            beat(t)
        try:
            yield
        finally:
            with suppress(Ended):
                beat(t)  # a device whose master never came back may keep this error and report no later loss of it
                t.download(CONSUMER, 0, 4)


def beat(t: NodeTester) -> None:
    t.say_on(cobid.heartbeat(MASTER), bytes((State.OPERATIONAL,)))


@contextmanager
def faulty(t: NodeTester, word: int = 0x0F) -> Iterator[None]:
    """In fault, because its master was lost; where 6007h is missing, by a following error."""
    if not all(t.setup.pics.get(item) for item in WATCHES):
        with lagging(t, word):
            yield
        return
    with brought_to(t, ENABLED), supervised(t, 1):
        with t.given():
            control(t, word)
            reaches(t, FAULT, "the master's heartbeat stays away, 6007h = 1")
        yield


@contextmanager
def lagging(t: NodeTester, word: int) -> Iterator[None]:
    """In fault and at rest, because a set value jumped."""
    way, times = plan(t)[1], there(t, WINDOW_TIME)
    with t.kept(WINDOW, *times, TARGET), cyclic(t):
        with t.given():
            narrow(t, way, times)
            control(t, word)
            t.download(TARGET, position(t) + 4 * way, 4)
            for _ in range(100):
                t.on_grid()
                if state_of(status(t)) == FAULT and at_standstill(t):
                    break
            reaches(t, FAULT, "a jump of the set value far beyond 6065h")
        yield


def narrow(t: NodeTester, way: int, times: Sequence[Key]) -> None:
    """Set a small window of the following error, with a short time if the drive has one (`times`); SYNC continues, so it reads nothing
    back.
    """
    t.download(WINDOW, max(way // 20, 1), 4)
    for key in times:
        t.download(key, 10, 2)


@FLT.case(
    "BV_01",
    "6007h = 1: a lost master is a fault (transitions 13, 14), with EMCY and 603Fh",
    "6007h = 1: ein verlorener Master ist ein Fehler (Übergänge 13, 14), mit EMCY und 603Fh",
    condition=WATCHES,
    beside=Particulars(limits="the fault within 3 s after the last heartbeat"),
)
def master_lost(t: NodeTester) -> None:
    with brought_to(t, ENABLED), supervised(t, 1):
        last = t.asked_at
        if t.setup.pics.get("emcy") is not False:
            frame = t.hear((t.emcy,), ms(3000))
            if frame is None or len(frame.data) != 8 or not decode(frame.data).code:
                raise Fail("no emergency message when the master is lost", "EMCY with an error code", shown(frame))
        reaches(t, FAULT, "the master is lost")
        t.timed("master lost to fault", t.now() - last, ms(0.8 * watched_ms(t)), ms(3000))
        if not (code := t.number(ERROR_CODE)):
            raise Fail("603Fh is 0 in fault", "an error code", f"{code:04X}h")


def reset_by(t: NodeTester, word: int, what: str) -> None:
    """The master is back; this controlword must reset the fault."""
    with t.given():
        control(t, 0)
        beat(t)
    control(t, word)
    reaches(t, DISABLED, what)


@FLT.case(
    "BV_02",
    "the rising edge of bit 7 resets a fault (transition 15), and 603Fh is 0",
    "die steigende Flanke von Bit 7 setzt einen Fehler zurück (Übergang 15), 603Fh ist 0",
    condition=FAULTS,
    preamble=(*POWER, LOST),
)
def reset(t: NodeTester) -> None:
    with faulty(t):
        reset_by(t, 0x80, "fault reset")
        if code := t.number(ERROR_CODE):
            raise Fail(f"603Fh is {code:04X}h after the reset", "0000h", f"{code:04X}h")


@FLT.case(
    "BI_01", "in fault other commands have no effect", "im Fehler wirken andere Befehle nicht", condition=FAULTS, preamble=(*POWER, LOST)
)
def no_commands(t: NodeTester) -> None:
    with faulty(t):
        for word in (0, 6, 7, 15, 2):
            control(t, word)
            stays(t, FAULT, f"controlword {word:04X}h in fault", ms(20))


@FLT.case(
    "BI_02",
    "bit 7 that is set already resets nothing: it is an edge",
    "ein bereits gesetztes Bit 7 setzt nichts zurück: es ist eine Flanke",
    condition=FAULTS,
    preamble=(*POWER, LOST, "CIA402_FLT_BV_02"),
)
def level(t: NodeTester) -> None:
    with faulty(t, 0x8F):
        beat(t)
        control(t, 0x80)
        stays(t, FAULT, "bit 7 was set before the fault")
        with t.given():
            control(t, 0)
        control(t, 0x80)
        reaches(t, DISABLED, "fault reset")


QUICK_STOP = 3  # 6007h


def _stays_stopped(t: NodeTester) -> bool:
    """605Ah = 5 to 8: quick stop ends in quick stop active."""
    if not t.setup.pics.get("quick_option"):
        return False
    with t.given():
        return 5 <= t.number(QUICK_OPTION, signed=True) <= 8


def _option(number: int, option: int, end: int, words: str, german: str) -> None:
    @FLT.case(
        f"BV_{number:02}",
        f"6007h = {option}: a lost master {words}",
        f"6007h = {option}: ein verlorener Master {german}",
        condition=WATCHES,
        preamble=(*POWER, LOST),
    )
    def body(t: NodeTester) -> None:
        with brought_to(t, ENABLED), supervised(t, option):
            if end == ENABLED:
                stays(t, ENABLED, f"6007h = {option}", ms(4 * watched_ms(t)))
            else:
                stops_there = end == DISABLED and option == QUICK_STOP and _stays_stopped(t)
                reaches(t, QUICK if stops_there else end, f"6007h = {option}, the master is lost")


_option(3, 0, ENABLED, "changes nothing", "ändert nichts")
_option(4, 2, DISABLED, "is disable voltage", "ist Disable Voltage")
_option(5, 3, DISABLED, "is quick stop", "ist Quick Stop")


@FLT.case(
    "BV_06",
    "while the master's heartbeat is received nothing happens",
    "solange der Heartbeat des Masters kommt, geschieht nichts",
    condition=WATCHES,
    preamble=(*POWER, LOST),
)
def supervised_well(t: NodeTester) -> None:
    with brought_to(t, ENABLED), supervised(t, 1):
        for _ in range(10):
            beat(t)
            stays(t, ENABLED, "the master is present", ms(watched_ms(t) // 2))


@FLT.case(
    "BV_07",
    "a following error beyond 6065h for 6066h is a fault: EMCY 8611h",
    "ein Schleppfehler über 6065h länger als 6066h ist ein Fehler: EMCY 8611h",
    condition=("csp", "following", "may_move"),
    preamble=(*POWER, "CIA402_CSP_BV_01"),
)
def following(t: NodeTester) -> None:
    way, times = plan(t)[1], there(t, WINDOW_TIME)
    with t.kept(WINDOW, *times, TARGET), cyclic(t):
        with t.given():
            narrow(t, way, times)
        goal = position(t) + 4 * way
        t.download(TARGET, goal, 4)
        t.on_grid(2)
        if state_of(status(t)) == ENABLED and abs(position(t) - goal) <= max(way // 20, 1):
            raise Inconclusive(
                "this jump is not a following error: the drive makes it in two cycles; state [link] way",
                "a lag beyond 6065h",
                "it is there",
            )
        for _ in range(100):
            t.on_grid()
            if state_of(status(t)) == FAULT:
                break
        else:
            got = named(status(t))
            raise Fail("a jump of the set value far beyond 6065h raises no fault", "fault", got)
        if t.setup.pics.get("emcy") is False:
            return
        codes = [decode(frame.data).code for frame in t.heard if frame.identifier == t.emcy and len(frame.data) == 8]
        if 0x8611 not in codes:
            raise Fail(
                "another emergency message for a following error", "EMCY 8611h", ", ".join(f"{code:04X}h" for code in codes) or "none"
            )


def in_ms(t: NodeTester, period: int) -> None:
    """60C2h; a drive may have a fixed unit."""
    if t.number(PERIOD[1], signed=True) != MILLI:
        t.download(PERIOD[1], MILLI, 1)
    t.download(PERIOD[0], period, 1)


@contextmanager
def cyclic(t: NodeTester, cycle: Ns = 0) -> Iterator[None]:
    """CSP at the tester's SYNC period, or one that is stated, holding its position."""
    with t.given():
        begin = t.now()
        t.download(TARGET, position(t), 4)
        took = t.now() - begin
    wanted = cycle or max(t.setup.cycle, took)  # a set value and a look at the drive fit into one cycle, however slow its SDOs are
    period = min(max(math.ceil(wanted / 1_000_000), 1), 255)
    t.period = ms(period)
    keys = PERIOD if t.setup.pics.get("period") else ()
    with t.kept(*keys, TARGET):
        with t.given():
            if keys:
                in_ms(t, period)
            t.download(TARGET, position(t), 4)
        with t.operational(), brought_to(t, ENABLED, CSP):
            t.on_grid(3)
            yield


# ---- option codes, in motion
OPT = Purposes[NodeTester](
    "CIA402_OPT", "drive", "CiA 402-2, option codes", condition=("pv", "may_move"), preamble=(*POWER, "CIA402_VEL_BV_01")
)
RAMPED = Particulars(limits="the ramp of the speed and deceleration, 70 to 150 %, and 100 ms")


def ramp(t: NodeTester, speed: int, key: tuple[int, int], what: str) -> None:
    with t.given():
        rate = max(t.number(key), 1)
    nominal = round(speed / rate * 1e9)
    t.timed(what, stop_time(t), round(0.7 * nominal) - ms(20), round(1.5 * nominal) + ms(100))


def _stops(
    number: int, key: tuple[int, int], item: str, option: int, word: int, rate: tuple[int, int], end: int, words: tuple[str, str]
) -> None:
    index = key[0]

    @OPT.case(
        f"BV_{number:02}",
        f"{index:04X}h = {option}: {words[0]} along {rate[0]:04X}h",
        f"{index:04X}h = {option}: {words[1]} an der Rampe {rate[0]:04X}h",
        condition=(item,),
        beside=RAMPED,
    )
    def body(t: NodeTester) -> None:
        with t.kept(key, rate), moving(t) as speed:
            with t.given():
                choose(t, key, option)
                t.download(rate, max(2 * speed, 1), 4)  # half a second
            control(t, word)
            ramp(t, speed, rate, f"{words[0]}, {index:04X}h = {option}")
            reaches(t, end, words[0])


_stops(1, QUICK_OPTION, "quick_option", 1, 0x02, DECELERATION, DISABLED, ("quick stop", "Quick Stop"))
_stops(2, QUICK_OPTION, "quick_option", 2, 0x02, QUICK_DECELERATION, DISABLED, ("quick stop", "Quick Stop"))
_stops(3, SHUTDOWN_OPTION, "shutdown_option", 1, 0x06, DECELERATION, READY, ("shutdown", "Shutdown"))
_stops(4, DISABLE_OPTION, "disable_option", 1, 0x07, DECELERATION, ON, ("disable operation", "Disable Operation"))
_stops(5, HALT_OPTION, "halt_option", 1, 0x10F, DECELERATION, ENABLED, ("halt", "Halt"))
_stops(6, HALT_OPTION, "halt_option", 2, 0x10F, QUICK_DECELERATION, ENABLED, ("halt", "Halt"))
_stops(10, QUICK_OPTION, "quick_option", 5, 0x02, DECELERATION, QUICK, ("quick stop", "Quick Stop"))
_stops(11, QUICK_OPTION, "quick_option", 6, 0x02, QUICK_DECELERATION, QUICK, ("quick stop", "Quick Stop"))


@OPT.case(
    "BV_07",
    "605Ah = 0: quick stop takes the torque away at once",
    "605Ah = 0: Quick Stop nimmt sofort das Moment weg",
    condition=("quick_option",),
)
def coast(t: NodeTester) -> None:
    with t.kept(QUICK_OPTION, DECELERATION, QUICK_DECELERATION), moving(t) as speed:
        with t.given():
            choose(t, QUICK_OPTION, 0)
            for rate in (DECELERATION, QUICK_DECELERATION):  # a ramp would last half a second
                t.download(rate, max(2 * speed, 1), 4)
        control(t, 0x02)
        took = reaches(t, DISABLED, "quick stop, 605Ah = 0")
        t.timed("quick stop to switch on disabled, 605Ah = 0", took, None, ms(200))


@OPT.case(
    "BV_08",
    "605Eh = 2: a fault in motion stops along 6085h, then fault",
    "605Eh = 2: ein Fehler in Bewegung hält an der Rampe 6085h, dann Fehler",
    condition=("fault_option", *WATCHES),
    preamble=(*POWER, "CIA402_VEL_BV_01", LOST),
    beside=RAMPED,
)
def quick_reaction(t: NodeTester) -> None:
    fault_in_motion(t, 2, QUICK_DECELERATION)


def fault_in_motion(t: NodeTester, option: int, rate: tuple[int, int]) -> None:
    """Judged: 605Eh = option, with half a second along this ramp; 0 ends at once."""
    what = f"fault reaction, 605Eh = {option}"
    with t.kept(FAULT_OPTION, rate), moving(t) as speed:
        with t.given():
            choose(t, FAULT_OPTION, option)
            t.download(rate, max(2 * speed, 1), 4)
        with supervised(t, 1):
            lost = _lost(t)
            if lost is None:
                raise Fail("no fault when the master is lost in motion", "fault reaction active", named(status(t)))
            if not option:
                return t.timed(what, reaches(t, FAULT, what), None, ms(200))
            ramp(t, speed, rate, what)
            reaches(t, FAULT, what)


def _lost(t: NodeTester) -> Ns | None:
    """When the statusword leaves operation enabled."""
    begin = t.now()
    while t.now() - begin < ms(1000):
        if state_of(status(t)) != ENABLED:
            return t.now()
        t.pause(ms(1))
    return None


@OPT.case(
    "BV_09",
    "605Ch = 0: disable operation takes the torque away at once",
    "605Ch = 0: Disable Operation nimmt sofort das Moment weg",
    condition=("disable_option",),
)
def disable_at_once(t: NodeTester) -> None:
    with t.kept(DISABLE_OPTION, DECELERATION), moving(t) as speed:
        with t.given():
            choose(t, DISABLE_OPTION, 0)
            t.download(DECELERATION, max(2 * speed, 1), 4)
        control(t, 0x07)
        t.timed("disable operation, 605Ch = 0", reaches(t, ON, "disable operation, 605Ch = 0"), None, ms(200))
