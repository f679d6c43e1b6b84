"""A passive line with types beside D, coordination flags, unknown blocks; an active line with our own SEND and FETCH."""

import contextlib
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

from drivers.ports.base import runtime_dir
from drivers.ports.open import open_bytes
from drivers.ports.serial.line_format import parse_record
from gateway.pure.lines.rk512_link import Rk512Link
from gateway.runtime.supervisor_client import wait_up
from hil_tests.lab.partners import rk512_active as plc
from hil_tests.lab.partners.rk512_active import ActiveStation, Event, Refused, Unasked
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.virtual.rk512_blocks import Blocks
from protocols.base.machine import Damage
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.active import Denied, Done, Failed
from protocols.rk512.dialects import Dialect
from protocols.rk512.passive import Fetched, Written

ROOT = pathlib.Path(__file__).resolve().parents[3]
CELL = """
format = 1
[cell]
name = "both roles"
[rc_inputs]
owner = { "2" = "served", "3" = "served" }
[[line]]
name = "served"
port = "sim"
[line.rk512]
types = ["D", "X", "E", "A", "M"]
unknown_block = 0x0A
coordination_flag = "keep"
[line.supervision]
max_silence_ms = 5000
[[line]]
name = "asking"
port = "sim"
role = "active"
[line.times]
ADT = 600
[line.supervision]
max_silence_ms = 3000
[[db]]
number = 10
words = 8
writer = "plc"
line = "served"
entries = [{ at = "DW 7", type = "KF", to = "line.served.life" }]
[[db]]
number = 10
kind = "X"
words = 4
writer = "plc"
line = "served"
[[db]]
number = 12
kind = "X"
words = 4
writer = "axisgate"
line = "served"
entries = [{ at = "DW 1", type = "KF", from = "cell.life" }]
[[db]]
number = 30
words = 4
writer = "axisgate"
line = "asking"
every_ms = 250
at_partner = "DB20.DW2"
flag = "M 6.4"
entries = [{ at = "DW 3", type = "KF", from = "cell.life" }]
[[db]]
number = 31
words = 3
writer = "plc"
line = "asking"
every_ms = 250
at_partner = "DB21.DW1"
entries = [{ at = "DW 0", type = "KF", to = "line.asking.life" }]
[[bus]]
name = "drives"
port = "sim"
protocol = "servodyn"
cycle_ms = 20
[[axis]]
name = "X"
unit = "mm"
drive = { type = "servodyn", bus = "drives", module = 1 }
limits = { min = -5.0, max = 1000.0, speed = 100.0, accel = 1000.0 }
home = { by = "none" }
"""
FLAG = (6, 4)  # bytes 9 and 10 of a header: M 6.4


@dataclass
class Run:
    """The running cell, and an active partner at its passive line."""

    name: str
    record: pathlib.Path
    plc: SyncLine[Event]
    station: ActiveStation
    events: list[Event] = field(default_factory=list)

    def job(self, number: int) -> Event:
        found: list[Event] = []

        def over() -> bool:
            found.extend(event for _, event in self.plc.events if not isinstance(event, Unasked) and event.job == number)
            self.plc.events.clear()
            return bool(found)

        assert self.plc.run_until(over, 10), "no outcome of an RK512 job"
        return found[0]

    def ask(self, head: str, data: bytes = b"", brings: int = 0) -> Event:
        """A telegram written out byte by byte."""
        return self.job(self.station.command(bytes.fromhex(head) + data, brings, time.monotonic_ns()))

    def fetch(self, head: str, brings: int) -> bytes:
        done = self.ask(head, b"", brings)
        assert isinstance(done, plc.Done), done
        return done.data

    def var(self, **request: str) -> dict[str, Any]:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
            link.settimeout(5.0)
            link.connect(str(runtime_dir() / f"{self.name}-services.sock"))
            link.sendall(json.dumps(request).encode() + b"\n")
            answer = json.loads(link.makefile().readline())
        assert isinstance(answer, dict)
        return answer

    def counters(self, line: str) -> dict[str, Any]:
        sources = self.var(op="status")["command_sources"]
        return next(source for source in sources if source["name"] == line)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    folder = tmp_path_factory.mktemp("roles")
    cell = folder / "roles.toml"
    cell.write_text(CELL, encoding="utf-8")
    with tempfile.TemporaryDirectory(prefix="ag") as short, contextlib.ExitStack() as stack:
        before = os.environ.get("AXISGATE_RUNTIME")
        os.environ["AXISGATE_RUNTIME"] = f"{short}/run"
        command = [sys.executable, "-m", "gateway", "run", str(cell), "--sim", "--name", "roles", "--record", str(folder / "rec")]
        process = subprocess.Popen([*command, "--die-with-parent"], stdout=(folder / "log").open("wb"), stderr=subprocess.STDOUT, cwd=ROOT)
        try:
            assert wait_up("roles", 30), (folder / "log").read_text()
            station = ActiveStation(9600, RHO3, Priority.HIGH)
            line = SyncLine(open_bytes(f"pty:{runtime_dir() / 'roles-served-a'}", "9600 8E1"), station)
            stack.callback(line.close)
            yield Run("roles", folder / "rec", line, station)
        finally:
            process.terminate()
            process.wait(20)
            if before is None:
                del os.environ["AXISGATE_RUNTIME"]
            else:
                os.environ["AXISGATE_RUNTIME"] = before


