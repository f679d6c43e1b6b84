"""Shipped cells played as they stand, each with a PLC, host or neighbour that is none of ours or written by hand (issue 6.5).

The S5 cell (users.md 3.4) is played in rig/canopen/test_s5_plays.py and test_couplers.py, the CL300 cell in test_cl300_bits.py.
"""

import contextlib
import select
import struct
import threading
import time

import serial

from drivers.ports.base import runtime_dir
from drivers.ports.can.open import open_can
from hil_tests.lab.partners.plc2 import DONE, ENABLE, OVERRIDE, PTP, REFERENCE, REQUEST, RESET, ModbusPlc
from hil_tests.lab.running.cell_running import STOLEN
from hil_tests.lab.running.joined_running import cell_copy, running_joined
from protocols.base.machine import Frame

BOTH = 0b11
OURS, THEIRS = 472, 471


def test_a_modbus_plc_moves_servodyn_axes_and_its_display_registers_follow() -> None:
    """The PLC's client is pymodbus."""
    with running_joined(lambda folder: cell_copy("modbus-servodyn", folder), "mbsd") as run:
        plc = ModbusPlc("127.0.0.1", run.port)
        plc.start()
        try:
            plc.wait(lambda status: True, 10)
            plc.synchronise()
            assert any(moved(plc) for _ in range(6)), run.words()
            plc.wait(lambda status: abs(status.actual[1] - 21.5) < 0.05, 5)

            def shown() -> tuple[int, int]:
                with plc._lock:
                    words = plc._client.read_holding_registers(20, count=6).registers
                return struct.unpack(">i", struct.pack(">HH", words[1], words[0]))[0], words[2] >> 8 & 1

            run.until(lambda: abs(shown()[0] - 2150) <= 5 and shown()[1] == 1, "21.5 mm in 0.01 mm, low word first, valid")
        finally:
            plc.stop()


def moved(plc: ModbusPlc) -> bool:
    """From whatever stands to the target; False when the machine took the processor away and a drive or the clock gave up."""
    for code, mask in ((REQUEST, 0), (RESET, 0), (ENABLE, BOTH), (OVERRIDE, 0), (REFERENCE, BOTH), (PTP, BOTH)):
        status = plc.command(code, mask, 1.0, (40.0, 21.5) if code == PTP else ())
        if status.state != DONE:
            assert status.reason in STOLEN, (code, status)
            return False
    return True


class Neighbour:
    """The other rho 3: sends its block every 20 ms of its own, hears ours."""

    def __init__(self, bus: str) -> None:
        self.says, self.heard, self.speaking = bytes(4), bytes(4), True
        self._stop = threading.Event()
        self._port = open_can(f"broker:{bus}")
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._stop.is_set():
            if time.monotonic() >= due:
                due = time.monotonic() + 0.02
                if self.speaking:
                    self._port.send([Frame(THEIRS, self.says)])
            if select.select([self._port], (), (), 0.005)[0]:
                for frame in self._port.receive():
                    self.heard = frame.data if frame.identifier == OURS else self.heard

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        self._port.close()


def test_a_coupled_rho3_works_with_its_neighbour_and_lets_nobody_in_when_it_is_gone() -> None:
    absent = ("[plant.axis.A1]", '[plant]\nabsent = ["io"]\n[plant.axis.A1]')
    with running_joined(lambda folder: cell_copy("rho3-coupled", folder, absent), "coupled") as run, contextlib.ExitStack() as stack:
        other = Neighbour("coupled-io")
        stack.callback(other.close)
        other.says = bytes((1, 0, 100, 0))
        run.until(lambda: other.heard[2:4] == (200).to_bytes(2, "big"), "the neighbour's number comes back doubled")
        run.until(lambda: run.value("A 3.2") == 1, "it lets us in")
        run.until(lambda: struct.unpack("b", other.heard[1:2])[0] == round(run.value("axis.A1.actual")), "it sees where we are")
        other.speaking = False
        run.until(lambda: run.value("A 3.2") == 0 and other.heard[2:4] == bytes(2), "a silent neighbour lets nobody in")
        other.speaking = True
        run.until(lambda: run.value("A 3.2") == 1 and other.heard[2:4] == (200).to_bytes(2, "big"), "it is back")


def block_3964r(line: serial.Serial, data: bytes) -> None:
    """One block as rho 3 part 1, 7.1 tells it; by hand."""
    for _ in range(30):  # the first may find the line still closed
        line.write(b"\x02")
        if line.read(1) == b"\x10":
            break
    else:
        raise AssertionError("no DLE to our STX")
    body = data.replace(b"\x10", b"\x10\x10") + b"\x10\x03"
    check = 0
    for octet in body:
        check ^= octet
    line.timeout = 5
    line.write(body + bytes((check,)))
    assert line.read(1) == b"\x10", "DLE to our block"


def test_the_replaced_rho3_takes_orders_of_its_host_and_shows_itself_to_its_new_plc() -> None:
    here = ('allow  = ["10.0.0.5"]', 'allow  = ["127.0.0.1"]')
    with running_joined(lambda folder: cell_copy("rho3-servodyn", folder, here), "rho3new") as run:
        plc = ModbusPlc("127.0.0.1", run.port)
        with serial.Serial(str(runtime_dir() / "rho3new-V24_1-a"), timeout=0.6) as host:
            order = b"\0\0OR" + struct.pack("<i", 4711) + struct.pack("<i", 12) + struct.pack("<f", 145.5) + b"AB"
            block_3964r(host, order)
            run.until(lambda: run.value("order.number") == 4711 and run.value("order.pallet") == 12, "the order is taken")
            assert run.value("order.pattern") == "AB" and run.value("order.height") == 145.5
        client = plc._client
        assert client.connect()
        with contextlib.closing(client):
            client.write_coils(24, [True] * 5)
            run.until(lambda: [run.value(f"A 3.{bit}") for bit in range(5)] == [1] * 5, "coils are the enabling inputs")

            def actual() -> tuple[float, ...]:
                words = client.read_holding_registers(1000, count=12).registers
                return struct.unpack(">6f", struct.pack(">12H", *words))

            names = [f"axis.{n}.actual" for n in range(1, 7)]
            run.until(lambda: all(abs(a - run.value(n)) < 0.01 for a, n in zip(actual(), names, strict=True)), "positions as REAL")
