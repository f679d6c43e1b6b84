"""`route.one_way` and `route.both_ways` over a drive: a Modbus client releases feed hold, a route carries that to the cycle, the drive gets
another set value and moves, and a second route shows its actual position at the command source.

Every round: a move is held at its beginning; write, first telegram to the drive with another set value and first telegram of the drive
with another position (both stamped by the broker, a third process), first read-back of another position by the client.  The axis has the
limits of its cell, so the first set values are less than an increment away and the position loop follows (AX-551).  Both clocks are
CLOCK_MONOTONIC; the time on loopback counts against us.
"""

import random
import struct
import time

from hil_tests.bench.bus_listener import BusListener
from hil_tests.lab.running.joined_running import JoinedRun, cell_copy, running_joined
from hil_tests.lab.running.modbus_running import RawClient
from protocols.base.machine import Frame
from protocols.servodyn.plan import actual_id, set_id

NAME = "routedrive"
MOVED_INC, MOVED_UM = 2, 3  # more than a drive at rest moves; about the same way: 819 increments are a millimetre
WRITTEN, READ_BACK = 5, 6  # holding registers: RC input byte 10, bit 0 of a high byte; bytes 12..15
RUN, WAY_MM = 0x0100, 2.0
ENABLE, RELATIVE, RESET, OVERRIDE, REQUEST = 1, 5, 9, 10, 11
RUNNING, DONE, REFUSED, ABORTED = 2, 3, 4, 5
QUICK = (('home      = { by = "gateway", mode = 0, speed = 100.0, slow_speed = 20.0, direction = "-" }', 'home      = { by = "none" }'),)
SOURCE = """
[rc_inputs]
owner = { "10" = "door", "11" = "door" }
assume = ["EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "TRAVEL_ALLOW_RCI"]
[[modbus]]
name = "door"
command_block = true
max_silence_ms = 60000
[[route]]
name = "run"
from = "A 10.0"
to   = "FEED_HOLD_N_RCI"
[[route]]
name = "place"
from = "axis.A1.actual"
to   = "AD 12"
to_type = "s32"
scale = 1000.0
"""


def measure(rounds: int, p5_ms: int, seed: int = 1) -> tuple[list[float], list[float], list[float]]:
    """(command source to set value, to actual value, back to the command source) in cycles."""
    with (
        running_joined(lambda folder: cell_copy("host-telegrams", folder, *QUICK, more=SOURCE), NAME, p5_ms=p5_ms) as run,
        RawClient(run.port) as source,
    ):
        ear = _Ear()
        try:
            return _rounds(run, source, ear, rounds, p5_ms, random.Random(seed))
        finally:
            ear.close()


class _Ear(BusListener):
    """When a telegram to the drive, and one from it, first contained another position."""

    def __init__(self) -> None:
        self.moved_ns, self.place, self._rest = 0, 0, 0
        self.ordered_ns, self._wanted, self._wanted_at_rest = 0, 0, 0
        super().__init__(f"{NAME}-drives")

    def begin(self) -> None:
        """From here on a move is looked for."""
        self._rest, self._wanted_at_rest = self.place, self._wanted
        self.moved_ns = self.ordered_ns = 0

    def _take(self, frame: Frame) -> None:
        if frame.identifier == set_id(1):
            self._wanted = struct.unpack_from("<i", frame.data, 2)[0]
            if not self.ordered_ns and self._wanted != self._wanted_at_rest:
                self.ordered_ns = frame.stamp_ns
        elif frame.identifier == actual_id(1):
            self.place = struct.unpack_from("<i", frame.data, 2)[0]
            if not self.moved_ns and abs(self.place - self._rest) > MOVED_INC:
                self.moved_ns = frame.stamp_ns

    def wait(self) -> None:
        """The telegrams are on the bus before the client reads it back; this thread may be later."""
        end = time.monotonic() + 5.0
        while not (self.moved_ns and self.ordered_ns):
            assert time.monotonic() < end, "set value and actual value were never seen on the bus"
            time.sleep(0.001)


class Spoiled(Exception):
    """A round in which the machine was so late that the drive gave up: it is repeated."""


