"""The planner killed between any two writes of its ring, and in the middle of one: what the stepper holds ends at rest on the path.

The planner runs in a child process on a real ring and dies by SIGKILL at a chosen store; a stepper takes what is in the ring and runs
it out.  A second program follows while the first one moves, so that tails are replaced, too.
"""

import os
from collections.abc import Sequence

import numpy as np
import pytest

from gateway.pure.image.records.planner import PIECE_LAYOUT, BlockRecord, Part, PieceRecord, Say, pack_piece, piece_size, unpack_piece
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.cycle_view import CycleView
from gateway.pure.planning.planner import Programs
from gateway.runtime.regions import RingReader, RingWriter, create_ring
from hil_tests.lab.cells.arms import Array, portal, shares
from hil_tests.rig.image.dying import DyingRing, Executioner, dies
from motion.errors import PieceError
from motion.execution.stepper import State, Stepper
from motion.execution.timed import decode_any
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.text.reader import read

P = 0.004
AXES = 3
HEAD = "axes mm mm mm"
FIRST = ["linear pose 0 0 40 0 0 0 radius=15", "linear pose 200 0 40 0 0 0 radius=15"]
SECOND = ["linear pose 200 150 40 0 0 0 radius=15", "linear pose 0 150 0 0 0 0 blend=off"]


def curve() -> Array:
    """The whole path, densely."""
    program = read("\n".join([HEAD, "start 0 0 0", *FIRST, *SECOND]))
    route = Route(portal(), (0.0, 0.0, 0.0))
    for block in program.blocks:
        route.add(block)
    route.finish()
    return np.concatenate([s.path.at(np.linspace(0.0, s.path.length, 250))[:, :AXES] for s in route.take()])


def away(rows: Array, path: Array) -> float:
    """Largest distance from the polyline, m."""
    a, way = path[:-1], np.diff(path, axis=0)
    square = np.maximum(np.sum(way * way, axis=1), 1e-18)
    worst = 0.0
    for row in rows:
        share = np.clip(np.sum((row - a) * way, axis=1) / square, 0.0, 1.0)
        worst = max(worst, float(np.min(np.linalg.norm(a + share[:, None] * way - row, axis=1))))
    return worst


class Both:
    """Planner turns and stepper periods in step, in one process: the ring between them."""

    def __init__(self, writer: RingWriter, reader: RingReader) -> None:
        self.writer, self.reader = writer, reader
        self.programs = Programs(CellPrograms(lambda *_: machine(), lambda _: 7))
        self.stepper = Stepper(AXES, P, (0.0, 0.0, 0.0))
        self.piece, self.rows, self.records = 0, [(0.0, 0.0, 0.0)], 0

    def turn(self, said: Sequence[BlockRecord]) -> None:
        for record in self.planned(said):
            self.writer.put(pack_piece(record, self.writer.size))
        self.step()

    def planned(self, said: Sequence[BlockRecord]) -> list[PieceRecord]:
        """What one turn hands on, the law that is begun in it made."""
        moving = self.stepper.state is not State.IDLE
        return made(self.programs, said, self.piece, self.rows[-1], moving=moving)

    def step(self) -> None:
        for _, data in self.reader.take(8):
            record = unpack_piece(data)
            self.records += 1
            if record.part is Part.PIECE:
                self.stepper.load(decode_any(record.piece))
        sample = self.stepper.step()
        self.piece = sample.piece_id
        self.rows.append((sample.q[0], sample.q[1], sample.q[2]))


def machine() -> Machine:
    return portal()


def made(programs: Programs, said: Sequence[BlockRecord], piece: int, standing: Sequence[float], *, moving: bool) -> list[PieceRecord]:
    """One turn, and one more for the law begun in it."""
    records = programs.turn(said, CycleView(1, piece, standing, moving=moving))
    if programs.working:
        while not programs.work():
            pass
        records += programs.turn([], CycleView(1, piece, standing, moving=moving))
    return records


def said(lines: Sequence[str], *marks: Say) -> list[BlockRecord]:
    return [*(BlockRecord(Say.LINE, 1, line) for line in lines), *(BlockRecord(mark, 1) for mark in marks)]


def opening() -> list[BlockRecord]:
    return [BlockRecord(Say.BEGIN, 1, "robot portal"), *said([HEAD, *FIRST])]


def ring() -> int:
    return create_ring("pieces", piece_size(AXES), 256, PIECE_LAYOUT)


def whole(fd: int) -> Both:
    """The program undisturbed: its second half is said while the first one moves."""
    both = Both(RingWriter(fd, "pieces"), RingReader(fd, "pieces"))
    both.turn(opening())
    while both.rows[-1][2] < 0.02:
        both.turn([])
        assert len(both.rows) < 500
    both.turn(said(SECOND, Say.END))
    while both.stepper.state is not State.IDLE or not both.programs.state.ended:
        both.turn([])
        assert len(both.rows) < 1500
    return both


