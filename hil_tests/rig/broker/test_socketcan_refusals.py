"""The SocketCAN port where no kernel CAN is needed: a full queue (vcan cannot be full), a host without CAN, URLs."""

import errno
import socket

import pytest

from drivers.ports.base import PortError
from drivers.ports.can.open import open_can
from drivers.ports.can.socketcan import SocketCanPort
from protocols.base.machine import Frame


class FullSocket:
    """A CAN interface that takes three frames and then has no room."""

    def __init__(self, number: int) -> None:
        self.taken: list[bytes] = []
        self._errno = number

    def send(self, octets: bytes) -> int:
        if len(self.taken) == 3:
            raise OSError(self._errno, "full")
        self.taken.append(octets)
        return len(octets)

    def close(self) -> None:
        pass


@pytest.mark.parametrize("number", [errno.ENOBUFS, errno.EAGAIN])
def test_a_full_interface_takes_the_first_frames_in_order_and_the_rest_is_counted(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    full = FullSocket(number)
    monkeypatch.setattr(SocketCanPort, "_open", lambda *_: full)
    port = SocketCanPort("can0")
    assert port.send([Frame(100 + n, bytes([n])) for n in range(7)]) == 3
    assert (port.counters.sent, port.counters.refused) == (3, 4)
    assert [octets[:9] for octets in full.taken] == [bytes([100 + n, 0, 0, 0, 1, 0, 0, 0, n]) for n in range(3)]


def test_any_other_refusal_is_a_port_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SocketCanPort, "_open", lambda *_: FullSocket(errno.ENETDOWN))
    port = SocketCanPort("can0")
    with pytest.raises(PortError, match="can0: the interface is down: sudo ip link set can0 up"):
        port.send([Frame(n) for n in range(7)])


def test_a_host_without_can_says_so_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_can(*_: object) -> socket.socket:
        raise OSError(errno.EAFNOSUPPORT, "Address family not supported by protocol")

    monkeypatch.setattr(socket, "socket", no_can)
    with pytest.raises(PortError, match=r"^socketcan:can0: this kernel has no CAN[^\n]*broker:NAME$"):
        open_can("socketcan:can0")


@pytest.mark.parametrize("url", ["", "can0", "broker:", "socketcan:"])
def test_an_unknown_url_names_what_exists(url: str) -> None:
    with pytest.raises(PortError, match=r"a CAN port is socketcan:INTERFACE, broker:NAME or an adapter of python-can, e\.g\. "):
        open_can(url)
