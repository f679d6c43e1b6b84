"""The local bus between real processes: order, stamps, slow and dead partners, the broker's own death, its log."""

import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest

from drivers.ports.base import PortError
from drivers.ports.can.broker import BrokerPort, broker_stats, socket_path
from drivers.ports.can.wire import RECORD, Control, control_record
from gateway.simulation.bus.log import LogPipe
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.running.bus_running import Bus, receive, running_bus, wait_readable
from protocols.base.machine import Frame, FrameFault

CYCLE = [Frame(100)] + [Frame(200 + 10 * axis, bytes([axis] * 8)) for axis in range(1, 7)]


@pytest.fixture
def bus(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path) as running:
        yield running


def plain(frames: list[Frame]) -> list[tuple[int, bytes]]:
    return [(frame.identifier, frame.data) for frame in frames]


def drain(port: BrokerPort) -> None:
    while True:
        port.receive()


def count_of(stats: dict[str, object], key: str) -> int:
    value = stats[key]
    assert isinstance(value, int)
    return value


def test_every_other_subscriber_gets_all_frames_in_order_with_the_same_rising_stamps(bus: Bus) -> None:
    a, b, c = bus.port(), bus.port(), bus.port()
    before = time.monotonic_ns()
    for number in range(300):
        assert a.send(CYCLE) == 7
        assert b.send([Frame(610, number.to_bytes(2, "little"))]) == 1
        if number % 20 == 0:
            time.sleep(0.001)
    at_c = receive(c, 2400)
    after = time.monotonic_ns()
    assert [frame.data for frame in at_c if frame.identifier == 610] == [number.to_bytes(2, "little") for number in range(300)]
    assert plain([frame for frame in at_c if frame.identifier != 610]) == plain(CYCLE) * 300
    stamps = [frame.stamp_ns for frame in at_c]
    assert stamps == sorted(stamps) and before < stamps[0] and stamps[-1] < after
    at_b = receive(b, 2100)
    assert at_b == [frame for frame in at_c if frame.identifier != 610], "another stamp or order than c saw"
    assert plain(receive(a, 300)) == [(610, number.to_bytes(2, "little")) for number in range(300)], "own frames are not heard"
    assert a.counters.sent == 2100 and a.counters.received == 300 and a.counters.refused == 0
    bus.stop()
    logged = buslog.frames(bus.log_lines())
    assert [frame.sequence for frame in logged] == list(range(1, 2401))
    assert [Frame(frame.identifier, frame.data, frame.stamp_ns) for frame in logged] == at_c
    assert len({frame.sender for frame in logged}) == 2 and {
        frame.sender == logged[0].sender for frame in logged if frame.identifier != 610
    } == {True}


def test_frames_of_one_send_travel_in_one_message_up_to_64_and_share_their_stamp(bus: Bus) -> None:
    a, b = bus.port(), bus.port()
    assert a.send([Frame(n) for n in range(150)]) == 150
    frames = receive(b, 150)
    assert [frame.identifier for frame in frames] == list(range(150))
    assert len({frame.stamp_ns for frame in frames[:64]}) == 1 and len({frame.stamp_ns for frame in frames}) <= 3
    with pytest.raises(ValueError, match="9 bytes"):
        a.send([Frame(1), Frame(2, bytes(9))])
    with pytest.raises(ValueError, match="0x800"):
        a.send([Frame(0x800)])
    assert a.counters.sent == 150


def test_one_message_may_be_taken_alone_and_the_rest_stays(bus: Bus) -> None:
    a, b, c = bus.port(), bus.port(), bus.port()
    assert a.send([Frame(n) for n in range(150)]) == 150
    receive(c, 150)  # by then all of it waits at b, too
    parts: list[list[Frame]] = []
    while sum(map(len, parts)) < 150:
        wait_readable(b)
        parts.append(b.receive_next())
    assert max(map(len, parts)) <= 64
    assert [frame.identifier for part in parts for frame in part] == list(range(150))