def test_extended_blocks_inputs_outputs_and_flags_are_served(run: Run) -> None:
    assert run.ask("00 00 4F 58 0A 01 00 02 FF FF", b"\x12\x34\x56\x78") == plc.Done(run.station._number, b"")
    assert run.fetch("00 00 45 58 0A 00 00 04 FF FF", 8) == bytes.fromhex("0000 1234 5678 0000")
    before = run.fetch("00 00 45 58 0C 01 00 01 FF FF", 2)
    time.sleep(0.1)
    assert run.fetch("00 00 45 58 0C 01 00 01 FF FF", 2) != before, "cell.life stands in DX 12 DW 1"
    outputs = run.fetch("00 00 45 45 00 00 00 10 FF FF", 16)  # E: what a PLC reads as inputs, the RC outputs
    assert outputs == run.fetch("00 00 45 44 15 00 00 08 FF FF", 16), "the same as DB 21"
    assert run.ask("00 00 41 44 14 01 00 01 FF FF", b"\x5a\x01") == plc.Done(run.station._number, b"")
    assert run.fetch("00 00 45 41 00 02 00 02 FF FF", 2) == b"\x5a\x01", "A: bytes 2 and 3 of the RC inputs"
    assert run.fetch("00 00 45 41 00 03 00 01 FF FF", 1) == b"\x01", "bytes are counted, not words"


def test_a_link_that_refuses_every_job_is_not_alive(run: Run) -> None:
    """AX-650: thirty jobs to a missing block in six seconds are no sign of life; the first good one is."""
    run.fetch("00 00 45 44 0A 00 00 01 FF FF", 2)
    assert run.counters("served")["alive"]
    end, refused = time.monotonic() + 6.0, 0
    while time.monotonic() < end:
        assert isinstance(run.ask("00 00 45 44 63 00 00 01 FF FF"), Refused)
        refused += 1
    assert refused > 5 and not run.counters("served")["alive"]
    told = (runtime_dir() / "roles" / "journal.jsonl").read_text()
    assert "no job that could be served, the last one refused with 0Ah" in told
    run.fetch("00 00 45 44 0A 00 00 01 FF FF", 2)
    assert run.counters("served")["alive"]


def test_types_not_listed_are_refused(run: Run) -> None:
    for head in ("00 00 45 54 00 00 00 01 FF FF", "00 00 45 5A 00 00 00 01 FF FF"):
        answer = run.ask(head)
        assert isinstance(answer, Refused) and answer.number == 0x12


@pytest.mark.parametrize("head", ["00 00 41 44 63 00 00 01 FF FF", "00 00 41 44 0A 08 00 01 FF FF", "00 00 4F 58 63 00 00 01 FF FF"])
def test_a_block_that_is_not_configured_gets_the_configured_number_and_nothing_changes(run: Run, head: str) -> None:
    before = run.fetch("00 00 45 44 0A 00 00 08 FF FF", 16), run.fetch("00 00 45 58 0A 00 00 04 FF FF", 8)
    answer = run.ask(head, b"\xab\xcd")
    assert isinstance(answer, Refused) and answer.number == 0x0A
    assert (run.fetch("00 00 45 44 0A 00 00 08 FF FF", 16), run.fetch("00 00 45 58 0A 00 00 04 FF FF", 8)) == before


def test_a_coordination_flag_locks_until_it_is_reset(run: Run) -> None:
    def send(word: bytes) -> Event:
        return run.job(run.station.send(10, 0, word, time.monotonic_ns(), FLAG))

    def flag_byte() -> bytes:
        return run.fetch("00 00 45 4D 00 06 00 01 FF FF", 1)

    assert flag_byte() == b"\x00"
    assert isinstance(send(b"\x00\x01"), plc.Done)
    assert flag_byte() == b"\x10", "M 6.4 is set, and seen in area M"
    locked = send(b"\x00\x02")
    assert isinstance(locked, Refused) and locked.number == 0x32
    assert run.fetch("00 00 45 44 0A 00 00 01 FF FF", 2) == b"\x00\x01", "the locked job changed nothing"
    assert run.var(op="get", address="M 6.4")["value"] == 1
    assert "set by the partner" in run.var(op="set", address="M 6.4", value="1")["error"]
    assert run.var(op="set", address="M 6.4", value="0")["value"] == 0
    assert isinstance(send(b"\x00\x03"), plc.Done)
    assert run.fetch("00 00 45 44 0A 00 00 01 FF FF", 2) == b"\x00\x03"
    run.var(op="set", address="M 6.4", value="0")


