"""P20 and P21, the expanded interface, remote blocks.  rho 3 release manual: L7693-7767, L11073-11258, L11711-11713."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.coupling import (
    WITHOUT_MTB,
    Block,
    BlockJoiner,
    Coupling,
    CouplingFault,
    Ranges,
    flag_byte,
    flag_index,
    in_blocks,
    io_index,
)
from gateway.pure.image.addresses import Direction, RcBit, cl300

COUPLING = "gateway.pure.controllers.rho3.signals.coupling:"


def numbered() -> PicImage:
    return PicImage(bytearray(range(128)), bytearray(range(128, 256)))


@pytest.mark.requirement("RHO-PLC-29", by="gateway.pure.controllers.rho3.signals.coupling:Coupling.board_addresses")
def test_9_3_addresses_of_the_board_as_printed() -> None:
    assert Coupling(15).board_addresses() == ("I45.0-I52.7", "O45.0-O49.7")
    assert Coupling(16).board_addresses() == ("I88.0-I95.7", "O88.0-O92.7")
    assert Coupling(15, Ranges(10, 54, 10, 54)).board_addresses() == ("I55.0-I62.7", "O55.0-O59.7")
    assert Coupling(16, Ranges(10, 73, 10, 91)).board_addresses() == ("I74.0-I81.7", "O92.0-O96.7")
    assert Coupling(16, WITHOUT_MTB).board_addresses() == ("I64.0-I71.7", "O82.0-O86.7")
    assert Coupling(19).board_addresses() is None


@pytest.mark.requirement("RHO-PLC-29", by="gateway.pure.controllers.rho3.signals.coupling:_checked")
def test_p21_is_checked_against_p20() -> None:
    for p20, ranges, words in (
        (19, Ranges(2, 89, 0, 87), "I.START 2"),
        (19, Ranges(0, 87, 1, 88), "O.START 1"),
        (15, Ranges(208, 248, 0, 44), "at most 247"),
        (16, Ranges(0, 87, 200, 251), "at most 250"),
        (15, Ranges(0, 46, 0, 44), "47 bytes"),
        (2, Ranges(0, 88, 40, 127), "89 bytes"),
        (2, Ranges(5, 4, 0, 87), "not before"),
        (2, Ranges(-1, 4, 0, 87), "from 0"),
        (2, Ranges(0, 4, 200, 256), "at most 255"),
    ):
        with pytest.raises(CouplingFault, match=words):
            Coupling(p20, ranges)
    with pytest.raises(CouplingFault, match="P20 = 3"):
        Coupling(3)
    assert Coupling(15, Ranges(203, 247, 206, 250)).ranges == Ranges(203, 247, 206, 250)
    assert Coupling(2, Ranges(2, 89, 2, 89)).to_plc_bytes == 88  # in the EI/EO field


@pytest.mark.requirement("RHO-PLC-29", by="gateway.pure.controllers.rho3.signals.coupling:Coupling.plc_address")
def test_signals_lie_where_the_manual_puts_them_and_move_with_the_start() -> None:
    normal, moved, expanded, rho31 = Coupling(15), Coupling(15, Ranges(10, 54, 10, 54)), Coupling(19), Coupling(2)
    drive_on, ready = RcBit(Direction.INPUT, 66), RcBit(Direction.OUTPUT, 68)
    assert [each.plc_address(drive_on) for each in (normal, moved, expanded, rho31)] == ["O7.2", "O17.2", "O8.2", "O48.2"]
    assert [each.plc_address(ready) for each in (normal, moved, expanded, rho31)] == ["I6.4", "I16.4", "I8.4", "I8.4"]
    for direction, first in ((Direction.INPUT, 8), (Direction.OUTPUT, 16)):
        for number in range(first, first + 45 * 8):
            assert normal.plc_address(RcBit(direction, number)) == cl300(RcBit(direction, number))
        assert normal.plc_address(RcBit(direction, first - 1)) is None
        assert normal.plc_address(RcBit(direction, first + 45 * 8)) is None


@pytest.mark.requirement("RHO-PLC-29", by="gateway.pure.controllers.rho3.signals.coupling:Coupling.to_plc")
def test_configuration_15_carries_45_bytes_and_the_board() -> None:
    coupling, image = Coupling(15), numbered()
    assert coupling.to_plc(image, bytes([1, 2, 3, 4, 5, 6, 7, 8])) == bytes(range(130, 175)) + bytes([1, 2, 3, 4, 5, 6, 7, 8])
    assert coupling.to_plc(image, b"\x01") == bytes(range(130, 175)) + b"\x01" + bytes(7)
    frame = bytes(200 + byte % 50 for byte in range(45)) + b"BOARD"
    assert coupling.from_plc(frame, image) == b"BOARD"
    assert image.inputs[1:46] == frame[:45] and image.inputs[0] == 0 and image.inputs[46] == 46


@pytest.mark.requirement("RHO-PLC-30", by="gateway.pure.controllers.rho3.signals.coupling:Coupling.from_plc")
def test_13_2_the_expanded_interface_is_88_bytes_both_ways() -> None:
    for p20 in (2, 19):
        coupling, image = Coupling(p20), numbered()
        sent = coupling.to_plc(image)
        assert sent == bytes(range(128, 216)) and coupling.to_plc_bytes == coupling.from_plc_bytes == 88
        frame = bytes(range(100, 188))
        assert coupling.from_plc(frame, image) == b""
        assert image.inputs[:88] == frame and image.inputs[88:] == bytes(range(88, 128))
        for length in (0, 46, 87, 89):
            with pytest.raises(CouplingFault, match=f"frame of {length} bytes, 88"):
                coupling.from_plc(bytes(length), image)
        assert image.inputs[:88] == frame


@pytest.mark.requirement("RHO-PLC-30", by=(COUPLING + "Coupling.to_plc", COUPLING + "Coupling.from_plc", COUPLING + "flag_byte"))
def test_13_2_1_the_printed_program_finds_every_signal_in_its_flags() -> None:
    """P0 K15AH: input array as of M 90; P1 K100H: output array as of M 0; P2 and P3 K88D (L11100-11113)."""
    coupling, image, flags = Coupling(19), PicImage(), bytearray(256)
    received, transmitted = flag_byte(0x15A), flag_byte(0x100)
    assert (received, transmitted) == (90, 0) and transmitted + coupling.from_plc_bytes <= received, "the arrays lie one behind the other"
    for number in range(128 * 8):  # every RC output that goes over, alone
        image.outputs[:] = bytes(128)
        image.put(number, True)
        flags[received : received + 88] = coupling.to_plc(image)
        where = [(byte, bit) for byte in range(256) for bit in range(8) if flags[byte] >> bit & 1]
        assert where == ([(90 + number // 8, number % 8)] if number < 88 * 8 else []), number
    flags = bytearray(256)
    flags[transmitted + 87] = 0x80
    flags[received + 8] = 0xFF  # of the other array
    coupling.from_plc(bytes(flags[transmitted : transmitted + 88]), image)
    assert [number for number in range(128 * 8) if image.input(number)] == [87 * 8 + 7]
    assert [flag_byte(0x15A + byte) for byte in (0, 37, 87)] == [90, 127, 177]


@pytest.mark.requirement("RHO-PLC-30", by="gateway.pure.controllers.rho3.signals.coupling:flag_index")
def test_13_2_1_index_addresses() -> None:
    assert (flag_index(90), flag_index(0), io_index(40)) == (0x15A, 0x100, 0x2C8)


@pytest.mark.requirement("RHO-PLC-30", by="gateway.pure.controllers.rho3.signals.coupling:flag_byte")
def test_13_2_1_flags_behind_index_addresses() -> None:
    assert (flag_byte(0x15A), flag_byte(0x100)) == (90, 0)
    with pytest.raises(CouplingFault, match="before M 0"):
        flag_byte(0xFF)


@pytest.mark.requirement("RHO-PLC-31", by="gateway.pure.controllers.rho3.signals.coupling:in_blocks")
def test_5_2_88_bytes_go_as_two_blocks_of_at_most_48() -> None:
    frame = Coupling(19).to_plc(numbered())
    assert in_blocks(frame) == [Block(0, 2, frame[:48]), Block(1, 2, frame[48:])]
    assert [len(block.data) for block in in_blocks(bytes(46))] == [46]


@pytest.mark.requirement("RHO-PLC-31", by="gateway.pure.controllers.rho3.signals.coupling:BlockJoiner.take")
def test_5_2_a_frame_is_taken_whole_or_not_at_all() -> None:
    frame, other = bytes(range(88)), bytes(88)
    one, two = in_blocks(frame)
    joiner = BlockJoiner()
    assert [joiner.take(one), joiner.take(two)] == [None, frame]
    assert [joiner.take(two), joiner.take(one), joiner.take(one), joiner.take(two)] == [None, None, None, frame]
    assert [joiner.take(one), joiner.take(in_blocks(bytes(140))[1]), joiner.take(two)] == [None, None, None]
    assert joiner.take(Block(0, 1, bytes(49))) is None
    assert [joiner.take(block) for block in in_blocks(other)] == [None, other]
