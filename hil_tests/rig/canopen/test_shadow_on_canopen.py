"""A shadow beside a running control with CiA 402 drives: it listens to SYNC, RPDO1 and TPDO1, compares, and sends nothing (AX-512)."""

import pytest

from hil_tests.lab.partners.plc2 import PTP
from hil_tests.lab.running.shadow_running import Old, Shadow, old_control, until
from hil_tests.rig.canopen.test_demo_402 import configured

pytestmark = pytest.mark.timeout(300)
A1 = 1
FAR = (100.0, 10.0, 5.0, 0.0, 0.0, 0.0)
TOLERANCE = 2.0  # mm, deg
CONTROLWORD = 6  # bits of it that are compared


def test_commands_and_positions_of_nodes_are_equal_and_nothing_is_sent() -> None:
    with old_control("demo-402", "old402") as old:
        configured(old.run)
        shadow = Shadow(old, "demo-402", "beside402", "--tolerance", str(TOLERANCE))

        def comparing() -> bool:
            lines = shadow.kept("shadow-lines.json").get("lines")
            return isinstance(lines, list) and len(lines) == 2 and all(line["comparing"] for line in lines)

        until(comparing, "the shadow compares: the nodes count as started up")
        old.run.ready()
        old.run.repeat(1, lambda number: _there(old), old.run.ready)
        kept = shadow.kept("shadow-buses.json")
        pid = kept["pid"]
        assert isinstance(pid, int)
        _, report = shadow.end()
        assert old.frames_of(pid) == []
    assert isinstance(report["buses"], dict)
    telegrams = report["buses"]["telegrams"]
    assert [block["block"].rpartition("telegram ")[2] for block in telegrams] == [f"{0x200 + node} (set value)" for node in range(1, 7)]
    assert all(block["compared"] == CONTROLWORD + 1 and block["answers"] > 100 for block in telegrams)
    positions = {place["name"]: place for block in telegrams for place in block["places"] if place["place"] == "position"}
    assert all(place["equal_percent"] > 60.0 for place in positions.values()), positions


def _there(old: Old) -> None:
    old.run.command(PTP, A1, 1.0, FAR)
