"""AX-611: control of the commissioning tools belongs to one connection and ends with it; reading is not a sign of life."""

import contextlib
import json
import pathlib
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.image.records.cell import Motion
from gateway.runtime.supervisor_client import ask
from gateway.services.tool_interface import MOST_SDO
from gateway.tools.client import ToolClient, ToolError, mask_of, simulated

CELL = load_cell("demo-402")
EVERY = mask_of(CELL, [axis.name for axis in CELL.axis])


@pytest.fixture(scope="module")
def first() -> Iterator[ToolClient]:
    with simulated("demo-402") as (client, _):
        client.wait_ready()
        client.take_over()
        client.command("enable", EVERY)
        client.command("reference", EVERY, timeout_s=120.0)
        yield client


@contextlib.contextmanager
def another() -> Iterator[ToolClient]:
    client = ToolClient("tool")
    try:
        yield client
    finally:
        client.close()


def until(holds: Callable[[], bool], what: str, seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, f"{what}: not within {seconds} s"
        time.sleep(0.02)


def motion(client: ToolClient) -> Motion:
    return Motion(int(str(client.ask("axes")["motion"])))


def owner(client: ToolClient) -> object:
    return client.ask("status")["owner"]


def far(client: ToolClient, to_low: bool) -> int:
    """A slow move that lasts; its job."""
    targets = [axis.limits.min + (axis.limits.max - axis.limits.min) * (0.1 if to_low else 0.9) for axis in CELL.axis]
    answer = client.ask("tool", code="ptp_absolute", mask=EVERY, velocity=0.02, targets=targets)
    assert answer["open"], answer
    until(lambda: motion(client) is Motion.RUNNING, "the axes move")
    return int(str(answer["job"]))


def in_control(client: ToolClient) -> None:
    client.take_over()
    if motion(client) is Motion.STOPPED:
        client.command("abandon")
    client.command("enable", EVERY)


def test_another_tool_is_not_owner_but_reads_and_stops(first: ToolClient) -> None:
    in_control(first)
    with another() as second:
        for code in ("request_control", "enable", "ptp_absolute", "override", "release_control", "fault_reset", "abandon"):
            answer = second.ask("tool", code=code, mask=EVERY, targets=[0.0] * len(CELL.axis))
            assert (answer["state"], answer["words"]) == ("REFUSED", "NOT_OWNER"), code
        with pytest.raises(ToolError, match="not owner"):
            second.sdo(CELL.axis[0].name, 0x6072, 0, (200).to_bytes(2, "little"))
        assert second.sdo(CELL.axis[0].name, 0x1018, 1)
        job = far(first, to_low=True)
        assert second.ask("job", job=job)["open"]
        second.command("stop")
        until(lambda: motion(first) is Motion.STOPPED, "everybody may stop")
    first.command("abandon")
    assert owner(first) == 90, "a reader that leaves takes nothing with it"


def test_reading_of_others_is_no_sign_of_life_of_the_one_in_control(first: ToolClient) -> None:
    in_control(first)
    job = far(first, to_low=False)
    with another() as second:
        until(lambda: second.ask("job", job=job)["state"] != "RUNNING" or motion(second) is not Motion.RUNNING, "stopped on the path", 4.0)
        until(lambda: motion(second) in (Motion.STOPPED, Motion.IDLE), "at rest")  # its enabling inputs ended with it: IDLE
        second.command("request_control")
        answer = first._asked("tool", {"code": "override"})
        assert answer["words"] == "NOT_OWNER", "the first one was silent for a second, and the axes rest"
        second.command("release_control")
    first._holds = False


def test_control_ends_with_its_connection_and_the_axes_stop(first: ToolClient) -> None:
    with another() as holder:
        in_control(holder)
        far(holder, to_low=True)
        began = time.monotonic()
    until(lambda: motion(first) is not Motion.RUNNING, "stops at once", 0.9)
    until(lambda: owner(first) == 0, "nobody is in control")
    assert time.monotonic() - began < 5.0
    in_control(first)


def test_sdo_requests_are_bounded_and_their_tickets_answered(first: ToolClient) -> None:
    in_control(first)
    tickets, refusals = list[int](), list[str]()
    for _ in range(300):
        try:
            tickets.append(int(str(first.ask("sdo", axis=CELL.axis[0].name, index=0x1018, sub=1)["ticket"])))
        except ToolError as error:
            refusals.append(str(error))
    assert tickets and refusals and all(f"{MOST_SDO} SDO requests are under way" in words for words in refusals)

    def over() -> bool:
        answer = first._asked("ticket", {"ticket": tickets[-1]})
        assert "error" not in answer, answer
        return "data" in answer

    until(over, "the last one is answered")
    assert first.sdo(CELL.axis[0].name, 0x1018, 1)
    with pytest.raises(ToolError, match="no such ticket"):
        first.ask("ticket", ticket=99999)


def test_a_command_that_starts_its_own_simulation_lets_it_wait_for_a_late_machine(first: ToolClient) -> None:
    """Else `program run --sim` reports drive faults of a busy laptop (AX-681)."""
    emulator = next(each for each in processes(first) if str(each["name"]).startswith("emulator-"))
    assert "--stretched" in emulator["command"], emulator


def test_the_processes_of_a_run_are_copies_of_their_supervisor_until_one_dies(first: ToolClient) -> None:
    """AX-1740: a copy is called by its module, a new Python by its program; none had to be started twice."""
    names = {str(each["name"]): pathlib.Path(f"/proc/{each['pid']}/comm").read_text().strip() for each in processes(first)}
    assert names["services"] == "services.loop" and names["cycle"] == "cycle.loop", names
    assert not [name for name, shown in names.items() if shown.startswith(("python", "axisgate"))], names
    assert not any(each["restarts"] for each in processes(first))


def test_a_copied_cycle_has_neither_the_services_nor_the_check_of_the_cell_in_its_memory(first: ToolClient) -> None:
    """AX-1740: what is not there can neither be slow nor start a thread."""
    maps = {str(each["name"]): pathlib.Path(f"/proc/{each['pid']}/maps").read_text() for each in processes(first)}
    assert "/_asyncio." in maps["services"]
    assert [library for library in ("/_asyncio.", "/_ssl.", "_pydantic_core") if library in maps["cycle"]] == []
    assert [name for name, mapped in maps.items() if "_pydantic_core" in mapped] == []


def processes(client: ToolClient) -> list[dict[str, Any]]:
    """As their supervisor knows them."""
    with ask(client.run, "status") as connection:
        found: list[dict[str, Any]] = json.loads(connection.makefile().readline())["processes"]
        return found
