"""How long and how far drives run on when SYNC, the gateway's heartbeat or the gateway fails: measured from the emulator's record."""

import html
import json
import pathlib
import time
from dataclasses import asdict, dataclass

from drivers.drives.cia402_family import GATEWAY_NODE
from drivers.emulator.servo.record import Record, Row, read
from gateway.assembly.drive_buses import MISSED
from gateway.assembly.plant import motor_rad
from gateway.assembly.run import slug_of
from gateway.files.stop_report import sheet_digest
from gateway.pure.cell.cell import Bus, Cell
from gateway.pure.image.records.cell import AxisFlag
from gateway.registry import BUS_PROTOCOLS
from gateway.runtime.clock import wall
from gateway.runtime.supervisor_client import ask
from gateway.simulation.drives.control import EmulatorControl
from gateway.tools.client import ToolClient, ToolError, mask_of
from gateway.tools.command_support import BANNER
from gateway.tools.drives.first_enable import fingerprint
from protocols.canopen import cob_id as cobid
from protocols.servodyn.plan import SYNC_ID

KINDS = {
    "gateway": "the cycle is ended: no SYNC, no heartbeat, no set values",
    "sync": "SYNC stays away",
    "heartbeat": "the gateway's heartbeat stays away",
}
STANDSTILL_RAD_S = 0.2  # at the motor
PATIENCE_S = 4.0


@dataclass(frozen=True, slots=True)
class Stop:
    """One axis after one loss."""

    loss: str
    axis: str
    unit: str
    speed: float  # unit/s when it happened
    reaction_ms: float  # until the axis began to slow down
    stop_ms: float  # until standstill
    way: float  # unit
    allowed_ms: float  # supervision time + one cycle, by when it has to react
    good: bool


def losses_of(cell: Cell) -> list[str]:
    """Possible losses in this cell: a SERVODYN bus has no heartbeat."""
    canopen = any(BUS_PROTOCOLS[bus.protocol].nodes for bus in cell.bus)
    return ["heartbeat", "sync", "gateway"] if canopen else ["sync", "gateway"]


def measure(client: ToolClient, cell: Cell, folder: pathlib.Path, loss: str, velocity: float) -> list[Stop]:
    """One loss in the middle of a move of all axes; the cell is enabled and referenced before if need be."""
    under_way(client, cell, mask_of(cell, [axis.name for axis in cell.axis]), velocity)
    time.sleep(0.5)
    lost_ns = _lose(client, cell, loss)
    time.sleep(PATIENCE_S)
    records = [
        (bus.name, _record(client.run, bus.name, folder)) for bus in cell.bus if any(axis.drive.bus == bus.name for axis in cell.axis)
    ]
    if loss == "gateway":
        cycle_again(client)
    return [_stop(cell, n, dict(records), loss, lost_ns) for n in range(len(cell.axis))]


def under_way(client: ToolClient, cell: Cell, mask: int, velocity: float) -> None:
    """Enabled, referenced, at one end of the travel; and off to the other one."""
    client.wait_ready()
    client.take_over()
    client.command("enable", mask)
    if not all(int(str(row["flags"])) & AxisFlag.REFERENCED for row in client.axes()):
        client.command("reference", mask, timeout_s=max(axis.home.timeout_s for axis in cell.axis) + 10.0)
    _far(client, cell, mask, velocity, low=True, wait=True)
    _far(client, cell, mask, velocity, low=False, wait=False)


def end_cycle(client: ToolClient) -> None:
    """The cycle is ended and stays away."""
    with ask(client.run, "hold", process="cycle") as link:
        link.makefile().readline()


def cycle_again(client: ToolClient) -> None:
    """It may start again."""
    with ask(client.run, "release", process="cycle") as link:
        link.makefile().readline()
    time.sleep(1.0)


def allowed_ms(bus: Bus, period_ms: float) -> float:
    """Time limit for a drive's reaction: its supervision time, one cycle for the drive, one for the record."""
    supervision = max(2 * period_ms, bus.heartbeat_ms * MISSED) if BUS_PROTOCOLS[bus.protocol].nodes else 2 * period_ms
    return float(supervision + 2 * period_ms)


def _far(client: ToolClient, cell: Cell, mask: int, velocity: float, *, low: bool, wait: bool) -> None:
    targets = [0.0] * len(cell.axis)
    for n, axis in enumerate(cell.axis):
        span = axis.limits.max - axis.limits.min
        targets[n] = axis.limits.min + span * (0.1 if low else 0.9)
    if wait:
        client.command("ptp_absolute", mask, velocity=velocity, targets=targets, timeout_s=120.0)
        return
    answer = client.ask("tool", code="ptp_absolute", mask=mask, velocity=velocity, targets=targets)
    if not answer["open"]:
        raise ToolError(f"ptp_absolute: {answer['words']} {answer['detail']}")


def _lose(client: ToolClient, cell: Cell, loss: str) -> int:
    """Cause the loss; return its start in ns of the monotonic clock."""
    if loss == "gateway":
        stamp = time.monotonic_ns()
        end_cycle(client)
        return stamp
    stamp = time.monotonic_ns()
    for bus in cell.bus:
        canopen = BUS_PROTOCOLS[bus.protocol].nodes
        identifier = cobid.heartbeat(GATEWAY_NODE) if loss == "heartbeat" else cobid.SYNC if canopen else SYNC_ID
        if any(axis.drive.bus == bus.name for axis in cell.axis):
            control = EmulatorControl(f"{client.run}-{bus.name}")
            control.ask("drop", way="in", id=identifier, count=1_000_000)
            control.close()
    return stamp


