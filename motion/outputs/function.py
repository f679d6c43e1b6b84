"""IO logic and PPO as a program calls them (rho 3 SF 1 IOL, SF 2 PPO, L4216-4229)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Function:
    """Called where its block begins: function number (negative: reset), kinematic, coordinate 1.. of the workpiece point, position (mm or
    deg), parameter value, time offset in ms; system: the workpiece system (mm, deg) the coordinate is of."""

    ppo: bool
    number: int
    kinematic: int
    coordinate: int
    position: float
    value: float
    time_ms: int = 0
    system: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
