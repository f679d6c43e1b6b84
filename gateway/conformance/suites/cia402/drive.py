"""The tester's side of a CiA 402 drive: controlword and statusword, modes, motion; every case ends with the power off."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.can.node import named as object_name
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable
from protocols.base.machine import Ns, ms
from protocols.canopen.dictionary import Key

ABORT_OPTION, ERROR_CODE, CONTROL, STATUS = (0x6007, 0), (0x603F, 0), (0x6040, 0), (0x6041, 0)
QUICK_OPTION, SHUTDOWN_OPTION, DISABLE_OPTION, HALT_OPTION, FAULT_OPTION = ((index, 0) for index in range(0x605A, 0x605F))
MODE, MODE_SHOWN, POSITION, SPEED = (0x6060, 0), (0x6061, 0), (0x6064, 0), (0x606C, 0)
WINDOW, WINDOW_TIME, TARGET, LIMIT_LOW, LIMIT_HIGH = (0x6065, 0), (0x6066, 0), (0x607A, 0), (0x607D, 1), (0x607D, 2)
PROFILE_SPEED, ACCELERATION, DECELERATION, QUICK_DECELERATION = (0x6081, 0), (0x6083, 0), (0x6084, 0), (0x6085, 0)
MODES_OFFERED, TARGET_SPEED = (0x6502, 0), (0x60FF, 0)
MASK = 0x6F  # bits of the statusword that name the state
NOT_READY, DISABLED, READY, ON, ENABLED, QUICK, REACTION, FAULT = 0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08
NAMES = {
    NOT_READY: "not ready to switch on",
    DISABLED: "switch on disabled",
    READY: "ready to switch on",
    ON: "switched on",
    ENABLED: "operation enabled",
    QUICK: "quick stop active",
    REACTION: "fault reaction active",
    FAULT: "fault",
}
PP, PV, HM, IP, CSP = 1, 3, 6, 7, 8
STEP = ms(2)
LONG = ms(8000)
DISPLAY = ms(1000)  # from 6060h to 6061h
REACHED, BIT12, BIT13, INTERNAL = 0x400, 0x1000, 0x2000, 0x800


def named(status: int) -> str:
    """A statusword in hex and words."""
    return f"{status:04X}h ({NAMES.get(state_of(status), 'not a state of the standard')})"


def state_of(status: int) -> int:
    """Bits 0 to 3, 5 and 6; bit 5 does not count where the standard leaves it open."""
    found = status & MASK
    return found if found in NAMES else found & 0x4F


def status(t: NodeTester) -> int:
    return t.number(STATUS)


def control(t: NodeTester, word: int) -> None:
    t.download(CONTROL, word, 2)


def until(t: NodeTester, good: Callable[[], bool], what: str, limit: Ns = LONG, beside: Callable[[], str] = str) -> Ns:
    """Wait until the condition holds; return the time it took.  `beside`: what a Fail shows besides the statusword."""
    begin = t.now()
    while not good():
        if t.now() - begin > limit:
            got = ", ".join(filter(None, (beside(), f"statusword {named(status(t))}")))
            raise Fail(f"{what}: not within {limit / 1e6:.0f} ms, {got}", what, got)
        t.pause(STEP)
    return t.now() - begin


def reaches(t: NodeTester, state: int, what: str, limit: Ns = ms(3000)) -> Ns:
    """Judged: this state, soon."""
    begin = t.now()
    while state_of(got := status(t)) != state:
        if t.now() - begin > limit:
            raise Fail(f"{what}: {named(got)}", f"{NAMES[state]} (xx{state:02X}h)", named(got))
        t.pause(STEP)
    return t.now() - begin


def stays(t: NodeTester, state: int, what: str, time: Ns = ms(60)) -> None:
    """Judge: no other state during the wait."""
    begin = t.now()
    while t.now() - begin < time:
        if state_of(got := status(t)) != state:
            raise Fail(f"{what}: {named(got)}", f"{NAMES[state]} (xx{state:02X}h)", named(got))
        t.pause(5 * STEP)


WAYS = {DISABLED: (), READY: (6,), ON: (6, 7), ENABLED: (6, 7, 15)}
REACHED_BY = {6: READY, 7: ON, 15: ENABLED}


@contextmanager
def brought_to(t: NodeTester, state: int, mode: int | None = None) -> Iterator[None]:
    """In this state within the block, without power afterwards."""
    with t.kept(MODE):
        try:
            with t.given():
                if mode is not None:
                    t.download(MODE, mode, 1)
                at_rest(t)
                for word in WAYS[state]:
                    control(t, word)
                    reaches(t, REACHED_BY[word], f"controlword {word:04X}h")
                if mode is not None:
                    _mode_shown(t, mode)
            yield
        finally:
            try:
                off(t)
            except Ended:  # the next case must not find it so
                with suppress(Ended):
                    t.reset()


def _mode_shown(t: NodeTester, mode: int) -> None:
    """A drive may need a moment to change its mode; one that never shows it is judged by the cases of 6061h."""
    begin = t.now()
    with suppress(Ended):
        while t.number(MODE_SHOWN, signed=True) != mode and t.now() - begin < DISPLAY:
            t.pause(STEP)


def at_rest(t: NodeTester) -> None:
    """Switch on disabled; a fault is reset."""
    control(t, 0)
    until(t, lambda: state_of(status(t)) not in (NOT_READY, REACTION, QUICK, ENABLED), "a state at rest")
    if state_of(status(t)) == FAULT:
        control(t, 0x80)
    reaches(t, DISABLED, "controlword 0000h")
    control(t, 0)


def off(t: NodeTester) -> None:
    """Stops, then no power."""
    if state_of(status(t)) == ENABLED:
        control(t, 0x02)
        with suppress(Ended):
            until(t, lambda: state_of(status(t)) != ENABLED, "quick stop", ms(3000))
            until(t, lambda: at_standstill(t), "standstill", ms(3000))
    at_rest(t)


def there(t: NodeTester, *keys: Key) -> tuple[Key, ...]:
    """Those of these objects, which the standard leaves to the maker, that the drive has."""
    return tuple(key for key in keys if t.exists(key))


def position(t: NodeTester) -> int:
    return t.number(POSITION, signed=True)


def speed(t: NodeTester) -> int:
    """606Ch; of a drive without it, by 6064h."""
    if t.setup.pics.get("velocity"):
        return t.number(SPEED, signed=True)
    begin, before = t.now(), position(t)
    t.pause(5 * STEP)
    return round((position(t) - before) * 1e9 / max(t.now() - begin, 1))


def at_standstill(t: NodeTester) -> bool:
    return abs(speed(t)) < max(plan(t)[0] // 50, 10)


def patience(t: NodeTester) -> Ns:
    """For ten ways at the speed of the plan."""
    chosen, way = plan(t)
    return LONG + round(10e9 * way / max(chosen, 1))


def choose(t: NodeTester, key: Key, option: int) -> None:
    """This option for the case; option codes may be fixed, and a drive need not offer each."""
    if t.number(key, signed=True) == option:
        return
    try:
        t.download(key, option, 2)
    except Aborted as refused:
        raise NotApplicable(f"{object_name(key)} does not accept {option}: {refused.got}") from refused


def plan(t: NodeTester) -> tuple[int, int]:
    """Speed and way of a motion of this tester, in the device's units; found out once."""
    pics = t.setup.pics
    chosen, way = pics.get("motion_speed"), pics.get("motion_way")
    assert isinstance(chosen, int) and isinstance(way, int), "set by the session"
    return chosen, way


@contextmanager
def moving(t: NodeTester) -> Iterator[int]:
    """Profile velocity at the speed of the plan; the speed."""
    wanted = plan(t)[0]
    with t.kept(TARGET_SPEED), brought_to(t, ENABLED, PV):
        with t.given():
            t.download(TARGET_SPEED, wanted, 4)
            until(t, lambda: abs(speed(t) - wanted) < wanted // 20, f"{wanted} in 606Ch")
        yield wanted


def stop_time(t: NodeTester) -> Ns:
    return until(t, lambda: at_standstill(t), "standstill")
