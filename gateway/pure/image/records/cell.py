"""Layouts of the records that the processes exchange through regions and rings (design: sections 4 to 6).

All plain structs in native byte order: both sides run on one machine, and the layout string goes into the region's hash.
"""

import functools
import operator
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from enum import IntEnum, IntFlag
from operator import attrgetter
from typing import Annotated

from gateway.pure.image.records.layout import F64, I64, U8, U16, U32, U64, Code, Layout
from motion.execution.pieces import MAX_AXES

MOST_AXES = MAX_AXES  # of one cell (AX-572)
EVERY_AXIS = (1 << MOST_AXES) - 1
RC_BYTES = 128  # PIC image: 1024 bits (rho3 0.2)
NEVER = 0  # a stamp that means: not yet
SPARE = 7  # bytes after a lane: they make it as long as two axes and a byte


class Motion(IntEnum):
    """What the cell's set values do."""

    IDLE = 0  # at rest, nothing left to do
    RUNNING = 1
    STOPPING = 2  # braking on the path
    STOPPED = 3  # at rest on the path, a rest of the move is left
    REFERENCING = 4


class Permit(IntFlag):
    """Enabling inputs as the cycle judges them (AX-002); a missing one counts as not set."""

    CHAIN = 1  # emergency-stop chain closed
    CONTROL = 2
    FEED = 4
    RUN = 8  # feed hold not
    TRAVEL = 16


ALL_PERMITS = Permit(31)


class AxisFlag(IntFlag):
    """Bits of one axis in the axes region."""

    ENABLED = 1
    REFERENCED = 2
    IN_POSITION = 4
    FAULT = 8
    LOST = 16  # no telegram from the drive
    HOMING = 32
    WARNING = 64
    ON = 128  # we ask for it to be on
    UNCONFIGURED = 256  # the drive has not been started up by the master yet: it cannot be switched on


OneByteBool = Annotated[bool, Code("B", bool)]
FLAGS = tuple(AxisFlag(bits) for bits in range(1 << len(AxisFlag)))  # arithmetic of enum flags costs microseconds, a table nothing


@dataclass(slots=True)
class AxisState:
    """One axis as the cycle sees it; rad or m, rad/s or m/s, torque as a share of rated."""

    actual: F64 = 0.0
    set: F64 = 0.0
    speed: F64 = 0.0
    lag: F64 = 0.0
    torque: F64 = 0.0
    flags: Annotated[AxisFlag, Code("H", FLAGS.__getitem__)] = AxisFlag(0)
    fault_code: U16 = 0
    power: U8 = 0
    finding: U16 = 0  # 647, 648 (drivers.drives.tracking), 0: none
    measured: F64 = 0.0  # @MPOS, where measured_mask has the axis


