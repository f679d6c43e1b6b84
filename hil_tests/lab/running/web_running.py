"""A cell with its page, a PLC on its line, and Debian's chromium in front of it."""

import contextlib
import http.client
import json
import pathlib
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Error, Page, ViewportSize, sync_playwright

from gateway.simulation.line.control import LineControl
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.running.cell_running import P5_MS, CellRun, free_port, running_cell

CHROMIUM = shutil.which("chromium")
# Without a GPU everything but WebGL is painted by the processor at once: ten times quicker on a busy machine than through a software GPU
FLAGS = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"]
PATIENCE_S = 40.0
DESKTOP, TABLET = ViewportSize(width=1366, height=850), ViewportSize(width=1024, height=768)
PHONE = ViewportSize(width=390, height=844)
ADMIN, PASSWORD = "anna", "correct horse 7"
PAGES = ("overview", "axes", "motion", "signals", "scope", "lines", "bus", "events", "cell", "emulator", "access")


@dataclass
class WebAsk:
    """Requests without a browser."""

    port: int

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def ask(self, method: str, path: str, body: object = None, **headers: str) -> tuple[int, Any]:
        """Status, and the answer's JSON."""
        link = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        sent = {"content-type": "application/json", **{name.replace("_", "-"): value for name, value in headers.items()}}
        link.request(method, path, json.dumps(body) if body is not None else None, sent)
        answer = link.getresponse()
        data = answer.read()
        link.close()
        with contextlib.suppress(ValueError):
            return answer.status, json.loads(data)
        return answer.status, data

    def headers(self, name: str = ADMIN, password: str = PASSWORD) -> dict[str, str]:
        """Headers of a login without a browser; the first one sets the first password."""
        fresh = self.ask("GET", "/api/me")[1]["fresh"]
        link = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        body = json.dumps({"name": name, "password": password})
        link.request("POST", "/api/setup" if fresh else "/api/login", body, {"content-type": "application/json", "x-axisgate": "1"})
        answer = link.getresponse()
        assert answer.status == 200, answer.read()
        cookie = str(answer.headers["set-cookie"]).partition(";")[0]
        link.close()
        return {"cookie": cookie, "x_axisgate_csrf": str(self.ask("GET", "/api/me", cookie=cookie)[1]["csrf"])}

    def answers(self) -> bool:
        """The page is there."""
        with contextlib.suppress(OSError):
            return self.ask("GET", "/api/health")[0] == 200
        return False


@dataclass
class WebRun(WebAsk):
    """One run and one browser."""

    run: CellRun
    plc: S5Plc
    browser: Browser
    complaints: list[str] = field(default_factory=list)  # errors in pages

    def context(self, *, dark: bool = False, tablet: bool = False, phone: bool = False) -> BrowserContext:
        """A browser of its own: no cookie of another."""
        context = self.browser.new_context(
            viewport=PHONE if phone else TABLET if tablet else DESKTOP,
            has_touch=tablet or phone,
            color_scheme="dark" if dark else "light",
            locale="en-GB",
        )
        context.set_default_timeout(PATIENCE_S * 1000)
        return context

    def page(self, context: BrowserContext, name: str = "overview") -> Page:
        page = context.new_page()
        page.on("pageerror", lambda error: self.complaints.append(f"{name}: {error}"))
        page.goto(f"{self.url}/{name}")
        self.ready(page, name)
        return page

    @staticmethod
    def ready(page: Page, name: str) -> None:
        """The page is built and connected."""
        page.wait_for_selector(f"body[data-page={name}]")
        page.wait_for_selector("#state .chip")

    def go(self, page: Page, name: str) -> None:
        """By the navigation, as a person goes."""
        page.click(f"#nav-{name}")
        self.ready(page, name)

    def login(self, page: Page, name: str = ADMIN, password: str = PASSWORD) -> None:
        """Through the dialog; the first time it sets the password."""
        page.click("#login")
        page.fill("input[name=name]", name)
        page.fill("input[name=password]", password)
        page.click("#send")
        page.wait_for_selector("#logout")

    def in_control(self, page: Page) -> None:
        """On the axes page with control and drives on; what a busy machine has taken away meanwhile is taken back."""
        self.go(page, "axes")
        axes = len(self.run.demo.axis)

        def tried() -> bool:
            if f"drives on {axes}/{axes}" in page.inner_text("#state") and page.inner_text("#control") == "Release control":
                return True
            page.click("#permit", timeout=2000)
            if page.inner_text("#control") == "Request control":
                page.click("#control", timeout=2000)
            for code in ("fault_reset", "enable"):  # a drive that is still being reset cannot be switched on
                page.click(f"[data-code={code}]", timeout=2000)
                page.wait_for_timeout(1000)
            return False

        until(tried, "control was given and the drives are on")


def until(holds: Callable[[], bool], what: str, patience_s: float = PATIENCE_S) -> None:
    """Waits for a condition; an element that was being replaced is looked up again."""
    end = time.monotonic() + patience_s
    while True:
        with contextlib.suppress(Error):
            if holds():
                return
        assert time.monotonic() < end, f"not within {patience_s:.0f} s: {what}"
        time.sleep(0.05)


@contextlib.contextmanager
def web_run(name: str = "web", *, p5_ms: int = max(10, P5_MS), cell: str = "demo") -> Iterator[WebRun]:
    """The demo's cell, or one made of it, with its page on a free port and PLC 1 on its line."""
    port = free_port()
    with contextlib.ExitStack() as stack:
        run = stack.enter_context(running_cell(cell, name, plc=False, p5_ms=p5_ms, more=("--web", str(port))))
        plc = S5Plc(LineControl.path(f"{name}-plc1", "a"), [axis.name for axis in run.demo.axis])
        plc.start()
        stack.callback(plc.stop)
        playwright = stack.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        stack.callback(browser.close)
        web = WebRun(port, run, plc, browser)
        until(web.answers, "the page answers")
        yield web


def pictures() -> pathlib.Path:
    """Where the screenshots of a test run go."""
    folder = pathlib.Path(__file__).resolve().parents[3] / "build" / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    return folder
