"""The Modbus server over real sockets: pipelines, pieces, limits, and partners that misbehave or die."""

import asyncio
import contextlib
import errno
import os
import random
import socket
import struct
import time
from collections.abc import Sequence

import pytest

from drivers.ports.base import PortError
from gateway.links.modbus.tcp_server import Limits, ModbusServer
from hil_tests.lab.running.modbus_running import RawClient, Running
from hil_tests.lab.virtual.modbus_view import MemoryView
from protocols.base.machine import ms
from protocols.modbus.mbap import Why
from protocols.modbus.view import ExceptionCode, Kind

READ_1 = "03 0000 0001"


def request(transaction: int, pdu: str = READ_1) -> bytes:
    body = bytes.fromhex(pdu)
    return struct.pack(">HHHB", transaction & 0xFFFF, 0, len(body) + 1, 1) + body


def test_ten_requests_in_one_segment_get_ten_answers_with_their_ids_in_order() -> None:
    with Running() as running, running.client() as client:
        running.view.words[Kind.HOLDING_REGISTERS][0] = 0x1234
        client.send(b"".join(request(n) for n in range(500, 510)))
        assert client.take(10 * 11) == b"".join(request(n, "03 02 1234") for n in range(500, 510))


def test_one_byte_per_segment_is_answered() -> None:
    with Running() as running, running.client() as client:
        for byte in request(7) + request(8):
            client.send(bytes((byte,)))
        assert client.take(22) == request(7, "03 02 0000") + request(8, "03 02 0000")


def test_a_half_frame_and_silence_is_closed_at_its_deadline_and_nobody_else_notices() -> None:
    with Running(limits=Limits(receive_limit_ns=ms(400))) as running, running.client() as half, running.client() as other:
        half.send(request(1)[:9])
        assert other.ask(READ_1) == "03 02 00 00"
        assert 0.25 <= half.closed_after_s() <= 1.5
        assert other.ask(READ_1) == "03 02 00 00"
        assert running.server.counters.closed == {Why.HALF_FRAME: 1}


def test_a_wrong_length_closes_after_the_requests_before_it_were_answered() -> None:
    with Running() as running, running.client() as client:
        client.send(request(1) + request(2) + b"\x00\x03\x00\x00\x00\x00")
        assert client.take(23) == request(1, "03 02 0000") + request(2, "03 02 0000")
        assert running.server.counters.closed == {Why.LENGTH: 1}


def test_another_protocol_is_ignored_and_counted() -> None:
    with Running() as running, running.client() as client:
        client.send(b"\x00\x05\x00\x01\x00\x04\x01\x02\x03\x04")
        assert client.ask(READ_1) == "03 02 00 00"
        assert running.server.counters.foreign == 1 and running.server.clients[0].foreign == 1


def test_a_flood_of_requests_is_answered_whole_and_in_order_while_others_are_served() -> None:
    count, answers = 30_000, b""
    with Running() as running, running.client() as flood, running.client() as other:
        waiting = memoryview(b"".join(request(n) for n in range(count)))
        flood.socket.setblocking(False)
        slowest = 0.0
        while len(answers) < 11 * count:
            with contextlib.suppress(BlockingIOError):
                waiting = waiting[flood.socket.send(waiting[:8192]) :] if waiting else waiting
            try:
                answers += flood.socket.recv(65536)
            except BlockingIOError:
                start = time.monotonic()
                assert other.ask(READ_1) == "03 02 00 00"
                slowest = max(slowest, time.monotonic() - start)
        assert answers == b"".join(request(n, "03 02 0000") for n in range(count))
        assert slowest < 1.0


def test_a_flood_of_garbage_costs_its_connections_and_nothing_else() -> None:
    noise = random.Random(1)
    with Running() as running, running.client() as other:
        for _ in range(50):
            with running.client() as flood:
                try:
                    flood.send(noise.randbytes(20_000))
                except ConnectionError:
                    continue  # closed in the middle of it
                flood.closed_after_s()
        assert other.ask(READ_1) == "03 02 00 00"
        running.until(lambda: len(running.server.clients) == 1, "the flooders' places are free")
        assert running.server.counters.closed[Why.LENGTH] > 0


