"""Modes of operation of the emulated CiA 402 drive: PP, PV, HM, IP, CSP, CSV, CST.

Source: CiA 402-2/-3 (IEC 61800-7-201), chapters of the modes.  A mode requests motion from its drive; power, brake, limits and faults
belong to the drive.  Positions are the user's increments (6064h), speeds inc/s; `tick` is called every millisecond while `busy`.
"""

from typing import ClassVar, Protocol

from drivers.emulator.canopen.objects import Objects
from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.homing import HERE, METHODS, TO_INDEX, Homing, Phase
from drivers.emulator.cia402.position import UserPosition
from drivers.emulator.cia402.profile import Trapezoid, towards
from drivers.emulator.cia402.servo import DriveServo
from drivers.emulator.cia402.states import BIT12, BIT13, TARGET
from drivers.emulator.cia402.switches import Edge, Switches

TICK_S = 0.001
NEW_SET_POINT, IMMEDIATELY, RELATIVE, ON_SET_POINT = 0x10, 0x20, 0x40, 0x200  # controlword in PP
START = 0x10  # controlword in HM and IP
LEAST = 1e-9  # inc/s2: a deceleration of 0 would never end


class Drive(Protocol):
    """What a mode may request from the drive."""

    objects: Objects
    servo: DriveServo
    switches: Switches
    homing: Homing
    place: UserPosition

    @property
    def position(self) -> float: ...  # 6064h, not wrapped
    @property
    def demand(self) -> float: ...  # 6062h, not wrapped
    @property
    def controlword(self) -> int: ...
    @property
    def period_ns(self) -> int: ...  # of the set values in cyclic modes
    @property
    def following_error_active(self) -> bool: ...
    @property
    def own_feed_forward(self) -> float: ...
    def follow(self, position: float, duration_ns: int, speed: float) -> None: ...
    def clip(self, position: float) -> float: ...  # into the software limits
    def set_home(self, counter: int) -> None: ...
    def homing_failed(self) -> None: ...
    def watch_switches(self) -> None: ...


class Mode:
    """Also the mode "none": holds its position."""

    code: ClassVar[int] = 0
    synchronous: ClassVar[bool] = False  # lives from SYNC
    follows: ClassVar[bool] = True  # position control: the following error counts

    def __init__(self, drive: Drive) -> None:
        self.drive, self.objects, self.servo = drive, drive.objects, drive.servo
        self.busy = False
        self.halted = False

    def enter(self) -> None:
        """Operation was enabled, or the mode chosen: set-points are cleared, the axis holds."""
        self.busy = self.halted = False
        self.servo.hold()

    def leave(self) -> None:
        """Power or mode goes away."""
        self.busy = False

    def control(self, word: int, before: int) -> None:
        """A controlword while enabled."""

    def tick(self) -> None:
        """One millisecond of a motion."""

    def sync(self, new: bool) -> None:
        """SYNC, after the synchronous set values became active."""

    def edge(self, edge: Edge) -> None:
        """A switch changed."""

    def bits(self) -> int:
        """Bits 10, 12, 13 of the statusword."""
        return 0

    def halt(self) -> None:
        self.halted, self.busy = True, False

    def resume(self) -> None:
        self.halted = False
        self.servo.hold()

    def value(self, key: tuple[int, int]) -> int:
        number = self.objects.values[key]
        return number if isinstance(number, int) else 0


