"""Every page of a really running cell, clicked through with a real browser.  One cell and one browser for all of it, in this order."""

import json
import os
import pathlib
import re
import signal
import urllib.request
from collections.abc import Iterator

import numpy as np
import pytest
from asammdf import MDF
from playwright.sync_api import Page

from gateway.pure.image.records.cell import Motion
from gateway.scope.recording import load
from hil_tests.bench.web_bench import CHANNELS, recorded
from hil_tests.lab.judges.web_looks import CONTRAST, FILLED
from hil_tests.lab.partners.plc2 import ModbusPlc
from hil_tests.lab.running.web_running import ADMIN, DESKTOP, PAGES, PASSWORD, TABLET, WebRun, pictures, until, web_run
from hil_tests.lab.running.web_steps import Orders, schemathesis

pytestmark = [pytest.mark.slow, pytest.mark.browser]
HEADERS = {"x_axisgate": "1"}
QUIET = "document.getElementById('toasts').replaceChildren()"
RECORDS = "document.getElementById('scope-plot').dataset.records || 0"


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
    boss.click("button:has-text('Create')")
    until(lambda: "axg_" in boss.inner_text("#token"), "the token is shown once")
    token = boss.inner_text("#token").split()[-1]
    bearer = {"authorization": f"Bearer {token}"}
    assert web.ask("GET", "/api/me", **bearer)[1]["role"] == "viewer"
    assert web.ask("POST", "/api/force", {"bit": 40, "value": 1}, **bearer)[0] == 403, "a viewer's token forces nothing"
    assert web.ask("GET", "/api/me", authorization="Bearer axg_wrong")[0] == 401
    until(lambda: "the chain is intact" in boss.inner_text("body"), "the audit is verified")


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
    web.in_control(boss)
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


def test_a_reference_run_lasts_as_long_as_its_key_is_held(web: WebRun, boss: Page) -> None:
    web.in_control(boss)
    key = boss.locator("[data-ref=A6]")
    key.hover()
    boss.mouse.down()
    until(lambda: "referencing" in boss.inner_text("#state"), "A6 seeks its switch while the key is held")
    boss.mouse.up()
    until(lambda: "at rest" in boss.inner_text("#state"), "and stops when it is released")
    assert boss.inner_text("[data-referenced=A6]") == "no", "it was not done yet"
    key.hover()
    boss.mouse.down()
    until(lambda: boss.inner_text("[data-referenced=A6]") == "yes", "held to its end, A6 is referenced")
    boss.mouse.up()


def test_a_lost_connection_lifts_the_finger(web: WebRun, boss: Page) -> None:
    web.in_control(boss)
    boss.locator("[data-jog='5-']").hover()
    boss.mouse.down()
    until(lambda: "moving" in boss.inner_text("#state"), "A6 moves")
    boss.context.set_offline(True)  # the key is still down
    until(lambda: web.run.state().motion is Motion.IDLE, "the axis stops without anybody's help")
    boss.context.set_offline(False)
    boss.mouse.up()
    until(lambda: "at rest" in boss.inner_text("#state"), "the page is back")


def test_the_scope_keeps_what_was_before_its_trigger(web: WebRun, boss: Page) -> None:
    web.in_control(boss)
    orders = Orders(web, boss)

    def moves(degrees: float) -> bool:
        why = orders.refused("ptp_relative", 32, velocity=0.1, targets=[0, 0, 0, 0, 0, degrees])
        if why == "NOT_REFERENCED":
            orders.refused("reference", 32)
        elif why in ("DRIVES_OFF", "OVERRIDE_ZERO"):  # a busy machine let the drives stop meanwhile
            for code in ("fault_reset", "enable", "override"):
                orders.refused(code, 63)
                boss.wait_for_timeout(1000)
        return not why

    until(lambda: moves(0.0), "it has its reference and could move")
    web.go(boss, "scope")
    for name in ("axis.A1.set", "axis.A1.actual", "axis.A1.lag"):
        boss.click(f"[data-channel='{name}']")
    for name in ("axis.A6.set", "axis.A6.actual", "axis.A6.speed"):
        boss.fill("#channel", name)
        boss.click("#add-channel")
    boss.select_option("#trigger-form", ">")
    boss.fill("#trigger-at", "axis.A6.speed")
    boss.fill("#trigger-level", "1")
    boss.fill("#scope-pre", "0.5")
    boss.fill("#scope-seconds", "1.5")
    boss.click("#record")
    until(lambda: "waiting for axis.A6.speed > 1" in boss.inner_text("#scope-state"), "it is armed")
    until(lambda: int(boss.evaluate(RECORDS)) == 0, "nothing is kept before the trigger")
    boss.wait_for_timeout(700)  # what is to be seen before the trigger has to have been
    until(lambda: moves(20.0), "the move is taken")
    until(lambda: "records" in boss.inner_text("#scope-state"), "it has fired")
    boss.wait_for_selector("#scope-plot canvas")
    boss.wait_for_selector("#scope-plot[data-records]")
    rows = int(boss.get_attribute("#scope-plot", "data-records") or 0)
    assert rows == sum(round(each / web.run.p5_ms) for each in (500, 1500)), "before and after the trigger, whole"
    boss.fill("#cursor-a", "-0.2")
    boss.press("#cursor-a", "Tab")
    boss.fill("#cursor-b", "0.2")
    boss.press("#cursor-b", "Tab")
    speed = [float(text) for text in boss.locator("tr", has_text="axis.A6.speed").locator("td").all_inner_texts()[2:5]]
    assert speed[0] == 0.0, "before the trigger the axis stood"
    assert speed[1] > 1.0 and speed[2] == speed[1] - speed[0], "after it, it moves; their difference beside them"