def _record(run: str, bus: str, folder: pathlib.Path) -> Record:
    control = EmulatorControl(f"{run}-{bus}")
    control.ask("clear_frames")
    control.ask("flush")
    control.close()
    return read((folder / f"emulator-{bus}.rec").read_bytes())


def _stop(cell: Cell, number: int, records: dict[str, Record], loss: str, lost_ns: int) -> Stop:
    axis = cell.axis[number]
    bus = next(bus for bus in cell.bus if bus.name == axis.drive.bus)
    record = records[axis.drive.bus]
    place = record.axes.index(axis.drive.module or axis.drive.node or 0)
    per_rad = abs(1.0 / motor_rad(axis, 1.0))
    rows = [row for row in record.rows if row.stamp_ns >= lost_ns]
    before = [row for row in record.rows if row.stamp_ns < lost_ns]
    if not rows or not before:
        raise ToolError(f"the record of bus {bus.name} has no rows around the loss")
    start = before[-1].axes[place]
    slower = next((row for row in rows if abs(row.axes[place].speed_rad_s) < 0.95 * abs(start.speed_rad_s)), None)
    still = _standstill(rows, place)
    period = _period_ms(record)
    allowed = allowed_ms(bus, period)
    moving = abs(start.speed_rad_s) > STANDSTILL_RAD_S
    reaction = (slower.stamp_ns - lost_ns) / 1e6 if slower is not None and moving else 0.0
    stop_ms = (still.stamp_ns - lost_ns) / 1e6 if still is not None else float("inf")
    way = abs((still or rows[-1]).axes[place].position_rad - start.position_rad) * per_rad
    good = still is not None and reaction <= allowed
    return Stop(
        loss,
        axis.name,
        axis.unit,
        round(abs(start.speed_rad_s) * per_rad, 3),
        round(reaction, 1),
        round(stop_ms, 1),
        round(way, 3),
        allowed,
        good,
    )


def _period_ms(record: Record) -> float:
    """The cycle time of the drives."""
    settings = record.header["settings"]
    assert isinstance(settings, dict)
    return float(settings["cycle_ms"])


def _standstill(rows: list[Row], place: int) -> Row | None:
    """The first row after which the axis never moves again."""
    found: Row | None = None
    for row in reversed(rows):
        if abs(row.axes[place].speed_rad_s) > STANDSTILL_RAD_S:
            break
        found = row
    return found


EVIDENCE = {  # measurement -> form of the report
    "emulator": "evidence: emulator, not this machine. Measured at the emulated motor shaft, from the loss to the last movement.",
    "bus": "evidence: these drives, on this bus. Measured by 6064h, from the last SYNC or heartbeat to the last change.",
}


def report(cell: Cell, stops: list[Stop], evidence: str = "emulator") -> dict[str, object]:
    """Everything a stop-time protocol needs; `evidence`: key of EVIDENCE."""
    return {
        "cell": cell.cell.name, "file": cell.file, "wall": wall(), "evidence": evidence, "drives": fingerprint(cell),
        "data_sheets": {axis.name: sheet_digest(cell, axis) for axis in cell.axis},
        "stops": [asdict(stop) for stop in stops], "good": all(stop.good for stop in stops),
    }  # fmt: skip


def write(cell: Cell, stops: list[Stop], folder: pathlib.Path, evidence: str = "emulator") -> tuple[pathlib.Path, pathlib.Path]:
    """JSON and HTML of one test."""
    folder.mkdir(parents=True, exist_ok=True)
    result = report(cell, stops, evidence)
    stem = folder / f"loss-test-{slug_of(cell)}"
    stem.with_suffix(".json").write_text(json.dumps(result, indent=1))
    stem.with_suffix(".html").write_text(_page(cell, stops, str(result["wall"]), EVIDENCE[evidence]))
    return stem.with_suffix(".json"), stem.with_suffix(".html")


def _page(cell: Cell, stops: list[Stop], moment: str, evidence: str) -> str:
    heads = ("lost", "axis", "speed", "reaction", "allowed", "at rest after", "distance", "verdict")
    cells = [
        (
            *(KINDS[s.loss], s.axis, f"{s.speed:g} {s.unit}/s", f"{s.reaction_ms:g} ms", f"{s.allowed_ms:g} ms"),
            *(f"{s.stop_ms:g} ms", f"{s.way:g} {s.unit}", "stops" if s.good else "DOES NOT STOP AS REQUIRED"),
        )
        for s in stops
    ]
    rows = "".join(f"<tr>{''.join(f'<td>{html.escape(value)}</td>' for value in row)}</tr>" for row in cells)
    return (
        '<!doctype html><meta charset="utf-8"><title>Stop times at bus loss</title>'
        "<style>body{font:15px sans-serif;margin:2em}td,th{padding:.3em .8em;border:1px solid #999;text-align:left}</style>"
        f"<h1>Stop times at bus loss: {html.escape(cell.cell.name)}</h1><p>{html.escape(moment)}; {html.escape(cell.file)}; {evidence}</p>"
        f"<table><tr>{''.join(f'<th>{head}</th>' for head in heads)}</tr>{rows}</table><p>{html.escape(BANNER)}</p>"
    )