class ProfilePosition(Mode):
    code = 1

    def enter(self) -> None:
        super().enter()
        self._profile = Trapezoid(self.drive.position)
        self._next: tuple[float, float, float, float, bool] | None = None
        self._acknowledged = False
        self._in_window_ms, self._reached = 0, True
        self._passing = False
        self._goal = self.drive.position

    def control(self, word: int, before: int) -> None:
        if not word & NEW_SET_POINT:
            if self._next is None:
                self._acknowledged = False
        elif not before & NEW_SET_POINT and not self._acknowledged:
            self._take(word)

    def _take(self, word: int) -> None:
        """A new set-point: now, or after the one under way."""
        target = float(self.value(od.TARGET_POSITION))
        if word & RELATIVE:
            target += self._next[0] if self._next is not None else self._goal
        top = min(self.value(od.PROFILE_SPEED), self.value(od.MAX_PROFILE_SPEED))
        acceleration = min(self.value(od.ACCELERATION), self.value(od.MAX_ACCELERATION))
        deceleration = min(self.value(od.DECELERATION), self.value(od.MAX_DECELERATION))
        point = (self.drive.clip(target), float(top), max(acceleration, LEAST), max(deceleration, LEAST), bool(word & ON_SET_POINT))
        self._acknowledged, self._reached, self._in_window_ms = True, False, 0
        if word & IMMEDIATELY or self._profile.arrived:
            self._next = None
            self._go(point)
        else:
            self._next = point
            self._passing = point[4]
        if self.halted:
            self.busy = False

    def _go(self, point: tuple[float, float, float, float, bool]) -> None:
        if not self.busy and self.servo.mode and self._profile.arrived:
            self._profile.position, self._profile.speed = self.drive.demand, 0.0
        self._goal = self._profile.target = point[0]
        self._profile.top, self._profile.acceleration, self._profile.deceleration = point[1:4]
        self._passing, self.busy = False, True

    def tick(self) -> None:
        profile = self._profile
        if self._passing and self._next is not None:
            rest = profile.target - profile.position
            if abs(rest) <= abs(profile.speed) * TICK_S:
                self._start_next()
            else:  # on through the set-point without slowing down
                profile.target += rest * 1e6
                profile.step(TICK_S)
                profile.target = self._goal
        else:
            profile.step(TICK_S)
        self.drive.follow(profile.position, 1_000_000, profile.speed)
        if profile.arrived and self._next is not None:
            self._start_next()
        elif profile.arrived:
            self._settle()

    def _start_next(self) -> None:
        point, self._next = self._next, None
        if point is not None:
            self._go(point)
            self._in_window_ms = 0
        if not self.drive.controlword & NEW_SET_POINT:
            self._acknowledged = False

    def _settle(self) -> None:
        """Target reached: inside the window for the time of 6068h."""
        inside = abs(self._goal - self.drive.position) <= self.value(od.POSITION_WINDOW)
        self._in_window_ms = self._in_window_ms + 1 if inside else 0
        if inside and self._in_window_ms > self.value(od.POSITION_TIME):
            self._reached, self.busy = True, False

    def halt(self) -> None:
        super().halt()
        self._profile.speed = 0.0

    def resume(self) -> None:
        super().resume()
        self._profile.position, self._profile.speed = self.drive.position, 0.0
        self.busy = not self._profile.arrived or self._next is not None

    def bits(self) -> int:
        return TARGET * self._reached | BIT12 * self._acknowledged | BIT13 * self.drive.following_error_active


class ProfileVelocity(Mode):
    code = 3
    follows = False

    def enter(self) -> None:
        super().enter()
        self._speed = self.drive.servo.measured_inc
        self._in_window_ms = self._still_ms = 0
        self._reached = self._still = False
        self.busy = True

    def tick(self) -> None:
        limit = self.value(od.MAX_PROFILE_SPEED)
        wanted = min(max(self.value(od.TARGET_SPEED), -limit), limit)
        acceleration = min(self.value(od.ACCELERATION), self.value(od.MAX_ACCELERATION))
        deceleration = min(self.value(od.DECELERATION), self.value(od.MAX_DECELERATION))
        self._speed = towards(self._speed, float(wanted), acceleration, deceleration, TICK_S)
        self.servo.speed(self._speed)
        self._judge(wanted)

    def _judge(self, wanted: int) -> None:
        actual = self.servo.measured_inc
        self._in_window_ms = self._in_window_ms + 1 if abs(wanted - actual) <= self.value(od.SPEED_WINDOW) else 0
        self._reached = self._in_window_ms > self.value(od.SPEED_TIME)
        self._still_ms = self._still_ms + 1 if abs(actual) <= self.value(od.SPEED_THRESHOLD) else 0
        self._still = self._still_ms > self.value(od.SPEED_THRESHOLD_TIME)

    def resume(self) -> None:
        self.halted, self.busy = False, True
        self._speed = self.servo.measured_inc

    def bits(self) -> int:
        return TARGET * self._reached | BIT12 * self._still


