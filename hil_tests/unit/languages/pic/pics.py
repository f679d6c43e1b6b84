"""A PIC program on the bench: scanned by hand, its signals by their names."""

import pathlib

from gateway.files.find import read_signals
from gateway.pure.controllers.rho3.signals.timers import TimersAndCounters
from gateway.pure.image.signals import from_tables
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.pic.cell_pic import read_pic
from gateway.pure.languages.pic.run import Scan
from gateway.pure.languages.pic.symbols import Area, Bit, Symbols, address, named_in, symbols_of

VECTORS = pathlib.Path(__file__).parents[3] / "vectors" / "pic"
SIGNALS = named_in(from_tables(read_signals()))
PERIOD = 4_000_000


class Files:
    """A memory."""

    def __init__(self, files: dict[str, str]) -> None:
        self.files = files

    def text(self, name: str) -> str | None:
        return self.files.get(name)


def faults_of(text: str, symbols: str = "") -> list[tuple[int, int, str]]:
    """Line, column and kind of each fault."""
    faults = Faults()
    read_pic(Files({"P.QLS": text, "P.SYM": symbols}), "P", SIGNALS, faults)
    return [(fault.position.line, fault.position.column, fault.id) for fault in faults]


class Bench:
    """`set` and `get` by symbol, signal or address."""

    def __init__(
        self, text: str, symbols: str = "", timers: tuple[int, ...] = (), counters: tuple[int, ...] = (), owned: int = 128
    ) -> None:
        faults = Faults()
        program = read_pic(Files({"P.QLS": text, "P.SYM": symbols}), "P", SIGNALS, faults)
        assert program is not None and not len(faults), [str(fault) for fault in faults]
        self.program = program
        self.symbols: Symbols = symbols_of(symbols, "P.SYM", SIGNALS, faults)
        self.scan_of = Scan(TimersAndCounters(32, timers, counters, PERIOD))
        self.scan_of.load(program)
        self.inputs, self.others = bytearray(128), bytearray(128)
        self.owned = frozenset(range(owned))

    @classmethod
    def of(cls, name: str) -> "Bench":
        """A listing of the manual."""
        symbols = VECTORS / f"{name}.SYM"
        return cls((VECTORS / f"{name}.QLS").read_text(), symbols.read_text() if symbols.exists() else "")

    def place(self, name: str) -> Bit:
        found = address(name) or self.symbols.find(name)
        assert isinstance(found, Bit), name
        return found

    def set(self, *names: str, value: bool = True) -> None:
        for name in names:
            bit = self.place(name)
            if bit.area is Area.FLAG:
                byte = self.scan_of.flags[bit.byte]
                self.scan_of.set_flags(bit.byte, bytes((byte | 1 << bit.bit if value else byte & ~(1 << bit.bit),)))
                continue
            image = self.inputs if bit.area is Area.INPUT else self.others
            image[bit.byte] = image[bit.byte] & ~(1 << bit.bit) | value << bit.bit

    def scan(self, times: int = 1) -> None:
        for _ in range(times):
            self.scan_of.scan(PERIOD, bytes(self.inputs), bytes(self.others), self.owned)

    def get(self, name: str) -> bool:
        bit = self.place(name)
        image = {Area.INPUT: bytes(self.inputs), Area.OUTPUT: self.scan_of.outputs, Area.FLAG: self.scan_of.flags}[bit.area]
        return bool(image[bit.byte] >> bit.bit & 1)

    def bits(self, *names: str) -> str:
        """After one more scan, as 0 and 1."""
        self.scan()
        return "".join(str(int(self.get(name))) for name in names)
