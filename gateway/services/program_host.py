"""The interpreter as the services know it: its region and rings, joined with the process table of the control (AX-860)."""

import time
from collections.abc import Mapping

from gateway.pure.controllers.rho3.functions.processes import ProcessFault
from gateway.pure.controllers.rho3.signals.codes import code_text
from gateway.pure.controllers.rho3.signals.control import RhoControl
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

SILENT_NS = ms(12_000)  # a memory of many programs is read for seconds
TAKEN = 256


class ProgramHost:
    """Rings and regions of the interpreter."""

    def __init__(self, control: RhoControl, fds: Mapping[str, int], language: str) -> None:
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
        """Before a cycle of the control: messages of the interpreter."""
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

    # ---- tools ---------------------------------------------------------------------------------------------------------
    def answer(self, request: dict[str, object], door: int) -> dict[str, object]:
        """`do`: list, start and stop (`name`), state (`run`).  `door`: command source a program that is started moves as, 0: the PLC's."""
        rho, hosted, name = self._control, self.hosted, str(request.get("name", "")).upper()
        match request.get("do"):
            case "list":
                return {"programs": hosted.programs, "processes": hosted.rows, "id": hosted.language_id}
            case "start":
                return self._start_program(rho, hosted, name, door)
            case "stop":
                process = rho.processes.named(name)
                if process is None or not rho.processes.stop(process.number):
                    return {"error": f"{name}: no such process"}
                return {"ok": True}
            case "state":
                return _outcome(hosted, request.get("run"))
        return {"error": f"do {request.get('do')!r}; list, start, stop, state are known"}

    @staticmethod
    def _start_program(rho: RhoControl, hosted: HostedPrograms, name: str, door: int) -> dict[str, object]:
        row = next((row for row in hosted.programs if row["name"] == name), None)
        if row is None:
            known = ", ".join(str(each["name"]) for each in hosted.programs) or "none"
            why = f"the memory has {known}" if hosted.language_id else "the interpreter does not run"
            return {"error": f"{name}: no such program; {why}"}
        if row["fault"]:
            return {"error": f"{name} has {row['errors']} errors and does not run; the first: {row['fault']}"}
        hosted.starter = door
        try:
            return {"run": hosted.run_of(rho.start(name))}
        except ProcessFault as fault:
            return {"error": f"{name}: {code_text(fault.code) or 'error'} ({fault.code})"}
        finally:
            hosted.starter = 0


def _outcome(hosted: HostedPrograms, run: object) -> dict[str, object]:
    """How a run of a program is, or how it ended."""
    if not isinstance(run, int):
        return {"error": "state: run = a number that start has given"}
    if (over := hosted.results.get(run)) is not None:
        how, code, words, place = over
        return {"over": True, "how": how, "code": code, "text": words, "place": place}
    rows = [row for row in hosted.rows if row["run"] == run]
    return {"over": False, "rows": rows}
