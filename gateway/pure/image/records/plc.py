"""What the process of the integrated PLC and the services share (AX-900): regions of the PLC and its test display, one of the robot's
markers, two rings."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.layout import I32, U32, U64, Code, Layout, Yes

MARKERS, AREA, CELLS, CELL = 1968, 40, 32, 10  # bytes of markers, of outputs; timers and counters and bytes of each
ORDERS = 256
MOST_STEPS, NAME_BYTES = 4_000, 256  # steps beyond are not displayed
Markers = Annotated[bytes, Code(f"{MARKERS}s")]
Outputs = Annotated[bytes, Code(f"{AREA}s")]


@dataclass(frozen=True, slots=True)
class PlcReport:
    """The PLC after a period.  `id`: start of the process; `written`: output bits the last scan wrote; `cells`: timers and counters with
    their remaining values, as they are retained.
    """

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


@dataclass(frozen=True, slots=True)
class StepShown:
    """Behind one step of the test display: state of its operand, VKE, accumulators."""

    step: U32
    status: Yes
    result: Yes
    accu1: I32
    accu2: I32


_STEP = Layout(StepShown)


@dataclass(frozen=True, slots=True)
class PlcShown:
    """The test display after a scan (robotstar 5.7).  `name`: program, empty: it is off; `text`: check sum of the running source;
    `rows`: the steps that were executed."""

    name: Annotated[bytes, Code(f"{NAME_BYTES}s")] = b""
    text: U32 = 0
    scans: U64 = 0
    count: U32 = 0
    rows: Annotated[bytes, Code(f"{MOST_STEPS * _STEP.size}s")] = b""


def shown_of(name: str, text: int, scans: int, steps: Mapping[int, tuple[bool, bool, int, int]]) -> PlcShown:
    """A display; steps by their number."""
    rows = [_STEP.pack(StepShown(step, *values)) for step, values in sorted(steps.items())[:MOST_STEPS]]
    return PlcShown(name.encode()[:NAME_BYTES], text, scans, len(rows), b"".join(rows))


def steps_of(shown: PlcShown) -> list[StepShown]:
    """The steps that were executed."""
    return [_STEP.unpack(shown.rows[at : at + _STEP.size]) for at in range(0, shown.count * _STEP.size, _STEP.size)]


_PLC, _ROBOT, _SHOWN = Layout(PlcReport, "plc/1"), Layout(RobotSide, "plc-robot/1"), Layout(PlcShown, "plc-shown/1")
PLC_SIZE, PLC_LAYOUT = _PLC.size, _PLC.text
ROBOT_SIZE, ROBOT_LAYOUT = _ROBOT.size, _ROBOT.text
pack_plc, unpack_plc = _PLC.pack, _PLC.unpack
SHOWN_SIZE, SHOWN_LAYOUT = _SHOWN.size, _SHOWN.text
pack_robot, unpack_robot = _ROBOT.pack, _ROBOT.unpack
pack_shown, unpack_shown = _SHOWN.pack, _SHOWN.unpack