def fill(client: RawClient, pdu: str) -> int:
    """Sends requests and reads nothing until the server takes no more or closes; how many bytes were sent."""
    block, sent, last = request(1, pdu) * 50, 0, time.monotonic()
    client.socket.setblocking(False)
    while time.monotonic() - last < 0.5:
        try:
            sent += client.socket.send(block[sent % 12 :])
            last = time.monotonic()
        except BlockingIOError:
            time.sleep(0.01)
        except ConnectionError:
            break
    client.socket.settimeout(10)
    return sent


def test_a_client_that_never_reads_is_stopped_by_bounded_memory_and_gets_everything_when_it_reads() -> None:
    limits = Limits(receive_limit_ns=ms(400))  # shorter than the time nobody reads: a request cut by our own stopping is not late
    with Running(limits=limits) as running, running.client(buffers=16384) as mute, running.client() as other:
        running.view.words[Kind.HOLDING_REGISTERS][124] = 0xBEEF
        sent = fill(mute, "03 0000 007D")
        assert 0 < running.server.unsent_bytes() <= running.server.limits.held_bytes
        assert running.server.counters.requests < sent // 12, "it goes on reading from a client that takes no answers"
        assert other.ask(READ_1) == "03 02 00 00"
        expected = request(1, "03 FA" + "0000" * 124 + "BEEF")
        assert mute.take(sent // 12 * len(expected)) == expected * (sent // 12)
        if sent % 12:  # the full buffer had cut a request
            mute.send(request(1, "03 0000 007D")[sent % 12 :])
            assert mute.take(len(expected)) == expected
        assert mute.ask(READ_1) == "03 02 00 00"


def test_a_client_that_never_reads_is_dropped_in_the_end() -> None:
    with Running(limits=Limits(stall_limit_ns=ms(300))) as running, running.client(buffers=16384) as mute:
        fill(mute, "03 0000 007D")
        running.until(lambda: not running.server.clients, "the stalled client is gone")
        assert running.server.counters.stalled == 1 and running.server.unsent_bytes() == 0


def test_the_33rd_client_is_refused_and_the_place_of_one_that_left_is_free_again() -> None:
    with Running() as running:
        clients = [running.client() for _ in range(32)]
        assert [client.ask(READ_1) for client in clients] == ["03 02 00 00"] * 32
        with running.client() as refused:
            assert refused.closed_after_s() < 5 and running.server.counters.refused_connections == 1
        assert {client.ask(READ_1) for client in clients} == {"03 02 00 00"}
        clients.pop().socket.close()
        running.until(lambda: len(running.server.clients) == 31, "the place is free")
        with running.client() as late:
            assert late.ask(READ_1) == "03 02 00 00"
        for client in clients:
            client.socket.close()


def test_an_idle_client_is_closed_where_that_is_asked_for() -> None:
    with Running(limits=Limits(idle_limit_ns=ms(400))) as running, running.client() as client:
        assert client.ask(READ_1) == "03 02 00 00"
        assert 0.2 <= client.closed_after_s() <= 1.5 and running.server.counters.idle == 1


def test_clients_that_die_leave_nothing_behind() -> None:
    with Running() as running, running.client() as other:
        for _ in range(40):
            with running.client() as dying:
                dying.send(request(1, "03 0000 007D") * 40 + request(1)[:5])
                dying.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # close sends RST
        assert other.ask(READ_1) == "03 02 00 00"
        running.until(lambda: len(running.server.clients) == 1, "the dead clients are gone")
        assert running.server.unsent_bytes() == 0


def test_a_client_that_closes_its_sending_half_still_gets_its_answers() -> None:
    with Running() as running, running.client() as client:
        client.send(request(1) + request(2)[:5])
        client.socket.shutdown(socket.SHUT_WR)
        assert client.take(12) == request(1, "03 02 0000")
        running.until(lambda: running.server.counters.closed == {Why.LOST: 1}, "the half frame is counted")


@pytest.mark.parametrize(
    "allow, answer", [(["10.0.0.5"], "86 01"), ([], "86 01"), (["10.0.0.5", "127.0.0.0/8"], "06 00 03 12 34"), (None, "06 00 03 12 34")]
)
def test_only_allowed_addresses_write_and_everybody_reads(allow: list[str] | None, answer: str) -> None:
    with Running(allow=allow) as running, running.client() as client:
        assert client.ask("06 0003 1234") == answer
        assert client.ask("03 0003 0001") == ("03 02 12 34" if answer[:2] == "06" else "03 02 00 00")
        assert running.server.clients[0].rights.write == (answer[:2] == "06")


def test_an_ipv4_partner_on_an_ipv6_socket_is_the_same_partner() -> None:
    server = ModbusServer(lambda _: None, limits=Limits(allow=["10.0.0.5", "fd00::/8"]))
    partners = ("10.0.0.5", "::ffff:10.0.0.5", "fd00::1%eth0", "10.0.0.6", "::1")
    assert [server.may_write(host) for host in partners] == [True, True, True, False, False]


def test_only_requests_answered_without_exception_count_as_life() -> None:
    told: list[tuple[str, int]] = []
    with Running(on_request=lambda address, function: told.append((address, function))) as running, running.client() as client:
        for pdu in ("41", "03 0000 0000", "03 0FFF 0001", "06 0000 0001", READ_1):
            client.ask(pdu)
        assert client.ask(READ_1, unit=9) == "83 0B"
        address = f"127.0.0.1:{client.socket.getsockname()[1]}"
        assert told == [(address, 6), (address, 3)]
        (served,) = running.server.clients
        assert (served.address, served.requests, served.exceptions) == (address, 6, 4)
        assert served.last_request_ns == running.server.last_request_ns and served.last_request_ns is not None
        assert running.server.counters.requests == 6
        assert running.server.counters.exceptions == {
            ExceptionCode.ILLEGAL_FUNCTION: 1,
            ExceptionCode.ILLEGAL_DATA_VALUE: 1,
            ExceptionCode.ILLEGAL_DATA_ADDRESS: 1,
            ExceptionCode.GATEWAY_TARGET_SILENT: 1,
        }


class BrokenView(MemoryView):
    """A view whose holding registers raise."""

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        raise KeyError(address)


def test_a_view_or_a_watcher_that_raises_costs_one_request_and_is_named() -> None:
    def watcher(address: str, function: int) -> None:
        raise RuntimeError("nobody is watching")

    with Running(view=BrokenView(), on_request=watcher) as running, running.client() as client:
        assert client.ask(READ_1) == "83 04"
        assert "KeyError" in running.server.counters.last_view_fault
        assert client.ask("06 0000 0007") == "06 00 00 00 07"
        assert running.server.counters.view_faults == 2 and "nobody is watching" in running.server.counters.last_view_fault


def start_error(host: str, port: int) -> str:
    with pytest.raises(PortError) as caught:
        asyncio.run(ModbusServer(lambda _: None, host=host, port=port).start())
    return str(caught.value)


def test_a_port_in_use_is_named_with_what_to_do() -> None:
    with Running() as running:
        text = start_error("127.0.0.1", running.port)
    assert f"127.0.0.1:{running.port}: in use" in text and "`bind`" in text


def test_an_address_of_another_machine_is_named() -> None:
    text = start_error("192.0.2.77", 1502)
    assert "192.0.2.77" in text and "`bind`" in text


def test_a_forbidden_port_is_named_with_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> socket.socket:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(socket, "create_server", refuse)
    text = start_error("127.0.0.1", 502)
    assert "127.0.0.1:502" in text and "1502" in text and "ip_unprivileged_port_start" in text


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


def test_close_ends_everything_and_the_same_port_opens_again_at_once() -> None:
    async def life() -> int:
        before = open_files()
        server = ModbusServer(lambda _: MemoryView(), port=0)
        for _ in range(3):
            await server.start()
            clients = [RawClient(server.address[1]) for _ in range(5)]
            for client in clients:
                client.send(request(1) + request(2)[:4])
            while server.counters.requests < 5:
                await asyncio.sleep(0.005)
            await server.close()
            assert server.clients == [] and {client.closed_after_s() < 5 for client in clients} == {True}
            for client in clients:
                client.socket.close()
            server.counters.requests = 0
        assert len(asyncio.all_tasks()) == 1
        return open_files() - before

    assert asyncio.run(life()) == 0
