"""rho 3 Releases part 5, 6.11 to 6.14.2 and part 8, 11.1: PIC bytes and frames, supervision of inputs, coupling of two controls."""

import pytest

from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.messages import IoError, Trouble
from gateway.pure.controllers.rho3.can.rules import Block
from gateway.pure.controllers.rho3.can.tables import Side
from protocols.base.machine import Frame, Ns, ms

P2 = ms(8)
IMAGE = bytes(128)


class Io:
    """An I/O bus with its time; `said`: every error as the pendant shows it."""

    def __init__(self, settings: IoSettings, now: Ns = 0) -> None:
        self.bus, self.now = IoBus(settings, now), now
        self.said: list[str] = []

    def hears(self, identifier: int, data: bytes) -> None:
        self._note(self.bus.receive(Frame(identifier, data), self.now))

    def cycle(self, count: int = 1, identifier: int | None = None, data: bytes = b"") -> None:
        """P2 cycles; in each of them `identifier` comes once."""
        for _ in range(count):
            if identifier is not None:
                self.hears(identifier, data)
            self.now += P2
            self._note(self.bus.cycle(self.now))

    def _note(self, found: list[IoError]) -> None:
        self.said += [str(error) for error in found]

    def bytes(self, first: int, last: int) -> bytes:
        return bytes(self.bus.image[first : last + 1])


def sent(bus: IoBus, image: bytes | bytearray) -> list[Frame]:
    return bus.frames(image)


@pytest.mark.requirement("RHO-CAN-08", by="gateway.pure.controllers.rho3.can.blocks:IoBus.receive")
def test_frame_541_of_four_bytes_becomes_pic_inputs_i92_0_to_i95_7() -> None:
    io = Io(IoSettings(1, (Block(92, 4, 541),)))
    io.hears(541, bytes((0x01, 0x80, 0xAA, 0xFF)))
    assert io.bytes(91, 96) == bytes((0, 0x01, 0x80, 0xAA, 0xFF, 0))
    io.cycle()
    io.hears(541, bytes((0, 0, 0, 0x80)))
    assert io.bytes(92, 95) == bytes((0, 0, 0, 0x80))
    assert io.said == []


def test_of_a_longer_frame_only_the_blocks_length_is_taken_and_a_shorter_one_is_inadmissible() -> None:
    io = Io(IoSettings(1, (Block(92, 2, 541), Block(94, 2, 542))))
    io.hears(541, b"\x11\x22\x33\x44")
    io.hears(542, b"\x55")
    assert io.bytes(92, 95) == b"\x11\x22\x00\x00"
    assert io.said == ["380 inadm. data CAN 1 I2"]


@pytest.mark.requirement("RHO-CAN-09", by="gateway.pure.controllers.rho3.can.blocks:IoBus.frames")
def test_o92_to_o95_with_length_4_leave_as_frame_471_and_a_changed_bit_is_in_the_next_one() -> None:
    bus = IoBus(IoSettings(2, (), (Block(92, 4, 471), Block(100, 8, 472))), 0)
    image = bytearray(range(128))
    assert sent(bus, image) == [Frame(471, bytes((92, 93, 94, 95))), Frame(472, bytes(range(100, 108)))]
    image[95] ^= 0x80
    assert sent(bus, image) == [Frame(471, bytes((92, 93, 94, 95 ^ 0x80))), Frame(472, bytes(range(100, 108)))]


@pytest.mark.requirement("RHO-CAN-10", by="gateway.pure.controllers.rho3.can.blocks:IoBus.cycle")
def test_no_frame_for_a_p2_cycle_is_no_transm_with_bus_and_block() -> None:
    io = Io(IoSettings(2, (Block(88, 8, 541), Block(96, 8, 545))))
    for _ in range(3):
        io.hears(541, bytes(8))
        io.cycle(1, 545, b"\x07" + bytes(7))
    assert io.said == []
    io.cycle(1, 541, bytes(8))
    assert io.said == ["381 no transm. CAN2 I2"]
    assert io.bytes(96, 96) == b"\x00"  # lost inputs read 0
    io.cycle(1, 541, bytes(8))
    assert io.said == ["381 no transm. CAN2 I2"]  # told once
    assert io.bus.errors == [IoError(Trouble.SILENT, 2, 2)]
    io.hears(545, b"\x07" + bytes(7))
    assert io.said[1:] == ["381 no transm. CAN2 I2: recovered"] and io.bytes(96, 96) == b"\x07"


