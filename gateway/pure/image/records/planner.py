"""Records exchanged by planner, cycle and the sources of program orders through rings and one region (design: sections 4 and 6).

blocks ring (to the planner): one statement of the text form a record, or a mark.  pieces ring (to the cycle): one motion piece a record,
or the mark that nothing follows.  planner region: its activity, for displays and for the source of the order.
"""

import json
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Annotated, NamedTuple

from gateway.pure.image.records.layout import F64, I32, U32, U64, Code, Layout, Yes
from motion.execution.pieces import RECORD_SIZE, record_size
from motion.outputs.function import Function

BLOCKS = 2048  # records in the blocks ring
PIECES = 1024  # records in the pieces ring: one law and what goes with it (AX-606)
AHEAD = 128  # pieces handed on and not run; in time motion.planner.planner.AHEAD_S
PLANNER_BYTES = 8192
WORDS = 400  # characters of a sentence
TEXT_BYTES = 1000


class Say(IntEnum):
    """Kinds of blocks records."""

    BEGIN = 1  # a program begins; text: head statements so far as known (robot NAME)
    LINE = 2  # a statement of the text form
    FINISH = 3  # nothing follows for the time being: run all known blocks to their end
    END = 4  # the program is complete
    DROP = 5  # forget everything (the cycle abandoned the motion, or the program is aborted)
    RUN = 6  # a complete program of the cell; text: its number, velocity and acceleration factor (run_record)
    STREAM = 7  # a stream of the interpreter begins, at rest; text: number of its robot, from 1
    WHOLE = 8  # the lines of this stream are read when END has come, and run as a program of the cell is
    FLUSH = 9  # the axes rest on the path, and blocks that are not over are dropped (AX-1080)
    CUT = 10  # drop the blocks after this one; text: its number
    SINGLE = 11  # blocks wait for STEP; text: on, off
    STEP = 12  # the next one of them
    LOST = 13  # statements of this stream that its sender could not hand over; text: how many, and how many may wait


@dataclass(frozen=True, slots=True)
class _Said:
    """A BlockRecord as the ring holds it."""

    say: Annotated[Say, Code("I", Say)]
    size: U32
    job: U64
    text: Annotated[bytes, Code(f"{TEXT_BYTES}s")]


_SAY = Layout(_Said, "blocks/1")
SAY_SIZE, SAY_LAYOUT = _SAY.size, _SAY.text


@dataclass(frozen=True, slots=True)
class BlockRecord:
    """job: the order's id; a job is taken once."""

    say: Say
    job: int
    text: str = ""


def pack_block(record: BlockRecord) -> bytes:
    """As SAY_SIZE bytes; ValueError for a line that is too long."""
    octets = record.text.encode()
    if len(octets) > TEXT_BYTES:
        raise ValueError(f"a line of {len(octets)} bytes; {TEXT_BYTES} fit")
    return _SAY.pack(_Said(record.say, len(octets), record.job, octets))


def unpack_block(data: bytes) -> BlockRecord:
    """The reverse of pack_block."""
    said = _SAY.unpack(data)
    return BlockRecord(said.say, said.job, said.text[: said.size].decode())


@dataclass(frozen=True, slots=True)
class ProgramFacts:
    """What the dispatcher must know of a program of the cell; mask: bit n-1 = axis n."""

    name: str
    mask: int


@dataclass(frozen=True, slots=True)
class ProgramOrder:
    """For the planner: job, number of the program, factors 0..1.  robot: no program, but a stream of this robot (from 1)."""

    job: int
    number: int
    velocity: float
    acceleration: float
    robot: int = 0


def run_record(order: ProgramOrder) -> BlockRecord:
    """The order as the planner gets it."""
    if order.robot:
        return BlockRecord(Say.STREAM, order.job, str(order.robot))
    return BlockRecord(Say.RUN, order.job, f"{order.number} {order.velocity!r} {order.acceleration!r}")


