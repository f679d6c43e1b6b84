"""The portal with belts in virtual time, its cycles recorded: encoders as frames of the bus, pieces of the planner, and the file."""

import json
import pickle
import zlib
from collections.abc import Sequence
from typing import Any

from gateway.cycle.recording_tap import CycleTap
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.planner import PieceRecord, pack_piece, piece_size
from gateway.pure.planning.planner import Programs
from gateway.pure.recording.messages import Message, What, pack
from gateway.recording.file import Found, Segment
from gateway.recording.replay import Bench
from gateway.recording.states import frozen
from hil_tests.lab.virtual.belt_bench import AXES, CELL, BeltBench
from hil_tests.lab.virtual.planner_beside import PlannerBeside
from hil_tests.lab.virtual.recorded_bench import RecordedBench
from protocols.base.machine import Frame
from protocols.servodyn.plan import SYNC_ID

HEAD: dict[str, Any] = {"p5_ms": 4, "simulated": True, "buses": ["drives"], "stamp_ns": 0, "zeros": {}}


class TappedPlanner(PlannerBeside):
    """The tap sees its pieces, as the cycle shows them."""

    def __init__(self, programs: Programs, axes: int, tap: CycleTap) -> None:
        super().__init__(programs, axes)
        self._tap = tap

    def feed(self, core: CycleLogic, record: PieceRecord) -> None:
        if self._tap.on:
            self._tap.put(What.PIECE, pack_piece(record, piece_size(self.axes)))
        super().feed(core, record)


class RecordedBelts(BeltBench, RecordedBench):
    """`found`: what a file of it holds."""

    def _new_core(self) -> CycleLogic:
        core, _, (self.encoders,) = Bench(CELL, HEAD, {}).core()
        assert core.belts is not None
        self.belts = core.belts
        core.state.generation = self.generation
        return core

    def cycle(self, count: int = 1) -> None:
        """The encoders answer the SYNC as the drives do; the tap sees their telegrams."""
        for _ in range(count):
            self.bus.encoders = self.encoders
            self.emulated.receive([Frame(SYNC_ID, stamp_ns=self.now)])
            self.others = [frame._replace(stamp_ns=self.now + 2) for frame in self.emulated.take_output()]
            for frame in self.others:
                self.encoders[frame.identifier].hear(frame.data)
            self._one()

    def _beside(self) -> PlannerBeside:
        return TappedPlanner(self.programs, AXES, self.tap)

    def found(self) -> Found:
        """As the recorder keeps it and a reader finds it."""
        return found_in(self.messages, HEAD)


def found_in(messages: Sequence[Message], head: dict[str, Any]) -> Found:
    """What a file with these messages of its cycles holds, the start among them."""
    state = pickle.loads(next(payload for what, payload in messages if what is What.START))
    tree = {"core": frozen(state.core), "families": frozen(state.families), "late": state.late, "sent": state.sent_ns}
    start = json.loads(json.dumps({"cycle": state.core.state.cycle, **tree, "encoders": state.encoders}))
    played = b"".join(pack(*message) for message in messages if message.what is not What.START)
    return Found(head, segments=[Segment(start, [zlib.compress(played)])])
