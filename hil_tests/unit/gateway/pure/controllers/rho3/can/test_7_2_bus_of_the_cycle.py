"""rho 3 Releases part 5, 7.2: the cycle transmits the parameters in the start-up phase; drives and I/O blocks share the burst."""

import pytest

from drivers.drives.family import Demand
from drivers.drives.servodyn import Drive, Power
from drivers.drives.servodyn_download import Download
from drivers.drives.servodyn_family import ServodynFamily
from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.family import Parameters, RhoFamily
from gateway.pure.controllers.rho3.can.rules import Block
from gateway.pure.image.records.cell import InputImage, Quality
from hil_tests.lab.virtual.servodyn_bus import CODEC, START
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, ms
from protocols.servodyn.codec import ActualValue, SetValue

IO = IoSettings(1, (Block(92, 2, 541),), (Block(94, 1, 471),))


def test_two_boosters_get_their_parameters_one_after_the_other_at_most_one_request_a_cycle() -> None:
    slave = ServodynSlave(BusSettings(4.0, 1, {1: ServoSettings(), 2: ServoSettings()}), CODEC)
    runs = {1: Parameters(0, Download([(7, 50.0), (15, 12000.0)])), 2: Parameters(1, Download([(7, 60.0), (30, 1)]))}
    family = RhoFamily(None, ServodynFamily(CODEC, [(0, 1), (1, 2)]), runs)
    said: list[str] = []
    requests: list[int] = []
    for cycle in range(40):
        frames = family.burst([SetValue(), SetValue()])
        requests += [frame.identifier for frame in frames if frame.identifier in (310, 320)]
        assert [frame.identifier for frame in frames][:3] == [100, 210, 220] and len(frames) <= 4
        now = START + cycle * ms(4)
        slave.receive([frame._replace(stamp_ns=now) for frame in frames], now)
        heard = [family.hear(frame) for frame in slave.take_output()]
        assert [each[0] for each in heard if each is not None] == [0, 1]
        said += family.take_news()
    assert requests == [310, 310, 320, 320]
    assert said == ["module 1: 2 parameters taken", "module 2: parameters not taken: the drive does not have parameter 30"]
    assert [slave.axis(n).settings.kv_per_s for n in (1, 2)] == [50.0, 60.0]


def test_a_drive_is_asked_to_come_on_only_when_its_parameters_are_through() -> None:
    """Its wish stands from the first cycle: a booster with power would answer 645."""
    slave = ServodynSlave(BusSettings(4.0, 1, {1: ServoSettings(), 2: ServoSettings()}), CODEC)
    family = RhoFamily(None, ServodynFamily(CODEC, [(0, 1), (1, 2)]), {2: Parameters(1, Download([(n, 0.7) for n in (20,) * 70]))})
    drives = [Drive(), Drive()]
    actuals: dict[int, ActualValue] = {}
    on_at: dict[int, int] = {}
    for cycle in range(150):
        values = [drive.step(actuals.get(n), Demand(on=cycle > 15)) for n, drive in enumerate(drives)]
        now = START + cycle * ms(4)
        slave.receive([frame._replace(stamp_ns=now) for frame in family.burst(values)], now)
        for frame in slave.take_output():
            if frame.identifier in (610, 620):
                actuals[frame.identifier // 10 - 61] = CODEC.decode_actual(frame)[1]
            family.hear(frame)
        for n, actual in actuals.items():
            if actual.power_on:
                on_at.setdefault(n, cycle)
        told = family.take_news()
        assert told in ([], ["module 2: 1 parameters taken"])
    assert on_at[0] < 30 < 60 < on_at[1] and drives[1].power is Power.ENABLED


def test_io_blocks_leave_behind_the_set_values_and_a_byte_nobody_vouches_for_is_0() -> None:
    family = RhoFamily(IoBus(IO, 0), ServodynFamily(CODEC, [(0, 1)]))
    image, inputs = InputImage(), bytearray(128)
    image.values[94] = 0x5A
    assert family.exchange(image, inputs, 0, up=True) == []
    assert family.burst([SetValue()])[-1] == Frame(471, b"\x00")
    image.quality[94] = Quality.GOOD
    family.exchange(image, inputs, ms(4), up=True)
    frames = family.burst([SetValue()])
    assert [frame.identifier for frame in frames] == [100, 210, 471] and frames[-1].data == b"\x5a"
    assert family.hear(Frame(541, b"\x01\x02")) is None
    family.exchange(image, inputs, ms(8), up=True)
    assert inputs[92:94] == b"\x01\x02" and family.expected == 1
    with pytest.raises(DecodeError):
        family.hear(Frame(542, b"\x01\x02"))


def test_a_bus_that_was_never_there_is_not_supervised_and_one_that_went_is() -> None:
    family = RhoFamily(IoBus(IO, 0))
    image, inputs = InputImage(), bytearray(128)
    assert [family.exchange(image, inputs, ms(4 * n), up=False) for n in range(5)] == [[]] * 5
    assert family.exchange(image, inputs, ms(20), up=True) == []
    said = [text for n in range(6, 9) for text in family.exchange(image, inputs, ms(4 * n), up=False)]
    assert said == ["380 no transm. CAN1 I1", "380 imperm. data CAN1 O1"]
    assert [frame.identifier for frame in family.burst([])] == [100, 471] and family.expected == 0
    with pytest.raises(DecodeError):
        family.hear(Frame(610, bytes(8)))


def test_a_simulation_waits_for_a_module_that_answered_so_far_and_not_for_one_that_is_silent_or_coupled() -> None:
    """AX-915: what a machine keeps back is waited for; a module that is away is reported, and one wait is enough."""
    family = RhoFamily(IoBus(IO, 0))
    image, inputs = InputImage(), bytearray(128)
    assert not family.awaited, "nothing was asked yet"
    family.exchange(image, inputs, ms(4), up=True)
    assert family.awaited
    family.hear(Frame(541, b"\x01\x02"))
    assert not family.awaited
    family.exchange(image, inputs, ms(8), up=True)
    assert family.awaited, "the next SYNC asks again"
    assert family.exchange(image, inputs, ms(12), up=True) == ["380 no transm. CAN1 I1"]
    assert not family.awaited, "silent"
    family.hear(Frame(541, b"\x01\x02"))
    family.exchange(image, inputs, ms(16), up=True)
    assert family.awaited, "it is there again"
    coupled = RhoFamily(IoBus(IoSettings(1, (Block(92, 2, 471),)), 0))
    coupled.exchange(image, inputs, ms(4), up=True)
    assert not coupled.awaited and not RhoFamily(None).awaited
