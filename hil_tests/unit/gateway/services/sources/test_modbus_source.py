"""The command source of a Modbus server, built alone: its view, what its clients write, what they read."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from gateway.pure.arbitration.command_block import COMMAND_WORDS, TOGGLE, Code
from gateway.pure.cell.modbus import ModbusRegisters
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Quality
from gateway.pure.modbus.rho3_view import BLOCK_AT
from gateway.services.sources.modbus import ModbusSource
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench
from protocols.modbus.view import ExceptionCode, Kind

BYTE = 3  # RC inputs the server of the demo owns


@pytest.fixture
def bench() -> Iterator[SourceBench]:
    made = SourceBench(DEMO)
    made.publish()
    yield made
    made.close()


def source_of(bench: SourceBench) -> ModbusSource:
    source = ModbusSource(bench.context("plc2"))
    source.listen(next(modbus for modbus in bench.run.cell.modbus if modbus.name == "plc2"))
    return source


def test_a_coil_it_owns_is_an_rc_input_that_goes_on_at_once(bench: SourceBench) -> None:
    source = source_of(bench)
    assert source.view.write_bits(8 * BYTE, [True]) is None
    assert bench.image.input_bit(8 * BYTE) and bench.image.inputs.quality[BYTE] == Quality.GOOD
    assert bench.image.changed and bench.passed_on == 1
    assert source.view.write_bits(8 * 9, [True]) is not None and bench.passed_on == 1, "byte 9 is not its own"


def test_command_words_reach_the_dispatcher_and_the_answer_is_fresh(bench: SourceBench) -> None:
    source = source_of(bench)
    words = [0] * COMMAND_WORDS
    source.view.write_words(BLOCK_AT, words)
    words[0] = TOGGLE | Code.REQUEST_CONTROL
    assert source.view.write_words(BLOCK_AT, words) is None
    assert bench.dispatcher.owner == source.number and source.in_control
    assert source.row()["state"] == CommandState.DONE.name and bench.passed_on == 2


def test_its_registers_are_values_by_name() -> None:
    modbus = next(each for each in DEMO.modbus if each.name == "plc2")
    tables = (ModbusRegisters(at=300, from_="cell.motion", type="UINT16"), ModbusRegisters(at=301, from_="cell.control", type="UINT16"))
    made = SourceBench(replace(DEMO, modbus=(replace(modbus, registers=tables),)))
    made.publish(motion=3)
    source = source_of(made)
    assert source.view.read_words(Kind.HOLDING_REGISTERS, 300, 2) == [3, 0]
    made.dispatcher.control.request(source.number, at_rest=True)
    assert source.view.read_words(Kind.HOLDING_REGISTERS, 300, 2) == [3, 1], "this very source is in control"
    made.close()


def test_the_first_server_is_what_tools_read_registers_from(bench: SourceBench) -> None:
    source = source_of(bench)
    assert bench.values.views == [source.view]
    assert source.view.read_bits(Kind.COILS, 60_000, 1) is ExceptionCode.ILLEGAL_DATA_ADDRESS
