"""The integrated PLC's process as the services see it: its outputs are 0 from the moment it is killed."""

import os
import signal
import time
from typing import cast

from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.image.records import interpreter, plc
from gateway.pure.image.records.plc import AREA, PlcReport, pack_plc
from gateway.runtime.regions import RegionWriter, create_region, create_ring
from gateway.services.plc_host import PlcHost

LONG_WATCHDOG = 6_000  # 1/100 s: its silence alone would be noticed after a minute
ON = bytes([1]) + bytes(AREA - 1)


class Joined:
    """What the host needs of the control."""

    plc: object = None


def regions() -> dict[str, int]:
    rings = ("plc-orders", "plc-says")
    found = {name: create_ring(name, interpreter.TEXT_SIZE, 64, interpreter.TEXT_LAYOUT) for name in rings}
    found["plc"] = create_region("plc", plc.PLC_SIZE, plc.PLC_LAYOUT)
    found["plc-robot"] = create_region("plc-robot", plc.ROBOT_SIZE, plc.ROBOT_LAYOUT)
    found["plc-shown"] = create_region("plc-shown", plc.SHOWN_SIZE, plc.SHOWN_LAYOUT)
    return found


def publish(writer: RegionWriter, report: PlcReport) -> None:
    now = time.monotonic_ns()
    writer.beat(now)
    writer.write(pack_plc(report), now)


def running_child(fds: dict[str, int], done: int) -> None:
    publish(RegionWriter(fds["plc"], "plc", plc.PLC_LAYOUT), PlcReport(1, True, outputs=ON, written=ON))
    os.write(done, b"1")
    signal.pause()


def test_outputs_are_0_at_once_when_the_process_is_killed_until_its_successor_reports() -> None:
    fds, (read, write) = regions(), os.pipe()
    host = PlcHost(cast(ReisControl, Joined()), fds, LONG_WATCHDOG)
    child = os.fork()
    if child == 0:
        running_child(fds, write)
    try:
        assert os.read(read, 1) == b"1"
        host.before()
        assert host.plc.outputs() == {(0, 0): True}
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)  # a zombie: nobody has fetched it yet
    host.before()
    assert not host.plc.on and host.plc.outputs() == {}
    os.waitpid(child, 0)
    host.before()
    assert not host.plc.on
    successor = RegionWriter(fds["plc"], "plc", plc.PLC_LAYOUT)
    successor.beat(time.monotonic_ns())
    host.before()
    assert not host.plc.on, "what the dead one left does not count"
    publish(successor, PlcReport(2, True, outputs=ON, written=ON))
    host.before()
    assert host.plc.outputs() == {(0, 0): True}
