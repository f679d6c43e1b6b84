"""Neutral blocks: what an interpreter, a position table or the text form passes to the planner.  Frozen data in SI units.

A block is one move from where the one before it ends.  Its `blend` defines how its own end point is passed; `leave` lies before the point
on this block, `reach` after it on the next.  What each of the three controls means by its words is decided where those words are known
(motion.program.passing, motion.program.reis, motion.val3); here everything is a number with a unit.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from motion.geometry.conventions import Convention
from motion.geometry.frames import IDENTITY, Pose, Vector
from motion.kinematics.base import FREE, Configuration
from motion.outputs.function import Function
from motion.rho3.wc import WcFrame

MAX_JOINTS = 24  # 6 of the arm, additional axes 7 .. 24


class Interpolation(Enum):
    """The way to the target."""

    PTP = "ptp"  # straight in the axes, all end together
    LINEAR = "linear"
    CIRCULAR = "circular"  # through `via`
    SPLINE = "spline"  # one curve through a row of such blocks


class Turning(Enum):
    """How the orientation goes along an arc."""

    LEAST = "least"  # least rotation from start to end: Reis ZIRK_MIN_ORI
    PATH = "path"  # fixed to the moving frame of the arc: Reis ZIRK_BAHN_ORI
    VIA = "via"  # start, via, end: VAL 3 movec


class Slope(Enum):
    """rho 3: whether the sequence keeps its speed (program) or each block has its own ramps and starts early (block)."""

    PROGRAM = "program"
    BLOCK = "block"


class Shape(Enum):
    """How the speed of a block from rest to rest goes up and down (AX-575)."""

    ROBOT = "robot"  # the robot's default
    JERK = "jerk"  # jerk-limited, the quickest
    SIN2 = "sin2"  # rho 3 `Sinus*2-slope`: the acceleration is a sine square of the time


class Rounding(Enum):
    """What kind of curve rounds the end point."""

    OFF = "off"  # exact stop
    CARTESIAN = "cartesian"  # path of the TCP
    JOINT = "joint"  # path of the axes


@dataclass(frozen=True, slots=True)
class Blend:
    """How the end of a block is passed.  m; leave and reach 0 with distance 0 and axes empty: exactly through the point."""

    rounding: Rounding = Rounding.OFF
    leave: float = 0.0  # before the point; rho 3 R and BAHN_RADIUS: leave = reach
    reach: float = 0.0  # after the point
    distance: float = 0.0  # > 0: the corner is missed by this much, leave and reach follow from it (BAHN_DISTANZ has priority)
    axes: tuple[float, ...] = ()  # PTP by the axis criterion (P213 x R_PTP): m or rad per axis
    share: float = 0.5  # the most of a block that one corner may use: rho 3 0.5, Reis 0.4 (RAPPR_FACT_MAX)
    past_circles: bool = False  # VAL 3 and Reis round corners next to arcs, the rho 3 never does (L1906-1908)
    flyby: float | None = None  # share of the mean of both path speeds at the middle of the corner (_IV_FLYBY_S)


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast.  Shares are of each axis' limit and may exceed 1 where a control allows it; the limits themselves are never
    exceeded.  None: no demand beyond the limits."""

    speed: float = 1.0  # share of the axis speeds
    accel: float = 1.0  # share of the axis accelerations, speeding up
    decel: float = 1.0  # slowing down
    path_speed: float | None = None  # m/s of the TCP
    turn_speed: float | None = None  # rad/s of the tool
    path_accel: float | None = None  # m/s2 along the path, speeding up
    path_decel: float | None = None
    time: float | None = None  # s for the entire block, overrides every speed (BAHN_ZEIT)
    ramp: float = 0.25  # share of `time` for speeding up, and again for slowing down (_IACC_TIME)
    lead: bool = False  # PTP: `speed` is that of the axis with the largest travel (Reis), the others follow


@dataclass(frozen=True, slots=True)
class JointTarget:
    """Axis positions: m or rad, arm axes first, then additional axes."""

    q: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PoseTarget:
    """Where the tool goes in the block's frame; extra: additional axes (m or rad), empty: they stay."""

    pose: Pose
    configuration: Configuration = FREE
    extra: tuple[float, ...] = ()


Target = JointTarget | PoseTarget
MEASURED = JointTarget(())  # @MPOS: where the axes were at the edge of the last measurement
UNKNOWN = JointTarget((math.nan,))  # of a block with a shift or a file: known where it begins, and nothing can be run to it before