@dataclass(slots=True)
class CellState:
    """What the cycle publishes once per SYNC."""

    cycle: U64 = 0  # SYNCs sent since this cycle process started
    sync_ns: I64 = NEVER
    generation: U64 = 0  # new for every cycle process: orders for an older one are dropped
    motion: Annotated[Motion, Code("B", Motion)] = Motion.IDLE
    override: F64 = 0.0
    job: U64 = 0  # id of the order that moves the axes now, 0: none
    progress: F64 = 0.0  # s of the running piece, 0..1
    done_job: U64 = 0  # last order that ended well
    failed_job: U64 = 0  # last order that ended badly; failure() also knows those before it
    failed_reason: U16 = 0
    taken: U64 = 0  # last order id taken from the ring
    emergency: OneByteBool = False  # emergency-stop latch
    ready: OneByteBool = False
    permits: U8 = 0  # Permit bits: which enabling inputs are set
    stop_cause: U16 = 0  # Reason number of the last stop that the cycle itself initiated
    skipped: U64 = 0  # grid instants without SYNC
    incomplete: U64 = 0  # cycles in which an actual value was missing
    late: U64 = 0  # telegrams that came in the cycle after theirs
    services_lost: U64 = 0  # how often the services' life counter stopped
    piece: U64 = 0  # id of the planner's piece under way, 0: none
    compute_ns: U64 = 0  # time of the last cycle from the last actual value to set values ready
    parts: U64 = 0  # completed parts of programs: the axes rest, and the planner continues from their positions
    engaged: F64 = 0.0  # belt value (m or rad) at which the robot got onto its belt last
    belt: F64 = 0.0  # counter of the belt under way, or of the first one; m or rad
    belt_speed: F64 = 0.0
    belt_code: U16 = 0  # last fault of a synchronous part: number of the rho 3, or 65001 .. (AX-545, AX-547)
    belt_block: U32 = 0  # and its block in the program
    belt_axis: U8 = 0  # and the axis, from 1; also of a servo error (AX-549)
    met: OneByteBool = False  # the last part with an input ended by it
    path_stop: U16 = 0  # function of the path that was stopped last, or was still in use (plannerrecords.function_words), 0: none
    drive_axis: U8 = 0  # axis (from 1) for whose drive-on the last program ended, 0: none
    measured_mask: U32 = 0  # axes (bit n-1 = axis n) whose position the program under way, or the last one, has measured
    failed_2: U64 = 0  # the three that ended badly before failed_job, newest first: several may fail in one cycle (AX-514)
    reason_2: U16 = 0
    failed_3: U64 = 0
    reason_3: U16 = 0
    failed_4: U64 = 0
    reason_4: U16 = 0
    axes: list[AxisState] = field(default_factory=lambda: [AxisState() for _ in range(MOST_AXES)])  # published: those of the cell
    lanes: list["LaneState"] = field(default_factory=list)  # of a cell of several kinematics; the rest is then of all together

    def fail(self, job: int, reason: int) -> None:
        """This order ended badly; 0: there was none."""
        if not job:
            return
        if job != self.failed_job:
            self.failed_4, self.reason_4 = self.failed_3, self.reason_3
            self.failed_3, self.reason_3 = self.failed_2, self.reason_2
            self.failed_2, self.reason_2 = self.failed_job, self.failed_reason
        self.failed_job, self.failed_reason = job, int(reason)

    def failure(self, job: int) -> int:
        """Why this order ended badly, 0: it did not, or four others have since."""
        found = _failure(self, job)
        for lane in self.lanes:
            found = found or _failure(lane, job)
        return found

    # ---- by lanes: a cell of one answers these itself -----------------------------------------------------------------
    @property
    def apart(self) -> list["LaneState"]:
        """Lanes that lead axes; empty: one lane leads the axes of all kinematics, and their records hold only their own fields."""
        return self.lanes if any(lane.holds for lane in self.lanes) else []

    def done(self, job: int) -> bool:
        """The last order of a lane that ended well is this one."""
        lanes = self.apart
        return any(lane.done_job == job for lane in lanes) if lanes else self.done_job == job

    def moves(self, job: int) -> bool:
        """This order moves axes now."""
        lanes = self.apart
        return any(lane.job == job for lane in lanes) if lanes else self.job == job

    def span(self, mask: int) -> int:
        """Every axis of the lanes with some of these axes; 0: of all lanes."""
        return self.kinematics(mask) if self.apart else EVERY_AXIS

    def kinematics(self, mask: int) -> int:
        """Every axis of the kinematics with some of these axes; 0: of all."""
        if not self.lanes:
            return EVERY_AXIS
        return functools.reduce(operator.or_, (lane.own for lane in self.lanes if lane.own & mask or not mask), 0)

    def motion_of(self, mask: int) -> Motion:
        """Of the lanes that hold some of these axes (bit n-1 = axis n)."""
        lanes = self.apart
        return worst(lane.motion for lane in lanes if lane.holds & mask) if lanes else self.motion

    def lane_of(self, mask: int) -> "CellState | LaneState":
        """The lane that holds the first of these axes."""
        return next((lane for lane in self.lanes if lane.holds & mask), self)

    def rests(self, since: int) -> bool:
        """Nothing moves but what was ordered after this order."""
        lanes = self.apart
        return all(lane.motion in AT_REST or lane.job > since for lane in lanes) if lanes else self.motion in AT_REST

    def stopped(self, mask: int) -> int:
        """Every axis of the lanes with some of these that rest with a rest of their path; 0: there is none."""
        if not (lanes := self.apart):
            return EVERY_AXIS if self.motion is Motion.STOPPED else 0
        return functools.reduce(operator.or_, (lane.holds for lane in lanes if lane.holds & mask and lane.motion is Motion.STOPPED), 0)

    def withheld(self, mask: int) -> int:
        """Permit bits that feed inputs of the kinematics with some of these axes withhold."""
        return functools.reduce(operator.or_, (lane.withheld for lane in self.lanes if lane.own & mask), 0)

    def override_of(self, mask: int) -> float:
        """The lowest of these lanes or kinematics, as ordered."""
        lanes = self.apart
        return min((lane.override for lane in self.lanes if (lane.holds if lanes else lane.own) & mask), default=self.override)


