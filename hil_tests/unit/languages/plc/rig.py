"""A PLC with one program, scanned every 10 ms of its own time by both executors."""

from collections.abc import Mapping

from gateway.pure.languages.plc.plc import Plc, PlcState, Settings

TICK = 10_000_000


class Rig:
    """`run(set(..inputs..))` scans once; reads are of the state after the last scan."""

    def __init__(
        self, text: str = "", sources: Mapping[str, str] | None = None, settings: Settings | None = None, start: str = "MAIN"
    ) -> None:
        self.sources = dict(sources or {"MAIN": f"PLC MAIN\n{text}\nEND"})
        self.plc = Plc(self.sources, settings or Settings())
        self.refused = [message.text for message in self.plc.start(start)]
        self.ticks = 0
        self.inputs = bytearray(40)
        self.outputs = bytes(40)

    def scan(self, *high: str, ticks: int = 1) -> "Rig":
        """One scan after `ticks` of 10 ms with these inputs high."""
        self.inputs[:] = bytes(40)
        for name in high:
            byte, bit = name.removeprefix("E").split(".")
            self.inputs[int(byte)] |= 1 << int(bit)
        self.outputs = self.plc.scan(self.ticks * TICK, bytes(self.inputs))
        self.ticks += ticks
        return self

    def output(self, name: str) -> bool:
        byte, bit = name.removeprefix("A").split(".")
        return bool(self.outputs[int(byte)] >> int(bit) & 1)

    @property
    def runs(self) -> bool:
        return self.plc.state is PlcState.RUN


def result_of(text: str, *high: str) -> bool:
    """The result that `= A0.0` puts out behind a text."""
    return Rig(f"{text}\n= A0.0").scan(*high).output("A0.0")


def accus_of(text: str) -> tuple[int, int]:
    """Both accumulators behind a text."""
    rig = Rig(f"{text}\nTD M100\nTA\nTD M104").scan()
    assert rig.refused == []
    return rig.plc.number(100), rig.plc.number(104)
