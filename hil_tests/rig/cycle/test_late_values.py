"""AX-149: an actual value that comes after its cycle is over is counted as late and never taken for the next cycle's."""

from drivers.drives.family import Actual
from drivers.ports.can.memory import memory_pair
from gateway.assembly.drive_buses import make_family
from gateway.cell_file.load import load_cell
from gateway.cycle.bus_link import BusLink
from protocols.base.machine import Frame
from protocols.servodyn.codec import SetValue


def test_what_the_bus_saw_before_the_burst_is_late() -> None:
    cell, clock = load_cell("demo"), [1_000]
    ours, theirs = memory_pair(lambda: clock[0])
    link = BusLink("memory:", make_family(cell, cell.bus[0], 4))
    link.port = ours
    link.prepare([SetValue()] * 6)
    theirs.send([answer(1, 11), answer(2, 22)])
    assert link.send(clock[0] + 1)
    clock[0] += 500
    theirs.send([answer(1, 111)])
    actuals: list[Actual | None] = [None] * 6
    assert link.receive(actuals) == 1 and link.late == 2
    assert [actual and actual.position_inc for actual in actuals] == [111, None, None, None, None, None]
    theirs.send([answer(2, 222), answer(1, 112)])
    assert link.receive(actuals) == 1, "axis 1 has answered before"
    assert [actual and actual.position_inc for actual in actuals[:2]] == [112, 222] and link.late == 2
    link.close()
    theirs.close()


def answer(module: int, position: int) -> Frame:
    """An actual value of this module that says only where it is (AX-001)."""
    return Frame(600 + 10 * module, b"\0\0" + position.to_bytes(4, "little") + b"\0\0")
