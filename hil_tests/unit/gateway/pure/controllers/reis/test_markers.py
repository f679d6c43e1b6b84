"""Markers, analog values, regulator errors of the Reis.  ROBOTstar V manual: L574-588, L2296, L2906-2986, L4682-4740."""

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.reis.analog import ana_inp, output_volts
from gateway.pure.controllers.reis.binary import Area, BinaryIo, IoFault
from gateway.pure.controllers.reis.markers import SYSTEM, Markers, meaning
from gateway.pure.controllers.reis.regulator import Message, Reference, regulator_error, start


def fresh() -> tuple[BinaryIo, Markers]:
    io = BinaryIo(PicImage())
    return io, Markers(io)


@pytest.mark.requirement("RSV-IO-04", by="gateway.pure.controllers.reis.markers:Markers.bit")
def test_inputs_and_outputs_are_markers() -> None:
    io, markers = fresh()
    io.write_bit(Area.INPUT, True, 3, 2)
    io.write_bit(Area.OUTPUT, True, 5, 3)
    assert markers.bit(1971, 2) and markers.bit(2013, 3)
    assert [byte for byte in range(1968, 2048) if markers.byte(byte)] == [1971, 2013]


@pytest.mark.requirement("RSV-IO-04", by="gateway.pure.controllers.reis.markers:Markers.set_bit")
def test_a_marker_of_an_output_is_the_output() -> None:
    io, markers = fresh()
    markers.set_bit(2047, 7, True)
    assert io.read_bit(Area.OUTPUT, 39, 7) and io.element(Area.OUTPUT, 10) == 1 << 31
    with pytest.raises(IoFault, match="is an input"):
        markers.set_bit(1971, 2, True)
    for byte, bit in ((2048, 0), (-1, 0), (0, 8)):
        with pytest.raises(IoFault, match=r"M2047\.7"):
            markers.bit(byte, bit)


@pytest.mark.requirement("RSV-IO-07", by="gateway.pure.controllers.reis.analog:ana_inp")
def test_marker_16384_is_5_volts() -> None:
    _, markers = fresh()
    markers.set_byte(1874, 16384 & 255)
    markers.set_byte(1875, 16384 >> 8)
    assert abs(ana_inp(markers, 2) - 5.0) <= 10.0 / 32767 and ana_inp(markers, 1) == 0.0
    markers.set_number(1918, -32767, 2)
    assert ana_inp(markers, 24) == -10.0


@pytest.mark.requirement("RSV-IO-07", by="gateway.pure.controllers.reis.analog:volts_of")
def test_an_output_is_shown_in_volts() -> None:
    _, markers = fresh()
    markers.set_number(1920, 16384, 2)
    markers.set_number(1966, -32767, 2)
    assert abs(output_volts(markers, 1) - 5.0) < 10 / 32767 and output_volts(markers, 24) == -10.0
    with pytest.raises(IoFault, match=r"1\.\.24"):
        output_volts(markers, 25)


def test_double_words_and_retention() -> None:
    io, markers = fresh()
    markers.set_number(212, 0x12345678)
    assert [markers.byte(byte) for byte in (212, 213, 214, 215)] == [0x78, 0x56, 0x34, 0x12]
    markers.set_number(944, -5)
    assert markers.number(944) == -5
    markers.set_bit(1020, 4, False)  # R M1020.4
    io.write_bit(Area.OUTPUT, True, 0, 0)
    kept = markers.retained()
    io, again = fresh()
    assert again.bit(1020, 4)
    again.power_on(kept)
    assert again.number(212) == 0x12345678 and again.bit(1020, 4) and again.number(944) == 0 and not io.byte(Area.OUTPUT, 0)
    with pytest.raises(IoFault, match="1968"):
        again.power_on(b"")


def test_system_markers_by_place() -> None:
    names = {
        (1020, 4): "power-on",
        (1020, 6): "robot synchronous",
        (944, 0): "error number of the control",
        (1024, 7): "actual value axis 1",
        (1119, 0): "actual value axis 24",
        (1147, 0): "TCP C",
        (1243, 0): "nominal position axis 24",
        (1435, 0): "override axis 24",
        (967, 0): "text parameter 4",
        (1473, 0): "path time done, 0.01 s",
        (2047, 7): "binary outputs",
        (1967, 0): "analog output 24",
    }
    for place, name in names.items():
        found = meaning(*place)
        assert found is not None and found.name == name
    for place in ((0, 0), (511, 7), (899, 0), (1020, 0), (1121, 0), (1871, 6)):
        assert meaning(*place) is None
    taken = [(row.byte + at, row.bit) for row in SYSTEM for at in range(row.bytes)]
    assert len(set(taken)) == len(taken)


@pytest.mark.requirement("RSV-DRV-01", by="gateway.pure.controllers.reis.regulator:regulator_error")
def test_error_647() -> None:
    _, markers = fresh()
    message = regulator_error(markers, 647, axis=3)
    assert message == Message(647, 3, "Servoregulator error 647: tracking distance too long")
    assert markers.number(944) == 647 and markers.bit(1021, 0)
    for number in (641, 700):
        assert regulator_error(markers, number, 1).text == f"Servoregulator error {number}: unknown"
    for number in (640, 701):
        with pytest.raises(ValueError, match=r"641\.\.700"):
            regulator_error(markers, number, 1)


@pytest.mark.requirement("RSV-DRV-03", by="gateway.pure.controllers.reis.regulator:start")
def test_a_changed_reference_point_makes_the_robot_asynchronous() -> None:
    _, markers = fresh()
    kept = {1: Reference(10.0, 4, 1), 2: Reference(20.0)}
    assert start(markers, kept, kept) == [] and markers.bit(1020, 6) and not markers.bit(1021, 0)
    for number, changed in ((677, Reference(10.5, 4, 1)), (678, Reference(10.0, 5, 1)), (679, Reference(10.0, 4, -1))):
        _, markers = fresh()
        markers.set_bit(1020, 6, True)
        messages = start(markers, kept, {**kept, 1: changed})
        assert [(message.number, message.axis) for message in messages] == [(number, 1)]
        assert not markers.bit(1020, 6) and markers.number(944) == number and markers.bit(1021, 0)
    _, markers = fresh()
    assert start(markers, {}, kept) == [] and not markers.bit(1020, 6)
