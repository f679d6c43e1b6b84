"""CiA 402, the power states: each transition of the automaton, and commands that must not act (CiA 402-2, figure 2)."""

from typing import NamedTuple

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.cia402.drive import (
    DISABLED,
    ENABLED,
    ON,
    QUICK,
    QUICK_OPTION,
    READY,
    STATUS,
    brought_to,
    choose,
    control,
    named,
    reaches,
    state_of,
    status,
    stays,
)
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.canopen.sdo import Abort

BASIC = "CIA402_PWR_BV_01"
PWR = Purposes[NodeTester]("CIA402_PWR", "drive", "CiA 402-2, power states", preamble=(BASIC,))
ANSWER = ms(3000)


@PWR.case(
    "BV_01",
    "after boot-up it is switch on disabled, by itself",
    "nach dem Hochlauf ist er von selbst in Einschaltsperre",
    preamble=(),
)
def boots(t: NodeTester) -> None:
    size = len(t.upload(STATUS))
    if size != 2:
        raise Fail(f"6041h has {size} bytes", "2 bytes", f"{size} bytes")
    t.reset()
    reaches(t, DISABLED, "after boot-up", t.setup.boot)


class Step(NamedTuple):
    """One transition: controlword in this state leads to that one; `needs`: cases whose behaviour it starts from."""

    number: int
    transition: str
    start: int
    word: int
    end: int
    words: str
    german: str
    needs: tuple[int, ...]


STEPS = (
    Step(2, "2", DISABLED, 0x06, READY, "shutdown from switch on disabled", "Shutdown aus der Einschaltsperre", ()),
    Step(3, "3", READY, 0x07, ON, "switch on", "Switch On", (2,)),
    Step(4, "4", ON, 0x0F, ENABLED, "enable operation", "Enable Operation", (2, 3)),
    Step(5, "5", ENABLED, 0x07, ON, "disable operation", "Disable Operation", (2, 3, 4)),
    Step(6, "6", ON, 0x06, READY, "shutdown from switched on", "Shutdown aus Switched On", (2, 3)),
    Step(7, "7", READY, 0x00, DISABLED, "disable voltage from ready", "Disable Voltage aus Ready", (2,)),
    Step(8, "7", READY, 0x02, DISABLED, "quick stop from ready", "Quick Stop aus Ready", (2,)),
    Step(9, "8", ENABLED, 0x06, READY, "shutdown from operation enabled", "Shutdown aus Operation Enabled", (2, 3, 4)),
    Step(10, "9", ENABLED, 0x00, DISABLED, "disable voltage from operation enabled", "Disable Voltage aus Operation Enabled", (2, 3, 4)),
    Step(11, "10", ON, 0x00, DISABLED, "disable voltage from switched on", "Disable Voltage aus Switched On", (2, 3)),
    Step(12, "10", ON, 0x02, DISABLED, "quick stop from switched on", "Quick Stop aus Switched On", (2, 3)),
)


def _needs(numbers: tuple[int, ...]) -> tuple[str, ...]:
    return (BASIC, *(f"CIA402_PWR_BV_{number:02}" for number in numbers))


def _transition(step: Step) -> None:
    @PWR.case(
        f"BV_{step.number:02}",
        f"transition {step.transition}: {step.words}",
        f"Übergang {step.transition}: {step.german}",
        condition=() if step.start in (DISABLED,) and step.end == READY else ("may_power",),
        preamble=_needs(step.needs),
        beside=Particulars(limits="within 3 s"),
    )
    def body(t: NodeTester) -> None:
        with brought_to(t, step.start):
            control(t, step.word)
            took = reaches(t, step.end, step.words, ANSWER)
            t.timed(f"{step.words} to statusword", took, None, ANSWER)


for _step in STEPS:
    _transition(_step)


class Idle(NamedTuple):
    """A command that does not act in this state."""

    number: int
    state: int
    word: int
    words: str
    german: str
    needs: tuple[int, ...]


IDLE = (
    Idle(1, DISABLED, 0x07, "switch on in switch on disabled", "Switch On in Einschaltsperre", ()),
    Idle(2, DISABLED, 0x0F, "enable operation in switch on disabled", "Enable Operation in Einschaltsperre", ()),
    Idle(3, READY, 0x86, "a fault reset in ready to switch on", "ein Fehler-Reset in Ready to Switch On", (2,)),
    Idle(4, ON, 0x87, "a fault reset in switched on", "ein Fehler-Reset in Switched On", (2, 3)),
)


