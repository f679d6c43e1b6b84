"""The signal list: generated rows, names in two languages, moved numbers, and the modules that use its numbers."""

import os
import pathlib

import pytest

from gateway.files.find import read_signals
from gateway.files.signal_lists import signal_list
from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals import errors, modes, user
from gateway.pure.controllers.rho3.signals.numbers import AS_SHIPPED, numbers_of
from gateway.pure.controllers.rho3.signals.whole import Installation, SignalInterface
from gateway.pure.image.addresses import AddressFault, Direction, Kind, Operand, RcBit, cl300, parse, parse_operand, pic, rc
from gateway.pure.image.records.cell import set_bit
from gateway.pure.image.signals import SignalFault, from_tables

IN, OUT = Direction.INPUT, Direction.OUTPUT
ALL = from_tables(read_signals())


def at(name: str) -> RcBit | None:
    signal = ALL.named(name)
    return signal.at if signal else None


def test_rows_are_generated_for_axes_kinematics_and_belts() -> None:
    for name, first, count in (
        ("DRIVE_{}_RCI", 192, 20),
        ("DISAXIS_{}_RCI", 216, 20),
        ("SETBELT_{}_RCI", 376, 8),
        ("USER_{}_RCI", 464, 120),
    ):
        for number in range(1, count + 1):
            assert at(name.format(number)) == RcBit(IN, first + number - 1)
        assert at(name.format(count + 1)) is None
    assert [at(f"K{number:02}_A_MN_RCI") for number in range(1, 12)] == [*(RcBit(IN, 37 + n) for n in range(1, 11)), None]
    small = from_tables(read_signals(), {"axis": 4, "kinematic": 2, "belt": 1})
    for name in ("DRIVE_4_RCI", "K02_A_MN_RCI", "SETBELT_1_RCI", "JOG_4_P", "INPOS_4_RCO", "USER_99_RCI"):
        assert small.named(name) is not None
    for name in ("DRIVE_5_RCI", "K03_A_MN_RCI", "K10_A_MN_RCI", "SETBELT_2_RCI", "JOG_5_M", "INPOS_5_RCO"):
        assert small.named(name) is None and ALL.named(name) is not None


def test_every_signal_has_both_texts_a_source_and_addresses_in_three_worlds() -> None:
    for signal in ALL.all:
        assert signal.de and signal.en and (signal.source == "rho3") <= bool(signal.lines)
        assert parse(pic(signal.at)) == signal.at
        if signal.at.number >= (16 if signal.at.direction is IN else 64):
            assert parse(f"CL300 {cl300(signal.at)}") == signal.at
            assert parse(f"RC {'in' if signal.at.direction is IN else 'out'} {rc(signal.at)}") == signal.at


def test_other_names_lead_to_the_same_signal() -> None:
    for name, other in (
        ("DIS_PHGM_RCI", "SP_DIS23_RCI"), ("ERROR15_RCO", "ERROR_15_RCO"), ("ERROR_3_RCO", "ERROR3_RCO"), ("USER_17_RCO", "AAUS_17_RCA"),
        ("K01_A_MN_RCI", "k01_a_mn_rce"), ("POWERRED_RCO", "POWERRED_RCA"), ("STB_TXTO_RCI", "STB_TXTO_RCO"),
    ):  # fmt: skip
        assert ALL.named(other) is ALL.named(name) is not None
    assert parse("AAUS_17_RCA", ALL.symbols()) == RcBit(OUT, 400)
    assert at("DISCOUPL_RCI") == RcBit(IN, 112)  # rho3 D-06
    names = [name.upper() for signal in ALL.all if not signal.until for name in (signal.name, *signal.also)]
    assert sorted(name for name in set(names) if names.count(name) > 1) == []


def test_the_modules_use_the_lists_numbers() -> None:
    used = {
        "TEST_MN_RCI": modes.TEST_MN, "AUTO_MN_RCI": modes.AUTO_MN, "K01_A_MN_RCI": modes.FIRST_KINEMATIC, "KIN_A_MN_RCI": modes.KIN_A_MN,
        "POWERRED_RCO": modes.POWERRED, "PHG_ACTV_RCO": modes.PHG_ACTV, "AUTO_MN_RCO": modes.AUTO_OUT, "TEST_MN_RCO": modes.TEST_OUT,
        "CTRL_RESET_RCI": errors.CONTROL_RESET, "ERR_ACK_RCI": errors.ACKNOWLEDGE, "USER_1_RCI": user.FIRST_INPUT,
    }  # fmt: skip
    for name, number in used.items():
        place = at(name)
        assert place is not None and place.number == number, name
    assert numbers_of(ALL) == AS_SHIPPED