@dataclass(frozen=True, slots=True)
class Shift:
    """MOVE_REL of the rho 3: the target is relative to the end of the previous block; numbers are added to numbers (AX-567).  values: of
    each axis (m or rad), or with `angles` x, y, z (m) and three angles (rad) of the tool in the block's frame.  extra: of additional axes
    that accompany a pose (m or rad), empty: they stay.
    """

    values: tuple[float, ...]
    angles: Convention | None = None
    extra: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Tool:
    """Flange -> tool centre point."""

    name: str = ""
    pose: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class Frame:
    """Base of the robot -> user frame."""

    name: str = ""
    pose: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class Output:
    """A signal that changes with the path: so far before the end of the block (m, or rad where only the orientation turns)."""

    number: int
    value: float
    before: float = 0.0


@dataclass(frozen=True, slots=True)
class Until:
    """MOVE UNTIL: the block ends early when this input has the value.  channel: a measuring input by its number (rho 3: 6x0 probe, 6xy
    high-speed input), 0: the RC input `number`; error: label at which the program continues when the input never had it, empty: at the
    next block; within: s of movement after which the block ends without it (MAX_TIME), None: at its target alone.
    """

    number: int
    value: bool = True
    channel: int = 0
    error: str = ""
    within: float | None = None


@dataclass(frozen=True, slots=True)
class StartWait:
    """Fast start-off, WAIT UNTIL directly before the movement: it begins when the input has the value, `delay` (s, MAX_TIME) later.
    channel: a high-speed input 6xy, 0: the RC input `number`."""

    number: int
    value: bool = True
    channel: int = 0
    delay: float = 0.0


@dataclass(frozen=True, slots=True)
class Flying:
    """Flying measurement where the block begins, without a stop: rho 3 SF 43 MEASURE_ON with its edge, SF 44 MEASURE_OFF (None)."""

    channel: int  # probe 6x0
    edge: bool | None = True
    member: int = 0  # whose, of several kinematics: its place among them, from 0


@dataclass(frozen=True, slots=True)
class Latching:
    """setLatch of VAL 3 where the block begins: the next rising edge of fIn0 or fIn1 stores where the axes are."""

    name: str
    member: int = 0  # as of Flying


@dataclass(frozen=True, slots=True)
class Recording:
    """Reference path where the block begins: rho 3 SF 29 (a mark each `distance` of system `system`, in m, rad or cycles of P5:
    `unit`), SF 30 (system 0).  member: whose path, of several kinematics: its place among them, from 0."""

    system: int = 0
    distance: float = 0.0
    unit: str = "mm"
    member: int = 0


Called = Function | Flying | Latching | Recording


@dataclass(frozen=True, slots=True)
class Synchron:
    """A belt-synchronous part (rho 3 SYNCHRON .. SYNCHRON_END): its blocks all hold this one.  at: belt value (m or rad) it begins
    at, None: at once; number: of the part in its program, so that two parts on one belt stay two."""

    belt: str
    at: float | None = None
    number: int = 0


@dataclass(frozen=True, slots=True)
class OnBelt:
    """Belt value (m or rad of the counter) a block ends at, or is meant for; first, third: sections of the cam as belt paths."""

    value: float
    first: float = 0.0
    third: float = 0.0


@dataclass(frozen=True, slots=True)
class Alteration:
    """An alterable part (VAL 3 alterBegin .. alterEnd): its blocks all hold this one.  reference: the tool or frame whose coordinates a
    correction has; speed, accel, decel: shares of the axis limits, path, turn: m/s and rad/s the altered path may have; until: the part
    stays alterable at the end of its path until this input has the value; number: of the part in its program."""

    reference: Tool | Frame
    speed: float = 1.0
    path: float = 9.999
    turn: float = math.radians(9999.0)
    accel: float = 1.0
    decel: float = 1.0
    until: Until | None = None
    number: int = 0


@dataclass(frozen=True, slots=True)
class Sync:
    """SYNC of the rho 3: the program waits until the belt's counter is at least (else at most) `limit` (m or rad), or the RC input has
    its level; then the counter gets its reset value.  inside: it is in a synchronous part."""

    belt: str
    limit: float = 0.0
    at_least: bool = True
    input: int | None = None
    level: bool = True
    inside: bool = False


@dataclass(frozen=True, slots=True)
class BeltCall:
    """Special functions of the rho 3 for belts: 15 BELT_PARAM, 21 BELT_TYPE, 28 SET_BELTCNT.  belt: from 1; values: in the manual's order
    and units (mm or deg, per s, ms)."""

    function: int
    belt: int
    values: tuple[float, ...]
    inside: bool = False


BeltAct = Sync | BeltCall


@dataclass(frozen=True, slots=True)
class MachinePoint:
    """SF 3 MACH_POS of the rho 3: the axes are at these places (m or rad) from here on."""

    q: tuple[float, ...]
    inside: bool = False
    member: int = 0  # whose, of several kinematics: its place among them, from 0


