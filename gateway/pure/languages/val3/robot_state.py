"""State of the robot and its operator in a virtual run: mode, power, speed, safety, watchdog.  Source: VAL 3 reference 5.10 and 8."""

from dataclasses import dataclass, field

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.errors import Rte

MANUAL, TEST, LOCAL, REMOTE = 1, 2, 3, 4
SAFE_RESTART, SS1, SS2 = 1, 2, 3  # esStatus (L4246-4257)
POWER_UP_NS: Ns = 0
NO_DATA = -14  # brakeTest: its data are missing


@dataclass(slots=True)
class Service:
    """Answers of the drives and the safety board (AX-1061).  brakes: of each axis, a code below 0 for the entire test, none: all hold."""

    brakes: tuple[int, ...] = ()
    brake_position: tuple[float, ...] = ()  # in which brakeTest is made; none: in any
    hibernate: int = -1
    wake: int = 0


@dataclass(slots=True)
class RobotState:
    """As the operator and the safety board have it.  version: of the system."""

    mode: int = REMOTE
    powered: bool = True
    speed: float = 100.0
    speed_by_operator: bool = False
    estop: int = 0  # esStatus
    hold: bool = False
    language: str = "english"
    profile: str = "default"
    version: str = "s8.0cs9_B587"
    arm_type: str = "virtual"
    watchdog_ns: Ns = 0  # 0: none
    watchdog_until: Ns | None = None
    watchdog_broken: bool = False
    watchdog_stop: bool = False  # estop is that of the watchdog, which its next refresh clears
    components: dict[str, str] = field(default_factory=dict)
    service: Service = field(default_factory=Service)
    reboot: bool = False  # an overrun of the synchro task: power only after a new start of the controller

    @property
    def moving_allowed(self) -> bool:
        """Power is on, nothing holds."""
        return self.powered and self.estop == 0 and not self.hold

    def stop(self, code: int) -> None:
        """The safety chain: 0 is closed again, then a safe restart is waited for; 1 or 2 opens it (SS1), 3 holds under power (SS2)."""
        if code == 0:
            self.estop = SAFE_RESTART if self.estop == SS1 else 0
            return
        self.estop, self.watchdog_stop = SS2 if code == SS2 else SS1, False
        if self.estop == SS1:
            self.powered = False

    def restart(self) -> None:
        """setSafetyRestart: stop waiting for a safe restart."""
        if self.estop == SAFE_RESTART:
            self.estop = 0

    def overrun(self) -> None:
        """The synchro task was late: the robot stops, and has no power until the controller begins anew (L3460)."""
        self.reboot, self.powered = True, False

    def switch(self, on: bool) -> None:
        """The operator switches the power; off remains off while the safety chain is open."""
        if on and not self.reboot and self.estop in (0, SAFE_RESTART) and self.guarded and not self.watchdog_broken:
            self.estop, self.powered = 0, True
        elif not on:
            self.powered = False

    def refresh_watchdog(self, now: Ns) -> bool:
        """Whether it was active; 45 where there is none, and power stays off then."""
        if self.watchdog_ns <= 0:
            self.watchdog_broken, self.powered = True, False
            raise Rte(45)
        active = self.watchdog_until is not None and now < self.watchdog_until
        if self.watchdog_stop:
            self.estop, self.watchdog_stop = 0, False
        self.watchdog_until = now + self.watchdog_ns
        return active

    def tick(self, now: Ns) -> None:
        """An expired watchdog stops the robot; without power, too, it is not active any more."""
        if self.watchdog_until is not None and now >= self.watchdog_until:
            self.watchdog_until = None
            if self.powered:
                self.estop, self.powered, self.watchdog_stop = SS1, False, True

    @property
    def guarded(self) -> bool:
        """Power can be switched on: the watchdog is active, or there is none (L3555)."""
        return self.watchdog_ns <= 0 or self.watchdog_until is not None

    def enable(self) -> bool:
        """enablePower: only in remote mode."""
        if self.mode != REMOTE or self.estop not in (0, SAFE_RESTART) or self.watchdog_broken or self.reboot:
            return False
        if not self.guarded:
            return False
        self.estop, self.powered = 0, True
        return True

    def disable(self) -> None:
        """disablePower."""
        self.powered = False

    def set_speed(self, speed: float) -> int:
        """setMonitorSpeed: 0, -1, -2, -3."""
        if not 0 <= speed <= 100:
            return -3
        if speed > self.speed:
            if self.mode != REMOTE:
                return -1
            if self.speed_by_operator:
                return -2
        self.speed = speed
        return 0
