"""The loss of the gateway on a cell that runs, with drives without internal access: the bus itself is the witness.

Until the loss each CiA 402 drive reports its position with every SYNC; from then on 6064h is read by SDO, one drive after the
other, as fast as they answer: the cycle is ended, so the bus is free for it.  A SERVODYN drive is silent without SYNC and cannot be
measured so.
"""

import contextlib
import select
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drivers.drives.cia402_family import GATEWAY_NODE
from drivers.ports.base import CanPort
from drivers.ports.can.open import open_can
from gateway.pure.cell.cell import Axis, Bus, Cell
from gateway.registry import DRIVE_FAMILIES
from gateway.tools.client import ToolClient, ToolError, mask_of
from gateway.tools.drives import loss_test as losstest
from gateway.tools.drives.loss_test import PATIENCE_S, Stop
from gateway.tools.drives.without_cycle import inc_to_unit
from protocols.base.machine import Frame, Ns
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo

POSITION = (0x6064, 0)
ANSWER_S = 0.05  # patience with one answer
SLOPE_NS = 40_000_000  # time over which speed is measured
REST_INC_S = 50  # below it a drive is at standstill
SLOWER = 0.9  # of its speed: it has begun to stop
LISTEN_S = 0.5


@dataclass(slots=True)
class Track:
    """One drive as seen on the bus."""

    places: list[tuple[Ns, int]] = field(default_factory=list)  # stamp, increments
    emergency_ns: Ns = 0  # first EMCY after the loss


class Witness:
    """All drives of one bus."""

    def __init__(self, port: CanPort, nodes: Sequence[int]) -> None:
        self.port, self.tracks = port, {node: Track() for node in nodes}
        self.last_life: Ns = 0  # last heartbeat or SYNC of the gateway

    def listen(self, seconds: float) -> None:
        """Frames that the cycle makes them send."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            select.select([self.port], (), (), left)
            self._take(0)

    def ask_once(self) -> None:
        """6064h of one drive after the other."""
        for node in self.tracks:
            self.port.send([Frame(cobid.sdo_request(node), sdo.initiate(sdo.Request.INITIATE_UPLOAD, POSITION))])
            until = time.monotonic() + ANSWER_S
            while not self._take(node) and (left := until - time.monotonic()) > 0:
                select.select([self.port], (), (), left)

    def _take(self, asked: int) -> bool:
        """All waiting frames; True: `asked` has answered."""
        answered = False
        for frame in self.port.receive():
            if frame.identifier in (cobid.SYNC, cobid.heartbeat(GATEWAY_NODE)):
                self.last_life = frame.stamp_ns
                continue
            node, kind = frame.identifier & 0x7F, frame.identifier & 0x780
            track = self.tracks.get(node)
            if track is None:
                continue
            if kind == cobid.tpdo(1, 0) and len(frame.data) == 6:
                track.places.append((frame.stamp_ns, int.from_bytes(frame.data[2:6], "little", signed=True)))
            elif kind == cobid.sdo_answer(0) and len(frame.data) == 8 and sdo.key_of(frame.data) == POSITION:
                answered = answered or node == asked
                if frame.data[0] >> 5 != sdo.Answer.ABORT:
                    track.places.append((frame.stamp_ns, int.from_bytes(sdo.expedited_data(frame.data), "little", signed=True)))
            elif kind == cobid.emcy(0) and frame.data[:2] != b"\0\0":
                track.emergency_ns = track.emergency_ns or frame.stamp_ns
        return answered


def measure(client: ToolClient, cell: Cell, urls: Mapping[str, str], velocity: float, patience_s: float = PATIENCE_S) -> list[Stop]:
    """The cycle is ended in the middle of a move of all axes; `urls`: bus -> CAN port.  It may start again after `patience_s`."""
    axes = drives_of(cell)
    losstest.under_way(client, cell, mask_of(cell, [axis.name for axis in cell.axis]), velocity)
    with contextlib.ExitStack() as stack:  # opened only now: the buffer of a port that is not read for a while is full of old frames
        witnesses: dict[str, Witness] = {}
        for name in dict.fromkeys(axis.drive.bus for axis in axes):
            port = open_can(urls[name])
            stack.callback(port.close)
            nodes = [axis.drive.node for axis in axes if axis.drive.bus == name and axis.drive.node is not None]
            witnesses[name] = Witness(port, nodes)
        for witness in witnesses.values():
            witness.listen(LISTEN_S / len(witnesses))
        losstest.end_cycle(client)
        try:
            _ask_all(witnesses, patience_s)
        finally:
            losstest.cycle_again(client)
    period = float(str(client.ask("axes").get("p5_ms", cell.cycle_ms)))
    return [_stop(axis, _bus_of(cell, axis), witnesses[axis.drive.bus], period) for axis in axes]


def _ask_all(witnesses: Mapping[str, Witness], patience_s: float) -> None:
    """In sequence, the drives of the second bus would be at standstill already when polled: poll the buses in turns."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        for witness in witnesses.values():
            witness.ask_once()


