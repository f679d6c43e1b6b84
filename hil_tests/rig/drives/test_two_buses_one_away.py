"""A running cell on two drive buses, and one of them goes: bus-off of its drives by command, its cable cut, bus-off of our own controller.

Its axes are lost within two cycles, the kinematic goes off in order, telegrams on the other bus flow on; everything is good again by itself
within 2 s of the bus' return, and moves again after acknowledgment and fresh commands (AX-437).
"""

import pathlib
import time
from collections.abc import Callable, Iterator

import pytest

from drivers.ports.can.broker import Link
from drivers.ports.can.wire import ERR_FLAG, RECORD
from gateway.commands.fault import main as fault
from gateway.files.find import find_config, read_text
from gateway.pure.image.records.cell import AxisFlag
from hil_tests.lab.judges.bus_log import Logged, read
from hil_tests.lab.partners.plc2 import ABORTED, ENABLE, PTP, RESET
from hil_tests.lab.running.cell_running import ALL, HOME, P5_MS, CellRun, patience_s, running_cell
from protocols.base.machine import Ns

pytestmark = pytest.mark.timeout(patience_s(20.0))
NAME = "twobus"
SECOND = """
[[bus]]
name     = "wrist"
port     = "sim"
protocol = "servodyn"
cycle_ms = 4
axes     = "1..3"

[defaults.axis] """
WRIST, VOID = [3, 4, 5], 0b111000
QUIET_MS = 700
LIMIT_S, BACK_S, DRIVE_LOST, BUS_OFF = 20.0, 2.0, 17, 0x40
SYNC, ON = 100, 0x03  # drive on, enable: bits 0 and 1 of a set value (AX-001)


def cell(folder: pathlib.Path) -> pathlib.Path:
    text = read_text(find_config("demo", "cells")).replace("[defaults.axis] ", SECOND, 1)
    text = text.replace('axes     = "1..6"', 'axes     = "1..3"', 1)
    for module in (4, 5, 6):
        text = text.replace(f'bus = "drives", module = {module}', f'bus = "wrist", module = {module - 3}', 1)
    path = folder / "twobus.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CellRun]:
    with running_cell(str(cell(tmp_path_factory.mktemp("cell"))), NAME, p5_ms=2 * P5_MS) as found:  # two brokers, two emulators
        yield found


def wait(condition: Callable[[], object], limit_s: float = LIMIT_S) -> bool:
    end = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def lost(run: CellRun) -> list[int]:
    return [n for n, axis in enumerate(run.state().axes[:6]) if axis.flags & AxisFlag.LOST]


def frames(run: CellRun, bus: str, since: Ns) -> list[Logged]:
    data = (run.folder / f"bus-{bus}.log").read_bytes()
    lines = data[: data.rfind(b"\n") + 1].decode().splitlines(keepends=True)
    return [entry for entry in read(lines) if isinstance(entry, Logged) and entry.stamp_ns > since]


def stamps(entries: list[Logged], identifier: int) -> list[Ns]:
    return [entry.stamp_ns for entry in entries if entry.identifier == identifier]


def away(run: CellRun, cut: Callable[[], object]) -> tuple[Ns, list[int]]:
    """In the middle of a move of all six; moment before the cut and the axes that were lost."""
    status = run.plc.wait(lambda s: True, 2)
    if status.enabled != ALL or status.referenced != ALL:
        run.ready()
    run.under_way(0.1)
    since = time.monotonic_ns()
    cut()
    status = run.plc.wait(lambda s: s.toggle == run.plc.toggle and s.state == ABORTED, 5)
    assert status.reason == DRIVE_LOST, status
    wait(lambda: lost(run) == WRIST, QUIET_MS / 2000)  # the one whose telegram was missed first is told first
    return since, lost(run)


def good_again(run: CellRun) -> Ns:
    """Moment when none is lost any more; looked at before anything else."""
    assert wait(lambda: not lost(run)), run.words()
    return time.monotonic_ns()


def judge(run: CellRun, since: Ns, back: Ns, good: Ns) -> None:
    """By the stamps of both buses; `back`: not before, the drives were heard again."""
    assert wait(lambda: stamps(frames(run, "drives", good), SYNC)), "the log is handed over in batches"
    assert wait(lambda: stamps(frames(run, "wrist", good), 610))
    other, wrist = frames(run, "drives", since), frames(run, "wrist", 0)
    off = next(entry.stamp_ns for entry in other if entry.identifier == 210 and entry.data[0] & ON != ON)
    last = max(entry.stamp_ns for entry in wrist if entry.stamp_ns < off and entry.identifier >= 610)
    cycles = len([stamp for stamp in stamps(other, SYNC) if last < stamp <= off])
    assert cycles <= 4, f"{cycles} SYNCs: two without an answer, the burst made before that was known, and the one without enable"
    asked = [stamp for stamp in stamps(other, SYNC) if stamp < back]
    heard = [len([stamp for stamp in stamps(other, identifier) if stamp < back]) for identifier in (610, 620, 630)]
    assert len(asked) > 10 and all(abs(count - len(asked)) <= 2 for count in heard), "the others flow on"
    first = next(stamp for stamp in stamps(wrist, 610) if stamp > back)
    assert (good - first) / 1e9 < BACK_S


def moves_again(run: CellRun, void: int) -> None:
    """Nothing came back by itself; acknowledged and with fresh commands it does."""
    status = run.plc.wait(lambda s: s.enabled == 0, 2)  # a drive that comes back still says `enabled` until it hears us
    assert status.referenced & void == 0, "a lost drive's reference is void (AX-110)"
    if void:
        run.ready()
        return
    for code, mask in ((RESET, 0), (ENABLE, ALL)):
        run.command(code, mask)
    run.command(PTP, ALL, 1.0, HOME)


def test_bus_off_of_the_drives_of_one_bus(run: CellRun) -> None:
    def body(_: int) -> None:
        since, gone = away(run, lambda: fault(["--emulator", f"{NAME}-wrist", "quiet", f"ms={QUIET_MS}"]))
        good = good_again(run)
        assert gone == WRIST
        judge(run, since, since + QUIET_MS * 1_000_000, good)
        moves_again(run, VOID)

    run.repeat(1, body, run.ready)


def test_the_cable_of_one_bus_is_cut(run: CellRun) -> None:
    """Its broker is taken away and comes again: neither we nor the drives have a bus there meanwhile."""

    def body(_: int) -> None:
        since, gone = away(run, lambda: run.hold("broker-wrist"))
        time.sleep(QUIET_MS / 1000)
        back = time.monotonic_ns()
        run.forgive("broker-wrist")
        good = good_again(run)
        assert gone == WRIST
        judge(run, since, back, good)
        moves_again(run, VOID)

    run.repeat(1, body, run.ready)


def test_our_own_controller_is_bus_off(run: CellRun) -> None:
    """The kernel says it by an error frame; the bus is opened again, which restarts a controller of metal."""

    def body(count: int) -> None:
        def error_frame() -> None:
            link = Link(f"{NAME}-wrist")
            link.send([RECORD.pack(ERR_FLAG | BUS_OFF, 8, 0, bytes(8), 0, 0)])
            link.socket.close()

        since, _ = away(run, error_frame)
        good_again(run)
        said = [entry for entry in run.journal("output") if "bus-off: the controller left the bus" in entry["text"] and entry["ns"] > since]
        assert len(said) == 1 and f"broker:{NAME}-wrist" in said[0]["text"]
        assert not [entry for entry in run.journal("output") if "drives: bus-off" in entry["text"]], "the other bus is none of it"
        moves_again(run, 0)

    run.repeat(1, body, run.ready)
