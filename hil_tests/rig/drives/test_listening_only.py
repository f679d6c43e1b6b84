"""A real SERVODYN bus without layout_evidence: the run is up and sends nothing on it; both buses' logs are the witnesses (AX-436)."""

import json
import os
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from gateway.assembly.run import plan_run
from gateway.cell_file.load import load_cell
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import AxisFlag
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.web.cell_view import described
from gateway.web.plant_view import Plant
from gateway.web.skeleton import Skeleton
from hil_tests.lab.judges.bus_log import CLIENT, Logged, Remark, read
from hil_tests.lab.partners.plc2 import ENABLE, REFUSED, REQUEST
from hil_tests.lab.running.cell_running import ALL, CellRun
from hil_tests.lab.running.real_running import RealRun, running_real
from protocols.servodyn.codec import SYNC

LIMIT_S = 20.0
CYCLES = 25
WORDS = "bus drives listens only: no layout_evidence"


def wait(condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + LIMIT_S
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def links(run: CellRun) -> dict[str, Any]:
    fds: dict[str, int] = {}
    try:
        with ask(run.name, "regions") as connection:
            fds = recv_fds(connection)
        payload = RegionReader(fds["links"], "links").read()
    finally:
        for fd in fds.values():
            os.close(fd)
    found: dict[str, Any] = json.loads((payload or b"{}").rstrip(b"\0 ") or b"{}")
    return found


@pytest.fixture(scope="module")
def run() -> Iterator[RealRun]:
    with running_real(adapter=True, evidence=False) as (found, _):
        yield found


def far_log(run: RealRun) -> list[Logged | Remark]:
    assert run.far.log is not None
    data = run.far.log.read_bytes()
    return list(read(data[: data.rfind(b"\n") + 1].decode().splitlines(keepends=True)))


def senders(entries: list[Logged | Remark]) -> dict[int, int]:
    """Pid of each sender -> frames."""
    pids = {int(found[1]): int(found[2]) for entry in entries if isinstance(entry, Remark) and (found := CLIENT.match(entry.text))}
    frames: dict[int, int] = {}
    for entry in entries:
        if isinstance(entry, Logged):
            frames[pids[entry.sender]] = frames.get(pids[entry.sender], 0) + 1
    return frames


def test_nothing_is_sent_whatever_the_sources_ask_for(run: RealRun) -> None:
    """The old controller is alive on the bus: its drives answer it, and our run hears them."""
    old = run.far.port()
    assert wait(lambda: any(entry["text"].endswith("open, listening only") for entry in run.journal("output"))), run.words()
    run.command(REQUEST)
    run.plc.send(ENABLE, ALL)
    answer = run.plc.wait(lambda status: status.toggle == run.plc.toggle and status.state == REFUSED, 10)
    for _ in range(CYCLES):
        old.send([SYNC])
        time.sleep(0.01)
    heard = wait(lambda: senders(far_log(run)).get(run.emulator.pid, 0) >= 6 * CYCLES)
    near = wait(lambda: senders(run.bus()).get(run.pid("adapter-drives"), 0) >= 6 * CYCLES)
    old.close()
    assert heard and near, run.words()
    assert set(senders(far_log(run))) == {os.getpid(), run.emulator.pid}, "the old controller and its drives, nobody else"
    assert set(senders(run.bus())) == {run.pid("adapter-drives")}, "the cycle sent nothing"
    assert answer.reason == Reason.NOT_READY and answer.enabled == 0
    state = run.state()
    assert not state.ready and all(axis.flags & AxisFlag.LOST for axis in state.axes[:6]), "what was heard is not a drive's word"


def test_the_state_is_reported_everywhere(run: RealRun) -> None:
    assert run.status()["listening"] == ["drives"]
    told = links(run)
    assert told["listening"] == ["drives"] and told["errors"][0]["code"] == Reason.NOT_READY and WORDS in told["errors"][0]["text"]
    assert not [row for row in told["errors"] if row["code"] == Reason.DRIVE_LOST], "one reason, not six"
    assert any(WORDS in str(entry["text"]) for entry in run.journal("alarm"))
    assert f"{WORDS}, and the SERVODYN layout is axisgate's own" in (run.folder / "run.log").read_text()
    plan = plan_run(load_cell(run.cell), simulated=False, slug="other")
    page = described(plan, Plant(plan), Skeleton(plan.cell))
    assert [bus["listens"] for bus in page["buses"]] == [True]
