"""AX-472: forced inputs are an overlay; what is not forced stays as its command source wrote it."""

import pytest

from gateway.pure.image.records.cell import InputImage, Quality
from gateway.services.forces import MOST, Forces


def written() -> InputImage:
    """Byte 5 is a living command source's, all bits 1."""
    image = InputImage()
    image.values[5], image.quality[5], image.stamps[5] = 0xFF, Quality.GOOD, 1000
    return image


def test_a_forced_bit_stays_set_and_its_neighbours_stay() -> None:
    forces, image = Forces(), written()
    forces.put(40, False, 2000)
    laid = forces.over(image)
    assert (laid.values[5], laid.quality[5], laid.stamps[5]) == (0xFE, Quality.GOOD, 1000)
    assert image.values[5] == 0xFF, "the command source's own image is not touched"


def test_in_a_byte_nobody_writes_only_the_forced_bit_is_allowed() -> None:
    forces, image = Forces(), written()
    image.quality[5] = Quality.BAD
    forces.put(42, True, 2000)
    laid = forces.over(image)
    assert (laid.values[5], laid.quality[5], laid.stamps[5]) == (0x04, Quality.GOOD, 2000)


def test_without_forces_the_image_is_handed_on_itself() -> None:
    forces, image = Forces(), written()
    forces.put(40, True, 1)
    forces.drop(40)
    assert forces.over(image) is image
    forces.put(40, True, 1)
    forces.put(41, True, 1)
    forces.drop()
    assert forces.over(image) is image


def test_a_bit_that_is_none_and_too_many_are_refused() -> None:
    forces = Forces()
    for number in (-1, 1024):
        with pytest.raises(ValueError, match="RC input"):
            forces.put(number, True, 1)
    for number in range(MOST):
        forces.put(number, True, 1)
    with pytest.raises(ValueError, match="forced already"):
        forces.put(MOST, True, 1)
    forces.put(0, False, 1)
    assert forces.bits[0] is False
