"""Outputs of neutral blocks: each at its place of the path, once."""

import pytest

from motion.errors import MotionError
from motion.outputs.on_path import BlockOutputs, Switched
from motion.program.blocks import Output


def test_outputs_switch_in_the_order_of_their_places_with_the_instant_between_two_cycles() -> None:
    block = BlockOutputs((Output(5, 1.0), Output(3, 1.0, 0.1), Output(3, 0.0, 0.04)), 0.3)
    assert block.step(0.15) == []
    assert block.step(0.19) == []
    (first,) = block.step(0.21)
    assert first[:2] == (3, 1.0) and first.share == pytest.approx(0.5)
    assert [s[:2] for s in block.step(0.3)] == [(3, 0.0), (5, 1.0)]
    assert block.step(0.3) == []


def test_going_back_and_on_again_does_not_switch_twice() -> None:
    block = BlockOutputs((Output(1, 1.0, 0.1),), 0.3)
    assert len(block.step(0.25)) == 1
    assert block.step(0.1) == [] and block.step(0.25) == []


def test_an_output_at_the_very_start_switches_in_the_first_cycle() -> None:
    assert BlockOutputs((Output(1, 1.0, 0.3),), 0.3).step(0.0) == [Switched(1, 1.0, 1.0)]


@pytest.mark.parametrize("before", [-0.1, 0.4, float("nan")])
def test_places_outside_the_block_are_refused(before: float) -> None:
    with pytest.raises(MotionError, match="output 1"):
        BlockOutputs((Output(1, 1.0, before),), 0.3)
