"""VAL 3 manual, 3.7.3, sioCtrl: parameters, what they return, when they act."""

import pytest

from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from gateway.pure.controllers.val3.sio.control import Value
from gateway.pure.controllers.val3.sio.core import SioCore
from hil_tests.lab.virtual.val3_sio import SioBench
from hil_tests.requirements.val3_sio.stations import CLIENT, SERIAL, SERVER, UDP

JUDGE = "gateway.pure.controllers.val3.sio.control:judge"
APPLY = "gateway.pure.controllers.val3.sio.control:_apply"
CONTROL = "gateway.pure.controllers.val3.sio.core:SioCore.control"
CHANGE = "gateway.pure.controllers.val3.sio.core:SioCore.change"


@pytest.mark.requirement("VAL-SIO-17", by=(JUDGE, APPLY, CONTROL, CHANGE))
def test_the_example_of_the_manual() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    example: list[tuple[str, Value]] = [
        ("baudRate", 115200), ("bits", 8), ("parity", "none"), ("stopBits", 1), ("timeout", 0), ("endOfString", 13),
    ]  # fmt: skip
    assert [bench.control(sio, name, value) for name, value in example] == [0] * 6
    channel = bench.core.channel(SERIAL.name)
    assert (channel.frame, channel.timeout_s, channel.end_of_string) == ("115200 8N1", 0.0, 13)
    assert bench.configured[-1] == channel


@pytest.mark.requirement("VAL-SIO-18", by=(JUDGE, APPLY, CONTROL))
@pytest.mark.parametrize(
    "channel, name, value, code",
    [
        (SERIAL, "foo", 1, -1),
        (SERIAL, "", 1, -1),
        (SERIAL, "baudrate", 1, -1),
        (CLIENT, "port", "x", -2),
        (CLIENT, "port", True, -2),
        (CLIENT, "target", 1, -2),
        (CLIENT, "nagle", 1, -2),
        (SERIAL, "parity", False, -2),
        (SERIAL, "bits", 9, -3),
        (SERIAL, "bits", 4, -3),
        (SERIAL, "bits", 7.5, -3),
        (SERIAL, "stopBits", 1.5, -3),
        (SERIAL, "stopBits", 3, -3),
        (SERIAL, "parity", "mark", -3),
        (SERIAL, "mode", "rs485", -3),
        (SERIAL, "flowControl", "xonxoff", -3),
        (SERIAL, "baudRate", -9600, -3),
        (SERIAL, "timeout", -2, -3),
        (SERIAL, "timeout", float("nan"), -3),
        (SERIAL, "timeout", float("inf"), -3),
        (SERIAL, "endOfString", 256, -3),
        (SERIAL, "endOfString", -1, -3),
        (CLIENT, "port", 0, -3),
        (CLIENT, "port", 65536, -3),
        (CLIENT, "port", float("nan"), -3),
        (CLIENT, "target", "camera", -3),
        (CLIENT, "target", "192.168.0.256", -3),
        (CLIENT, "target", "0.0.0.0", -3),
        (SERVER, "clients", 0, -3),
        (CLIENT, "parity", "none", -5),
        (CLIENT, "clients", 1, -5),
        (SERVER, "target", "192.168.0.1", -5),
        (SERIAL, "nagle", True, -5),
        (SERIAL, "port", 1, -5),
        (UDP, "port", 1, -5),
        (UDP, "nagle", "x", -5),
    ],
)
def test_what_is_refused_changes_nothing(channel: Channel, name: str, value: Value, code: int) -> None:
    bench = SioBench(channel)
    assert bench.control(bench.variable(channel.name), name, value) == code
    assert bench.core.channel(channel.name) == channel and bench.configured == []


@pytest.mark.requirement("VAL-SIO-18", by=(APPLY, CONTROL))
def test_a_socket_must_be_closed_before_its_port_changes() -> None:
    cases: tuple[tuple[Channel, dict[str, Value]], ...] = (
        (CLIENT, {"port": 5000, "target": "10.0.0.1"}),
        (SERVER, {"port": 5000, "clients": 3}),
    )
    for channel, changes in cases:
        bench = SioBench(channel)
        sio = bench.variable(channel.name)
        bench.get(sio, [0.0])
        bench.client_comes(channel.name) if channel is SERVER else None
        assert [bench.control(sio, name, value) for name, value in changes.items()] == [-4, -4]
        assert bench.control(sio, "timeout", 1.5) == 0 and bench.control(sio, "endOfString", 10) == 0
        bench.clear(sio)
        assert [bench.control(sio, name, value) for name, value in changes.items()] == [0, 0]
    assert (bench.core.channel(SERVER.name).port, bench.core.channel(SERVER.name).clients) == (5000, 3)


@pytest.mark.requirement("VAL-SIO-18", by=(APPLY, CONTROL, "gateway.pure.controllers.val3.sio.line:Line.clear"))
def test_a_serial_line_must_rest_before_its_frame_changes() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    call = bench.get(sio, [0.0])
    frame: list[tuple[str, Value]] = [
        ("baudRate", 19200), ("bits", 7), ("parity", "even"), ("stopBits", 2), ("mode", "rs232"), ("flowControl", "hardware"),
    ]  # fmt: skip
    assert [bench.control(sio, name, value) for name, value in frame] == [-4] * 6
    bench.hears(1, b"a")
    assert bench.outcome(call) == 1
    assert int(bench.core.control(sio, "bits", 7, unsent=True)) == -4
    assert [bench.control(sio, name, value) for name, value in frame] == [0] * 6
    assert bench.core.channel(SERIAL.name).frame == "19200 7E2" and bench.clear(sio) == 0
    bench.hears(1, b"xyz")
    assert bench.clear(sio) == 3 and bench.closed == [], "characters go, the line stays"


@pytest.mark.requirement("VAL-SIO-19", by=(JUDGE, CHANGE))
def test_nagle_is_on_until_it_is_switched_off_also_while_connected() -> None:
    for channel in (CLIENT, SERVER):
        bench = SioBench(channel)
        sio = bench.variable(channel.name)
        bench.get(sio, [0.0])
        bench.client_comes(channel.name) if channel is SERVER else None
        assert bench.core.channel(channel.name).nagle
        assert bench.control(sio, "nagle", False) == 0
        assert [one.nagle for one in bench.configured] == [False]


def test_a_new_time_out_counts_from_the_next_instruction_on() -> None:
    bench = SioBench(SERIAL)
    sio = bench.variable(SERIAL.name)
    old = bench.get(sio, [0.0])
    bench.control(sio, "timeout", 0.5)
    new = bench.get(sio, [0.0])
    bench.at(10_000_000_000)
    assert (bench.outcome(old), bench.outcome(new)) == ("waits", 0)


@pytest.mark.parametrize(
    "channel, words",
    [
        (Channel("a", Kind.TCP_CLIENT, port=1), "needs the address of its server"),
        (Channel("a", Kind.TCP_SERVER), "port 0"),
        (Channel("a", Kind.UDP, address="camera", port=70000), "port 70000: 1..65535 expected; sio channel a: address"),
        (Channel("", Kind.SERIAL), "name is empty; sio channel : device is empty"),
        (Channel("a", Kind.SERIAL, device="/dev/x", timeout_s=-3, end_of_string=300), "end_of_string 300"),
    ],
)
def test_a_faulty_declaration_is_refused_with_every_fault(channel: Channel, words: str) -> None:
    with pytest.raises(ValueError) as caught:
        SioCore([channel])
    assert words in str(caught.value)
    with pytest.raises(ValueError, match="declared twice"):
        SioCore([SERIAL, SERIAL])
