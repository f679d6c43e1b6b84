"""Override entries of single kinematics in the data blocks of a PLC (AX-1787)."""

import pytest

from gateway.pure.arbitration.block_overrides import BlockOverrides
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.command_numbers import OVERRIDE, MoveNumbers

ARM, SCARA = "robot.arm.override", "robot.scara.override"
MASKS = {"arm": 0b0011, "scara": 0b1100}  # of five axes: the last one is no robot's


class Said:
    """A PLC's entries, and what they make of what it writes."""

    def __init__(self, *names: str) -> None:
        self.numbers = MoveNumbers(set(names))
        self.overrides = BlockOverrides(self.numbers, 5)
        self.overrides.robots = MASKS

    def write(self, *, fresh: bool = False, control: bool = True, **levels: float | None) -> dict[int, float] | str:
        """Axes and the override ordered for them."""
        names = {"cell": OVERRIDE, "arm": ARM, "scara": SCARA}
        for name, level in levels.items():
            self.numbers.put(names[name], level, "too much" if level is None else "")
        found = self.overrides.take({names[n]: v for n, v in levels.items() if v is not None}, fresh=fresh, control=control)
        if isinstance(found, str):
            return found
        assert all(command.code == (Code.AXES_OVERRIDE if command.mask else Code.OVERRIDE) for command in found)
        return {command.mask: round(command.velocity, 6) for command in found}


def test_that_of_a_kinematic_is_a_share_of_that_of_the_cell_and_each_lane_gets_one_order() -> None:
    plc = Said(OVERRIDE, SCARA)
    assert plc.write(cell=80, scara=50) == {}, "the first telegram only sets the state of its entries"
    assert plc.write(fresh=True) == {0b1100: 0.4, 0b10011: 0.8}
    assert plc.write(scara=100) == {0b1100: 0.8, 0b10011: 0.8}
    assert plc.write(scara=100) == {}, "a level that has not changed fights nobody"
    assert plc.write(cell=10) == {0b1100: 0.1, 0b10011: 0.1}
    assert plc.write(cell=20, control=False) == {}


def test_without_an_entry_of_the_cell_its_share_is_the_whole() -> None:
    plc = Said(ARM, SCARA)
    plc.write(arm=30, scara=60)
    assert plc.write(fresh=True) == {0b0011: 0.3, 0b1100: 0.6, 0b10000: 1.0}


@pytest.mark.parametrize(("names", "expected"), [((), {0: 1.0}), ((OVERRIDE,), {0: 0.8})])
def test_blocks_without_such_entries_order_as_ever(names: tuple[str, ...], expected: dict[int, float]) -> None:
    plc = Said(*names)
    if names:
        plc.write(cell=80)
    assert plc.write(fresh=True) == expected


def test_a_refused_one_leaves_all_as_they_are_until_a_good_one_is_written() -> None:
    plc = Said(OVERRIDE, SCARA)
    plc.write(cell=80, scara=50)
    assert plc.write(scara=None) == {} and plc.overrides.refused == "too much"
    assert plc.write(fresh=True) == "too much"
    assert plc.write(scara=70) == {0b1100: 0.56, 0b10011: 0.8}, "the drives were asked on before"
    assert plc.overrides.refused == ""


def test_one_that_is_not_written_is_missing_and_nothing_is_ordered() -> None:
    plc = Said(OVERRIDE, SCARA)
    assert plc.write(cell=80) == {} and plc.write(fresh=True) == {}
    assert plc.numbers.missing(plc.overrides.names).startswith(f"{SCARA} has not been written")
