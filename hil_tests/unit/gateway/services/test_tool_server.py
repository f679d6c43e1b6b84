"""The server of the tools, built alone: whatever a request does, its connection stays and gets a sentence."""

import asyncio
import json
import pathlib
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from types import FrameType
from typing import Any

import pytest

from gateway.pure.cell.cell import Cell
from gateway.pure.image.error_list import ErrorList
from gateway.runtime.journal import Journal
from gateway.services.canopen import CanopenServices
from gateway.services.contacts import DigitalContacts
from gateway.services.context import RunContext
from gateway.services.controller_host import ControllerHost
from gateway.services.page_interface import PageInterfaces
from gateway.services.part_context import PartContext
from gateway.services.plant_addresses import PlantAddresses
from gateway.services.tool_server import LONGEST, Variables
from gateway.services.value_directory import Reader
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench
from protocols.base.machine import Ns
from protocols.telegrams.fields import Value

BROKEN = b'{"op": "get", "address": "io.broken"}\n'
GOOD = b'{"op": "names"}\n'


def joined(name: str) -> dict[str, object] | None:
    if name == "io.broken":
        raise IndexError("no such place")
    return {"value": object()} if name == "io.strange" else None


@pytest.fixture
def bench() -> Iterator[SourceBench]:
    made = SourceBench(DEMO)
    made.publish()
    yield made
    made.close()


def server_of(bench: SourceBench, journal: pathlib.Path) -> Variables:
    old: Cell = bench.run.cell
    run = RunContext(old, bench.plan, Journal(journal, "services"), bench.run.recorder, bench.run.clock)
    canopen = CanopenServices(bench.plan, bench.fds, run.journal.write)
    contacts = DigitalContacts(run, bench.image, bench.values, canopen.coupler_fault, {})
    tools = PageInterfaces(run, bench.image, bench.values, bench.dispatcher, canopen, contacts, [])
    context = PartContext(run, bench.image, bench.values, bench.dispatcher)
    host = ControllerHost(context, ErrorList(), lambda: 0, lambda jobs: None, {}, 0)
    return Variables(context, tools, contacts, host, PlantAddresses(old, bench.image, bench.values), joined, dict)


def told(bench: SourceBench, folder: pathlib.Path, *requests: bytes) -> list[dict[str, Any]]:
    """Answers on one connection, one after the other."""

    async def talk() -> list[dict[str, Any]]:
        server = await server_of(bench, folder / "journal").listen(folder / "tools.sock")
        reader, writer = await asyncio.open_unix_connection(folder / "tools.sock", limit=1 << 20)
        found = []
        for request in requests:
            writer.write(request)
            found.append(json.loads(await asyncio.wait_for(reader.readline(), 5)))
        writer.close()
        server.close()
        return found

    return asyncio.run(talk())


def test_what_goes_wrong_inside_is_reported_and_journalled_once(bench: SourceBench, tmp_path: pathlib.Path) -> None:
    first, again, after = told(bench, tmp_path, BROKEN, BROKEN, GOOD)
    assert first == again == {"error": "the request failed: IndexError: no such place"} and "cell.ready" in after["names"]
    assert (tmp_path / "journal").read_text().count("a tool's request failed: IndexError: no such place") == 1


def test_an_answer_that_is_no_json_is_reported(bench: SourceBench, tmp_path: pathlib.Path) -> None:
    strange, after = told(bench, tmp_path, b'{"op": "get", "address": "io.strange"}\n', GOOD)
    assert strange["error"].startswith("the request failed: TypeError: ") and "names" in after


@pytest.mark.parametrize("size", [LONGEST, LONGEST + 1, 3 * LONGEST, 20 * LONGEST])
def test_a_request_too_long_is_reported_and_the_next_one_answered(bench: SourceBench, tmp_path: pathlib.Path, size: int) -> None:
    long, after = told(bench, tmp_path, b"x" * size + b"\n", GOOD)
    assert "error" in long and "names" in after


@pytest.mark.parametrize("request_", [b"[" * 4000 + b"\n", b"\xff\xfe\n", b"\n", b"[1]\n", b"7\n", b'{"op": "get"}\n', b'{"op": [1]}\n'])
def test_junk_is_reported(bench: SourceBench, tmp_path: pathlib.Path, request_: bytes) -> None:
    junk, after = told(bench, tmp_path, request_, GOOD)
    assert "error" in junk and "names" in after


