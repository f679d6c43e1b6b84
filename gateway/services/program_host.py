"""The interpreter as the services know it: its region and rings, joined with the control whose programs it runs (AX-860)."""

import time
from collections.abc import Mapping
from typing import Protocol

from gateway.pure.image.records.interpreter import (
    REPORT_LAYOUT,
    SEEN_LAYOUT,
    TEXT_LAYOUT,
    Channels,
    Fact,
    pack_channels,
    pack_facts,
    unpack_facts,
    unpack_report,
)
from gateway.runtime.regions import RegionReader, RegionWriter, RingReader, RingWriter
from protocols.base.machine import Ns, ms

SILENT_NS = ms(12_000)  # a memory of many programs is read for seconds
TAKEN = 256


class Hosted(Protocol):
    """Programs of the interpreter for their control.

    Orders to the interpreter, sentences for the operator, and jobs of an interpreter that is gone; all three are read once per cycle.
    """

    orders: list[dict[str, Fact]]
    sentences: list[str]
    ending: list[int]

    def report(self, report: Mapping[str, object], *, alive: bool) -> None:
        """The interpreter's publication: identity, programs, processes."""

    def hear(self, said: Mapping[str, Fact], now: Ns) -> None:
        """One record of its ring."""

    def step(self, now: Ns) -> None:
        """Before and after a cycle of the control."""


class ProgramsOfControl(Protocol):
    """Interface of a language's part in the services."""

    @property
    def hosted(self) -> Hosted:
        """Its programs."""

    def seen(self) -> Channels:
        """The interface as programs see it."""

    def faults(self) -> list[str]:
        """Active errors of programs, in words."""

    def answer(self, request: Mapping[str, object], source: int) -> dict[str, object]:
        """Answer a tool: `do` = list, start and stop (`name`), state (`run`).  `source`: the command source as which a started program
        moves, 0: the PLC's.
        """


class ProgramHost:
    """Rings and regions of the interpreter."""

    def __init__(self, programs: ProgramsOfControl, fds: Mapping[str, int]) -> None:
        self._programs = programs
        self._region = RegionReader(fds["interpreter"], "interpreter", REPORT_LAYOUT)
        self._orders = RingWriter(fds["program-orders"], "program-orders", TEXT_LAYOUT)
        self._says = RingReader(fds["program-says"], "program-says", TEXT_LAYOUT)
        self._channels = RegionWriter(fds["channels"], "channels", SEEN_LAYOUT)
        self._seen, self._report = b"", -1
        self._alive = False
        self._orders.put(pack_facts({"do": "hello"}))

    def before(self, now: Ns) -> None:
        """Before a cycle of the control: messages of the interpreter."""
        hosted = self._programs.hosted
        alive = time.monotonic_ns() - self._region.life[1] < SILENT_NS
        payload = self._region.read()
        if payload is not None and (self._region.index != self._report or alive != self._alive):
            self._report, self._alive = self._region.index, alive
            hosted.report(unpack_report(payload), alive=alive)
        for _, data in self._says.take(TAKEN):
            hosted.hear(unpack_facts(data), now)
        hosted.step(now)

    def after(self) -> list[str]:
        """After it: the channels as programs see them; report to the operator."""
        hosted = self._programs.hosted
        seen = pack_channels(self._programs.seen())
        if seen != self._seen:
            self._seen = seen
            self._channels.write(seen, time.monotonic_ns())
        hosted.step(time.monotonic_ns())
        sentences, hosted.sentences = hosted.sentences, []
        return sentences

    def pass_on(self) -> None:
        """Orders to the interpreter, when the planner has its own: a statement that comes before its stream would be lost (AX-1691)."""
        hosted = self._programs.hosted
        orders, hosted.orders = hosted.orders, []
        for order in orders:
            self._orders.put(pack_facts(order))

    def ending(self) -> list[int]:
        """Jobs of an interpreter that is gone."""
        hosted = self._programs.hosted
        jobs, hosted.ending = hosted.ending, []
        return jobs

    def faults(self) -> list[str]:
        """Active errors of programs."""
        return self._programs.faults()

    def answer(self, request: dict[str, object], source: int) -> dict[str, object]:
        """Answer a tool."""
        return self._programs.answer(request, source)
