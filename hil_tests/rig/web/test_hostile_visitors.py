"""AX-613: half requests end after five seconds and cost nobody a stop; wrong passwords tried at once are five a minute as well."""

import contextlib
import json
import socket
import threading
import time
from collections import Counter
from collections.abc import Iterator

import pytest
from websockets.sync.client import connect
from websockets.typing import Origin

from gateway.web.unfinished_requests import PLACES, REQUEST_S
from hil_tests.lab.running.cell_running import P5_MS, CellRun, free_port, running_cell
from hil_tests.lab.running.web_running import ADMIN, PASSWORD, WebAsk, until

HALVES = (
    b"",
    b"POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Half: ",
    b'POST /api/login HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 90\r\n\r\n{"name": "a',
)


@pytest.fixture(scope="module")
def port() -> int:
    return free_port()


@pytest.fixture(scope="module")
def run(port: int) -> Iterator[CellRun]:
    with running_cell("demo", "hostile", plc=False, p5_ms=max(10, P5_MS), more=("--web", str(port))) as running:
        yield running


@pytest.fixture(scope="module")
def web(run: CellRun, port: int) -> WebAsk:
    page = WebAsk(port)
    until(page.answers, "the page answers")
    assert page.ask("POST", "/api/setup", {"name": ADMIN, "password": PASSWORD}, x_axisgate="1")[0] == 200
    return page


def halves(web: WebAsk, count: int) -> list[socket.socket]:
    opened = []
    for n in range(count):
        link = socket.create_connection(("127.0.0.1", web.port), timeout=10)
        link.sendall(HALVES[n % len(HALVES)])
        opened.append(link)
    return opened


def ended(link: socket.socket) -> bool:
    link.settimeout(0.01)
    try:
        return link.recv(4096) == b""
    except TimeoutError:
        return False
    except OSError:
        return True


def stopped(web: WebAsk) -> float:
    began = time.monotonic()
    status, told = web.ask("POST", "/api/stop", x_axisgate="1")
    assert status == 200, told
    return time.monotonic() - began


def test_a_live_connection_is_no_unfinished_request(web: WebAsk) -> None:
    with connect(f"ws://127.0.0.1:{web.port}/live", origin=Origin(web.url)) as live:
        live.send(json.dumps({"t": "page", "name": "overview", "watch": []}))
        end = time.monotonic() + 1.6 * REQUEST_S
        while time.monotonic() < end:
            assert json.loads(live.recv(timeout=REQUEST_S))["t"] == "live"


def test_half_requests_end_after_five_seconds(web: WebAsk) -> None:
    links = halves(web, 9)
    slow = links[1]
    began = time.monotonic()
    while time.monotonic() < began + REQUEST_S - 1.0:  # a byte now and then is no progress
        slow.sendall(b"a")
        time.sleep(0.3)
    assert not any(ended(link) for link in links[:3])
    while not all(ended(link) for link in links):
        assert time.monotonic() < began + REQUEST_S + 3.0, "they go on"
        time.sleep(0.1)
    assert stopped(web) < 3.0


def test_visitors_who_leave_in_the_middle_or_speak_no_http_do_not_fill_the_journal(web: WebAsk, run: CellRun) -> None:
    before = len(run.journal("output"))
    for n in range(60):
        link = socket.create_connection(("127.0.0.1", web.port), timeout=10)
        if n % 2:
            link.sendall(HALVES[2])
            time.sleep(0.02)  # the page has begun to wait for the rest
        else:
            link.sendall(b"\x16\x03\x01\x02 no request\r\n\r\n")
        link.close()
    time.sleep(1.0)
    told = [entry["text"] for entry in run.journal("output")][before:]
    assert len(told) <= 3 and not any("Traceback" in each or "ClientDisconnect" in each for each in told), told
    assert web.answers()


def test_a_stop_gets_through_hundreds_of_half_requests(web: WebAsk) -> None:
    with contextlib.ExitStack() as stack:
        for _ in range(3):
            for link in halves(web, PLACES):
                stack.callback(link.close)
            assert stopped(web) < 3.0
        assert web.ask("GET", "/api/health")[0] == 200


def test_a_connection_that_finishes_its_requests_stays(web: WebAsk) -> None:
    import http.client

    link = http.client.HTTPConnection("127.0.0.1", web.port, timeout=10)
    until_s = time.monotonic() + REQUEST_S + 1.5
    while time.monotonic() < until_s:
        link.request("GET", "/api/health")
        answer = link.getresponse()
        assert answer.status == 200 and json.loads(answer.read())
        time.sleep(0.5)
    link.close()


def test_wrong_passwords_tried_at_once_are_five_a_minute(web: WebAsk) -> None:
    assert web.ask("POST", "/api/login", {"name": ADMIN, "password": PASSWORD}, x_axisgate="1")[0] == 200
    found: list[int] = []
    ready = threading.Barrier(24)

    def guess(n: int) -> None:
        ready.wait()
        found.append(web.ask("POST", "/api/login", {"name": ADMIN, "password": f"wrong guess {n}"}, x_axisgate="1")[0])

    threads = [threading.Thread(target=guess, args=(n,)) for n in range(24)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert Counter(found) == {401: 5, 429: 19}
    assert stopped(web) < 3.0
