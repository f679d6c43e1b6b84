"""AX-481: inputs of [[measuring]] whose wire ends on a bus of the cycle act in the cycle that hears them, not a way round later."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from drivers.drives.cia402_family import Cia402Family
from gateway.assembly.fast_inputs import fast_wires
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config
from gateway.pure.arbitration.jobs import Job
from gateway.pure.buses.cia401 import Coupler, CouplerFamily
from gateway.pure.cell.belts import Measuring
from gateway.pure.cell.cell import Cell, Io, IoDevice
from gateway.pure.cell.routes import Route
from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.family import RhoFamily
from gateway.pure.controllers.rho3.can.rules import Block
from gateway.pure.image.fast_inputs import FastWires, InputLevel
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import InputImage, Motion, Quality, get_bit
from gateway.pure.image.records.planner import MeasuringFacts
from hil_tests.lab.virtual.probing import CLOSE, ON_ALL, Probing
from hil_tests.lab.virtual.program_bench import CELL, joints
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid

PROBE, NODE, BLOCK = 300, 20, 541
CONTACT = Io("probe", IoDevice("canopen-401", "can0", NODE, input=3), "cell.safety_ok")
CHIP = Io("chip", IoDevice("gpiochip", chip="/dev/gpiochip0", input=3), "cell.safety_ok")
MEASURING = "\n[[measuring]]\nchannel = {}\ninput = {}\n"
PLAIN = Route("probe", "io.probe", f"A {PROBE // 8}.{PROBE % 8}")


def coupler() -> CouplerFamily:
    """Released, and not heard yet."""
    family = CouplerFamily(Cia402Family([], 12, 12), [Coupler(NODE, {}, {3: 0})], 50)
    family.release(NODE, 1)
    return family


def test_check_reports_which_way_each_measuring_input_takes() -> None:
    text = find_config("cl300-bits", "cells").read_text() + "".join(
        MEASURING.format(channel, number) for channel, number in ((611, 28), (612, 27))
    )
    told = {notice.where: notice.text for notice in load_cell("cl300-bits.toml", text).notes if notice.where.startswith("measuring")}
    assert told == {
        "measuring.611.input": "RC input 28 is read in the cycle (AX-481)",
        "measuring.612.input": "RC input 27 passes through the services process, one or two cycles later (AX-481)",
    }, "its route debounces"


def says(family: CouplerFamily, octet: int, stamp: Ns) -> None:
    family.hear(Frame(cobid.tpdo(1, NODE), bytes((octet,)), stamp))


def blocks() -> RhoFamily:
    """E 94 and E 95 in an input block."""
    return RhoFamily(IoBus(IoSettings(2, (Block(94, 2, BLOCK),)), 0))


def cell_with(*routes: Route, io: Sequence[Io] = (CONTACT,), number: int = PROBE) -> Cell:
    return replace(CELL, io=tuple(io), route=routes, measuring=(Measuring(610, number),))


def wires(cell: Cell, family: CouplerFamily | RhoFamily) -> FastWires:
    found = fast_wires(cell, {"can0": family})
    assert found is not None, "its wire ends in the cycle"
    return found


def test_a_level_heard_in_the_cycle_goes_over_what_the_services_say_for_as_long_as_its_module_is_good() -> None:
    family, image = coupler(), InputImage()
    made = wires(cell_with(PLAIN), family)
    image.quality[PROBE >> 3], image.stamps[PROBE >> 3] = Quality.GOOD, 5
    assert not made.over(image).bit(PROBE), "nothing was heard yet"
    says(family, 0b1000, ms(7))
    seen = made.over(image)
    assert (seen.bit(PROBE), seen.stamps[PROBE >> 3], image.bit(PROBE)) == (True, ms(7), False)
    assert made.over(image) is seen, "nothing new, nothing made"
    says(family, 0b1000, ms(8))
    assert made.over(image).stamps[PROBE >> 3] == ms(7), "the stamp is that of the change"
    says(family, 0b0111, ms(9))
    seen = made.over(image)
    assert (seen.bit(PROBE), seen.stamps[PROBE >> 3]) == (False, ms(9))
    says(family, 0b1000, ms(10))
    family.hold(NODE)
    assert made.over(image).bit(PROBE) is False and made.over(image).stamps[PROBE >> 3] == 5, "the services' word counts again"
    later = InputImage()
    later.values[PROBE >> 3] = 0xFF
    assert made.over(later).bit(PROBE), "and a new image is a new one"


def test_a_block_of_inputs_is_heard_with_the_stamp_of_its_change() -> None:
    family, image = blocks(), InputImage()
    made = wires(cell_with(Route("probe", "E 95.2", f"A {PROBE // 8}.{PROBE % 8}"), io=()), family)
    assert not made.over(image).bit(PROBE)
    for octets, stamp, level, changed in (((0, 4), 3, True, 3), ((0, 4), 4, True, 3), ((0, 0), 6, False, 6)):
        family.hear(Frame(BLOCK, bytes(octets), ms(stamp)))
        seen = made.over(image)
        assert (seen.bit(PROBE), seen.stamps[PROBE >> 3]) == (level, ms(changed))
        assert family.io is not None and family.io.cycle(ms(stamp)) == []
    family.hear(Frame(BLOCK, bytes((0, 4)), ms(8)))
    assert made.over(image).bit(PROBE)
    assert family.io is not None
    for n in range(4):
        family.io.cycle(ms(20 + n))
    assert not made.over(image).bit(PROBE), "its module is silent: nobody vouches for it"


@pytest.mark.parametrize(
    ("cell", "level"),
    [
        (cell_with(PLAIN), True),
        (cell_with(replace(PLAIN, scale=-1.0, offset=1.0)), False),
        (cell_with(io=(replace(CONTACT, signal="cell.feed_hold_not"),), number=27), True),
        (cell_with(io=(replace(CONTACT, signal="FEED_HOLD_N_RCI"),), number=27), True),
    ],
)
def test_the_wire_is_the_plain_route_or_the_contact_the_cell_has(cell: Cell, level: bool) -> None:
    family, number = coupler(), cell.measuring[0].input
    says(family, 0b1000, ms(1))
    seen = wires(cell, family).over(InputImage())
    assert [n for n in range(1024) if get_bit(seen.values, n)] == [number] * level


@pytest.mark.parametrize(
    "cell",
    [
        cell_with(replace(PLAIN, debounce_ms=20)),
        cell_with(replace(PLAIN, edge="rising")),
        cell_with(replace(PLAIN, every_ms=50)),
        cell_with(replace(PLAIN, scale=2.0)),
        cell_with(replace(PLAIN, from_="io.chip"), io=(CHIP,)),
        cell_with(replace(PLAIN, from_="A 10.0"), io=()),
        cell_with(replace(PLAIN, from_="E 94.0"), io=()),
        cell_with(PLAIN, number=PROBE + 1),
        replace(cell_with(PLAIN), measuring=()),
    ],
)
def test_what_is_more_than_a_wire_or_ends_elsewhere_comes_through_the_services(cell: Cell) -> None:
    assert fast_wires(cell, {"can0": coupler()}) is None


class Wired(Probing):
    """Its probe hangs on a coupler; the services never say anything of it."""

    def __init__(self) -> None:
        super().__init__()
        self.programs.cell.channels = {610: MeasuringFacts(PROBE, ON_ALL)}
        self.family = coupler()
        self.wires = wires(cell_with(PLAIN), self.family)
        self.image = self.cell.inputs
        self.says(0)

    def says(self, octet: int) -> None:
        says(self.family, octet, self.cell.now)

    def motion(self) -> Motion:
        return self.cell.core.state.motion

    def cycles(self, count: int = 1) -> None:
        for _ in range(count):
            self.cell.inputs = self.wires.over(self.image)
            self.cell.cycle()

    def cycles_until(self, holds: Callable[[], bool]) -> None:
        for _ in range(3000):
            if holds():
                return
            self.cycles()
        raise AssertionError(f"never: {self.cell.core.state}")

    def on_its_way(self) -> Job:
        """A block that ends with the probe has begun, and is a good part of its way along."""
        job = self.order(f"ptp joints {joints(90)} until=ch610")
        self.cycles_until(lambda: self.places()[0] > 20.0)
        return job


def test_move_until_leaves_its_path_in_the_very_cycle_that_hears_the_probe() -> None:
    bench = Wired()
    job = bench.on_its_way()
    stamp = bench.cell.now - bench.cell.period_ns // 3
    says(bench.family, 0b1000, stamp)
    assert bench.motion() is Motion.RUNNING
    bench.cycles()
    assert bench.motion() is Motion.STOPPING, "no way round by the services"
    assert not bench.image.bit(PROBE)
    bench.cycles_until(lambda: not job.open)
    assert job.state is CommandState.DONE
    assert bench.measured == pytest.approx(bench.was(stamp), abs=CLOSE)


def test_an_edge_reported_behind_the_sync_of_its_cycle_is_measured_where_it_was() -> None:
    """A module that speaks at once is heard in the cycle of its edge: the positions of that instant come with the next SYNC."""
    bench = Wired()
    job = bench.on_its_way()
    stamp = bench.cell.now + bench.cell.period_ns // 4
    says(bench.family, 0b1000, stamp)
    bench.cycles_until(lambda: not job.open)
    assert job.state is CommandState.DONE
    assert bench.measured == pytest.approx(bench.was(stamp), abs=CLOSE)


def test_a_wire_that_is_bad_is_reported_as_nothing() -> None:
    family = coupler()
    assert family.input_at(NODE, 3) is None
    says(family, 8, ms(2))
    assert family.input_at(NODE, 3) == InputLevel(True, ms(2)) and family.input_at(NODE, 17) is None
    for _ in range(60):
        family.burst([])
    assert family.input_at(NODE, 3) is None, "silent for longer than its patience"
