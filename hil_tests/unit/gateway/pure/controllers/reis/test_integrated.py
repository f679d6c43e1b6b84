"""Outputs that the robot program writes, as the integrated PLC has them."""

from dataclasses import replace

import pytest

from gateway.pure.controllers.reis.integrated import IntegratedPlc
from gateway.pure.image.records.plc import PlcReport
from gateway.pure.languages.plc.plc import Plc


def scanned(plc: Plc, now: int) -> Plc:
    plc.scan(now * 10_000_000, bytes(40))
    return plc


@pytest.mark.requirement("RSV-IO-05", by="gateway.pure.languages.plc.plc:Plc.robot_output")
def test_the_program_sees_the_robots_outputs_and_keeps_its_own() -> None:
    plc = Plc({"MAIN": "U A2.0\n= A2.1\nU M0.0\n= A3.0\nEND\n"})
    assert plc.start("MAIN") == []
    scanned(plc, 1)
    plc.robot_output(2, 1, 1)
    plc.robot_output(3, 0b11, 0b11)
    assert plc.data.memory[2008 + 3] == 0b10, "A3.0 is written by the PLC in each scan"
    assert scanned(plc, 2).outputs[2] == 0b11 and plc.outputs[3] == 0b10
    plc.robot_output(2, 1, 0)
    assert scanned(plc, 3).outputs[2] == 0


def test_a_process_that_begins_learns_what_the_robot_has_set() -> None:
    plc = IntegratedPlc()
    running = PlcReport(1, running=True)
    plc.take(running, alive=True)
    plc.released()
    plc.robot_output(2, 0b11, 0b01)
    plc.robot_output(5, 0x80, 0x80)
    plc.orders.clear()
    plc.take(running, alive=True)
    assert plc.orders == []
    plc.take(replace(running, id=2), alive=True)
    assert [(order["byte"], order["mask"], order["bits"]) for order in plc.orders] == [(2, 1, 1), (5, 0x80, 0x80)]
    plc.orders.clear()
    plc.take(PlcReport(2, running=False), alive=True)
    assert plc.released(), "a PLC that has stopped sets all outputs to 0"
    plc.take(replace(running, id=3), alive=True)
    assert plc.orders == []
