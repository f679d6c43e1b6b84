"""What the planner reports as done: by the piece the cycle is on, and at rest only what it has run."""

from gateway.pure.planning.chain import UNSEEN, Chain
from motion.execution.timed import TimedPiece


def piece(number: int) -> TimedPiece:
    rest = (0.0,) * 6  # one axis, and the way
    return TimedPiece(number, 1, 1, (0.0, 0.1), (rest, rest), (1.0, 1.0), (1.0, 1.0))


def chain(*begins: tuple[int, float, int]) -> Chain:
    made = Chain()
    for number, tau, passed in begins:
        made.add(piece(number), tau, passed)
    return made


def test_blocks_behind_a_rest_are_not_over_before_their_pieces_are_run() -> None:
    path = chain((1, 0.0, 0))
    assert (path.tau(1, 0.1), path.passed(1, 0)) == (0.1, 0)
    assert (path.tau(0, 0.1), path.passed(0, 1)) == (0.1, 1), "run out at its end"
    path.add(piece(2), 0.1, 1)
    path.add(piece(3), 1.0, 2)
    assert path.tau(0, 2.0) == 0.1 and path.passed(0, 3) == 1, "handed on, and not begun"
    assert path.tau(2, 2.0) == 1.0 and path.passed(2, 3) == 1
    assert path.tau(3, 1.05) == 1.05 and path.passed(3, 3) == 2
    assert path.tau(0, 1.05) == 1.05 and path.passed(0, 3) == 3


def test_a_cycle_that_has_not_got_the_next_piece_yet_is_not_at_the_end() -> None:
    path = chain((1, 0.0, 0), (2, 0.08, 1))
    path.tau(1, 1.5)
    assert path.tau(0, 1.5) == 0.08 and path.passed(0, 2) == 0
    assert path.tau(2, 1.5) == 1.5 and path.passed(2, 2) == 1


def test_pieces_shorter_than_a_turn_are_over_though_the_cycle_was_never_seen_on_them() -> None:
    path = chain((1, 0.0, 0))
    path.tau(1, 0.1)
    path.tau(0, 0.1)
    path.add(piece(2), 0.1, 1)
    for _ in range(UNSEEN):
        assert path.passed(0, 2) <= 1
        path.tau(0, 0.101)
    path.tau(0, 0.101)
    assert path.passed(0, 2) == 2


def test_a_piece_that_is_still_in_the_ring_is_not_run_however_long_it_takes() -> None:
    path = chain((1, 0.0, 0), (2, 0.05, 1))
    assert path.tau(1, 0.1) == 0.05
    assert {path.tau(0, 0.1, waits=True) for _ in range(UNSEEN + 2)} == {0.05} and path.passed(0, 2) == 0
    assert path.tau(0, 0.1) == 0.1 and path.passed(0, 2) == 2
