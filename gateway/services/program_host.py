"""The interpreter as the services know it: its region and rings, joined with the process table of the control (AX-860)."""

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING

from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.image.records.interpreter import (
    REPORT_LAYOUT,
    SEEN_LAYOUT,
    TEXT_LAYOUT,
    pack_channels,
    pack_facts,
    unpack_facts,
    unpack_report,
)
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter
from protocols.base.machine import ms

if TYPE_CHECKING:
    from gateway.pure.controllers.rho3.signals.control import RhoControl

SILENT_NS = ms(12_000)  # a memory of many programs is read for seconds
TAKEN = 256


class ProgramHost:
    """Rings and regions of the interpreter."""

    def __init__(self, control: "RhoControl", fds: Mapping[str, int], language: str) -> None:
        self._control = control
        self.hosted = HostedPrograms(control, language)
        control.hosted = self.hosted
        self._region = RegionReader(fds["interpreter"], "interpreter", REPORT_LAYOUT)
        self._orders = RingWriter(fds["program-orders"], "program-orders", TEXT_LAYOUT)
        self._says = RingReader(fds["program-says"], "program-says", TEXT_LAYOUT)
        self._channels = RegionWriter(fds["channels"], "channels", SEEN_LAYOUT)
        self._seen, self._report = b"", -1
        self._alive = False
        self._orders.put(pack_facts({"do": "hello"}))

    def before(self, now: int) -> None:
        """In front of a cycle of the control: what the interpreter says."""
        alive = time.monotonic_ns() - self._region.life[1] < SILENT_NS
        payload = self._region.read()
        if payload is not None and (self._region.index != self._report or alive != self._alive):
            self._report, self._alive = self._region.index, alive
            self.hosted.report(unpack_report(payload), alive=alive)
        for _, data in self._says.take(TAKEN):
            self.hosted.hear(unpack_facts(data), now)
        self.hosted.step(now)

    def after(self) -> list[str]:
        """Behind it: the channels as programs see them, orders; what a person should read."""
        seen = pack_channels(self._control.seen())
        if seen != self._seen:
            self._seen = seen
            self._channels.write(seen, time.monotonic_ns())
        self.hosted.step(time.monotonic_ns())
        orders, self.hosted.orders = self.hosted.orders, []
        for order in orders:
            self._orders.put(pack_facts(order))
        told, self.hosted.told = self.hosted.told, []
        return told

    def ending(self) -> list[int]:
        """Jobs of an interpreter that is gone."""
        jobs, self.hosted.ending = self.hosted.ending, []
        return jobs
