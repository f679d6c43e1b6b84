"""SERVODYN: boosters with a fault in their phase, their stops or their supervision, seen in motion (used by peers.servodyn)."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import pi

from drivers.emulator.servo.settings import INC_PER_TURN
from drivers.emulator.servodyn.axis import Fault, State
from gateway.conformance.peers.boosters import CYCLE_MS, QUICK, ActualChange, Booster, Heard, codec
from gateway.conformance.peers.can_devices import put
from protocols.base.machine import Frame, ms
from protocols.servodyn.codec import ActualValue, SetValue
from protocols.servodyn.plan import SYNC_ID

SET = codec().set_id(1)
CYCLE = ms(CYCLE_MS)
FAR, CREEP = 5000, 1000  # increments, and increments a cycle
UNSEEN = 3  # unchanged life counters that go unseen
FED = replace(QUICK, speed_feed_forward=1.0)


# ---- latched values
def one_before(booster: Booster, value: ActualValue) -> ActualValue:
    before, booster.kept = booster.kept, value
    return value._replace(position_inc=before.position_inc if before is not None else value.position_inc)


def own_timer(booster: Booster, value: ActualValue) -> ActualValue:
    """The position at a timer of its own, up to a cycle old."""
    speed = booster.axis.servo.speed_rad_s * INC_PER_TURN / (2 * pi)
    return value._replace(position_inc=value.position_inc - round(speed * (booster.now % CYCLE) / 1e9))


def as_sent(booster: Booster, value: ActualValue) -> ActualValue:
    return value._replace(position_inc=int(booster.axis.servo.counter_inc // 1.0))


def at_once(booster: Booster, frame: Frame) -> Sequence[Frame]:
    """A set value acts when it comes."""
    if frame.identifier == SET and len(frame.data) == 8 and booster.now:
        booster.slave.wake(booster.now)
        booster.axis._activate(codec().decode_set(frame)[1], 0)
    return [frame]


def first_counts(booster: Booster, frame: Frame) -> Sequence[Frame]:
    if frame.identifier == SYNC_ID:
        booster.tally = 0
    elif frame.identifier == SET:
        booster.tally += 1
        return [frame] if booster.tally == 1 else []
    return [frame]


# ---- reported values
def code_changes(booster: Booster, value: ActualValue) -> ActualValue:
    """The second telegram of a fault names the next one."""
    booster.tally = booster.tally + 1 if value.fault else 0
    return value._replace(fault_code=Fault.LIFE_LOST) if booster.tally > 1 else value


def code_once(booster: Booster, value: ActualValue) -> ActualValue:
    booster.tally = booster.tally + 1 if value.fault else 0
    return value._replace(fault_code=0) if booster.tally > 1 else value


def torque(change: Callable[[int], int]) -> ActualChange:
    return lambda booster, value: value._replace(torque_permille=change(value.torque_permille))


def swapped(value: int) -> int:
    return int.from_bytes((value & 0xFFFF).to_bytes(2, "big"), "little", signed=True)


# ---- accepted values
def feed_forward(factor: float) -> Heard:
    return lambda booster, value: value._replace(speed_rpm=max(min(round(factor * value.speed_rpm), 32767), -32768))


def one_late(booster: Booster, value: SetValue) -> SetValue:
    """Under control the set position is that of the set value before."""
    before, booster.tally = booster.tally, value.position_inc
    return value._replace(position_inc=before) if booster.axis.state is State.ENABLED else value


def twice(booster: Booster, frame: Frame) -> Sequence[Frame]:
    return [frame, frame] if booster.axis.state is State.ENABLED and frame.identifier == codec().actual_id(1) else [frame]


def code_left(booster: Booster, value: ActualValue) -> ActualValue:
    booster.tally = value.fault_code or booster.tally
    return value._replace(fault_code=booster.tally) if value.power_on and not value.fault else value


def power_dips(booster: Booster, value: ActualValue) -> ActualValue:
    begins = value.enabled and not (booster.kept and booster.kept.enabled)
    booster.kept = value
    return value._replace(power_on=value.power_on and not begins)


def jumps_back(booster: Booster, value: SetValue) -> SetValue:
    """A set position that jumps back is gone to."""
    at = max(value.position_inc, booster.tally - CREEP) if booster.axis.state is State.ENABLED else value.position_inc
    booster.tally = at
    return value._replace(position_inc=at)


def enable_edge(booster: Booster, value: SetValue) -> SetValue:
    """Enable counts by its edge, with power on."""
    if not value.enable:
        booster.tally = 0
    elif not booster.tally:
        booster.tally = 1 if booster.axis.state in (State.POWERED, State.OPENING, State.ENABLED) else 2
    return value._replace(enable=booster.tally == 1)


def one_life(booster: Booster, value: SetValue) -> SetValue:
    """One unchanged life counter is a fault."""
    if value.life == booster.tally and booster.axis.supervised:
        booster.axis.fail(Fault.LIFE_LOST)
    booster.tally = value.life
    return value


class LateLife(Booster):
    """Three unchanged life counters more go unseen."""

    def __init__(self) -> None:
        super().__init__(sets=lambda booster, value: self.heard(value))
        self.before, self.fake, self.unchanged = -1, 0, 0

    def heard(self, value: SetValue) -> SetValue:
        self.unchanged = self.unchanged + 1 if value.life == self.before else 0
        self.before = value.life
        self.fake += self.unchanged <= UNSEEN
        return value._replace(life=self.fake & 0xFF)


def sets_unwatched(booster: Booster, frame: Frame) -> Sequence[Frame]:
    """Set values that stay away are not missed: the last one counts as new."""
    if frame.identifier == SET:
        booster.tally = 1
        return [frame]
    if frame.identifier != SYNC_ID:
        return [frame]
    came, booster.tally = booster.tally, 0
    if came:
        return [frame]
    last = booster.axis.commanded.value
    booster.last_sync += 1
    return [codec().encode_set(1, last._replace(life=last.life + 1 + booster.last_sync & 0xFF)), frame]


def narrow(bits: int) -> Heard:
    half = 1 << (bits - 1)
    return lambda booster, value: value._replace(position_inc=(value.position_inc + half) % (2 * half) - half)


class Creeps(Booster):
    """Moves to a distant set position when control begins."""

    def __init__(self) -> None:
        super().__init__(sets=lambda booster, value: self.heard(value))
        self.goes, self.at = False, 0

    def heard(self, value: SetValue) -> SetValue:
        if self.axis.state is not State.ENABLED:
            self.goes, self.at = value.enable, self.axis.actual().position_inc
            return value._replace(position_inc=self.at) if value.enable else value
        way = value.position_inc - self.at
        self.goes = self.goes and abs(way) > FAR
        if not self.goes:
            return value
        self.at += max(min(way, CREEP), -CREEP)
        return value._replace(position_inc=self.at)


def zero_at_reset(booster: Booster) -> None:
    axis = booster.axis
    reset = axis._reset

    def begun() -> None:
        reset()
        if not axis.fault_code:
            axis.jump_encoder(-int(axis.servo.counter_inc // 1.0))

    put(axis, _reset=begun)
