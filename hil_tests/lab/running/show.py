"""What a person sees of the demo: a live table on a terminal, plain lines elsewhere."""

import sys
import threading
from collections.abc import Sequence

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from gateway.pure.cell.cell import Cell
from hil_tests.lab.judges.judge import Verdict
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.partners.plc2 import ModbusPlc

REFRESH_S = 0.2
STATES = {0: "-", 1: "accepted", 2: "running", 3: "done", 4: "refused", 5: "aborted"}


class Show:
    """Steps are always printed; the table lives below them while both PLCs run."""

    def __init__(self, *, quiet: bool) -> None:
        self.title = "start"
        self._console = Console(file=sys.stderr if quiet else sys.stdout, highlight=False)
        self._live: Live | None = None
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def say(self, text: str) -> None:
        """A line that stays."""
        self._console.print(text, soft_wrap=True)

    def step(self, title: str) -> None:
        """The next act."""
        self.title = title
        self._console.print(f"- {title}")

    def watch(self, cell: Cell, one: S5Plc, two: ModbusPlc) -> None:
        """Start the live table, if this is a terminal."""
        if not self._console.is_terminal:
            return
        self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._live.start()
        self._thread = threading.Thread(target=self._run, args=(cell, one, two), daemon=True)
        self._thread.start()

    def _run(self, cell: Cell, one: S5Plc, two: ModbusPlc) -> None:
        while not self._stop.wait(REFRESH_S):
            if self._live is not None:
                self._live.update(picture(cell, one, two, self.title), refresh=True)

    def unwatch(self) -> None:
        """Take the table away."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(2)
            self._thread = None
        if self._live is not None:
            self._live.stop()
            self._live = None

    def summary(self, verdicts: Sequence[Verdict]) -> None:
        """The verdicts, one a line."""
        self._console.print()
        for verdict in verdicts:
            self._console.print(Text(verdict.line(), style="green" if verdict.ok else "bold red"))
        good = sum(verdict.ok for verdict in verdicts)
        judged = "judged by the emulator's record and the line record, evidence level: emulator"
        self._console.print(f"{good} of {len(verdicts)} checks passed; {judged}", soft_wrap=True)  # one line, as the tutorial shows it

    def close(self) -> None:
        self.unwatch()


def picture(cell: Cell, one: S5Plc, two: ModbusPlc, title: str) -> Group:
    """Axes as PLC 2 reads them next to DB 11 as PLC 1 fetches it (KF at 0.1)."""
    status = two.status
    table = Table("axis", "actual", "lag", "on", "ref", "in pos", "DB 11 (KF)", title=title)
    for n, axis in enumerate(cell.axis):
        if status is None:
            table.add_row(axis.name, "-", "-", "-", "-", "-", str(one.status.word(2 + n)))
            continue
        marks = ["x" if mask >> n & 1 else "" for mask in (status.enabled, status.referenced, status.in_position)]
        table.add_row(axis.name, f"{status.actual[n]:9.3f} {axis.unit}", f"{status.lag[n]:7.3f}", *marks, str(one.status.word(2 + n)))
    line = f"PLC 1: {one.cycles} cycles, {one.failures} failed jobs   PLC 2: {two.cycles} cycles"
    owner = (
        ""
        if status is None
        else f"   owner: command source {status.owner}   override {status.override:.0%}   PLC 2's command: {STATES.get(status.state)}"
    )
    return Group(table, Text(line + owner))