def test_a_moved_signal_is_used_where_it_lies() -> None:
    moved = ALL.moved({"USER_1_RCO": 256, "EMSTOP_OK_RCI": 600, "EMSTOP_RCO": 601, "INTIN_0_RCI": 704, "INTSTB_401_RCI": 601})
    image = PicImage()
    interface = SignalInterface(image, Installation(), numbers_of(moved))
    interface.step(0)
    assert interface.faults.shown == (528,) and image.output(601) and not image.output(67)
    image.inputs[89] = 42  # 402
    for bit in (600, 602):
        set_bit(image.inputs, bit, True)
    interface.user.write(3, True)
    interface.step(0)
    assert image.output(258) and interface.user.integer(402) == 42
    with pytest.raises(ValueError, match="whole byte"):
        numbers_of(ALL.moved({"INTIN_0_RCI": 705}))


def test_ours_move_as_a_row_and_the_manuals_only_to_what_it_prints() -> None:
    moved = ALL.moved({"USER_1_RCO": 256, "MSD_ACTI_RCO": 135})
    for name, number in (("USER_1_RCO", 256), ("USER_120_RCO", 375), ("MSD_ACTI_RCO", 135), ("POWERRED_RCO", 68)):
        signal = moved.named(name)
        assert signal is not None and signal.at == RcBit(OUT, number)
    assert moved.at(RcBit(OUT, 384)) is None and moved.at(RcBit(OUT, 115)) is None
    for places, words in (
        ({"POWERRED_RCO": 300}, "number stays"),
        ({"MSD_ACTI_RCO": 134}, "or is 135"),
        ({"USER_1_RCO": 192}, "INPOS_1_RCO"),
        ({"USER_1_RCO": 1000}, r"0\.\.1023"),
        ({"NOBODY": 1}, "no such signal"),
    ):
        with pytest.raises(SignalFault, match=words):
            ALL.moved(places)


@pytest.mark.parametrize(
    ("text", "operand", "written"),
    [
        ("M1020.4", Operand(Kind.FLAG, 1020, 4), "M1020.4"),
        ("F 6.3", Operand(Kind.FLAG, 6, 3), "M6.3"),
        ("m2047.7", Operand(Kind.FLAG, 2047, 7), "M2047.7"),
        ("MB7", Operand(Kind.FLAG, 7, bytes=1), "MB7"),
        ("FY 7", Operand(Kind.FLAG, 7, bytes=1), "MB7"),
        ("MD 944", Operand(Kind.FLAG, 944, bytes=4), "MD944"),
        ("EW2", Operand(Kind.INPUT, 2, bytes=2), "EW2"),
        ("IB 127", Operand(Kind.INPUT, 127, bytes=1), "EB127"),
        ("AD0", Operand(Kind.OUTPUT, 0, bytes=4), "AD0"),
        ("QB 5", Operand(Kind.OUTPUT, 5, bytes=1), "AB5"),
        ("T 31", Operand(Kind.TIMER, 31), "T31"),
        ("Z5", Operand(Kind.COUNTER, 5), "Z5"),
        ("C5", Operand(Kind.COUNTER, 5), "Z5"),
    ],
)
def test_operands_of_plc_programs(text: str, operand: Operand, written: str) -> None:
    assert parse_operand(text) == operand and str(operand) == written and parse_operand(written) == operand


def test_everything_else_is_read_as_ever_and_limits_hold() -> None:
    for text in ("DB10.DW2", "E 1.0", "I8.4", "RC 7.3", "K01_A_MN_RCI", "40001", "DB10.D0.8", "axis.X.actual"):
        assert parse_operand(text, ALL.symbols()) == parse(text, ALL.symbols())
    for text in ("M2048.0", "M0.8", "MD2045", "EW127", "IB128", "T256", "C999"):
        with pytest.raises(AddressFault, match=r"0\.\."):
            parse_operand(text)
    with pytest.raises(AddressFault, match="expected"):
        parse_operand("X5")
    with pytest.raises(AddressFault, match=r"MB 20 is the byte, M 20\.0 a bit; axisgate plc show"):
        parse_operand("M 20")


ROW = '[[signal]]\nname = "{name}"\ndirection = "input"\nbit = 7\nsource = "axisgate"\nen = "a signal"\nde = "ein Signal"\n'


def test_the_shipped_list_is_parsed_once_and_unmoved_it_stays_itself() -> None:
    assert signal_list() is signal_list()
    assert signal_list().moved({}) is signal_list()
    assert signal_list().all == ALL.all


def test_a_list_whose_file_has_changed_is_read_again(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "signals" / "own.toml"
    file.parent.mkdir()
    monkeypatch.setenv("AXISGATE_CONFIGS", str(tmp_path))
    file.write_text(ROW.format(name="FIRST_RCI"))
    assert [each.name for each in signal_list("own").all] == ["FIRST_RCI"]
    file.write_text(ROW.format(name="OTHER_RCI"))  # as long as the first one
    os.utime(file, ns=(1, 1))
    assert [each.name for each in signal_list("own").all] == ["OTHER_RCI"]
    assert signal_list().all == ALL.all