def test_a_passive_line_says_nothing_of_its_own(run: Run) -> None:
    time.sleep(0.2)
    before = len((run.record / "line-served.rec").read_text())
    time.sleep(1.0)
    assert len((run.record / "line-served.rec").read_text()) == before
    assert run.counters("served")["own_jobs"] == 0


@contextlib.contextmanager
def passive_partner(blocks: Blocks) -> Iterator[tuple[SyncLine[Any], Rk512Link]]:
    """A PLC with data blocks at the active line."""
    machine = Rk512Link(RHO3, Priority.HIGH, blocks, Dialect(coordination_flag="ignore"))
    with SyncLine[Any](open_bytes(f"pty:{runtime_dir() / 'roles-asking-a'}", "9600 8E1"), machine) as line:
        yield line, machine


def until(line: SyncLine[Any], there: Callable[[], bool], seconds: float = 15.0) -> bool:
    return line.run_until(there, seconds)


def test_an_active_line_sends_and_fetches_by_itself_and_serves_nobody(run: Run) -> None:
    blocks = Blocks({20: 8, 21: 8})
    blocks.blocks[21][2:8] = bytes.fromhex("0007 1111 2222")
    with passive_partner(blocks) as (line, _):
        assert until(line, lambda: sum(isinstance(event, Written) for _, event in line.events) >= 3)
        assert until(line, lambda: run.var(op="get", address="DB31.DW1")["value"] == 0x1111), "what was fetched stands in our block"
    assert recorded(run, "00 00 41 44 14 02 00 04 06 04"), "SEND DB 20 DW 2, 4 words, flag M 6.4"
    assert recorded(run, "00 00 45 44 15 01 00 03 FF FF"), "FETCH DB 21 DW 1, 3 words"


def recorded(run: Run, head: str) -> bool:
    """Whether our side of the active line sent it; a line writes its record when it is idle, thus a little later."""
    end = time.monotonic() + 5.0
    while time.monotonic() < end:
        text = (run.record / "line-asking.rec").read_text()
        if bytes.fromhex(head) in parse_record(text[: text.rfind("\n") + 1].splitlines(keepends=True)).sent_by("B"):
            return True
        time.sleep(0.05)
    return False


def test_the_partner_of_an_active_line_is_refused(run: Run) -> None:
    with passive_partner(Blocks({20: 8, 21: 8})) as (line, partner):
        job = partner.active.fetch(0, 1, 31)
        partner.start(time.monotonic_ns())
        assert until(line, lambda: any(isinstance(event, Denied | Done | Failed) for _, event in line.events))
        assert [event for _, event in line.events if isinstance(event, Denied | Done | Failed)] == [Denied(job, 0x0A)]


def test_our_jobs_that_the_partner_refuses_are_counted_and_go_on(run: Run) -> None:
    before = run.counters("asking")
    with passive_partner(Blocks({21: 8})) as (line, _):  # DB 20 is missing: 14h for every SEND
        assert until(line, lambda: run.counters("asking")["own_faults"] >= before["own_faults"] + 2)
        fetched = sum(isinstance(event, Fetched) for _, event in line.events)
        assert until(line, lambda: sum(isinstance(event, Fetched) for _, event in line.events) >= fetched + 2), "FETCH goes on"
        assert run.counters("asking")["alive"] is True


class GivesWayToo:
    """A station that has no priority either: STX against our STX, then DLE, as ours answers to it."""

    def __init__(self) -> None:
        self._output = b""

    def receive(self, data: bytes, now: int) -> list[object]:
        self._output += bytes(byte for byte in data if byte in (0x02, 0x10))
        return []

    def damaged(self, kind: Damage, now: int) -> list[object]:
        return []

    def sent(self, now: int) -> list[object]:
        return []

    def wake(self, now: int) -> list[object]:
        return []

    def deadline(self) -> int | None:
        return None

    def take_output(self) -> bytes:
        output, self._output = self._output, b""
        return output

    def lost(self, now: int) -> list[object]:
        return []


def test_the_same_priority_at_both_ends_is_counted_and_said_in_words(run: Run) -> None:
    assert (run.counters("asking")["same_priority"], run.counters("asking")["advice"]) == (0, "")
    with SyncLine[Any](open_bytes(f"pty:{runtime_dir() / 'roles-asking-a'}", "9600 8E1"), GivesWayToo()) as line:
        assert until(line, lambda: run.counters("asking")["same_priority"] >= 1)
    assert run.counters("asking")["advice"] == "both stations have the same priority (low): set one to high, the other to low"
