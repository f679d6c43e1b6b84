"""Frames that only the master of a bus sends, and detection of a second master, which would reset the first one's drives (AX-631).  Pure.

Source: CiA 301, 7.3.5 (predefined connection set); rho3 2.2 (SERVODYN: SYNC 100, set values 200+10n).
"""

from collections import Counter
from collections.abc import Iterable, Mapping

from drivers.drives.cia402_family import GATEWAY_NODE
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.servodyn.plan import SYNC_ID

SILENT_NS = ms(3000)  # a master that sends nothing for so long is gone
MODULES = range(1, 25)
NONE: Mapping[int, str] = {}


def master_identifiers(protocol: str) -> Mapping[int, str]:
    """Identifier -> its meaning, on a [[bus]] of this protocol."""
    if protocol == "canopen":
        found = {cobid.NMT: "NMT", cobid.SYNC: "SYNC", cobid.heartbeat(GATEWAY_NODE): f"heartbeat of node {GATEWAY_NODE}"}
        found |= {cobid.sdo_request(node): "SDO request" for node in range(1, cobid.MAX_NODE + 1)}
        return found | {cobid.LSS_MASTER: "LSS"}
    if protocol == "servodyn":
        return {SYNC_ID: "SYNC"} | {200 + 10 * module: "set value" for module in MODULES}
    return NONE


def device_identifiers(node: int) -> frozenset[int]:
    """Identifiers that only the CANopen device with this number sends."""
    pdos = {cobid.tpdo(number, node) for number in range(1, 5)}
    return frozenset(pdos | {cobid.emcy(node), cobid.sdo_answer(node), cobid.heartbeat(node)})


def heard_text(heard: Mapping[int, int], names: Mapping[int, str]) -> str:
    """ "SYNC (080h, 40 times), SDO request (602h, once)"; empty: nothing of a master was received."""
    times = {number: "once" if count == 1 else f"{count} times" for number, count in heard.items()}
    return ", ".join(f"{names[number]} ({number:03X}h, {times[number]})" for number in sorted(heard) if number in names)


def masters_in(frames: Iterable[Frame], protocol: str) -> str:
    """Sentence about the masters found while listening; empty: no master was active."""
    names = master_identifiers(protocol)
    return heard_text(Counter(frame.identifier for frame in frames if frame.identifier in names), names)


class OtherMaster:
    """Detects another master on a bus in use: one sentence when it appears, one when it is gone."""

    def __init__(self, protocol: str) -> None:
        self.names = master_identifiers(protocol)
        self._heard: Counter[int] = Counter()
        self._last: Ns = 0

    def heard(self, identifier: int, now: Ns) -> str:
        """The sentence to report, mostly empty."""
        first = not self._heard[identifier]
        self._heard[identifier] += 1
        self._last = now
        words = f"another master is active on this bus: {self.names[identifier]} ({identifier:03X}h); two masters reset each other's drives"
        return f"{words}: end one of them" if first else ""

    def wake(self, now: Ns) -> str:
        """The sentence that it is over, mostly empty."""
        if not self._heard or now - self._last < SILENT_NS:
            return ""
        words = f"the other master is silent; it sent {heard_text(self._heard, self.names)}"
        self._heard.clear()
        return words
