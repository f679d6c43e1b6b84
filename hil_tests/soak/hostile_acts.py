"""What the hostile partners of a run do, all at once, in a process of their own: python -m hil_tests.soak.hostile_acts --name RUN ..

Each act continues until the end, even if it is refused or its partner is gone, and counts what it did; the counts are the only line that is
printed.
"""

import argparse
import contextlib
import http.client
import json
import random
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable

from drivers.ports.base import PortError, runtime_dir
from drivers.ports.can.broker import BrokerPort
from gateway.simulation.line.control import LineControl
from protocols.base.machine import Frame

READ_125 = bytes.fromhex("00010000000601030000007d")
FOREIGN = range(0x500, 0x7F0)  # identifiers of no drive of the cell
PATHS = ("/api/health", "/api/cell", "/api/errors?q=drive", "/api/alarms", "/api/me", "/api/trend?id=axis.A1.actual&seconds=60", "/nothing")
WEBSOCKET = "GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
GONE = (OSError, PortError, ValueError, http.client.HTTPException)


class Hostile:
    """One run as its hostile partners see it."""

    def __init__(self, name: str, web: int, modbus: int, seed: int) -> None:
        self.name, self.web, self.modbus = name, web, modbus
        self.random = random.Random(seed)
        self.over = threading.Event()
        self.did: Counter[str] = Counter()

    def acts(self) -> list[Callable[[], None]]:
        """Some of them more than once at a time."""
        floods: list[Callable[[], None]] = [self.modbus_flood] * 2 + [self.tools_flood] * 2
        halves: list[Callable[[], None]] = [self.half_modbus, self.half_pages, self.half_tools, self.deaf_pages]
        return [self.bus_flood, *floods, *halves, *[self.wrong_passwords] * 3, self.reads, self.noise, self.unplugging]

    def run(self, act: Callable[[], None], pause: float) -> None:
        """Again and again."""
        while not self.over.wait(pause):
            with contextlib.suppress(*GONE):
                act()
                self.did[act.__name__] += 1

    # ---- the bus
    def bus_flood(self) -> None:
        """2,000 frames a second of a device that babbles."""
        port = BrokerPort(f"{self.name}-drives")
        try:
            while not self.over.wait(0.01):
                port.send([Frame(self.random.choice(FOREIGN), self.random.randbytes(self.random.randrange(9))) for _ in range(20)])
                port.receive()
                self.did["frames"] += 20
        finally:
            port.close()

    # ---- Modbus, page, tools
    def _tcp(self, port: int) -> socket.socket:
        return socket.create_connection(("127.0.0.1", port), timeout=3.0)

    def _unix(self, name: str) -> socket.socket:
        link = socket.socket(socket.AF_UNIX)
        link.settimeout(3.0)
        try:
            link.connect(str(runtime_dir() / name))
        except OSError:
            link.close()
            raise
        return link

    @staticmethod
    def _pour(link: socket.socket, octets: bytes) -> None:
        """Sends for a second without waiting for an answer."""
        with link:
            link.setblocking(False)
            end = time.monotonic() + 1.0
            while time.monotonic() < end:
                with contextlib.suppress(BlockingIOError):
                    link.send(octets)
                with contextlib.suppress(BlockingIOError):
                    link.recv(1 << 20)
                time.sleep(0.005)

    def modbus_flood(self) -> None:
        self._pour(self._tcp(self.modbus), READ_125 * 50)

    def tools_flood(self) -> None:
        self._pour(self._unix(f"{self.name}-services.sock"), b'{"op":"status"}\n' * 50)

    def half_modbus(self) -> None:
        """Headers without an end, lengths that lie, and silence."""
        with contextlib.ExitStack() as stack:
            for octets in (
                b"\0",
                READ_125[:7],
                READ_125[:4] + b"\xff\xff" + READ_125[6:],
                b"\x00\x01\x12\x34\x00\x06\x01\x03",
                self.random.randbytes(300),
            ):
                stack.enter_context(self._tcp(self.modbus)).sendall(octets)
            self.over.wait(2.0)

    def half_pages(self) -> None:
        """Requests without an end."""
        head = f"POST /api/login HTTP/1.1\r\nHost: 127.0.0.1:{self.web}\r\nContent-Type: application/json\r\nx-axisgate: 1\r\n"
        with contextlib.ExitStack() as stack:
            for text in ("GET /api/he", head, head + "Content-Length: 100000\r\n\r\n{", "GET / HTTP/1.1\r\nHost:", "\x16\x03\x01\x02"):
                stack.enter_context(self._tcp(self.web)).sendall(text.encode())
            self.over.wait(2.0)

    def half_tools(self) -> None:
        """Of both sockets: no end, no JSON, far too much."""
        with contextlib.ExitStack() as stack:
            for name in (f"{self.name}.sock", f"{self.name}-services.sock"):
                for octets in (b'{"op": "sta', b"\xff\xfe\n", b"[1, 2]\n", b"x" * 200_000):
                    with contextlib.suppress(OSError):
                        stack.enter_context(self._unix(name)).sendall(octets)
            self.over.wait(1.0)

    def deaf_pages(self) -> None:
        """Pages that are open and take nothing."""
        with contextlib.ExitStack() as stack:
            for n in range(4):
                link = stack.enter_context(self._tcp(self.web))
                link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                head = WEBSOCKET.format(port=self.web)
                link.sendall(f"{head}Sec-WebSocket-Key: {'dGhlIHNhbXBsZSBub25jZQ=='}\r\n\r\n".encode())
                if n == 0:
                    link.sendall(b"\x81\xfe\xff\xff")  # half a message
            self.over.wait(4.0)

    def wrong_passwords(self) -> None:
        body = json.dumps({"name": "anna", "password": f"guess {self.random.random()}"})
        self.did[f"login {self._request('POST', '/api/login', body)}"] += 1

    def reads(self) -> None:
        self._request("GET", self.random.choice(PATHS))

    def _request(self, method: str, path: str, body: str | None = None) -> int:
        link = http.client.HTTPConnection("127.0.0.1", self.web, timeout=3.0)
        try:
            link.request(method, path, body, {"content-type": "application/json", "x-axisgate": "1"})
            return link.getresponse().status
        finally:
            link.close()

    # ---- the line
    def noise(self) -> None:
        """Characters spoiled and out of nowhere, BREAK."""
        with LineControl(f"{self.name}-plc1") as cable:
            cable.damage_some("A", "parity", 0.01, self.random.randrange(1000))
            cable.noise(self.random.choice("AB"), self.random.randbytes(20))
            if self.random.random() < 0.2:
                cable.send_break(self.random.choice("AB"))

    def unplugging(self) -> None:
        with LineControl(f"{self.name}-plc1") as cable:
            cable.unplug()
            self.over.wait(self.random.uniform(0.2, 3.0))
            cable.plug()
            self.over.wait(self.random.uniform(2.0, 6.0))

    def calm(self) -> None:
        """The line as it was."""
        with contextlib.suppress(*GONE), LineControl(f"{self.name}-plc1") as cable:
            cable.calm()
            cable.plug()


PAUSES = {"wrong_passwords": 0.1, "reads": 0.05, "noise": 1.0}


def main() -> int:
    parser = argparse.ArgumentParser(prog="hil_tests.soak.hostile_acts")
    parser.add_argument("--name", required=True)
    parser.add_argument("--web", type=int, required=True)
    parser.add_argument("--modbus", type=int, required=True)
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    hostile = Hostile(arguments.name, arguments.web, arguments.modbus, arguments.seed)
    threads = [threading.Thread(target=hostile.run, args=(act, PAUSES.get(act.__name__, 0.02))) for act in hostile.acts()]
    for thread in threads:
        thread.start()
    time.sleep(arguments.seconds)
    hostile.over.set()
    for thread in threads:
        thread.join(10)
    hostile.calm()
    print(json.dumps(hostile.did))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
