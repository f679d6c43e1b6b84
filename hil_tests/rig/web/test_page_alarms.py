"""The alarm history of a running cell: a drive fault and an emergency stop, acknowledged, filtered, exported, kept over a restart."""

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page

from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.running.web_running import CHROMIUM, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")]

STOPPED = (int(Reason.DRIVE_FAULT), int(Reason.MACHINE_LATE))  # a machine that was late itself names no drive
POST = """async ([path, body]) => { const me = await (await fetch('/api/me')).json();
  return (await fetch(`/api/${path}`, {method: 'POST', body: JSON.stringify(body), headers: {'content-type': 'application/json',
    'x-axisgate': '1', 'x-axisgate-csrf': me.csrf}})).status; }"""


@pytest.fixture(scope="module")
def web() -> Iterator[WebRun]:
    with web_run("alarms") as run:
        yield run


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    context = web.context()
    page = web.page(context)
    web.login(page)
    yield page
    context.close()


def alarms(web: WebRun, **query: str) -> list[dict[str, Any]]:
    asked = "&".join(f"{name}={value}" for name, value in query.items())
    found: list[dict[str, Any]] = web.ask("GET", f"/api/alarms?{asked}")[1]["alarms"]
    return found


def errors(web: WebRun) -> list[int]:
    return [int(each["code"]) for each in web.run.status().get("errors", [])]


def test_a_drive_fault_comes_is_acknowledged_and_goes(web: WebRun, boss: Page) -> None:
    web.in_control(boss)
    web.go(boss, "emulator")
    boss.select_option("[data-fault=A2]", "force_fault")
    boss.click("[data-inject=A2]")
    until(lambda: any(row["source"] == "A2" and row["code"] in STOPPED for row in alarms(web, state="active")), "the fault came")
    web.in_control(boss)  # which resets it
    until(lambda: any(row["acknowledged"] and row["gone"] for row in alarms(web, source="A2")), "it was acknowledged and went")
    assert next(row for row in alarms(web, source="A2") if row["acknowledged"])["by"] == "page"


def test_an_emergency_stop_is_in_it(web: WebRun, boss: Page) -> None:
    assert boss.evaluate(POST, ["force", {"bit": 24, "value": 0}]) == 200
    until(lambda: any(row["code"] == 8 for row in alarms(web, state="active")), "it came")
    assert boss.evaluate(POST, ["unforce", {"bit": 24}]) == 200
    web.in_control(boss)
    until(lambda: any(row["code"] == 8 and row["gone"] for row in alarms(web)), "it went")


def test_a_stop_is_an_error_only_while_a_rest_of_the_move_waits(web: WebRun, boss: Page) -> None:
    web.in_control(boss)
    boss.locator("#override").fill("100")
    until(lambda: "override 100 %" in boss.inner_text("#state"), "override 100 %")
    boss.locator("[data-jog='5+']").hover()
    boss.mouse.down()
    until(lambda: web.run.state().motion is Motion.RUNNING, "A6 moves", 15)
    assert web.ask("POST", "/api/stop", x_axisgate="1")[0] == 200
    until(lambda: any(row["code"] == 19 for row in alarms(web, state="active")), "the stop is an error while its rest waits")
    boss.mouse.up()
    until(lambda: web.run.state().motion is Motion.STOPPED, "A6 is at rest: only then there is a rest to abandon")
    boss.click("[data-code=abandon]")
    until(lambda: not any(row["code"] == 19 for row in alarms(web, state="active")), "and ends with it")


def test_the_page_filters_and_exports_and_nothing_is_lost_in_a_restart(web: WebRun, boss: Page) -> None:
    web.go(boss, "events")
    until(lambda: boss.locator("#alarms tbody tr").count() >= 3, "the alarms are listed")
    boss.screenshot(path=pictures() / "alarms.png")
    boss.select_option("#alarm-source", "A2")
    until(lambda: set(boss.locator("#alarms tbody tr td:nth-child(5)").all_inner_texts()) == {"A2"}, "those of A2 alone")
    with boss.expect_download() as download:
        boss.click("#alarms-csv")
    lines = download.value.path().read_text(encoding="utf-8-sig").splitlines()
    assert lines[0] == "number;came;acknowledged;by;gone;code;source;text" and all(";A2;" in line for line in lines[1:]) and len(lines) > 1
    before = alarms(web)
    dead = web.run.pid("services")
    os.kill(dead, signal.SIGKILL)
    web.run.back("services", dead)
    until(lambda: bool(alarms(web)), "the page has them")
    rows = {row["number"]: row for row in alarms(web)}
    assert all(rows[row["number"]]["came"] == row["came"] for row in before)
    assert web.ask("GET", "/api/alarms?state=lost")[0] == 400
