"""The line tools at real ptys, with the line process between them and a station of ours in another process."""

import json
import pathlib
import subprocess
import threading
import time
from collections.abc import Callable

import pytest

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import parse_format, parse_record
from drivers.ports.serial.pty import PtyPort
from gateway.links.serial.tool_wire import RealWire
from gateway.simulation.line.control import LineControl
from gateway.tools.line.ports import PyserialPort, open_port
from hil_tests.rig.line_tools.conftest import Cable, axisgate, end, run
from protocols.base.machine import ms

Start = Callable[..., None]


def test_send_and_fetch_over_a_cable(cable: Cable, station: Start) -> None:
    station("good")
    sent = axisgate("line", "send", cable.near, "DB10.DW2", "--type", "KF,KG", "1200", "1200.5", "--bytes")
    assert sent.returncode == 0, sent.stderr
    assert "> 00 00 41 44 0A 02 00 03 FF FF 04 B0 0B 4B 08 00" in sent.stderr
    brought = axisgate("line", "fetch", cable.near, "DB10.DW2", "--type", "KF,KG", "--count", "2", "--json")
    assert brought.returncode == 0, brought.stderr
    assert [one["value"] for one in json.loads(brought.stdout)] == [1200, 1200.5]


def test_an_unplugged_cable_is_reported_in_both_vocabularies(cable: Cable, station: Start) -> None:
    station("good")
    with LineControl(cable.name) as control:
        control.unplug()
    failed = axisgate("line", "fetch", cable.near, "DB10.DW2")
    assert failed.returncode == 1
    assert "QVZ/ADT 550 ms (6 attempts)" in failed.stderr


def test_a_port_that_is_not_there_is_the_environment(cable: Cable) -> None:
    failed = axisgate("line", "fetch", "pty:/nowhere/at-all", "DB10.DW2")
    assert failed.returncode == 3
    assert "/nowhere/at-all" in failed.stderr


@pytest.mark.slow
def test_the_probe_over_a_cable_writes_its_report(cable: Cable, station: Start, tmp_path: pathlib.Path) -> None:
    station("good")
    groups = (
        "idle",
        "receive.gap-in-data",
        "receive.parity-in-data",
        "receive.parity-in-check",
        "send.just-too-late",
        "conflict.first",
        "rk512",
    )
    only = [word for group in groups for word in ("--only", group)]
    done = axisgate("line", "probe", cable.near, "--write", "--report", "cw4", *only, folder=tmp_path, seconds=110)
    report = json.loads((tmp_path / "cw4.json").read_text())
    verdicts = {test["name"]: (test["verdict"], test["reason"]) for test in report["tests"]}
    assert done.returncode == 0, verdicts
    assert verdicts["receive.parity-in-data"][0] in ("PASS", "INCONCLUSIVE")
    assert sum(verdict == "PASS" for verdict, _ in verdicts.values()) >= 20, verdicts
    assert report["time"] == "real"
    page = (tmp_path / "cw4.html").read_text()
    assert "It is not a certificate" in page and "receive.gap-in-data" in page


def test_the_probe_over_a_cable_finds_a_hostile_station(cable: Cable, station: Start, tmp_path: pathlib.Path) -> None:
    station("two-attempts")
    done = axisgate("line", "probe", cable.near, "--only", "send.nak-to-stx", "--no-report", folder=tmp_path)
    assert done.returncode == 1
    assert "2 connection attempts when STX is answered with NAK, expected 6" in done.stdout


def test_diagnose_over_a_cable_reports_what_rides_on_it(cable: Cable, station: Start) -> None:
    station("good")
    done = axisgate("line", "diagnose", cable.near, "--no-scan", "--json")
    names = {one["name"] for one in json.loads(done.stdout)}
    assert {"3964R", "RK512", "priority"} <= names, done.stdout


