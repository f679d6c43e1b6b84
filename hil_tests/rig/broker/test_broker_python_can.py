"""python-can on the local bus: can.Bus(interface="broker"), Notifier in a thread and in asyncio, both ways."""

import asyncio
import pathlib
import signal
import time
from collections.abc import Iterator

import can
import pytest

from drivers.ports.can.memory import memory_pair
from hil_tests.lab.running.bus_running import Bus, receive, running_bus
from protocols.base.machine import Frame, FrameFault

MANY = [Frame(300 + n, bytes([n])) for n in range(100)]


@pytest.fixture
def bus(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path, log=False) as running:
        yield running


def flood(plug: can.BusABC) -> None:
    for _ in range(1_000_000):
        plug.send(can.Message(arbitration_id=1, is_extended_id=False), timeout=0.01)


def test_messages_go_both_ways_between_a_port_and_python_can(bus: Bus) -> None:
    port = bus.port()
    with can.Bus(interface="broker", channel=bus.name) as plug:
        plug.recv(0.05)
        plug.send(can.Message(arbitration_id=210, data=bytes(range(8)), is_extended_id=False))
        assert [(frame.identifier, frame.data) for frame in receive(port, 1)] == [(210, bytes(range(8)))]
        before = time.monotonic()
        port.send([Frame(610, b"\x01\x02")])
        message = plug.recv(5)
        assert message is not None
        assert (message.arbitration_id, bytes(message.data), message.is_extended_id, message.dlc) == (610, b"\x01\x02", False, 2)
        assert before <= message.timestamp <= time.monotonic() and message.channel == bus.name
        start = time.monotonic()
        assert plug.recv(0.05) is None and 0.04 < time.monotonic() - start < 1


def test_extended_remote_and_error_frames_pass_from_python_can_to_python_can(bus: Bus) -> None:
    sent = [
        can.Message(arbitration_id=0x1ABCDEF0, data=b"ext", is_extended_id=True),
        can.Message(arbitration_id=0x123, is_remote_frame=True, dlc=4, is_extended_id=False),
        can.Message(arbitration_id=0x40, data=bytes(8), is_error_frame=True, is_extended_id=False),
    ]
    port = bus.port()
    with can.Bus(interface="broker", channel=bus.name) as one, can.Bus(interface="broker", channel=bus.name) as two:
        two.recv(0.05)
        for message in sent:
            one.send(message)
        for message in sent:
            received = two.recv(5)
            assert received is not None and received.equals(message, timestamp_delta=None, check_channel=False, check_direction=False)
        one.send(can.Message(arbitration_id=1, is_extended_id=False))
        assert [frame.identifier for frame in receive(port, 1)] == [1]
    assert port.counters.ignored == 2 and [kind for kind, _ in port.take_faults()] == [FrameFault.BUS_OFF]


def test_a_notifier_thread_hands_over_every_message_of_a_batch(bus: Bus) -> None:
    port = bus.port()
    with can.Bus(interface="broker", channel=bus.name) as plug:
        plug.recv(0.05)
        reader = can.BufferedReader()
        notifier = can.Notifier(plug, [reader], timeout=0.1)
        port.send(MANY)
        received = [reader.get_message(5) for _ in MANY]
        notifier.stop()
    assert [message.arbitration_id for message in received if message] == [frame.identifier for frame in MANY]


def test_a_notifier_in_asyncio_hands_over_every_message_of_a_batch(bus: Bus) -> None:
    port = bus.port()

    async def listen() -> list[int]:
        with can.Bus(interface="broker", channel=bus.name) as plug:
            plug.recv(0.05)
            reader = can.AsyncBufferedReader()
            notifier = can.Notifier(plug, [reader], loop=asyncio.get_running_loop())
            port.send(MANY)
            received = [(await asyncio.wait_for(reader.get_message(), 5)).arbitration_id for _ in MANY]
            notifier.stop()
        return received

    assert asyncio.run(listen()) == [frame.identifier for frame in MANY]


def test_a_missing_dead_or_full_broker_is_pythons_can_error(bus: Bus) -> None:
    with pytest.raises(can.CanInitializationError, match="start it with"):
        can.Bus(interface="broker", channel="nobody")
    with can.Bus(interface="broker", channel=bus.name) as plug:
        with pytest.raises(can.CanOperationError, match="classic"):
            plug.send(can.Message(arbitration_id=1, data=bytes(12), is_fd=True))
        plug.recv(0.05)
        bus.process.send_signal(signal.SIGSTOP)
        with pytest.raises(can.CanOperationError, match="full"):
            flood(plug)
        bus.stop(signal.SIGKILL)
        with pytest.raises(can.CanOperationError, match="open the port again"):
            plug.send(can.Message(arbitration_id=1, is_extended_id=False))
        with pytest.raises(can.CanOperationError, match="open the port again"):
            plug.recv(1)


def test_a_memory_pair_behaves_as_a_bus_of_two() -> None:
    now = iter(range(1000, 2000))
    a, b = memory_pair(lambda: next(now), limit=3)
    assert a.send([Frame(1), Frame(2), Frame(3), Frame(4)]) == 3 and a.counters.refused == 1
    assert b.receive() == [Frame(1, b"", 1000), Frame(2, b"", 1000), Frame(3, b"", 1000)] and b.receive() == []
    b.fault(FrameFault.BUS_OFF)
    assert b.receive() == [] and b.take_faults() == [(FrameFault.BUS_OFF, 1001)]
    b.close()
    with pytest.raises(OSError, match="closed"):
        a.receive()
    a.close()
