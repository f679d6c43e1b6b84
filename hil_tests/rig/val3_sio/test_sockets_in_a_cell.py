"""sio of an application in a cell: its channel is a real socket, served once a turn (AX-930)."""

import socket

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