def test_a_name_without_a_value_so_far_is_a_name(bench: SourceBench, tmp_path: pathlib.Path) -> None:
    """A part lists it, and its partner has sent nothing yet: the name is right."""

    class Scale:
        def names(self) -> Iterable[str]:
            return ("scale.weight",)

        def read(self, name: str, reader: Reader | None) -> Value:
            raise KeyError(name)

        def valid(self, name: str) -> bool:
            return False

        def write(self, name: str, value: Value, now: Ns, by: str) -> None:
            raise KeyError(name)

    bench.values.register(Scale())
    answers = told(bench, tmp_path, b'{"op": "get", "address": "scale.weight"}\n', b'{"op": "get", "address": "scale.wait"}\n')
    assert answers[0] == {"address": "scale.weight", "place": "scale.weight", "value": "never written"}
    assert answers[1]["error"] == "scale.wait: no such name, did you mean scale.weight?; axisgate var lists them"


def test_reading_a_word_loads_nothing_while_the_cell_runs() -> None:
    """The services are silent meanwhile, and the supervisor ends them: rules of cell files bring in every control and language."""
    rooms = ("gateway.checks", "gateway.pure.languages")
    program = f"import sys, gateway.services.tool_server; print([n for n in sys.modules if n.startswith({rooms})])"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    source = pathlib.Path(sys.modules[Variables.__module__].__file__ or "").read_text()
    assert "\n    from " not in source and "\n    import " not in source, "an import in a function runs while the cell does"


def test_everybody_may_stop_a_program_and_who_holds_control_alone_may_start_one(bench: SourceBench, tmp_path: pathlib.Path) -> None:
    server = server_of(bench, tmp_path / "journal")
    assert server.answer(b'{"op": "tool", "code": "request_control"}', "one")["state"] == "DONE"
    start, stop = (server.answer(json.dumps({"op": "process", "do": do, "name": "P"}).encode(), "two") for do in ("start", "stop"))
    assert str(start["error"]).startswith("not owner") and str(stop["error"]).startswith("no programs: "), (start, stop)


def test_however_many_tools_ask_one_of_them_is_answered_a_turn(
    bench: SourceBench, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """64 tools with a request each were 64 answers between two signs of life."""
    tools, turn, turns = 40, 0, []
    answer = Variables.answer

    def counted(self: Variables, line: bytes, connection: object = "") -> dict[str, object]:
        turns.append(turn)
        return answer(self, line, connection)

    monkeypatch.setattr(Variables, "answer", counted)

    def count() -> None:
        nonlocal turn
        turn += 1
        asyncio.get_running_loop().call_soon(count)

    async def ask_together() -> None:
        server = await server_of(bench, tmp_path / "journal").listen(tmp_path / "tools.sock")
        count()
        links = [await asyncio.open_unix_connection(tmp_path / "tools.sock") for _ in range(tools)]
        for _ in range(3):
            for _, writer in links:
                writer.write(GOOD)
            for reader, _ in links:
                assert b"names" in await asyncio.wait_for(reader.readline(), 20)
        for _, writer in links:
            writer.close()
        server.close()

    asyncio.run(ask_together())
    assert len(turns) == 3 * tools
    assert max(Counter(turns).values()) == 1, Counter(turns).most_common(3)


def test_a_name_that_is_unknown_costs_a_large_cell_no_more_than_a_small_one(bench: SourceBench, tmp_path: pathlib.Path) -> None:
    """It was compared with all names there are: 90 ms for 2,700 of them."""
    server, calls = server_of(bench, tmp_path / "journal"), 0

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += event == "call"

    bench.values.register(ManyNames())
    sys.setprofile(count)
    try:
        found = server.answer(b'{"op": "get", "address": "plant.valve_0123_opem"}')
    finally:
        sys.setprofile(None)
    assert "did you mean plant.valve_01" in str(found["error"])
    assert calls < 20_000, f"{calls} calls"


class ManyNames:
    def names(self) -> Iterable[str]:
        return [f"plant.valve_{number:04d}_open" for number in range(9000)]

    def read(self, name: str, reader: object) -> float:
        raise KeyError(name)

    def valid(self, name: str) -> bool:
        return False

    def write(self, name: str, value: object, now: int, by: str) -> None:
        raise KeyError(name)
