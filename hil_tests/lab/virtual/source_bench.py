"""What a part of the services is given, made in this process from a cell alone: no supervisor, no cycle, no port.

The regions are memory of this process; `publish` is what the cycle would have published.
"""

import os
import pathlib
from collections.abc import Callable

from gateway.assembly.axes import axis_facts, make_planner
from gateway.assembly.run import CommandSource, RunPlan, make_regions
from gateway.assembly.telegrams import named_values
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import OnLoss
from gateway.pure.arbitration.link_watch import LinkWatch
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import ALL_PERMITS, AxisFlag, AxisState, CellState
from gateway.runtime.journal import Journal
from gateway.runtime.regions import RegionReader, RegionWriter
from gateway.services.cell_values import CellValues
from gateway.services.context import RunContext
from gateway.services.plant_addresses import PlantAddresses
from gateway.services.recording_tap import ServicesTap
from gateway.services.shared_image import RcOutputs, SharedImage
from gateway.services.sources.base import SourceContext
from gateway.services.value_directory import ValueDirectory
from protocols.base.machine import Ns, ms

NOWHERE = pathlib.Path("/nonexistent")
READY = AxisFlag.ENABLED | AxisFlag.REFERENCED | AxisFlag.IN_POSITION


class SourceBench:
    """`now`: the clock of the parts; `passed_on`: how often a part let go on at once what it had written."""

    def __init__(
        self, cell: Cell, *, simulated: bool = True, folder: pathlib.Path = NOWHERE, clock: Callable[[], Ns] | None = None
    ) -> None:
        kinds = [(line.name, "line") for line in cell.line] + [(x.name, "modbus") for x in cell.modbus if x.role == "server"]
        sources = tuple(CommandSource(number, name, kind) for number, (name, kind) in enumerate(kinds, 1))
        self.numbers = {source.name: source.number for source in sources}
        self.plan = RunPlan(
            "bench", cell, simulated, folder, 4, {}, {line.name: line.port for line in cell.line},
            {modbus.name: ("127.0.0.1", 0) for modbus in cell.modbus}, sources,
        )  # fmt: skip
        self.now: Ns = ms(1)
        self.fds = make_regions(self.plan)
        self.run = RunContext(cell, self.plan, Journal(None, "services"), ServicesTap(self.fds), clock or (lambda: self.now))
        self.outputs = RegionWriter(self.fds["rc_out"], "rc_out")
        owners = {octet: self.numbers[name] for octet, name in cell.rc_inputs.owner.items()}
        self.image = SharedImage(RcOutputs(RegionReader(self.fds["rc_out"], "rc_out")), owners)
        self.values = ValueDirectory(named_values(cell))
        self.cell_values = CellValues(cell, self.image, self.values)
        self.values.register(self.cell_values)
        self.values.register(PlantAddresses(cell, self.image, self.values))
        self.dispatcher = CommandDispatcher(axis_facts(cell), make_planner(cell), 1)
        self.passed_on = 0
        self.image.goes_on = self._count

    def _count(self) -> None:
        self.passed_on += 1

    def context(self, name: str, *, silence_ms: int = 500) -> SourceContext:
        """Everything the command source of that name is given."""
        source = next(each for each in self.plan.sources if each.name == name)
        region = RegionWriter(self.fds[f"source-{source.number}"], f"source-{source.number}")
        watch = LinkWatch(ms(silence_ms), has_life_word=False)
        return SourceContext(self.run, self.image, self.values, self.dispatcher, source, watch, OnLoss.STOP, region)

    def publish(self, flags: AxisFlag = READY, **fields: int) -> CellState:
        """The cycle is ready and every axis has these flags."""
        axes = [AxisState(flags=flags) for _ in self.run.cell.axis]
        state = CellState(generation=1, ready=True, permits=int(ALL_PERMITS), axes=axes)
        for name, value in fields.items():
            setattr(state, name, value)
        self.image.state = state
        self.dispatcher.observe(state, 0)
        return state

    def close(self) -> None:
        for fd in self.fds.values():
            os.close(fd)
