"""The page where something is wrong: a hung process, a browser that stood still, refused keys, devices that are away.  In this order."""

import contextlib
import json
import os
import pathlib
import re
import signal
import time
from collections.abc import Iterator

import pytest
from playwright.sync_api import Error as PlaywrightError
from playwright.sync_api import Page

from gateway.pure.image.records.cell import Motion
from hil_tests.lab.running.cell_running import free_port
from hil_tests.lab.running.modbus_running import Running
from hil_tests.lab.running.web_running import CHROMIUM, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")]
CLIENTS = """
[[modbus]]
name = "oven"
role = "client"
port = "tcp://127.0.0.1:{oven}"
[[modbus.device]]
name = "tank"
[[modbus.value]]
device = "tank"
table = "holding"
at = 60000
type = "UINT16"
to = "tank.level"
[[modbus]]
name = "far"
role = "client"
port = "tcp://127.0.0.1:{far}"
[[modbus.device]]
name = "pump"
[[modbus.value]]
device = "pump"
table = "holding"
at = 1
type = "UINT16"
to = "pump.speed"
"""
JOG = "[data-jog='5+']"
FULL = """() => fetch('/api/me').then(r => r.json()).then(me => fetch('/api/command', {method: 'POST',
  body: '{"code": "override"}', headers: {'content-type': 'application/json', 'x-axisgate-csrf': me.csrf}}))"""
STOP_IS_ON_TOP = """() => { const r = document.getElementById('stop').getBoundingClientRect();
  return r.left >= 0 && r.top >= 0 && r.right <= innerWidth && r.bottom <= innerHeight && [[4, 4], [r.width / 2, r.height / 2],
  [r.width - 4, r.height - 4]].every(([x, y]) => document.elementFromPoint(r.left + x, r.top + y)?.id === 'stop'); }"""
MANY = "import('/static/dom.js').then(d => { for (let n = 0; n < 60; n += 1) d.toast(`${n} ` + 'words '.repeat(60), 'bad'); })"


@pytest.fixture(scope="module")
def web(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebRun]:
    demo = pathlib.Path(__file__).parents[3] / "configs/cells/demo.toml"
    file = tmp_path_factory.mktemp("cell") / "faults.toml"
    with Running() as oven:
        file.write_text(demo.read_text() + CLIENTS.replace("{oven}", str(oven.port)).replace("{far}", str(free_port())))
        with web_run("faults", cell=str(file)) as run:
            yield run


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    context = web.context()
    page = web.page(context)
    web.login(page)
    yield page
    context.close()


def stays_at_rest(web: WebRun, seconds: float) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if web.run.state().motion is not Motion.IDLE:
            return False
        time.sleep(0.02)
    return True


def toasts(page: Page) -> list[str]:
    return page.locator(".toast").all_inner_texts()


def pressed(web: WebRun, page: Page) -> None:
    """The jog key of A6 is down and the axis moves."""
    web.in_control(page)
    page.evaluate(FULL)
    until(lambda: "override 100 %" in page.inner_text("#state"), "override 100 %")
    page.locator(JOG).hover()
    page.mouse.down()
    until(lambda: web.run.state().motion is Motion.RUNNING, "A6 moves", 15)


def test_devices_that_are_away_and_reads_refused_are_on_the_page(web: WebRun, boss: Page) -> None:
    web.go(boss, "lines")
    until(lambda: "exception 02h illegal data address" in boss.inner_text("#asked tr:has-text('tank')"), "the refused read")
    assert "answers" in boss.inner_text("#asked tr:has-text('tank')")
    until(lambda: "no connection" in boss.inner_text("#asked tr:has-text('pump')"), "the pump that was never reached")
    assert "oven alive" in boss.inner_text("#state") and "far silent" in boss.inner_text("#state")
    shown = boss.inner_text("[aria-label='Lines plc1'] tbody tr td:first-child")
    here = boss.evaluate("Date.now() % 60000")
    assert re.fullmatch(r"\d\d:\d\d:\d\d\.\d{3}", shown), "the time of day"
    assert (here - (int(shown[6:8]) * 1000 + int(shown[9:]))) % 60_000 < 15_000
    boss.screenshot(path=pictures() / "lines-modbus-devices.png", full_page=True)


