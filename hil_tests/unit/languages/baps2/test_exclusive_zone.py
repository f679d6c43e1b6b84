"""EXCLUSIVE as the lock of a zone that two robots share: it holds through the movements in it (AX-1743)."""

import pytest

from gateway.pure.cell.cell import Cell
from hil_tests.lab.virtual.baps2_bench import ProgramCell
from hil_tests.unit.languages.baps2.running import body, run, short
from hil_tests.unit.languages.baps2.test_two_robots_in_a_cell import memory, two_portals

TWO = ";;KINEMATICS : (1 = PORTAL, 2 = LOADER)\n;;PORTAL.JC_NAMES = A1, A2\n;;LOADER.JC_NAMES = B1, B2\n"


def parallel(first: str, second: str) -> list[tuple[object, ...]]:
    events = run(TWO + body(f"PARALLEL {first} ALSO {second} PARALLEL_END", "SEMAPHORE : ZONE"))
    return [(row[0], row[2]) for row in short(events, "moving")]


@pytest.mark.requirement("RHO-BAP-08", by="gateway.pure.languages.baps2.semaphores:Semaphores.end")
def test_the_second_kinematic_moves_in_when_the_blocks_of_the_first_are_over() -> None:
    first = "EXCLUSIVE ZONE MOVE PORTAL VIA @(1, 0) MOVE PORTAL TO @(2, 0) EXCLUSIVE_END MOVE PORTAL TO @(3, 0)"
    second = "WAIT 0.1 EXCLUSIVE ZONE MOVE LOADER TO @(1, 0) EXCLUSIVE_END"
    assert parallel(first, second) == [(0.0, 1), (1.0, 2), (2.0, 3), (2.0, 4)]


def test_the_blocks_behind_the_part_are_prepared_meanwhile() -> None:
    text = "EXCLUSIVE ZONE MOVE PORTAL VIA @(1, 0) EXCLUSIVE_END MOVE PORTAL TO @(2, 0)"
    prepared = short(run(TWO + body(text, "SEMAPHORE : ZONE")), "move")
    assert prepared == [(0.0, "move", 1), (0.0, "move", 2)]


def test_a_part_without_blocks_ends_at_once() -> None:
    first = "MOVE PORTAL TO @(1, 0) EXCLUSIVE ZONE I = 1 EXCLUSIVE_END"
    events = run(
        TWO + body(f"PARALLEL {first} ALSO EXCLUSIVE ZONE I = 2 WRITE 'IN' EXCLUSIVE_END PARALLEL_END", "SEMAPHORE : ZONE INTEGER : I")
    )
    assert [event["t"] for event in events if event["event"] == "write"] == [0.0]


def test_a_loop_that_enters_again_lets_the_other_one_in_first() -> None:
    part = "RPT 2 TIMES EXCLUSIVE ZONE MOVE {0} TO @(1, 0) MOVE {0} TO @(0, 0) EXCLUSIVE_END RPT_END"
    events = run(TWO + body(f"PARALLEL {part.format('PORTAL')} ALSO {part.format('LOADER')} PARALLEL_END", "SEMAPHORE : ZONE"))
    who = {event["n"]: event["kinematic"] for event in events if event["event"] == "move"}
    begun = [(event["t"], who[event["n"]]) for event in events if event["event"] == "moving"]
    assert begun == [(float(t), "LOADER" if t // 2 % 2 else "PORTAL") for t in range(8)]


def test_a_jump_out_of_the_part_holds_it_to_the_end_of_its_block() -> None:
    first = "EXCLUSIVE ZONE MOVE PORTAL TO @(1, 0) JUMP OUT EXCLUSIVE_END OUT:"
    assert parallel(first, "WAIT 0.1 EXCLUSIVE ZONE MOVE LOADER TO @(1, 0) EXCLUSIVE_END") == [(0.0, 1), (1.0, 2)]


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    return two_portals(tmp_path_factory.mktemp("two"))


def test_two_robots_of_a_cell_are_never_in_the_zone_together(two: Cell) -> None:
    """Two programs; the semaphore is PUBLIC.  In the zone: X beyond 100 and U beyond 100."""
    zone = "EXCLUSIVE ZONE\nMOVE {0} PTP VIA @({1})\nMOVE {0} PTP TO @({2})\nEXCLUSIVE_END\nMOVE {0} PTP TO @({3})"
    files = memory(zone.format("PORTAL", "300, 55, 40, 12", "80, 55, 40, 12", "60, 55, 40, 12"), "PUBLIC SEMAPHORE : ZONE")
    files |= memory(zone.format("LOADER", "300, 55", "80, 55", "60, 55"), "EXTERNAL P : ZONE", name="Q")
    cell = ProgramCell(files, two)
    first, second = cell.start("P"), cell.start("Q")
    assert (cell.ends(first)[0], cell.ends(second)[0]) == ("ended", "ended")
    inside = [(place[0] > 100, place[4] > 100) for place in cell.places]
    assert any(x for x, _ in inside) and any(u for _, u in inside)
    assert (True, True) not in inside


def test_a_part_in_a_part_of_the_same_semaphore_does_not_open_the_zone() -> None:
    inner = "EXCLUSIVE ZONE MOVE PORTAL TO @(2, 0) EXCLUSIVE_END"
    first = f"EXCLUSIVE ZONE MOVE PORTAL TO @(1, 0) {inner} MOVE PORTAL TO @(3, 0) EXCLUSIVE_END"
    second = "WAIT 0.1 EXCLUSIVE ZONE MOVE LOADER TO @(1, 0) EXCLUSIVE_END"
    assert parallel(first, second) == [(0.0, 1), (1.0, 2), (2.0, 3), (3.0, 4)]
