"""rho 3 Releases part 8, 11.1 on a real vcan0: two controls exchange their bytes, candump is the witness."""

import contextlib
import pathlib

import pytest

from hil_tests.lab.running.cycle_running import running_cycle
from hil_tests.rig.rho3can.test_11_1_two_controls import Control, cell, until
from hil_tests.rig.vcan.candump import candump, read

pytestmark = pytest.mark.vcan


def test_two_controls_on_vcan0(tmp_path: pathlib.Path) -> None:
    files = cell(tmp_path, "one", [(92, 4, 471)], [(92, 4, 472)]), cell(tmp_path, "two", [(92, 4, 472)], [(92, 4, 471)])
    log = tmp_path / "log"
    with contextlib.ExitStack() as stack:
        stack.enter_context(candump(log))
        one, two = (Control(stack.enter_context(running_cycle(file, {"io": "socketcan:vcan0"}))) for file in files)
        one.put(92, b"\x12\x34\x56\x78")
        two.put(92, b"\x9a\xbc\xde\xf0")
        arrived = until(lambda: two.get(92, 95) == b"\x12\x34\x56\x78" and one.get(92, 95) == b"\x9a\xbc\xde\xf0", 10.0)
    heard = read(log)
    assert arrived
    assert {frame.identifier for frame in heard} == {471, 472}
    assert {frame.data for frame in heard if frame.identifier == 472} <= {bytes(4), b"\x12\x34\x56\x78"}
