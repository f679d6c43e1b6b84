"""AX-611: who is removed or lowered loses open pages, control and a held key at once; a page that only looks keeps nobody in control."""

import contextlib
import http.client
import json
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from gateway.cell_file.load import load_cell
from gateway.pure.cell.web import Web
from gateway.pure.image.records.cell import Motion
from gateway.runtime.page_data import data_file
from gateway.tools.client import ToolClient
from gateway.web.socket import REFUSED
from gateway.web.store import Role, Store
from hil_tests.lab.running.cell_running import P5_MS, CellRun, free_port, running_cell
from hil_tests.lab.running.web_running import ADMIN, PASSWORD, WebAsk

BERT, HIS = "bert", "battery staple 9"


@dataclass
class Login:
    """One session of the page."""

    web: WebAsk
    cookie: str
    csrf: str

    def post(self, path: str, **body: object) -> dict[str, object]:
        status, told = self.web.ask("POST", path, body, cookie=self.cookie, x_axisgate_csrf=self.csrf)
        assert status == 200, (path, status, told)
        assert isinstance(told, dict)
        return told

    def get(self, path: str) -> int:
        return self.web.ask("GET", path, cookie=self.cookie)[0]

    def live(self) -> ClientConnection:
        return connect(f"ws://127.0.0.1:{self.web.port}/live", additional_headers={"Cookie": self.cookie}, max_size=None)


@dataclass
class Cell:
    """The run, its page, the administrator."""

    run: CellRun
    web: WebAsk
    boss: Login
    store: Store


def login(web: WebAsk, name: str, password: str, path: str = "/api/login") -> Login:
    link = http.client.HTTPConnection("127.0.0.1", web.port, timeout=30)
    link.request("POST", path, json.dumps({"name": name, "password": password}), {"content-type": "application/json", "x-axisgate": "1"})
    answer = link.getresponse()
    told = json.loads(answer.read())
    assert answer.status == 200, told
    return Login(web, str(answer.getheader("set-cookie")).partition(";")[0], told["csrf"])


def until(holds: Callable[[], bool], what: str, seconds: float = 15.0) -> None:
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, f"{what}: not within {seconds} s"
        time.sleep(0.02)


@pytest.fixture(scope="module")
def cell() -> Iterator[Cell]:
    port = free_port()
    with running_cell("demo", "users", plc=False, p5_ms=max(10, P5_MS), more=("--web", str(port))) as run:
        web = WebAsk(port)
        until(web.answers, "the page answers", 40.0)
        boss = login(web, ADMIN, PASSWORD, "/api/setup")
        yield Cell(run, web, boss, Store(data_file(load_cell("demo"), Web(), simulated=True)))


class Jogging:
    """A browser with a held key: its live connection, and the message repeated as the page does."""

    def __init__(self, cell: Cell, person: Login) -> None:
        self.cell, self.person = cell, person
        self.socket = person.live()
        self.code = 0
        person.post("/api/command", code="request_control")
        self._lifted = threading.Event()
        self._thread = threading.Thread(target=self._hold, daemon=True)

    def _hold(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while not self._lifted.wait(0.1):
                self.socket.send(json.dumps({"t": "jog", "axis": 5, "direction": 1, "percent": 2}))
                with contextlib.suppress(TimeoutError):
                    while True:
                        self.socket.recv(timeout=0.001)

    def begin(self) -> None:
        self.cell.boss.post("/api/permit")
        for code in ("fault_reset", "override", "enable"):
            self.person.post("/api/command", code=code, mask=63)
            time.sleep(0.3)
        until(lambda: bool(self.cell.run.state().axes[5].flags & 1), "drives on")
        self._thread.start()
        until(lambda: self.cell.run.state().motion is Motion.RUNNING, "the axis moves while the key is held")

    def ended(self) -> int | None:
        """The close code, once the server has closed."""
        self._thread.join(3.0)
        assert not self._thread.is_alive()
        return self.socket.protocol.close_code

    def lift(self) -> None:
        self._lifted.set()
        self.socket.close()


def operator(cell: Cell) -> Jogging:
    """Bert is an operator, in control, and holds a key."""
    cell.boss.post("/api/users", name=BERT, role="operator", password=HIS)
    hand = Jogging(cell, login(cell.web, BERT, HIS))
    hand.begin()
    return hand


def owner(cell: Cell) -> object:
    client = ToolClient(cell.run.name)
    try:
        return client.ask("status")["owner"]
    finally:
        client.close()


def lowered(cell: Cell) -> None:
    cell.boss.post("/api/users", name=BERT, role="viewer", password=HIS)


def removed(cell: Cell) -> None:
    cell.boss.post("/api/users/drop", name=BERT)


def lowered_at_the_command_line(cell: Cell) -> None:
    cell.store.put_user(BERT, Role.VIEWER, HIS)  # as `axisgate web user` does, in the very file


@pytest.mark.parametrize("change", [lowered, removed, lowered_at_the_command_line])
def test_a_changed_user_loses_page_control_and_key(cell: Cell, change: Callable[[Cell], None]) -> None:
    hand = operator(cell)
    try:
        change(cell)
        until(lambda: cell.run.state().motion is not Motion.RUNNING, "the axis stops though the key is still held", 1.0)
        assert hand.ended() == REFUSED
        until(lambda: owner(cell) == 0, "control is free", 3.0)
        assert hand.person.get("/api/users") != 200
        state = cell.run.state()
        time.sleep(0.5)
        assert cell.run.state().axes[5].set == pytest.approx(state.axes[5].set, abs=0.002)
    finally:
        hand.lift()


def test_reading_keeps_nobody_in_control(cell: Cell) -> None:
    """The holder's page is gone; a script with the same session goes on asking for what became of its jobs."""
    cell.boss.post("/api/users", name=BERT, role="operator", password=HIS)
    person = login(cell.web, BERT, HIS)
    job = person.post("/api/command", code="request_control")["job"]
    assert owner(cell) == 91
    end = time.monotonic() + 6.0
    while time.monotonic() < end and owner(cell) == 91:
        person.get(f"/api/jobs/{job}")
        time.sleep(0.1)
    assert owner(cell) == 0


def test_control_ends_with_the_page_that_was_closed(cell: Cell) -> None:
    hand = operator(cell)
    began = time.monotonic()
    hand.lift()
    until(lambda: cell.run.state().motion is not Motion.RUNNING, "stops", 1.0)
    until(lambda: owner(cell) == 0, "control is free", 2.0)
    assert time.monotonic() - began < 2.0
