"""An slcan adapter as a process of its own: a pty that speaks Lawicel's ASCII protocol, connected to a local bus.

python -m hil_tests.lab.partners.slcan_station --link PATH --bus NAME.  PATH becomes a link to the pty; ending the process is pulling the
adapter.
Source: CAN232 manual (Lawicel AB), commands S, O, L, C, t, V, N; answers CR, BELL.  Written apart from python-can's.
"""

import argparse
import os
import pathlib
import select
import signal

from drivers.ports.can.broker import BrokerPort
from drivers.ports.serial.pty import set_raw
from gateway.runtime.realtime import die_with_parent, go_realtime
from protocols.base.machine import Frame

PRIORITY = 25
CR, BELL = b"\r", b"\a"


class Station:
    """The adapter: closed, open, or listening."""

    def __init__(self, port: BrokerPort) -> None:
        self._port = port
        self._rest = b""
        self._open = self._mute = False
        self.rate = ""

    def hear(self, data: bytes) -> bytes:
        """Commands in, answers out."""
        *lines, self._rest = (self._rest + data).split(CR)
        return b"".join(self._do(line.decode("ascii", "replace")) for line in lines)

    def _do(self, line: str) -> bytes:
        match line[:1]:
            case "S" if not self._open:
                self.rate = line[1:]
            case "O" | "L" if not self._open:
                self._open, self._mute = True, line[0] == "L"
            case "C":
                self._open = False
            case "t" if self._open and not self._mute:
                count = int(line[4])
                self._port.send([Frame(int(line[1:4], 16), bytes.fromhex(line[5 : 5 + 2 * count]))])
            case "":
                return b""
            case _:
                return BELL
        return CR

    def heard(self) -> bytes:
        """Return frames of the bus as the adapter reports them."""
        frames = self._port.receive()
        if not self._open:
            return b""
        return b"".join(f"t{frame.identifier:03X}{len(frame.data)}{frame.data.hex().upper()}\r".encode() for frame in frames)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--link", type=pathlib.Path, required=True)
    parser.add_argument("--bus", required=True)
    arguments = parser.parse_args()
    die_with_parent(number=signal.SIGKILL)
    master, slave = os.openpty()
    set_raw(slave)
    arguments.link.unlink(missing_ok=True)
    arguments.link.symlink_to(os.ttyname(slave))
    port = BrokerPort(arguments.bus)
    station = Station(port)
    go_realtime(PRIORITY)
    print("ready", flush=True)
    while True:
        ready = select.select([master, port.fileno()], (), ())[0]
        if master in ready:
            os.write(master, station.hear(os.read(master, 4096)))
        if port.fileno() in ready:
            os.write(master, station.heard())


if __name__ == "__main__":
    main()
