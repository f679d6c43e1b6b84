"""External program selection and abort: code, parity, two strobes.  Source: rho 3 Releases L2604-2667; rho3 3.3, AX-541."""

from gateway.pure.controllers.rho3.functions.addresses import Edge, Places, Pulse, even, number_at, trusted
from gateway.pure.controllers.rho3.functions.dat_lines import Table
from gateway.pure.controllers.rho3.functions.messages import Text
from gateway.pure.controllers.rho3.functions.processes import ProcessFault, ProcessTable
from gateway.pure.image.records.cell import InputImage
from protocols.base.machine import Ns


class ExternalPrograms:
    """Each rising edge of a strobe gets one answer: done or error, for P9."""

    def __init__(self, places: Places, strobe_time: Ns, table: Table[str] | None) -> None:
        self.table = table
        self._places = places
        self._abort_edge, self._select_edge = Edge(places.abort_strobe), Edge(places.select_strobe)
        self._aborted, self._abort_error = Pulse(places.aborted, strobe_time), Pulse(places.abort_error, strobe_time)
        self._selected, self._select_error = Pulse(places.selected, strobe_time), Pulse(places.select_error, strobe_time)

    def step(self, inputs: InputImage, outputs: bytearray, processes: ProcessTable, now: Ns) -> list[Text]:
        """Returns why orders were refused."""
        abort, select = self._abort_edge.step(inputs) > 0, self._select_edge.step(inputs) > 0
        refusals: list[Text] = []
        if abort:
            refusal = self._abort(inputs, processes)
            (self._aborted if refusal is None else self._abort_error).give()
            refusals += [refusal] if refusal else []
        if select:
            refusal = self._select(inputs, processes)
            (self._selected if refusal is None else self._select_error).give()
            refusals += [refusal] if refusal else []
        for pulse in (self._aborted, self._abort_error, self._selected, self._select_error):
            pulse.step(outputs, now)
        return refusals

    def _name(self, inputs: InputImage) -> str | Text:
        """Return the program of the code on the channel, or its fault."""
        if inputs.bit(self._places.abort_strobe) and inputs.bit(self._places.select_strobe):
            return Text("both_strobes")  # forbidden (L2651): neither is done
        if not (trusted(inputs, self._places.program_code) and trusted(inputs, self._places.program_parity)):
            return Text("not_good")
        code = number_at(inputs.values, self._places.program_code, 8)
        if even(code) != inputs.bit(self._places.program_parity):
            return Text("parity", (f"{code:02X}",))
        if self.table is None:
            return Text("no_file")
        return self.table.entries.get(code) or Text("no_code", (self.table.file, f"{code:02X}"))

    def _abort(self, inputs: InputImage, processes: ProcessTable) -> Text | None:
        name = self._name(inputs)
        if isinstance(name, Text):
            return name
        process = processes.named(name)
        return None if process is not None and processes.stop(process.number) else Text("no_process", (name,))

    def _select(self, inputs: InputImage, processes: ProcessTable) -> Text | None:
        name = self._name(inputs)
        if isinstance(name, Text):
            return name
        try:
            processes.start(name)
        except ProcessFault as fault:
            return Text("not_started", (name, str(fault.code)))
        return None
