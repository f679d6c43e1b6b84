"""The web process: serves the page of one run; started by the supervisor if the cell or the command line requests it (AX-470).

It reads the regions and never writes one; it runs at low priority, so a busy page costs the cycle no time.  It may die at any time:
the supervisor starts it again, and open pages reconnect automatically.
"""

import argparse
import logging
import os
import pathlib
import resource
import signal
import socket
import sqlite3
import time

import uvicorn

from gateway.assembly.run import load_plan
from gateway.observer.regions import Regions
from gateway.pure.scope.records import SCOPE_LAYOUT
from gateway.runtime.journal import Journal
from gateway.runtime.late_address import listening, patiently
from gateway.runtime.life import BEAT_S, Life
from gateway.runtime.page_data import data_file
from gateway.runtime.realtime import die_with_parent
from gateway.runtime.regions import RingReader, fds_from_text
from gateway.web.app import make_app
from gateway.web.scope import Scope
from gateway.web.store import Store
from gateway.web.unfinished_requests import PatientHttp, PatientServer

NICE = 5
SETTLE_TICKS = 10  # between two looks at writes the disk refused; one second
SELDOM_S, MOST_WORDS = 60.0, 100
MOST_FILES = 8192  # handshakes that never end hold one each for five seconds


class LivingServer(PatientServer):
    """Shows life whenever its loop comes round, ten times a second."""

    def __init__(self, config: uvicorn.Config, journal: Journal, life: Life | None = None, store: Store | None = None) -> None:
        super().__init__(config)
        self._life, self._journal, self._store = life or Life(), journal, store

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Waits for an address that comes late, alive."""

        async def start() -> socket.socket:
            return listening(self.config.host, self.config.port)

        where = f"page on {self.config.host}:{self.config.port}"
        found = await patiently(where, start, self._say, self._life.beat, lambda: self.should_exit)
        if found is not None:
            await super().startup([found])

    def _say(self, text: str) -> None:
        self._journal.write("alarm", text)

    async def on_tick(self, counter: int) -> bool:
        self._life.beat()
        if self._store is not None and counter % SETTLE_TICKS == 0:
            self._store.settle()
        return await super().on_tick(counter)


class Seldom(logging.Filter):
    """Messages that a visitor can cause at will are logged once a minute, with their count."""

    def __init__(self) -> None:
        super().__init__()
        self._said: dict[str, float] = {}
        self._more: dict[str, int] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        words, now = str(record.msg), time.monotonic()
        if record.levelno >= logging.ERROR:
            return True
        if now - self._said.get(words, -SELDOM_S) < SELDOM_S:
            self._more[words] = self._more.get(words, 0) + 1
            return False
        if len(self._said) > MOST_WORDS:
            self._said.clear()
        self._said[words] = now
        if more := self._more.pop(words, 0):
            record.msg, record.args = f"{record.getMessage()} ({more} times more in between)", ()
        return True


def opened(path: pathlib.Path, journal: Journal, life: Life) -> Store:
    """Users and audit of the page, as soon as its disk can be opened; waiting is reported once and does not end the process."""
    waits = False
    while True:
        try:
            store = Store(path, lambda words: journal.write("alarm", words))
        except (sqlite3.Error, OSError) as error:
            if not waits:
                journal.write(
                    "alarm", f"the page's data {path} cannot be opened ({error}); free space on its disk; tried again every second"
                )
            waits = True
            for _ in range(round(1.0 / BEAT_S)):
                life.beat()
                time.sleep(BEAT_S)
        else:
            if waits:
                journal.write("alarm", f"the page's data {path} is open")
            return store


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate web process", description="the web process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    plan = load_plan(arguments.plan)
    assert plan.web is not None
    web, folder = plan.web, pathlib.Path(plan.cell.file).parent
    logging.getLogger("uvicorn.error").addFilter(Seldom())
    journal, life = Journal(plan.journal, "web"), Life()
    store = opened(data_file(plan.cell, web, simulated=plan.simulated), journal, life)
    fds, kept = fds_from_text(arguments.fds), data_file(plan.cell, web, simulated=plan.simulated)
    scope = Scope(plan, RingReader(fds["scope"], "scope", SCOPE_LAYOUT), kept.parent / "scope" / kept.stem)
    app = make_app(plan, web, Regions(plan, fds), store, scope)
    config = uvicorn.Config(
        app, host=web.host, port=web.port, log_level="warning", access_log=False, ws_max_size=65536, ws_per_message_deflate=False,
        ws_ping_interval=10.0, ws_ping_timeout=20.0, timeout_graceful_shutdown=1, server_header=False, limit_concurrency=200,
        ssl_certfile=str(folder / web.tls_certificate) if web.tls_certificate else None,
        ssl_keyfile=str(folder / web.tls_key) if web.tls_key else None,
        proxy_headers=False, http=PatientHttp,
    )  # fmt: skip
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, MOST_FILES) if hard != resource.RLIM_INFINITY else MOST_FILES, hard))
    server = LivingServer(config, journal, life, store)
    os.nice(NICE)  # from here on: the start itself is to be short
    server.run()
    store.close()
    journal.close()
    return 0 if server.started else 3


if __name__ == "__main__":
    raise SystemExit(main())
