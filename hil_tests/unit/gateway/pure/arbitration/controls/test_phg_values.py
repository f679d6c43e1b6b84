"""PHG 2000 variables of a running control by name.  Source: rho 3 Releases L9288-9470; AX-496."""

import pathlib
import tempfile
from typing import Any

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.faults import CellFaults
from gateway.pure.controllers.rho3.functions.system_variables import VariableError
from gateway.pure.controllers.rho3.pendant.catalogue import coded_index, variable_of
from gateway.pure.modbus.registers import type_of
from hil_tests.lab.partners.signal_plc import signal_cell
from hil_tests.unit.gateway.pure.arbitration.controls.bench import ControlBench, cell_with

PROCESS = 'kind = "rho3"\n[[controller.process]]\nname = "PICK"\nsteps = [ { to = { A1 = 40.0 }, speed = "50 %" } ]'
REGISTERS = """
[[modbus.registers]]
at = 2000
from = "{name}"
"""


@pytest.fixture
def bench() -> ControlBench:
    made = ControlBench(cell_with(PROCESS))
    made.cycle(3)
    return made


def read(bench: ControlBench, name: str) -> Any:
    """Its value, or what is said."""
    try:
        return bench.rho3.pendant.phg.read(name)
    except VariableError as fault:
        return str(fault)


@pytest.mark.requirement("RHO-PHG-01", by="gateway.pure.controllers.rho3.signals.phg_values:PhgValues.read")
def test_signals_and_positions_of_the_running_control(bench: ControlBench) -> None:
    bench.put(85)
    assert [read(bench, "phg.33026.85"), read(bench, "phg.33026.84"), read(bench, "phg.33029.10")] == [1, 0, 0x20]
    bench.control.write_flags(4, b"\x81")
    assert [read(bench, "phg.33027.39"), read(bench, "phg.33030.4"), read(bench, "phg.33033.3")] == [1, 0x81, 0x8100]
    assert read(bench, "phg.33025.107") == 1, "run-up finished is an RC output, an input of the PIC"
    axis = bench.rho3.view.cell.axes[1]
    axis.actual, axis.set, axis.lag = 0.0125, 0.013, 0.0005
    assert [read(bench, f"phg.{code}.1.2") for code in (33282, 33281, 33293)] == pytest.approx([12.5, 13.0, 0.5])
    assert read(bench, "phg.33282.2") == pytest.approx(12.5) and read(bench, "phg.33291.1.2") == "A2"
    assert [read(bench, "phg.33289.1"), read(bench, "phg.33290.1"), read(bench, "phg.33297")] == [2000.0, -2000.0, 2]


@pytest.mark.requirement("RHO-PHG-02", by="gateway.pure.controllers.rho3.pendant.catalogue:variable_of")
def test_a_name_of_three_numbers_is_a_coded_index() -> None:
    found = [variable_of(name)[1] for name in ("phg.33282.2.3", "phg.33282.7", "phg.33793", "phg.33282.33025")]
    assert found == [32768 + 515, 7, 0, coded_index(1, 1)]


@pytest.mark.requirement("RHO-PHG-03", by="gateway.pure.controllers.rho3.signals.phg_values:PhgValues.write")
def test_factors_outputs_and_processes_are_written_and_act(bench: ControlBench) -> None:
    phg = bench.rho3.pendant.phg

    def written(name: str, value: float | str) -> str:
        try:
            phg.write(name, value)
        except VariableError as fault:
            return str(fault)
        return "done"

    assert [written("phg.33793", 0.25), written("phg.33803.1", 0.5)] == ["done", "done"]
    assert bench.rho3.factor_table.acting(1).velocity == 0.25 and bench.rho3.factor_table.acting(1).acceleration == 0.5
    assert [read(bench, "phg.33793"), read(bench, "phg.33803.1")] == [0.25, 0.5]
    assert "is only read" in written("phg.33028.0", 1) and "0 to 1" in written("phg.33793", 2)
    assert written("phg.33038.48", 0x81) == "done"
    bench.cycle()
    assert [bench.output(384), bench.output(385), bench.output(391)] == [True, False, True]
    assert "the control writes it itself" in written("phg.33037.66", 1)
    bench.rho3.start("PICK")
    bench.cycle()
    assert [read(bench, "phg.34305"), read(bench, "phg.34309.1"), written("phg.34310", 1), read(bench, "phg.34316")] == [
        1,
        "PICK",
        "done",
        "PICK",
    ]
    assert written("phg.34322", 1) == "done" and read(bench, "phg.34305") == 0


def test_the_global_factor_slows_the_next_move_and_control_reset_brings_it_back(
    bench: ControlBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    ordered: list[float] = []
    command = bench.dispatcher.command

    def heard(source: int, order: Any, now: int, **more: Any) -> Any:
        ordered.append(order.velocity)
        return command(source, order, now, **more)

    monkeypatch.setattr(bench.dispatcher, "command", heard)
    bench.rho3.pendant.phg.write("phg.33793", 0.5)
    bench.put(23)
    bench.rho3.start("PICK")
    bench.cycle()
    assert 0.25 in ordered, "50 % of the step, 0.5 of the factor"
    bench.pulse(19)
    assert read(bench, "phg.33793") == 1.0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("phg.33285.1", "this control has none"),
        ("phg.34816.1", "this control has none"),
        ("phg.33284.1", "no such variable"),
        ("phg.33282.3", "axis 3: 1 to 2"),
        ("phg.33282.1.0", "1..127 and 1..255"),
    ],
)
def test_what_is_not_there_is_said_and_is_no_zero(bench: ControlBench, name: str, words: str) -> None:
    assert words in str(read(bench, name))


@pytest.mark.parametrize("name", ["phg.x", "phg.1.2.3.4"])
def test_what_is_no_name_of_a_variable_is_refused(bench: ControlBench, name: str) -> None:
    with pytest.raises(KeyError):
        bench.rho3.pendant.phg.read(name)


def test_registers_take_the_base_type() -> None:
    assert [type_of(name) for name in ("phg.33282.1.2", "phg.33034.0", "phg.33026.85", "axis.A1.actual")] == [
        "REAL",
        "UINT32",
        "UINT16",
        "REAL",
    ]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("phg.33282.1.2", ""),
        ("phg.33793", ""),
        ("phg.33282.3.1", "kinematic 3: 1 to 1"),
        ("phg.33291.1", "a text has no number"),
        ("phg.33", "no such variable"),
        ("phg.a", "phg.CODE"),
    ],
)
def test_check_tries_each_name_at_the_control(name: str, words: str) -> None:
    def faults(text: str) -> str:
        try:
            load_cell("cell.toml", text)
        except CellFaults as found:
            return "\n".join(map(str, found.faults))
        return ""

    cell = cell_text()
    told = faults(cell.replace("[[bus]]", REGISTERS.format(name=name) + "[[bus]]", 1))
    block = faults(cell.replace('from = "MD 40"', f'from = "{name}"').replace('type = "DH", from', 'type = "REAL", from'))
    assert (told, block) == ("", "") if not words else words in told and words in block


def cell_text() -> str:
    with tempfile.TemporaryDirectory() as folder:
        return pathlib.Path(signal_cell(pathlib.Path(folder), "rack", 'kind = "rho3"')).read_text()
