"""The page Programs of a running cell: listing, current line, start and stop; a program with a fault is shown where the fault is."""

import pathlib
import shutil
import time
from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

import configs
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.running.web_running import CHROMIUM, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here"), pytest.mark.timeout(300)]
CELLS = pathlib.Path(configs.__file__).parent / "cells"
LOOP = """;;KINEMATICS : (1 = PORTAL)
PROGRAM LOOP
BEGIN
V = 60
AGAIN:
MOVE LINEAR TO @(300, 60, 100, 0)
MOVE LINEAR TO @(100, 60, 100, 0)
JUMP AGAIN
PROGRAM_END
"""
STEPS = """;;KINEMATICS : (1 = PORTAL)
PROGRAM STEPS
INTEGER : COUNT
BEGIN
COUNT = 1
COUNT = COUNT + 1
MOVE LINEAR TO HERE
COUNT = COUNT + 10
PROGRAM_END
"""
WRONG = "PROGRAM WRONG\nBEGIN\n  JUMP NOWHERE\nPROGRAM_END\n"


@pytest.fixture(scope="module")
def web(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebRun]:
    folder = tmp_path_factory.mktemp("programs")
    shutil.copytree(CELLS / "palletiser", folder / "palletiser")
    shutil.copy(CELLS / "palletiser.toml", folder)
    (folder / "palletiser/LOOP.QLL").write_text(LOOP)
    (folder / "palletiser/STEPS.QLL").write_text(STEPS)
    (folder / "palletiser/STEPS.PKT").write_text("HERE = (1, 2, 3, 4)\n")
    (folder / "palletiser/WRONG.QLL").write_text(WRONG)
    with web_run("programs", cell=str(folder / "palletiser.toml")) as run:
        yield run


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    context = web.context()
    page = web.page(context)
    web.login(page)
    yield page
    context.close()


def lines_now(page: Page) -> list[int]:
    return [
        int(each)
        for each in page.eval_on_selector_all(
            "#listing li", "rows => rows.flatMap((row, n) => row.classList.contains('now') ? [n + 1] : [])"
        )
    ]


def chosen(page: Page, name: str) -> None:
    page.locator(f"table button.value:text-is('{name}')").first.click()
    until(lambda: page.inner_text("#listing-note").startswith(f"{name}.QLL"), f"the listing of {name}")


def test_a_listing_has_its_faults_in_place_and_cannot_be_started(web: WebRun, boss: Page) -> None:
    web.go(boss, "programs")
    until(lambda: boss.locator("[data-do=start]").count() >= 3, "the programs are listed")
    chosen(boss, "WRONG")
    wrong = boss.locator("#listing li.wrong")
    assert wrong.count() == 1 and "JUMP NOWHERE" in wrong.inner_text() and "NOWHERE" in wrong.locator(".fault").inner_text()
    start = boss.locator("[data-do=start][data-program=WRONG]")
    assert start.is_disabled() and start.get_attribute("title") == "The program has errors."
    assert web.ask("GET", "/api/program?name=NOBODY")[0] == 404


def test_a_viewer_starts_nothing(web: WebRun) -> None:
    context = web.context()
    page = web.page(context)
    web.go(page, "programs")
    until(lambda: page.locator("[data-do=start]").count() >= 3, "the programs are listed")
    assert page.locator("[data-do=start]").first.is_disabled()
    assert web.ask("POST", "/api/program/start", {"name": "LOOP"}, x_axisgate="1")[0] in (401, 403)
    context.close()


def started(web: WebRun, page: Page) -> None:
    """LOOP moves; what a busy machine has taken away is taken back first."""
    web.in_control(page)
    page.locator("#override").fill("100")
    until(lambda: "override 100 %" in page.inner_text("#state"), "override 100 %")
    web.go(page, "programs")
    chosen(page, "LOOP")
    until(lambda: "moves under the control of this page" in page.inner_text("#whose"), "the page knows that it has control")
    if page.locator("[data-do=stop][data-program=LOOP]").count() == 0:
        page.click("[data-do=start][data-program=LOOP]")
    until(lambda: web.run.state().motion is Motion.RUNNING, "it moves", 60)


