"""The planner process for the services: its blocks ring to write, its region to read."""

import time
from collections.abc import Mapping, Sequence

from gateway.pure.image.records.planner import (
    SAY_LAYOUT,
    BlockRecord,
    PlannerState,
    ProgramOrder,
    Say,
    pack_block,
    run_record,
    unpack_planner,
)
from gateway.runtime.record_reader import RecordReader
from gateway.runtime.regions import RegionReader, RingWriter
from protocols.base.machine import ms

SILENT_NS = ms(2_000)  # an idle planner beats every 5 ms; it is checked only while the axes rest


class PlannerLink:
    """Without a planner in the run (`fds` has no ring of its) there is nothing to order."""

    def __init__(self, fds: Mapping[str, int]) -> None:
        there = "blocks" in fds
        self._blocks = RingWriter(fds["blocks"], "blocks", SAY_LAYOUT) if there else None
        self._reports = RecordReader(RegionReader(fds["planner"], "planner"), unpack_planner, PlannerState()) if there else None

    def state(self) -> PlannerState | None:
        """Its report; None: it is not there, or shows no life."""
        if self._reports is None or time.monotonic_ns() - self._reports.region.life[1] > SILENT_NS:
            return None
        return self._reports.read()

    def order(self, orders: Sequence[ProgramOrder]) -> None:
        """Hand them over."""
        for order in orders:
            assert self._blocks is not None  # the dispatcher refuses programs without a planner
            self._blocks.put(pack_block(run_record(order)))

    def say(self, records: Sequence[BlockRecord]) -> None:
        """Statements of streams."""
        for record in records:
            assert self._blocks is not None
            self._blocks.put(pack_block(record))

    def end(self, jobs: Sequence[int]) -> None:
        """No blocks follow for these: their interpreter is gone."""
        for job in jobs:
            assert self._blocks is not None
            self._blocks.put(pack_block(BlockRecord(Say.END, job)))
