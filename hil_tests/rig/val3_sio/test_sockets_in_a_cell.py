"""sio of an application in a cell: its channels are a real serial line and real sockets, served once a turn (AX-930)."""

import contextlib
import os
import socket
import termios
import time
from collections.abc import Callable

from gateway.links.serial.val3_cell_sio import CellSio
from gateway.pure.controllers.val3.sio.channel import Channel, Kind
from hil_tests.lab.running.cell_running import free_port
from hil_tests.unit.languages.val3.apps import App, datum, machine, value


def test_an_application_asks_a_camera_over_a_socket() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(5.0)
        channel = Channel("Socket\\cam", Kind.TCP_CLIENT, address="127.0.0.1", port=server.getsockname()[1], timeout_s=5.0)
        data = datum("sCam", "sio", "1", value(link="cam")) + datum("sText", "string") + datum("nDone", "num")
        app = App(data=data, programs={"start": 'sCam="where?"\nsText=sCam\nnDone=1'})
        made = machine(app)
        made.sio = CellSio([channel])
        own = made.instance("demo", "demo", "")
        assert own is not None and made.start(own)
        made.run(200_000_000)
        partner, _ = server.accept()
        with partner:
            partner.settimeout(5.0)
            asked = partner.recv(64)
            assert asked[:6] == b"where?"
            partner.sendall(b"12.5" + asked[6:])
            made.run(made.clock + 400_000_000)
        assert (own.data["sText"], own.data["nDone"]) == (["12.5"], [1.0])


def test_a_client_asks_an_application_that_listens() -> None:
    port = free_port()
    data = datum("sHost", "sio", "1", value(link="srv")) + datum("sText", "string") + datum("nDone", "num")
    made = machine(App(data=data, programs={"start": 'sText=sHost\nsHost="got "+sText\nnDone=1'}))
    made.sio = CellSio([Channel("Socket\\srv", Kind.TCP_SERVER, port=port, timeout_s=5.0)])
    own = made.instance("demo", "demo", "")
    assert own is not None and made.start(own)
    made.run(200_000_000)
    with socket.create_connection(("127.0.0.1", port), timeout=5.0) as client:
        client.sendall(b"part 7\r")
        made.run(made.clock + 400_000_000)
        assert client.recv(64).rstrip() == b"got part 7"
    assert (own.data["sText"], own.data["nDone"]) == (["part 7"], [1.0])


def test_an_application_talks_over_a_serial_line() -> None:
    master, slave = os.openpty()
    os.set_blocking(master, False)
    try:
        device = os.ttyname(slave)
        channel = Channel("Serial\\scale", Kind.SERIAL, device=device, timeout_s=5.0, baud_rate=19200, parity="even", end_of_string=13)
        data = datum("sScale", "sio", "1", value(link="Serial\\scale")) + datum("sText", "string") + datum("nByte", "num", "3")
        data += datum("nRead", "num") + datum("nSet", "num") + datum("nDone", "num")
        code = """sScale="W?"
sText=sScale
nSet=sioCtrl(sScale,"baudRate",38400)
nRead=sioGet(sScale,nByte)
sioSet(sScale,nByte)
sioCtrl(sScale,"timeout",-1)
nDone=1+sioGet(sScale,nByte)"""
        made = machine(App(data=data, programs={"start": code}))
        made.sio = CellSio([channel])
        own = made.instance("demo", "demo", "")
        assert own is not None and made.start(own)

        heard = bytearray()

        def until(test: Callable[[], bool]) -> None:
            """Real time and that of the application."""
            for _ in range(5000):
                made.sio.settle()
                made.run(made.clock + 4_000_000)
                with contextlib.suppress(BlockingIOError):
                    heard.extend(os.read(master, 16))
                if test():
                    return
                time.sleep(0.002)
            raise AssertionError((bytes(heard), own.data, made.log))

        until(lambda: heard == b"W?\r")
        assert termios.tcgetattr(slave)[4] == termios.B19200
        os.write(master, b"12.5 kg\r")
        until(lambda: own.data["nSet"] == [0.0] and own.data["sText"] == ["12.5 kg"])
        until(lambda: termios.tcgetattr(slave)[4] == termios.B38400)
        os.write(master, bytes((1, 2, 250)))
        until(lambda: own.data["nDone"] == [1.0])
        assert own.data["nByte"] == [1.0, 2.0, 250.0] and own.data["nRead"] == [3.0]
        assert heard[3:] == bytes((1, 2, 250))
    finally:
        os.close(master)
        os.close(slave)