def drives_of(cell: Cell) -> list[Axis]:
    """ToolError where a drive is silent without SYNC."""
    silent = [axis.name for axis in cell.axis if not DRIVE_FAMILIES[axis.drive.type].objects]
    if silent:
        raise ToolError(
            f"axes {', '.join(silent)}: a SERVODYN drive is silent without SYNC; measure its stop with the maker's tool or a watch "
            "and write last_stop_test into [safety] yourself"
        )
    return list(cell.axis)


def _bus_of(cell: Cell, axis: Axis) -> Bus:
    return next(bus for bus in cell.bus if bus.name == axis.drive.bus)


def _stop(axis: Axis, bus: Bus, witness: Witness, period_ms: float) -> Stop:
    track = witness.tracks[axis.drive.node or 0]
    found = judged(track, witness.last_life)
    if found is None:
        raise ToolError(f"axis {axis.name}: node {axis.drive.node} reported no position around the loss; is another master on {bus.name}?")
    allowed = losstest.allowed_ms(bus, period_ms)
    per_inc = abs(inc_to_unit(axis, 1))
    return Stop(
        "gateway", axis.name, axis.unit, round(abs(found.speed_inc_s) * per_inc, 3), round(found.reaction_ms, 1), round(found.stop_ms, 1),
        round(abs(found.way_inc) * per_inc, 3), allowed, found.stopped and found.reaction_ms <= allowed,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Judged:
    """One drive after the loss."""

    speed_inc_s: float
    reaction_ms: float
    stop_ms: float
    way_inc: int
    stopped: bool


def judged(track: Track, lost_ns: Ns) -> Judged | None:
    """Reaction: its emergency, or when it had become slower, whichever was first.  None: nothing was received around the loss."""
    before = [place for place in track.places if lost_ns - 2 * SLOPE_NS <= place[0] <= lost_ns]
    after = [place for place in track.places if place[0] > lost_ns]
    if len(before) < 2 or not after:
        return None
    speed = _speed(before[0], before[-1])
    start = before[-1][1]
    slower = next((b[0] for a, b in _pairs([*before, *after]) if b[0] > lost_ns and abs(_speed(a, b)) < SLOWER * abs(speed)), None)
    reactions = [stamp for stamp in (track.emergency_ns, slower) if stamp]
    moving = abs(speed) > REST_INC_S
    reaction = (min(reactions) - lost_ns) / 1e6 if reactions and moving else float("inf") if moving else 0.0
    end = after[-1][1]
    still = next((stamp for n, (stamp, _) in enumerate(after) if all(abs(inc - end) <= 2 for _, inc in after[n:])), after[-1][0])
    stopped = after[-1][0] - still >= 2 * SLOPE_NS
    return Judged(speed, reaction, (still - lost_ns) / 1e6, end - start, stopped)


def _speed(a: tuple[Ns, int], b: tuple[Ns, int]) -> float:
    return (b[1] - a[1]) * 1e9 / max(1, b[0] - a[0])


def _pairs(places: Sequence[tuple[Ns, int]]) -> list[tuple[tuple[Ns, int], tuple[Ns, int]]]:
    """Each place with the last one that is SLOPE_NS or more older."""
    found, first = [], 0
    for place in places:
        while first + 1 < len(places) and place[0] - places[first + 1][0] >= SLOPE_NS:
            first += 1
        if place[0] - places[first][0] >= SLOPE_NS:
            found.append((places[first], place))
    return found
