"""The page VAL 3 of a running cell: start, the user page in its sandbox, a prompt, a variable."""

import pathlib
import shutil
from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

import configs
from hil_tests.lab.running.web_running import CHROMIUM, WebRun, pictures, until, web_run
from hil_tests.unit.languages.val3.apps import App
from hil_tests.unit.languages.val3.test_operator_page import DATA, START

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here"), pytest.mark.timeout(300)]
CELLS = pathlib.Path(configs.__file__).parent / "cells"
PAGE = """<html><head><script>parent.document.title = "run by a script"</script></head><body onload="parent.document.title = 'handler'">
<p id="count">-</p><button id="go"><b>Go</b></button><input id="wish"></body></html>"""


@pytest.fixture(scope="module")
def web(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebRun]:
    folder = tmp_path_factory.mktemp("val3page")
    text = (CELLS / "cs8.toml").read_text().replace('application = "cycle"', 'application = "menu"\nprompts = "page"')
    (folder / "cs8.toml").write_text(text)
    shutil.copytree(CELLS / "cs8", folder / "cs8")
    for path, data in App("menu", DATA, {"start": START}).files().items():
        target = folder / "cs8" / "usrapp" / path
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(data)
    interface = folder / "cs8" / "usrapp" / "menu" / "interface"
    interface.mkdir()
    (interface / "menu.html").write_text(PAGE)
    with web_run("val3page", cell=str(folder / "cs8.toml")) as run:
        yield run


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    context = web.context()
    page = web.page(context)
    web.login(page)
    web.go(page, "val3")
    yield page
    context.close()


def test_an_operator_works_with_the_user_page_of_an_application(web: WebRun, boss: Page) -> None:
    until(lambda: "can run" in boss.inner_text("#val3-state"), "the application is there")
    boss.click("#val3-start")
    until(lambda: "running" in boss.inner_text("#val3-state"), "it runs")
    inside = boss.frame_locator("#val3-page")
    until(lambda: inside.locator("#count").inner_text() == "0", "the bound variable is shown")
    until(lambda: inside.locator("#wish").input_value() == "7", "and the one of the entry")
    assert "press go" in boss.inner_text("#val3-screen") and "ready" in boss.inner_text("#val3-popups")
    inside.locator("#wish").fill("12")
    inside.locator("#wish").press("Tab")
    inside.locator("#go b").click()
    until(lambda: inside.locator("#count").inner_text() == "12", "the click and the entry have come")
    until(lambda: boss.is_visible("#val3-ok") and "Sure?" in boss.inner_text("#val3-prompt"), "the first prompt")
    boss.screenshot(path=pictures() / "val3.png")
    boss.click("#val3-ok")
    until(lambda: boss.is_visible("#val3-entry"), "the second prompt")
    boss.fill("#val3-entry", "Box 4")
    boss.click("#val3-ok")
    until(lambda: boss.is_hidden("#val3-prompt"), "it is answered")
    until(lambda: '"Box 4"' in boss.inner_text("table:has-text('sName')"), "its answer is in the variable")
    assert "script" not in boss.title() and "handler" not in boss.title(), "nothing of the page runs"
    boss.select_option("#val3-mode", "local")
    until(lambda: "local" in boss.inner_text("#val3-facts"), "the mode is another one")
    boss.fill("#val3-speed", "40")
    boss.press("#val3-speed", "Enter")
    until(lambda: "40 %" in boss.inner_text("#val3-facts"), "the monitor speed is another one")
    boss.fill("#val3-name", "nCount")
    boss.fill("#val3-value", "99")
    boss.click("#val3-write")
    until(lambda: "can run" in boss.inner_text("#val3-state"), "the application has ended")
    assert web.complaints == []


def test_a_viewer_operates_nothing(web: WebRun) -> None:
    assert web.ask("POST", "/api/val3/act", {"act": "set", "what": "nCount", "value": "1"}, x_axisgate="1")[0] in (401, 403)
    assert web.ask("GET", "/api/val3/page?folder=menu&name=none")[0] == 404
    assert web.ask("GET", "/api/val3/page?folder=..&name=x")[0] == 404