class _Commands:
    """The command block of the command source."""

    def __init__(self, run: JoinedRun, source: RawClient) -> None:
        self._run, self._source, self._toggle = run, source, False
        self.give(0)  # the first one is only adopted

    def give(self, code: int, way_mm: float = 0.0) -> None:
        """For axis 1 with full rates; a move is only begun, everything else is waited for."""
        self._toggle = not self._toggle
        word, (high, low) = (0x8000 if self._toggle else 0) | code, struct.unpack(">HH", struct.pack(">f", way_mm))
        answer = self._source.ask(f"10 03e8 0006 0c {word:04x} 0001 2710 2710 {high:04x} {low:04x}")
        assert answer == "10 03 E8 00 06", answer
        if code:
            self.wait(RUNNING if code == RELATIVE else DONE)

    def wait(self, state: int) -> None:
        """Until the command given last has come so far; Spoiled: it was refused or aborted."""
        found: list[int] = []

        def ended() -> bool:
            toggle, said = self._status()
            found[:] = [said]
            return toggle == self._toggle and said in (state, DONE, REFUSED, ABORTED)

        self._run.until(ended, f"state {state} of the command block")
        if found != [state]:
            raise Spoiled(f"state {found[0]} instead of {state}: {self._source.ask('04 03e8 0006')}")

    def ready(self) -> None:
        """Drive on, whatever has become of it."""
        self._run.until(self._switched_on, "the drive is on")

    def _switched_on(self) -> bool:
        try:
            for code in (REQUEST, RESET, OVERRIDE, ENABLE):
                self.give(code)
        except Spoiled:
            return False
        return True

    def _status(self) -> tuple[bool, int]:
        high, low = (int(octet, 16) for octet in self._source.ask("04 03e8 0001").split()[2:4])
        return bool(high & 0x80), low


def _rounds(
    run: JoinedRun, source: RawClient, ear: _Ear, rounds: int, p5_ms: int, chance: random.Random
) -> tuple[list[float], list[float], list[float]]:
    orders: list[float] = []
    acts: list[float] = []
    back: list[float] = []
    run.until(lambda: source.ask(f"06 {WRITTEN:04x} 0000").startswith("06"), "the command source takes a write")
    commands, spoiled = _Commands(run, source), 0
    commands.ready()
    while len(back) < rounds:
        run.until(lambda: run.value("A 3.3") == 0, "feed hold stands")
        try:
            commands.give(RELATIVE, WAY_MM if len(back) % 2 == 0 else -WAY_MM)
            time.sleep(chance.uniform(20.0, 21.0) * p5_ms / 1000)  # at rest, at any moment of the cycle
            began, ordered, moved, seen = _round(source, ear)
            commands.wait(DONE)
            orders.append((ordered - began) / (p5_ms * 1e6))
            acts.append((moved - began) / (p5_ms * 1e6))
            back.append((seen - began) / (p5_ms * 1e6))
        except Spoiled as why:
            spoiled += 1
            if spoiled > rounds:
                raise AssertionError(f"{why}\n{run.words()}") from why
            commands.ready()
        source.ask(f"06 {WRITTEN:04x} 0000")
    return orders, acts, back


def _round(source: RawClient, ear: _Ear) -> tuple[int, int, int, int]:
    """Stamps of the write, of the telegram to the drive, of the drive's telegram, of the read-back; Spoiled."""
    rest = _place(source)
    ear.begin()
    began = time.monotonic_ns()
    source.ask(f"06 {WRITTEN:04x} {RUN:04x}")
    while abs(_place(source) - rest) <= MOVED_UM:
        if time.monotonic_ns() - began > 1_000_000_000:
            raise Spoiled("the drive stays where it is")
    seen = time.monotonic_ns()
    ear.wait()
    return began, ear.ordered_ns, ear.moved_ns, seen


def _place(source: RawClient) -> int:
    """As the command source shows it, um."""
    octets = bytes.fromhex(source.ask(f"03 {READ_BACK:04x} 0002"))
    return int(struct.unpack(">i", octets[2:6])[0])