def test_a_stopped_subscriber_is_disconnected_and_the_others_lose_nothing(bus: Bus) -> None:
    a, b = bus.port(), bus.port()
    program = (
        "import sys,time; from drivers.ports.can.broker import BrokerPort; "
        "p=BrokerPort(sys.argv[1]); print('on',flush=True); time.sleep(60)"
    )
    monitor = subprocess.Popen([sys.executable, "-c", program, bus.name], stdout=subprocess.PIPE, text=True)
    try:
        assert monitor.stdout is not None and monitor.stdout.readline() == "on\n"
        monitor.send_signal(signal.SIGSTOP)
        total = 0
        while count_of(broker_stats(bus.name), "overflows") == 0:
            assert total < 200_000, "the stopped subscriber's queue has no end"
            for _ in range(16):
                assert a.send([Frame(n) for n in range(64)]) == 64
                total += 64
                assert len(receive(b, 64)) == 64
        assert b.counters.received == total == a.counters.sent and b.counters.gaps == 0 and a.counters.refused == 0
        assert total > 16_384, "at least a second of a full bus is kept for a slow subscriber"
        stats = broker_stats(bus.name)
        assert monitor.pid not in [client["pid"] for client in stats["clients"]] and stats["overflow_frames"] > 16_384
    finally:
        monitor.kill()
        monitor.communicate()
    bus.stop()
    said = [entry.text for entry in buslog.remarks(bus.log_lines()) if "too slow" in entry.text]
    assert len(said) == 1 and f"pid {monitor.pid}" in said[0]
    assert len(buslog.frames(bus.log_lines())) == total


def test_a_disconnected_subscriber_learns_it_and_reconnecting_reports_the_gap(tmp_path: pathlib.Path) -> None:
    with running_bus(tmp_path, "--queue", "100") as bus:
        a, slow = bus.port(), bus.port()
        a.send([Frame(1)])
        assert len(receive(slow, 1)) == 1
        sent = 0
        while count_of(broker_stats(bus.name), "overflows") == 0:
            sent += a.send([Frame(2)] * 64)
        with pytest.raises(PortError, match="too slow"):
            drain(slow)
        got = slow.counters.received - 1
        slow.reconnect()
        wait_readable(slow)
        slow.receive()
        assert got + slow.counters.gaps == sent
        a.send([Frame(3)])
        assert plain(receive(slow, 1)) == [(3, b"")]


def test_a_killed_subscriber_and_a_sender_that_leaves_at_once_disturb_nobody(bus: Bus) -> None:
    a, b = bus.port(), bus.port()
    program = (
        "import sys,time; from drivers.ports.can.broker import BrokerPort; "
        "p=BrokerPort(sys.argv[1]); print('on',flush=True); time.sleep(60)"
    )
    victim = subprocess.Popen([sys.executable, "-c", program, bus.name], stdout=subprocess.PIPE, text=True)
    assert victim.stdout is not None and victim.stdout.readline() == "on\n"
    for number in range(100):
        a.send(CYCLE)
        if number == 50:
            victim.kill()
    victim.communicate()
    leaver = BrokerPort(bus.name)
    wait_readable(leaver)
    bus.process.send_signal(signal.SIGSTOP)
    leaver.send([Frame(7, b"bye")])
    leaver.close()  # without reading a word: the broker sees a reset before it sees the frame
    bus.process.send_signal(signal.SIGCONT)
    assert plain(receive(b, 701)) == plain(CYCLE) * 100 + [(7, b"bye")]
    assert [client["pid"] for client in broker_stats(bus.name)["clients"]].count(victim.pid) == 0


