"""Orders of tools, page and pendant to the test system of a rho 3: those the manual allows are passed to the interpreter (AX-1040)."""

from collections.abc import Mapping

from gateway.pure.controllers.rho3.functions.processes import Kind, ProcessFault
from gateway.pure.controllers.rho3.pendant.infos import Condition
from gateway.pure.controllers.rho3.signals.codes import code_text
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.image.records.interpreter import Fact

Row = dict[str, object]
STEPS = ("run", "into", "over", "out", "hold")
MOST_LINES, MOST_TEXT = 100, 400


def start_program(rho: RhoControl, hosted: HostedPrograms, name: str, source: int) -> dict[str, object]:
    """A program of the memory starts; or why it does not."""
    row = next((row for row in hosted.programs if row["name"] == name), None)
    if row is None:
        known = ", ".join(str(each["name"]) for each in hosted.programs) or "none"
        why = f"the memory has {known}" if hosted.language_id else "the interpreter does not run"
        return {"error": f"{name}: no such program; {why}"}
    if row["fault"]:
        return {"error": f"{name} has errors and does not run; the first: {row['fault']}"}
    hosted.starter = source
    try:
        return {"run": hosted.run_of(rho.start(name))}
    except ProcessFault as fault:
        return {"error": f"{name}: {code_text(fault.code) or 'error'} ({fault.code})"}
    finally:
        hosted.starter = 0


class TestOrders:
    """Orders for testing, teaching and setting that are permitted now."""

    __test__ = False

    def __init__(self, control: RhoControl, hosted: HostedPrograms) -> None:
        self._control, self._hosted = control, hosted

    def answer(self, request: Mapping[str, object], source: int) -> Row:
        """`ticket` of an order that went on (see `outcome`), `run` of a start, or why it is refused."""
        if not self._hosted.language_id:
            return {"error": "the interpreter does not run"}
        name = str(request.get("name", "")).upper()[:32]
        match request.get("do"):
            case "test":
                return self._start(name, source, hold=request.get("hold") is True)
            case "outcome":
                return self._outcome(request.get("ticket"))
            case "look":
                return self._order("look", run=self._run(request))
            case "breakpoints":
                return self._breakpoints(name, request.get("lines"))
            case "step":
                how = str(request.get("how"))
                if how not in STEPS:
                    return {"error": f"how = {how!r}; {', '.join(STEPS)} are known"}
                return self._order("step", run=self._run(request), how=how)
            case "movement":
                return self._order("movement", on=request.get("on") is True)
            case "variable":
                value = str(request.get("value", ""))[:MOST_TEXT]
                program = str(request.get("program", "")).upper()[:32]
                return self._order("variable", run=self._run(request), program=program, name=name, value=value)
        return self._point(request, name)

    def _order(self, what: str, **facts: Fact) -> Row:
        return {"ticket": self._hosted.order(what, **facts)}

    @staticmethod
    def _run(request: Mapping[str, object]) -> int:
        run = request.get("run")
        return run if isinstance(run, int) else 0

    def _outcome(self, ticket: object) -> Row:
        why = self._hosted.answers.get(ticket) if isinstance(ticket, int) else None
        return {"over": False} if why is None else {"error": why} if why else {"over": True}

    def _start(self, name: str, source: int, *, hold: bool) -> Row:
        if not self._control.test_allowed():
            return {"error": f"{Condition.NO_TEST_BIT.value} The PLC selects the test with TEST_MN_RCI"}
        self._hosted.testing = hold
        try:
            answer = start_program(self._control, self._hosted, name, source)
        finally:
            self._hosted.testing = None
        process = self._control.processes.named(name) if "run" in answer else None
        if process is not None:
            process.kind = Kind.TEST
        return answer

    def _breakpoints(self, name: str, lines: object) -> Row:
        wanted = lines if isinstance(lines, list) else []
        if len(wanted) > MOST_LINES or not all(isinstance(line, int) and 1 <= line <= 32767 for line in wanted):
            return {"error": f"lines: up to {MOST_LINES} numbers, 1 to 32767"}
        return self._order("breakpoints", program=name, lines=",".join(map(str, sorted(set(wanted)))))

    def _point(self, request: Mapping[str, object], name: str) -> Row:
        """Teach in of the actual position, or a point by numbers."""
        point = str(request.get("point", "")).upper()[:32]
        if Condition.DEFINE_DISABLED in self._control.pendant.view.conditions():
            return {"error": f"{Condition.DEFINE_DISABLED.value}: the PLC has disabled Define and Teach in"}
        if request.get("do") == "define":
            return self._order("define", program=name, point=point, value=str(request.get("value", ""))[:MOST_TEXT])
        kinematic = request.get("kinematic")
        number = kinematic if isinstance(kinematic, int) else 0
        row = next((row for row in self._hosted.programs if row["name"] == name), None)
        given = row["kinematics"] if row is not None else None
        own = number or (min(given) if isinstance(given, list) and given else 1)
        if own in range(1, self._control.setup.installation.kinematics + 1) and self._control.modes.automatic(own):
            return {"error": f"kinematic {own} is in automatic; Teach in needs manual (AUTO_MN_RCI = 0)"}
        return self._order("teach", program=name, point=point, kinematic=number)
