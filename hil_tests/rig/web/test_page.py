"""Every page of a really running cell, clicked through with a real browser.  One cell and one browser for all of it, in this order."""

import json
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

from hil_tests.lab.web_running import ADMIN, CHROMIUM, DESKTOP, PAGES, PASSWORD, TABLET, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")]
HEADERS = {"x_axisgate": "1"}
FILLED = {  # what stands there when a page has something to show
    "overview": "td:has-text('A6')",
    "axes": ".uplot canvas",
    "motion": "[data-drawn]",
    "signals": "[data-id='cell.life']:not(:empty)",
    "lines": "td:has-text('SEND')",
    "bus": "td:has-text('SYNC')",
    "events": "td:has-text('services started')",
    "emulator": "td:has-text('A6')",
    "access": "td:has-text('POST')",
}


@pytest.fixture(scope="module")
def web() -> Iterator[WebRun]:
    with web_run() as run:
        yield run


@pytest.fixture(scope="module")
def guest(web: WebRun) -> Iterator[Page]:
    """Somebody at the gateway who has not logged in."""
    context = web.context()
    yield web.page(context)
    context.close()


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    """The administrator; his first login sets the first password."""
    context = web.context()
    page = web.page(context)
    web.login(page)
    yield page
    context.close()


def number(page: Page, selector: str) -> float:
    return float(page.inner_text(selector).split()[-1])


def test_looking_needs_no_password_and_what_is_shown_lives(web: WebRun, guest: Page) -> None:
    assert "is not a safety device" in guest.inner_text("#foot")
    assert guest.inner_text("#cell") == web.run.demo.cell.name
    before = guest.inner_text("#cycle")
    until(lambda: guest.inner_text("#cycle") != before, "the cycle's counters change")
    until(lambda: guest.locator("table", has_text="A6").count() > 0, "the drives are listed")
    until(lambda: "plc1 alive" in guest.inner_text("#state"), "the link of PLC 1 is shown alive")
    assert guest.evaluate("fetch('/api/me').then(r => r.json())")["role"] == "viewer"


def test_the_first_page_is_light_and_needs_nobody_else(web: WebRun) -> None:
    context = web.context()
    page = context.new_page()
    asked: dict[str, int] = {}
    page.on("response", lambda answer: asked.update({answer.url: len(answer.body()) if answer.ok and "/static" in answer.url else 0}))
    page.goto(f"{web.url}/overview")
    web.ready(page, "overview")
    context.close()
    assert all(url.startswith(web.url) for url in asked), asked
    assert not any("three" in url for url in asked)
    assert sum(asked.values()) < 1_500_000


def test_nothing_is_changed_before_there_is_a_password(web: WebRun) -> None:
    for path, body in (("/api/command", {"code": "request_control"}), ("/api/force", {"bit": 40, "value": 1}), ("/api/users", None)):
        status, told = web.ask("POST", path, body, **HEADERS)
        assert status == 401, (path, told)
    assert web.ask("GET", "/api/audit")[0] == 401
    status, _ = web.ask("POST", "/api/login", {"name": "admin", "password": "admin"}, **HEADERS)
    assert status == 401, "there is no default password"


def test_the_first_password_is_set_once_and_roles_count(web: WebRun, boss: Page) -> None:
    assert web.ask("POST", "/api/setup", {"name": "eve", "password": "another one 8"}, **HEADERS)[0] == 409
    web.go(boss, "access")
    for name, role in (("vera", "viewer"), ("otto", "operator")):
        boss.fill("input[name=name]", name)
        boss.select_option("select[name=role] >> nth=0", role)
        boss.fill("input[name=password]", PASSWORD)
        boss.click("button:has-text('Save')")
        boss.wait_for_selector(f"td:has-text('{name}')")
    boss.fill("input[name=label]", "script")
    boss.click("button:has-text('Make')")
    until(lambda: "axg_" in boss.inner_text("#token"), "the token is shown once")
    token = boss.inner_text("#token").split()[-1]
    bearer = {"authorization": f"Bearer {token}"}
    assert web.ask("GET", "/api/me", **bearer)[1]["role"] == "viewer"
    assert web.ask("POST", "/api/force", {"bit": 40, "value": 1}, **bearer)[0] == 403, "a viewer's token forces nothing"
    assert web.ask("GET", "/api/me", authorization="Bearer axg_wrong")[0] == 401
    until(lambda: "the chain is whole" in boss.inner_text("body"), "the audit is verified")


