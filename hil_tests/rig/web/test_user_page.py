"""The sandboxed frame of a VAL 3 user page: presses by mouse, touch and key, attributes, entries (VAL 3 reference 4.1, 14.2)."""

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page, Route, sync_playwright

from gateway.web.app import STATIC
from hil_tests.lab.running.web_running import CHROMIUM

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here"), pytest.mark.timeout(300)]
SITE = "http://pages.test"
HARNESS = """<!DOCTYPE html><body><p>outside</p><script type="module">
import { UserPage } from "/static/userpage.js";
window.orders = [];
window.user = new UserPage("page", {
  act: async (order) => { const short = order.act === "event" ? `${order.what} ${order.value}` : `${order.what} = ${order.value}`;
    if (order.value === "mousedown") await new Promise((done) => setTimeout(done, 100)); window.orders.push(short); },
  image: async (file) => `data:image/png;base64,${btoa(file)}`, allowed: () => true });
document.body.append(window.user.element);
</script>"""
INSIDE = """<button id="b"><b>Go</b></button><div id="area">area <input name="none"></div><input id="i"><select id="s"></select>
<img id="g"><a id="a">x</a><span id="box" tabindex="0">box</span>"""
POINTER = """([kind, inside]) => { const frame = document.getElementById("val3-page");
  const target = inside ? frame.contentDocument.getElementById("b") : document.body;
  target.dispatchEvent(new (target.ownerDocument.defaultView.PointerEvent)(kind, { pointerId: 7, button: 0, bubbles: true })); }"""


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    """A page with the frame alone, without a cell."""

    def serve(route: Route) -> None:
        path = route.request.url.removeprefix(SITE).partition("?")[0]
        if path.startswith("/static/"):
            route.fulfill(path=STATIC / path.removeprefix("/static/"))
        else:
            route.fulfill(body=HARNESS, content_type="text/html")

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        found = browser.new_context(has_touch=True).new_page()
        found.route(f"{SITE}/**", serve)
        found.goto(f"{SITE}/")
        found.wait_for_function("window.user !== undefined")
        found.evaluate("html => window.user.show(html)", INSIDE)
        found.frame_locator("#val3-page").locator("#box").wait_for()
        yield found
        browser.close()


def orders(page: Page, count: int) -> list[str]:
    """What has been sent, at least `count` of them and nothing for a while."""
    page.wait_for_function("count => window.orders.length >= count", arg=count)
    page.wait_for_timeout(300)
    found: list[str] = page.evaluate("() => window.orders.splice(0)")
    return found


def test_a_press_is_one_press_by_mouse_touch_and_key_and_ends_where_the_pointer_is(page: Page) -> None:
    inside, whole = page.frame_locator("#val3-page"), ["b mousedown", "b mouseup", "b click"]
    inside.locator("#b b").click()
    assert orders(page, 3) == whole
    inside.locator("#b").tap()
    assert orders(page, 3) == whole, "a touch is not a mouse besides"
    inside.locator("#b").press("Space")
    assert sorted(orders(page, 3)) == sorted(whole)
    inside.locator("#b").press("Enter")
    assert sorted(orders(page, 3)) == sorted(whole)
    inside.locator("#box").press("Enter")
    assert orders(page, 3) == ["box mousedown", "box mouseup", "box click"]
    page.evaluate(POINTER, ["pointerdown", True])
    page.evaluate(POINTER, ["pointerup", False])
    assert orders(page, 2) == ["b mousedown", "b mouseup"], "released outside the frame"
    page.evaluate(POINTER, ["pointerdown", True])
    page.evaluate("() => window.user.hide()")
    assert orders(page, 2) == ["b mousedown", "b mouseup"], "the page is left while the object is pressed"
    page.evaluate("() => { window.user.element.hidden = false; }")


def test_entries_are_of_the_object_itself(page: Page) -> None:
    inside = page.frame_locator("#val3-page")
    inside.locator("input[name=none]").fill("1")
    inside.locator("#i").fill("a b")
    inside.locator("#i").press("Tab")
    assert [each for each in orders(page, 1) if "=" in each] == ["i = a b"]


def test_attributes_are_shown_as_the_catalogue_has_them(page: Page) -> None:
    rows = [["b", "innerHTML", "PUSHED"], ["b", "disabled", "true"], ["i", "disabled", "false"], ["i", "min", "2"], ["a", "target", "x"],
            ["s", "options", "a,b"], ["s", "options", "c"], ["s", "value", "c"], ["g", "src", "lamp.png"], ["a", "href", "http://x/"],
            ["box", "style.backgroundColor", "rgb(1, 2, 3)"], ["box", "style.backgroundImage", "url(http://x/y.png)"],
            ["box", "dataset.part", "7"], ["area", "className", "on"]]  # fmt: skip
    page.frame_locator("#val3-page").locator("#b").focus()
    page.evaluate("rows => { window.user.draw(rows); window.user.draw(rows); }", rows)
    page.wait_for_function("() => document.getElementById('val3-page').contentDocument.getElementById('g').src")
    seen: dict[str, Any] = page.evaluate(
        """() => { const at = (id) => document.getElementById("val3-page").contentDocument.getElementById(id); return {
        text: at("b").textContent, off: at("b").disabled, on: at("i").disabled, min: at("i").min, target: at("a").target,
        options: [...at("s").options].map((each) => each.text), chosen: at("s").value,
        image: at("g").src, link: at("a").getAttribute("href"),
        colour: at("box").style.backgroundColor, loaded: at("box").style.backgroundImage, part: at("box").dataset.part,
        name: at("area").className }; }"""
    )
    assert seen == {
        "text": "PUSHED", "off": True, "on": False, "min": "2", "target": "x", "options": ["a,b", "c"], "chosen": "c",
        "image": "data:image/png;base64,bGFtcC5wbmc=", "link": None, "colour": "rgb(1, 2, 3)", "loaded": "", "part": "7", "name": "on",
    }  # fmt: skip
    page.evaluate("rows => window.user.draw(rows)", [["b", "disabled", "0"], ["b", "innerHTML", "RELEASED"]])
    assert page.frame_locator("#val3-page").locator("#b").inner_text() == "RELEASED"
    assert page.frame_locator("#val3-page").locator("#b").is_enabled()
