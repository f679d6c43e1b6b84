"""What the page costs: seconds to the first paint, MB of the first page, ms of a search, and what twenty viewers do to the cycle,
and how many records the page's scope loses in ten minutes of 16 channels at 2 ms.

The cycle is measured by its own trace ring (SYNC sent minus due) in blocks that alternate: nobody looks, twenty viewers look.  The
viewers are live connections in a process of their own, on all pages; the row gives how many were really connected.
"""

import asyncio
import contextlib
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator

from websockets.asyncio.client import connect

from gateway.pure.image.records.trace import unpack_trace
from gateway.runtime.regions import RingReader, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.scope.recording import load
from gateway.tools.progress import steps, waited
from hil_tests.lab.running.cell_running import CellRun, free_port, running_cell
from hil_tests.lab.running.web_running import CHROMIUM, FLAGS, PAGES, WebAsk, until

Figure = dict[str, object]
VIEWERS, BLOCKS, BLOCK_S, SETTLE_S = 20, 5, 4.0, 1.0
SIGNALS, WORDS = 5000, ("DB107.DW12", "axis actual", "40001", "feed allow", "move target", "RCI 26", "O3.0", "DB 140")
SCOPE_S = 600.0
CHANNELS = [f"axis.A{n}.{what}" for n in range(1, 7) for what in ("set", "actual")] + [f"axis.A{n}.lag" for n in range(1, 5)]
FIRST_PAINT = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime"


def figures(scope_s: float = SCOPE_S) -> list[Figure]:
    """All of them; `scope_s`: how long the page's scope records at 2 ms."""
    return [*page_figures(), scope_figure(scope_s)]


def page_figures() -> list[Figure]:
    """First page, search, viewers."""
    with tempfile.TemporaryDirectory(prefix="axg-web-") as folder:
        cell = pathlib.Path(folder) / "wide.toml"
        cell.write_text(wide_cell())
        port = free_port()
        with running_cell(str(cell), "webbench", plc=False, p5_ms=4, more=("--web", str(port))) as run:
            web = WebAsk(port)
            until(web.answers, "the page answers", 60.0)
            return [*first_page(web), search(web), *viewers(run, web)]


def scope_figure(seconds: float) -> Figure:
    """16 channels at 2 ms through the page, so long."""
    port = free_port()
    with running_cell("demo", "scopebench", plc=False, p5_ms=2, more=("--web", str(port))):
        web = WebAsk(port)
        until(web.answers, "the page answers", 60.0)
        records, wanted, lost = recorded(web, seconds, 2)
    met = lost == 0 and records == wanted and seconds >= SCOPE_S
    beside = f"{records} of {wanted} records of {len(CHANNELS)} channels in {seconds:g} s; the goal is {SCOPE_S:g} s"
    return figure("web.scope_lost", lost, "records", 0.0, met=met, beside=beside)


def recorded(web: WebAsk, seconds: float, p5_ms: int) -> tuple[int, int, int]:
    """(records kept, records asked for, records that never came) of one recording of the page, read from its file."""
    _, before = web.ask("GET", "/api/scope/names")
    status, told = web.ask("POST", "/api/scope/start", {"channels": CHANNELS, "seconds": seconds}, **web.headers())
    assert status == 200, told
    waited("web, scope", seconds)

    def ended() -> bool:
        _, now = web.ask("GET", "/api/scope/names")
        return bool(now["number"] > before["number"] and not now["running"])

    until(ended, "the recording has ended", 60.0)
    with tempfile.TemporaryDirectory(prefix="axg-scope-") as folder:
        file = pathlib.Path(folder) / "kept.scope"

        def there() -> bool:
            answered, octets = web.ask("GET", "/api/scope/file?as=scope")
            if answered == 200 and isinstance(octets, bytes):
                file.write_bytes(octets)
            return file.exists()

        until(there, "the recording is there", 120.0)
        recording = load(file)
    return len(recording.time), round(seconds * 1000 / p5_ms), recording.lost


def wide_cell() -> str:
    """The demo's cell with so many entries more that 5000 values and more are to be searched."""
    from gateway.files.find import find_config

    text = find_config("demo", "cells").read_text()
    return "\n".join([text, *(wide_block(number) for number in range(100, 200))])


def wide_block(number: int) -> str:
    """One data block with thirty actual values."""
    units = ["0.1 mm"] * 3 + ["0.1 deg"] * 3
    rows = [f'  {{ at = "DW {n}", type = "KF", from = "axis.A{n % 6 + 1}.actual", unit = "{units[n % 6]}" }},' for n in range(30)]
    head = f'[[db]]\nnumber = {number}\ncomment = "station {number}"\nwords = 32\nwriter = "axisgate"\nline = "plc1"'
    return "\n".join([head, "entries = [", *rows, "]", ""])


def first_page(web: WebAsk) -> list[Figure]:
    """Median of five first visits, each by a browser that knows nothing; bytes of everything it fetched."""
    from playwright.sync_api import Response, sync_playwright

    paints, weights = [], []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        for _ in steps("web, first page", range(5)):
            context = browser.new_context()
            page = context.new_page()
            answers: list[Response] = []

            def keep(answer: Response, kept: list[Response] = answers) -> None:
                kept.append(answer)

            page.on("response", keep)
            page.goto(f"{web.url}/overview")
            page.wait_for_selector("#state .chip")
            paints.append(float(page.evaluate(FIRST_PAINT)) / 1000.0)
            weights.append(sum(len(answer.body()) for answer in answers if answer.ok) / 1e6)
            context.close()
        browser.close()
    paint, weight = statistics.median(paints), max(weights)
    return [
        figure("web.first_paint_s", round(paint, 3), "s", 1.0, met=paint <= 1.0, beside="median of 5 first visits on loopback"),
        figure("web.weight_MB", round(weight, 3), "MB", 1.5, met=weight <= 1.5, beside="everything the first page fetches, not packed"),
    ]


