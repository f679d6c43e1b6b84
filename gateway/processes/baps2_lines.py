"""BAPS2 programs of a cell with serial units, as the interpreter process hosts them (AX-1021)."""

from gateway.assembly.interpreter import Baps2Programs
from gateway.assembly.program_lines import serial_setup
from gateway.assembly.run import RunPlan
from gateway.links.serial.program_lines import ProgramLines
from gateway.pure.languages.base.hosting import Port

NOT_YET = "not opened yet"


class LinePrograms(Baps2Programs):
    """Reports each line that comes and goes."""

    def __init__(self, plan: RunPlan, port: Port) -> None:
        super().__init__(plan, port)
        setup = serial_setup(plan.cell)
        assert setup is not None  # a cell without units has the programs alone
        self._port = port
        self._lines = ProgramLines(setup, {name: plan.lines[name] for name in setup.lines})
        self._reported: dict[str, str] = {}
        self.language.connect(self._lines.units)

    def seen(self, now: int) -> dict[str, object]:
        """Nothing of its own; reports lost and returning lines."""
        for name, why in self._lines.reasons().items():
            if why != self._reported.get(name, NOT_YET):
                self._reported[name] = why
                self._port.report(f"line {name}", 0, why or "is open")
        return super().seen(now)
