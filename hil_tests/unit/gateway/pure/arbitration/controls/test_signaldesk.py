"""SignalDesk: a control is stepped at once when a command source has written, so that no edge falls between two of its cycles (AX-332)."""

from types import SimpleNamespace
from typing import Any

from gateway.pure.image.records.cell import RC_BYTES, CellState, InputImage, Quality
from gateway.services.controller_host import ControllerHost, RcOutputs
from gateway.services.routes import Bridge
from hil_tests.unit.gateway.pure.arbitration.controls.bench import ControlBench, cell_with

ELEMENT = "reis.ibin_in.1"  # bytes 88..91


class Desk:
    """The desk over a real control and image; only the services around them are bare.  `steps`: how often it was stepped."""

    def __init__(self, controller: str, rho3: str = "", more: str = "") -> None:
        self.steps, self.inputs = 0, InputImage()
        self.levels: dict[str, float] = {"probe": 0.0}  # of contacts
        self.inputs.quality[:] = bytes((Quality.GOOD,)) * RC_BYTES
        cell = cell_with(controller, rho3, more)
        region: Any = SimpleNamespace(read=lambda: bytes(RC_BYTES))
        services: Any = SimpleNamespace(
            cell=cell, owned={}, doors=[], office=ControlBench(cell).office, inputs=self.inputs, rc_out=RcOutputs(region),
            plan=SimpleNamespace(doors=[]), retain=SimpleNamespace(restore=lambda control: None), values=SimpleNamespace(state=CellState()),
            journal=SimpleNamespace(write=lambda *_: None), forces=SimpleNamespace(over=self._over),
        )  # fmt: skip
        self.desk = ControllerHost(services, 0)
        services.signals = self.desk
        services.contacts = SimpleNamespace(contacts=(), listen=lambda now: None, show=lambda now: None, read=self.levels.get)
        self.bridge = Bridge(services, {})

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


def test_a_wire_of_a_route_reaches_a_waiting_process_with_the_cycle_that_brings_it_not_with_the_next_tick() -> None:
    process = '\n[[controller.process]]\nname = "WAITS"\nsteps = [ { input = 612 } ]\n'
    route = '\n[[route]]\nname = "wire"\nfrom = "io.probe"\nto = "rho3.fast.612"\n'
    contact = '\n[[io]]\nname = "probe"\ndevice = { type = "gpiochip", chip = "/dev/gpiochip0", input = 1 }\nsignal = "cell.safety_ok"\n'
    made = Desk('kind = "rho3"\nboards = ["modular-i"]' + process, "P11 = [1, 2]", route + contact)
    control = made.desk.rho3
    assert control is not None
    made.desk.step(0)
    control.start("WAITS")

    def turn(now: int) -> int:
        """As the cycle's wake-up does it; how often the control was stepped."""
        before = made.steps
        made.bridge.step(now)
        made.desk.inputs_came(now)
        return made.steps - before

    turn(1)
    assert turn(2) == 0 and control.processes.processes, "nothing has changed, it waits"
    made.levels["probe"] = 1.0
    assert turn(3) == 1 and control.value("rho3.fast.612") == 1
    assert not control.processes.processes, "its last step is done"
    assert turn(4) == 0
