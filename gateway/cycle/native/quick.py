"""The parts in C for the cycle; a missing or unsuitable part is replaced by its Python twin (AX-320)."""

from collections.abc import Callable, Sequence
from functools import partial
from types import ModuleType
from typing import cast

from drivers.drives.demand_edges import DemandEdges
from drivers.drives.family import Actual, BusFamily, Demand, Power, SetRecord
from drivers.drives.held import HeldPosition
from drivers.drives.limits import LagMonitor, LagState
from drivers.drives.scaling import Scaling
from drivers.drives.servodyn import Drive, Row
from drivers.drives.servodyn_family import ServodynFamily
from drivers.drives.tracking import Tracking
from gateway.cycle.native.built import load, wanted
from gateway.cycle.native.foresight import QuickForesight
from gateway.pure.cycle.axis import CoreAxis, HeldAxis
from gateway.pure.cycle.axis_loops import PYTHON, AxisLoops
from gateway.pure.image.records.cell import (
    AXIS,
    FLAGS,
    STATE,
    AxisState,
    CellState,
    cell_state_packer,
    cell_state_size,
    lanes_packer,
)
from gateway.runtime.realtime import Alarm
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter
from motion.timing.foresight import Foresight
from protocols.base.layout import Packer
from protocols.servodyn.codec import SYNC, ActualValue, SetValue

Seen = tuple[int, int, int, int, int, int]  # pid and last beat of the services, pid of the planner, published: pieces, orders, RC inputs
Look = Callable[[], Seen]
Collected = tuple[int, int, tuple[int, bytes | None] | None]  # still missing, late, a bus and its message that is not for C
Collect = Callable[[list[tuple[object, int, int]], list[Actual | None], int, int], Collected]
SIZES = {"b": 1, "B": 1, "h": 2, "H": 2, "i": 4, "I": 4}


class QuickTelegrams:
    """One bus of SERVODYN-GC drives with plain layouts."""

    def __init__(self, part: ModuleType, table: object) -> None:
        self._message, self.table = part.message, table

    def message(self, values: Sequence[SetRecord]) -> bytes | None:
        """The next burst as one message of the local bus; None: the family has to make it."""
        message: bytes | None = self._message(self.table, values)
        return message


class QuickAlarm(Alarm):
    """Sleeps and stays awake in C."""

    part: ModuleType

    def until(self, due_ns: int) -> int:
        now: int
        woke, now = self.part.until(due_ns, self.ahead_ns)
        self.learn(woke, due_ns)
        return now


class QuickRegion(RegionWriter):
    """Writes and beats in C."""

    part: ModuleType

    def write(self, payload: bytes | bytearray | memoryview, stamp_ns: int) -> int:
        index: int = self.part.write(self._octets, self._stride, payload, stamp_ns)
        return index

    def beat(self, stamp_ns: int) -> None:
        self.part.beat(self._octets, stamp_ns)


class QuickRing(RingWriter):
    """Puts in C."""

    part: ModuleType

    def put(self, record: bytes | bytearray | memoryview) -> int:
        index: int = self.part.put(self._octets, self._stride, record)
        return index


class NativeParts:
    """Everything the cycle may have in C.  `missing`: why a part is not, for the journal."""

    def __init__(self, *, python: bool | None = None) -> None:
        self.missing: list[str] = []
        self._off = not wanted() if python is None else python
        self.loops: AxisLoops = PYTHON
        self.foresight: type[Foresight] = Foresight
        self.region: type[RegionWriter] = RegionWriter
        self.ring: type[RingWriter] = RingWriter
        self.alarm: type[Alarm] = Alarm
        self.collect: Collect | None = None
        self._memory, self._telegrams = self._part("memory"), self._part("telegrams")
        axes, alarm, foresight = self._part("axes"), self._part("alarm"), self._part("foresight")
        if axes is not None:
            self.loops = self._bound(axes)
        if self._memory is not None:
            QuickRegion.part = QuickRing.part = self._memory
            self.region, self.ring = QuickRegion, QuickRing
        if self._telegrams is not None:
            self._telegrams.bind(SetValue, ActualValue)
            self.collect = self._telegrams.collect
        if alarm is not None:
            QuickAlarm.part = alarm
            self.alarm = QuickAlarm
        if foresight is not None:
            QuickForesight.part = foresight
            self.foresight = QuickForesight

    def _part(self, name: str) -> ModuleType | None:
        if self._off:
            return None
        try:
            return load(name)
        except ImportError as error:
            self.missing.append(str(error))
            return None

    @staticmethod
    def _bound(axes: ModuleType) -> AxisLoops:
        axes.bind(
            HeldAxis, CoreAxis, Scaling, Drive, DemandEdges, HeldPosition, Row, Tracking, LagMonitor,
            AxisState, SetValue, ActualValue, Demand, Power, LagState, FLAGS,
        )  # fmt: skip
        return cast(AxisLoops, axes)

    def packer(self, axes: int, lanes: int = 0) -> Callable[[CellState], bytes]:
        """As cell_state_packer."""
        memory = self._memory
        if memory is None:
            return cell_state_packer(axes, lanes)
        packing = memory.packing(CellState, AxisState, STATE.names, STATE.codes, AXIS.names, AXIS.codes, axes, cell_state_size(axes))
        packer: Callable[[CellState], bytes] = partial(memory.pack, packing)
        behind = lanes_packer(lanes)

        def packer_with_lanes(state: CellState) -> bytes:
            return packer(state) + behind(state)

        return packer_with_lanes if lanes else packer

    def looker(
        self, links: RegionReader, planner: RegionReader | None, pieces: RingReader | None, orders: RingReader, image: RegionReader
    ) -> Look:
        """Function that checks for changes by others since the last cycle, all in one call."""
        memory = self._memory
        if memory is not None:
            places = [reader.octets if reader is not None else None for reader in (links, planner, pieces, orders, image)]
            return partial(memory.look, *places)

        def in_python() -> Seen:
            pids = links.writer_pid, links.life[1], planner.writer_pid if planner is not None else 0
            return (*pids, pieces.published if pieces is not None else 0, orders.published, image.published)

        return in_python

    def telegrams(self, family: BusFamily) -> QuickTelegrams | None:
        """None: this bus has no plain SERVODYN-GC drives, or nothing else."""
        if self._telegrams is None or type(family) is not ServodynFamily:
            return None
        rows = []
        for index, module in family.axes:
            set_packer, actual_packer = family.codec.packers(module)
            outwards, inwards = _plain(set_packer), _plain(actual_packer)
            if outwards is None or inwards is None:
                return None
            rows.append((index, family.codec.set_id(module), *outwards, family.codec.actual_id(module), *inwards))
        table = self._telegrams.table(SYNC.identifier, rows)
        return None if table is None else QuickTelegrams(self._telegrams, table)


def _plain(packer: Packer) -> tuple[int, bytes, tuple[int, ...]] | None:
    """Length, places of the flags in byte 0, and (place, octets, signed) of each number after them; None: another kind of layout."""
    if packer.plain is None:
        return None
    numbers: list[int] = []
    at, gap = 1, ""
    for letter in packer.plain.format[2:]:
        if letter.isdigit():
            gap += letter
        elif letter == "x":
            at, gap = at + int(gap or 1), ""
        else:
            numbers += (at, SIZES[letter], int(letter.islower()))
            at += SIZES[letter]
    return packer.plain.size, bytes(packer.flag_places), tuple(numbers)
