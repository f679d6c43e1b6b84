"""Motion of an emulated CiA 402 drive as its mode requests: following, limits, switches, windows, times.

The power stage around it is cia402_axis.
"""

from math import inf

from drivers.emulator.canopen.node import CanopenNode
from drivers.emulator.canopen.objects import Objects
from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.errors import KINDS, Error
from drivers.emulator.cia402.states import State
from drivers.emulator.cia402.switches import Edge, Signal
from drivers.emulator.cia402.view import DriveView, wrap
from drivers.emulator.servo.model import INC_PER_RAD
from drivers.emulator.servo.settings import DriveSettings
from protocols.base.machine import Ns
from protocols.canopen.types import Value


class DriveMotion(DriveView):
    """`now`: the bus time reached."""

    def __init__(self, settings: DriveSettings, cycle_ns: Ns, seed: int, objects: Objects, node: CanopenNode, substeps: int) -> None:
        super().__init__(settings, cycle_ns, seed, objects, substeps)
        self.node = node
        self.now: Ns = 0
        self._cycle_ns = cycle_ns

    # -- limits and times -------------------------------------------------------------------------

    def _limits(self) -> None:
        self.servo.limit_torque(self.value(od.MAX_TORQUE) * 1e-3 * self.settings.servo.rated_torque_nm)
        self.soft_limits.load(self.value(od.LIMIT_MIN), self.value(od.LIMIT_MAX))
        self._window()

    def _timing(self) -> None:
        """Period of SYNC: interpolation time period, else communication cycle period, else the bus' nominal one (AX-287)."""
        watch, own = self.sync_watch, self.value(od.PERIOD_VALUE)
        period = round(own * 10.0 ** (self.value(od.PERIOD_EXPONENT) + 9)) if own else self.value(od.CYCLE_PERIOD) * 1000
        watch.period = period if period >= 100_000 else self._cycle_ns
        watch.tolerance = self.value(od.SYNC_TOLERANCE) * 1000 or watch.period // 4
        watch.unlock()

    def _probe_written(self, value: Value) -> None:
        for edge in self.switches.crossed(self.servo):  # since the model's last tick, before another window is watched
            self._edge(edge)
        self.probe.arm(int(value) if isinstance(value, int) else 0)
        self.watch_switches()

    def _window(self) -> None:
        """Following error is supervised in position control with power, unless the object switches that off."""
        window = self.value(od.FOLLOWING_WINDOW)
        on = self.state is State.ENABLED and self.mode.follows and not self.stop.active and window != 0xFFFFFFFF
        self.servo.following_window(float(window) if on and self._follow_since is None else inf)
        if not on:
            self._follow_since = None

    # -- motion, requested by the mode ------------------------------------------------------------

    def follow(self, position: float, duration_ns: int, speed: float) -> None:
        """To this position in this time; INTEGER32 set values count on through their wrap."""
        servo = self.servo
        goal = position - self.place.shift
        last = servo.goal_inc
        away = goal - last
        if not -0x80000000 <= away < 0x80000000:
            goal = last + wrap(away)
        servo.follow(goal, self.place.rest_ns, duration_ns, speed / INC_PER_RAD)

    def clip(self, position: float) -> float:
        return self.soft_limits.clip(position)

    def set_home(self, counter: int) -> None:
        """The user position at `counter` is the home offset (AX-288)."""
        self.place.home(counter, self.value(od.HOME_OFFSET))

    def homing_failed(self) -> None:
        self.node.emergencies.raise_(Error.HOMING, KINDS[Error.HOMING], self.now)
        self.node.emergencies.clear([Error.HOMING], self.now)

    def watch_switches(self) -> None:
        self.switches.index_wanted = self.homing.wants_index or self.probe.wants_index
        self.switches.look_around(self.servo)

    def _edge(self, edge: Edge) -> None:
        self.probe.edge(edge, self.place.shift)
        if self.state is State.ENABLED:
            self.mode.edge(edge)
        if edge.signal in (Signal.NEGATIVE_LIMIT, Signal.POSITIVE_LIMIT):
            self._block()

    def _block(self) -> None:
        """A limit switch stops the motion towards it, except while a homing looks for it."""
        inputs = self.switches.inputs(self.servo.position_rad)
        free = self.homing.running or not inputs & 3 or inputs & 3 == 3
        self.servo.block(0 if free else -1 if inputs & 1 else 1)