@dataclass(slots=True)
class LaneState:
    """One lane of a cell of several: a kinematic that moves independently, or the axes of none.

    Its fields mean the same as those of CellState, for these axes only.  Where one lane leads all (belts, a correction) only own,
    override and withheld are used.
    """

    own: U32 = 0  # axes (bit n-1 = axis n) of its kinematic
    holds: U32 = 0  # axes it leads now: its own, and those of others while it moves them, too; 0: another lane has them
    motion: Annotated[Motion, Code("B", Motion)] = Motion.IDLE
    override: F64 = 0.0
    job: U64 = 0
    progress: F64 = 0.0
    piece: U64 = 0
    parts: U64 = 0
    met: OneByteBool = False
    done_job: U64 = 0
    failed_job: U64 = 0
    failed_reason: U16 = 0
    failed_2: U64 = 0
    reason_2: U16 = 0
    failed_3: U64 = 0
    reason_3: U16 = 0
    failed_4: U64 = 0
    reason_4: U16 = 0
    stop_cause: U16 = 0
    path_stop: U16 = 0
    drive_axis: U8 = 0
    withheld: Annotated[int, Code(f"B{SPARE}x")] = 0  # Permit bits that inputs of its kinematic alone withhold (AX-1787)


def _failure(state: CellState | LaneState, job: int) -> int:
    if not job:
        return 0
    failures = (
        (state.failed_job, state.failed_reason),
        (state.failed_2, state.reason_2),
        (state.failed_3, state.reason_3),
        (state.failed_4, state.reason_4),
    )
    return next((reason for failed, reason in failures if failed == job), 0)


def worst(motions: Iterable[Motion]) -> Motion:
    """Return the state of several lanes: moving takes precedence over held with a remainder of the path, and that over at rest."""
    return max(motions, key=MOTIONS_BY_WEIGHT.index, default=Motion.IDLE)


AT_REST = (Motion.IDLE, Motion.STOPPED)
MOTIONS_BY_WEIGHT = (Motion.IDLE, Motion.STOPPED, Motion.STOPPING, Motion.REFERENCING, Motion.RUNNING)
STATE, AXIS, LANE = Layout(CellState, "cell-state/2"), Layout(AxisState), Layout(LaneState)
CELL_STATE_LAYOUT = f"{STATE.text} axes x {AXIS.struct.format}"  # lanes follow where there are some: recordings without read as ever
MOST_LANES = 32
assert LANE.size % AXIS.size == 1 and AXIS.size > MOST_LANES  # so the length of a record determines both numbers


def cell_state_size(axes: int, lanes: int = 0) -> int:
    """Return the bytes of the packed state of a cell of these axes and lanes (0: one): a cycle copies existing ones only."""
    return STATE.size + axes * AXIS.size + lanes * LANE.size


def lanes_packer(lanes: int) -> Callable[[CellState], bytes]:
    """Packs the lanes of a state, which follow its axes."""
    pack = struct.Struct(f"={LANE.codes * lanes}").pack
    values_of = attrgetter(*LANE.names)

    def packer(state: CellState) -> bytes:
        values: list[object] = []
        for lane in state.lanes:
            values += values_of(lane)
        return pack(*values)

    return packer


def cell_state_packer(axes: int, lanes: int = 0) -> Callable[[CellState], bytes]:
    """Packs the first `axes` of a state, which has no fewer, and its lanes: cell_state_size(axes, lanes) bytes."""
    pack, behind = struct.Struct(f"={STATE.codes}{AXIS.codes * axes}").pack, lanes_packer(lanes) if lanes else None
    head = attrgetter(*STATE.names)
    axis = attrgetter(*AXIS.names)

    def packer(state: CellState) -> bytes:
        values = [*head(state)]
        for one in state.axes[:axes]:
            values += axis(one)
        return pack(*values) if behind is None else pack(*values) + behind(state)

    return packer


def pack_cell_state(state: CellState) -> bytes:
    """All axes and lanes of it."""
    return cell_state_packer(len(state.axes), len(state.lanes))(state)


def unpack_cell_state(data: bytes) -> CellState:
    """The reverse of pack_cell_state: as many axes and lanes as were packed."""
    rest = memoryview(data)
    lanes_at = len(data) - (len(data) - STATE.size) % AXIS.size * LANE.size
    axes = [AXIS.unpack(rest[at : at + AXIS.size]) for at in range(STATE.size, lanes_at, AXIS.size)]
    return STATE.unpack(data, axes, [LANE.unpack(rest[at : at + LANE.size]) for at in range(lanes_at, len(data), LANE.size)])


class Order(IntEnum):
    """What services ask of the cycle."""

    ENABLE = 1
    DISABLE = 2
    REFERENCE = 3
    MOVE = 4  # a piece follows in the record
    STOP = 6
    RESUME = 7
    ABANDON = 8
    RESET = 9
    OVERRIDE = 10
    PROGRAM = 11  # the planner's pieces of this job are taken from now on
    BELT = 13  # mask: place of a belt; value: its offset as it was kept, NaN: none (AX-480)
    EMERGENCY = 12  # as an open chain: drives off, READY open, until a fault reset
    HOLD = 14  # of a stream: on the path; what still comes waits until RESUME (AX-1080)
    RETRACE = 15  # and back along the path, to where it begins at most
    DISTANCE = 16  # value: m or rad that a modified MOVE UNTIL of these axes runs on past the edge, until another one is ordered
    FACTOR = 17  # of the program `job`: value is a share of the override, until its end (rho 3 SF 41)