class HomingMode(Mode):
    code = 6
    follows = False

    def enter(self) -> None:
        super().enter()
        self._speed = 0.0
        self._begun = False

    def leave(self) -> None:
        super().leave()
        self.drive.homing.interrupt()
        self.drive.watch_switches()

    def control(self, word: int, before: int) -> None:
        homing = self.drive.homing
        if word & START and not before & START and not homing.running:
            self._begin()
        elif not word & START and homing.running:
            homing.interrupt()
            self.drive.watch_switches()

    def _begin(self) -> None:
        number = self.value(od.HOMING_METHOD)
        self.drive.place.homed, self._begun = False, True
        if number not in METHODS:
            self._fail()
            return
        self.drive.homing.begin(number, int(self.servo.counter_inc // 1.0))
        self._speed = self.servo.measured_inc
        self.drive.watch_switches()
        self.busy = True

    def edge(self, edge: Edge) -> None:
        homing = self.drive.homing
        homing.edge(edge)
        if homing.phase is Phase.FAILED:
            self._fail()
        self.drive.watch_switches()

    def _fail(self) -> None:
        self.drive.homing.phase = Phase.FAILED
        self.busy = True
        self.drive.homing_failed()

    def tick(self) -> None:
        homing = self.drive.homing
        top = self.value(od.HOMING_FAST if homing.fast else od.HOMING_SLOW)
        ramp = float(min(self.value(od.HOMING_ACCELERATION), self.value(od.MAX_ACCELERATION)))
        self._speed = towards(self._speed, float(homing.direction * top), ramp, ramp, TICK_S)
        if self._speed or homing.direction:
            self.servo.speed(self._speed)
            return
        if self.servo.mode != 1:
            if abs(self.servo.measured_inc) > max(self.value(od.SPEED_THRESHOLD), 1):
                self.servo.speed(0.0)
                return
            self.servo.hold()
        if homing.phase is Phase.STOPPING and homing.home is not None:
            self.drive.set_home(homing.home)
            homing.stopped()
        self.busy = False

    def halt(self) -> None:
        super().halt()
        self.drive.homing.interrupt()
        self.drive.watch_switches()

    def bits(self) -> int:
        still = TARGET * (not self.busy)
        match self.drive.homing.phase:
            case Phase.SWITCH | Phase.INDEX:
                return 0
            case Phase.STOPPING:
                return BIT12 if self.drive.homing.home is not None and not self._here else 0
            case Phase.FAILED:
                return BIT13 | still
            case Phase.INTERRUPTED:
                return still
        return (BIT12 if self.drive.place.homed else 0) | still

    @property
    def _here(self) -> bool:
        return self.value(od.HOMING_METHOD) in HERE

    @property
    def wants_index(self) -> bool:
        return self.drive.homing.wants_index or (self.value(od.HOMING_METHOD) in TO_INDEX and self.drive.homing.running)


class Cyclic(Mode):
    """Modes that read a set value with every SYNC."""

    synchronous = True

    def resume(self) -> None:
        self.halted = False  # the next SYNC continues

    def bits(self) -> int:
        return BIT12 * (not self.halted)


class InterpolatedPosition(Cyclic):
    """Linear interpolation, one data record a SYNC (60C0h = 0)."""

    code = 7

    def enter(self) -> None:
        super().enter()
        self.active = False

    def control(self, word: int, before: int) -> None:
        active = bool(word & START)
        if self.active and not active:
            self.servo.hold()
        self.active = active

    def sync(self, new: bool) -> None:
        if self.active and not self.halted:
            self.drive.follow(self.drive.clip(float(self.value(od.INTERPOLATED))), self.drive.period_ns, 0.0)

    def bits(self) -> int:
        reached = abs(self.value(od.INTERPOLATED) - self.drive.position) <= self.value(od.POSITION_WINDOW)
        return BIT12 * (self.active and not self.halted) | TARGET * (reached and self.active)


class CyclicPosition(Cyclic):
    code = 8

    def enter(self) -> None:
        super().enter()
        self._goal: float | None = None  # of the SYNC before

    def sync(self, new: bool) -> None:
        if not self.halted:
            goal, offset = self.drive.clip(self.value(od.TARGET_POSITION)), self.value(od.SPEED_OFFSET)
            own = (goal - self._goal) * 1e9 / self.drive.period_ns * self.drive.own_feed_forward if self._goal is not None else 0.0
            self._goal = goal
            self.drive.follow(goal, self.drive.period_ns, offset + own)

    def bits(self) -> int:
        return BIT12 * (not self.halted) | BIT13 * self.drive.following_error_active


class CyclicVelocity(Cyclic):
    code = 9
    follows = False

    def enter(self) -> None:
        super().enter()
        self._speed = self.servo.measured_inc

    def sync(self, new: bool) -> None:
        if self.halted:
            return
        limit = self.value(od.MAX_PROFILE_SPEED)
        wanted = float(min(max(self.value(od.TARGET_SPEED) + self.value(od.SPEED_OFFSET), -limit), limit))
        ramps = self.value(od.MAX_ACCELERATION), self.value(od.MAX_DECELERATION)
        self._speed = towards(self._speed, wanted, *ramps, self.drive.period_ns * 1e-9)
        self.servo.speed(self._speed)

    def resume(self) -> None:
        super().resume()
        self._speed = self.servo.measured_inc


class CyclicTorque(Cyclic):
    code = 10
    follows = False

    def sync(self, new: bool) -> None:
        if not self.halted:
            self.servo.torque(self.value(od.TARGET_TORQUE) * 1e-3 * self.servo.settings.rated_torque_nm)


MODES: tuple[type[Mode], ...] = (
    *(Mode, ProfilePosition, ProfileVelocity, HomingMode),
    *(InterpolatedPosition, CyclicPosition, CyclicVelocity, CyclicTorque),
)
CODES = frozenset(mode.code for mode in MODES)