def test_a_program_said_in_two_halves_runs_through_without_a_stop_in_between() -> None:
    fd = ring()
    try:
        both = whole(fd)
        rows = np.array(both.rows)
        assert rows[-1] == pytest.approx([0.0, 0.15, 0.0], abs=1e-9)
        assert away(rows[::3], curve()) < 1e-6
        speed = np.linalg.norm(np.diff(rows, axis=0), axis=1) / P
        running = np.nonzero(speed > 1e-6)[0]
        assert float(speed[running[0] + 12 : running[-1] - 12].min()) > 0.02, "stopped where the second half began"
        assert shares(portal(), rows, P)[0] <= 1.001
    finally:
        os.close(fd)


def test_a_row_with_slow_corners_goes_on_without_a_stop() -> None:
    """Its law is refined, and such a tail has more pieces than the one it replaces: it has to be with the axes in time (AX-961)."""
    places = [(20 + 20 * (n // 2), (0, 20, 20, 0, 0, 20)[n % 6]) for n in range(12)]
    lines = [f"linear pose {x} {y} 40 0 0 0 radius=2" for x, y in places]
    lines[-1] = lines[-1].replace("radius=2", "blend=off")
    fd = ring()
    try:
        both = Both(RingWriter(fd, "pieces"), RingReader(fd, "pieces"))
        both.turn([BlockRecord(Say.BEGIN, 1, "robot portal"), *said([HEAD, *lines[:6]])])
        while len(both.rows) <= 0.1 / P + 1:
            both.turn([])
        both.turn(said(lines[6:], Say.END))
        while both.stepper.state is not State.IDLE or not both.programs.state.ended:
            both.turn([])
            assert len(both.rows) < 1500
        speed = np.linalg.norm(np.diff(np.array(both.rows), axis=0), axis=1) / P
        running = np.nonzero(speed > 1e-6)[0]
        assert float(speed[running[0] + 12 : running[-1] - 12].min()) > 0.02, "stopped where the second half began"
    finally:
        os.close(fd)


@pytest.mark.parametrize("half", [False, True])
def test_killed_at_any_write_of_the_ring_the_axes_end_at_rest_on_the_path(half: bool) -> None:
    """The child says both halves of the program at once, so that every piece there is comes through the dying ring."""
    path, reached = curve(), []
    programs = Programs(CellPrograms(lambda *_: machine(), lambda _: 7))
    records = made(programs, [*opening(), *said(SECOND, Say.END)], 0, (0.0, 0.0, 0.0), moving=False)
    while records[-1].part is not Part.LAST:
        records += made(programs, [], 0, (0.0, 0.0, 0.0), moving=False)
    for fatal in range(1, 400, 3 if half else 1):
        fd = ring()
        try:
            reader = RingReader(fd, "pieces")

            def plan(executioner: Executioner, fd: int = fd) -> None:
                DyingRing.executioner = executioner
                writer = DyingRing(fd, "pieces")
                for record in records:
                    writer.put(pack_piece(record, writer.size))

            died = dies(plan, fatal, half)
            stepper, rows = Stepper(AXES, P, (0.0, 0.0, 0.0)), [(0.0, 0.0, 0.0)]
            for _, data in reader.take(256):
                record = unpack_piece(data)
                if record.part is Part.PIECE:
                    try:
                        stepper.load(decode_any(record.piece))
                    except PieceError as error:
                        pytest.fail(f"a piece of a dead planner is torn: {error}")
            for _ in range(2000):
                sample = stepper.step()
                rows.append((sample.q[0], sample.q[1], sample.q[2]))
                if sample.state is State.IDLE:
                    break
            assert stepper.state is State.IDLE, "never at rest"
            moved = np.array(rows)
            assert away(moved[::4], path) < 1e-6
            assert float(np.abs(moved[-1] - moved[-2]).max()) < 1e-5, "ends while it moves"
            reached.append(float(np.linalg.norm(moved[-1] - path[-1])))
        finally:
            os.close(fd)
        if not died:
            break
    assert not died and len(reached) > 10 and reached[-1] < 1e-9


def test_killed_while_a_tail_is_replaced_the_old_tail_or_the_new_one_is_run_whole() -> None:
    path = curve()
    for extra in range(0, 12, 2):
        fd = ring()
        try:
            both = Both(RingWriter(fd, "pieces"), RingReader(fd, "pieces"))
            both.turn(opening())
            while both.rows[-1][2] < 0.02:
                both.turn([])
            records = both.planned(said(SECOND, Say.END))
            assert len(records) > 5, "no tail to replace"
            for record in records[:extra]:
                both.writer.put(pack_piece(record, both.writer.size))
            for _ in range(1500):
                both.step()
                if both.stepper.state is State.IDLE:
                    break
            rows = np.array(both.rows)
            assert both.stepper.state is State.IDLE and away(rows[::4], path) < 1e-6
            assert float(np.abs(rows[-1] - rows[-2]).max()) < 1e-5
        finally:
            os.close(fd)
