"""Five turntables, the first one parallel to an endless belt whose encoder counts in 16 bits, in virtual time (BeltBench)."""

import numpy as np

from drivers.emulator.servo.record import read
from gateway.cell_file.load import load_cell
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.turning_cell import PORTAL, cell_text
from hil_tests.lab.running.belt_run import FIRST_ID
from hil_tests.lab.virtual.belt_bench import BeltBench
from hil_tests.lab.virtual.planned_bench import Driven

FACTOR = 0.36  # deg of M for one mm of belt: a metre is a round
HEAD = "robot turntables\nangles rho3\naxes deg deg deg deg deg\nstart 0 0 0 0 0\n"
BELTS = "".join(
    f'[[belt]]\nname = "B{n}"\nincrement = 0.1\nbus = "drives"\nid = {FIRST_ID + n}\n{keys}\nsimulated = 100.0\n\n'
    for n, keys in ((1, f'bytes = 2\naxis = "M"\nfactor = {FACTOR}'), (2, "type = 1"), (3, 'axis = "S4"\nfactor = -0.1'))
)


def endless(portal: str | None = None) -> str:
    """The cell file; portal: as of cell_text()."""
    return cell_text(portal).replace("[plant]\n", f"{BELTS}[plant]\n")


TEXT = endless()
CELL = load_cell(str(PORTAL), TEXT)


class EndlessBelt(BeltBench):
    """`places`: of the first belt's encoder at each SYNC of the emulator's record, mm as it has run since the start."""

    head, home = HEAD, "ptp joints 0 0 0 0 0"

    def __init__(self) -> None:
        self.places: list[float] = []
        super().__init__(CELL)

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            super().cycle()
            self.places.append(0.1 * self.emulated.all[0].place)

    def ridden(self) -> tuple[Array, Array]:
        """Since the start: (SYNCs,) mm of the belt, and (SYNCs, axes) deg of the set values that each SYNC activated."""
        record = read(self.slave.header() + self.slave.take_record())
        sets = np.degrees(Driven(CELL, record, self.period_ns / 1e9).sets)
        return np.array(self.places[-len(sets) : -1]), sets[1:]  # the record says what the SYNC before has activated
