"""A cell without [[db]]: the own command block over 3964R and RK512 (AX-011, AX-012), and what a bad partner gets there."""

import contextlib
import json
import pathlib
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from drivers.ports.open import open_bytes
from gateway.runtime.supervisor_client import wait_up
from gateway.simulation.line.control import LineControl
from hil_tests.lab.partners.plc1 import PROFILE
from hil_tests.lab.partners.plc2 import ENABLE, OVERRIDE, PTP, REFERENCE, REQUEST, Status
from hil_tests.lab.partners.rk512_active import ActiveStation, Done, Event, Refused, Unasked
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.running.scenario import free_port
from protocols.p3964r.profiles import Priority

ROOT = pathlib.Path(__file__).resolve().parents[3]
ALLOWED = 0b11111 << 0  # RC inputs 24..28 are bits 0..4 of byte 3
DONE, REFUSED, NOT_READY_YET = 3, 4, 20


def own_block_cell(folder: pathlib.Path) -> pathlib.Path:
    """The demo cell without data blocks and without Modbus; the line owns the enabling inputs, and one signal is moved."""
    text = (ROOT / "configs/cells/demo.toml").read_text()
    head, rest = text.split("# Every entry names its STEP 5 type", 1)
    drives = rest[rest.index("# ---- drives") :]
    head = head.replace('owner = { "3" = "plc2" }', 'owner = { "3" = "plc1", "2" = "plc1" }\n\n[signals]\nREADY_RCO = 300')
    head = head.replace('life_word      = "DB10.DW31"', "")
    path = folder / "own.toml"
    path.write_text(head + drives)
    return path


@dataclass
class Partner:
    """An active RK512 station on the cell's line."""

    line: SyncLine[Event]
    station: ActiveStation
    toggle: bool = False

    def job(self, number: int) -> Event:
        found: list[Event] = []

        def over() -> bool:
            found.extend(event for _, event in self.line.events if not isinstance(event, Unasked) and event.job == number)
            self.line.events.clear()
            return bool(found)

        assert self.line.run_until(over, 10), "no outcome of an RK512 job"
        return found[0]

    def send(self, db: int, word: int, data: bytes) -> Event:
        return self.job(self.station.send(db, word, data, time.monotonic_ns()))

    def fetch(self, db: int, word: int, words: int) -> bytes:
        done = self.job(self.station.fetch(db, word, words, time.monotonic_ns()))
        assert isinstance(done, Done), done
        return done.data

    def inputs(self) -> None:
        """DB 20 DW 1: RC input bytes 2 and 3."""
        assert isinstance(self.send(20, 1, bytes((0, ALLOWED))), Done)

    def status(self) -> Status:
        return Status.of(struct.unpack(">58H", self.fetch(11, 0, 58)))

    def command(self, code: int, mask: int = 0, velocity: float = 1.0, targets: tuple[float, ...] = (), seconds: float = 20.0) -> Status:
        self.toggle = not self.toggle
        head = struct.pack(">4H", (0x8000 if self.toggle else 0) | code, mask, round(velocity * 10_000), 10_000)
        assert isinstance(self.send(10, 0, head + struct.pack(">12f", *(*targets, *[0.0] * 12)[:12])), Done)
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.inputs()
            status = self.status()
            if status.toggle == self.toggle and status.state >= DONE:
                return status
            if status.reason == NOT_READY_YET:
                return status
        raise AssertionError(f"code {code} had no outcome: {status}")


@pytest.fixture(scope="module")
def partner(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Partner]:
    folder = tmp_path_factory.mktemp("own")
    name = f"own-{folder.name[-6:]}"
    command = [sys.executable, "-m", "gateway", "run", str(own_block_cell(folder)), "--sim", "--name", name, "--p5", "10"]
    command += ["--die-with-parent", "--modbus-port", str(free_port(1502))]
    run = subprocess.Popen(command, stdout=(folder / "run.log").open("wb"), stderr=subprocess.STDOUT, cwd=ROOT)
    try:
        assert wait_up(name, 60), (folder / "run.log").read_text()
        port = LineControl.path(f"{name}-plc1", "a")
        with SyncLine(lambda: open_bytes(f"pty:{port}", "9600 8E1"), station := ActiveStation(9600, PROFILE, Priority.HIGH)) as line:
            yield Partner(line, station)
    finally:
        run.terminate()
        run.wait(20)


