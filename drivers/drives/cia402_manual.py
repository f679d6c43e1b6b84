"""Commissioning by SDO alone: switch a drive on and move it in PP, PV, HM or IP mode, without a cycle.  Pure plans of steps.

Source: IEC 61800-7-201 (profile position, profile velocity, homing, interpolated position); units AX-311.  The operator must be at the
machine: there is no path planning, no other axis, and only the drive's own lag supervision.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

from drivers.drives.canopen_steps import Answer, Now, Pause, Read, Silent, Step, Sync, Write
from drivers.drives.cia402 import Bit, Mode
from drivers.drives.cia402_boot import name_of
from drivers.drives.cia402_states import Command, State, next_command, state_of

POLL_MS, TRIES = 5, 400  # for a state; a move has its own limit
SLICE_MS = 20  # longest pause within a move, so that a request to end it takes effect soon
STOP_TRIES, STILL, STILL_INC, SILENCES = 1000, 10, 2, 3  # polls of a stop in all, and with the place unchanged; answers it may lack
NEW_SET_POINT, RELATIVE, IP_ENABLE = 0x0010, 0x0040, 0x0010
ACKNOWLEDGED = SPEED_ZERO = 0x1000  # statusword bit 12 in PP, in PV
Manual = Generator[Step, Answer, "Moved"]


class ManualError(Exception):
    """The refused step, and the object."""


@dataclass(frozen=True, slots=True)
class Moved:
    """Increments before and after."""

    start_inc: int
    end_inc: int


def patience_ms(way_inc: int, speed_inc_s: int, accel_inc_s2: int) -> int:
    """Time limit of a move: twice the time for distance, speed and both ramps, plus two seconds."""
    return 2 * round(1000 * (abs(way_inc) / speed_inc_s + speed_inc_s / accel_inc_s2)) + 2000


def profile_position(way_inc: int, speed_inc_s: int, accel_inc_s2: int) -> Manual:
    """PP: a relative way; the set-point handshake is waited for."""
    yield from _write(0x6081, speed_inc_s, 4)
    yield from _write(0x6083, accel_inc_s2, 4)
    yield from _write(0x6084, accel_inc_s2, 4)
    start = yield from _on(Mode.PP)
    yield from _write(0x607A, way_inc, 4)
    yield from _control(Command.ENABLE.value | NEW_SET_POINT | RELATIVE)
    yield from _status(ACKNOWLEDGED, ACKNOWLEDGED, 1000)
    yield from _control(Command.ENABLE.value | RELATIVE)
    yield from _status(ACKNOWLEDGED, 0, 1000)
    yield from _status(Bit.TARGET_REACHED, Bit.TARGET_REACHED, patience_ms(way_inc, speed_inc_s, accel_inc_s2))
    return (yield from _off(start))


def profile_velocity(speed_inc_s: int, accel_inc_s2: int, run_ms: int) -> Manual:
    """PV: at that speed for a while, then to rest."""
    yield from _write(0x6083, accel_inc_s2, 4)
    yield from _write(0x6084, accel_inc_s2, 4)
    yield from _write(0x60FF, 0, 4)
    start = yield from _on(Mode.PV)
    yield from _write(0x60FF, speed_inc_s, 4)
    for left in range(run_ms, 0, -SLICE_MS):
        yield Pause(min(SLICE_MS, left))
    yield from _write(0x60FF, 0, 4)
    yield from _status(SPEED_ZERO, SPEED_ZERO, patience_ms(0, abs(speed_inc_s), accel_inc_s2))
    return (yield from _off(start))


def homing(limit_ms: int) -> Manual:
    """HM by the method and speeds stored in the drive; ManualError when it ends in an error."""
    start = yield from _on(Mode.HM)
    yield from _control(Command.ENABLE.value | Bit.START_HOMING)
    yield Pause(20)
    done = Bit.HOMING_ATTAINED | Bit.TARGET_REACHED
    end = (yield from _now()) + limit_ms
    while (yield from _now()) < end:
        status = yield from _number(0x6041, signed=False)
        if status & Bit.HOMING_ERROR or not status & 0x04:
            break
        if status & done == done:
            return (yield from _off(start))
        yield Pause(POLL_MS)
    yield from _off(start)
    raise ManualError("homing: the drive did not find its home")


def interpolated(points_inc: Sequence[int], period_ms: int) -> Manual:
    """IP: one point (relative to its position) with each SYNC of the tool."""
    start = yield from _number(0x6064)
    yield from _write(0x60C1, start, 4, sub=1)
    yield from _on(Mode.IP)
    yield from _control(Command.ENABLE.value | IP_ENABLE)
    for point in points_inc:
        yield from _write(0x60C1, start + point, 4, sub=1)
        yield Sync(period_ms)
    for _ in range(20):  # comes to rest at the last point
        yield Sync(period_ms)
    yield from _control(Command.ENABLE.value)
    return (yield from _off(start))


def stopped() -> Generator[Step, Answer, int]:
    """Stop and switch off by controlword, from any state of a move; return the statusword that proves it.

    A drive that waits in quick stop active (605Ah 5..8) is switched off at rest.  A refusal does not end the attempt: the next poll tries
    again.
    Raises ManualError when the drive does not show that it is off.
    """
    place, still, silent, words = 0, 0, 0, "no answer"
    for turn in range(STOP_TRIES):
        answer = yield Read(0x6041)
        if isinstance(answer, bytes):
            status = int.from_bytes(answer, "little")
            state, words = state_of(status), f"statusword {status:04X}h"
            if state in (State.DISABLED, State.NOT_READY, State.FAULT):
                yield Write(0x6060, 0, bytes((Mode.CSP,)))
                return status
            before, shown = place, (yield Read(0x6064))
            place = int.from_bytes(shown, "little", signed=True) if isinstance(shown, bytes) else before + STILL_INC + 1
            still = still + 1 if abs(place - before) <= STILL_INC else 0
            command = _stopping(state, ramp_over=still >= STILL or turn >= STOP_TRIES // 2)
            if command is not None:
                yield Write(0x6040, 0, command.value.to_bytes(2, "little"))
        elif answer is Silent.YES and (silent := silent + 1) >= SILENCES:
            break
        yield Pause(POLL_MS)
    raise ManualError(f"the drive does not show that it is switched off ({words})")


def _stopping(state: State | None, *, ramp_over: bool) -> Command | None:
    if state is State.REACTING:
        return None
    if state in (State.ENABLED, State.QUICK_STOP) and not ramp_over:
        return Command.QUICK_STOP
    return Command.DISABLE_VOLTAGE


def _on(mode: Mode) -> Generator[Step, Answer, int]:
    """In that mode and enabled; 607Ah = 6064h before; where it is."""
    yield from _write(0x6060, mode, 1)
    for _ in range(TRIES):
        if (yield from _number(0x6061)) == mode:
            break
        yield Pause(POLL_MS)
    start = yield from _number(0x6064)
    yield from _write(0x607A, start, 4)
    yield from _way(State.ENABLED)
    return start


def _off(start: int) -> Generator[Step, Answer, Moved]:
    """At rest: switched off, back in CSP; where it is."""
    end = yield from _number(0x6064)
    yield from _way(State.DISABLED)
    yield from _write(0x6060, Mode.CSP, 1)
    return Moved(start, end)


def _way(goal: State) -> Generator[Step, Answer, None]:
    for _ in range(TRIES):
        state = state_of((yield from _number(0x6041, signed=False)))
        if state is goal:
            return
        command = next_command(state, goal) if state is not None else None
        if state is State.NOT_READY and goal is State.ENABLED:
            command = Command.SHUTDOWN  # some drives leave statusword 0000h only at their first controlword
        if state is State.FAULT and goal is State.DISABLED:
            raise ManualError("the drive has a fault")
        if command is not None:
            yield from _control(command.value)
        yield Pause(POLL_MS)
    raise ManualError(f"the drive did not reach {goal.name.lower()}")


def _status(mask: int, value: int, limit_ms: int) -> Generator[Step, Answer, None]:
    end = (yield from _now()) + limit_ms
    while (yield from _now()) < end:
        status = yield from _number(0x6041, signed=False)
        if status & mask == value:
            return
        if state_of(status) is not State.ENABLED:
            raise ManualError(f"the drive left operation enabled (statusword {status:04X}h)")
        yield Pause(POLL_MS)
    raise ManualError(f"statusword: bits {mask:04X}h did not become {value:04X}h within {limit_ms} ms")


def _now() -> Generator[Step, Answer, int]:
    answer = yield Now()
    return int.from_bytes(answer, "little") if isinstance(answer, bytes) else 0


def _control(word: int) -> Generator[Step, Answer, None]:
    yield from _write(0x6040, word, 2)


def _write(index: int, value: int, size: int, sub: int = 0) -> Generator[Step, Answer, None]:
    answer = yield Write(index, sub, (value & (1 << 8 * size) - 1).to_bytes(size, "little"))
    if not isinstance(answer, bytes):
        raise ManualError(f"{name_of(index, sub)}: {'no answer' if answer is Silent.YES else answer}")


def _number(index: int, *, signed: bool = True) -> Generator[Step, Answer, int]:
    answer = yield Read(index)
    if not isinstance(answer, bytes):
        raise ManualError(f"{name_of(index, 0)}: {'no answer' if answer is Silent.YES else answer}")
    return int.from_bytes(answer, "little", signed=signed)
