"""A CANopen bus without a cycle: who is there, and one node started up by hand; the tool's own port is the only master then."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from drivers.drives.cia402_boot import NodePlan
from drivers.ports.can import open_can
from gateway.canopen_direct import DirectLink
from gateway.canopen_master import CanopenMaster, Health, Node
from protocols.base.machine import Frame
from protocols.canopen import cobid, nmt, sdo

QUIET_S = 0.4  # after the last request: whoever has not answered by then is not there
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


def start_up(link: DirectLink, axis: str, plan: NodePlan, timeout_s: float = 20.0) -> Node:
    """One node by the same plan as the cell's master; it is left pre-operational afterwards, because nobody watches it."""
    said: list[str] = []
    master = CanopenMaster("commission", link, [(axis, plan)], lambda kind, words, facts: said.append(words))
    master.start()
    node = master.nodes[plan.node]
    end = time.monotonic() + timeout_s
    try:
        while node.health not in (Health.READY, Health.REFUSED, Health.DEAD) and time.monotonic() < end:
            time.sleep(0.02)
        return node
    finally:
        frame = nmt.command(nmt.Command.PRE_OPERATIONAL, plan.node)
        link.send(frame.identifier, frame.data)
        master.stop()
