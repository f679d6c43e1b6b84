"""Stories of a plant: a PLC that has nothing but the signals of the interface works with the palletiser, in virtual time.

Those with the interlocks of a PIC program are in hil_tests/unit/languages/pic/test_in_a_cell.py.
"""

import pytest

from hil_tests.lab.virtual.baps2_bench import ABORT, ACKNOWLEDGE, AUTOMATIC, CODE, PARITY, RESET, SELECT, ProgramCell, one

FEED_HOLD, CHAIN, DRIVE_ON, OF_AXES = 27, 24, 66, (192, 200, 208, 216, 224, 232)
ABORTED, ABORT_ERROR, SELECTED, NOT_SELECTED = 116, 117, 120, 121
ERROR_STROBE, ERROR_BITS = 118, range(152, 168)
WAY = "V = 400\nMOVE LINEAR TO (160, 20, 40, 12)\nPUT = 1\nLAST = POS\nMOVE LINEAR TO (20, 20, 40, 12)\nPUT = 0"
DECLARED = "OUTPUT : 1 = PUT\nDEF POINT : LAST"


class Plc:
    """It writes RC inputs, reads RC outputs and notes the pulses it sees."""

    def __init__(self, files: dict[str, str] | None = None) -> None:
        self.cell = ProgramCell(files or one(WAY, DECLARED, name="PALLET"))
        self.seen: set[int] = set()
        self.codes: list[int] = []
        self.bits(SELECT, ABORT, DRIVE_ON, *OF_AXES, value=False)
        self.bits(DRIVE_ON)

    def output(self, bit: int) -> bool:
        return bool(self.cell.control.outputs[bit >> 3] >> (bit & 7) & 1)

    def look(self) -> None:
        """One of its cycles."""
        self.cell.bench.cycle()
        self.seen |= {bit for bit in (ABORTED, ABORT_ERROR, SELECTED, NOT_SELECTED) if self.output(bit)}
        if self.output(ERROR_STROBE):
            code = sum(self.output(bit) << n for n, bit in enumerate(ERROR_BITS))
            if code not in self.codes[-1:]:
                self.codes.append(code)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 250)):
            self.look()

    def bits(self, *bits: int, value: bool = True) -> None:
        self.cell.bench.permit(*bits, value=value)
        self.run(0.05)

    def pulse(self, bit: int) -> None:
        self.bits(bit)
        self.bits(bit, value=False)

    def select(self, code: int = 1, strobe: int = SELECT) -> None:
        for n in range(8):
            self.cell.bench.permit(CODE + n, value=bool(code >> n & 1))
        self.cell.bench.permit(PARITY, value=bool(code.bit_count() & 1))
        self.pulse(strobe)

    def until(self, test: object, seconds: float = 20.0) -> None:
        assert callable(test)
        for _ in range(round(seconds * 250)):
            if test():
                return
            self.look()
        raise AssertionError(f"never: {self.cell.told} {self.cell.language.rows()}")

    @property
    def running(self) -> bool:
        return bool(self.cell.control.processes.processes)

    def x(self) -> float:
        return self.cell.at()[0]


def parts(plc: Plc, since: int = 0) -> int:
    """How often it came to the place of a part."""
    there = [abs(place[0] - 160) < 0.01 for place in plc.cell.places[since:]]
    return sum(now and not before for before, now in zip([False, *there], there, strict=False))


def test_a_feed_hold_on_the_way_costs_no_part() -> None:
    plc = Plc()
    plc.select()
    plc.until(lambda: plc.x() > 60)
    plc.bits(FEED_HOLD, value=False)
    plc.run(0.5)
    held = plc.cell.at()
    plc.run(0.5)
    assert plc.cell.at() == held and plc.running and held[0] < 160
    plc.bits(FEED_HOLD)
    plc.until(lambda: not plc.running)
    assert parts(plc) == 1 and plc.seen == {SELECTED} and plc.x() == 20


def test_one_part_after_the_other() -> None:
    plc = Plc()
    for _ in range(3):
        plc.select()
        plc.until(lambda: not plc.running)
    assert parts(plc) == 3 and [value for _, _, value in plc.cell.outputs] == [True, False] * 3


def test_an_aborted_program_begins_anew() -> None:
    plc = Plc()
    plc.select()
    plc.until(lambda: plc.x() > 60)
    plc.select(strobe=ABORT)
    plc.until(lambda: ABORTED in plc.seen and not plc.running, 5)
    plc.run(0.5)
    rest = plc.cell.at()
    plc.run(0.5)
    assert plc.cell.at() == rest and rest[0] < 160
    plc.select()
    plc.until(lambda: not plc.running)
    assert parts(plc) == 1 and plc.x() == 20


def test_a_wrong_parity_a_strange_code_and_a_second_selection_start_nothing() -> None:
    plc = Plc()
    plc.cell.bench.permit(CODE)
    plc.cell.bench.permit(PARITY, value=False)
    plc.pulse(SELECT)
    assert plc.seen == {NOT_SELECTED} and not plc.running
    plc.select(7)
    assert not plc.running
    plc.select()
    plc.until(lambda: plc.running, 1)
    plc.seen.clear()
    plc.select()
    plc.run(0.3)
    assert NOT_SELECTED in plc.seen and len(plc.cell.control.processes.processes) == 1


def test_a_runtime_error_is_a_code_at_the_interface_until_it_is_acknowledged() -> None:
    plc = Plc(one("N = 0\nN = 5 / N", "INTEGER : N", name="PALLET"))
    plc.select()
    plc.until(lambda: 209 in plc.codes, 5)
    assert plc.running, "it stays in the list"
    plc.pulse(ACKNOWLEDGE)
    plc.run(0.2)
    assert not plc.running


@pytest.mark.parametrize("leave", [AUTOMATIC, CHAIN])
def test_manual_and_emergency_stop_end_the_program_and_a_fresh_selection_runs_it(leave: int) -> None:
    plc = Plc()
    plc.select()
    plc.until(lambda: plc.x() > 60)
    plc.bits(leave, value=False)
    plc.run(1.5)
    rest = plc.cell.at()
    assert plc.codes, "the reason is told"
    plc.bits(leave)
    plc.pulse(RESET)
    plc.run(0.5)
    assert plc.cell.at() == rest and not plc.running, "nothing goes on by itself"
    plc.bits(DRIVE_ON, value=False)
    plc.bits(DRIVE_ON)
    plc.run(0.5)
    plc.select()
    plc.until(lambda: parts(plc) == 1 and not plc.running)


def test_after_a_power_off_the_last_place_is_known_and_nothing_moves() -> None:
    plc = Plc()
    plc.select()
    plc.until(lambda: not plc.running)
    again = Plc({name: data.decode() for name, data in plc.cell.memory.files.items()})
    here = again.cell.at()
    again.bits(CODE, PARITY)
    again.run(0.5)
    assert again.cell.at() == here and not again.running
    assert "LAST = (160, 20, 40, 12)" in (again.cell.memory.text("PALLET.PKT") or "")
    again.select()
    again.until(lambda: not again.running)
    assert parts(again) == 1