def test_lost_inputs_may_keep_their_last_bytes() -> None:
    io = Io(IoSettings(1, (Block(88, 1, 541),), zero_on_loss=False))
    io.cycle(2, 541, b"\x55")
    io.cycle(2)
    assert io.said == ["380 no transm. CAN1 I1"] and io.bytes(88, 88) == b"\x55"


@pytest.mark.requirement("RHO-CAN-11", by="gateway.pure.controllers.rho3.can.blocks:IoBus.receive")
def test_two_frames_of_one_block_in_a_cycle_are_inadmissible_data() -> None:
    io = Io(IoSettings(1, (Block(88, 1, 541), Block(89, 1, 542))))
    for _ in range(2):
        io.hears(541, b"\x01")
        io.cycle(1, 542, b"\x02")
    io.hears(541, b"\x01")
    io.hears(542, b"\x02")
    io.hears(542, b"\x03")
    assert io.said == ["380 inadm. data CAN 1 I2"] and io.bytes(88, 89) == b"\x01\x02"
    io.cycle()
    io.hears(541, b"\x01")
    io.cycle(1, 542, b"\x02")
    assert io.said[1:] == ["380 inadm. data CAN 1 I2: recovered"]


def coupled(own: int, other: int, *, coupling_ns: Ns | None = ms(300), start_ns: Ns = ms(60_000), give_up: bool = False) -> IoSettings:
    return IoSettings(1, (Block(92, 4, other),), (Block(92, 4, own),), coupling_ns, start_ns, give_up=give_up)


@pytest.mark.requirement(
    "RHO-CAN-13", by=("gateway.pure.controllers.rho3.can.blocks:IoBus.frames", "gateway.pure.controllers.rho3.can.blocks:IoBus.receive")
)
def test_bytes_92_to_95_of_control_1_arrive_at_control_2_by_472_and_come_back_by_471() -> None:
    one, two = Io(coupled(472, 471)), Io(coupled(471, 472))
    images = (bytearray(128), bytearray(128))
    images[0][92:96], images[1][92:96] = b"\x12\x34\x56\x78", b"\x9a\xbc\xde\xf0"
    for source, image, target in ((one, images[0], two), (two, images[1], one)):
        frames = sent(source.bus, image)
        assert isinstance(frames, list), frames
        for frame in frames:
            target.hears(frame.identifier, frame.data)
    assert two.bytes(92, 95) == b"\x12\x34\x56\x78" and one.bytes(92, 95) == b"\x9a\xbc\xde\xf0"
    assert [frame.identifier for frame in sent(one.bus, IMAGE) if isinstance(frame, Frame)] == [472]
    assert one.said == two.said == []


@pytest.mark.requirement("RHO-CAN-14", by="gateway.pure.controllers.rho3.can.blocks:IoBus.cycle")
@pytest.mark.parametrize(("option", "after"), [(ms(300), ms(304)), (ms(1000), ms(1000))])
def test_a_partner_that_stops_is_reported_300_ms_later_and_the_option_changes_the_time(option: Ns, after: Ns) -> None:
    """Judged at the P2 cycles of 8 ms: at the first one at which the time has passed."""
    io = Io(coupled(472, 471, coupling_ns=option))
    io.cycle(5, 471, b"\x01\x02\x03\x04")
    last = io.now - P2  # the frame of the last cycle came at its begin
    while not io.said and io.now < last + 2 * after:
        io.cycle()
    assert (io.said, io.now - last) == (["380 no transm. CAN1 I1"], after)


def test_the_option_may_remove_the_supervision() -> None:
    io = Io(coupled(472, 471, coupling_ns=None))
    io.cycle(5, 471, bytes(4))
    io.cycle(1000)
    assert io.said == []


