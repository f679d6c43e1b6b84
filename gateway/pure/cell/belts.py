"""[[belt]] of the cell file, and [plant.belt.NAME]: conveyors and round tables a program can run with (docs/guide/belts.md)."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Belt:
    """[[belt]]: number 1.. by its place in the file (P501 = how many); lengths in `unit`."""

    name: str
    increment: float  # unit of one increment; negative: counts the other way
    unit: str = "mm"  # mm | deg
    bus: str = ""  # drive bus its encoder is on; empty: simulated alone (P508)
    id: int = 0  # CAN identifier of the encoder's telegram
    byte: int = 0  # first byte of the count, low byte first
    bytes: int = 4  # 2 | 4
    type: int = 1  # 1 parallel, 2 without parallel axis, 3 cam (SF 21)
    tolerance: int = 5  # interpolation cycles of belt way, types 2 and 3
    factors: tuple[float, ...] = (1.0, 0.0, 0.0)  # P503: way of x, y, z for one of the belt
    axis: str = ""  # instead of x, y, z: the endless axis parallel to the belt (type 1)
    factor: float = 1.0  # P503 of that axis: its way in its unit for one of the belt
    simulated: float = 0.0  # P508, unit/s: while RC input 399 is 1
    v_stop: float | None = None  # SF 15, unit/s; None: 0.005 mm in each cycle
    v_run: float | None = None
    patience_ms: int = 0
    accel: float = 2000.0  # with which the robot catches up, unit/s2
    jerk: float = 20000.0
    robot: tuple[str, ...] = ()  # who follows it, by the names of [[robot]]; empty: the only one
    factors_of: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # P503 of robots that stand otherwise to it


@dataclass(frozen=True, slots=True)
class Measuring:
    """[[measuring]]: a measuring input of programs by its number of the rho 3: 6x0 probe of board x, 6xy its y-th high-speed input."""

    channel: int
    input: int = -1  # RC input its wire comes to; -1: none, drives measure
    axes: tuple[str, ...] = ()  # on the board; empty: all of its robots
    drives: tuple[str, ...] = ()  # axes whose CiA 402 drives catch the edge by their touch probe
    probe: int = 1  # of those drives: 1 | 2
    robot: tuple[str, ...] = ()  # whose programs use it; empty: the only one
    latch: str = ""  # fIn0 | fIn1: it is this fast input of VAL 3


@dataclass(frozen=True, slots=True)
class PathOutput:
    """[[path_output]]: IO logic (SF 1) or PPO (SF 2) of programs, and where its value stands in the image."""

    kind: str  # iol | ppo
    function: int  # 1..; a PPO from 201 on is analog
    output: int  # RC output; of a PPO the first bit of its byte or word
    bits: int = 16  # of a PPO: 8 | 16, two's complement
    rated: float = 0.0  # P405 of an analog output: the value at `volts`
    volts: float = 10.0  # 10 | 13.3
    robot: tuple[str, ...] = ()  # whose coordinates lead it: one; empty: the only one


@dataclass(frozen=True, slots=True)
class PlantBelt:
    """[plant.belt.NAME]: the emulated belt and its encoder."""

    speed: float = 0.0  # unit/s, from the start on
    accel: float = 1000.0  # unit/s2, when a command changes its speed
