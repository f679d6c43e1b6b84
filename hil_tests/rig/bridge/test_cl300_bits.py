"""The shipped CL300 cell: the PLC behind the I/O blocks is written by hand, its bits reach the control and the control's reach it."""

import contextlib
import json
import os
import signal
import time
from collections.abc import Iterator

from gateway.pure.image.records.cell import Permit, unpack_cell_state
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from hil_tests.lab.running.joined_running import JoinedRun, Modules, cell_copy, running_joined

IN, OUT = 541, 471  # what the CL300 puts out, what it reads
ALLOWED, TRAVEL = 0b11111, 0b10000
BOTH = Permit.CHAIN | Permit.TRAVEL
MEASURING = """
[[measuring]]
channel = 611
input   = 28
"""


@contextlib.contextmanager
def services_stand(run: JoinedRun) -> Iterator[None]:
    """Meanwhile they do nothing; who would replace them is stopped as well."""
    with ask(run.name, "status") as connection:
        status = json.loads(connection.makefile().readline())
    services = next(int(each["pid"]) for each in status["processes"] if each["name"] == "services")
    os.kill(run.process.pid, signal.SIGSTOP)
    try:
        os.kill(services, signal.SIGSTOP)
        try:
            yield
        finally:
            os.kill(services, signal.SIGCONT)
        assert run.value("EB 8") is not None, "they tick again"
    finally:
        os.kill(run.process.pid, signal.SIGCONT)


def permits(axes: RegionReader) -> Permit:
    """As the cycle judges them."""
    payload = axes.read()
    return Permit(0) if payload is None else Permit(unpack_cell_state(payload).permits)


def test_a_cl300_sees_its_bits_go_over_can_blocks_and_a_lost_coupling_is_marked() -> None:
    absent = ("[plant.axis.X]", '[plant]\nabsent = ["io"]\n[plant.axis.X]')
    with (
        running_joined(lambda folder: cell_copy("cl300-bits", folder, absent, more=MEASURING), "cl300") as run,
        contextlib.ExitStack() as stack,
    ):
        plc = Modules("cl300-io", {IN: bytes(8)})
        stack.callback(plc.close)

        def seen(byte: int) -> int:
            return plc.heard.get(OUT, bytes(8))[byte]

        def word(byte: int) -> int:
            return int.from_bytes(plc.heard.get(OUT, bytes(8))[byte : byte + 2], "big", signed=True)

        run.until(lambda: seen(0) & 0x80, "the position is valid")
        run.until(lambda: abs(word(2) - 10 * run.value("axis.X.actual")) <= 1, "the position as KF in 0.1 mm")
        before = word(4)
        run.until(lambda: word(4) != before, "the life counter runs")
        plc.says[IN] = bytes((ALLOWED, 7)) + bytes(6)
        run.until(lambda: seen(1) == 7, "the number of the CL300 comes back")
        run.until(lambda: [run.value(f"A 3.{bit}") for bit in range(5)] == [1] * 5, "all enabling inputs stand")
        plc.says[IN] = bytes((ALLOWED & ~8, 8)) + bytes(6)
        run.until(lambda: run.value("A 3.3") == 0 and seen(1) == 8, "feed hold")
        plc.says[IN] = bytes((ALLOWED, 9)) + bytes(6)
        run.until(lambda: run.value("A 3.3") == 1, "feed hold is gone")

        with ask(run.name, "regions") as connection:
            fds = recv_fds(connection)
        for fd in fds.values():
            stack.callback(os.close, fd)
        axes = RegionReader(fds["axes"], "axes")

        def acts_alone() -> bool:
            """With the services stopped travel goes, and what no [[measuring]] names stays as they left it; a try takes a second."""
            run.until(lambda: permits(axes) & BOTH == BOTH, "the cycle has chain and travel")
            with services_stand(run):
                plc.says[IN] = bytes((ALLOWED & ~TRAVEL, 9)) + bytes(6)
                end = time.monotonic() + 1.0
                while (found := permits(axes) & BOTH) != Permit.CHAIN and time.monotonic() < end:
                    time.sleep(0.002)
            plc.says[IN] = bytes((ALLOWED, 9)) + bytes(6)
            return found == Permit.CHAIN

        run.until(acts_alone, "a measuring input of an I/O block acts in the cycle (AX-481)", 60.0)

        plc.speaking = False
        run.until(lambda: [run.value(f"A 3.{bit}") for bit in range(5)] == [0] * 5, "a silent CL300 allows nothing")
        plc.speaking = True
        run.until(lambda: run.value("A 3.0") == 1 and seen(1) == 9, "it is back")
        told = run.ask(op="get", address="route.echo")
        assert told["value"] == 9.0 and told["valid"] and told["life"] > 0
