"""Offsets of belts over power-off (issue 6, retained data; AX-480): the counter comes back with what the encoder says then."""

from math import isnan, nan

import pytest

from gateway.assembly.cycle_belts import Encoder
from gateway.assembly.limits import limits_of
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.image.records.cell import InputImage
from hil_tests.lab.running.belt_run import INCREMENT
from hil_tests.lab.virtual.belt_bench import CELL, FACTS, MACHINE, BeltBench

SPAN16 = 1 << 16


class Counting:
    """The first belt of three, with an encoder of 16 bits; each look is a cycle."""

    def __init__(self) -> None:
        self.belts = CoreBelts(FACTS, {1: MACHINE.kinematics}, [limits_of(axis) for axis in CELL.axis], 0.004)
        self.encoder = Encoder(self.belts, 0, 0, 2)
        self.inputs = InputImage()

    def says(self, *raw: int) -> "Counting":
        for value in raw:
            self.encoder.hear(value.to_bytes(2, "little"))
            self.belts.update(self.inputs)
        return self

    @property
    def counter(self) -> float:
        return self.belts.all.all[0].counter


def test_a_counter_begins_at_0_where_nothing_was_kept_and_goes_on_where_its_offset_was() -> None:
    first = Counting().says(1000, 1500)
    assert first.counter == pytest.approx(500 * INCREMENT) and isnan(first.belts.offset(0)), "nobody has said what was kept"
    first.belts.restore(0, nan)
    first.says(1600)
    assert first.counter == pytest.approx(600 * INCREMENT)
    first.belts.all.all[0].set_counter(0.0)
    first.says(1700)
    offset = first.belts.offset(0)
    assert offset == pytest.approx(-1600 * INCREMENT)
    second = Counting()
    second.belts.restore(0, offset)
    second.says(2100)  # it ran while nobody looked
    assert second.counter == pytest.approx(500 * INCREMENT) and second.belts.offset(0) == pytest.approx(offset)
    second.belts.restore(0, 99.0)
    assert second.says(2200).counter == pytest.approx(600 * INCREMENT), "it is taken once"


def test_an_offset_follows_the_roll_over_of_the_telegram_in_both_directions() -> None:
    belt = Counting().says(SPAN16 - 10)
    belt.belts.restore(0, nan)
    belt.says(SPAN16 - 1, 20)
    assert belt.counter == pytest.approx(30 * INCREMENT)
    again = Counting()
    again.belts.restore(0, belt.belts.offset(0))
    assert again.says(25).counter == pytest.approx(35 * INCREMENT)
    back = again.says(0, SPAN16 - 5)
    assert back.counter == pytest.approx(5 * INCREMENT)
    third = Counting()
    third.belts.restore(0, back.belts.offset(0))
    assert third.says(SPAN16 - 4).counter == pytest.approx(6 * INCREMENT)


def test_belts_that_are_not_there_and_belts_without_an_encoder_keep_nothing() -> None:
    belt = Counting()
    for place in (0, 1, 7, 255):
        belt.belts.restore(place, 1.0)
    belt.says(100, 200)
    assert belt.counter == pytest.approx(1.0 + 200 * INCREMENT)
    assert isnan(belt.belts.offset(1)) and belt.belts.all.all[1].counter == 0.0


def test_a_new_cycle_gets_the_counter_back_by_an_order_of_the_services() -> None:
    bench = BeltBench()
    bench.dispatcher.restore_belt_offset(0, nan)
    bench.drive(1, 0.15)
    bench.run(0.2)
    bench.zero(1)
    bench.run(0.4)
    before, offset = bench.core.state.belt, bench.belts.offset(0)
    assert before == pytest.approx(0.06, abs=0.002) and not isnan(offset)
    bench.restart_cycle()
    bench.cycle(2)
    assert bench.core.state.belt < 0.005, "a new one begins at 0"
    bench.dispatcher.restore_belt_offset(0, offset)
    bench.run(0.1)
    assert bench.core.state.belt == pytest.approx(before + 0.015, abs=0.002)
    assert bench.belts.offset(0) == pytest.approx(offset, abs=INCREMENT)
