"""A cell with [controller] in virtual time: dispatcher, core, emulated drives and the control its PLC sees, which is command source 1 of
two."""

import pathlib
import tempfile
from collections.abc import Mapping

from drivers.drives.family import BusFamily
from drivers.drives.servodyn_family import ServodynFamily
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.assembly.controllers import make_control
from gateway.assembly.plant import bus_settings
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.control import Control
from gateway.pure.controllers.reis.control import ReisControl
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import RC_BYTES, AxisFlag, Quality, get_bit, set_bit
from hil_tests.lab.partners.signal_plc import signal_cell
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.servodyn_bus import CODEC

PLC, OTHER = 1, 2
CHAIN, CONTROL_ALLOW = 24, 25
RESET, AUTO, ACK, DRIVE_ON = 19, 23, 62, 66


def cell_with(controller: str, rho3: str = "", more: str = "") -> Cell:
    """The two-axis cell of the rig tests."""
    with tempfile.TemporaryDirectory() as folder:
        path = signal_cell(pathlib.Path(folder), "rack", controller, rho3=rho3)
        return load_cell("old.toml", pathlib.Path(path).read_text() + more)


class ControlBench(CellBench):
    """`control` is stepped after each cycle of the core, as the services do it."""

    def __init__(self, cell: Cell, owners: Mapping[int, int] | None = None) -> None:
        super().__init__(8, cell=cell)
        owned = dict.fromkeys(range(RC_BYTES), PLC) if owners is None else owners
        self.errors = ErrorList()
        made, self.faults = make_control(cell, owned, {"rack": PLC, "net": OTHER}, self.dispatcher, self.errors, self.now)
        assert made is not None
        self.control: Control = made
        self.told: list[str] = []
        self.each = self._step
        for byte in range(RC_BYTES):
            self.inputs.quality[byte] = Quality.GOOD

    def _drives(self) -> tuple[ServodynSlave | Cia402Slave, BusFamily]:
        return ServodynSlave(bus_settings(self.cell, "drives", self.p5_ms), CODEC), ServodynFamily(CODEC, [(0, 1), (1, 2)])

    def _step(self) -> None:
        assert self.dispatcher.cell is not None
        self.told += self.control.step(self.inputs, bytes(self.core.outputs), self.dispatcher.cell, self.now)
        self._hand_over()

    # ---- the PLC ---------------------------------------------------------------------------------------------------------
    def put(self, *bits: int, off: tuple[int, ...] = (), cycles: int = 2) -> "ControlBench":
        """RC inputs to 1 and to 0, then some cycles."""
        for bit in bits:
            set_bit(self.inputs.values, bit, True)
        for bit in off:
            set_bit(self.inputs.values, bit, False)
        self.cycle(cycles)
        return self

    def pulse(self, bit: int) -> "ControlBench":
        return self.put(off=(bit,)).put(bit).put(off=(bit,))

    def quality(self, quality: Quality, *bytes_: int) -> "ControlBench":
        for byte in bytes_ or range(RC_BYTES):
            self.inputs.quality[byte] = quality
        self.cycle(2)
        return self

    def output(self, bit: int) -> bool:
        return get_bit(self.control.outputs, bit)

    def enabled(self) -> list[bool]:
        assert self.dispatcher.cell is not None
        return [bool(axis.flags & AxisFlag.ENABLED) for axis in self.dispatcher.cell.axes[:2]]

    def place(self, axis: int = 0) -> float:
        """mm."""
        assert self.dispatcher.cell is not None
        return self.dispatcher.cell.axes[axis].actual * 1000.0

    # ---- the kinds -------------------------------------------------------------------------------------------------------
    @property
    def rho3(self) -> RhoControl:
        assert isinstance(self.control, RhoControl)
        return self.control

    @property
    def reis(self) -> ReisControl:
        assert isinstance(self.control, ReisControl)
        return self.control

    @property
    def val3(self) -> Val3Control:
        assert isinstance(self.control, Val3Control)
        return self.control

    def codes(self) -> list[int]:
        return [record.code for record in self.errors.records if record.source == "rho3"]
