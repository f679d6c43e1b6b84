"""User inputs and outputs, P24, P27.  rho 3: L696, L872-875, L5133-5141, L7953-7967."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.user import ChannelFault, UserPorts, input_bit
from gateway.pure.image.addresses import Direction, from_pic
from gateway.pure.image.records.cell import set_bit


@pytest.mark.requirement("RHO-PLC-35", by="gateway.pure.controllers.rho3.signals.user:UserPorts.read")
def test_user_99_is_o70_2_and_binary_input_99() -> None:
    image = PicImage()
    ports = UserPorts(image)
    place = from_pic("O", 70, 2)
    assert place.direction is Direction.INPUT
    set_bit(image.inputs, place.number, True)
    assert [channel for channel in range(1, 121) if ports.read(channel)] == [99]
    assert [channel for channel in range(1001, 1121) if ports.read(channel)] == [1099]


@pytest.mark.requirement("RHO-PLC-35", by="gateway.pure.controllers.rho3.signals.user:UserPorts.statuses")
def test_user_inputs_1_to_99_are_the_machine_statuses() -> None:
    image = PicImage()
    ports = UserPorts(image)
    for bit in (464, 464 + 7, 562, 563):  # the hundredth is an input, and no status
        set_bit(image.inputs, bit, True)
    assert ports.statuses() == (1, 8, 99)


@pytest.mark.requirement("RHO-PLC-35", by="gateway.pure.controllers.rho3.signals.user:input_bit")
def test_channels_outside_are_refused() -> None:
    assert (input_bit(1), input_bit(99), input_bit(120), input_bit(1120)) == (464, 562, 583, 583)
    for channel in (0, 121, 1000, 1121):
        with pytest.raises(ChannelFault, match="inadmissable input"):
            input_bit(channel)


@pytest.mark.requirement("RHO-PLC-36", by="gateway.pure.controllers.rho3.signals.user:UserPorts.control_reset")
def test_p24_control_reset_clears_outputs_1_to_4_only() -> None:
    for p24, left in ((4, [5, 6, 120]), (0, [1, 2, 3, 4, 5, 6, 120]), (120, [])):
        image = PicImage()
        ports = UserPorts(image, p24=p24)
        for channel in (1, 2, 3, 4, 5, 6, 120):
            ports.write(channel, True)
        image.put(115, True)
        ports.control_reset()
        assert [channel for channel in range(1, 121) if image.output(383 + channel)] == left
        assert image.output(115)


def test_every_output_is_cleared_unless_p24_says_otherwise() -> None:
    image = PicImage()
    ports = UserPorts(image)
    ports.write(120, True)
    ports.control_reset()
    assert not any(image.outputs)
    with pytest.raises(ChannelFault, match="121"):
        ports.write(121, True)
    with pytest.raises(ValueError, match="P24"):
        UserPorts(image, p24=121)


@pytest.mark.requirement("RHO-PLC-37", by="gateway.pure.controllers.rho3.signals.user:UserPorts.integer")
def test_p27_1_takes_the_value_without_strobe() -> None:
    image = PicImage()
    ports = UserPorts(image, p27=1)
    for value in (7, 200):
        image.inputs[77] = value  # channel 402
        assert (ports.integer(402), ports.integer(1402), ports.integer(401)) == (value, value, 0)
    with pytest.raises(ChannelFault, match="409"):
        ports.integer(409)


@pytest.mark.requirement("RHO-PLC-37", by="gateway.pure.controllers.rho3.signals.user:UserPorts.look")
def test_p27_0_takes_the_value_at_its_strobe() -> None:
    image = PicImage()
    ports = UserPorts(image, p27=0)
    ports.look()
    image.inputs[77] = 7
    ports.look()
    assert ports.integer(402) == 0
    set_bit(image.inputs, 673, True)
    ports.look()
    assert ports.integer(402) == 7
    image.inputs[77] = 8
    ports.look()
    assert ports.integer(402) == 7  # a standing strobe takes nothing
    set_bit(image.inputs, 673, False)
    ports.look()
    set_bit(image.inputs, 673, True)
    ports.look()
    assert ports.integer(402) == 8 and ports.integer(401) == 0
