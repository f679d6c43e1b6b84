"""The application of the interpreter together with the points of a VAL 3 control, and the requests of tools about it."""

from collections.abc import Mapping
from dataclasses import replace

from gateway.pure.controllers.val3.application import HostedApplication
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.image.records.cell import get_bit, set_bit
from gateway.pure.image.records.interpreter import Channels


class Val3Programs:
    """The control and the interpreter."""

    def __init__(self, control: Val3Control, hosted: HostedApplication) -> None:
        self._control, self.hosted = control, hosted

    def seen(self) -> Channels:
        """The application's image, including the operator's simulated values."""
        image, system = self._control.image, self._control.system
        inputs, outputs = bytearray(image.inputs), bytearray(image.outputs)
        for name, point in self._control.points.items():
            if not (system.simulated(name) or system.locked(name)):
                continue
            data, raw = outputs if point.output else inputs, system.raw(point)
            if point.steps:
                data[point.byte : point.byte + 2] = raw.to_bytes(2, "little", signed=True)
            elif get_bit(data, point.bit) != bool(raw):
                set_bit(data, point.bit, bool(raw))
        return replace(Channels(), inputs=bytes(inputs), outputs=bytes(outputs))

    def faults(self) -> list[str]:
        """Active errors: tasks that have stopped with one."""
        return self.hosted.faults

    def answer(self, request: Mapping[str, object], source: int) -> dict[str, object]:
        """`do`: list, start and stop (`name`), state (`run`)."""
        hosted, name = self.hosted, str(request.get("name", ""))
        match request.get("do"):
            case "list":
                return {"programs": hosted.programs, "processes": hosted.rows, "id": hosted.language_id}
            case "start":
                return hosted.start(name, source)
            case "stop":
                return hosted.stop(name)
            case "view":
                return {**hosted.seen, "id": hosted.language_id, "processes": hosted.rows, "programs": hosted.programs, "run": hosted.run}
            case "act":
                return hosted.act(request)
            case "state":
                return hosted.results.answer(request.get("run"), hosted.rows, alive=bool(hosted.language_id))
        return {"error": f"do {request.get('do')!r}; list, start, stop, state, view, act are known"}