def run_of(record: BlockRecord) -> ProgramOrder:
    """The reverse of run_record."""
    number, velocity, acceleration = record.text.split()
    return ProgramOrder(record.job, int(number), float(velocity), float(acceleration))


class Part(IntEnum):
    """Kinds of pieces records."""

    PIECE = 1
    LAST = 2  # the job ends where the pieces before end
    FAULT = 3  # a block of the job cannot be run: it is over where the pieces before end
    OUTPUT = 4  # an RC output changes at a place of a piece that follows (SwitchAt)
    UNTIL = 5  # the part that follows ends when an input has a value (UntilInput)
    REST = 6  # the part ends with the previous pieces; the next one begins where the axes then rest
    SYNCHRON = 7  # a belt-synchronous part begins at the present position (records.belts)
    BELT_BLOCK = 8  # one block of it, with a belt of type 2 or 3
    FUNCTION = 9  # IO logic or PPO is called at a place of a piece that follows (FunctionAt)
    ALTER = 10  # an alterable part begins at the present position (records.alter)
    BELT_ACT = 11  # SYNC, or a special function of belts; a part of its own (beltacts)
    START = 12  # the part that follows begins when an input has a value (inputrecords)
    FLYING = 13  # a probe is switched on or off at a place of a piece that follows (inputrecords)
    MACHINE = 14  # the axes have other positions from here on; a separate part (records.points)
    RECALL = 15  # an entry of the reference path is wanted; a part of its own
    TAPE = 16  # the reference path begins or ends at a place of a piece that follows
    LATCH = 17  # VAL 3's latch is set at a place of a piece that follows
    FLUSH = 18  # the current part ends where the axes come to rest on its path


@dataclass(frozen=True, slots=True)
class _PieceHead:
    """The packed part of a PieceRecord; the piece follows."""

    part: Annotated[Part, Code("I", Part)]
    size: U32  # of the piece
    job: U64
    generation: U64


_PIECE = Layout(_PieceHead, "pieces/2")
PIECE_LAYOUT = _PIECE.text


@dataclass(frozen=True, slots=True)
class _Taken:
    """The region that the cycle writes in addition to the ring."""

    number: U64


_TAKEN = Layout(_Taken, "pieces-taken/1")
TAKEN_LAYOUT, TAKEN_SIZE = _TAKEN.text, _TAKEN.size


def pack_taken(number: int) -> bytes:
    """Sequence number of the last record of the pieces ring that the cycle took."""
    return _TAKEN.pack(_Taken(number))


def unpack_taken(data: bytes) -> int:
    """The reverse of pack_taken."""
    return _TAKEN.unpack(data).number


def piece_size(axes: int) -> int:
    """Return the bytes of a record of the pieces ring of a cell of these axes."""
    return _PIECE.size + record_size(axes)


@dataclass(frozen=True, slots=True)
class PieceRecord:
    """generation: of the cycle process it is meant for; a new cycle drops it."""

    part: Part
    job: int
    generation: int
    piece: bytes = b""


@dataclass(frozen=True, slots=True)
class SwitchAt:
    """RC output `number` becomes 0 or 1 this long (s at full speed) after the beginning of a piece; number -1: earlier records of this
    piece and later ones are void.
    """

    piece: U64
    after: F64
    number: I32
    value: Yes = False


@dataclass(frozen=True, slots=True)
class FunctionAt:
    """rho 3 SF 1 IOL or SF 2 PPO is called this long (s at full speed) after the beginning of a piece."""

    piece: int
    after: float
    function: Function


@dataclass(frozen=True, slots=True)
class MeasuringFacts:
    """[[measuring]]: RC input that carries the wire of a channel, axes (bit n-1 = axis n) whose positions it stores; drives: those whose
    own touch probe catches the edge (then there is no input: -1)."""

    input: int
    mask: int
    drives: int = 0
    latch: str = ""  # fIn0, fIn1: it is this fast input of VAL 3


NO_LIMIT = -1.0


