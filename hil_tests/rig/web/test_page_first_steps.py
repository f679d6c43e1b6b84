"""A new user in front of a new cell, with the page alone: from the first password to an axis that moves.  In this order."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

from gateway.pure.image.records.cell import Motion, Permit
from hil_tests.lab.running.web_running import ADMIN, CHROMIUM, PAGES, PASSWORD, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")]
HEIGHT = "document.querySelector('main').getBoundingClientRect().height / innerHeight"
CURRENT = """() => { const r = document.querySelector('#nav a[aria-current]').getBoundingClientRect();
  return r.left >= 0 && r.right <= innerWidth && r.top >= 0; }"""
QUARTER = """() => fetch('/api/me').then(r => r.json()).then(me => fetch('/api/command', {method: 'POST',
  body: '{"code": "override", "velocity": 0.25}', headers: {'content-type': 'application/json', 'x-axisgate-csrf': me.csrf}}))"""
CHANGES = """async () => { const me = await (await fetch('/api/me')).json(); const found = [];
  const changes = [['permit', {on: true}], ['cable', {line: 'plc1', do: 'unplug'}], ['command', {code: 'enable', mask: 1}],
    ['scope/start', {channels: ['cell.ready']}], ['scope/stop', {}], ['scope/open', {name: 'kept'}],
    ['kept', {kind: 'watch', name: 'a', value: '[]'}]];
  for (const [path, body] of changes) found.push((await fetch(`/api/${path}`, {method: 'POST', body: JSON.stringify(body),
    headers: {'content-type': 'application/json', 'x-axisgate': '1', 'x-axisgate-csrf': me.csrf}})).status);
  return found; }"""
JOG = "[data-jog='5+']"


@pytest.fixture(scope="module")
def web() -> Iterator[WebRun]:
    with web_run("firststeps") as run:
        yield run


@pytest.fixture(scope="module")
def page(web: WebRun) -> Iterator[Page]:
    context = web.context()
    yield web.page(context, "axes")
    context.close()


def step(page: Page, words: str) -> None:
    until(lambda: words in page.inner_text("#next"), f"the page says: {words}")


def test_each_step_to_a_moving_axis_is_named_by_the_page(web: WebRun, page: Page) -> None:
    step(page, "Set the first password.")
    assert page.is_disabled("[data-code=enable]") and page.get_attribute("[data-code=enable]", "title") == "Set the first password."
    page.screenshot(path=pictures() / "axes-first-steps.png")
    page.click("#control")  # the first password is asked for before the first change
    page.fill("input[name=name]", ADMIN)
    page.fill("input[name=password]", PASSWORD)
    page.click("#send")
    page.wait_for_selector("#logout")
    step(page, "Request control.")
    assert page.get_attribute(JOG, "title") == "Request control."
    page.click("#control")
    web.plc.stop()  # nobody else sets enabling inputs
    until(
        lambda: "Enabling inputs missing" in page.inner_text("#next") or "drives are off" in page.inner_text("#next"), "inputs, or drives"
    )
    if "Enabling" in page.inner_text("#next"):
        page.click("#permit")
    until(lambda: any(words in page.inner_text("#next") for words in ("drives are off", "emergency stop is latched")), "the next step")
    if "latched" in page.inner_text("#next"):
        page.click("[data-code=fault_reset]")
    step(page, "The drives are off: switch them on.")
    page.click("[data-code=enable]")
    step(page, "The override is 0 %: raise it.")
    assert page.input_value("#override") == "0", "the slider shows the override, not what it was made with"
    page.locator("#override").fill("60")
    until(lambda: abs(web.run.state().override - 0.6) < 0.01, "it is ordered")
    step(page, "Ready: hold a jog key to move its axis.")
    page.locator(JOG).hover()
    page.mouse.down()
    until(lambda: web.run.state().motion is Motion.RUNNING, "A6 moves", 15)
    page.mouse.up()
    until(lambda: web.run.state().motion is Motion.IDLE, "and stops")


def test_the_slider_follows_an_override_ordered_elsewhere(web: WebRun, page: Page) -> None:
    page.evaluate(QUARTER)
    until(lambda: page.input_value("#override") == "25" and "25" in page.inner_text("#override-value"), "the slider shows 25 %")


def test_enabling_inputs_stay_what_the_page_shows(web: WebRun, page: Page) -> None:
    page.click("#control")  # control is given back: the page asks for nothing any more
    until(lambda: "Request control" in page.inner_text("#control"), "control is given back")
    if "Set" in page.inner_text("#permit"):
        page.click("#permit")
    until(lambda: "Clear enabling inputs" in page.inner_text("#permit"), "they are set")
    page.wait_for_timeout(4000)
    assert "Clear enabling inputs" in page.inner_text("#permit") and web.run.state().permits & Permit.TRAVEL
    page.click("#permit")
    until(lambda: "Set enabling inputs" in page.inner_text("#permit"), "they are cleared")
    until(lambda: not web.run.state().permits & Permit.TRAVEL, "in the cell as well")


def test_a_viewer_changes_nothing_and_each_grey_button_says_why(web: WebRun, page: Page) -> None:
    web.go(page, "access")
    page.fill("input[name=name]", "vera")
    page.select_option("select[name=role] >> nth=0", "viewer")
    page.fill("input[name=password]", PASSWORD)
    page.click("button:has-text('Save')")
    page.wait_for_selector("td:has-text('vera')")
    context = web.context()
    viewer = web.page(context)
    web.login(viewer, "vera")
    for name in ("axes", "motion", "scope"):
        web.go(viewer, name)
        viewer.wait_for_timeout(500)
        grey = viewer.locator("main button:disabled, main input:disabled")
        assert grey.count() > 0
        for n in range(grey.count()):
            assert "operator" in (grey.nth(n).get_attribute("title") or "") or "setter" in (grey.nth(n).get_attribute("title") or ""), name
    told = viewer.evaluate(CHANGES)
    assert told == [403] * 7
    context.close()


@pytest.mark.parametrize("language", ["en", "de"])
def test_on_a_phone_the_content_has_three_quarters_and_the_current_page_is_seen(web: WebRun, language: str) -> None:
    context = web.context(phone=True)
    page = web.page(context)
    page.evaluate(f"localStorage.setItem('language', '{language}')")
    for name in PAGES:
        page.goto(f"{web.url}/{name}")
        web.ready(page, name)
        page.wait_for_timeout(300)
        assert page.evaluate(HEIGHT) >= 0.75, name
        assert page.evaluate(CURRENT), f"{name} is not seen in the navigation"
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, name
        stop = page.locator("#stop").bounding_box()
        assert stop is not None and stop["x"] + stop["width"] <= 390 and stop["height"] >= 40
        page.screenshot(path=pictures() / f"{name}-{language}-phone.png")
    context.close()