def test_switch_on_reference_and_move_by_the_own_block(partner: Partner) -> None:
    partner.inputs()
    first = partner.command(REQUEST)
    assert (first.state, first.reason) == (0, NOT_READY_YET), "the first block after a start is adopted, not carried out"
    for code, mask in ((REQUEST, 0), (OVERRIDE, 0), (ENABLE, 0x3F), (REFERENCE, 0x3F)):
        assert partner.command(code, mask).state == DONE, code
    target = (150.0, 120.0, 60.0, 20.0, -10.0, 30.0)
    status = partner.command(PTP, 0x3F, 1.0, target)
    assert status.state == DONE
    time.sleep(0.5)
    assert partner.status().actual[:6] == pytest.approx(target, abs=0.01)


def test_a_moved_signal_is_at_its_new_place(partner: Partner) -> None:
    outputs = partner.fetch(21, 0, 20)
    assert outputs[37] >> 4 & 1 == 1, "READY_RCO was moved to bit 300"
    assert outputs[8] & 1 == 0


@pytest.mark.parametrize(
    ("db", "word", "data", "number"),
    [
        (99, 0, b"\0\0", 0x14),
        (11, 0, b"\0\0", 0x14),
        (21, 0, b"\0\0", 0x14),
        (10, 27, bytes(4), 0x14),
        (20, 0, b"\1\1", 0x0A),
    ],
)
def test_what_may_not_be_written_gets_its_error_number_and_changes_nothing(
    partner: Partner, db: int, word: int, data: bytes, number: int
) -> None:
    before = partner.fetch(20, 0, 8)
    answer = partner.send(db, word, data)
    assert isinstance(answer, Refused)
    assert answer.number == number
    assert partner.fetch(20, 0, 8) == before


@pytest.mark.parametrize("kind", ["parity", "flip", "drop", "break"])
def test_damage_on_the_line_costs_repeats_and_nothing_else(partner: Partner, kind: str) -> None:
    name = partner.line._core.port.name.split("/")[-1].removesuffix("-a") if partner.line._core.port else ""
    with LineControl(name) as cable:
        time.sleep(0.05)  # the last acknowledgement has left: a lost one makes its reaction come twice, which nobody can tell from the next
        cable.damage("A", kind, 1)
        before = partner.status().life
        assert partner.status().life != before
        time.sleep(0.05)  # here too: noise in one burst with the acknowledgement spoils it (AX-241)
        cable.noise("A", b"garbage\x02")
        time.sleep(0.5)
    assert isinstance(partner.send(20, 1, bytes((0, ALLOWED))), Done)


def test_the_demo_leaves_nothing_after_ctrl_c(tmp_path: pathlib.Path) -> None:
    before = {path.name for path in pathlib.Path("/dev/shm").iterdir()}
    name = f"ctrlc-{tmp_path.name[-6:]}"
    command = [sys.executable, "-m", "gateway", "demo", "--name", name, "--p5", "20", "--records", str(tmp_path / "rec")]
    demo = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=ROOT, text=True, start_new_session=True)
    try:
        assert wait_up(name, 60)
        time.sleep(2.0)
        demo.send_signal(2)
        words, _ = demo.communicate(timeout=30)
    finally:
        with contextlib.suppress(ProcessLookupError):
            demo.kill()
    assert "nothing is left running" in words, words
    assert not [line for line in running() if name in line]
    from drivers.ports.base import runtime_dir

    assert not [path.name for path in runtime_dir().iterdir() if path.name.startswith(name) and not path.is_dir()]
    assert {path.name for path in pathlib.Path("/dev/shm").iterdir()} == before
    assert json.dumps(demo.returncode) != "0"


def running() -> list[str]:
    """Command lines of all processes."""
    found = []
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            found.append(path.read_bytes().replace(b"\0", b" ").decode(errors="replace"))
    return found
