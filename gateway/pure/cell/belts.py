"""[[belt]] of the cell file, and [plant.belt.NAME]: conveyors and round tables a program can run with (docs/guide/belts.md)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, MaxLen, MinLen

from gateway.pure.cell.marks import Name, OneRobot, Robots, Unit

U, PER_S, PER_S2, PER_S3 = (Unit(text) for text in ("mm or deg", "mm/s or deg/s", "mm/s2 or deg/s2", "mm/s3 or deg/s3"))
Factors = Annotated[tuple[float, ...], MinLen(3), MaxLen(3)]


@dataclass(frozen=True, slots=True)
class Belt:
    """[[belt]]: number 1.. by its place in the file (P501 = how many); lengths in `unit`."""

    name: Name
    increment: Annotated[float, Ge(-100.0), Le(100.0), U]  # unit of one increment; negative: counts the other way
    unit: Literal["mm", "deg"] = "mm"
    bus: str = ""  # drive bus its encoder is on; empty: simulated alone (P508)
    id: Annotated[int, Ge(0), Le(0x7FF)] = 0  # CAN identifier of the encoder's telegram
    byte: Annotated[int, Ge(0), Le(7)] = 0  # first byte of the count, low byte first
    bytes: Literal[2, 4] = 4
    type: Literal[1, 2, 3] = 1  # 1 parallel, 2 without parallel axis, 3 cam (SF 21)
    tolerance: Annotated[int, Ge(1), Le(12), Unit("interpolation cycles")] = 5  # interpolation cycles of belt way, types 2 and 3
    factors: Factors = (1.0, 0.0, 0.0)  # P503: way of x, y, z for one of the belt
    axis: str = ""  # instead of x, y, z: the endless axis parallel to the belt (type 1)
    # P503 of that axis: its way in its unit for one of the belt
    factor: Annotated[float, Ge(-1e6), Le(1e6), Unit("unit of the axis for one of the belt")] = 1.0
    simulated: Annotated[float, Ge(-10000.0), Le(10000.0), PER_S] = 0.0  # P508, unit/s: while RC input 399 is 1
    v_stop: Annotated[float | None, Ge(0.0), Le(10000.0), PER_S] = None  # SF 15, unit/s; None: 0.005 mm in each cycle
    v_run: Annotated[float | None, Ge(0.0), Le(10000.0), PER_S] = None
    patience_ms: Annotated[int, Ge(0), Le(60000), Unit("ms")] = 0
    accel: Annotated[float, Gt(0.0), Le(1e6), PER_S2] = 2000.0  # with which the robot catches up, unit/s2
    jerk: Annotated[float, Gt(0.0), Le(1e9), PER_S3] = 20000.0
    robot: Robots = ()  # who follows it, by the names of [[robot]]; empty: the only one
    factors_of: Mapping[str, Factors] = field(default_factory=dict)  # P503 of robots with another orientation to it


@dataclass(frozen=True, slots=True)
class Measuring:
    """[[measuring]]: a measuring input of programs by its number of the rho 3: 6x0 probe of board x, 6xy its y-th high-speed input."""

    channel: Annotated[int, Ge(610), Le(699)]
    input: Annotated[int, Ge(-1), Le(1023)] = -1  # RC input it is wired to; -1: none, drives measure
    axes: tuple[str, ...] = ()  # on the board; empty: all of its robots
    drives: tuple[str, ...] = ()  # axes whose CiA 402 drives catch the edge by their touch probe
    probe: Literal[1, 2] = 1  # of those drives: 1 | 2
    robot: Robots = ()  # whose programs use it; empty: the only one
    latch: Literal["", "fIn0", "fIn1"] = ""  # fIn0 | fIn1: it is this fast input of VAL 3


@dataclass(frozen=True, slots=True)
class PathOutput:
    """[[path_output]]: IO logic (SF 1) or PPO (SF 2) of programs, and the address of its value in the image."""

    kind: Literal["iol", "ppo"]
    function: Annotated[int, Ge(1), Le(299)]  # 1..; a PPO from 201 on is analog
    output: Annotated[int, Ge(0), Le(1023)]  # RC output; of a PPO the first bit of its byte or word
    bits: Literal[8, 16] = 16  # of a PPO: 8 | 16, two's complement
    rated: Annotated[float, Ge(0.0), Le(1e6)] = 0.0  # P405 of an analog output: the value at `volts`
    volts: Annotated[float, Ge(10.0), Le(13.3), Unit("V")] = 10.0  # 10 | 13.3
    robot: OneRobot = ()  # whose coordinates lead it: one; empty: the only one


@dataclass(frozen=True, slots=True)
class PlantBelt:
    """[plant.belt.NAME]: the emulated belt and its encoder."""

    speed: Annotated[float, Ge(-10000.0), Le(10000.0), PER_S] = 0.0  # unit/s, from the start on
    accel: Annotated[float, Gt(0.0), Le(1e6), PER_S2] = 1000.0  # unit/s2, when a command changes its speed
