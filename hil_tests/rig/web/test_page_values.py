"""Values on the page over time: the trend by one click, watch lists, the rolling scope and its layouts.  One cell, in this order."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

from hil_tests.lab.running.web_running import ADMIN, CHROMIUM, PASSWORD, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")]
QUIET = "document.getElementById('toasts').replaceChildren()"
POINTS = "Number(document.getElementById('trend-plot')?.dataset.points || 0)"
ROLLING = "Number(document.getElementById('scope-plot').dataset.rolling || 0)"
SCALES = "Number(document.getElementById('scope-plot').dataset.scales || 0)"


@pytest.fixture(scope="module")
def web() -> Iterator[WebRun]:
    with web_run("values") as run:
        yield run


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    context = web.context()
    page = web.page(context)
    web.login(page)
    yield page
    context.close()


def test_a_value_shows_its_trend_by_one_click_and_what_was_before_it(web: WebRun, boss: Page) -> None:
    status, told = web.ask("GET", "/api/trend?id=cell.life&seconds=600")
    assert status == 200 and len(told["values"]) >= 2, "it is kept from the start, not from the click"
    assert told["values"] == sorted(told["values"]) and told["ms"] == sorted(told["ms"]) and told["ms"][-1] == 0
    for name, value in (
        ("signals", "[data-trend='cell.life']"),
        ("axes", "[data-trend='axis.A1.actual']"),
        ("overview", "td button.value"),
    ):
        web.go(boss, name)
        boss.locator(value).first.click()
        boss.wait_for_selector("#trend canvas")
        until(lambda: boss.evaluate(POINTS) >= 2, "points are drawn")
        boss.evaluate(QUIET)
        boss.screenshot(path=pictures() / f"trend-{name}.png")
        boss.click("#stop")
        until(lambda: "Stop requested" in boss.inner_text("#toasts"), "STOP is within reach of an open trend")
        boss.evaluate(QUIET)
        boss.click("#trend-close")
        boss.wait_for_selector("#trend", state="detached")
    assert web.ask("GET", "/api/trend?id=no.such&seconds=600")[0] == 404
    assert web.ask("GET", "/api/trend?id=cell.life&seconds=nan")[0] == 400


def test_a_word_of_the_image_is_found_and_lives_and_has_a_trend(web: WebRun, boss: Page) -> None:
    assert web.ask("POST", "/api/force", {"bit": 40, "value": 1}, **web.headers())[0] == 200
    web.go(boss, "signals")
    boss.fill("#search", "AW 4")
    until(lambda: boss.inner_text("[data-id='inw:4:2']").strip() == "1", "byte 4 is the high one, bit 0 of byte 5 is forced")
    until(lambda: boss.locator("tr.forced [data-id='inw:4:2']").count() == 1, "the word shows that a bit of it is forced")
    until(lambda: web.ask("GET", "/api/trend?id=inw:5:1&seconds=60")[1]["values"][-1] == 1.0, "its trend is made of its bits")
    assert web.ask("POST", "/api/unforce", {"bit": 40}, **web.headers())[0] == 200


def test_a_watch_list_is_kept_and_another_browser_opens_it(web: WebRun, boss: Page) -> None:
    web.go(boss, "signals")
    for words, id_ in (("cell.life", "cell.life"), ("AW 4", "inw:4:2"), ("axis.A2.lag", "axis.A2.lag")):
        boss.fill("#search", words)
        boss.click(f"[data-star='{id_}']")
    boss.click("#watch")
    until(lambda: boss.locator("td[data-id]").count() == 3, "the list shows its values alone")
    until(lambda: boss.inner_text("[data-id='cell.life']") != "", "and they live")
    boss.fill("#watch-name", "press 3 / start")
    boss.click("#watch-keep")
    until(lambda: "press 3 / start" in boss.inner_text("#watch-kept"), "it is kept")
    boss.evaluate(QUIET)
    boss.screenshot(path=pictures() / "watch-list.png")
    context = web.context()
    other = web.page(context, "signals")
    other.select_option("#watch-kept", "press 3 / start")
    until(lambda: other.locator("td[data-id]").count() == 3, "another browser opens it")
    assert other.is_disabled("#watch-keep") and "Log in" in (other.get_attribute("#watch-keep", "title") or "")
    other.reload()
    web.ready(other, "signals")
    assert "(3)" in other.inner_text("#watch"), "the browser remembers its last list"
    context.close()


def test_the_scope_rolls_with_a_scale_for_each_channel(web: WebRun, boss: Page) -> None:
    web.go(boss, "scope")
    boss.fill("#scope-window", "2")
    boss.click("#roll")
    until(lambda: boss.evaluate(ROLLING) > 100, "the last seconds are drawn")
    assert boss.evaluate(SCALES) == 3, "three channels of one unit have a scale each"
    boss.click("#joint")
    until(lambda: boss.evaluate(SCALES) == 1, "or one for their unit")
    boss.click("#joint")
    boss.fill("[data-end='axis.A1.lag 0']", "-2")
    boss.press("[data-end='axis.A1.lag 0']", "Tab")
    boss.fill("[data-end='axis.A1.lag 1']", "2")
    boss.press("[data-end='axis.A1.lag 1']", "Tab")
    boss.wait_for_timeout(3000)
    assert "rolling" in boss.inner_text("#scope-state"), "it does not end by itself"
    boss.evaluate(QUIET)
    boss.screenshot(path=pictures() / "scope-rolling.png")
    boss.click("#roll")
    until(lambda: boss.inner_text("#roll") == "Roll", "it is stopped")
    boss.wait_for_selector("#scope-plot[data-records]")
    assert int(boss.get_attribute("#scope-plot", "data-records") or 0) == round(2000 / web.run.p5_ms), (
        "the last two seconds are a recording"
    )
    boss.fill("#scope-name", "lag of A1")
    boss.locator("#scope-keep").click()
    until(lambda: "lag of A1" in boss.inner_text("#scope-kept"), "the layout is kept")


def test_a_kept_layout_brings_its_channels_and_scales_to_another_browser(web: WebRun) -> None:
    context = web.context(phone=True)
    other = web.page(context, "scope")
    other.select_option("#scope-kept", "lag of A1")
    until(lambda: other.input_value("#scope-window") == "2", "its window")
    until(lambda: other.input_value("[data-end='axis.A1.lag 1']") == "2", "its scale")
    assert other.is_disabled("#roll") and other.is_disabled("#record") and "Log in" in (other.get_attribute("#roll", "title") or "")
    assert other.evaluate("document.documentElement.scrollWidth") <= 390
    other.screenshot(path=pictures() / "scope-phone.png")
    context.close()


def test_a_rolling_scope_refuses_what_it_has_not(web: WebRun) -> None:
    own = web.headers(ADMIN, PASSWORD)
    for more in ({"seconds": 61.0}, {"trigger": "error"}, {"pre": 1.0}):
        status, told = web.ask("POST", "/api/scope/start", {"channels": ["cell.job"], "rolling": True, **more}, **own)
        assert status == 400 and "rolling" in told["error"]
    assert web.complaints == []
