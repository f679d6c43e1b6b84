"""BAPS2 programs of the interpreter in the process table of a rho 3, and what tools ask of them."""

from collections.abc import Mapping

from gateway.pure.controllers.rho3.functions.processes import ProcessFault
from gateway.pure.controllers.rho3.signals.codes import code_text
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.image.records.interpreter import Channels


class Rho3Programs:
    """The process table and the interpreter."""

    def __init__(self, control: RhoControl, language: str) -> None:
        self._control = control
        self.hosted = control.hosted = HostedPrograms(control, language)

    def seen(self) -> Channels:
        """The interface as programs see it."""
        return self._control.seen()

    def faults(self) -> list[str]:
        """The control lists them with its own numbers."""
        return []

    def answer(self, request: Mapping[str, object], source: int) -> dict[str, object]:
        """`do`: list, start and stop (`name`), state (`run`).  `source`: command source a program moves as, 0: the PLC's."""
        rho, hosted, name = self._control, self.hosted, str(request.get("name", "")).upper()
        match request.get("do"):
            case "list":
                return {"programs": hosted.programs, "processes": hosted.rows, "id": hosted.language_id}
            case "start":
                return _start_program(rho, hosted, name, source)
            case "stop":
                process = rho.processes.named(name)
                if process is None or not rho.processes.stop(process.number):
                    return {"error": f"{name}: no such process"}
                return {"ok": True}
            case "state":
                return _outcome(hosted, request.get("run"))
        return {"error": f"do {request.get('do')!r}; list, start, stop, state are known"}


def _start_program(rho: RhoControl, hosted: HostedPrograms, name: str, source: int) -> dict[str, object]:
    row = next((row for row in hosted.programs if row["name"] == name), None)
    if row is None:
        known = ", ".join(str(each["name"]) for each in hosted.programs) or "none"
        why = f"the memory has {known}" if hosted.language_id else "the interpreter does not run"
        return {"error": f"{name}: no such program; {why}"}
    if row["fault"]:
        return {"error": f"{name} has {row['errors']} errors and does not run; the first: {row['fault']}"}
    hosted.starter = source
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
