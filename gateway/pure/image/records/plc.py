"""What the process of the integrated PLC and the services share (AX-900): a region of the PLC's, one of the robot's markers, two rings."""

import struct
from dataclasses import dataclass

MARKERS, AREA, CELLS, CELL = 1968, 40, 32, 10  # bytes of markers, of outputs; timers and counters and bytes of each
_PLC = struct.Struct(f"=QBBQ{MARKERS}s{AREA}s{AREA}s{CELLS * CELL}s")
PLC_SIZE = _PLC.size
PLC_LAYOUT = f"plc/1 {_PLC.format}"
_ROBOT = struct.Struct(f"=B{MARKERS}s")
ROBOT_SIZE = _ROBOT.size
ROBOT_LAYOUT = f"plc-robot/1 {_ROBOT.format}"
ORDERS = 256


@dataclass(frozen=True, slots=True)
class PlcReport:
    """The PLC behind a period.  `id`: start of the process; `written`: output bits the last scan wrote; `cells`: timers and counters with
    what is left of them, as they are retained; `drives_off`: a message has switched the drives off and is not acknowledged."""

    id: int
    running: bool = False
    drives_off: bool = False
    scans: int = 0
    markers: bytes = bytes(MARKERS)
    outputs: bytes = bytes(AREA)
    written: bytes = bytes(AREA)
    cells: bytes = bytes(CELLS * CELL)


def pack_plc(report: PlcReport) -> bytes:
    """As PLC_SIZE bytes."""
    return _PLC.pack(
        report.id, report.running, report.drives_off, report.scans, report.markers, report.outputs, report.written, report.cells
    )


def unpack_plc(data: bytes) -> PlcReport:
    """The reverse of pack_plc."""
    run, running, drives_off, scans, markers, outputs, written, cells = _PLC.unpack(data)
    return PlcReport(run, bool(running), bool(drives_off), scans, markers, outputs, written, cells)


@dataclass(frozen=True, slots=True)
class RobotSide:
    """Markers as the robot has them, before a scan; `drives`: they are on."""

    markers: bytes = bytes(MARKERS)
    drives: bool = False


def pack_robot(side: RobotSide) -> bytes:
    """As ROBOT_SIZE bytes."""
    return _ROBOT.pack(side.drives, side.markers)


def unpack_robot(data: bytes) -> RobotSide:
    """The reverse of pack_robot."""
    drives, markers = _ROBOT.unpack(data)
    return RobotSide(markers, bool(drives))