def test_a_wrong_password_is_refused_and_so_is_a_wrong_role(web: WebRun) -> None:
    context = web.context()
    page = web.page(context, "axes")
    page.click("#login")
    page.fill("input[name=name]", "vera")
    page.fill("input[name=password]", "not hers at all")
    page.click("#send")
    page.wait_for_selector("text=name or password is wrong")
    page.fill("input[name=password]", PASSWORD)
    page.click("#send")
    page.wait_for_selector("#logout")
    until(lambda: page.is_disabled("#control"), "a viewer cannot ask for control")
    told = page.evaluate(
        """async () => { const me = await (await fetch('/api/me')).json();
        const answer = await fetch('/api/command', {method: 'POST', body: '{"code": "enable", "mask": 1}',
          headers: {'content-type': 'application/json', 'x-axisgate': '1', 'x-axisgate-csrf': me.csrf}}); return answer.status; }"""
    )
    assert told == 403
    context.close()


def test_another_pages_requests_are_not_carried_out(web: WebRun, boss: Page) -> None:
    cookie = next(each for each in boss.context.cookies() if each.get("name") == "axisgate")
    assert cookie.get("sameSite") == "Strict"
    assert cookie.get("httpOnly") is True
    own = {"cookie": f"axisgate={cookie.get('value')}"}
    assert web.ask("POST", "/api/force", {"bit": 40, "value": 1}, **own, **HEADERS)[0] == 403, "the session's mark is missing"
    assert web.ask("POST", "/api/stop", origin="http://evil.example", **HEADERS)[0] == 403
    assert web.ask("POST", "/api/stop")[0] == 403, "a plain form of another page lacks our header"
    assert web.ask("GET", "/api/me", host="evil.example")[0] == 421
    assert web.ask("POST", "/api/stop", **HEADERS)[0] == 200, "stop at the gateway itself needs no password"


def test_axes_are_switched_on_and_jogged_while_the_key_is_held(web: WebRun, boss: Page) -> None:
    web.go(boss, "axes")
    boss.click("#permit")
    until(lambda: "emergency" not in boss.inner_text("#state"), "nothing latched")
    boss.click("#control")
    until(lambda: boss.inner_text("#control") == "Release control", "control was given")
    boss.click("[data-code=fault_reset]")
    boss.click("[data-code=enable]")
    until(lambda: "drives on 6/6" in boss.inner_text("#state"), "the drives are on")
    boss.evaluate("fetch('/api/me').then(r => r.json()).then(me => fetch('/api/command', {method: 'POST', body: '{\"code\": \"override\"}', headers: {'content-type': 'application/json', 'x-axisgate-csrf': me.csrf}}))")  # fmt: skip  # noqa: E501
    until(lambda: "override 100 %" in boss.inner_text("#state"), "override 100 %")
    actual = "tr:has([data-jog='5+']) td:nth-child(4)"
    before = number(boss, actual)
    key = boss.locator("[data-jog='5+']")
    key.hover()
    boss.mouse.down()
    until(lambda: number(boss, actual) > before + 2.0, "A6 moves while its key is held")
    boss.mouse.up()
    until(lambda: "at rest" in boss.inner_text("#state"), "and stops when it is released")
    after = number(boss, actual)
    key.focus()
    boss.keyboard.down("Space")
    until(lambda: number(boss, actual) > after + 1.0, "the keyboard jogs as well")
    boss.keyboard.up("Space")
    until(lambda: "at rest" in boss.inner_text("#state"), "and stops")
    boss.click("[data-ref=A6]")
    until(lambda: boss.inner_text("[data-referenced=A6]") == "yes", "A6 is referenced")


def test_signals_are_found_live_and_forced_with_a_mark(web: WebRun, boss: Page) -> None:
    web.go(boss, "signals")
    boss.fill("#search", "DB10.DW31")
    until(lambda: boss.locator("[data-id='db:10:31']").count() == 1, "the life word is found by its address")
    first = boss.inner_text("[data-id='db:10:31']")
    until(lambda: boss.inner_text("[data-id='db:10:31']") != first, "and lives")
    boss.fill("#search", "O5.0")
    until(lambda: boss.locator("[data-force='in:40=1']").count() == 1, "an input is found by its PIC address")
    boss.click("[data-force='in:40=1']")
    until(lambda: boss.locator("tr.forced [data-id='in:40']").count() == 1, "the force is marked in its row")
    until(lambda: boss.inner_text("[data-id='in:40']") == "1" and "1 forced" in boss.inner_text("#state"), "and on every page")
    boss.screenshot(path=pictures() / "signals-forced.png")
    boss.click("[data-force='in:40=end']")
    until(lambda: boss.inner_text("[data-id='in:40']") == "0", "the force has ended")
    until(lambda: "forced" not in boss.inner_text("#state"), "and its mark is gone")
    boss.fill("#search", "A1.actual")
    boss.click("[data-row='axis.A1.actual']")
    until(lambda: "DB 11 DW 2" in boss.inner_text("#detail"), "where-used names the word the PLC reads")