def test_a_killed_broker_is_a_port_error_and_its_successor_takes_the_name(bus: Bus) -> None:
    a, b = bus.port(), bus.port()
    a.send(CYCLE)
    receive(b, 7)
    bus.stop(signal.SIGKILL)
    assert os.path.exists(socket_path(bus.name)), "a killed broker leaves its socket file"
    with pytest.raises(PortError, match="open the port again"):
        a.send(CYCLE)
    with pytest.raises(PortError, match="open the port again"):
        b.receive()
    with pytest.raises(PortError, match=r"start it with: python -m gateway\.simulation\.bus\.broker --name t"):
        b.reconnect()
    bus.start()
    a.reconnect()
    b.reconnect()
    for port in (a, b):
        wait_readable(port)
        port.receive()
    assert a.send(CYCLE) == 7
    assert plain(receive(b, 7)) == plain(CYCLE)
    assert b.counters.gaps == 0, "sequence numbers of another broker say nothing about this one's"


def test_a_second_broker_of_the_name_is_refused_and_the_first_goes_on(bus: Bus) -> None:
    second = subprocess.run(
        [sys.executable, "-m", "gateway.simulation.bus.broker", "--name", bus.name], check=False, capture_output=True, text=True, timeout=10
    )
    assert second.returncode == 3 and "another broker of this name is running" in second.stderr
    bus.process.send_signal(signal.SIGSTOP)  # a stopped one is not a dead one
    try:
        stopped = subprocess.run(
            [sys.executable, "-m", "gateway.simulation.bus.broker", "--name", bus.name],
            check=False,
            capture_output=True,
            text=True,
            timeout=10,
        )
    finally:
        bus.process.send_signal(signal.SIGCONT)
    assert stopped.returncode == 3
    a, b = bus.port(), bus.port()
    a.send(CYCLE)
    assert plain(receive(b, 7)) == plain(CYCLE)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_an_ended_broker_leaves_no_socket_and_no_process(bus: Bus, number: int) -> None:
    port = bus.port()
    assert bus.stop(number)[0] == 0
    assert os.listdir(os.environ["AXISGATE_RUNTIME"]) == []
    with pytest.raises(PortError):
        port.receive()
    assert (
        subprocess.run(["pgrep", "-g", "0", "-f", f"broker --name {bus.name} "], check=False, capture_output=True, text=True).stdout == ""
    )


def test_a_full_sender_learns_how_many_were_taken_and_counts_the_rest(bus: Bus) -> None:
    a, b = bus.port(), bus.port()
    bus.process.send_signal(signal.SIGSTOP)
    given = taken = 0
    while taken == given:
        assert given < 10_000_000
        given += 64
        taken += a.send([Frame(5)] * 64)
    assert a.counters.refused == given - taken and a.counters.sent == taken
    assert a.send(CYCLE) == 0 and a.counters.refused == given - taken + 7
    bus.process.send_signal(signal.SIGCONT)
    assert len(receive(b, taken)) == taken
    assert a.send(CYCLE) == 7


def test_malformed_messages_are_counted_and_harm_nobody(bus: Bus) -> None:
    b = bus.port()
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as raw:
        raw.connect(socket_path(bus.name))
        long = RECORD.pack(1, 9, 0, bytes(8), 0, 0)
        good = RECORD.pack(2, 1, 99, b"A", 12345, 67890)
        for message in (b"x", bytes(31), bytes(33), bytes(32 * 65), long + good, control_record(Control.GAP, b"")):
            raw.send(message)
        assert plain(receive(b, 1)) == [(2, b"A")], "stamp, sender and sequence are the broker's alone"
        stats = broker_stats(bus.name)
    assert (stats["malformed"], stats["frames"]) == (6, 1)


def test_error_frames_reach_the_port_as_faults(bus: Bus) -> None:
    b = bus.port()
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as raw:
        raw.connect(socket_path(bus.name))
        for can_id, data in (
            (0x20000040, bytes(8)),
            (0x20000004, b"\0\x20" + bytes(6)),
            (0x20000020, bytes(8)),
            (0x20000008, bytes(8)),
            (0x80000001, b""),
        ):
            raw.send(RECORD.pack(can_id, len(data), 0, data, 0, 0))
        raw.send(RECORD.pack(5, 0, 0, b"", 0, 0))
        assert plain(receive(b, 1)) == [(5, b"")]
    kinds = [kind for kind, _ in b.take_faults()]
    assert kinds == [FrameFault.BUS_OFF, FrameFault.ERROR_PASSIVE, FrameFault.NO_ACK, FrameFault.OTHER]
    assert b.counters.faults == 4 and b.counters.ignored == 1 and b.take_faults() == []


