"""The cycle process on a real vcan0: the identifiers of one cycle, by candump and by what it takes as actual values."""

import itertools
import pathlib

import pytest

from drivers.ports.can.open import open_can
from hil_tests.lab.running.cycle_running import Drives, running_cycle, serve
from hil_tests.rig.vcan.candump import candump, read

pytestmark = pytest.mark.vcan

CYCLES = 20
TURN = 16384


@pytest.mark.requirement("RHO-CAN-01", by=("gateway.cycle.bus_link:BusLink.prepare", "gateway.cycle.bus_link:BusLink.receive"))
def test_one_cycle_on_vcan0(tmp_path: pathlib.Path) -> None:
    """The drives are played by this test, which the guest may let wait: then it is tried again, at most four times."""
    for attempt in range(5):
        log = tmp_path / f"log{attempt}"
        with candump(log), running_cycle("demo", {"drives": "socketcan:vcan0"}) as run:
            port = open_can("socketcan:vcan0")
            drives = Drives(port, [TURN * n for n in range(1, 7)])
            serve(run, [drives], CYCLES)
            actual = run.actual()
            port.close()
        identifiers = [frame.identifier for frame in read(log)]
        starts = [n for n, identifier in enumerate(identifiers) if identifier == 100]
        assert len(starts) > CYCLES, "SYNC did not come"
        cycles = [identifiers[a:b] for a, b in itertools.pairwise(starts[:CYCLES])]
        assert all(cycle[:7] == [100, 210, 220, 230, 240, 250, 260] for cycle in cycles)
        late = [cycle for cycle in cycles[1:] if cycle[7:] != [610, 620, 630, 640, 650, 660]]
        if not late:
            break
    assert late == []
    assert actual[:3] == pytest.approx([0.02, 0.04, 0.03], abs=1e-12)
