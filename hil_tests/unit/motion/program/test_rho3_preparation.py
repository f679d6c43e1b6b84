"""rho 3 Releases part 2, section 13: block preparation, asynchronous inputs, BLOCK_SEARCH."""

from collections.abc import Iterator

import pytest

from hil_tests.lab.cells.arms import at, portal
from motion.errors import MotionError
from motion.planner.arm import Arm
from motion.program.blocks import Block, Interpolation
from motion.program.preparation import InputKind, Preparation, Read, channel

P5 = 0.004
PREPARATION = "motion.program.preparation:Preparation."


class Inputs:
    """Input 1 as the plant sets it, and what the program saw."""

    def __init__(self) -> None:
        self.value = 0.0
        self.seen: list[float] = []

    def read(self, number: int) -> float:
        assert number == 1
        return self.value


def line(k: int) -> Block:
    return Block(Interpolation.LINEAR, at(20.0 * k))


def program(inputs: Inputs, count: int, reads: dict[int, int]) -> Iterator[Block | Read]:
    """Blocks 1 .. count; before block k the channel reads[k] is read."""
    for k in range(1, count + 1):
        if k in reads:
            yield Read(reads[k], inputs.seen.append)
        yield line(k)


@pytest.mark.requirement("RHO-MOT-44", by="motion.program.preparation:Preparation.block_search")
@pytest.mark.requirement("RHO-MOT-44", by="motion.program.preparation:Preparation.turn")
def test_block_search_5_prepares_at_most_5_blocks_and_an_input_acts_after_5() -> None:
    arm, inputs = Arm(portal(), (0.0, 0.0, 0.0), P5), Inputs()
    ahead = Preparation(arm, program(inputs, 12, dict.fromkeys(range(1, 13), 1001)), inputs.read, P5)
    ahead.block_search(5)
    most, changed_at = 0, None
    for _ in range(2000):
        ahead.turn()
        arm.step()
        most = max(most, arm.prepared)
        if changed_at is None and arm.place().block == 2 and arm.place().share > 0.5:
            changed_at = arm.place().block
            inputs.value = 1.0
        if ahead.ended and arm.place().waiting == 0:
            break
    assert most == 5
    assert inputs.seen.index(1.0) + 1 == 2 + 5 + 1, "the first block that knows it is the sixth behind the one under way"
    for wrong in (0, 12):
        with pytest.raises(MotionError, match="BLOCK_SEARCH"):
            ahead.block_search(wrong)


@pytest.mark.requirement(
    "RHO-MOT-44", by=("motion.program.preparation:Preparation.turn", "motion.program.preparation:Preparation.block_search")
)
@pytest.mark.parametrize("search", [1, 2, 5, 11])
def test_exactly_so_many_blocks_are_prepared_and_the_change_acts_behind_them(search: int) -> None:
    arm, inputs, count = Arm(portal(), (0.0, 0.0, 0.0), P5), Inputs(), 16
    ahead = Preparation(arm, program(inputs, count, dict.fromkeys(range(1, count + 1), 1001)), inputs.read, P5)
    ahead.block_search(search)
    prepared = set()
    for _ in range(4000):
        ahead.turn()
        arm.step()
        if not ahead.ended:
            prepared.add(arm.prepared)
        if arm.place().block == 3 and arm.place().share > 0.5:
            inputs.value = 1.0
        if ahead.ended and arm.place().waiting == 0 and arm.remaining_s == 0.0:
            break
    assert max(prepared) == search
    assert inputs.seen == [0.0] * (3 + search) + [1.0] * (count - 3 - search)
    assert arm.joints[0] == pytest.approx(0.02 * count), "the program ends at its last point"


@pytest.mark.requirement("RHO-MOT-51", by="motion.program.preparation:Preparation._now_read")
@pytest.mark.requirement("RHO-MOT-51", by="motion.program.preparation:Preparation._begin")
def test_a_normal_input_stops_preparation_until_2_cycles_before_the_end_point_and_1001_is_read_at_preparation() -> None:
    arm, inputs = Arm(portal(), (0.0, 0.0, 0.0), P5), Inputs()
    ahead = Preparation(arm, program(inputs, 6, {2: 1, 5: 1001}), inputs.read, P5)
    read = False
    for _ in range(2000):
        left, before = arm.remaining_s, len(inputs.seen)
        ahead.turn()
        if len(inputs.seen) > before and not read:
            read = True
            assert left <= 2 * P5 + 1e-9
            assert arm.joints[0] > 0.019, "block 1 is nearly at its end"
            assert arm.planner.added > 1, "then everything behind it is prepared at once"
        elif not read:
            assert arm.planner.added <= 1 and len(inputs.seen) == 0
        if arm.joints[0] > 0.005:
            inputs.value = 1.0
        arm.step()
        if ahead.ended and arm.place().waiting == 0:
            break
        if len(inputs.seen) == 2:
            assert arm.place().block <= 2, "the asynchronous one was read long before block 5"
            break
    assert inputs.seen == [1.0, 1.0]


def test_channels_and_their_asynchronous_twins() -> None:
    assert channel(120).kind is InputKind.BINARY and channel(1224).kind is InputKind.DEC and channel(1401).kind is InputKind.INTEGER
    assert channel(1001).asynchronous and channel(1001).number == 1 and not channel(408).asynchronous
    for wrong in (0, 121, 200, 225, 409, 1000, 1121, 2001):
        with pytest.raises(MotionError, match="channel"):
            channel(wrong)
