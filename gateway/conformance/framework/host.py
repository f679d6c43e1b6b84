"""Uncertainty of a time caused by this host: the lateness of the tester, and of a device that is a program on this host as well."""

import time
from typing import Protocol

from gateway.conformance.framework.peers import Peers
from gateway.links.serial.tool_wire import waited_ns
from protocols.base.machine import Ns


class Held(Protocol):
    """A wire, as far as its own lateness goes."""

    simulated: bool
    late_ns: Ns

    def now(self) -> Ns: ...
    def held(self, since: Ns, until: Ns) -> Ns: ...


class Lates(Protocol):
    """Processes that notice when they wake late."""

    def begin(self) -> None: ...
    def late(self, since: Ns | None = None) -> Ns: ...


class Host:
    """Host of one run.  If the programs at the other end are known their own waits count, else the worst of the witness processes."""

    def __init__(self, witness: Lates | None = None, peers: Peers | None = None) -> None:
        self._witness, self._peers = witness, peers
        self._since: Ns = 0

    def begin(self) -> None:
        """A case starts."""
        if self._witness is not None:
            self._witness.begin()
        if self._peers is not None:
            self._peers.look()
        self._since = time.monotonic_ns()

    def sample(self, wire: Held) -> None:
        """At each character or frame sent or received."""
        if self._peers is not None and not wire.simulated:
            self._peers.sample(wire.now(), waited_ns())

    def late(self, wire: Held) -> Ns:
        """The worst since the case began; of tester and device together where that is known."""
        if wire.simulated:
            return 0
        if self._peers is not None and self._peers.known:
            self.sample(wire)
            return max(wire.late_ns, self._peers.worst(self._since))
        return max(wire.late_ns, self._others())

    def within(self, wire: Held, since: Ns) -> Ns:
        """Additional lateness of any answer of the device since then, caused by this host."""
        if wire.simulated:
            return 0
        if self._peers is not None and self._peers.known:
            self.sample(wire)
            return wire.held(since, wire.now()) + self._peers.within(since)
        return max(wire.late_ns, self._others(since))

    def ends(self, wire: Held, since: Ns) -> Ns:
        """The uncertainty of a time from then until now."""
        if wire.simulated:
            return 0
        if self._peers is not None and self._peers.known:
            self.sample(wire)
            return wire.held(since, wire.now()) + self._peers.ends(since)
        return max(wire.held(since, wire.now()), self._others(since))

    def _others(self, since: Ns | None = None) -> Ns:
        return self._witness.late(since) if self._witness is not None else 0
