"""BAPS2 programs of the interpreter in the process table of a rho 3, and requests of tools about them."""

from collections.abc import Mapping

from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.image.records.interpreter import Channels
from gateway.services.rho3_test_orders import TestOrders, start_program


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
        """`do`: list, start and stop (`name`), state (`run`); of the test system: test, breakpoints, step, movement, look, variable, teach,
        define, outcome.  `source`: command source a program moves as, 0: the PLC's."""
        rho, hosted, name = self._control, self.hosted, str(request.get("name", "")).upper()
        match request.get("do"):
            case "list":
                return {"programs": hosted.programs, "processes": hosted.rows, "id": hosted.language_id, **hosted.shown}
            case "start":
                return start_program(rho, hosted, name, source)
            case "stop":
                process = rho.processes.named(name)
                if process is None or not rho.processes.stop(process.number):
                    return {"error": f"{name}: no such process"}
                return {"ok": True}
            case "state":
                return hosted.results.answer(request.get("run"), hosted.rows, alive=bool(hosted.language_id))
            case "test" | "outcome" | "look" | "breakpoints" | "step" | "movement" | "variable" | "teach" | "define":
                return TestOrders(rho, hosted).answer(request, source)
        return {"error": f"do {request.get('do')!r}; list, start, stop, state are known"}
