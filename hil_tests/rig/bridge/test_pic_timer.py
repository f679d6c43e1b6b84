"""The PIC's timer in a whole run (rho 3 L707, AX-478), and a high-speed input that a route wires (AX-477)."""

import json
import os
import signal
import time

from gateway.pure.image.records.cell import RC_BYTES, Quality, unpack_inputs
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from hil_tests.lab.running.cell_running import P5_MS
from hil_tests.lab.running.joined_running import JoinedRun, cell_copy, running_joined
from hil_tests.lab.running.modbus_running import RawClient

NAME = "pic"
MORE = """
[rho3]
P11 = [1, 2]
[controller]
kind = "rho3"
boards = ["modular-i"]
pic_timeout_ms = 200
[rc_inputs]
owner = { "10" = "door", "11" = "door" }
assume = ["EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI"]
[[modbus]]
name = "door"
max_silence_ms = 60000
[[route]]
name = "wire"
from = "A 10.3"
to   = "rho3.fast.612"
[[route]]
name = "shown"
from = "rho3.fast.612"
to   = "A 12.0"
"""
WRITTEN = 5  # holding register: RC input bytes 10 and 11


def test_a_route_wires_a_high_speed_input_and_a_timer_error_of_the_pic_takes_everything_to_0() -> None:
    with (
        running_joined(lambda folder: cell_copy("host-telegrams", folder, more=MORE), NAME, p5_ms=P5_MS) as run,
        RawClient(run.port) as plc,
    ):
        run.until(lambda: plc.ask(f"06 {WRITTEN:04x} 085a").startswith("06"), "the command source takes a write")
        run.until(lambda: run.value("rho3.fast.612") == 1 and cycles_inputs()[10:13] == b"\x08\x5a\x01", "wired, and read by another route")
        plc.ask(f"06 {WRITTEN:04x} 005a")
        run.until(lambda: run.value("rho3.fast.612") == 0 and cycles_inputs()[10:13] == b"\x00\x5a\x00", "and off again")
        run.until(lambda: run.value("E 8.0") == 1 and run.value("cell.ready") == 1, "READY")
        run.until(lambda: late(run) == 0, "READY is open", 60.0)  # the first second after a start is not judged
        run.until(lambda: cycles_inputs() == bytes(RC_BYTES), "no RC input is left for the cycle")
        assert plc.ask("04 0000 0040") == "04 80" + " 00" * RC_BYTES, "nor any RC output"
        plc.ask(f"06 {WRITTEN:04x} ffff")
        run.until(lambda: run.value("A 10.0") == 1, "the command source takes what the PLC writes")
        assert cycles_inputs() == bytes(RC_BYTES) and run.value("E 8.0") == 0
        said = [line for line in (run.folder / "run" / NAME / "journal.jsonl").read_text().splitlines() if "PIC timer error" in line]
        assert [json.loads(line)["kind"] for line in said] == ["plc"]


def cycles_inputs() -> bytes:
    """RC inputs as the cycle reads them; none before those of the command source are good."""
    fds: dict[str, int] = {}
    try:
        with ask(NAME, "regions") as connection:
            fds = recv_fds(connection)
        payload = RegionReader(fds["rc_in"], "rc_in").read()
        assert payload is not None
        image = unpack_inputs(payload)
        return bytes(image.values) if all(image.quality[byte] == Quality.GOOD for byte in range(10, 13)) else b""
    finally:
        for fd in fds.values():
            os.close(fd)


def late(run: JoinedRun) -> object:
    """The services are stopped for longer than the PIC may be late; who would replace them is stopped as long.  READY after it."""
    with ask(NAME, "status") as connection:
        status = json.loads(connection.makefile().readline())
    services = next(int(each["pid"]) for each in status["processes"] if each["name"] == "services")
    os.kill(run.process.pid, signal.SIGSTOP)
    try:
        os.kill(services, signal.SIGSTOP)
        time.sleep(0.4)
        os.kill(services, signal.SIGCONT)
        assert run.value("EB 8") is not None, "they tick again"
    finally:
        os.kill(run.process.pid, signal.SIGCONT)
    time.sleep(0.2)
    return run.value("cell.ready")