def test_lines_and_bus_are_decoded(web: WebRun, boss: Page) -> None:
    web.go(boss, "lines")
    for words in ("SEND DB10.DW0, 32 words", "FETCH DB11.DW0, 32 words", "reaction 00h no error"):
        boss.wait_for_selector(f"td:has-text('{words}')")
    web.go(boss, "bus")
    until(lambda: "SET_1 enable=" in boss.inner_text("main"), "SERVODYN frames are decoded")
    until(lambda: boss.locator("td", has_text="SYNC").count() == 1, "SYNC is listed")
    until(lambda: 0.0 < float(boss.inner_text("tr:has-text('SYNC') td:nth-child(2)")) < 500.0, "its rate is told")


def test_the_motion_page_draws(web: WebRun, boss: Page) -> None:
    web.go(boss, "motion")
    until(lambda: boss.locator("#robot canvas").count() == 1, "three.js draws")
    until(lambda: len(set(boss.locator("#robot").screenshot())) > 100, "something is to be seen")
    until(lambda: "at rest" in boss.inner_text("main"), "the state is told")


def test_a_fault_is_ordered_and_named(web: WebRun, boss: Page) -> None:
    web.go(boss, "emulator")
    boss.select_option("[data-fault=A2]", "force_fault")
    boss.click("[data-inject=A2]")
    web.go(boss, "overview")
    until(lambda: "drive fault: A2" in boss.inner_text("#first-out"), "the fault is named first")
    assert "What to do" in boss.inner_text("#first-out")
    web.go(boss, "events")
    boss.fill("#catalogue", "drive fault")
    until(lambda: boss.locator("td", has_text="axisgate 16").count() == 1, "the catalogue knows its number")
    web.go(boss, "axes")
    boss.click("[data-code=fault_reset]")
    web.go(boss, "overview")
    until(lambda: "drive fault" not in boss.inner_text("#first-out"), "it is reset")


def test_the_plug_is_pulled_and_it_comes_back(web: WebRun, guest: Page) -> None:
    web.go(guest, "emulator")
    until(lambda: "plc1 alive" in guest.inner_text("#state"), "the link lives")
    guest.click("[data-plug=plc1]")
    until(lambda: "plc1 silent" in guest.inner_text("#state"), "the link is red")
    guest.screenshot(path=pictures() / "plug-pulled.png")
    guest.click("[data-plug=plc1]:has-text('Put the plug back')")
    until(lambda: "plc1 alive" in guest.inner_text("#state"), "and green again by itself")


def test_pages_survive_a_restart_of_services_and_of_the_web_process(web: WebRun, guest: Page) -> None:
    web.go(guest, "overview")
    pid, _ = web.run.kill("services")
    until(lambda: "services start again" in guest.inner_text("#state"), "the loss is told")
    web.run.back("services", pid)
    until(lambda: "services start again" not in guest.inner_text("#state"), "it is over")
    until(lambda: "plc1 alive" in guest.inner_text("#state"), "the link is back")
    pid = web.run.pid("web")
    os.kill(pid, signal.SIGKILL)
    guest.wait_for_selector("#lost")
    until(lambda: guest.locator("#lost").count() == 0, "the page has connected by itself")
    before = guest.inner_text("#cycle")
    until(lambda: guest.inner_text("#cycle") != before, "and its values live")


def test_german_dark_and_the_keyboard(web: WebRun, guest: Page) -> None:
    guest.click("#language")
    until(lambda: "keine Sicherheitseinrichtung" in guest.inner_text("#foot"), "the text is German")
    assert guest.inner_text("#nav-lines") == "Leitungen"
    guest.click("#theme")
    assert guest.evaluate("document.documentElement.dataset.theme") == "dark"
    guest.click("#theme")
    guest.click("#language")
    guest.keyboard.press("Alt+5")
    web.ready(guest, "lines")
    assert guest.locator("#nav-lines[aria-current=page]").count() == 1
    guest.keyboard.press("Shift+Escape")
    until(lambda: "Stop is ordered" in guest.inner_text("#toasts"), "stop by the keyboard, without a password")


