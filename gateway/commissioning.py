"""A CANopen bus without a cycle: who is there, and one node started up by hand; the tool's own port is the only master then."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from drivers.drives.cia402_boot import NodePlan
from drivers.drives.cia402_manual import Manual, Moved, homing, interpolated, profile_position, profile_velocity
from drivers.ports.can import open_can
from gateway.axes import scaling_of
from gateway.canopen_direct import DirectLink
from gateway.canopen_master import CanopenMaster, Health, Node
from gateway.cell import Axis
from gateway.firstenable import percent
from motion.units import to_si
from protocols.base.machine import Frame
from protocols.canopen import cobid, nmt, sdo

QUIET_S = 0.4  # after the last request: whoever has not answered by then is not there
IP_PERIOD_MS = 40  # between two SYNCs of a tool
OBJECTS = ((0x1000, 0, "type"), (0x1018, 1, "vendor"), (0x1018, 2, "product"), (0x1018, 3, "revision"), (0x1018, 4, "serial"))
Found = dict[str, object]


@contextmanager
def direct(url: str) -> Iterator[DirectLink]:
    """The bus by itself; PortError when it cannot be opened."""
    port = open_can(url)
    try:
        yield DirectLink(port)
    finally:
        port.close()


def scan(link: DirectLink, nodes: Sequence[int] = range(1, 128)) -> list[Found]:
    """Every node that answers SDO, with its identity.  Nothing is written, nothing is started."""
    found: dict[int, Found] = {}
    for index, sub, name in OBJECTS:
        asked = nodes if not found else sorted(found)
        for node in asked:
            link.send(cobid.sdo_request(node), sdo.initiate(sdo.Request.INITIATE_UPLOAD, (index, sub)))
            time.sleep(0.001)
        end = time.monotonic() + QUIET_S
        while time.monotonic() < end:
            _take(link.receive(), (index, sub), name, found)
            time.sleep(0.002)
        if not found:
            break
    return [found[node] for node in sorted(found)]


def _take(frames: list[Frame], key: tuple[int, int], name: str, found: dict[int, Found]) -> None:
    for frame in frames:
        node = frame.identifier - cobid.sdo_answer(0)
        if not 1 <= node <= cobid.MAX_NODE or len(frame.data) != 8 or sdo.key_of(frame.data) != key:
            continue
        row = found.setdefault(node, {"node": node})
        if frame.data[0] >> 5 != sdo.Answer.ABORT:
            row[name] = int.from_bytes(sdo.expedited_data(frame.data), "little")


def start_up(
    link: DirectLink, axis: str, plan: NodePlan, manual: Manual | None = None, timeout_s: float = 20.0
) -> tuple[Node, Moved | None]:
    """One node by the same plan as the cell's master, and one move by hand; pre-operational afterwards, because nobody watches it."""
    master = CanopenMaster("commission", link, [(axis, plan)], lambda kind, words, facts: None)
    master.start()
    node, moved = master.nodes[plan.node], None
    end = time.monotonic() + timeout_s
    try:
        while node.health not in (Health.READY, Health.REFUSED, Health.DEAD) and time.monotonic() < end:
            time.sleep(0.02)
        if node.health is Health.READY and manual is not None:
            moved = master.carry(plan.node, manual)
        return node, moved
    finally:
        frame = nmt.command(nmt.Command.PRE_OPERATIONAL, plan.node)
        link.send(frame.identifier, frame.data)
        master.stop()


def move_plan(axis: Axis, mode: str, way: float | None) -> Manual:
    """One move at the axis' first_enable speed; `way` in its unit, its first_enable travel when left out."""
    scaling, first = scaling_of(axis), axis.first_enable
    way_inc = round(to_si(first.travel if way is None else way, axis.unit) * scaling.inc_per_unit)
    speed_inc_s = max(1, round(to_si(axis.limits.speed * percent(first.speed), axis.unit) * abs(scaling.inc_per_unit)))
    accel_inc_s2 = max(1, round(to_si(axis.limits.accel / 2, axis.unit) * abs(scaling.inc_per_unit)))
    match mode:
        case "pp":
            return profile_position(way_inc, speed_inc_s, accel_inc_s2)
        case "pv":
            return profile_velocity(speed_inc_s if way_inc > 0 else -speed_inc_s, accel_inc_s2, round(1000 * abs(way_inc) / speed_inc_s))
        case "hm":
            return homing(round(axis.home.timeout_s * 1000))
        case _:
            steps = max(2, round(1000 * abs(way_inc) / speed_inc_s / IP_PERIOD_MS))
            return interpolated([round(way_inc * n / steps) for n in range(1, steps + 1)], IP_PERIOD_MS)


def inc_to_unit(axis: Axis, inc: int) -> float:
    """Increments as a way of the axis."""
    return inc / scaling_of(axis).inc_per_unit / to_si(1.0, axis.unit)
