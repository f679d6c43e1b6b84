"""Facts about the run for a part of the services: the cell, the plan, the journal, the recorder, the clock.  Nothing in it changes."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from gateway.assembly.run import RunPlan
from gateway.pure.cell.cell import Cell
from gateway.runtime.journal import Journal
from gateway.services.recording_tap import ServicesTap
from protocols.base.machine import Ns


@dataclass(frozen=True, slots=True)
class RunContext:
    """Context of one run; created by the process, passed to every part."""

    cell: Cell
    plan: RunPlan
    journal: Journal
    recorder: ServicesTap
    clock: Callable[[], Ns] = time.monotonic_ns
