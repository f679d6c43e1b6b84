"""Drive-on per axis, disabled axes, and the parts of the interface together.  rho 3: L1295-1305, L7920-7941."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.drives import DisabledAxes, drive_on
from gateway.pure.controllers.rho3.signals.modes import Refusal, RuntimeFault
from gateway.pure.controllers.rho3.signals.whole import Installation, SignalInterface
from gateway.pure.image.records.cell import get_bit, set_bit
from protocols.base.machine import ms


def given(*bits: int) -> PicImage:
    image = PicImage()
    for bit in bits:
        set_bit(image.inputs, bit, True)
    return image


def test_3_1_axis_specific_drive_on_works_only_without_the_group_signal() -> None:
    assert drive_on(given(192, 194, 211), 20) == 1 << 19 | 0b101
    assert drive_on(given(66), 6) == 0b111111 == drive_on(given(66, 192), 6)
    assert drive_on(given(198), 6) == 0 == drive_on(given(), 6)


@pytest.mark.requirement("RHO-MOT-47", by="gateway.pure.controllers.rho3.signals.drives:DisabledAxes.update")
def test_11_1_a_disabled_axis_stays_so_until_a_start_with_0() -> None:
    axes = DisabledAxes(20)
    assert axes.update(given(216, 235)) == (1408, 1427) and axes.mask == 1 << 19 | 1
    assert axes.update(given(217)) == (1409,) and axes.mask == 1 << 19 | 0b11
    assert axes.update(given()) == () and axes.mask == 1 << 19 | 0b11
    assert DisabledAxes(20).update(given()) == ()
    with pytest.raises(ValueError, match=r"1\.\.20"):
        DisabledAxes(21)


def test_all_parts_look_at_one_image() -> None:
    image = given(24, 54, 38, 39, 66, 217)
    interface = SignalInterface(image, Installation(axes=6, kinematics=2, p2=5, p13=(1,), p24=4))
    for channel in range(1, 7):
        interface.user.write(channel, True)
    set_bit(image.flags, 16, True)
    seen = interface.step(ms(10))
    assert (seen.drive_on, seen.disabled, seen.switched, seen.outcome.processes_end) == (0b111101, 0b10, (), False)
    assert interface.faults.shown == (1409,)
    assert [image.output(bit) for bit in (68, 72, 96, 124, 125, 126)] == [False, False, True, True, False, True]
    assert get_bit(image.flags, 32)
    interface.modes.begins("CYCLE", [2])
    for bit, value in ((39, False), (19, True)):
        set_bit(image.inputs, bit, value)
    seen = interface.step(ms(10))
    assert seen.switched == (RuntimeFault("CYCLE", 2, Refusal.SWITCHED),)
    assert seen.outcome.processes_end and seen.outcome.cleared == (1409,)
    assert [image.output(383 + channel) for channel in range(1, 7)] == [False] * 4 + [True] * 2
    assert [image.output(bit) for bit in (68, 72, 96)] == [True, True, False] and get_bit(image.flags, 24)
