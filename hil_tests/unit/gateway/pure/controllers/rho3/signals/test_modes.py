"""Automatic and manual per kinematic, status signals, P2.  rho 3 release manual, TO02F chapter 12 (L2496-2602), L3929-3958."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.machine_type import show_machine
from gateway.pure.controllers.rho3.signals.modes import OperatingModes, Refusal, RuntimeFault
from gateway.pure.image.records.cell import set_bit

KIN_A_MN, AUTO, TEST = 54, 23, 22
K = {number: 37 + number for number in range(1, 11)}  # K01 = 38 .. K10 = 47


def given(*bits: int) -> PicImage:
    image = PicImage()
    for bit in bits:
        set_bit(image.inputs, bit, True)
    return image


def state(image: PicImage) -> dict[str, bool]:
    return {"POWERRED": image.output(68), "PHG_ACTV": image.output(72), "AUTO_MN": image.output(96), "TEST_MN": image.output(97)}


@pytest.mark.requirement("RHO-PLC-24", by="gateway.pure.controllers.rho3.signals.modes:OperatingModes.update")
def test_12_1_with_bit_54_each_kinematic_has_its_own_signal_and_bit_23_has_no_meaning() -> None:
    modes = OperatingModes(10)
    for number in range(1, 11):
        for with_global in ([], [AUTO]):
            modes.update(given(KIN_A_MN, K[number], *with_global))
            assert [modes.automatic(n) for n in range(1, 11)] == [n == number for n in range(1, 11)]
    modes.update(given(K[3]))  # without bit 54 the Kxx have no meaning
    assert not any(modes.automatic(n) for n in range(1, 11))
    modes.update(given(AUTO))
    assert all(modes.automatic(n) for n in range(1, 11))


@pytest.mark.requirement("RHO-PLC-26", by="gateway.pure.controllers.rho3.signals.modes:OperatingModes._status")
def test_12_1_1_status_signals() -> None:
    modes = OperatingModes(3)
    one_manual = given(KIN_A_MN, TEST, K[1], K[3])
    modes.update(one_manual)
    assert state(one_manual) == {"POWERRED": True, "PHG_ACTV": True, "AUTO_MN": False, "TEST_MN": True}
    every = given(KIN_A_MN, TEST, K[1], K[2], K[3])
    modes.update(every)
    assert state(every) == {"POWERRED": False, "PHG_ACTV": False, "AUTO_MN": True, "TEST_MN": False}
    modes.update(every, emergency_without_rc=True)
    assert state(every)["POWERRED"] and state(every)["AUTO_MN"]
    no_test = given(KIN_A_MN, K[1])
    modes.update(no_test)
    assert not state(no_test)["TEST_MN"]


def test_status_signals_of_the_global_mode() -> None:
    modes = OperatingModes(2)
    manual = given(TEST)
    modes.update(manual, phg_active=True)
    assert state(manual) == {"POWERRED": True, "PHG_ACTV": True, "AUTO_MN": False, "TEST_MN": True}
    modes.update(manual)
    assert not state(manual)["PHG_ACTV"]
    automatic = given(TEST, AUTO)
    modes.update(automatic, phg_active=True)
    assert state(automatic) == {"POWERRED": False, "PHG_ACTV": False, "AUTO_MN": True, "TEST_MN": True}


@pytest.mark.requirement("RHO-PLC-25", by="gateway.pure.controllers.rho3.signals.modes:OperatingModes.prepare")
def test_12_2_a_block_for_a_kinematic_in_manual_is_a_runtime_error() -> None:
    modes = OperatingModes(3)
    modes.update(given(KIN_A_MN, K[1], K[2]))
    assert modes.prepare("CYCLE", [1, 2]) is None
    fault = modes.prepare("CYCLE", [1, 3])
    assert fault == RuntimeFault("CYCLE", 3, Refusal.MANUAL) and fault.why.value == "Inadmis. in manual op."


@pytest.mark.requirement("RHO-PLC-25", by="gateway.pure.controllers.rho3.signals.modes:OperatingModes._switched")
def test_12_2_switched_over_in_motion_bars_the_kinematic_until_the_program_is_deselected() -> None:
    modes = OperatingModes(3)
    modes.update(given(KIN_A_MN, K[1], K[2]))
    modes.begins("CYCLE", [1, 2])
    modes.begins("OTHER", [3])
    assert modes.update(given(KIN_A_MN, K[1])) == [RuntimeFault("CYCLE", 2, Refusal.SWITCHED)]
    assert Refusal.SWITCHED.value == "AUTO/MANUAL switching"
    assert modes.update(given(KIN_A_MN, K[1], K[2])) == []
    for program in ("CYCLE", "OTHER"):
        assert modes.prepare(program, [2]) == RuntimeFault(program, 2, Refusal.SWITCHED)
    assert modes.prepare("OTHER", [1]) is None
    modes.deselected("OTHER")  # not the program in question
    assert modes.prepare("OTHER", [2]) is not None
    modes.deselected("CYCLE")
    assert modes.prepare("OTHER", [2]) is None
    modes.begins("OTHER", [1])
    modes.ends("OTHER")
    assert modes.update(given(KIN_A_MN)) == []  # no block, no error


@pytest.mark.requirement("RHO-PLC-24", by="gateway.pure.controllers.rho3.signals.modes:OperatingModes.set_up")
def test_12_3_to_12_6_set_up_only_in_manual_and_a_prepared_changeover_is_silent() -> None:
    modes = OperatingModes(2)
    modes.update(given(KIN_A_MN, K[1]))
    assert modes.set_up("", 2) is None
    assert modes.set_up("", 1) == RuntimeFault("", 1, Refusal.NOT_MANUAL)
    modes.update(given(AUTO, K[1], K[2]))
    modes.begins("CYCLE", [1, 2])
    assert modes.update(given(AUTO, KIN_A_MN, K[1], K[2])) == []
    assert len(modes.update(given(KIN_A_MN))) == 2
    with pytest.raises(ValueError, match=r"1\.\.10"):
        OperatingModes(11)


@pytest.mark.requirement("RHO-PLC-23", by="gateway.pure.controllers.rho3.signals.machine_type:show_machine")
def test_p2_is_at_bits_124_to_127() -> None:
    image = PicImage()
    for code in (5, 15, 0, 10):
        show_machine(image, code)
        assert [image.output(124 + bit) for bit in range(4)] == [bool(code >> bit & 1) for bit in range(4)]
    with pytest.raises(ValueError, match=r"0\.\.15"):
        show_machine(image, 16)