def _no_effect(idle: Idle) -> None:
    @PWR.case(
        f"BI_{idle.number:02}",
        f"{idle.words} changes nothing",
        f"{idle.german} ändert nichts",
        condition=("may_power",),
        preamble=_needs(idle.needs),
    )
    def body(t: NodeTester) -> None:
        with brought_to(t, idle.state):
            control(t, idle.word)
            stays(t, idle.state, idle.words)


for _idle in IDLE:
    _no_effect(_idle)

FULL = (2, 3, 4)


@PWR.case(
    "BV_13",
    "transitions 11 and 12: quick stop with 605Ah = 2 ends in switch on disabled",
    "Übergänge 11 und 12: Quick Stop mit 605Ah = 2 endet in Einschaltsperre",
    condition=("may_power", "quick_option"),
    preamble=_needs(FULL),
)
def quick_stop(t: NodeTester) -> None:
    with t.kept(QUICK_OPTION), brought_to(t, ENABLED):
        with t.given():
            choose(t, QUICK_OPTION, 2)
        control(t, 0x02)
        reaches(t, DISABLED, "quick stop, 605Ah = 2")


@PWR.case(
    "BV_14",
    "605Ah = 6: it stays in quick stop active; transition 16 leads back",
    "605Ah = 6: er bleibt in Quick Stop Active; Übergang 16 führt zurück",
    condition=("may_power", "quick_option"),
    preamble=_needs(FULL),
)
def quick_stop_stays(t: NodeTester) -> None:
    with t.kept(QUICK_OPTION), brought_to(t, ENABLED):
        got = _takes(t, 6)
        if not got:
            raise Warn("605Ah does not accept 6", "quick stop that stays", "refused")
        control(t, 0x02)
        reaches(t, QUICK, "quick stop, 605Ah = 6")
        stays(t, QUICK, "quick stop, 605Ah = 6", ms(500))
        control(t, 0x0F)
        reaches(t, ENABLED, "enable operation in quick stop active")


@PWR.case(
    "BV_15",
    "605Ah = 6, transition 12: disable voltage ends quick stop active",
    "605Ah = 6, Übergang 12: Disable Voltage beendet Quick Stop Active",
    condition=("may_power", "quick_option"),
    preamble=_needs(FULL),
)
def quick_stop_left(t: NodeTester) -> None:
    with t.kept(QUICK_OPTION), brought_to(t, ENABLED):
        if not _takes(t, 6):
            raise Warn("605Ah does not accept 6", "quick stop that stays", "refused")
        control(t, 0x02)
        with t.given():
            reaches(t, QUICK, "quick stop, 605Ah = 6")
        control(t, 0)
        reaches(t, DISABLED, "disable voltage in quick stop active")


def _takes(t: NodeTester, value: int) -> bool:
    try:
        t.download(QUICK_OPTION, value, 2)
    except Aborted as refused:
        if refused.code == Abort.READ_ONLY and (fixed := t.number(QUICK_OPTION, signed=True)) != value:
            raise NotApplicable(f"605Ah is fixed to {fixed}") from refused
        return refused.code == Abort.READ_ONLY
    return True


@PWR.case(
    "CA_01",
    "enable operation in ready to switch on passes through switched on",
    "Enable Operation in Ready to Switch On läuft durch Switched On",
    condition=("may_power",),
    preamble=_needs(FULL),
)
def both_at_once(t: NodeTester) -> None:
    with brought_to(t, READY):
        control(t, 0x0F)
        try:
            reaches(t, ENABLED, "000Fh in ready to switch on", ms(1500))
        except Fail as failed:
            if state_of(status(t)) not in (READY, ON):
                raise
            raise Warn(
                "000Fh in ready to switch on does not enable; masters that skip 0007h fail here", failed.expected, failed.got
            ) from failed


@PWR.case(
    "CA_02",
    "bit 4 voltage enabled and bit 9 remote are set while enabled",
    "Bit 4 Spannung und Bit 9 Remote sind bei Betrieb gesetzt",
    condition=("may_power",),
    preamble=_needs(FULL),
)
def bits(t: NodeTester) -> None:
    with brought_to(t, ENABLED):
        got = status(t)
        for bit, name in ((4, "voltage enabled"), (9, "remote")):
            if not got >> bit & 1:
                raise Warn(f"bit {bit} ({name}) of the statusword is clear in operation enabled", "bits 4 and 9 set", named(got))


@PWR.case("RC_01", "ten times on and off", "zehnmal ein und aus", condition=("may_power",), preamble=_needs((*FULL, 10)))
def ten_times(t: NodeTester) -> None:
    with brought_to(t, DISABLED):
        for turn in range(10):
            for word, state in ((6, READY), (7, ON), (15, ENABLED), (0, DISABLED)):
                control(t, word)
                reaches(t, state, f"turn {turn + 1}, controlword {word:04X}h")