def test_after_stop_a_key_that_is_still_held_moves_nothing(web: WebRun, boss: Page) -> None:
    pressed(web, boss)
    boss.keyboard.press("Shift+Escape")
    until(lambda: web.run.state().motion in (Motion.IDLE, Motion.STOPPED), "it stops")
    web.go(boss, "axes")
    assert not boss.evaluate("document.querySelector('button.down')")
    boss.mouse.up()
    boss.locator("[data-code=abandon]").click()
    until(lambda: web.run.state().motion is Motion.IDLE, "nothing waits")


def test_a_stop_from_elsewhere_ends_the_held_key(web: WebRun, boss: Page) -> None:
    pressed(web, boss)
    assert web.ask("POST", "/api/stop", x_axisgate="1")[0] == 200
    until(lambda: web.run.state().motion is Motion.STOPPED, "it stops on the path")
    time.sleep(1.0)
    assert web.run.state().motion is Motion.STOPPED, "the key is still down, and moves nothing"
    until(lambda: any("release the key" in each for each in toasts(boss)), "it says what to do")
    boss.mouse.up()
    boss.locator("[data-code=abandon]").click()
    until(lambda: web.run.state().motion is Motion.IDLE, "nothing waits")


def test_a_browser_that_stood_still_never_jogs_on(web: WebRun, boss: Page) -> None:
    pressed(web, boss)
    boss.evaluate("const end = Date.now() + 1500; while (Date.now() < end);")  # the key stays down meanwhile
    until(lambda: web.run.state().motion is Motion.IDLE, "it stopped by itself")
    assert stays_at_rest(web, 1.5), "it goes on though nobody pressed the key again"
    boss.mouse.up()


def test_a_page_that_lost_its_focus_never_jogs_on(web: WebRun, boss: Page) -> None:
    pressed(web, boss)
    boss.evaluate("window.dispatchEvent(new Event('blur'))")
    until(lambda: web.run.state().motion is Motion.IDLE, "it stops")
    boss.evaluate("window.dispatchEvent(new Event('focus'))")
    assert stays_at_rest(web, 1.0)
    boss.mouse.up()


def test_a_key_pressed_on_an_old_picture_moves_nothing(web: WebRun, boss: Page) -> None:
    """What waits in a network or a hung process is carried out late, or never: never."""
    web.in_control(boss)
    told = boss.evaluate(
        """() => new Promise((done) => {
        const socket = new WebSocket(location.origin.replace('http', 'ws') + '/live');
        const answers = [];
        socket.onmessage = (event) => {
          const message = JSON.parse(event.data);
          if (message.t === 'live' && !answers.length) {
            answers.push(1);
            socket.send(JSON.stringify({t: 'jog', axis: 5, direction: 1, percent: 5, first: true, at: message.at - 3000}));
          }
          if (message.t === 'answer') { done(message); socket.close(); }
        };
        })"""
    )
    assert told["held"]["state"] == "REFUSED" and "too slow" in told["held"]["say"][0]
    assert stays_at_rest(web, 0.5)


def test_a_refused_key_says_so_once_in_words_and_is_in_the_journal_once(web: WebRun, boss: Page) -> None:
    web.in_control(boss)
    boss.click("[data-code=disable]")
    until(lambda: "drives on 0/6" in boss.inner_text("#state"), "drives are off")
    boss.evaluate("document.getElementById('toasts').replaceChildren()")

    def entries() -> int:
        return sum("jog" in json.dumps(each) or "drives are off" in each["text"] for each in web.run.journal("command"))

    before = entries()
    boss.locator(JOG).hover()
    boss.mouse.down()
    until(lambda: toasts(boss) != [], "the refusal")
    time.sleep(1.5)  # still held
    assert toasts(boss) == ["drives are off: A6. Switch the drives on."]
    assert entries() == before + 1
    boss.mouse.up()


def test_a_german_page_says_journal_lines_evidence_and_refusals_in_german(web: WebRun) -> None:
    context = web.context()
    page = web.page(context)
    page.evaluate("localStorage.setItem('language', 'de')")
    page.goto(f"{web.url}/events")
    web.ready(page, "events")
    until(lambda: "gestartet, PID" in page.inner_text("[aria-label='Ereignisse']"), "the journal's sentences")
    shown = page.inner_text("[aria-label='Ereignisse']")
    assert "keine Verbindung zu tcp://127.0.0.1" in shown and "Befehlsquelle" in shown
    for english in ("started, pid", "command source", "link is alive", "no connection to", "is tried again"):
        assert english not in shown
    web.go(page, "lines")
    until(lambda: "Ausnahme 02h" in page.inner_text("#asked tr:has-text('tank')"), "the refused read")
    until(
        lambda: re.search(r"\d+ Wörter", page.inner_text("[aria-label='Lines plc1'], [aria-label='Leitungen plc1']")) is not None, "RK512"
    )
    web.go(page, "overview")
    evidence = page.inner_text("[aria-label='Nachweis']")
    assert "Antriebe servodyn" in evidence and "kein echter Booster" in evidence and "drives servodyn" not in evidence
    told = page.evaluate(
        """() => import('/static/net.js').then(net => net.post('/api/command', {code: 'enable', mask: 1})).catch(error => error.message)"""
    )
    assert "nötig ist die Rolle Bediener" in told or "führt die Befehlsquelle der Seite" in told, told
    context.close()


