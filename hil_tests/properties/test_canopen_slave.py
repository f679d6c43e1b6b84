"""The emulated CANopen slave under any traffic: never an exception, and the same answers however the same stamped frames are cut."""

from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import DICTIONARY, START
from protocols.base.machine import Frame, Ns
from protocols.canopen import sdo
from protocols.canopen.eds import parse

SERVO = ServoSettings(boot_s=0.001, charge_s=0.0, brake=False, torque_noise_nm=0.02)
NODES = {1: DriveSettings(SERVO, tpdo_delay_us=100, tpdo_spread_us=300), 2: DriveSettings(SERVO)}
SETTINGS = BusSettings(4.0, 7, {}, NODES)

MINE = [0x000, 0x080, 0x201, 0x202, 0x601, 0x602, 0x7E5, 0x77F, 0x181 | 1 << 30, 0x701 | 1 << 30]
KEYS = sorted(DICTIONARY.entries)
any_frame = st.builds(Frame, st.sampled_from(MINE), st.binary(max_size=8))
downloads = st.builds(
    lambda key, data, node: Frame(0x600 + node, sdo.expedited(sdo.Request.INITIATE_DOWNLOAD, key, data)),
    st.sampled_from(KEYS),
    st.binary(min_size=1, max_size=4),
    st.integers(1, 2),
)
starts = st.sampled_from([Frame(0, b"\x01\x00"), Frame(0x080), Frame(0x201, b"\x06" + bytes(5)), Frame(0x201, b"\x0f" + bytes(5))])
traffic = st.lists(st.tuples(st.one_of(any_frame, downloads, starts), st.integers(0, 5_000_000)), min_size=1, max_size=40)


def slave() -> Cia402Slave:
    return Cia402Slave(SETTINGS, dict.fromkeys(NODES, DICTIONARY))


def stamped(entries: list[tuple[Frame, Ns]]) -> list[Frame]:
    now, frames = START, []
    for frame, pause in entries:
        now += pause
        frames.append(frame._replace(stamp_ns=now))
    return frames


@settings(max_examples=150, deadline=None)
@given(traffic)
def test_any_traffic_is_borne_and_answers_do_not_depend_on_how_it_is_cut(entries: list[tuple[Frame, Ns]]) -> None:
    frames = stamped(entries)
    end = frames[-1].stamp_ns + 50_000_000
    whole, single = slave(), slave()
    whole.wake(START)
    whole.receive(frames, end)
    whole.wake(end)
    single.wake(START)
    for frame in frames:
        while (due := single.deadline()) is not None and due <= frame.stamp_ns:
            single.wake(due)
        single.receive([frame], frame.stamp_ns)
        single.prepare()
    single.wake(end)
    assert whole.take_output() == single.take_output()
    assert whole.take_record() == single.take_record()


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.sampled_from(
            [
                "[1000]",
                "[1000sub1]",
                "[DeviceInfo]",
                "ParameterName=x",
                "DataType=0x7",
                "DataType=",
                "ObjectType=9",
                "a",
                "[",
                "=",
                "DefaultValue=$NODEID+",
                "AccessType=rw",
                "LowLimit=5",
                "HighLimit=1",
                "CompactSubObj=3",
                "SubNumber=x",
                "[20]",
            ]
        )
        | st.text(max_size=12),
        max_size=40,
    )
)
def test_any_text_is_read_as_an_eds_without_an_exception(lines: list[str]) -> None:
    dictionary, _ = parse("\n".join(lines))
    assert all(key == entry.key for key, entry in dictionary.entries.items())