def test_a_tap_decodes_both_wires_and_never_writes(
    cable: Cable, station: Start, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two plain cables stand for the two wires: what goes over the main line is played into their far ends."""
    taps = [_tap(tmp_path, name) for name in ("tapa", "tapb")]
    try:
        station("good")
        threading.Thread(target=_mirror, args=(cable, tmp_path), daemon=True).start()
        done = axisgate("line", "monitor", "--tap", ",".join(port for _, port, _ in taps), "--seconds", "4", "--json", seconds=30)
        told = [json.loads(line) for line in done.stdout.splitlines()]
        jobs = [(one["side"], one["job"]) for one in told if "job" in one]
        assert ("A", "FETCH") in jobs and ("B", "REACTION") in jobs, done.stdout + done.stderr
    finally:
        for process, _, _ in taps:
            end(process)
    for _, _, record in taps:
        assert parse_record(record.read_text().splitlines(keepends=True)).sent_by("A") == b""  # the monitor's end said nothing


def test_a_cell_is_learned_live_from_two_taps_that_only_listen(
    cable: Cable, station: Start, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taps = [_tap(tmp_path, name) for name in ("tapa", "tapb")]
    draft, trace = tmp_path / "cell.toml", tmp_path / "kept.rec"
    ports = ",".join(port for _, port, _ in taps)
    try:
        station("good")
        threading.Thread(target=_mirror, args=(cable, tmp_path), daemon=True).start()
        words = ("--tap", ports, "--seconds", "4", "--save", str(trace), "-o", str(draft))
        done = axisgate("learn", "line", *words, seconds=30)
        assert done.returncode == 0, done.stderr
        assert "2 blocks, 1 kind of telegrams; next: axisgate check" in done.stdout
    finally:
        for process, _, _ in taps:
            end(process)
    for _, _, record in taps:
        assert parse_record(record.read_text().splitlines(keepends=True)).sent_by("A") == b""
    assert "# FETCH DW 0, 1 words: 1 times, once" in draft.read_text()
    again = axisgate("learn", "line", str(trace))
    body = draft.read_text().split("\n", 1)[1]
    assert again.returncode == 0 and again.stdout.split("\n", 1)[1] == body, "the trace that was kept gives the same draft"
    assert axisgate("check", str(draft)).returncode == 0


def test_live_learning_says_what_it_needs(tmp_path: pathlib.Path) -> None:
    for words, said in (
        ((), "TRACE, or live --tap A,B"),
        (("--tap", "COM1"), "two ports expected"),
        (("x.rec", "--tap", "a,b"), "TRACE, or"),
    ):
        done = axisgate("learn", "line", *words, folder=tmp_path)
        assert (done.returncode, said in done.stderr) == (2, True), done.stderr


def _tap(folder: pathlib.Path, name: str) -> "tuple[subprocess.Popen[str], str, pathlib.Path]":
    record = folder / f"{name}.rec"
    process = run("gateway.simulation.line.process", "--name", name, "--baud", "9600", "--record", str(record))
    return process, f"pty:{folder}/run/{name}-a", record


def _mirror(cable: Cable, folder: pathlib.Path) -> None:
    """A fetch on the main line; its record, wire by wire, as noise on the taps."""
    time.sleep(1.5)
    axisgate("line", "fetch", cable.near, "DB10.DW0")
    with LineControl(cable.name) as control:
        control.status()
    with LineControl("tapa") as one, LineControl("tapb") as other:
        for sent in parse_record(cable.record.read_text().splitlines(keepends=True)).runs:
            (one if sent.side == "A" else other).noise("B", sent.data)
            time.sleep(0.004)


def test_the_portable_port_carries_the_same_bytes(cable: Cable) -> None:
    far = PtyPort(cable.far.removeprefix("pty:"), parse_format("9600 8E1"))
    near = PyserialPort(cable.near.removeprefix("pty:"), parse_format("9600 8N1"))
    wire = RealWire(near)
    try:
        wire.write(b"\x02")
        limit = time.monotonic() + 5
        while not (got := far.read()) and time.monotonic() < limit:
            time.sleep(0.005)
        assert got == [b"\x02"]
        far.write(b"\x10")
        heard = wire.hear(wire.now() + ms(2000))
        assert heard is not None and heard.what == 0x10
        assert wire.hear(wire.now() + ms(30)) is None
    finally:
        wire.close()
        far.close()


def test_a_busy_port_is_a_port_error(cable: Cable) -> None:
    holder = open_port(cable.near)
    try:
        with pytest.raises(PortError, match="used by another program"):
            open_port(cable.near)
    finally:
        holder.close()


def test_a_port_that_vanishes_is_a_port_fault_and_the_report_says_how_far_it_came(
    cable: Cable, station: Start, tmp_path: pathlib.Path
) -> None:
    station("good")

    def pull() -> None:
        time.sleep(3.0)
        with LineControl(cable.name) as control:
            control.remove("A")

    threading.Thread(target=pull, daemon=True).start()
    done = axisgate("line", "probe", cable.near, "--report", "gone", folder=tmp_path)
    assert done.returncode == 3, done.stdout
    assert "lost (" in done.stderr
    report = json.loads((tmp_path / "gone.json").read_text())
    assert report["device"]["Broken off"].startswith(f"after {len(report['tests'])} tests")
    assert len(report["tests"]) >= 1