CONTRAST = """() => {
  const rgb = (text) => { const m = text.match(/[\\d.]+/g).map(Number); return m.length > 3 ? m : [...m, 1]; };
  const light = ([r, g, b]) => { const f = (c) => { c /= 255; return c <= .03928 ? c / 12.92 : ((c + .055) / 1.055) ** 2.4; };
    return .2126 * f(r) + .7152 * f(g) + .0722 * f(b); };
  const ground = (e) => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor); if (c[3] > .5) return c; }
    return [255, 255, 255]; };
  const low = new Set();
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement;
    if (!walk.currentNode.textContent.trim() || e.closest('canvas,.uplot,.skip') || e.closest(':disabled') || !e.checkVisibility()) continue;
    const [a, b] = [light(rgb(getComputedStyle(e).color)), light(ground(e))].sort((x, y) => y - x);
    if ((a + .05) / (b + .05) < 4.5) low.add(`${e.tagName}.${e.className}: ${walk.currentNode.textContent.slice(0, 30)} ${((a + .05) / (b + .05)).toFixed(2)}`);
  }
  return [...low];
}"""  # noqa: E501


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_every_page_is_pictured_readable_and_fits(web: WebRun, dark: bool) -> None:
    context = web.context(dark=dark)
    page = web.page(context)
    web.login(page)
    look = "dark" if dark else "light"
    for name in PAGES:
        web.go(page, name)
        page.wait_for_selector(FILLED.get(name, "main section"))
        page.evaluate("document.getElementById('toasts').replaceChildren()")
        for size, screen in (("desktop", DESKTOP), ("tablet", TABLET)):
            page.set_viewport_size(screen)
            page.wait_for_timeout(100)  # the plot and the robot take their new size
            page.screenshot(path=pictures() / f"{name}-{look}-{size}.png")
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), f"{name} is wider than a {size}"
        assert page.evaluate(CONTRAST) == [], f"{name}: text that cannot be read"
        page.set_viewport_size(DESKTOP)
    context.close()
    assert web.complaints == []


def test_too_many_wrong_passwords_have_to_wait(web: WebRun) -> None:
    found = [web.ask("POST", "/api/login", {"name": ADMIN, "password": f"wrong {n}"}, **HEADERS)[0] for n in range(6)]
    assert found[:1] == [401]
    assert found[-1] == 429
    assert web.ask("POST", "/api/login", {"name": ADMIN, "password": PASSWORD}, **HEADERS)[0] == 429, "not even the right one is heard"


def test_everything_that_was_changed_stands_in_the_audit(web: WebRun, boss: Page) -> None:
    told = boss.evaluate("fetch('/api/audit').then(r => r.json())")
    whats = {entry["what"] for entry in told["entries"]}
    assert told["broken_at"] is None
    assert {"POST /api/setup", "POST /api/force", "POST /api/command", "POST /api/cable", "wrong password"} <= whats
    assert PASSWORD not in json.dumps(told)


def test_the_interface_describes_itself(web: WebRun) -> None:
    with urllib.request.urlopen(f"{web.url}/api/openapi.json") as answer:
        described = json.load(answer)
    assert "/api/jobs/{number}" in described["paths"]
    assert described["paths"]["/api/command"]["post"]["x-role"] == "operator"


def test_schemathesis_finds_no_servers_fault(web: WebRun, boss: Page) -> None:
    """What we did not write asks everything the interface describes, as an administrator's script; the last one here: it plays havoc."""
    token = boss.evaluate(
        """async () => { const me = await (await fetch('/api/me')).json();
        const answer = await fetch('/api/tokens', {method: 'POST', body: '{"label": "fuzz", "role": "admin"}',
          headers: {'content-type': 'application/json', 'x-axisgate-csrf': me.csrf}}); return (await answer.json()).token; }"""
    )
    command = [sys.executable, "-m", "schemathesis.cli", "run", f"{web.url}/api/openapi.json", "--header", f"authorization: Bearer {token}"]
    command += ["--checks", "not_a_server_error", "--seed", "1", "--max-examples", "3", "--max-time", "5", "--request-timeout", "20"]
    command += ["--exclude-path", "/api/logout", "--phases", "coverage,fuzzing", "--warnings", "off", "--no-color", "--no-shrink"]
    found = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert found.returncode == 0, found.stdout[-3000:] + found.stderr[-1000:]
    assert "not_a_server_error" in found.stdout or "passed" in found.stdout
    assert web.ask("GET", "/api/health") == (200, {"cycle": True, "services": True}), "and everything still lives"
