"""Error acknowledgement, Control reset, EMERGENCY STOP, codes of system errors.  rho 3: L1072-1076, L3059, L4046-4068, L7485-7500."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.errors import EMERGENCY_STOP, Faults, Outcome
from gateway.pure.image.records.cell import InputImage, Quality, set_bit
from gateway.pure.image.system_errors import system_code, system_number

RESET, CHAIN, ACK = 19, 24, 62


class Control:
    """Faults on an image with the chain closed."""

    def __init__(self) -> None:
        self.image, self.faults = PicImage(), Faults()
        self.set(CHAIN, True)

    def set(self, bit: int, value: bool) -> Outcome:
        set_bit(self.image.inputs, bit, value)
        return self.faults.update(self.image)

    def pulse(self, bit: int) -> Outcome:
        self.set(bit, False)
        outcome = self.set(bit, True)
        self.set(bit, False)
        return outcome


@pytest.mark.requirement("RHO-PLC-13", by="gateway.pure.controllers.rho3.signals.errors:Faults.update")
def test_9_2_the_rising_edge_of_bit_62_clears_errors_and_leaves_processes() -> None:
    control = Control()
    for code in (91, 380, 1051, 1408):
        control.faults.came(code)
    assert control.pulse(ACK) == Outcome((91, 380, 1051, 1408), processes_end=False)
    assert not control.faults.shown
    control.set(ACK, True)
    control.faults.came(91)
    assert control.set(ACK, True) == Outcome() and 91 in control.faults.shown  # a standing bit clears nothing


@pytest.mark.requirement("RHO-PLC-13", by="gateway.pure.controllers.rho3.signals.errors:kind_of")
def test_9_3_bit_62_does_not_clear_emergency_stop_and_p2_errors() -> None:
    control = Control()
    control.set(CHAIN, False)
    control.set(CHAIN, True)
    for code in (768, 1023, 600, 3400, 91, system_code(133)):
        control.faults.came(code)
    assert control.pulse(ACK) == Outcome((91,))
    assert list(control.faults.shown) == [EMERGENCY_STOP, 768, 1023, 600, 3400, 3716]
    assert control.pulse(RESET) == Outcome((EMERGENCY_STOP, 768, 1023, 600, 3400), processes_end=True)
    assert list(control.faults.shown) == [
        3716,
    ]  # system errors go with a restart only


@pytest.mark.requirement("RHO-PLC-14", by="gateway.pure.controllers.rho3.signals.errors:Faults._clear")
def test_control_reset_clears_what_has_no_cause_and_ends_processes() -> None:
    control = Control()
    control.faults.came(91)
    control.faults.came(800, active=True)
    control.set(CHAIN, False)
    assert control.pulse(RESET) == Outcome((91,), processes_end=True)
    assert list(control.faults.shown) == [800, EMERGENCY_STOP] and control.image.output(67)
    control.set(CHAIN, True)
    control.faults.gone(800)
    assert list(control.faults.shown) == [800, EMERGENCY_STOP]
    assert control.pulse(RESET) == Outcome((800, EMERGENCY_STOP), processes_end=True)
    assert not control.faults.shown and not control.image.output(67)


@pytest.mark.requirement("RHO-SYS-02", by="gateway.pure.controllers.rho3.signals.errors:Faults._watch_chain")
def test_emergency_stop_stays_after_release_until_control_reset_or_panel() -> None:
    control = Control()
    assert not control.image.output(67)
    for by_panel in (False, True):
        control.set(CHAIN, False)
        control.set(CHAIN, True)
        assert control.pulse(ACK) == Outcome()
        assert list(control.faults.shown) == [
            EMERGENCY_STOP,
        ] and control.image.output(67)
        outcome = control.faults.update(control.image, panel_reset=True) if by_panel else control.pulse(RESET)
        assert outcome == Outcome((EMERGENCY_STOP,), processes_end=True)
        assert not control.image.output(67)
        control.faults.update(control.image)


def test_a_reset_that_is_set_when_its_source_comes_back_is_no_edge() -> None:
    image, faults, sources = PicImage(), Faults(), InputImage()
    for bit in (CHAIN, RESET):
        set_bit(sources.values, bit, True)
    told: list[bool] = []
    for quality in (Quality.GOOD, Quality.STALE, Quality.BAD, Quality.GOOD):
        sources.quality[:] = bytes([quality]) * 128
        image.take(sources)
        told.append(faults.update(image).processes_end)
        assert image.input(RESET) == (quality is not Quality.BAD)
    assert told == [False] * 4 and faults.shown == (EMERGENCY_STOP,)  # the chain was unknown for a while
    for value in (False, True):
        set_bit(sources.values, RESET, value)
        image.take(sources)
        told.append(faults.update(image).processes_end)
    assert told[-2:] == [False, True] and not faults.shown


def test_a_reset_that_is_set_at_start_is_no_edge() -> None:
    image, faults = PicImage(), Faults()
    for bit in (RESET, CHAIN, ACK):
        set_bit(image.inputs, bit, True)
    faults.came(91)
    assert faults.update(image, panel_reset=True) == Outcome()


@pytest.mark.requirement("RHO-SYS-01", by="gateway.pure.image.system_errors:system_code")
def test_codes_of_system_errors() -> None:
    assert {n: system_code(n) for n in (133, 149, 150, 151, 1, 256, 300)} == {
        133: 3716, 149: 3732, 150: 3733, 151: 3734, 1: 3584, 256: 3839, 300: 3883,
    }  # fmt: skip
    for number in (0, -1, 513):
        with pytest.raises(ValueError, match="have a code"):
            system_code(number)


@pytest.mark.requirement("RHO-SYS-01", by="gateway.pure.image.system_errors:system_number")
def test_system_errors_of_codes() -> None:
    assert [system_number(code) for code in (3584, 3716, 4095)] == [1, 133, 512]
    for code in (91, 528, 3583):
        with pytest.raises(ValueError, match="system errors are"):
            system_number(code)