@dataclass(frozen=True, slots=True)
class OrderRecord:
    """One record of the command ring; `piece` is an encoded motion piece for MOVE and empty otherwise."""

    order: Order
    job: int
    generation: int
    mask: int = 0  # bit n-1 = axis n
    value: float = 0.0
    reason: int = 0  # why (for STOP: Reason number); of a move, program or reference run SERVICES_LOST: it stops when they are lost
    piece: bytes = b""


@dataclass(frozen=True, slots=True)
class _OrderHead:
    """The packed part of a record; the piece follows."""

    order: Annotated[Order, Code("H", Order)]
    reason: U16
    mask: U32
    job: U64
    generation: U64
    value: F64
    size: Annotated[int, Code("I4x")]  # of the piece


_ORDER = Layout(_OrderHead, "orders/2")
ORDER_LAYOUT = _ORDER.text


def order_size(piece_size: int) -> int:
    """Return the bytes of one record of the command ring whose longest piece has `piece_size`."""
    return _ORDER.size + piece_size


def pack_order(record: OrderRecord, piece_size: int) -> bytes:
    """OrderRecord as order_size(piece_size) bytes."""
    if len(record.piece) > piece_size:
        raise ValueError(f"piece of {len(record.piece)} bytes; {piece_size} fit")
    head = _OrderHead(record.order, record.reason, record.mask, record.job, record.generation, record.value, len(record.piece))
    return _ORDER.pack(head) + record.piece.ljust(piece_size, b"\0")


def unpack_order(data: bytes) -> OrderRecord:
    """The reverse of pack_order."""
    head = _ORDER.unpack(data)
    piece = bytes(data[_ORDER.size : _ORDER.size + head.size])
    return OrderRecord(head.order, head.job, head.generation, head.mask, head.value, head.reason, piece)


class Quality(IntEnum):
    """How far a value may be trusted (design: section 5)."""

    BAD = 0
    STALE = 1
    GOOD = 2


@dataclass(slots=True)
class InputImage:
    """RC inputs: value, quality and stamp of each byte; a byte belongs to one command source."""

    values: Annotated[bytearray, Code(f"{RC_BYTES}s", bytearray, bytes)] = field(default_factory=lambda: bytearray(RC_BYTES))
    quality: Annotated[bytearray, Code(f"{RC_BYTES}s", bytearray, bytes)] = field(default_factory=lambda: bytearray(RC_BYTES))
    stamps: Annotated[list[int], Code(f"{RC_BYTES}q", list)] = field(default_factory=lambda: [NEVER] * RC_BYTES)

    def bit(self, number: int) -> bool:
        """Bit N of the image whatever its quality."""
        return bool(self.values[number >> 3] >> (number & 7) & 1)


_INPUT = Layout(InputImage, "rc-in/1")
INPUT_SIZE, INPUT_LAYOUT = _INPUT.size, _INPUT.text


def pack_inputs(image: InputImage) -> bytes:
    """InputImage as INPUT_SIZE bytes; by hand, it is done in every cycle."""
    return _INPUT.struct.pack(bytes(image.values), bytes(image.quality), *image.stamps)


def unpack_inputs(data: bytes) -> InputImage:
    """The reverse of pack_inputs."""
    values, quality, *stamps = _INPUT.struct.unpack(data)
    return InputImage(bytearray(values), bytearray(quality), stamps)


def set_bit(image: bytearray, number: int, value: bool) -> None:
    """Bit N = byte N div 8, bit N mod 8 (rho3 0.2)."""
    if value:
        image[number >> 3] |= 1 << (number & 7)
    else:
        image[number >> 3] &= ~(1 << (number & 7))


def set_bits(image: bytearray, first: int, count: int, values: int) -> None:
    """Bits `first` .. `first + count - 1`; bit 0 of `values` is the first of them."""
    start, stop, shift = first >> 3, (first + count + 7) >> 3, first & 7
    word = int.from_bytes(image[start:stop], "little") & ~(((1 << count) - 1) << shift) | values << shift
    image[start:stop] = word.to_bytes(stop - start, "little")


def get_bit(image: bytes | bytearray, number: int) -> bool:
    """The reverse of set_bit."""
    return bool(image[number >> 3] >> (number & 7) & 1)