def test_a_missing_frame_now_and_then_and_two_in_one_cycle_are_no_fault_of_a_coupled_control() -> None:
    """Controls are not synchronised to one cycle (L10960-10962)."""
    io = Io(coupled(472, 471))
    for _ in range(50):
        io.cycle(3, 471, bytes(4))
        io.hears(471, bytes(4))
        io.cycle(1, 471, bytes(4))
        io.cycle(2)
    assert io.said == []


@pytest.mark.requirement("RHO-CAN-15", by="gateway.pure.controllers.rho3.can.blocks:IoBus.cycle")
def test_supervision_begins_when_all_have_answered_and_a_partner_silent_for_60_s_is_an_error() -> None:
    settings = IoSettings(1, (Block(92, 1, 471), Block(93, 1, 473)), (Block(92, 1, 472),))
    patient = Io(settings)
    patient.cycle(10, 471, b"\x01")
    patient.cycle(1000)  # 8 s: block 1 has been silent for long, but block 2 never answered yet
    assert patient.said == []
    patient.hears(473, b"\x02")
    patient.cycle()
    assert patient.said == ["380 no transm. CAN1 I1"]  # now all have answered: block 1 is too old
    alone = Io(settings)
    alone.cycle(7499, 471, b"\x01")
    assert (alone.said, alone.bus.aborted) == ([], False)
    alone.cycle(1, 471, b"\x01")
    assert alone.now == ms(60_000)
    assert (alone.said, alone.bus.aborted) == (["380 no transm. CAN1 I2"], True)
    assert [frame.identifier for frame in sent(alone.bus, IMAGE) if isinstance(frame, Frame)] == [472]  # ours goes on (AX-263)
    alone.hears(473, b"\x02")
    assert alone.said[1:] == ["380 no transm. CAN1 I2: recovered"]


def test_the_manuals_way_stops_sending_after_a_start_that_failed() -> None:
    io = Io(coupled(472, 471, start_ns=ms(80), give_up=True))
    assert len(io.bus.frames(IMAGE)) == 1
    io.cycle(10)
    assert io.said == ["380 no transm. CAN1 I1"] and io.bus.frames(IMAGE) == []


def test_our_own_identifier_from_another_control_is_reported_once() -> None:
    io = Io(coupled(472, 471))
    for _ in range(3):
        io.hears(472, bytes(4))
    assert io.said == ["same id CAN1 O1"]
    assert io.bus.errors[0].trouble.words(1, 1, "de").startswith("eine andere Steuerung")


def test_frames_the_interface_did_not_take_are_write_access_refused() -> None:
    bus = IoBus(IoSettings(2, (), (Block(92, 4, 471), Block(96, 4, 472))), 0)
    assert [str(error) for error in bus.sent(1)] == ["381 imperm. data CAN2 O2"]
    assert bus.sent(1) == []
    assert [str(error) for error in bus.sent(2)] == ["381 imperm. data CAN2 O2: recovered"]


def test_what_no_block_of_this_bus_is_says_nothing() -> None:
    io = Io(IoSettings(1, (Block(88, 1, 541),)))
    for identifier in (100, 210, 610, 542, 472):
        io.hears(identifier, bytes(8))
    assert io.said == [] and bytes(io.bus.image) == IMAGE


def test_diagnosis_lists_all_errors_and_shows_inputs_and_outputs_as_they_are() -> None:
    """Before TO01 only the first one was listed (L686); modes 7.14 and 7.15 (L7459-7475)."""
    io = Io(IoSettings(2, (Block(88, 2, 541), Block(90, 1, 542), Block(91, 1, 543)), (Block(92, 2, 471),)))
    for _ in range(3):
        io.cycle(1, 542, b"\x81")
    assert [str(error) for error in io.bus.errors] == ["381 no transm. CAN2 I1", "381 no transm. CAN2 I3"]
    io.hears(541, b"\x01\x02")
    io.bus.frames(bytes(92) + b"\x0f\xf0" + bytes(34))
    assert io.bus.live(Side.INPUT) == [(541, b"\x01\x02"), (542, b"\x81"), (543, b"\x00")]
    assert io.bus.live(Side.OUTPUT) == [(471, b"\x0f\xf0")]
