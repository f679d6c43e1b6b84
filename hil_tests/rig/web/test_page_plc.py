"""The page PLC of a running cell: its state, the listing with its test display, forced inputs and markers by hand."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

from hil_tests.lab.running.web_running import CHROMIUM, WebRun, pictures, until, web_run

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium here"), pytest.mark.timeout(300)]


@pytest.fixture(scope="module")
def web() -> Iterator[WebRun]:
    with web_run("plcpage", cell="reis-plc") as run:
        yield run


@pytest.fixture(scope="module")
def boss(web: WebRun) -> Iterator[Page]:
    context = web.context()
    page = web.page(context)
    web.login(page)
    web.go(page, "plc")
    until(lambda: "RUN" in page.inner_text("#plc-state"), "the PLC runs")
    yield page
    context.close()


def shown(page: Page, step: int) -> list[str]:
    """State, VKE, ACCU1 and ACCU2 of a step of the listing."""
    found: list[str] = page.eval_on_selector_all(
        "main tbody tr",
        "(rows, step) => [...rows.find((row) => row.children[0].textContent === step).children].slice(2).map((td) => td.textContent)",
        str(step),
    )
    return found


def test_the_listing_shows_state_vke_and_accumulators_of_each_step_live(boss: Page) -> None:
    until(lambda: shown(boss, 2)[:2] == ["0", "0"], "the test display is on")
    assert shown(boss, 16)[0] == "NOP", "behind a jump that was taken"
    boss.click("tbody button:has-text('U E0.0')")
    boss.fill("#plc-value", "1")
    boss.click("#plc-write")
    until(lambda: shown(boss, 2)[:2] == ["1", "1"], "the forced input is seen by the program")
    boss.select_option("#plc-numbers", "hex")
    until(lambda: shown(boss, 7)[2] == "C8H", "L 200 in ACCU1")
    boss.screenshot(path=pictures() / "plc.png")
    boss.click("#plc-free")
    until(lambda: shown(boss, 2)[:2] == ["0", "0"], "the force is ended")


def test_a_marker_is_written_and_one_of_the_robot_is_refused(web: WebRun, boss: Page) -> None:
    boss.fill("#plc-operand", "M100")
    boss.fill("#plc-value", "41")
    boss.click("#plc-write")
    until(lambda: web.ask("GET", "/api/value?address=MB%20100")[1]["value"] == 41, "the marker has its value")
    boss.fill("#plc-operand", "M1021.2")
    boss.click("#plc-write")
    until(lambda: "ihn schreibt der Roboter" in boss.inner_text("#toasts"), "the refusal is shown")
    said = [each["say"] for each in web.ask("GET", "/api/audit", **web.headers())[1]["entries"]]
    assert ["wrote 41 to M100", "M100 mit 41 beschrieben"] in said


def test_the_plc_is_stopped_and_started(boss: Page) -> None:
    boss.click("#plc-stop")
    until(lambda: "STOP" in boss.inner_text("#plc-state"), "stopped")
    boss.click("#plc-start")
    until(lambda: "RUN" in boss.inner_text("#plc-state"), "it runs again")
    until(lambda: shown(boss, 2)[:2] == ["0", "0"], "and its test display is on again")


def test_the_pendant_has_its_display_and_its_keys(web: WebRun, boss: Page) -> None:
    """20 lines, typed and clicked keys, the PLC started by RUN, a movement key that needs control; a viewer presses none (AX-1660)."""
    web.go(boss, "pendant")
    until(lambda: boss.inner_text("#phg-screen").count("\n") == 19 and "DIR /" in boss.inner_text("#phg-screen"), "the display")
    boss.click("#phg-keys [data-key=INFO]")
    boss.focus("#phg-screen")
    boss.keyboard.press("PageDown")
    boss.keyboard.press("F3")
    until(lambda: "_SPS[1]" in boss.inner_text("#phg-screen"), "the markers")
    boss.screenshot(path=pictures() / "pendant.png", full_page=True)
    for key in ("RUN", "MENU+", "F2"):
        boss.click(f"#phg-keys [data-key='{key}']")
    until(lambda: "die SPS wird gestartet" in boss.inner_text("#phg-screen"), "Start PLC, in the language of the cell")
    boss.hover("#phg-keys [data-key='1+']")
    boss.mouse.down()
    until(lambda: "kein Speicher" in " ".join(boss.inner_text("#phg-screen").split()), "this cell has no robot programs")
    boss.mouse.up()
    said = [each["say"] for each in web.ask("GET", "/api/audit", **web.headers())[1]["entries"]]
    assert ["pressed 1+ at the pendant", "1+ am Handgerät gedrückt"] in said
    boss.click("#phg-control")
    boss.wait_for_timeout(3500)  # longer than a page that shows no life keeps control
    assert boss.inner_text("#phg-control") == "Steuerung abgeben"
    boss.click("#phg-control")
    until(lambda: boss.inner_text("#phg-control") == "Steuerung anfordern", "control is released")
    context = web.context()
    viewer = web.page(context, "pendant")
    until(lambda: viewer.locator("#phg-keys [data-key=RUN]").is_disabled(), "a viewer looks only")
    context.close()
    assert web.complaints == []


def test_a_viewer_changes_nothing(web: WebRun) -> None:
    for path, body in (("start", {"name": ""}), ("stop", None), ("write", {"operand": "M100", "value": "1"})):
        assert web.ask("POST", f"/api/plc/{path}", body, x_axisgate="1")[0] in (401, 403)
    assert web.ask("GET", "/api/plc/listing?name=NONE")[0] == 404
    assert web.ask("GET", "/api/plc/listing?name=MAIN&first=x")[0] == 400
