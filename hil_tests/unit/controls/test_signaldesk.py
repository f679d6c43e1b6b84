"""SignalDesk: a control is stepped at once when a door has written, so that no edge falls between two of its cycles (AX-332)."""

from types import SimpleNamespace
from typing import Any

from gateway.pure.records import RC_BYTES, CellState, InputImage, Quality
from gateway.signaldesk import RcOutputs, SignalDesk
from hil_tests.unit.controls.bench import ControlBench, cell_with

ELEMENT = "reis.ibin_in.1"  # bytes 88..91


class Desk:
    """The desk over a real control and image; only the services around them are bare.  `steps`: how often it was stepped."""

    def __init__(self, controller: str) -> None:
        self.steps, self.inputs = 0, InputImage()
        self.inputs.quality[:] = bytes((Quality.GOOD,)) * RC_BYTES
        cell = cell_with(controller)
        region: Any = SimpleNamespace(read=lambda: bytes(RC_BYTES))
        services: Any = SimpleNamespace(
            cell=cell, owned={}, doors=[], office=ControlBench(cell).office, inputs=self.inputs, rc_out=RcOutputs(region),
            plan=SimpleNamespace(doors=[]), retain=SimpleNamespace(restore=lambda control: None), values=SimpleNamespace(state=CellState()),
            journal=SimpleNamespace(write=lambda *_: None), forces=SimpleNamespace(over=self._over),
        )  # fmt: skip
        self.desk = SignalDesk(services, 0)

    def _over(self, inputs: InputImage) -> InputImage:
        self.steps += 1
        return inputs

    def door_writes(self, value: int) -> float:
        """What the control has of it right after."""
        self.inputs.values[88] = value
        self.desk.inputs_came(1)
        assert self.desk.control is not None
        return self.desk.control.value(ELEMENT)


def test_both_edges_of_a_pulse_between_two_cycles_reach_the_control() -> None:
    made = Desk('kind = "reis"')
    made.desk.step(0)
    assert [made.door_writes(value) for value in (1, 0, 5)] == [1.0, 0.0, 5.0] and made.steps == 4


def test_a_telegram_that_changes_nothing_steps_nothing() -> None:
    made = Desk('kind = "reis"')
    made.desk.step(0)
    assert [made.door_writes(value) for value in (0, 0)] == [0.0, 0.0] and made.steps == 1
    made.door_writes(3)
    made.desk.inputs_came(2)
    assert made.steps == 2
