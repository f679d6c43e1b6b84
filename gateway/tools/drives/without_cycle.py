"""A CANopen bus without a cycle: find its nodes, and start one up by hand; the tool's own port is the only master then."""

import contextlib
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from drivers.drives.cia402_boot import NodePlan
from drivers.drives.cia402_manual import (
    Manual,
    ManualError,
    Moved,
    homing,
    interpolated,
    profile_position,
    profile_velocity,
    stopped,
)
from drivers.ports.base import PortError
from drivers.ports.can.open import open_can
from gateway.assembly.axis_scaling import scaling_of
from gateway.links.canopen.direct_link import DirectLink
from gateway.links.canopen.master import CanopenMaster, EndedError, Health, Node
from gateway.pure.cell.cell import Axis
from gateway.tools.drives.bus_watch import Heartbeat, Signals
from gateway.tools.drives.first_enable import percent
from motion.geometry.units import to_si
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt, sdo

QUIET_S = 0.4  # after the last request: a node that has not answered by then is not there
AGAIN_S = 2.0  # one retry with this time if no node answered at all: a loaded computer, a bus that has just come up
MISSED = 6  # heartbeats of the tool the drive may miss: a tool has no real-time priority
CONSUMER_HEARTBEAT = 0x1016
IP_PERIOD_MS = 40  # between two SYNCs of a tool
OBJECTS = ((0x1000, 0, "type"), (0x1018, 1, "vendor"), (0x1018, 2, "product"), (0x1018, 3, "revision"), (0x1018, 4, "serial"))
Found = dict[str, object]


@contextmanager
def direct(url: str) -> Iterator[DirectLink]:
    """The bus without a cycle; PortError if it cannot be opened."""
    port = open_can(url)
    try:
        yield DirectLink(port)
    finally:
        port.close()


def scan(link: DirectLink, nodes: Sequence[int] = range(1, 128)) -> list[Found]:
    """Every node that answers SDO, with its identity.  Nothing is written, nothing is started."""
    return _scanned(link, nodes, QUIET_S) or _scanned(link, nodes, AGAIN_S)


def _scanned(link: DirectLink, nodes: Sequence[int], quiet_s: float) -> list[Found]:
    found: dict[int, Found] = {}
    for index, sub, name in OBJECTS:
        asked = nodes if not found else sorted(found)
        for node in asked:
            link.send(cobid.sdo_request(node), sdo.initiate(sdo.Request.INITIATE_UPLOAD, (index, sub)))
            time.sleep(0.001)
        end = time.monotonic() + quiet_s
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
    """One node by the same plan as the cell's master, and one move by hand; pre-operational afterwards, because it is no longer supervised.

    The drive watches the tool's heartbeat, so the tool's death stops it.  Every other exit stops it by controlword and is verified. Raises
    ManualError with the refused step, and whether the drive is off.
    """
    plan = replace(plan, missed=MISSED)
    master = CanopenMaster("commission", link, [(axis, plan)], lambda kind, words, facts: None)
    node = master.nodes[plan.node]
    with Signals() as signals, Heartbeat(link, plan.heartbeat_ms / 1000.0) as life:
        master.start()
        last = nmt.Command.PRE_OPERATIONAL
        try:
            _await_start(node, signals, life, timeout_s)
            moved = None
            if node.health is Health.READY and manual is not None:
                last = nmt.Command.STOP  # until the drive has shown that it is off: its abort connection option is the last resort
                moved = _move(master, node, manual, signals, life)
                last = nmt.Command.PRE_OPERATIONAL
            if node.health is Health.READY:
                master.download(plan.node, CONSUMER_HEARTBEAT, 1, bytes(4))  # the heartbeat that ends now is not a fault
            return node, moved
        except MoveEndedError:
            last = nmt.Command.PRE_OPERATIONAL
            master.download(plan.node, CONSUMER_HEARTBEAT, 1, bytes(4))
            raise
        finally:
            with contextlib.suppress(PortError):
                frame = nmt.command(last, plan.node)
                link.send(frame.identifier, frame.data)
            master.stop()


class MoveEndedError(ManualError):
    """The move was ended, and the drive has shown that it is off."""


def _await_start(node: Node, signals: Signals, life: Heartbeat, timeout_s: float) -> None:
    end = time.monotonic() + timeout_s
    while node.health not in (Health.READY, Health.REFUSED, Health.DEAD) and time.monotonic() < end:
        if signals.why:
            raise ManualError(f"{signals.why} before the drive was started up; it was not switched on")
        life.alive()
        time.sleep(0.02)


def _move(master: CanopenMaster, node: Node, manual: Manual, signals: Signals, life: Heartbeat) -> Moved:
    """The move; then the drive is off, or ManualError reports that it is not."""

    def ends() -> str:
        life.alive()
        return signals.why or ("" if node.health is Health.READY else f"node {node.plan.node}: {node.why}")

    def goes_on() -> str:
        life.alive()
        return ""

    moved: Moved | None = None
    why = ""
    try:
        moved = master.carry(node.plan.node, manual, ends)
    except (ManualError, EndedError) as error:
        why = str(error)
    try:
        status = master.carry(node.plan.node, stopped(), goes_on)
    except ManualError as error:
        before = f"{why}; then " if why else ""
        raise ManualError(f"{before}{error}: PRESS THE EMERGENCY STOP, the drive may still move") from error
    if moved is None:
        raise MoveEndedError(f"{why}; the drive was stopped and is switched off (statusword {status:04X}h)")
    return moved


def move_plan(axis: Axis, mode: str, way: float | None) -> Manual:
    """One move at the axis' first_enable speed; `way` in its unit, its first_enable travel when left out.  Raises ManualError."""
    scaling, first = scaling_of(axis), axis.first_enable
    longest = (1 << 31) / abs(scaling.inc_per_unit) / to_si(1.0, axis.unit)
    if way is not None and not abs(way) < longest:  # also NaN
        raise ManualError(f"--way {way:g}: a way of axis {axis.name} is a number within +-{longest:.0f} {axis.unit} (32 bits)")
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
