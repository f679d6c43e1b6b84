"""rho 3 Releases part 5, 6.13 (L7459-7475), part 1 (L686): CAN diagnosis lists every faulty block; 7.14 and 7.15 show bits live."""

import pytest

from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.messages import IoError, Trouble
from gateway.pure.controllers.rho3.can.rules import Block
from gateway.pure.controllers.rho3.can.tables import Side
from protocols.base.machine import Frame, ms

INPUTS = (Block(88, 4, 541), Block(92, 2, 542), Block(94, 2, 543))
OUTPUTS = (Block(88, 2, 471), Block(90, 1, 472))


@pytest.mark.requirement("RHO-CAN-26", by="gateway.pure.controllers.rho3.can.blocks:IoBus.cycle")
def test_every_faulty_module_is_listed_by_its_own_kind_and_leaves_the_list_alone() -> None:
    bus = IoBus(IoSettings(2, INPUTS, OUTPUTS), 0)

    def cycle(number: int, **frames: int) -> list[IoError]:
        for name, count in frames.items():
            block = INPUTS[int(name[1:]) - 1]
            for _ in range(count):
                bus.receive(Frame(block.identifier, bytes([number] * block.length)), ms(number))
        return bus.cycle(ms(number))

    assert cycle(1, b2=1) == [] and bus.errors == [], "modules may come one cycle late at the start"
    assert cycle(2, b1=1, b2=1) == [IoError(Trouble.SILENT, 2, 3)]
    for number in (3, 4):
        cycle(number, b1=1, b2=1, b3=1)
    assert bus.errors == []
    assert cycle(5, b1=1, b2=2) == [IoError(Trouble.SILENT, 2, 3)]
    assert bus.errors == [IoError(Trouble.INADMISSIBLE, 2, 2), IoError(Trouble.SILENT, 2, 3)], "both, each with its kind"
    cycle(6, b1=1, b2=2, b3=1)
    assert bus.errors == [IoError(Trouble.INADMISSIBLE, 2, 2)], "module 3 is well, module 2 still sends twice"
    cycle(7, b1=1, b2=1)
    assert bus.errors == [IoError(Trouble.SILENT, 2, 3)], "and the other way round"
    cycle(8, b1=1, b2=1, b3=1)
    assert bus.errors == []
    assert cycle(9) == [IoError(Trouble.SILENT, 2, number) for number in (1, 2, 3)]


@pytest.mark.requirement(
    "RHO-CAN-26", by=("gateway.pure.controllers.rho3.can.blocks:IoBus.cycle", "gateway.pure.controllers.rho3.can.blocks:IoBus.live")
)
def test_two_faulty_modules_are_both_listed_and_the_bits_of_all_blocks_are_shown_as_they_are_now() -> None:
    bus = IoBus(IoSettings(2, INPUTS, OUTPUTS), 0)
    for cycle in range(1, 4):
        for block in INPUTS:
            bus.receive(Frame(block.identifier, bytes([cycle] * block.length)), ms(cycle))
        bus.cycle(ms(cycle))
    assert bus.errors == []
    assert bus.live(Side.INPUT) == [(541, b"\3\3\3\3"), (542, b"\3\3"), (543, b"\3\3")]
    for cycle in range(4, 6):  # 541 and 543 have failed
        bus.receive(Frame(542, b"\xa5\x5a"), ms(cycle))
        bus.cycle(ms(cycle))
    assert bus.errors == [IoError(Trouble.SILENT, 2, 1), IoError(Trouble.SILENT, 2, 3)], "both, not only the first"
    assert [error.trouble.phg(error.bus, error.block) for error in bus.errors] == ["no transm. CAN2 I1", "no transm. CAN2 I3"]
    assert bus.live(Side.INPUT)[1] == (542, b"\xa5\x5a")
    image = bytearray(128)
    image[88:91] = b"\x81\x00\x07"
    bus.frames(image)
    assert bus.live(Side.OUTPUT) == [(471, b"\x81\x00"), (472, b"\x07")]
    image[90] = 8
    bus.frames(image)
    assert bus.live(Side.OUTPUT)[1] == (472, b"\x08")
    for identifier, length in ((541, 4), (543, 2)):
        bus.receive(Frame(identifier, bytes(length)), ms(6))
    bus.receive(Frame(542, bytes(2)), ms(6))
    bus.cycle(ms(6))
    assert bus.errors == []
