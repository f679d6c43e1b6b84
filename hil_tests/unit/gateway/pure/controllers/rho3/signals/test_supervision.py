"""Start-up time-out of the PLC, timer error of the PIC.  rho 3 release manual: L11717-11732, L707."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.supervision import PicGuard, PlcWatch, has_grace
from protocols.base.machine import ms

NORMAL = ms(500)


@pytest.mark.requirement("RHO-PLC-32", by="gateway.pure.controllers.rho3.signals.supervision:PlcWatch.wake")
def test_6_80_seconds_of_silence_at_start_then_the_normal_time_out() -> None:
    start = ms(1000)
    watch = PlcWatch(NORMAL, start)
    assert watch.deadline() == start + ms(80_500)
    assert not watch.wake(start + ms(80_499))
    watch.heard(start + ms(80_499))
    heard = start + ms(80_499)
    assert not watch.wake(heard + NORMAL - 1)
    assert watch.wake(heard + NORMAL) and watch.silent and watch.deadline() is None
    assert not watch.wake(heard + 2 * NORMAL)  # told once
    watch.heard(heard + 3 * NORMAL)
    assert not watch.silent and watch.wake(heard + 4 * NORMAL)


@pytest.mark.requirement("RHO-PLC-32", by="gateway.pure.controllers.rho3.signals.supervision:has_grace")
def test_6_the_delay_came_with_to07j_and_is_not_for_remote_controls() -> None:
    versions = {"TO07J": True, "TO08E": True, "TO07I": False, "TO07F": False, "TO06J": False, "TO02F": False}
    assert {version: has_grace(version, remote=False) for version in versions} == versions
    assert not has_grace("TO08E", remote=True)
    assert PlcWatch(NORMAL, 0, grace=False).wake(NORMAL)
    with pytest.raises(ValueError, match="TO07J"):
        has_grace("7J", remote=False)


def marked(image: PicImage) -> None:
    image.inputs[8] = image.outputs[9] = image.flags[3] = 0xFF


@pytest.mark.requirement("RHO-PLC-38", by="gateway.pure.controllers.rho3.signals.supervision:PicGuard.timer_error")
def test_a_timer_error_stops_the_pic_opens_ready_and_clears_inputs_and_outputs() -> None:
    guard, image = PicGuard(ms(50)), PicImage()
    runs: list[int] = []

    def program(image: PicImage) -> None:
        runs.append(len(runs))
        marked(image)

    guard.run(image, ms(10), program)
    assert guard.ready and len(runs) == 1 and image.outputs[9] == 0xFF
    guard.timer_error(image)
    assert not guard.ready and not any(image.inputs) and not any(image.outputs) and image.flags[3] == 0xFF
    image.inputs[8] = 1
    guard.run(image, ms(20), program)
    assert len(runs) == 1 and not any(image.inputs) and not guard.ready


@pytest.mark.requirement("RHO-PLC-38", by="gateway.pure.controllers.rho3.signals.supervision:PicGuard.run")
def test_a_run_that_comes_too_late_is_a_timer_error() -> None:
    guard, image = PicGuard(ms(50)), PicImage()
    guard.run(image, ms(10), marked)
    guard.run(image, ms(60), marked)
    assert guard.ready and image.outputs[9] == 0xFF
    guard.run(image, ms(110) + 1, marked)
    assert not guard.ready and not any(image.outputs)
