"""The command source of an RK512 line, built alone: blocks, RC inputs, jobs it refuses, its handshake bits."""

import struct
from collections.abc import Iterator
from dataclasses import replace

import pytest

from gateway.pure.arbitration.command_block import COMMAND_WORDS, TOGGLE, Code
from gateway.pure.image.records.cell import Quality
from gateway.services.sources.rk512 import Rk512Source
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench
from hil_tests.unit.gateway.pure.arbitration.controls.bench import cell_with
from protocols.rk512.header import ErrorNumber

OWNED = 8  # RC input byte


@pytest.fixture
def bench() -> Iterator[SourceBench]:
    made = SourceBench(DEMO)
    made.publish()
    yield made
    made.close()


def test_a_send_to_a_declared_block_becomes_commands_of_this_source(bench: SourceBench) -> None:
    source = Rk512Source(bench.context("plc1"), DEMO.line[0])
    assert source.write(10, 0, b"\x00\x00") is None, "the first telegram only says where the bits are"
    assert source.write(10, 0, b"\x00\x01") is None
    assert bench.dispatcher.owner == source.number and bench.dispatcher.source(source.number).last is not None
    assert source.read(11, 0, 1) != b"" and source.move_bit("busy") is False


def test_a_block_no_table_declares_is_refused_and_nothing_is_commanded(bench: SourceBench) -> None:
    source = Rk512Source(bench.context("plc1"), DEMO.line[0])
    assert source.write(99, 0, b"\0\0") is ErrorNumber.BLOCK and source.write(11, 0, b"\0\0") is ErrorNumber.NOT_ALLOWED
    assert bench.dispatcher.source(source.number).last is None and not bench.image.changed


def test_rc_inputs_are_taken_where_the_line_owns_them_and_marked_good() -> None:
    cell = cell_with('kind = "reis"')
    bench = SourceBench(cell)
    source = Rk512Source(bench.context("rack"), cell.line[0])
    mine = next(octet for octet, number in bench.image.owners.items() if number == source.number)
    free = next(octet for octet in range(88) if octet not in bench.image.owners)
    assert source.write_inputs(free, b"\1") is ErrorNumber.NOT_ALLOWED and not bench.image.changed
    assert source.write_inputs(mine, b"\x5a") is None
    assert bench.image.changed and bench.image.inputs.values[mine] == 0x5A and bench.image.inputs.quality[mine] == Quality.GOOD
    bench.close()


def test_what_a_tool_writes_as_the_plc_goes_on_at_once(bench: SourceBench) -> None:
    source = Rk512Source(bench.context("plc1"), DEMO.line[0])
    assert source.write_as_plc(10, 0, b"\0\0") == "" and bench.passed_on == 1
    assert "refused with RK512 error" in source.write_as_plc(99, 0, b"\0\0")


def test_its_blocks_are_values_for_the_rest_of_the_services(bench: SourceBench) -> None:
    source = Rk512Source(bench.context("plc1"), DEMO.line[0])
    source.write(10, 2, struct.pack(">h", -125))
    assert bench.values.read("DB10.DW2") == -125 and bench.values.read("DB10.DL2") == 0xFF
    assert [bench.values.read(f"DB10.D2.{bit}") for bit in (0, 1, 15)] == [1, 1, 1]
    assert bench.values.serving(10)[0] is source
    with pytest.raises(KeyError):
        bench.values.write("DB10.DW2", 1, 0, "route")
    bench.values.write("DB11.DW20", 7, 0, "route")
    assert bench.values.read("DB11.DW20") == 7


def test_without_blocks_of_its_own_db_10_is_the_command_block() -> None:
    cell = replace(DEMO, db=(), handshake={})
    bench = SourceBench(cell)
    bench.publish()
    source = Rk512Source(bench.context("plc1"), cell.line[0])
    words = [0] * COMMAND_WORDS
    assert source.write(10, 0, struct.pack(f">{COMMAND_WORDS}H", *words)) is None
    words[0] = TOGGLE | Code.REQUEST_CONTROL
    assert source.write(10, 0, struct.pack(f">{COMMAND_WORDS}H", *words)) is None
    assert bench.dispatcher.owner == source.number
    bench.close()