@dataclass(frozen=True, slots=True)
class UntilInput:
    """RC input `number` has this value.  mask: axes whose positions are stored; by_edge: a probe, it has to change during the block;
    drives: axes whose drives catch its edge; within: s of movement after which the part ends without it, NO_LIMIT: at its end; runs_on:
    continues after the edge by the distance that was ordered last (rho 3 channel 7x0).
    """

    number: I32
    level: Yes
    mask: U32 = 0
    by_edge: Yes = False
    drives: U32 = 0
    within: F64 = NO_LIMIT
    runs_on: Yes = False


VOID = -1
PPO_NUMBERS = 1000  # added to the number of a PPO where a function is given as one number


@dataclass(frozen=True, slots=True)
class _Called:
    """A FunctionAt as the ring holds it."""

    piece: U64
    after: F64
    ppo: Yes
    number: I32
    kinematic: I32
    coordinate: I32
    position: F64
    value: F64
    time_ms: I32
    system: Annotated[tuple[float, float, float, float, float, float], Code("6d")]


_CALLED, _SWITCH, _UNTIL = Layout(_Called), Layout(SwitchAt), Layout(UntilInput)


def switch_record(job: int, generation: int, switch: SwitchAt) -> PieceRecord:
    """As a record of the pieces ring."""
    return PieceRecord(Part.OUTPUT, job, generation, _SWITCH.pack(switch).ljust(RECORD_SIZE, b"\0"))


def until_record(job: int, generation: int, until: UntilInput) -> PieceRecord:
    """As a record of the pieces ring."""
    return PieceRecord(Part.UNTIL, job, generation, _UNTIL.pack(until).ljust(RECORD_SIZE, b"\0"))


