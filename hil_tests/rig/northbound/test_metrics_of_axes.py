"""/metrics has every axis of a cell, also of 32; the region of the axes is real."""

import pathlib
import time

from gateway.assembly.run import RunPlan, make_regions
from gateway.cell_file.load import load_cell
from gateway.northbound.metrics import Metrics
from gateway.observer.regions import Regions
from gateway.pure.image.records.cell import AxisFlag, AxisState, CellState, LaneState, cell_state_packer
from gateway.runtime.regions import RegionWriter
from hil_tests.lab.cells.many_robots import ROBOTS, cell_file
from hil_tests.rig.northbound.test_northbound import parsed

AXES = 2 * ROBOTS


def test_every_axis_of_a_cell_of_32_has_its_numbers_in_its_unit(tmp_path: pathlib.Path) -> None:
    cell = load_cell(str(cell_file(tmp_path)))
    plan = RunPlan("many", cell, True, tmp_path, 4, {}, {}, {}, ())
    fds = make_regions(plan)
    on = AxisFlag.ENABLED | AxisFlag.REFERENCED
    axes = [AxisState(0.1 * n, 0.1 * n + 1e-3, 0.02, 1e-3, 0.5, on, fault_code=0x2310 if n == 31 else 0) for n in range(AXES)]
    axes[31].flags = AxisFlag.FAULT
    writer = RegionWriter(fds["axes"])
    state = CellState(axes=axes, lanes=[LaneState() for _ in range(ROBOTS)])
    writer.write(cell_state_packer(AXES, ROBOTS)(state), time.monotonic_ns())
    writer.beat(time.monotonic_ns())
    regions = Regions(plan, fds)
    regions.look()
    told = parsed(Metrics(regions).page())
    names = [axis.name for axis in cell.axis]
    place = {sample[1]: value for sample, value in told.items() if sample[0] == "axisgate_axis_actual"}
    assert place == {f'axis="{name}",unit="mm"': round(100.0 * n, 4) for n, name in enumerate(names)} and len(place) == 32
    last, first = f'axis="{names[31]}"', f'axis="{names[0]}"'
    assert told["axisgate_axis_set", f'{last},unit="mm"'] == 3101.0 and told["axisgate_axis_lag", f'{last},unit="mm"'] == 1.0
    assert told["axisgate_axis_speed", f'{last},unit="mm/s"'] == 20.0 and told["axisgate_axis_torque_percent", last] == 50.0
    assert told["axisgate_axis_fault_code", last] == 0x2310 and told["axisgate_axis_fault_code", first] == 0
    flags = {
        name: (told[f"axisgate_axis_{name}", first], told[f"axisgate_axis_{name}", last]) for name in ("enabled", "fault", "referenced")
    }
    assert flags == {"enabled": (1, 0), "fault": (0, 1), "referenced": (1, 0)}
