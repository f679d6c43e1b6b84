"""A second master says nothing: the one that is there (of the `canopen` package) is heard first and refused; a running cell reports it."""

import threading
import time
from collections.abc import Iterator
from typing import NamedTuple, Protocol

import can
import canopen
import pytest

from drivers.drives.cia402 import Cia402Set
from drivers.drives.cia402_family import Cia402Family
from drivers.drives.family import Actual
from drivers.ports.can.broker import BrokerPort
from gateway.__main__ import main
from gateway.cycle.bus_link import BusLink
from gateway.tools.drives.without_cycle import QUIET_S
from hil_tests.lab.partners.durand_drive import DurandDrive
from hil_tests.lab.running.bus_running import Bus, running_bus
from protocols.base.machine import Frame
from protocols.canopen.cob_id import sdo_answer, sdo_request

SYNC_S = 0.02


@pytest.fixture(scope="module")
def bus(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bus]:
    with running_bus(tmp_path_factory.mktemp("look"), name="look", log=False) as bus:
        yield bus


@pytest.fixture
def listener(bus: Bus) -> Iterator[BrokerPort]:
    port = bus.port()
    yield port
    port.close()


@pytest.fixture
def master(bus: Bus) -> Iterator[canopen.Network]:
    network = canopen.Network(can.Bus(interface="broker", channel="look"))
    network.connect()
    network.sync.start(SYNC_S)
    yield network
    network.sync.stop()  # type: ignore[no-untyped-call]  # canopen has no types here
    network.disconnect()


