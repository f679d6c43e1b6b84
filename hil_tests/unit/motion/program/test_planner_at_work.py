"""A law takes about as long to make as to run: it is made in slices, and between two of them the planner hears and answers."""

import pytest

from gateway.pure.image.records.planner import BlockRecord, Part, PieceRecord, Say
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.cycle_view import CycleView
from gateway.pure.planning.planner import Programs
from hil_tests.lab.cells import arms
from hil_tests.lab.cells.arms import Array
from motion.execution.timed import TimedPiece
from motion.planner.planner import Planner
from motion.program.blocks import Blend, Block, Interpolation, Rounding
from motion.timing import banded, interior, topp

TEXT = """robot portal
axes mm mm mm
linear pose 20 0 0 0 0 0 radius=4
linear pose 20 20 0 0 0 0
circular via pose 15 25 0 0 0 0 to pose 10 20 0 0 0 0
ptp joints 0 0 0
"""
START = (0.0, 0.0, 0.0)
CORNER = Blend(Rounding.CARTESIAN, 2e-3, 2e-3)


class Counted:
    """What costs the time of a law: systems that are solved, and passes over the whole path."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.systems = self.passes = 0
        patch.setattr(interior, "Banded", self._banded)
        backward = topp._backward

        def counted(rows: topp._Rows, most: Array, h: float, b_end: float) -> Array:
            self.passes += 1
            return backward(rows, most, h, b_end)

        patch.setattr(topp, "_backward", counted)

    def _banded(self, diagonal: Array, near: Array, far: Array) -> banded.Banded:
        self.systems += 1
        return banded.Banded(diagonal, near, far)

    def taken(self) -> tuple[int, int]:
        """Since the last call."""
        both, self.systems, self.passes = (self.systems, self.passes), 0, 0
        return both


def programs() -> Programs:
    return Programs(CellPrograms(lambda *_: arms.portal(), lambda machine: (1 << machine.axes) - 1, lambda _: TEXT))


def turn(made: Programs, *records: BlockRecord, piece: int = 0) -> list[PieceRecord]:
    while made.preparing:
        made.prepare(START)
    return made.turn(records, CycleView(1, piece, START, moving=piece > 0))


def blocks() -> Planner:
    planner = Planner(arms.portal(), START)
    planner.add(Block(Interpolation.PTP, arms.at(20.0)))
    planner.add(Block(Interpolation.CIRCULAR, arms.at(20.0, 20.0), via=arms.at(30.0, 10.0)))
    planner.add(Block(Interpolation.LINEAR, arms.at(0.0)))
    planner.finish()
    return planner


def test_a_turn_solves_at_most_one_system_and_passes_a_path_three_times(monkeypatch: pytest.MonkeyPatch) -> None:
    counted, made = Counted(monkeypatch), programs()
    turn(made, BlockRecord(Say.RUN, 1, "1 1.0 1.0"))
    turns, pieces = [counted.taken()], []
    while not made.state.ended:
        pieces += [record for record in turn(made) if record.part is Part.PIECE]
        turns.append(counted.taken())
        assert len(turns) < 2000
    assert max(systems for systems, _ in turns) == 1 and sum(systems for systems, _ in turns) > 30
    assert max(passes for _, passes in turns) <= 3 and len(pieces) > 5


def test_pieces_made_in_slices_are_those_made_at_once() -> None:
    whole, sliced = blocks(), blocks()
    pieces = whole.plan(0.0, hurry=True)
    found: list[TimedPiece] = []
    slices = 0
    while sliced.begin(0.0, hurry=True):
        assert sliced.open and not sliced.take()
        while not sliced.work():
            slices += 1
        found += sliced.take()
    assert len(pieces) > 5 and found == pieces and slices > 20
    assert not sliced.open and sliced.end == whole.end and sliced.begins == whole.begins


def test_what_comes_between_two_slices_is_heard_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    counted, made = Counted(monkeypatch), programs()
    turn(made, BlockRecord(Say.RUN, 1, "1 1.0 1.0"))
    turn(made)
    assert made.working and made.state.job == 1
    assert not turn(made, BlockRecord(Say.DROP, 1)) and not made.working and made.state.job == 0
    counted.taken()
    assert not turn(made) and counted.taken() == (0, 0), "nobody works for what was dropped"
    turn(made, BlockRecord(Say.RUN, 2, "1 1.0 1.0"))
    turn(made)
    assert made.working and made.state.job == 2 and made.state.failed_job == 0


def test_a_law_goes_on_between_two_turns_for_whoever_has_the_time() -> None:
    alone, helped = programs(), programs()
    all_alone: list[PieceRecord] = []
    all_helped: list[PieceRecord] = []
    turns = 0
    for made, found in ((alone, all_alone), (helped, all_helped)):
        found += turn(made, BlockRecord(Say.RUN, 1, "1 1.0 1.0"))
        while not made.state.ended:
            if made is helped:
                turns += 1
                while made.working and not made.work():
                    pass
            found += turn(made)
    assert all_helped == all_alone and turns < 20


@pytest.mark.parametrize("carried_s", [0.0, 0.02])
def test_a_new_tail_has_the_time_to_be_carried(carried_s: float) -> None:
    """It counts when its last piece is with the axes; one of many pieces came too late, and the stream was aborted."""
    planner, tau, late = Planner(arms.portal(), START), 0.0, []
    planner.carried_s = carried_s
    corners = [Block(Interpolation.LINEAR, arms.at(5.0 * n, 5.0 * (n % 2)), blend=CORNER) for n in range(1, 25)]
    while corners or planner.open:
        if corners and planner.waiting < 6:
            planner.add(corners.pop(0))
            if not corners:
                planner.finish()
        pieces = planner.plan(tau, hurry=True)
        tail = [piece.id for piece in pieces if piece.id in planner.begins]
        if any(piece.new_tail and piece.id == tail[0] for piece in pieces):
            late.append(planner.begins[tail[0]] < tau + 0.02 * len(tail))
        tau = min(tau + 5e-3, planner.end)
    assert planner.place(planner.end) == (24, 1.0)
    assert not any(late) if carried_s else any(late)