Act = BeltAct | MachinePoint


@dataclass(frozen=True, slots=True)
class FileCall:
    """MOVE_FILE of the rho 3 (SF 45): the points of a BNR file are the set values.  base: 1 interpolation, 2 position-controller cycles;
    modulo: @MODULO_FLAG of each axis, None: not set; offset: read marker of READ_BEGIN, None: the file is not open."""

    name: str
    base: int
    modulo: tuple[float | None, ...] = ()
    offset: int | None = None


@dataclass(frozen=True, slots=True)
class Curving:
    """Spline and orientation weights, 0 .. 1 (Reis _ISPL_TENS, _IORI_TENS, _IORI_WEIGHT, _IORI_CIRCHP).  tube: m, largest deviation of a
    spline from the straight line to this point, which it may then miss; 0: it meets the point.
    """

    tension: float = 1.0
    orientation_tension: float = 1.0
    weight: float = 1.0
    via_weight: float = 1.0
    tube: float = 0.0


@dataclass(frozen=True, slots=True)
class Block:
    """One move; see the module."""

    kind: Interpolation
    target: Target
    via: PoseTarget | None = None  # CIRCULAR
    pace: Pace = Pace()
    blend: Blend = Blend()
    tool: Tool = Tool()
    frame: Frame = Frame()
    turning: Turning = Turning.VIA
    slope: Slope = Slope.PROGRAM
    shape: Shape = Shape.ROBOT
    curving: Curving = Curving()
    outputs: tuple[Output, ...] = ()
    functions: tuple[Called, ...] = ()
    carried: tuple[Called | Output, ...] = ()  # of blocks before it that have no way: done where this one begins
    until: Until | None = None
    wait: StartWait | None = None
    synchron: Synchron | None = None
    on_belt: OnBelt | None = None
    alteration: Alteration | None = None
    angle: float | None = None  # CIRCULAR, rad: the circle through via and target is run so far, and beyond the target
    rise: float = 0.0  # with angle: m along the axis over the full angle, a helix
    lowest: Vector | None = None  # LIMIT_MIN: x, y, z (m) in the block's frame below which the tool is nowhere
    highest: Vector | None = None  # LIMIT_MAX
    shift: Shift | None = None  # PTP and LINEAR: the target is relative, and `target` UNKNOWN
    file: FileCall | None = None  # the way is that of a file, and `target` UNKNOWN
    freeze: bool = False  # in an alterable part: from the end of this block on the correction stays as it is (alterEnd before the end)
    recorded: int = 0  # the target is this entry of the reference path, and `target` UNKNOWN
    otherwise: str = ""  # of a block to @MPOS or an entry: label at which to continue if nothing was measured or stored
    ahead: int = 0  # most blocks prepared after the current one: BLOCK_SEARCH (rho 3 SF 46), 0: all known ones
    system: WcFrame | None = None  # WC_SYSTEM its poses are in, None: the one in force (motion.program.systems)
    label: str = ""  # before it
    acts: tuple[Act, ...] = ()  # of belts, done at rest before it
    line: int = field(default=0, compare=False)  # of the program text; 0: none

    @property
    def goes_on_at(self) -> str:
        """Label where its input never came, or what it goes to was not measured or stored; none: empty."""
        return self.otherwise or (self.until.error if self.until is not None else "")

    @property
    def unmet(self) -> bool:
        """It goes to @MPOS or an entry of the reference path: where that is, shows when it begins."""
        return self.recorded != 0 or self.target == MEASURED

    @property
    def measures(self) -> bool:
        """Return whether @MPOS may change with this block."""
        calls = self.functions
        return self.until is not None or any(isinstance(c, Latching) or (isinstance(c, Flying) and c.edge is not None) for c in calls)


@dataclass(frozen=True, slots=True)
class Program:
    """Blocks in order, and where the axes are before the first one."""

    name: str
    robot: str  # name of a robot file
    start: tuple[float, ...]  # m or rad
    blocks: tuple[Block, ...]
    units: tuple[str, ...] = ()  # outside units of the axes, "mm" or "deg"; empty: all deg
    acts: tuple[Act, ...] = ()  # after the last block
    system: WcFrame | None = None  # WC_SYSTEM after it


Part = TypeVar("Part")


def changed(part: Part, values: Mapping[str, object]) -> Part:
    """A copy of a frozen part with these fields changed, for callers that know them only by their names."""
    fields: Sequence[str] = getattr(part, "__slots__", ())
    if unknown := values.keys() - set(fields):
        raise AttributeError(f"{type(part).__name__} has no field {min(unknown)}")
    made = object.__new__(type(part))
    for name in fields:
        object.__setattr__(made, name, values[name] if name in values else getattr(part, name))
    return made
