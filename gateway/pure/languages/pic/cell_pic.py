"""The PIC of a cell, in the interpreter: reads its program, scans it each period, reports to the control (AX-981).  Pure."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from gateway.pure.image.records.interpreter import Fact
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import View
from gateway.pure.languages.pic.reader import PicProgram, read_program
from gateway.pure.languages.pic.run import Scan, Timers
from gateway.pure.languages.pic.symbols import Signals, symbols_of
from gateway.pure.languages.plc.state import TimeError

REPORTED_NS = 100_000_000  # period of its life reports


class Sources(Protocol):
    """Files of the memory."""

    def text(self, name: str) -> str | None:
        """A file as text."""


class PicPort(Protocol):
    """The cell as it sees it, and whom it reports to; a part of what hosts programs."""

    @property
    def view(self) -> View:
        """The cell in this turn."""

    def report(self, program: str, line: int, text: str) -> None:
        """What a person should read."""

    def send(self, what: str, **facts: Fact) -> None:
        """To its part in the services."""


def read_pic(memory: Sources, name: str, signals: Signals, faults: Faults) -> PicProgram | None:
    """The program NAME.QLS with its symbols NAME.SYM; None: it has errors or is not there."""
    text = memory.text(f"{name}.QLS")
    if text is None:
        return None
    symbols = symbols_of(memory.text(f"{name}.SYM") or "", f"{name}.SYM", signals, faults)
    return read_program(text, f"{name}.QLS", symbols, faults)


class CellPic:
    """Call `hear` with messages of the control, `turn` once a turn; nothing is scanned before the control has sent the flags."""

    def __init__(
        self, memory: Sources, name: str, signals: Signals, port: PicPort, timers: Timers, period: int, owned: frozenset[int]
    ) -> None:
        """`owned`: RC input bytes of the command source `pic`; `period`: ns."""
        self.name, self.owned, self.period = name.upper(), owned, period
        self._memory, self._signals, self._port = memory, signals, port
        self.stopped = False
        self._scan = Scan(timers)
        self._begun = False
        self._last, self._due, self._reported = 0, 0, 0
        self._seen: tuple[bytes, bytes, tuple[int, ...]] | None = None
        self._read()

    def _read(self) -> None:
        faults = Faults()
        program = read_pic(self._memory, self.name, self._signals, faults)
        for fault in faults:
            self._port.report(f"{self.name}.QLS", fault.position.line, f"{fault.text}; {fault.hint}" if fault.hint else fault.text)
        if program is not None:
            self._scan.load(program)
        else:
            self._port.report(f"{self.name}.QLS", 0, "the previous program continues" if self._scan.loaded else "the PIC does not start")

    def file_changed(self, name: str) -> None:
        """A file of the memory was replaced."""
        if name.upper() in (f"{self.name}.QLS", f"{self.name}.SYM"):
            self._read()

    def hear(self, order: Mapping[str, Fact]) -> None:
        """Flags and counters that were kept, or flags that others have written."""
        match order["do"]:
            case "pic":
                if not self._begun:
                    self._scan.set_flags(0, bytes.fromhex(str(order["flags"])))
                    for number, value in enumerate(str(order["counters"]).split(",")):
                        if value and number < len(self._scan.timers.counters):
                            self._scan.timers.counters[number] = int(value)
                self._begun, self._seen = True, None
            case "pic-flags":
                self._scan.set_flags(int(order["first"]), bytes.fromhex(str(order["data"])))

    def turn(self, now: int) -> None:
        """Scans where a period is over."""
        if not self._begun or self.stopped or not self._scan.loaded or now + self.period // 4 < self._due:
            return
        elapsed = now - self._last if self._last else 0
        self._due = max(self._due + self.period, now)
        self._last = now
        channels = self._port.view.channels
        try:
            self._scan.scan(elapsed, channels.outputs, channels.inputs, self.owned)
        except TimeError as error:
            self.stopped = True
            self._port.report(f"{self.name}.QLS", error.line, "the scan does not end; the PIC stops")
            self._port.send("pic-stopped", line=error.line)
            return
        self._report(now)

    def _report(self, now: int) -> None:
        scan = self._scan
        seen = scan.outputs, scan.flags, tuple(scan.timers.counters)
        if seen == self._seen and now - self._reported < REPORTED_NS:
            return
        self._seen, self._reported = seen, now
        left = _listed([ns // 1_000_000 for ns in scan.timers.left])
        self._port.send("pic", outputs=seen[0].hex(), flags=seen[1].hex(), counters=_listed(scan.timers.counters), left=left)


def _listed(numbers: Sequence[int]) -> str:
    return ",".join(str(each) for each in numbers)
