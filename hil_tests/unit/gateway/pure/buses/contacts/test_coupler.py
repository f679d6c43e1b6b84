"""AX-400, AX-401: our side of a CiA 401 coupler against an emulated one in virtual time, and what contacts show."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest

from drivers.drives import io_boot
from drivers.drives.canopen_steps import Answer, Nmt, Read, Refused, Silent, Write
from drivers.drives.cia402_boot import BootRefused
from drivers.drives.cia402_family import Cia402Family
from drivers.emulator.io.coupler_401 import Couplers
from gateway.assembly.contacts import couplers_of, falls, outputs_of
from gateway.files.find import find_config
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.buses.cia401 import REFRESH, Coupler, CouplerFamily, contacts_lost
from gateway.pure.buses.contacts import FORCED, Output, Outputs, Said, Source, pack_said, source_of, unpack_said
from gateway.pure.cell.cell import Cell, Io, IoDevice
from gateway.pure.controllers.reis.binary import Area
from gateway.pure.controllers.reis.control import ReisControl, ReisSetup
from gateway.pure.image.records.cell import AxisFlag, AxisState, CellState, Quality
from protocols.base.machine import Frame, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import eds
from protocols.canopen.nmt import Command

SHEET, _ = eds.parse(find_config("axisgate_401.eds", "drives").read_text())
NODE = 20
PLAN = io_boot.CouplerPlan(NODE, (), falls=((0, 0b11, 0b10), (1, 0b10, 0)), channels=10)
P5 = ms(4)


class Bench:
    """The emulated node, a family that speaks to it once per cycle, and a master with perfect hearing."""

    def __init__(self, coupler: Coupler | None = None) -> None:
        self.now = ms(1000)
        self.emulated = Couplers({NODE: SHEET})
        self.coupler = coupler or Coupler(NODE, {0: 0, 1: 1, 9: 2}, {0: 3, 17: 4})
        self.family = CouplerFamily(Cia402Family([], 12, 12), [self.coupler], 50)
        self.heard: list[Frame] = []
        self.cycles(20)

    def bus(self, frames: Sequence[Frame]) -> list[Frame]:
        """Frames to the node; what it says at once, heard by the family."""
        self.emulated.receive([frame._replace(stamp_ns=self.now) for frame in frames], self.now)
        self.emulated.wake(self.now)
        said = self.emulated.take_output()
        for frame in said:
            self.family.hear(frame)
        self.heard += said
        return said

    def cycles(self, count: int) -> list[Frame]:
        """Bursts of the family."""
        sent = []
        for _ in range(count):
            self.now += P5
            sent += self.family.burst([])
            self.bus(sent[-1:] if not sent else self._last(sent))
        return sent

    def _last(self, sent: list[Frame]) -> list[Frame]:
        return sent[max(n for n, frame in enumerate(sent) if frame.identifier == cobid.SYNC) :]

    def answer(self, step: object) -> Answer:
        objects = self.emulated.nodes[NODE].objects
        match step:
            case Read(index, sub):
                found = objects.upload((index, sub))
                return found if isinstance(found, bytes) else Refused(int(found))
            case Write(index, sub, data):
                code = objects.download((index, sub), data)
                return Refused(code) if code else b""
            case Nmt(command, _):
                self.bus([Frame(cobid.NMT, bytes((command, NODE)))])
                self.cycles(20)
        return b""

    def boot(self, plan: io_boot.CouplerPlan = PLAN) -> int:
        steps = io_boot.boot(plan)
        try:
            step = next(steps)
            while True:
                step = steps.send(self.answer(step))
        except StopIteration as end:
            self.family.release(NODE, end.value.mode)
            self.bus([])
            self.answer(Nmt(Command.PRE_OPERATIONAL))
            self.answer(Nmt(Command.START))
            return int(end.value.mode)

    def play(self, plan: io_boot.CouplerPlan, answers: Mapping[object, Answer]) -> None:
        """The start-up with some answers replaced."""
        steps = io_boot.boot(plan)
        step = next(steps)
        while True:
            step = steps.send(answers[step] if step in answers else self.answer(step))

    def outputs(self) -> int:
        return int.from_bytes(self.emulated.terminals[NODE].outputs, "little")


def test_outputs_reach_the_terminals_and_inputs_come_back_good() -> None:
    bench = Bench()
    assert bench.family.said()[3].quality is Quality.BAD, "before its start-up nothing is good"
    assert bench.boot() == 4
    bench.family.show({0: True, 1: False, 2: True})
    bench.cycles(2)
    assert bench.outputs() == 0b10_0000_0001
    bench.emulated.wire(NODE, 17, True, bench.now)
    bench.bus([])
    said = bench.family.said()
    assert said[3] == Said(True, Quality.GOOD) and said[4] == Said(True, Quality.GOOD), "0 follows output 0, 17 is wired"


def test_unchanged_outputs_are_sent_again_now_and_then_and_not_always() -> None:
    bench = Bench()
    bench.boot()
    bench.family.show({0: True})
    rpdos = [frame for frame in bench.cycles(4 * REFRESH) if frame.identifier == cobid.rpdo(1, NODE)]
    assert 4 <= len(rpdos) <= 6 and rpdos[-1].data == b"\x01\0\0\0"


def test_without_our_heartbeat_outputs_fall_to_their_error_values() -> None:
    bench = Bench()
    bench.boot()
    bench.family.show({0: True, 1: False, 2: True})
    bench.cycles(2)
    for _ in range(100):
        bench.now += P5
        bench.bus([])
    assert bench.outputs() == 0b10


def test_a_coupler_that_was_reset_or_falls_silent_is_bad_until_it_is_released_again() -> None:
    bench = Bench()
    bench.boot()
    bench.cycles(2)
    assert bench.family.said()[3].quality is Quality.GOOD
    bench.bus([Frame(cobid.NMT, bytes((Command.RESET_NODE, NODE)))])
    sent = bench.cycles(40)
    assert bench.family.said()[3] == Said() and bench.family.said()[0].quality is Quality.BAD
    assert not [frame for frame in sent[-20:] if frame.identifier == cobid.rpdo(1, NODE)]
    bench.boot()
    assert bench.family.said()[3].quality is Quality.GOOD
    for _ in range(60):
        bench.family.burst([])
    assert bench.family.said()[3].quality is Quality.BAD, "nothing came for longer than its patience"


@pytest.mark.parametrize(
    ("plan", "answers", "words"),
    [
        (PLAN, {Read(0x1000): (402).to_bytes(4, "little")}, "device profile 402"),
        (PLAN, {Read(0x1000): Silent.YES}, "no answer"),
        (io_boot.CouplerPlan(NODE, (), channels=33), {}, "32 outputs mapped"),
        (PLAN, {Write(0x1016, 1, (127 << 16 | 150).to_bytes(4, "little")): Refused(0x06020000)}, "refused"),
        (PLAN, {Write(0x1017, 0, (50).to_bytes(2, "little")): Silent.YES}, "no answer"),
    ],
)
def test_a_coupler_that_will_not_is_not_started(plan: io_boot.CouplerPlan, answers: dict[object, Answer], words: str) -> None:
    bench = Bench()
    with pytest.raises(BootRefused) as refused:
        bench.play(plan, answers)
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("refused", "words"),
    [
        (Write(0x1016, 1, (127 << 16 | 150).to_bytes(4, "little")), r"1016h:01.*: refused 96 00 7f 00"),
        (Write(0x6206, 1, b"\x03"), r"6206h:01: refused 03"),
    ],
)
def test_a_coupler_that_refuses_what_its_outputs_need_goes_on_with_its_inputs(refused: Write, words: str) -> None:
    bench = Bench()
    plan = replace(PLAN, inputs=True)
    steps, booted = io_boot.boot(plan), None
    step = next(steps)
    while booted is None:
        try:
            step = steps.send(Refused(0x06020000) if step == refused else bench.answer(step))
        except StopIteration as end:
            booted = end.value
    assert re.search(words, booted.refused) and booted.refused.startswith("its outputs are not driven: ")
    bench.family.release(NODE, booted.mode & 0xFF)
    bench.answer(Nmt(Command.PRE_OPERATIONAL))
    bench.answer(Nmt(Command.START))
    bench.family.show({0: True})
    sent = bench.cycles(2 * REFRESH)
    assert not [frame for frame in sent if frame.identifier == cobid.rpdo(1, NODE)], "an output that could stay on is not switched on"
    bench.emulated.wire(NODE, 17, True, bench.now)
    bench.bus([])
    said = bench.family.said()
    assert said[4] == Said(True, Quality.GOOD) and said[0].quality is Quality.BAD


@pytest.mark.parametrize(("vital_inputs", "vital_outputs"), [(True, False), (False, True), (False, False)])
def test_a_coupler_away_takes_readiness_where_its_signals_matter(vital_inputs: bool, vital_outputs: bool) -> None:
    bench = Bench()
    bench.coupler.vital_inputs, bench.coupler.vital_outputs = vital_inputs, vital_outputs
    matters = vital_inputs or vital_outputs
    assert contacts_lost([bench.family]) is matters, "before its start-up"
    bench.boot()
    bench.cycles(2)
    assert not contacts_lost([bench.family])
    bench.family.release(NODE, io_boot.INPUTS_ONLY)
    assert contacts_lost([bench.family]) is vital_outputs, "its inputs go on"
    bench.boot()
    for _ in range(60):
        bench.family.burst([])
    assert contacts_lost([bench.family]) is matters, "silent for longer than its patience"


def test_outputs_with_on_loss_are_what_a_coupler_falls_to() -> None:
    contacts = [Io(f"c{n}", IoDevice("canopen-401", "can0", NODE, output=n), "cell.ready", loss) for n, loss in enumerate((0, 1, None))]
    assert falls(contacts, Coupler(NODE, {0: 0, 1: 1, 10: 2})) == ((0, 0b11, 0b10), (1, 0b100, 0))


def test_what_outputs_show() -> None:
    axes = ["X", "Z"]
    assert source_of("cell.ready", axes, None)[0] is Source.READY
    assert source_of("axis.Z.brake", axes, None)[:2] == (Source.BRAKE, 1)
    assert source_of("axis.X.referenced", axes, None)[2] is AxisFlag.REFERENCED
    assert source_of("axis.Q.brake", axes, None)[0] is Source.SERVICES and source_of("LAMP", axes, 70)[3] == 70
    state = CellState(ready=True, cycle=0, axes=[AxisState(flags=AxisFlag.ENABLED), AxisState(flags=AxisFlag.ENABLED | AxisFlag.FAULT)])
    outputs = Outputs(
        [
            Output(0, Source.READY), Output(1, Source.WATCHDOG, half=2), Output(2, Source.BRAKE, axis=0), Output(3, Source.BRAKE, axis=1),
            Output(4, Source.SERVICES, on_loss=1), Output(5, Source.SERVICES), Output(6, Source.DRIVES_ON),
            Output(7, Source.RC_OUTPUT, bit=9),
        ],
        2,
    )  # fmt: skip
    said = [Said()] * 4 + [Said(False, Quality.GOOD), Said(True, Quality.GOOD), Said(), Said()]
    assert outputs.show(state, b"\x00\x02", said) == {0: True, 1: False, 2: True, 3: False, 4: False, 5: True, 6: True, 7: True}
    gone = outputs.show(state, b"\x00\x02", [])
    assert gone[4] is True and gone[5] is True, "on_loss, or the last value"
    levels = []
    for cycle in range(8):
        state.cycle = cycle
        levels.append(outputs.show(state, b"\x00\x02", [])[1])
    assert levels == [False, False, True, True] * 2
    state.cycle = 7
    assert {outputs.show(state, b"\x00\x02", [])[1] for _ in range(20)} == {True}, "no cycle, no toggle"


def test_a_forced_output_shows_what_it_is_forced_to_and_the_watchdog_never_does() -> None:
    outputs = Outputs([Output(0, Source.READY), Output(1, Source.WATCHDOG)], 0)
    forced = [Said(True, Quality.GOOD, forced=True), Said(True, Quality.GOOD, forced=True)]
    assert outputs.show(CellState(), bytes(128), forced) == {0: True, 1: False}
    assert unpack_said(pack_said(forced))[:3] == [*forced, Said()] and pack_said(forced)[1] & FORCED


@pytest.mark.requirement(
    "RSV-IO-08", by=("gateway.assembly.contacts:couplers_of", "gateway.pure.controllers.reis.control:ReisControl.value")
)
def test_output_3_7_of_a_reis_switches_channel_15_of_its_module_alone() -> None:
    """A module with 16 outputs is bytes 2 and 3 (L504): each contact has the output of the Reis as its signal."""
    device = [IoDevice("canopen-401", "can0", NODE, output=channel) for channel in range(16)]
    contacts = [Io(f"c{n}", device[n], f"reis.output.{2 + n // 8}.{n % 8}") for n in range(16)]
    cell = cast(Cell, SimpleNamespace(io=contacts, axis=[], signals={}))
    (coupler,) = couplers_of(cell, "can0")
    bench, outputs = Bench(coupler), Outputs(outputs_of(cell, "canopen-401", 4), 0)
    bench.boot(io_boot.CouplerPlan(NODE, (), falls=(), channels=16))
    control = ReisControl(ReisSetup(), CommandDispatcher((), lambda *_: b"", 1))
    switched = []
    for byte, bit in ((3, 7), (4, 0), (2, 0)):
        control.io.write_bit(Area.OUTPUT, True, byte, bit)
        said = [Said(bool(control.value(io.signal)), Quality.GOOD) for io in contacts]
        bench.family.show(outputs.show(CellState(ready=True, cycle=0, axes=[]), b"", said))
        bench.cycles(2)
        switched.append(bench.outputs())
    assert switched == [1 << 15, 1 << 15, 1 << 15 | 1]
