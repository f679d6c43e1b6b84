"""MOVE_FILE as the planner passes it on: a path that has its law already.  Beside motion.planner.planner (AX-576)."""

from dataclasses import dataclass, field

from motion.errors import LimitError, MotionError
from motion.execution.timed import TimedPiece
from motion.files.bnr import BnrError, decode_header
from motion.files.errors import FORMAT, MoveFileError
from motion.files.move_file import BY_FILE, Control, MoveFiles, Playback
from motion.files.playing import FilePath, path_of
from motion.geometry.units import from_si
from motion.kinematics.base import Joints
from motion.kinematics.endless import AxisType, within
from motion.planner.marks import Mark
from motion.planner.path_checks import Slowed
from motion.planner.robot import Machine
from motion.program.blocks import Block
from motion.program.errors import BlockError
from motion.timing.slices import Work

ROUNDING = 1e-6  # of a round: REAL32 gives seven digits
SHORTEST_US = 100  # of a time base that is not compared


def control_of(machine: Machine, period_us: int) -> Control:
    """What files are compared with; axes that go round are endless."""
    types = tuple(AxisType.ENDLESS_MAIN if axis.modulo else AxisType.MAIN for axis in machine.limits)
    return Control(machine.limits, period_us, types=types, modulo=tuple(from_si(axis.modulo, axis.unit) for axis in machine.limits))


def file_path(block: Block, data: bytes, position: Joints, machine: Machine, period_us: int, number: int) -> FilePath:
    """Run every check of a MOVE_FILE block that begins at the present position.  Raise BlockError with the manual's number, block and
    axis.  period_us: P5 of the cell; 0: there is none, and the file's own time is used.
    """
    call, rows = block.file, zip(position, machine.limits, strict=True)
    assert call is not None
    shown = tuple(within(place, axis.modulo) if axis.modulo else place for place, axis in rows)
    try:
        period_us = period_us or _own_period(data)
        files = MoveFiles(control_of(machine, period_us))
        if call.offset is not None:
            files.read_begin(call.name, data, call.offset)
        run = files.move_file(call.name, call.base, call.modulo, shown)
        path = path_of(run, position, [there - here for there, here in zip(position, shown, strict=True)], period_us * 1e-6)
        path.check_size()
    except MoveFileError as error:
        raise BlockError(f"{error.text}: {error.detail}", code=error.code, block=number, axis=error.axis, source="rho 3") from error
    except LimitError as error:
        raise BlockError(f"{call.name}: {str(error).partition(': ')[2]}", block=number, axis=error.axis) from error
    except MotionError as error:
        raise BlockError(f"{call.name}: {error}", block=number) from error
    _check_rounds(run, machine, call.name, number)
    return path


def _check_rounds(run: Playback, machine: Machine, name: str, number: int) -> None:
    """Refuse a file that ends an axis with another modulo: after the block an axis of a cell is within its own modulo."""
    for axis, flag, last, there in zip(machine.limits, run.flags, run.rows[-1], run.end_position(), strict=True):
        modulo = from_si(axis.modulo, axis.unit)
        if flag == BY_FILE and abs(within(last, modulo) - there) > ROUNDING * modulo:
            what = f"{name}: modulo flag 1, and {last:g} {axis.unit} at its end are not a whole number of rounds of {modulo:g} {axis.unit}"
            raise BlockError(what, block=number, axis=axis.name)


def _own_period(data: bytes) -> int:
    try:
        return max(decode_header(data).time_base_us, SHORTEST_US)
    except BnrError as error:
        raise MoveFileError(FORMAT, str(error)) from error


@dataclass
class FilePlan:
    """One block; with the interface of a planned path, so that it is passed on the same way.  path: at full speed; stretch: of its time,
    for a program that is ordered to run more slowly."""

    machine: Machine
    block: Block
    path: FilePath
    mask: int
    next_id: int
    added: int = 1
    _made: list[TimedPiece] = field(default_factory=list)
    _taken: bool = False

    @property
    def robot(self) -> Machine:
        return self.machine

    @property
    def position(self) -> Joints:
        """Where the axes will be."""
        return self.path.end

    @property
    def waiting(self) -> int:
        return 1

    @property
    def open(self) -> bool:
        """It was not handed on yet."""
        return not self._taken

    @property
    def working(self) -> bool:
        """Its law is there."""
        return False

    @property
    def slowed(self) -> dict[int, Slowed]:
        """Its speed is the file's."""
        return {}

    @property
    def end(self) -> float:
        return self.path.duration

    @property
    def begins(self) -> dict[int, float]:
        """Piece -> tau."""
        found, tau = {}, 0.0
        for piece in self._made:
            found[piece.id] = tau
            tau += piece.duration
        return found

    def begin(self, tau: float, *, hurry: bool = False) -> bool:
        """The pieces, once."""
        if not self._made:
            self._made = self.path.pieces(self.machine.limits, first_id=self.next_id, mask=self.mask, block=1)
        return not self._taken

    def work(self) -> bool:
        return True

    def take(self) -> list[TimedPiece]:
        taken, self._taken = self._taken, True
        return [] if taken else self._made

    def take_marks(self) -> list[Mark]:
        """Return the marks.  Functions before the block are called at its beginning."""
        return [Mark(self._made[0].id, 0.0, 0, 0.0, function) for function in self.block.functions] if self._made else []

    def ending(self) -> Work[None]:
        """As motion.planner.planner.Planner: nothing."""
        yield from ()

    def finish(self) -> None:
        """Nothing of it depends on what follows."""

    def place(self, tau: float) -> tuple[int, float]:
        """Block and share of its way."""
        return 1, min(max(tau / self.path.duration, 0.0), 1.0)
