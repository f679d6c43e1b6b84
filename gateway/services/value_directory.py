"""Every value of the services by its name: parts register their values; routes, telegrams, tools, page and programs read and write them.

Names: axis.*, cell.* (cell_values), order.* and other values written by telegrams and Modbus clients (named values), rho3.* and others of
the control, phg.*, io.* (contacts), signals and addresses of the plant (DB10.DW2, E 8.4, MW 10), registers of Modbus devices at ends of
routes.
"""

from collections.abc import Callable, Iterable
from typing import Protocol

from gateway.pure.arbitration.data_blocks import DataBlock, DataBlocks
from gateway.pure.arbitration.link_watch import LinkWatch
from gateway.pure.image.named_values import Values
from gateway.pure.image.records.cell import Quality
from protocols.base.machine import Ns
from protocols.modbus.view import View
from protocols.rk512.flags import Flags
from protocols.telegrams.fields import Value


class Reader(Protocol):
    """The command source that reads: some values differ between them."""

    number: int

    @property
    def in_control(self) -> bool:
        """It may move the axes."""

    def move_bit(self, key: str) -> bool:
        """busy, done, refused of its last move; KeyError: it has no handshake."""


class Provider(Protocol):
    """A part that has values."""

    def names(self) -> Iterable[str]:
        """Those a tool may list."""

    def read(self, name: str, reader: Reader | None) -> Value:
        """KeyError: not one of its names, or without a value so far."""

    def valid(self, name: str) -> bool:
        """The value of one of its names counts now; False: it is old, or was never written."""

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        """KeyError: not one of its names, or read only; ValueError: the value does not fit."""


class Line(Protocol):
    """A line that serves data blocks."""

    name: str
    number: int
    data: DataBlocks | None
    watch: LinkWatch
    flags: Flags

    def block_bytes(self, db: int) -> bytes | None:
        """The complete block as a partner would fetch it now; None: this line does not serve it."""

    def write_as_plc(self, db: int, word: int, data: bytes) -> str:
        """As if the PLC had sent it; returns "" or the reason of a refusal."""

    def flag_bytes(self) -> bytes:
        """Area M."""

    def reset_flag(self, byte: int, bit: int) -> bool:
        """A coordination flag is reset; False: it was not set."""


class ValueDirectory:
    """Providers are called in the order of their registration; owned by the services process, one thread."""

    def __init__(self, named: Values) -> None:
        self.named = named
        self.lines: list[Line] = []
        self.views: list[View] = []  # of Modbus servers, the first one is that of the tools
        self.errors: list[tuple[int, str]] = []  # of the cell, active, first one first
        self._providers: list[Provider] = []
        self._listeners: list[Callable[[], None]] = []
        self.register(NamedValues(self))

    def register(self, provider: Provider) -> None:
        """Its names can be read from now on."""
        self._providers.append(provider)

    def names(self) -> list[str]:
        """Every name that can be read, without signals and addresses."""
        return [name for provider in self._providers for name in provider.names()]

    def read(self, name: str, reader: Reader | None = None) -> Value:
        """KeyError: no such name, or no value so far; ValueError: it has none now."""
        return self._find(name, reader)[1]

    def number(self, name: str, reader: Reader | None = None) -> float:
        """For words and registers: a value that is none now is 0; KeyError: no such name."""
        try:
            return as_number(self.read(name, reader))
        except ValueError:
            return 0.0

    def current(self, name: str) -> float | None:
        """The number while it is valid; None: it is old, was never written, or is a text."""
        try:
            provider, value = self._find(name, None)
        except (KeyError, ValueError):
            return None
        return float(value) if isinstance(value, int | float) and provider.valid(name) else None

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        """KeyError: no such name, or it is read only; ValueError: the value does not fit."""
        for provider in self._providers:
            try:
                return provider.write(name, value, now, by)
            except KeyError:
                continue
        raise KeyError(f"{name}: no such name, or it is read only")

    def _find(self, name: str, reader: Reader | None) -> tuple[Provider, Value]:
        for provider in self._providers:
            try:
                return provider, provider.read(name, reader)
            except KeyError:
                continue
        raise KeyError(name)

    # ---- named values ------------------------------------------------------------------------------------------------
    def listen(self, on_change: Callable[[], None]) -> None:
        """Called after each write of a named value: telegrams that wait for an edge."""
        self._listeners.append(on_change)

    def changed(self) -> None:
        """A named value may have changed."""
        for on_change in self._listeners:
            on_change()

    # ---- data blocks -------------------------------------------------------------------------------------------------
    def data_block(self, key: int) -> DataBlock | None:
        """The declared block of whichever line has it."""
        return next((line.data.blocks[key] for line in self.lines if line.data is not None and key in line.data.blocks), None)

    def filled_block(self, key: int) -> bytes | None:
        """A declared block as its partner would fetch it now."""
        return next((bytes(line.data.fill(key)) for line in self.lines if line.data is not None and key in line.data.blocks), None)

    def serving(self, db: int) -> tuple[Line, bytes]:
        """The line that serves this block, and its bytes; KeyError in words."""
        for line in self.lines:
            data = line.block_bytes(db)
            if data is not None:
                return line, data
        raise KeyError(f"DB {db}: no line of this cell serves it")


def as_number(value: Value) -> float:
    """ValueError: a text or a row of values."""
    if isinstance(value, int | float):
        return float(value)
    raise ValueError(f"{value!r} is not a number")


class NamedValues:
    """Provider of values written by telegrams, Modbus clients and tools."""

    def __init__(self, directory: ValueDirectory) -> None:
        self._directory, self._values = directory, directory.named

    def names(self) -> Iterable[str]:
        return self._values.names()

    def read(self, name: str, reader: Reader | None) -> Value:
        return self._values.get(name)

    def valid(self, name: str) -> bool:
        return self._values.sample(name).quality is Quality.GOOD

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        self._values.put(name, value, now, by)
        self._directory.changed()
