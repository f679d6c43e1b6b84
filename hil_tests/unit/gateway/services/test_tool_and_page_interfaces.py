"""The command sources of tools and page, built alone: control belongs to a connection, forces, enabling inputs of a simulation."""

from collections.abc import Iterator

import pytest

from gateway.pure.cell.web import PAGE_SOURCE
from gateway.services.canopen import CanopenServices
from gateway.services.contacts import DigitalContacts
from gateway.services.page_interface import PageInterfaces
from gateway.services.sources.rk512 import Rk512Source
from gateway.services.tool_interface import SILENCE, TOOL_SOURCE, ToolInterface
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench

CONTROL: dict[str, object] = {"op": "tool", "code": "request_control"}


@pytest.fixture
def bench() -> Iterator[SourceBench]:
    made = SourceBench(DEMO)
    made.publish()
    yield made
    made.close()


def masters(bench: SourceBench) -> CanopenServices:
    return CanopenServices(bench.plan, bench.fds, bench.run.journal.write)


def tool_of(bench: SourceBench) -> ToolInterface:
    return ToolInterface(bench.run, bench.image, bench.dispatcher, masters(bench))


def pages_of(bench: SourceBench) -> PageInterfaces:
    canopen = masters(bench)
    contacts = DigitalContacts(bench.run, bench.image, bench.values, canopen.coupler_fault, {})
    sources = [Rk512Source(bench.context("plc1"), DEMO.line[0])]
    return PageInterfaces(bench.run, bench.image, bench.values, bench.dispatcher, canopen, contacts, sources)


def test_control_belongs_to_the_connection_that_asked_and_ends_with_it(bench: SourceBench) -> None:
    tool = tool_of(bench)
    assert (tool.answer(CONTROL, "one") or {})["state"] == "DONE" and bench.dispatcher.owner == TOOL_SOURCE
    refused = tool.answer(CONTROL, "two") or {}
    assert (refused["state"], refused["words"], refused["detail"]) == ("REFUSED", "NOT_OWNER", "another commissioning tool has it")
    assert tool.held_by_another("two") and not tool.held_by_another("one")
    tool.closed("one")
    tool.wake(1)
    assert bench.dispatcher.owner != TOOL_SOURCE and bench.passed_on > 0


def test_a_tool_silent_for_a_second_is_gone(bench: SourceBench) -> None:
    tool = tool_of(bench)
    tool.answer(CONTROL, "one")
    tool.wake(bench.now + SILENCE)
    assert tool.alive
    tool.wake(bench.now + SILENCE + 1)
    assert not tool.alive


def test_enabling_inputs_are_set_by_a_tool_in_a_simulation_only(bench: SourceBench) -> None:
    assert tool_of(bench).answer({"op": "permit"}, "one") == {"ok": True}
    assert all(bench.image.input_bit(bit) for bit in range(24, 29)) and bench.image.changed
    metal = SourceBench(DEMO, simulated=False)
    assert "error" in (tool_of(metal).answer({"op": "permit"}, "one") or {}) and not metal.image.changed
    metal.close()


def test_the_page_looks_at_blocks_and_forces_inputs(bench: SourceBench) -> None:
    pages = pages_of(bench)
    look = pages.answer({"op": "look", "source": PAGE_SOURCE}) or {}
    assert isinstance(look["blocks"], dict) and look["blocks"]["10"]["line"] == "plc1"
    assert pages.answer({"op": "force_input", "source": PAGE_SOURCE, "bit": 40, "value": 1}) == {
        "ok": True, "forced": {"40": 1}, "forced_words": {},
    }  # fmt: skip
    assert bench.image.input_bit(40) and bench.values.read("A 5.0") == 1 and bench.passed_on == 1
    pages.answer({"op": "unforce_input", "source": PAGE_SOURCE, "bit": 40})
    assert not bench.image.input_bit(40)


def test_the_page_forces_a_word_of_a_block_of_a_line(bench: SourceBench) -> None:
    pages = pages_of(bench)
    answer = pages.answer({"op": "force_words", "source": PAGE_SOURCE, "block": 11, "words": [[20, 0xFFFF, 0x1234]]}) or {}
    assert answer["forced_words"] == {"11:20": 0xFFFF} and bench.values.filled_block(11) is not None
    assert (bench.values.filled_block(11) or b"")[40:42] == b"\x12\x34"


def test_what_passed_is_asked_of_each_source_by_its_medium(bench: SourceBench) -> None:
    assert pages_of(bench).answer({"op": "tap", "source": PAGE_SOURCE, "since": {}}) == {"lines": {}, "modbus": {}}
