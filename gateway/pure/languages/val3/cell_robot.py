"""The robot and its operator in a cell: power, safety chain, speed are the cell's; what an application switches goes to the services."""

from collections.abc import Callable
from dataclasses import dataclass

from gateway.pure.image.records.cell import Motion
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.robot_state import REMOTE, RobotState

OPEN = 2  # esStatus: the chain is open


@dataclass(eq=False)
class CellRobot(RobotState):
    """axes: of the robot (bit n-1 = axis n of the cell)."""

    port: Port | None = None
    axes: int = 0
    held: bool = False  # no other command source has control
    button: bool = False  # hold, as set by the PLC or a tool
    dead_watch: bool = False  # the watchdog has expired, and was not refreshed since
    unguarded: bool = False  # power was switched on without an active watchdog
    said: Callable[[str], object] = str  # what a person has to know
    _before: bool = False

    def look(self) -> None:
        """The cell in a new turn."""
        assert self.port is not None
        view = self.port.view
        on = self.held and self.axes & ~view.enabled == 0
        if on and not self._before and not self.guarded:  # by a tool, a page or the PLC: off again (L3555)
            self.unguarded = True
            self._power(on=False)
            self.said("the power is switched off again: the watchdog of the application is not active")
        self.unguarded = self.unguarded and on
        self._before = on
        self.powered = on and not (self.watchdog_broken or self.reboot or self.dead_watch or self.unguarded)
        self.estop = OPEN if not view.chain or self.dead_watch else 0
        self.speed = 100.0 * view.override
        self.hold = self.button or view.motion is Motion.STOPPED

    def _power(self, *, on: bool) -> None:
        assert self.port is not None
        self.port.send("power", on=on)

    def enable(self) -> bool:
        """enablePower: only in remote mode; the drives need their time."""
        if self.mode != REMOTE or (self.estop == OPEN and not self.dead_watch) or self.watchdog_broken or self.reboot:
            return False
        if not self.guarded:
            return False
        self._power(on=True)
        return True

    def disable(self) -> None:
        """disablePower."""
        self._power(on=False)

    def overrun(self) -> None:
        """The arm stops and loses its power."""
        if not self.reboot:
            self._power(on=False)
        super().overrun()

    def tick(self, now: Ns) -> None:
        """An expired watchdog stops the robot."""
        before = self.powered
        super().tick(now)
        if before and not self.powered:
            self.dead_watch = True
            self._power(on=False)

    def refresh_watchdog(self, now: Ns) -> bool:
        """As in a virtual run; a broken watchdog switches the power off."""
        before = self.watchdog_broken
        try:
            active = super().refresh_watchdog(now)
        finally:
            if self.watchdog_broken and not before:
                self._power(on=False)
        if not active:
            self.dead_watch = False
        return active

    def set_speed(self, speed: float) -> int:
        """setMonitorSpeed: 0, -1, -2, -3."""
        assert self.port is not None
        code = super().set_speed(speed)
        if code == 0:
            self.port.send("speed", value=speed / 100.0)
        return code