def test_toasts_never_cover_stop(web: WebRun) -> None:
    for phone in (False, True):
        context = web.context(phone=phone)
        page = web.page(context)
        page.evaluate(MANY)
        page.wait_for_selector(".toast")
        stop = page.locator("#stop")
        box = stop.bounding_box()
        assert box is not None
        for x, y in ((5, 5), (box["width"] - 5, box["height"] - 5), (box["width"] / 2, box["height"] / 2)):
            found = page.evaluate("([x, y]) => document.elementFromPoint(x, y)?.id", [box["x"] + x, box["y"] + y])
            assert found == "stop"
        covering = page.evaluate(
            """() => { const s = document.getElementById('stop').getBoundingClientRect();
            return [...document.querySelectorAll('.toast, #toasts')].filter((each) => { const r = each.getBoundingClientRect();
              return r.top < s.bottom && r.bottom > s.top && r.left < s.right && r.right > s.left && r.height; }).length; }"""
        )
        assert covering == 0
        assert page.locator(".toast").count() <= 3
        context.close()


@pytest.mark.parametrize("phone", [False, True])
def test_stop_is_in_reach_while_the_page_asks_something(web: WebRun, boss: Page, *, phone: bool) -> None:
    context = web.context(phone=phone)
    page = web.page(context)

    def stops(leave: str) -> None:
        assert page.evaluate(STOP_IS_ON_TOP)
        pressed(web, boss)
        page.click("#stop", timeout=3000)
        until(lambda: web.run.state().motion is Motion.STOPPED, "STOP stops under the dialog")
        assert page.is_visible("#dialog"), "what was being asked is still asked"
        page.locator("#stop").press(leave)  # also with the focus on STOP
        until(lambda: not page.is_visible("#dialog"), "Escape leaves the question")
        boss.mouse.up()
        boss.locator("[data-code=abandon]").click()
        until(lambda: web.run.state().motion is Motion.IDLE, "nothing waits")

    page.click("#login")
    page.wait_for_selector("#dialog input[name=password]")
    page.screenshot(path=pictures() / f"dialog-login-{'phone' if phone else 'desktop'}.png")
    assert page.evaluate("document.activeElement.name") == "name"
    with pytest.raises(PlaywrightError):
        page.click("#nav-axes", timeout=500)  # everything else waits for the answer
    stops("Escape")
    web.login(page)
    web.go(page, "signals")
    page.fill("input[type=search]", "db:11:2")
    page.click("[data-force='db:11:2=value']")
    page.wait_for_selector("#asked")
    stops("Escape")
    assert "forced" not in page.inner_text("#state")
    web.go(page, "axes")  # the page is free again
    context.close()


def test_a_hung_page_process_is_shown_within_three_seconds_and_nothing_looks_alive(web: WebRun, boss: Page) -> None:
    web.go(boss, "overview")
    until(lambda: boss.locator("#state .chip.good").count() > 0, "something is good")
    pid = web.run.pid("web")
    os.kill(pid, signal.SIGSTOP)
    try:
        start = time.monotonic()
        boss.wait_for_selector("#lost", timeout=3000)
        assert time.monotonic() - start < 3.0
        assert boss.locator("#state .chip.good").count() == 0 and "ready" not in boss.inner_text("#state")
        assert float(boss.evaluate("getComputedStyle(document.querySelector('main')).opacity")) < 0.7
        boss.screenshot(path=pictures() / "lost.png")
        boss.click("#stop")
        until(lambda: any("use the emergency stop" in each for each in toasts(boss)), "that STOP did not arrive", 6)
    finally:
        with contextlib.suppress(ProcessLookupError):  # the supervisor may have ended a process without life (AX-626)
            os.kill(pid, signal.SIGCONT)
    boss.wait_for_selector("#lost", state="detached")
    until(lambda: boss.evaluate("!document.body.classList.contains('gone')"), "values are fresh again")
    assert web.complaints == []
