"""ControllerHost: a control is stepped at once when a command source has written: no edge falls between two cycles (AX-332)."""

from gateway.pure.buses.contacts import Said
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import RC_BYTES, CellState, InputImage, Quality
from gateway.services.contacts import DigitalContacts
from gateway.services.controller_host import ControllerHost
from gateway.services.part_context import PartContext
from gateway.services.routes import Bridge
from hil_tests.lab.virtual.source_bench import SourceBench
from hil_tests.unit.gateway.pure.arbitration.controls.bench import cell_with
from protocols.base.machine import Ns

ELEMENT = "reis.ibin_in.1"  # bytes 88..91


class CountedControl:
    """Counts how often a control is stepped."""

    def __init__(self, host: ControllerHost) -> None:
        self.steps = 0
        assert host.control is not None
        self._step, host.control.step = host.control.step, self.step  # type: ignore[method-assign]  # counted on its way

    def step(self, inputs: InputImage, cycle: bytes, state: CellState, now: Ns, *, heard: bool = False) -> list[str]:
        self.steps += 1
        return self._step(inputs, cycle, state, now, heard=heard)


class Host:
    """Control, contacts and routes over the shared image of the services."""

    def __init__(self, controller: str, rho3: str = "", more: str = "") -> None:
        self.bench = SourceBench(cell_with(controller, rho3, more))
        made = self.bench
        made.image.inputs.quality[:] = bytes((Quality.GOOD,)) * RC_BYTES
        context = PartContext(made.run, made.image, made.values, made.dispatcher)
        self.host = ControllerHost(context, ErrorList(), lambda: 0, lambda jobs: None, {}, 0)
        self.contacts = DigitalContacts(made.run, made.image, made.values, lambda bus, node: "", {})
        self.bridge = Bridge(made.run, made.image, made.values, self.contacts, lambda axis, key, data: None, {}, lambda: None)
        self.counted = CountedControl(self.host)

    @property
    def steps(self) -> int:
        return self.counted.steps

    def probe(self, value: bool) -> None:
        """The contact the route begins at."""
        self.contacts.said[0] = Said(value, Quality.GOOD)

    def source_writes(self, value: int) -> float:
        """What the control has of it right after."""
        self.bench.image.write(88, bytes((value,)), 1)
        self.host.inputs_came(1)
        assert self.host.control is not None
        return self.host.control.value(ELEMENT)


def test_both_edges_of_a_pulse_between_two_cycles_reach_the_control() -> None:
    made = Host('kind = "reis"')
    made.host.step(0)
    assert [made.source_writes(value) for value in (1, 0, 5)] == [1.0, 0.0, 5.0] and made.steps == 4


def test_a_telegram_that_changes_nothing_steps_nothing() -> None:
    made = Host('kind = "reis"')
    made.host.step(0)
    assert [made.source_writes(value) for value in (0, 0)] == [0.0, 0.0] and made.steps == 1
    made.source_writes(3)
    made.host.inputs_came(2)
    assert made.steps == 2


def test_a_wire_of_a_route_reaches_a_waiting_process_with_the_cycle_that_brings_it_not_with_the_next_tick() -> None:
    process = '\n[[controller.process]]\nname = "WAITS"\nsteps = [ { input = 612 } ]\n'
    route = '\n[[route]]\nname = "wire"\nfrom = "io.probe"\nto = "rho3.fast.612"\n'
    contact = '\n[[io]]\nname = "probe"\ndevice = { type = "gpiochip", chip = "/dev/gpiochip0", input = 1 }\nsignal = "cell.safety_ok"\n'
    made = Host('kind = "rho3"\nboards = ["modular-i"]' + process, "P11 = [1, 2]", route + contact)
    control = made.host.control
    assert isinstance(control, RhoControl)
    made.probe(False)
    made.host.step(0)
    control.start("WAITS")

    def turn(now: int) -> int:
        """As the cycle's wake-up does it; how often the control was stepped."""
        before = made.steps
        made.bridge.step(now)
        made.host.inputs_came(now)
        return made.steps - before

    turn(1)
    assert turn(2) == 0 and control.processes.processes, "nothing has changed, it waits"
    made.probe(True)
    assert turn(3) == 1 and control.value("rho3.fast.612") == 1
    assert not control.processes.processes, "its last step is done"
    assert turn(4) == 0
