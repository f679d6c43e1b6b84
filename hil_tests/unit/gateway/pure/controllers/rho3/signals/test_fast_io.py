"""High-speed inputs (P11) and multi-function I/O (P36).  rho 3 release manual: L1202-1259, L5026-5032, L11378-11422."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.fast_io import BOARDS, Configured, FastInputs, InputFault, MultiFunction, StartUpFault


@pytest.mark.requirement("RHO-PLC-33", by="gateway.pure.controllers.rho3.signals.fast_io:FastInputs.__init__")
def test_2_3_p11_beyond_the_hardware_aborts_the_run_up() -> None:
    printed = {  # L1204-1232: inputs, probes
        "servo-3/5/8-wide": (8, 1), "servo-abs-5/8": (8, 0), "servo-inc6/poti": (8, 0), "servo-3/5-narrow": (0, 1),
        "servo-3is/4is/6is": (9, 1), "servo-abs-3i": (9, 1), "modular-i": (9, 1), "rho3.0": (4, 1),
    }  # fmt: skip
    assert set(printed) == set(BOARDS)
    for name, (inputs, probes) in printed.items():
        assert FastInputs([BOARDS[name]], [Configured(probes, inputs)]).boards() == ((1,) if inputs else ())
        for want in (Configured(probes, inputs + 1), Configured(probes + 1, inputs)):
            with pytest.raises(StartUpFault, match=r"incorr\. highspeed-io: board 1"):
                FastInputs([BOARDS[name]], [want])
    with pytest.raises(StartUpFault, match="board 2"):
        FastInputs([BOARDS["modular-i"]], [Configured(), Configured(1)])
    with pytest.raises(StartUpFault, match="board 1"):
        FastInputs([BOARDS["rho3.0"]], [Configured(outputs=5)])


@pytest.mark.requirement("RHO-PLC-33", by="gateway.pure.controllers.rho3.signals.fast_io:FastInputs.read")
def test_2_3_an_input_that_is_not_configured_is_a_runtime_error() -> None:
    boards = [BOARDS["servo-3/5-narrow"], BOARDS["modular-i"], BOARDS["servo-3/5/8-wide"]]
    inputs = FastInputs(boards, [Configured(1, 0), Configured(0, 3), Configured(1, 5)])
    assert inputs.channels() == (610, 621, 622, 623, 630, 631, 632, 633, 634, 635)
    assert inputs.boards() == (2, 3)
    inputs.put(623, True)
    assert (inputs.read(623), inputs.read(635)) == (True, False)
    for channel in (620, 624, 611, 636, 641):
        with pytest.raises(InputFault, match=f"inadmissable input: {channel}"):
            inputs.read(channel)


@pytest.mark.requirement("RHO-PLC-34", by="gateway.pure.controllers.rho3.signals.fast_io:MultiFunction.step")
def test_2_4_p36_26_byte_i26_follows_with_its_low_four_bits() -> None:
    for p36 in (26, 0):
        image, multi = PicImage(), MultiFunction(p36_in=p36)
        image.outputs[26] = 0xFF  # the whole byte is reserved
        image.inputs[18] = 0xA5
        multi.step(image, terminals=0xF6)
        assert image.outputs[26] == 0x06 and multi.outputs == 0x05
        assert [multi.read(channel) for channel in (801, 802, 803, 804)] == [False, True, True, False]
        multi.write(802, True)
        multi.step(image, terminals=0)
        assert multi.outputs == 0x05 and image.outputs[26] == 0  # PIC and PLC overwrite BAPS


@pytest.mark.requirement("RHO-PLC-34", by="gateway.pure.controllers.rho3.signals.fast_io:MultiFunction.write")
def test_2_4_p36_minus_1_only_baps_sees_them() -> None:
    image, multi = PicImage(), MultiFunction(p36_in=-1, p36_out=-1)
    image.inputs[:] = image.outputs[:] = b"\xff" * 128
    multi.write(802, True)
    multi.step(image, terminals=0x0F)
    assert multi.outputs == 0x02 and image.outputs == b"\xff" * 128
    multi.write(802, False)
    multi.write(804, True)
    multi.step(image, terminals=0x01)
    assert multi.outputs == 0x08 and multi.read(611)


@pytest.mark.requirement("RHO-PLC-34", by="gateway.pure.controllers.rho3.signals.fast_io:_place")
def test_2_4_only_free_addresses() -> None:
    for inputs, outputs, words in ((88, 0, "stand-alone"), (0, 128, "stand-alone"), (-2, 0, "-1"), (0, 24, "free are"), (24, 0, "I24")):
        with pytest.raises(ValueError, match=words):
            MultiFunction(inputs, outputs, occupied=(24, 25))
    image, multi = PicImage(), MultiFunction(100, 127, stand_alone=True)
    image.inputs[127] = 3
    multi.step(image, 9)
    assert image.outputs[100] == 9 and multi.outputs == 3
    with pytest.raises(InputFault, match="805"):
        multi.read(805)
