"""What the process of the integrated PLC and the services share (AX-900): a region of the PLC's, one of the robot's markers, two rings."""

from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.layout import U64, Code, Layout, Yes

MARKERS, AREA, CELLS, CELL = 1968, 40, 32, 10  # bytes of markers, of outputs; timers and counters and bytes of each
ORDERS = 256
Markers = Annotated[bytes, Code(f"{MARKERS}s")]
Outputs = Annotated[bytes, Code(f"{AREA}s")]


@dataclass(frozen=True, slots=True)
class PlcReport:
    """The PLC behind a period.  `id`: start of the process; `written`: output bits the last scan wrote; `cells`: timers and counters with
    what is left of them, as they are retained."""

    id: U64
    running: Yes = False
    scans: U64 = 0
    markers: Markers = bytes(MARKERS)
    outputs: Outputs = bytes(AREA)
    written: Outputs = bytes(AREA)
    cells: Annotated[bytes, Code(f"{CELLS * CELL}s")] = bytes(CELLS * CELL)


@dataclass(frozen=True, slots=True)
class RobotSide:
    """Markers as the robot has them, before a scan; `drives`: they are on."""

    drives: Yes = False
    markers: Markers = bytes(MARKERS)


_PLC, _ROBOT = Layout(PlcReport, "plc/1"), Layout(RobotSide, "plc-robot/1")
PLC_SIZE, PLC_LAYOUT = _PLC.size, _PLC.text
ROBOT_SIZE, ROBOT_LAYOUT = _ROBOT.size, _ROBOT.text
pack_plc, unpack_plc = _PLC.pack, _PLC.unpack
pack_robot, unpack_robot = _ROBOT.pack, _ROBOT.unpack