def test_a_program_is_started_followed_line_by_line_and_stopped(web: WebRun, boss: Page) -> None:
    started(web, boss)
    seen: set[int] = set()
    end = time.monotonic() + 120
    while not {6, 7} <= seen and time.monotonic() < end:
        seen |= set(lines_now(boss))
        if web.run.state().motion is Motion.IDLE and not lines_now(boss):
            started(web, boss)
    assert {6, 7} <= seen, "both moves were shown as the current line"
    boss.screenshot(path=pictures() / "programs.png")
    boss.click("[data-do=stop][data-program=LOOP]")
    until(lambda: lines_now(boss) == [] and boss.locator("[data-do=stop]").count() == 0, "no process is left")
    until(lambda: web.run.state().motion is not Motion.RUNNING, "nothing moves")
    said = [each["say"] for each in web.ask("GET", "/api/audit", **web.headers())[1]["entries"]]
    assert ["started program LOOP", "Programm LOOP gestartet"] in said
    assert web.complaints == []


AUTO, TEST = 23, 22


def in_test(web: WebRun, page: Page) -> None:
    """Manual, and the test selected, as the PLC does it."""
    for bit, value in ((AUTO, 0), (TEST, 1)):
        assert web.ask("POST", "/api/force", {"bit": bit, "value": value}, **web.headers())[0] == 200
    web.go(page, "programs")
    chosen(page, "STEPS")


def variable(page: Page, name: str) -> str:
    found = page.locator(f"#test-system [data-do=set][data-name={name}]")
    return found.first.inner_text() if found.count() else ""


def test_a_program_is_held_at_a_breakpoint_stepped_and_changed(web: WebRun, boss: Page) -> None:
    in_test(web, boss)
    boss.click("#listing button.stop[data-line='6']")
    until(lambda: boss.get_attribute("#listing button.stop[data-line='6']", "aria-pressed") == "true", "the breakpoint is set")
    boss.click("[data-do=test][data-program=STEPS]")
    until(lambda: lines_now(boss) == [6] and variable(boss, "COUNT") == "1", "the process is held and shows its variables")
    boss.click("[data-step=into]")
    until(lambda: lines_now(boss) == [7] and variable(boss, "COUNT") == "2", "one line further")
    boss.click("#test-system [data-do=set][data-name=COUNT]")
    boss.fill("#asked", "many")
    boss.click("#send")
    until(lambda: "a whole number" in boss.inner_text("#toasts"), "what is not a number is refused in words")
    boss.click("#test-system [data-do=set][data-name=COUNT]")
    boss.fill("#asked", "40")
    boss.click("#send")
    until(lambda: variable(boss, "COUNT") == "40", "the variable is changed")
    boss.screenshot(path=pictures() / "programs-test.png", full_page=True)
    boss.click("[data-do=stop][data-program=STEPS]")
    until(lambda: lines_now(boss) == [], "no process is left")
    assert web.complaints == []


def test_a_point_is_taught_after_a_question(web: WebRun, boss: Page) -> None:
    in_test(web, boss)
    teach = boss.locator("#points [data-do=teach][data-point=HERE]")
    before = boss.inner_text("#points [data-do=define][data-point=HERE]")
    assert before == "1, 2, 3, 4"
    teach.click()
    until(lambda: "overwrite with the actual position?" in boss.inner_text("#dialog"), "a point that is defined is not overwritten unasked")
    boss.click("#send")
    until(lambda: boss.inner_text("#points [data-do=define][data-point=HERE]") != before, "the point is where the axes are")
    boss.click("#points [data-do=define][data-point=HERE]")
    boss.fill("#asked", "10, 20, 30, 40")
    boss.click("#send")
    until(lambda: boss.inner_text("#points [data-do=define][data-point=HERE]") == "10, 20, 30, 40", "the point has these numbers")
    assert web.ask("POST", "/api/program/teach", {"name": "STEPS", "point": "HERE"}, x_axisgate="1")[0] in (401, 403)
    web.ask("POST", "/api/force", {"bit": AUTO, "value": 1}, **web.headers())
    boss.locator("#points [data-do=teach][data-point=HERE]").click()
    boss.click("#send")
    until(lambda: "is in automatic" in boss.inner_text("#toasts"), "Teach in is refused in automatic")
    assert web.complaints == []
