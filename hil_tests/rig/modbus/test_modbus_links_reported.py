"""What the journal and the page are given of Modbus devices: never reached, refused reads and writes, lost and back; over real sockets."""

import asyncio
import json
import pathlib
import time
from collections.abc import Callable, Coroutine
from typing import Any

from gateway.links.modbus.client import Device, Group, Kind, Link, ModbusClient, write_bits_pdu
from gateway.runtime.journal import Journal
from gateway.services.modbus_links import LinkReports
from gateway.services.status_size import fitted
from gateway.web.line_view import asked_links
from hil_tests.lab.running.cell_running import free_port
from hil_tests.lab.running.modbus_running import Running
from protocols.base.machine import ms
from protocols.modbus.orders import Refused


def client_of(port: int, file: pathlib.Path) -> tuple[ModbusClient, LinkReports, Callable[[], list[str]]]:
    link = Link(f"tcp://127.0.0.1:{port}")
    reports = LinkReports(Journal(file, "services"), "Modbus client oven", link)
    client = ModbusClient(link, [Device("tank", timeout=ms(200))], reports.device, on_refused=reports.read)
    return client, reports, lambda: [json.loads(line)["text"] for line in file.read_text().splitlines()]


async def until(holds: Callable[[], object], what: str) -> None:
    end = time.monotonic() + 15
    while not holds():
        assert time.monotonic() < end, f"not within 15 s: {what}"
        await asyncio.sleep(0.02)


def run(play: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(play())


def test_a_read_that_is_refused_is_reported_once_and_when_it_is_read_again(tmp_path: pathlib.Path) -> None:
    async def play() -> None:
        with Running() as running:
            view = running.view
            client, reports, told = client_of(running.port, tmp_path / "journal")
            client.start()
            values: list[Any] = []
            client.poll(Group("0", "tank", Kind.HOLDING_REGISTERS, 60_000, 4, ms(20)), lambda found, now: values.append(found))
            await until(lambda: len(values) > 5, "it is refused some times")
            words, why = "Modbus client oven: device tank, holding registers 60000..60003", "exception 02h illegal data address"
            assert told() == ["Modbus client oven: device tank answers", f"{words}: the read is refused: {why}"]
            row = asked_links({"modbus_clients": {"oven": reports.status(client)}})[0]
            assert row["alive"] and [words[0] for words in row["refused"]] == [f"tank, holding registers 60000..60003: {why}"]
            view.words[Kind.HOLDING_REGISTERS].extend([0] * (60_010 - len(view.words[Kind.HOLDING_REGISTERS])))
            await until(lambda: values[-1] is not None, "it is read")
            assert told()[2:] == [f"{words}: read again"]
            assert asked_links({"modbus_clients": {"oven": reports.status(client)}})[0]["refused"] == []
            client.close()

    run(play)


def test_a_write_that_is_refused_is_reported_with_what_was_to_be_written(tmp_path: pathlib.Path) -> None:
    async def play() -> None:
        with Running() as running:
            client, reports, told = client_of(running.port, tmp_path / "journal")
            client.start()
            await until(lambda: client.connected, "connected")
            found: list[object] = []
            client.order("tank", write_bits_pdu(60_000, [True]), found.append)
            await until(lambda: found, "an answer")
            assert isinstance(found[0], Refused)
            for _ in range(3):
                reports.written("tank", "valve to coil 60000", "exception 02h illegal data address")
            reports.written("tank", "valve to coil 60000", "")
            assert told()[1:] == [
                "Modbus client oven: device tank, valve to coil 60000: the write is refused: exception 02h illegal data address",
                "Modbus client oven: device tank, valve to coil 60000: written again",
            ]
            client.close()

    run(play)


def test_a_device_that_was_never_reached_is_reported_and_when_it_is_there(tmp_path: pathlib.Path) -> None:
    async def play() -> None:
        port = free_port()
        client, reports, told = client_of(port, tmp_path / "journal")
        client.start()
        client.poll(Group("0", "tank", Kind.HOLDING_REGISTERS, 0, 1, ms(50)), lambda found, now: None)
        start = time.monotonic_ns()
        await until(lambda: "refused" in client.why.lower(), "nobody listens there")
        reports.step(client, start)
        reports.step(client, start + ms(2999))
        assert told() == [], "a device that boots with the cell is not a finding"
        for _ in range(3):
            reports.step(client, start + ms(3000))
        assert len(told()) == 1 and told()[0].startswith(f"Modbus client oven: no connection to tcp://127.0.0.1:{port}: ")
        row = asked_links({"modbus_clients": {"oven": reports.status(client)}})[0]
        assert not row["alive"] and not row["connected"] and "refused" in row["why"][0].lower()
        with Running(port=port):
            await until(lambda: client.devices["tank"].alive, "it answers")
            reports.step(client, start + ms(4000))
            assert f"Modbus client oven: connected to tcp://127.0.0.1:{port}" in told()
            client.close()

    run(play)


def test_a_status_too_long_for_its_region_stays_json_and_names_what_is_left_out() -> None:
    status: dict[str, object] = {"command_sources": [1, 2], "modbus_clients": {"oven": "x" * 500}, "modbus_couplers": {"a": "y" * 20}}
    whole = json.loads(fitted(status, 1000))
    assert whole == status and len(fitted(status, 1000)) == 1000
    assert json.loads(fitted(status, 200)) == {
        "command_sources": [1, 2],
        "modbus_couplers": {"a": "y" * 20},
        "too_long": ["modbus_clients"],
    }
