"""What the commands share: exit codes, the banner, loading a cell with a report of its faults."""

import contextlib
import signal
import sys
from collections.abc import Callable, Iterator

from gateway.cell_file.load import load_cell
from gateway.files.find import ConfigNotFound, find_config
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults

DONE, FINDING, USAGE, ENVIRONMENT = 0, 1, 2, 3
BANNER = (
    "axisgate is not a safety device. It has no safety function, no performance level and no certificate. Emergency stop, safe torque\n"
    "off, guards, enabling devices and speed monitoring must be realised in certified hardware that works without axisgate.\n"
    "axisgate ist keine Sicherheitseinrichtung: Not-Halt, STO, Schutztueren, Zustimmung und sichere Geschwindigkeit gehoeren in\n"
    "zertifizierte Hardware, die ohne axisgate wirkt."
)


def load(name: str) -> Cell | int:
    """The checked cell, or the exit code after its faults were printed."""
    try:
        return load_cell(str(find_config(name, "cells")))
    except ConfigNotFound as error:
        print(f"axisgate: {error}", file=sys.stderr)
        return USAGE
    except CellFaults as faults:
        for fault in faults.faults:
            print(fault, file=sys.stderr)
        print(f"axisgate: {len(faults.faults)} faults; axisgate check {name} explains them", file=sys.stderr)
        return USAGE


@contextlib.contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Ctrl-C, or a polite end, no longer ends the command: it asks whether that came."""
    came: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda got, frame: came.append(got)) for number in numbers]
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