class Called(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


class Axisgate(Protocol):
    def __call__(self, *words: str) -> Called: ...


@pytest.fixture
def axisgate(capsys: pytest.CaptureFixture[str]) -> Axisgate:
    """The command in this process."""

    def call(*words: str) -> Called:
        capsys.readouterr()
        code = main(words)
        return Called(code, *capsys.readouterr())

    return call


@pytest.mark.parametrize(
    "command",
    [
        ("drive", "commission", "demo-402", "A2", "--port", "broker:look"),
        ("drive", "scan", "broker:look"),
        ("drive", "scan", "demo-402", "--port", "broker:look"),
        ("bus", "send", "broker:look", "--nmt", "reset-node"),
        ("run", "demo-402", "--bus", "broker:look"),
    ],
    ids=["commission", "scan", "scan-cell", "nmt", "run"],
)
def test_a_foreign_sync_is_reported_and_nothing_is_sent(
    listener: BrokerPort, master: canopen.Network, axisgate: Axisgate, command: tuple[str, ...]
) -> None:
    told = axisgate(*command)
    assert told.returncode == 3, told
    assert "broker:look: another master is active on this bus: SYNC (080h, " in told.stderr and "Traceback" not in told.stderr
    assert {frame.identifier for frame in listener.receive()} == {0x080}, "the SYNC of the master that was there, and nothing else"


def test_a_heartbeat_of_a_gateway_and_an_sdo_client_are_masters_too(bus: Bus, axisgate: Axisgate) -> None:
    for frame in (Frame(0x77F, b"\x05"), Frame(0x602, bytes.fromhex("4041600000000000"))):
        with talking(frame):
            told = axisgate("drive", "commission", "demo-402", "A2", "--port", "broker:look")
        assert told.returncode == 3 and f"{frame.identifier:03X}h" in told.stderr, told


def test_nmt_beside_a_master_leaves_when_it_is_asked_for(listener: BrokerPort, master: canopen.Network, axisgate: Axisgate) -> None:
    assert axisgate("bus", "send", "broker:look", "--nmt", "start", "--node", "3", "--beside").returncode == 0
    assert Frame(0, b"\x01\x03") in [frame._replace(stamp_ns=0) for frame in listener.receive()]


def test_a_scan_asks_beside_a_master_when_it_is_asked_for_and_names_the_way(bus: Bus, master: canopen.Network, axisgate: Axisgate) -> None:
    assert "or ask anyway with --beside" in axisgate("drive", "scan", "broker:look").stderr
    drive = DurandDrive("look", 5)
    try:
        told = axisgate("drive", "scan", "broker:look", "--beside")
        assert told.returncode == 0 and "node   5: drive" in told.stdout, told
    finally:
        drive.stop()


def test_a_scan_that_listened_has_its_second_round(bus: Bus, axisgate: Axisgate) -> None:
    """A loaded machine: every answer comes later than the first round waits."""
    device, ended = bus.port(), threading.Event()
    waiting: list[tuple[float, Frame]] = []

    def answers() -> None:
        while not ended.wait(0.005):
            for frame in device.receive():
                if frame.identifier == sdo_request(5):
                    waiting.append(
                        (time.monotonic() + 3 * QUIET_S, Frame(sdo_answer(5), b"\x43" + frame.data[1:4] + bytes.fromhex("92010200")))
                    )
            while waiting and waiting[0][0] < time.monotonic():
                device.send([waiting.pop(0)[1]])

    thread = threading.Thread(target=answers)
    thread.start()
    told = axisgate("drive", "scan", "broker:look")
    ended.set()
    thread.join()
    device.close()
    assert told.returncode == 0 and "node   5: drive, vendor 0x00020192" in told.stdout, told


def test_a_silent_bus_is_talked_on(bus: Bus, axisgate: Axisgate) -> None:
    assert axisgate("bus", "send", "broker:look", "--nmt", "start").returncode == 0
    told = axisgate("drive", "commission", "demo-402", "A2", "--port", "broker:look")
    assert told.returncode == 1 and "does not answer" in told.stderr


def test_drives_are_not_emulated_beside_those_with_their_numbers(bus: Bus, axisgate: Axisgate) -> None:
    with talking(Frame(0x702, b"\x7f")):
        told = axisgate("emulate", "demo-402", "--bus", "broker:look")
    assert told.returncode == 3 and "node 2 is on this bus already" in told.stderr, told


class talking:  # reads as a verb where it is used
    """One frame every 20 ms from a thread of python-can."""

    def __init__(self, frame: Frame) -> None:
        self._frame = frame

    def __enter__(self) -> None:
        self._bus = can.Bus(interface="broker", channel="look")
        message = can.Message(arbitration_id=self._frame.identifier, data=self._frame.data, is_extended_id=False)
        self._task = self._bus.send_periodic(message, SYNC_S)

    def __exit__(self, *_: object) -> None:
        self._task.stop()
        self._bus.shutdown()


def cycles(link: BusLink, count: int, other: BrokerPort, says: list[Frame], *, behind: bool = False) -> list[bool]:
    """Turns of 10 ms: what the other one says, before the moment of the burst or `behind` it, and what was received."""
    sent = []
    for _ in range(count):
        if not behind:
            other.send(says)
            time.sleep(0.001)
        link.prepare([Cia402Set()])
        sent.append(link.send(time.monotonic_ns()))
        if behind:
            other.send(says)
        time.sleep(0.01)
        actuals: list[Actual | None] = [None]
        link.receive(actuals)
    return sent


@pytest.mark.parametrize("behind", [False, True])
def test_a_cycle_holds_its_burst_until_the_other_master_is_silent(bus: Bus, capsys: pytest.CaptureFixture[str], behind: bool) -> None:
    other = bus.port()
    link = BusLink("broker:look", Cia402Family([(0, 2)], 5, 1), protocol="canopen", listens=True)
    assert not any(cycles(link, 50, other, [Frame(0x080)], behind=behind)), "half a second beside a SYNC"
    assert {frame.identifier for frame in other.receive()} == set(), "not one frame"
    told = capsys.readouterr().out
    assert told.count("another master is active on this bus: SYNC (080h)") == 1 and "nothing is sent while it is active" in told
    sent = cycles(link, 50, other, [])
    assert sent.index(True) >= 20 and all(sent[sent.index(True) :]), "it begins when a quarter of a second was quiet"
    link.close()
    other.close()


@pytest.mark.parametrize("frame", [Frame(0x080), Frame(0x77F, b"\x05"), Frame(0, b"\x81\0"), Frame(0x602, bytes(8))])
def test_a_running_cycle_reports_another_master_once(bus: Bus, capsys: pytest.CaptureFixture[str], frame: Frame) -> None:
    other = bus.port()
    link = BusLink("broker:look", Cia402Family([(0, 2)], 5, 1), protocol="canopen")
    assert all(cycles(link, 10, other, []))
    assert "another master" not in capsys.readouterr().out
    assert all(cycles(link, 10, other, [frame])), "a cell that moves goes on and reports it"
    told = capsys.readouterr().out
    assert told.count("another master is active on this bus") == 1 and f"({frame.identifier:03X}h)" in told
    link.close()
    other.close()


def test_a_second_sender_of_an_actual_value_is_reported_and_a_late_one_is_not(bus: Bus, capsys: pytest.CaptureFixture[str]) -> None:
    other, twin = bus.port(), bus.port()
    link = BusLink("broker:look", Cia402Family([(0, 2)], 5, 1), protocol="canopen")
    assert all(cycles(link, 3, other, []))
    link.family.release(2, 8)
    said = Frame(0x182, bytes(6))

    def turns(count: int, twice: int) -> None:
        for n in range(count):
            link.prepare([Cia402Set()])
            assert link.send(time.monotonic_ns())
            other.send([said])
            if n % twice == 0:
                twin.send([said])
            time.sleep(0.002)
            link.receive([None])

    turns(300, 20)
    assert "is received twice" not in capsys.readouterr().out
    turns(60, 1)
    told = capsys.readouterr().out
    assert told.count("the actual value of axis 1 is received twice in a cycle: a second device has the same number") == 1, told
    for port in (link, other, twin):
        port.close()