def function_record(job: int, generation: int, at: FunctionAt) -> PieceRecord:
    """As a record of the pieces ring."""
    call = at.function
    own = (call.ppo, call.number, call.kinematic, call.coordinate, call.position, call.value, call.time_ms)
    body = _CALLED.pack(_Called(at.piece, at.after, *own, call.system))
    return PieceRecord(Part.FUNCTION, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def function_of(record: PieceRecord) -> FunctionAt:
    """The reverse of function_record."""
    at = _CALLED.unpack(record.piece)
    function = Function(at.ppo, at.number, at.kinematic, at.coordinate, at.position, at.value, at.time_ms)
    return FunctionAt(at.piece, at.after, replace(function, system=at.system))


def function_number(ppo: bool, number: int) -> int:
    """One number for both kinds."""
    return number + (PPO_NUMBERS if ppo else 0)


def function_words(number: int) -> str:
    """`IOL 2`, `PPO 3`."""
    return f"PPO {number - PPO_NUMBERS}" if number > PPO_NUMBERS else f"IOL {number}"


def until_of(record: PieceRecord) -> UntilInput:
    """The reverse of until_record."""
    return _UNTIL.unpack(record.piece)


def switch_of(record: PieceRecord) -> SwitchAt:
    """The reverse of switch_record."""
    return _SWITCH.unpack(record.piece)


def pack_piece(record: PieceRecord, size: int) -> bytes:
    """As `size` bytes: those of the ring."""
    if _PIECE.size + len(record.piece) > size:
        raise ValueError(f"a piece of {len(record.piece)} bytes; {size - _PIECE.size} fit")
    head = _PIECE.pack(_PieceHead(record.part, len(record.piece), record.job, record.generation))
    return (head + record.piece).ljust(size, b"\0")


def unpack_piece(data: bytes) -> PieceRecord:
    """The reverse of pack_piece."""
    head = _PIECE.unpack(data)
    return PieceRecord(head.part, head.job, head.generation, bytes(data[_PIECE.size : _PIECE.size + head.size]))


class Answer(NamedTuple):
    """About a block that ends with an input: whether it came, and where the axes of the cell were at its edge (None: not stored); m and
    rad."""

    block: int
    met: bool
    places: tuple[float | None, ...] = ()


ANSWERS = 4  # kept: the newest


@dataclass(frozen=True)
class PlannerState:
    """job under way (0: none), block and share of its way, blocks that wait, pieces handed on; the last fault with its block."""

    job: int = 0
    block: int = 0
    share: float = 0.0
    waiting: int = 0
    handed: int = 0
    ended: bool = False
    failed_job: int = 0
    fault: str = ""
    fault_block: int = 0
    fault_code: int = 0
    warning: str = ""  # about the block under way
    cycle: int = 0  # generation of the cycle that the types of belts hold for
    types: tuple[tuple[int, int], ...] = ()  # of the belts as programs have set them (SF 21): type and tolerance
    placed: int = 0  # axes (bit n-1 = axis n) whose positions programs have set in that cycle (SF 3)
    systems: tuple[tuple[int, tuple[float, float, float, float, float, float]], ...] = ()  # WC_SYSTEM of kinematics where it is not WC_UR
    tool: tuple[float, ...] = ()  # of the block under way or the last one, of kinematic 1: m, and nine floats of its rotation; (): none yet
    passed: int = 0  # blocks whose end the axes have reached
    answers: tuple[Answer, ...] = ()  # of blocks of this job, the oldest first
    withheld: int = 0  # blocks that wait for their step
    bound: str = ""  # what else the current part follows (belt, correction): it can only be ended
    back: bool = False  # the axes have gone back from the furthest place that they reached
    order_fault: str = ""  # why the last order to the stream could not be executed
    heard: int = 0  # statements and orders of the stream that have been read
    job_before: int = 0  # that is over: the answers are those of its blocks until another one begins on this lane
    others: tuple["PlannerState", ...] = ()  # of the lanes after the first one, in a cell of several

    @property
    def under_way(self) -> "PlannerState":
        """Of the first lane that has a job; the first one where none has."""
        return next((each for each in (self, *self.others) if each.job), self)

    def of(self, job: int) -> "PlannerState":
        """Of the lane that this job is on, failed on last or was on last; the first one where none knows of it."""
        lanes = (self, *self.others)
        known = (each for number in ("job", "failed_job", "job_before") for each in lanes if getattr(each, number) == job)
        return next(known, self)


def restated(state: PlannerState, **said: object) -> PlannerState:
    """As replace(), which looks at every field: one is made in nearly every turn of the planner."""
    made = object.__new__(PlannerState)
    vars(made).update(vars(state), **said)
    return made


def job_over(state: PlannerState, **said: object) -> PlannerState:
    """No job is on the lane any more; what its blocks have answered stays."""
    return restated(state, job=0, job_before=state.job or state.job_before, **said)


def planner_bytes(lanes: int = 0) -> int:
    """Return the bytes of the region of a cell of this number of lanes, 0: one."""
    return PLANNER_BYTES * max(lanes, 1)


def pack_planner(state: PlannerState) -> bytes:
    """JSON, padded to PLANNER_BYTES for each lane."""
    return json.dumps(_fields_of(state)).encode().ljust(planner_bytes(1 + len(state.others)))


def _fields_of(state: PlannerState) -> dict[str, object]:
    fields = vars(state) | {"fault": state.fault[:WORDS], "warning": state.warning[:WORDS]}
    return fields | {"others": [_fields_of(other) for other in state.others]}


def unpack_planner(data: bytes) -> PlannerState:
    """The reverse of pack_planner."""
    fields = json.loads(data.rstrip())  # json passes over the padding by a regular expression
    for each in (*fields["others"], fields):
        each["types"] = tuple((kind, tolerance) for kind, tolerance in each["types"])
        each["systems"] = tuple((kinematic, tuple(values)) for kinematic, values in each["systems"])
        each["tool"] = tuple(each["tool"])
        each["answers"] = tuple(Answer(block, met, tuple(places)) for block, met, places in each["answers"])
        each["others"] = tuple(PlannerState(**other) for other in each["others"])
    return PlannerState(**fields)
