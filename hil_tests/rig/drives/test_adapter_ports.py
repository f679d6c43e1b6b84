"""Adapters of python-can as ports: a socketcand server written by hand, the virtual bus, and words when one cannot be opened."""

import re
import select
import socket
import threading
import time
from collections.abc import Iterator

import can
import pytest

from drivers.ports.base import CanPort, PortError
from drivers.ports.can.adapter import AdapterPort
from drivers.ports.can.adapter_url import Adapter, adapter_of, is_adapter
from drivers.ports.can.open import open_can
from gateway.commands.doctor import main as doctor
from gateway.processes.can_adapter import latency_words
from protocols.base.machine import Frame

LIMIT_S = 10.0


def heard(port: CanPort, count: int) -> list[Frame]:
    frames: list[Frame] = []
    end = time.monotonic() + LIMIT_S
    while len(frames) < count and time.monotonic() < end:
        select.select([port], (), (), 0.1)
        frames += port.receive()
    return frames


class Daemon:
    """One client of a socketcand: every frame it sends comes back with the next identifier."""

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.link: socket.socket | None = None
        self.opened = ""
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        while True:
            try:
                link, _ = self._listener.accept()
            except OSError:
                return
            with link:
                self.link = link
                self._speak(link)

    def _speak(self, link: socket.socket) -> None:
        try:
            link.sendall(b"< hi >")
            rest = ""
            while data := link.recv(1024):
                *told, rest = (rest + data.decode()).split(">")
                for one in told:
                    self._answer(link, one.strip("< "))
        except OSError:
            return

    def _answer(self, link: socket.socket, told: str) -> None:
        if match := re.fullmatch(r"send (\w+) (\d) ?(.*?) *", told):
            octets = "".join(f"{int(part, 16):02X}" for part in match[3].split())
            link.sendall(f"< frame {int(match[1], 16) + 1:03X} 23.424242 {octets} >".encode())
            return
        self.opened = told.split()[1] if told.startswith("open") else self.opened
        link.sendall(b"< ok >")

    def close(self) -> None:
        self._listener.close()
        if self.link is not None:
            self.link.close()


@pytest.fixture
def daemon() -> Iterator[Daemon]:
    found = Daemon()
    yield found
    found.close()


def test_a_port_of_socketcand_carries_frames_both_ways_and_reports_when_it_is_gone(daemon: Daemon) -> None:
    port = open_can(f"socketcand:can7?host=127.0.0.1&port={daemon.port}")
    assert isinstance(port, AdapterPort)
    frames = [Frame(100), Frame(210, bytes(range(8))), Frame(220, b"\xff\x00")]
    assert port.send(frames) == 3
    found = heard(port, 3)
    assert daemon.opened == "can7"
    assert [(frame.identifier, frame.data) for frame in found] == [(101, b""), (211, bytes(range(8))), (221, b"\xff\x00")]
    assert len(port.answer_ns) == 1 and port.own_ns == [] and port.counters.sent == port.counters.received == 3
    assert daemon.link is not None
    daemon.link.shutdown(socket.SHUT_RDWR)
    with pytest.raises(PortError, match=r"socketcand:can7.*opened again"):  # noqa: PT012 it shows at one of many calls
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            select.select([port], (), (), 0.1)
            port.receive()
            port.send([Frame(1)])
    port.close()


def test_an_adapter_without_a_descriptor_serves_too_and_own_frames_show_the_latency() -> None:
    with can.Bus(interface="virtual", channel="adapters") as partner:
        port = AdapterPort("virtual:adapters")
        assert port.send([Frame(200 + n, bytes((n,))) for n in range(5)]) == 5
        assert [getattr(partner.recv(1.0), "arbitration_id", None) for _ in range(5)] == [200, 201, 202, 203, 204]
        partner.send(can.Message(arbitration_id=0x12345678, is_extended_id=True, data=b"\x01"))
        partner.send(can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\x02"))
        assert [(frame.identifier, frame.data) for frame in heard(port, 1)] == [(0x123, b"\x02")], "own frames and extended ones are none"
        assert len(port.own_ns) == 5 and min(port.own_ns) > 0 and port.counters.ignored == 1
        assert latency_words(port.own_ns, port.answer_ns).startswith("echo latency, ms: count 5, p50 ")
        port.close()


def test_doctor_measures_an_adapter_that_gives_frames_back(capsys: pytest.CaptureFixture[str]) -> None:
    assert doctor(["can", "virtual:echo", "--count", "20", "--seconds", "0.1"]) == 2, "a real bus: --send is asked for"
    assert doctor(["can", "virtual:echo", "--count", "20", "--seconds", "0.1", "--send"]) in (0, 1)
    out = capsys.readouterr()
    assert "--send" in out.err and "adapter echo, ms: count 20, p50" in out.out


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("nosuch:0", "python-can has no interface 'nosuch'; it has .*slcan"),
        ("slcan:/dev/no-such-adapter", "slcan:/dev/no-such-adapter: .*No such file"),
        ("socketcand:can0?host=127.0.0.1&port=1", "is socketcand running there"),
        ("slcan:/dev/ttyACM0?what", "option 'what'"),
        ("can0", "a CAN port is socketcan:INTERFACE, broker:NAME or an adapter"),
    ],
)
def test_what_cannot_be_opened_is_reported(url: str, words: str) -> None:
    with pytest.raises(PortError, match=words):
        open_can(url)


def test_the_form_of_an_adapter() -> None:
    assert adapter_of("slcan:/dev/ttyACM0@500000?sleep_after_open=2&rtscts=true") == Adapter(
        "slcan", "/dev/ttyACM0", 500_000, {"sleep_after_open": 2, "rtscts": True}
    )
    assert adapter_of("socketcand:can0?host=10.0.0.5&port=29536").options == {"host": "10.0.0.5", "port": 29536}
    assert [is_adapter(url) for url in ("socketcan:can0", "broker:x", "memory:x", "sim", "pcan:PCAN_USBBUS1")] == [False] * 4 + [True]