def search(web: WebAsk) -> Figure:
    """Longest of forty searches by HTTP, the answer read whole."""
    total = web.ask("GET", "/api/tree")[1]["total"]
    times = []
    for n in range(40):
        start = time.perf_counter()
        with urllib.request.urlopen(f"{web.url}/api/signals?q={WORDS[n % len(WORDS)].replace(' ', '%20')}") as answer:
            json.load(answer)
        times.append(1000.0 * (time.perf_counter() - start))
    worst = max(times)
    met = worst <= 100.0 and total >= SIGNALS
    return figure(
        "web.search_ms",
        round(worst, 1),
        "ms",
        100.0,
        met=met,
        beside=f"worst of 40 among {total} values; median {statistics.median(times):.1f}",
    )


def viewers(run: CellRun, web: WebAsk) -> list[Figure]:
    """p99 of SYNC's lateness and skipped SYNCs, medians of alternating blocks."""
    idle: list[tuple[float, int]] = []
    busy: list[tuple[float, int]] = []
    connected = VIEWERS
    for _ in steps("web, viewers", range(BLOCKS)):
        idle.append(block(run))
        with watching(web) as crowd:
            busy.append(block(run))
            connected = min(connected, crowd.count())
    quiet, loaded = statistics.median(p99 for p99, _ in idle), statistics.median(p99 for p99, _ in busy)
    skips = statistics.median(n for _, n in idle), statistics.median(n for _, n in busy)
    goal = 1.5 * quiet + 30.0
    row = figure(
        "web.cycle_p99_us", round(loaded, 1), "us", round(goal, 1), met=loaded <= goal and connected == VIEWERS,
        beside=f"idle p99 {quiet:.1f} us; {connected} viewers on {len(PAGES)} pages; {BLOCKS} alternating blocks of {BLOCK_S:g} s",
    )  # fmt: skip
    there = figure("web.viewers", connected, "viewers", VIEWERS, met=connected == VIEWERS, beside="fewest really connected in a block")
    row |= {
        "reference": "the same run with nobody looking, us",
        "reference_value": round(quiet, 1),
        "ratio": round(loaded / max(quiet, 0.1), 2),
    }
    skipped = figure(
        "web.skipped", skips[1], "SYNC", skips[0], met=skips[1] <= skips[0], beside=f"idle {skips[0]:g}; each block {BLOCK_S:g} s"
    )
    return [there, row, {**skipped, "reference": "the same run with nobody looking", "reference_value": skips[0]}]


def block(run: CellRun) -> tuple[float, int]:
    """p99 in us of SYNC sent minus due, and grid instants without SYNC, over one block."""
    time.sleep(SETTLE_S)
    fds: dict[str, int] = {}
    try:
        with ask(run.name, "regions") as connection:
            fds = recv_fds(connection)
        ring = RingReader(fds["trace"], "trace")
        late: list[float] = []
        skipped, end = run.state().skipped, time.monotonic() + BLOCK_S
        while time.monotonic() < end:
            time.sleep(0.2)
            late += [(trace.sent - trace.due) / 1e3 for _, record in ring.take(4096) if (trace := unpack_trace(record)).sent]
        return statistics.quantiles(late, n=100)[98], run.state().skipped - skipped
    finally:
        for fd in fds.values():
            os.close(fd)


class Crowd:
    """Viewers in a process of their own."""

    def __init__(self, web: WebAsk) -> None:
        command = [sys.executable, "-m", "hil_tests.bench.web_bench", str(web.port)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        self._process.stdout.readline()

    def count(self) -> int:
        """Return how many are connected and have received something since the last question."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return int(self._process.stdout.readline())

    def end(self) -> None:
        self._process.terminate()
        self._process.wait()


@contextlib.contextmanager
def watching(web: WebAsk) -> Iterator[Crowd]:
    """The crowd for the time of a block."""
    crowd = Crowd(web)
    try:
        yield crowd
    finally:
        crowd.end()


async def look(port: int, page: str, told: dict[int, int], number: int) -> None:
    """One viewer of one page."""
    watch = [f"in:{n}" for n in range(200)] if page == "signals" else []
    async with connect(f"ws://127.0.0.1:{port}/live", compression=None, max_size=None) as socket:
        await socket.send(json.dumps({"t": "page", "name": page, "watch": watch}))
        async for _ in socket:
            told[number] = told.get(number, 0) + 1


async def crowd_of(port: int) -> None:
    """Twenty viewers; a line on stdin is answered with the number of those that received something since the last one."""
    told: dict[int, int] = {}
    tasks = [asyncio.create_task(look(port, PAGES[n % len(PAGES)], told, n)) for n in range(VIEWERS)]
    while len(told) < VIEWERS and not all(task.done() for task in tasks):
        await asyncio.sleep(0.05)
    told.clear()
    print("ready", flush=True)
    while await asyncio.to_thread(sys.stdin.readline):
        print(len(told), flush=True)
        told.clear()


def figure(name: str, value: float, unit: str, goal: float, *, met: bool, beside: str) -> Figure:
    """A row of `axisgate bench`."""
    return {"figure": name, "value": value, "unit": unit, "reference": beside, "reference_value": "", "ratio": "", "goal": goal, "met": met}


if __name__ == "__main__":
    asyncio.run(crowd_of(int(sys.argv[1])))