def test_sigusr1_reports_the_counters_on_standard_error_and_in_the_log(bus: Bus) -> None:
    a = bus.port()
    a.send(CYCLE)
    while count_of(broker_stats(bus.name), "frames") < 7:
        pass
    bus.process.send_signal(signal.SIGUSR1)
    assert bus.process.stderr is not None
    told = json.loads(bus.process.stderr.readline())
    assert told["frames"] == 7 and told["pid"] == bus.process.pid
    bus.stop()
    assert json.dumps(told) in [entry.text for entry in buslog.remarks(bus.log_lines())]


def test_the_log_survives_a_killed_broker_and_names_its_senders(bus: Bus) -> None:
    a, b = bus.port(), bus.port()
    for _ in range(100):
        a.send(CYCLE)
    receive(b, 700)
    time.sleep(0.2)  # the broker hands its log over when the bus is quiet for 50 ms
    bus.stop(signal.SIGKILL)
    assert bus.log is not None
    end = time.monotonic() + 5
    while time.monotonic() < end and bus.log.read_text().count("\n") < 700:
        time.sleep(0.01)
    frames = buslog.frames(bus.log_lines())
    assert len(frames) == 700
    assert buslog.senders(buslog.remarks(bus.log_lines()))[frames[0].sender] == os.getpid()


def test_a_log_that_cannot_be_written_in_time_says_how_much_it_lost(tmp_path: pathlib.Path) -> None:
    fifo = tmp_path / "stuck"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)  # a disk that takes nothing for a while
    log = LogPipe(str(fifo), "t")
    record = RECORD.pack(100, 0, 1, b"", 1_234_567_890, 7)
    text = bytearray()

    def drain_file() -> None:
        while part := os.read(reader, 65536):
            text.extend(part)

    try:
        put, spent = 0, time.thread_time()
        while log.lost < 1000:  # a put that waited would wait for ever: the test's time-out
            log.put(record * 64)
            put += 64
            assert put < 1_000_000
        spent = time.thread_time() - spent
        lost = log.lost
        os.set_blocking(reader, True)
        disk = threading.Thread(target=drain_file, daemon=True)  # the disk takes everything again
        disk.start()
        while log.waiting():
            log.flush()
            time.sleep(0.001)
        log.put(record)
        log.close()
        disk.join()
    except BaseException:
        os.kill(log._child, signal.SIGKILL)
        raise
    assert spent / (put / 64) < 100e-6, "a stuck log costs bus time"
    entries = list(buslog.read(text.decode().splitlines(keepends=True)))
    assert sum(entry.lost for entry in entries if isinstance(entry, buslog.Remark)) == lost
    logged = [entry for entry in entries if isinstance(entry, buslog.Logged)]
    assert len(logged) == put - lost + 1 and logged[0] == buslog.Logged(1_234_567_890, 100, b"", False, 1, 7)
    os.close(reader)


def test_the_log_reads_as_candump_wrote_it() -> None:
    lines = ["(1436509052.249713) vcan0 044#2A366C2B\n", "(0.000001) t 064# 3 9 234\n", "(1.5) t\n"]
    assert list(buslog.read(lines[:2])) == [
        buslog.Logged(1436509052249713000, 0x44, bytes.fromhex("2A366C2B")),
        buslog.Logged(1234, 100, b"", False, 3, 9),
    ]
    with pytest.raises(ValueError, match="line 3"):
        list(buslog.read(lines))
    assert list(buslog.read(["(0.000001) t 06"])) == []
