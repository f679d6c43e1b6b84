"""What a PLC program works on: memory and cells.  The accumulators are the executor's own; where inputs and outputs lie is a parameter."""

from dataclasses import dataclass, field

from gateway.pure.languages.plc.cells import Cells


@dataclass(frozen=True, slots=True)
class Layout:
    """Size of the memory; first bytes and number of bytes of inputs and outputs in it; the bit that multiplication and division set."""

    size: int
    inputs: int
    outputs: int
    area: int
    error: tuple[int, int]  # byte, mask


@dataclass(slots=True)
class State:
    """Memory, cells, and masks of the output bits that a scan has written."""

    layout: Layout
    memory: bytearray = field(default_factory=bytearray)
    cells: Cells = field(default_factory=Cells)
    written: bytearray = field(default_factory=bytearray)

    def __post_init__(self) -> None:
        self.memory = bytearray(self.layout.size)
        self.written = bytearray(self.layout.area)


class TimeError(Exception):
    """A scan has run more commands than it may."""

    def __init__(self, routine: str, line: int) -> None:
        super().__init__(f"{routine}, step {line}")
        self.routine, self.line = routine, line
