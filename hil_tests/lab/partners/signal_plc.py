"""The PLC of an old controller's cell, seen from its own side: RC inputs written, RC outputs read, by bit numbers.  Two ways to it:
DB 20 and DB 21 over 3964R and RK512 by our lab's active station, and coils and discrete inputs by Debian's mbpoll.
"""

import pathlib
import time
from collections.abc import Callable
from typing import Protocol

from gateway.simulation.line.control import LineControl
from hil_tests.lab.partners.mbpoll import mbpoll, values_of
from hil_tests.lab.partners.plc1 import PROFILE
from hil_tests.lab.partners.rk512_active import ActiveStation, Done, Event, Unasked
from hil_tests.lab.partners.sync_line import SyncLine
from protocols.p3964r.profiles import Priority

FIRST, LAST = 2, 31  # bytes of the image the PLC has
PATIENCE_S = 20.0
AXIS = """
[[axis]]
name            = "{name}"
unit            = "mm"
drive           = {{ type = "servodyn", bus = "drives", module = {module}, inc_per_turn = 16384 }}
mechanics       = {{ feed_per_turn = 100.0, gear = "5:1", direction = "+" }}
limits          = {{ min = -2000.0, max = 2000.0, speed = 800.0, accel = 3000.0, jerk = 30000.0 }}
following_error = {{ warn = 30.0, trip = 60.0 }}
home            = {{ by = "none" }}
"""
CELL = """
format = 1
[cell]
name = "a cell of an old controller"
replaces = "rho3.1"
[rc_inputs]
owner = {{ {owners} }}
[rho3]
P2 = 5
P9 = {p9}
{rho3}
[controller]
{controller}
[[line]]
name = "rack"
port = "sim"
format = "38400 8E1"
protocol = "3964R"
profile = "rho3"
[line.rk512]
types = ["D", "E", "A", "M", "T", "Z"]
[line.supervision]
max_silence_ms = 8000
[[db]]
number = 30
words = 8
writer = "plc"
line = "rack"
entries = [
  {{ at = "DW 0", type = "KH", to = "MW 0" }},
  {{ at = "DD 4", type = "DH", to = "MD 40" }},
  {{ at = "D 7.3", type = "bit", to = "M 50.7" }},
]
[[db]]
number = 31
words = 8
writer = "axisgate"
line = "rack"
entries = [
  {{ at = "DW 0", type = "KF", from = "Z 0" }},
  {{ at = "D 1.0", type = "bit", from = "I8.0" }},
  {{ at = "DD 2", type = "DH", from = "MD 40" }},
]
[[modbus]]
name = "net"
bind = "127.0.0.1:1502"
max_silence_ms = 8000
[[bus]]
name = "drives"
port = "sim"
protocol = "servodyn"
cycle_ms = 8
axes = "1..2"
[plant]
seed = 1
[plant.axis.A1]
start = 0.0
"""


def signal_cell(folder: pathlib.Path, source: str, controller: str, *, rho3: str = "", p9: int = 800, spare: tuple[int, ...] = ()) -> str:
    """Two axes that need no referencing; `door` gives the RC inputs FIRST..LAST, `spare` are given to the other command source."""
    other = "net" if source == "rack" else "rack"
    owners = ", ".join(f'"{byte}" = "{other if byte in spare else source}"' for byte in sorted({*range(FIRST, LAST + 1), *spare}))
    text = CELL.format(owners=owners, controller=controller, rho3=rho3, p9=p9)
    path = folder / "old.toml"
    path.write_text(text + "".join(AXIS.format(name=f"A{module}", module=module) for module in (1, 2)))
    return str(path)


class Way(Protocol):
    """How the PLC reaches the control."""

    def write(self, first: int, data: bytes) -> None:
        """RC input bytes from `first` on, first even."""

    def read(self, first: int, count: int) -> bytes:
        """RC output bytes, both even."""


