"""The scan of a PIC: inputs in, timers and counters, the program, outputs.  Source: rho3 3.5, 6; AX-981."""

from typing import Protocol

from gateway.pure.languages.pic.expressions import ERROR, FIXED, FLAGS, INPUTS, ONE, OUTPUTS, SIZE
from gateway.pure.languages.pic.reader import PicProgram
from gateway.pure.languages.pic.symbols import BYTES
from gateway.pure.languages.plc.generated import Generated
from gateway.pure.languages.plc.state import Layout, State, TimeError

ALLOWANCE = 100_000  # commands of a scan: tens of ms; a program that jumps back runs no longer
LAYOUT = Layout(SIZE, INPUTS, OUTPUTS, BYTES, (ERROR, 1))


class Timers(Protocol):
    """Timers and counters of the control, controlled by flags."""

    counters: list[int]
    left: list[int]

    def step(self, flags: bytearray, elapsed: int) -> None:
        """Before a scan."""


class Scan:
    """One program over its memory; another program may be put in between two scans."""

    def __init__(self, timers: Timers) -> None:
        self.timers = timers
        self.state = State(LAYOUT)
        self.state.memory[FIXED] = ONE
        self._generated: Generated | None = None

    def load(self, program: PicProgram) -> None:
        """Scanned from now on; memory and times stay."""
        self._generated = Generated(program.program, self.state, _too_long)

    @property
    def loaded(self) -> bool:
        """There is a program."""
        return self._generated is not None

    @property
    def outputs(self) -> bytes:
        """O0 to O127."""
        return bytes(self.state.memory[OUTPUTS : OUTPUTS + BYTES])

    @property
    def flags(self) -> bytes:
        """M0 to M127."""
        return bytes(self.state.memory[FLAGS : FLAGS + BYTES])

    def set_flags(self, first: int, data: bytes) -> None:
        """Set flags from M `first` on; bytes beyond the last flag are ignored."""
        data = data[: max(0, BYTES - first)]
        self.state.memory[FLAGS + first : FLAGS + first + len(data)] = data

    def scan(self, elapsed: int, inputs: bytes, others: bytes, owned: frozenset[int]) -> None:
        """`others`: outputs as the control has them; the PIC reads those that others write.  TimeError: the program runs too long."""
        assert self._generated is not None  # asked before
        memory = self.state.memory
        memory[INPUTS : INPUTS + BYTES] = inputs
        for byte, value in enumerate(others):
            if byte not in owned:
                memory[OUTPUTS + byte] = value
        flags = bytearray(self.flags)
        self.timers.step(flags, elapsed)
        memory[FLAGS : FLAGS + BYTES] = flags
        self._generated.scan(ALLOWANCE)


def _too_long(routine: str, line: int) -> int:
    raise TimeError(routine, line)