def test_a_recording_is_kept_reopened_and_taken_away(web: WebRun, boss: Page, tmp_path: pathlib.Path) -> None:
    boss.fill("#recording-name", "edge")
    boss.click("#keep")
    until(lambda: "edge" in boss.inner_text("#kept"), "it is kept on the gateway")
    boss.click("#xy")
    until(lambda: boss.evaluate("document.getElementById('scope-xy').width > 200"), "one channel over another is drawn")
    boss.click("#xy")
    boss.click("#record")
    until(lambda: boss.inner_text("#record") == "End the recording", "another one begins")
    boss.click("#record")
    until(lambda: "stopped before its trigger" in boss.inner_text("#scope-state"), "and is ended")
    boss.click("#reopen")
    until(lambda: "trigger axis.A6.speed > 1" in boss.inner_text("#scope-about"), "the old one is there again")
    taken = {}
    for kind in ("scope", "csv", "mf4"):
        with boss.expect_download() as download:
            boss.click(f"#take-{kind}")
        taken[kind] = tmp_path / download.value.suggested_filename
        download.value.save_as(taken[kind])
    assert taken["csv"].name == "edge.csv"
    recording = load(taken["scope"])
    lines = taken["csv"].read_text(encoding="utf-8-sig").splitlines()
    assert lines[0] == "t [s];axis.A6.set [deg];axis.A6.actual [deg];axis.A6.speed [deg/s]"
    assert len(lines) == len(recording.time) + 1
    with MDF(taken["mf4"]) as mdf:
        assert np.array_equal(mdf.get("axis.A6.speed").samples, recording.column("axis.A6.speed"))
    speed, zero = recording.column("axis.A6.speed"), int(np.argmin(np.abs(recording.time)))
    assert speed[zero - 1] <= 1.0 < speed[zero], "time 0 is where the level was passed"
    assert recording.lost == 0


def test_a_data_word_is_forced_for_the_plc_and_marked(web: WebRun, boss: Page) -> None:
    web.go(boss, "signals")
    boss.fill("#search", "DB11.DW2")
    boss.click("[data-force='db:11:2=value']")
    boss.fill("#asked", "-12.5")
    boss.click("#send")
    until(lambda: boss.locator("tr.forced [data-id='db:11:2']").count() == 1, "the word is marked in its row")
    until(lambda: boss.inner_text("[data-id='db:11:2']") == "-12.5" and "1 forced" in boss.inner_text("#state"), "and on every page")
    until(lambda: web.plc.status.word(2) == -125, "the PLC fetches it")
    boss.click("[data-force='db:11:2=end']")
    until(lambda: "forced" not in boss.inner_text("#state"), "its mark is gone")
    until(lambda: web.plc.status.word(2) != -125, "and the PLC reads the axis again")


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
    boss.evaluate(QUIET)
    boss.screenshot(path=pictures() / "signals-forced.png")
    boss.click("[data-force='in:40=end']")
    until(lambda: boss.inner_text("[data-id='in:40']") == "0", "the force has ended")
    until(lambda: "forced" not in boss.inner_text("#state"), "and its mark is gone")
    boss.fill("#search", "A1.actual")
    boss.click("[data-row='axis.A1.actual']")
    until(lambda: "DB 11 DW 2" in boss.inner_text("#detail"), "where-used names the word the PLC reads")
    assert "written by: cycle" in boss.inner_text("#detail")


