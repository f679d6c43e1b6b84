"""`axisgate modbus probe`: nothing against our own server, the known points against somebody else's; `--find` in every type and order."""

import asyncio
import json
import pathlib
import socketserver
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from gateway.commands.modbus import main
from gateway.conformance.modbus.probe import Prober, probe, search
from hil_tests.lab.running.modbus_running import Running
from hil_tests.lab.virtual.modbus_view import MemoryView
from hil_tests.rig.modbus.test_modbus_rtu import pymodbus_server
from hil_tests.unit.protocols.modbus.test_6_7_to_6_21_other_functions import WholeView
from protocols.modbus.finding import find
from protocols.modbus.numbers import ORDERS, encode_number
from protocols.modbus.probing import Verdict, cases
from protocols.modbus.view import Kind


def verdicts(port: int, wait_s: float = 1.0, **more: bool) -> dict[str, tuple[Verdict, str]]:
    results = probe(Prober("127.0.0.1", port, wait_s), cases(**more), lambda result: None)
    return {result.case.name: (result.verdict, result.why) for result in results}


def test_it_finds_nothing_on_our_server() -> None:
    with Running(view=WholeView()) as running:
        found = verdicts(running.port, writes=True)
        assert {name: told for name, told in found.items() if told[0] is not Verdict.PASS} == {} and len(found) > 60
        assert running.view.words[Kind.HOLDING_REGISTERS][:125] == [0] * 125 and not any(running.view.bits[Kind.COILS])


def test_the_command_reports_as_json_and_html(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Running(view=WholeView()) as running:
        code = main(["probe", f"127.0.0.1:{running.port}", "--report", str(tmp_path / "ours")])
        assert (code, capsys.readouterr().out.splitlines()[-1]) == (0, "51 PASS, 0 not offered, 0 WARN, 0 FAIL")
        report = json.loads((tmp_path / "ours.json").read_text())
        assert report["counts"]["PASS"] == len(report["cases"]) == 51
        page = (tmp_path / "ours.html").read_text()
        assert page.count("<tr") == 52 and "not a certificate" in page
    assert main(["probe", f"127.0.0.1:{running.port}"]) == 3
    assert "no connection" in capsys.readouterr().err
    assert main(["probe", "here:there"]) == 2


def test_the_known_points_of_a_server_of_pymodbus() -> None:
    """serial-protocols 5.1, column P: found as it was measured (newer versions answer the ten requests)."""
    found: dict[str, tuple[Verdict, str]] = {}

    async def scene() -> None:
        async with pymodbus_server() as port:
            found.update(await asyncio.to_thread(verdicts, port, writes=True))

    asyncio.run(asyncio.wait_for(scene(), 100))
    assert found["FC 3: one of registers"][0] is Verdict.PASS
    assert found["FC 3: 0 registers"][0] is Verdict.FAIL and found["FC 41h, which does not exist"][0] is Verdict.FAIL
    assert found["one byte per segment"][0] is Verdict.PASS


@contextmanager
def naughty(answer: Callable[[bytes], bytes]) -> Iterator[int]:
    """A server of one line: whatever comes is answered by `answer`."""

    class Handler(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            while data := self.request.recv(4096):
                self.request.sendall(answer(data))

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield server.server_address[1]
        server.shutdown()
        thread.join(10)


def test_a_server_that_answers_everything_is_warned_about_and_blamed() -> None:
    def always(data: bytes) -> bytes:
        return data[:2] + b"\0\0\0\5" + data[6:8] + b"\2\0\0" if len(data) >= 8 else b""

    with naughty(always) as port:
        found = verdicts(port, 0.4)
    assert found["FC 3: one of registers"][0] is Verdict.PASS
    assert found["FC 3: a byte too many"] == (Verdict.WARN, "does not look at the length")
    assert found["unit that does not exist"] == (Verdict.WARN, "answers for any unit id")
    assert found["protocol identifier 1"][0] is Verdict.WARN
    assert found["FC 3: 126 registers"][0] is Verdict.FAIL and found["FC 41h, which does not exist"][0] is Verdict.FAIL
    assert found["ten requests in one segment"] == (Verdict.FAIL, "1 of 10 requests answered")


def test_a_server_that_mixes_up_transactions_fails() -> None:
    with naughty(lambda data: b"\0\1\0\0\0\5\1\3\2\0\0") as port:
        assert verdicts(port, 0.4)["FC 3: one of registers"] == (Verdict.FAIL, "transaction 0001h answered, 1234h asked")


def test_a_server_without_a_function_does_not_offer_it() -> None:
    def bare(data: bytes) -> bytes:
        return data[:2] + b"\0\0\0\3" + data[6:7] + bytes((data[7] | 0x80, 1))

    with naughty(bare) as port:
        found = verdicts(port, 0.4)
    assert found["FC 17"][0] is Verdict.NOT_OFFERED and found["FC 41h, which does not exist"][0] is Verdict.PASS


# ----------------------------------------------------------------------------------------------------------------- find


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(
    "type_, value", [("REAL", 21.37), ("INT32", -123456), ("UINT32", 4_000_000_000), ("LREAL", -0.125), ("INT16", -77)]
)
def test_a_value_is_found_in_every_type_and_order(type_: str, value: float, order: str) -> None:
    view = MemoryView(size=700)
    words = encode_number(value, type_, order)
    view.words[Kind.INPUT_REGISTERS][613 : 613 + len(words)] = words
    with Running(view=view) as running:
        found, read = search(Prober("127.0.0.1", running.port), value, 1, 600, 720)
    assert any((place.table, place.address, place.type) == ("input", 613, type_) and place.reference == "30614" for place in found)
    same = {encode_number(value, type_, each) for each in ORDERS}
    assert len(same) < 4 or {place.order for place in found if place.type == type_ and place.address == 613} == {order}
    assert read == 200, "both tables, from 600 to their end"


def test_a_value_kept_as_tenths_is_found_and_a_display_may_be_rounded() -> None:
    found = find(21.5, "holding", {7: 215, 8: 9})
    assert [(place.address, place.type, place.factor, place.reference) for place in found] == [(7, "UINT16", 10, "40008")]
    real = dict(enumerate(struct.unpack(">2H", struct.pack(">f", 21.4983)), 3))
    assert [(place.address, place.type) for place in find(21.5, "holding", real)] == [(3, "REAL")]
    assert find(21.5, "holding", {1: 21, 2: 5}) == []


def test_the_command_says_where(capsys: pytest.CaptureFixture[str]) -> None:
    view = MemoryView(size=50)
    view.words[Kind.HOLDING_REGISTERS][9] = 4711
    with Running(view=view) as running:
        at = f"127.0.0.1:{running.port}"
        assert main(["probe", at, "--find", "4711", "--last", "49"]) == 0
        assert capsys.readouterr().out.splitlines()[0] == "holding register 9 (40010): UINT16 ABCD: 4711", "the likeliest first"
        assert main(["probe", at, "--find", "4712", "--last", "49"]) == 1
        assert "none of the 100 registers" in capsys.readouterr().err