class Rack:
    """Active RK512 station on the line, high priority."""

    def __init__(self, line: SyncLine[Event], station: ActiveStation) -> None:
        self._line, self._station = line, station

    @staticmethod
    def port_of(run: str) -> str:
        """Our end of the cable."""
        return f"pty:{LineControl.path(f'{run}-rack', 'a')}"

    @staticmethod
    def station() -> ActiveStation:
        return ActiveStation(38400, PROFILE, Priority.HIGH)

    def job(self, number: int) -> Event:
        found: list[Event] = []

        def over() -> bool:
            found.extend(event for _, event in self._line.events if not isinstance(event, Unasked) and event.job == number)
            self._line.events.clear()
            return bool(found)

        assert self._line.run_until(over, PATIENCE_S), "no outcome of an RK512 job"
        return found[0]

    def send(self, word: int, data: bytes, block: int = 20) -> Event:
        return self.job(self._station.send(block, word, data, time.monotonic_ns()))

    def fetch(self, word: int, words: int, block: int = 21) -> bytes:
        done = self.job(self._station.fetch(block, word, words, time.monotonic_ns()))
        assert isinstance(done, Done), done
        return done.data

    def area(self, kind: str, address: int, amount: int) -> bytes:
        """FETCH of E, A, M (an even number of bytes) or T, Z (words), the header written by hand."""
        size = amount * (2 if kind in "TZ" else 1)
        header = b"\0\0E" + kind.encode() + address.to_bytes(2, "big") + amount.to_bytes(2, "big") + b"\xff\xff"
        done = self.job(self._station.command(header, size, time.monotonic_ns()))
        assert isinstance(done, Done), done
        return done.data

    def write(self, first: int, data: bytes) -> None:
        """A job that fails is given again, as a PLC's program would: services may just be starting."""
        until = time.monotonic() + PATIENCE_S
        while not isinstance(answer := self.send(first // 2, data), Done):
            assert time.monotonic() < until, answer

    def read(self, first: int, count: int) -> bytes:
        until = time.monotonic() + PATIENCE_S
        while not isinstance(answer := self.job(self._station.fetch(21, first // 2, count // 2, time.monotonic_ns())), Done):
            assert time.monotonic() < until, answer
        return answer.data


class Net:
    """mbpoll, one call after the other."""

    def __init__(self, port: int) -> None:
        self._port = port

    def _poll(self, *options: str, values: tuple[int, ...] = ()) -> str:
        until = time.monotonic() + PATIENCE_S
        while True:
            code, text = mbpoll(self._port, "-0", *options, values=values)
            if code == 0:
                return text
            assert time.monotonic() < until, text

    def write(self, first: int, data: bytes) -> None:
        words = tuple(int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2))
        self._poll("-t", "4", "-r", str(first // 2), values=words)

    def read(self, first: int, count: int) -> bytes:
        found = values_of(self._poll("-t", "3", "-r", str(first // 2), "-c", str(count // 2)))
        return b"".join(found[first // 2 + n].to_bytes(2, "big") for n in range(count // 2))


class SignalPlc:
    """Its program: an image of outputs that is written whole whenever a bit changes, and eyes on the inputs."""

    def __init__(self, way: Way, spare: tuple[int, ...] = ()) -> None:
        self.way = way
        self.image = bytearray(LAST - FIRST + 1)
        self.seen = b""

    def put(self, *bits: int, off: tuple[int, ...] = (), number: tuple[int, int] | None = None) -> None:
        """RC inputs to 1, others to 0; `number`: (first bit, 8-bit value); one telegram."""
        for bit in bits:
            self.image[bit // 8 - FIRST] |= 1 << bit % 8
        for bit in off:
            self.image[bit // 8 - FIRST] &= ~(1 << bit % 8)
        if number is not None:
            self.image[number[0] // 8 - FIRST] = number[1]
        self.write()

    def write(self) -> None:
        """Write the present image once more."""
        self.way.write(FIRST, bytes(self.image))

    def look(self) -> "SignalPlc":
        """Bytes 8..31 of the RC outputs."""
        self.seen = self.way.read(8, 24)
        return self

    def output(self, bit: int) -> bool:
        return bool(self.seen[bit // 8 - 8] >> bit % 8 & 1)

    def code(self) -> int:
        """Coded error on the channel, 0 while its strobe is 0; its parity is right."""
        if not self.output(118):
            return 0
        code = int.from_bytes(self.seen[11:13], "little")
        assert self.output(119) is bool(code.bit_count() & 1), f"parity of {code}"
        return code

    def until(self, holds: Callable[["SignalPlc"], bool], what: str, seconds: float = PATIENCE_S) -> None:
        until = time.monotonic() + seconds
        while not holds(self.look()):
            assert time.monotonic() < until, f"the PLC waited {seconds:g} s in vain for {what}; RC outputs 8..31: {self.seen.hex(' ')}"
            self.write()

    def codes_of_a_round(self, seconds: float) -> list[int]:
        """Different codes seen for a while, in order."""
        found: list[int] = []
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            code = self.look().code()
            if code and code not in found:
                found.append(code)
        return found
