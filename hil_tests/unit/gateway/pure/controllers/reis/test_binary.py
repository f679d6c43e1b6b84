"""Binary inputs and outputs of the Reis.  ROBOTstar V manual: L438-504, L1597-1618, L2272-2276."""

import contextlib

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.reis.binary import Area, BinaryIo, IoFault, SharedOutputs

IN, OUT = Area.INPUT, Area.OUTPUT


@pytest.mark.requirement("RSV-IO-01", by="gateway.pure.controllers.reis.binary:BinaryIo.element")
def test_output_5_3_is_0800h_of_ibin_out_2() -> None:
    image = PicImage()
    io = BinaryIo(image)
    io.write_bit(OUT, True, 5, 3)
    assert [io.element(OUT, n) for n in range(1, 11)] == [0, 0x0800, *[0] * 8]
    assert image.outputs[93] == 8 and not any(image.inputs)
    io.write_bit(OUT, False, 5, 3)
    assert io.element(OUT, 2) == 0


@pytest.mark.requirement("RSV-IO-02", by="gateway.pure.controllers.reis.binary:BinaryIo.element")
def test_inputs_39_7_and_24_0() -> None:
    io = BinaryIo(PicImage())
    io.write_bit(IN, True, 39, 7)
    io.write_bit(IN, True, 24, 0)
    assert [io.element(IN, n) for n in range(1, 11)] == [0, 0, 0, 0, 0, 0, 1, 0, 0, 1 << 31]


@pytest.mark.requirement("RSV-IO-01", "RSV-IO-02", by="gateway.pure.controllers.reis.binary:BinaryIo.set_element")
def test_every_bit_of_every_element() -> None:
    image = PicImage()
    io = BinaryIo(image)
    for area in (IN, OUT):
        for byte in range(40):
            for bit in range(8):
                io.set_element(area, byte // 4 + 1, 1 << 8 * (byte % 4) + bit)
                assert io.read_bit(area, byte, bit) and io.byte(area, byte) == 1 << bit
                io.set_element(area, byte // 4 + 1, 0)
    io.set_element(OUT, 10, -1)
    assert image.outputs[124:128] == b"\xff" * 4
    assert not any(image.outputs[:124]) and not any(image.inputs)


@pytest.mark.requirement("RSV-IO-03", by="gateway.pure.controllers.reis.binary:check_place")
def test_bytes_0_to_39_bits_0_to_7() -> None:
    io = BinaryIo(PicImage())
    for area in (IN, OUT):
        io.write_bit(area, True, 39, 7)
        assert io.read_bit(area, 39, 7)
        for byte, bit in ((40, 0), (0, 8), (-1, 0), (0, -1)):
            with pytest.raises(IoFault, match=r"0\.\.39"):
                io.write_bit(area, True, byte, bit)
            with pytest.raises(IoFault, match=r"0\.\.39"):
                io.read_bit(area, byte, bit)
    taken = []
    for place in ((0, 0), (0, 7), (39, 0), (39, 7), (40, 7), (39, 8)):
        with contextlib.suppress(IoFault):
            io.write_bit(OUT, True, *place)
            taken.append(place)
    assert taken == [(0, 0), (0, 7), (39, 0), (39, 7)]
    for number in (0, 11):
        with pytest.raises(IoFault, match=r"1\.\.10"):
            io.element(OUT, number)


@pytest.mark.requirement("RSV-IO-05", by="gateway.pure.controllers.reis.binary:SharedOutputs.end_of_cycle")
def test_the_plcs_value_remains_where_both_write() -> None:
    io = BinaryIo(PicImage())
    shared = SharedOutputs(io, plc_only=(7,), robot_only=(8,))
    for robot, plc in ((True, False), (False, True)):
        shared.by_plc(plc, 5, 3)
        shared.by_robot(robot, 5, 3)
        shared.by_robot(robot, 5, 4)
        shared.end_of_cycle()
        assert (io.read_bit(OUT, 5, 3), io.read_bit(OUT, 5, 4)) == (plc, robot)
    shared.by_robot(False, 5, 3)
    shared.end_of_cycle()
    assert not io.read_bit(OUT, 5, 3)  # a cycle in which the PLC says nothing
    with pytest.raises(IoFault, match="to the PLC"):
        shared.by_robot(True, 7, 0)
    with pytest.raises(IoFault, match="to the robot"):
        shared.by_plc(True, 8, 0)


def test_a_place_outside_the_image() -> None:
    with pytest.raises(IoFault, match="first byte"):
        BinaryIo(PicImage(), 89)