def test_lines_and_bus_are_decoded(web: WebRun, boss: Page) -> None:
    web.go(boss, "lines")
    for words in ("SEND DB10.DW0, 32 words", "FETCH DB11.DW0, 32 words", "reaction 00h no error"):
        boss.wait_for_selector(f"td:has-text('{words}')")
    plc2 = ModbusPlc("127.0.0.1", web.run.port)
    plc2.start()
    until(lambda: "write coils 24..28: 11111" in boss.inner_text("[data-modbus=plc2]"), "requests of the other PLC are told in words")
    until(lambda: "read input registers" in boss.inner_text("[data-modbus=plc2]"), "and so are its answers")
    plc2.stop()
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
    web.in_control(boss)  # which resets it
    web.go(boss, "overview")
    until(lambda: "drive fault" not in boss.inner_text("#first-out"), "it is reset")


def test_the_plug_is_pulled_and_it_comes_back(web: WebRun, guest: Page) -> None:
    web.go(guest, "emulator")
    until(lambda: "plc1 alive" in guest.inner_text("#state"), "the link lives")
    guest.click("[data-plug=plc1]")
    until(lambda: "plc1 silent" in guest.inner_text("#state"), "the link is red")
    guest.evaluate(QUIET)
    guest.screenshot(path=pictures() / "plug-pulled.png")
    guest.click("[data-plug=plc1]:has-text('Plug in again')")
    until(lambda: "plc1 alive" in guest.inner_text("#state"), "and green again by itself")


def test_pages_survive_a_restart_of_services_and_of_the_web_process(web: WebRun, guest: Page) -> None:
    web.go(guest, "overview")
    restarts = "tr:has(td:text-is('services')) td:nth-child(3)"
    before = guest.inner_text(restarts)
    pid, _ = web.run.kill("services")
    web.run.back("services", pid)  # their spare is there sooner than a page can tell that they were away
    until(lambda: guest.inner_text(restarts) != before, "the restart is told")
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
    guest.keyboard.press("Alt+6")
    web.ready(guest, "lines")
    assert guest.locator("#nav-lines[aria-current=page]").count() == 1
    guest.keyboard.press("Shift+Escape")
    until(lambda: "Stop requested" in guest.inner_text("#toasts"), "stop by the keyboard, without a password")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_every_page_is_pictured_readable_and_fits(web: WebRun, dark: bool) -> None:
    context = web.context(dark=dark)
    page = web.page(context)
    web.login(page)
    look = "dark" if dark else "light"
    plc2 = ModbusPlc("127.0.0.1", web.run.port)
    plc2.start()
    until(lambda: "plc2 alive" in page.inner_text("#state"), "both PLCs are there")
    for name in PAGES:
        web.go(page, name)
        if name == "scope":
            page.click("#reopen")  # what was kept before the web process died
        page.wait_for_selector(FILLED.get(name, "main section"))
        page.evaluate(QUIET)
        for size, screen in (("desktop", DESKTOP), ("tablet", TABLET)):
            page.set_viewport_size(screen)
            page.evaluate("document.querySelector('main').scrollTo(0, 0)")
            page.wait_for_timeout(100)  # the plot and the robot take their new size
            page.screenshot(path=pictures() / f"{name}-{look}-{size}.png")
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), f"{name} is wider than a {size}"
        assert page.evaluate(CONTRAST) == [], f"{name}: text that cannot be read"
        page.set_viewport_size(DESKTOP)
    plc2.stop()
    context.close()
    assert web.complaints == []


def test_sixteen_channels_are_recorded_whole_by_the_page(web: WebRun, boss: Page) -> None:
    """The short form of `axisgate bench web`, which asks for ten minutes at 2 ms."""
    records, wanted, lost = recorded(web, 2.0, web.run.p5_ms)
    assert (records, lost) == (wanted, 0)
    own = web.headers()
    told = web.ask("POST", "/api/scope/start", {"channels": CHANNELS, "seconds": 600.0}, **own)
    assert told[0] == 200, ("ten minutes are not too long", told)
    assert web.ask("POST", "/api/scope/stop", {}, **own)[0] == 200


def test_too_many_wrong_passwords_have_to_wait(web: WebRun) -> None:
    found = [web.ask("POST", "/api/login", {"name": ADMIN, "password": f"wrong {n}"}, **HEADERS)[0] for n in range(6)]
    assert found[:1] == [401]
    assert found[-1] == 429
    assert web.ask("POST", "/api/login", {"name": ADMIN, "password": PASSWORD}, **HEADERS)[0] == 429, "not even the right one is heard"


def test_everything_that_was_changed_is_in_the_audit(web: WebRun, boss: Page) -> None:
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
    """The last one here: it plays havoc."""
    found = schemathesis(web, boss)
    assert found.returncode == 0, found.stdout[-3000:] + found.stderr[-1000:]
    made = re.search(r"(\d+) generated", found.stdout)
    assert made is not None and int(made[1]) > 60, found.stdout[-1000:]
    assert web.ask("GET", "/api/health") == (200, {"cycle": True, "services": True}), "and everything still lives"
