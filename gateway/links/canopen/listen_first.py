"""Listen before sending: a tool listens to a bus before it acts there as its master or as one of its devices (AX-631)."""

import select
import time
from collections.abc import Iterable

from drivers.drives.masters import device_identifiers, masters_in
from drivers.ports.base import CanPort, PortError
from drivers.ports.can.open import open_can
from protocols.base.machine import Frame

LISTEN_S = 0.6  # long enough to receive a SYNC and a heartbeat of any usual period
END_IT = "nothing was sent; two masters reset each other's drives: end the other one first (a running cell, a tool, the old controller)"


class OtherMasterError(PortError):
    """Another device is the master of this bus."""


def listen(port: CanPort, seconds: float = LISTEN_S) -> list[Frame]:
    """All frames received in this time; raises PortError."""
    heard: list[Frame] = []
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        if select.select([port], (), (), left)[0]:
            heard += port.receive()
    return heard


def refuse_other_master(port: CanPort, url: str, protocol: str, otherwise: str = "") -> None:
    """Returns when no master was received; raises OtherMasterError, which ends with `otherwise`, and PortError."""
    words = masters_in(listen(port), protocol)
    if words:
        raise OtherMasterError(f"{url}: another master is active on this bus: {words}; {END_IT}{otherwise}")


def refuse_on(url: str, protocol: str) -> None:
    """The same on a port of its own; for a bus that is not up yet the cycle listens when it appears."""
    try:
        port = open_can(url)
    except PortError:
        return
    try:
        refuse_other_master(port, url, protocol)
    finally:
        port.close()


def taken_nodes(frames: Iterable[Frame], nodes: Iterable[int]) -> list[int]:
    """Which of these node numbers a device on the bus already has."""
    heard = {frame.identifier for frame in frames}
    return [node for node in nodes if heard & device_identifiers(node)]
