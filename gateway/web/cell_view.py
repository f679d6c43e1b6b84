"""The cell page: devices, wiring, findings of `check`, and evidence for each part."""

import functools
import pathlib
import re
from typing import Any

from gateway.assembly.run import RunPlan
from gateway.files.find import PACKAGED, read_evidence
from gateway.files.texts import read_texts, spoken
from gateway.pure.cell.cell import Axis, Bus, Cell, Line
from gateway.pure.reports.sentences import Sentence, in_language
from gateway.pure.reports.spoken import Spoken
from gateway.registry import CONTROLLERS, language_in
from gateway.web.german import german, says, umlauts
from gateway.web.plant_view import Plant
from gateway.web.skeleton import Skeleton

Row = dict[str, Any]
STATED = {"True": "yes", "False": "no", "None": "not stated"}


def described(plan: RunPlan, plant: Plant, skeleton: Skeleton) -> Row:
    """Everything about a run that does not change while it runs."""
    cell, language = plan.cell, language_in(plan.cell)
    return {
        "name": cell.cell.name,
        "file": shown_file(cell.file),
        "run": plan.slug,
        "replaces": cell.cell.replaces,
        "software": cell.cell.software,
        "language": cell.cell.language,
        "target": cell.cell.target,
        "simulated": plan.simulated,
        "p5_ms": plan.p5_ms,
        "axes": [_axis(axis) for axis in cell.axis],
        "command_sources": [{"number": source.number, "name": source.name, "kind": source.kind} for source in plan.sources],
        "lines": [_line(line, plan.lines[line.name]) for line in cell.line],
        "buses": [_bus(bus, plan.buses.get(bus.name, "not played"), listens=bus.name in plan.listening) for bus in cell.bus],
        "modbus": [{"name": server.name, "bind": plan.modbus_place(server.name), "unit": server.unit} for server in cell.modbus],
        "blocks": [
            {"number": db.number, "kind": db.kind, "words": db.words, "writer": db.writer, "line": db.line, "comment": db.comment}
            for db in cell.db
        ],
        "contacts": [
            {"name": io.name, "signal": io.signal, "device": f"{io.device.type} {io.device.bus} {io.device.node or ''}"} for io in cell.io
        ],
        "safety": safety(cell),
        "routes": [{"name": r.name, "from": r.from_, "to": r.to, "type": r.type, "edge": r.edge, "on_loss": r.on_loss} for r in cell.route],
        "wiring": wiring(cell),
        "notices": [{"level": notice.level, "where": _both(notice.where), "text": _both(notice.text)} for notice in cell.notices],
        "evidence": evidence(plan),
        "faults": plant.known(),
        "programs": language.words if language is not None else "",
        "val3": cell.val3 is not None,
        "plc": cell.controller is not None and cell.controller.plc is not None,
        "pendant": cell.controller is not None and CONTROLLERS[cell.controller.kind].panel is not None,
        "robot": {"kind": skeleton.kind, "reach": skeleton.reach, "why": skeleton.why, "model": cell.robot[0].model if cell.robot else ""},
    }


def shown_file(file: str) -> list[str] | str:
    """Path of the cell; a shipped one by its name, in both languages."""
    path = pathlib.Path(file).resolve()
    return wired(f"{path.stem} (shipped with axisgate)") if path.is_relative_to(PACKAGED) else file


def safety(cell: Cell) -> list[list[list[str]]]:
    """[safety] of the cell: name and value of each key, both in both languages."""
    if cell.safety is None:
        return []
    values = {name: str(getattr(cell.safety, name)) for name in cell.safety.__slots__}
    names = {name: name.replace("_", " ").replace("sto wired", "STO wired") for name in values}
    return [[wired(names[name]), wired(STATED.get(value, value))] for name, value in values.items()]


def wired(words: str) -> list[str]:
    """English and German of a place, a way of wiring or a key of [safety]."""
    return [words, _wiring().german(words)]


@functools.cache
def _wiring() -> Spoken:
    return Spoken(read_texts("wiring").pairs())


def _both(text: str) -> list[str]:
    """Findings of `check`, in the letters of a page."""
    german = in_language(text, "de") if isinstance(text, Sentence) else spoken("check-notices", "val3-files").german(text)
    return [str(text), umlauts(german)]


def _axis(axis: Axis) -> Row:
    limits = axis.limits
    warn = axis.following_error
    return {
        "name": axis.name, "unit": axis.unit, "drive": axis.drive.type, "bus": axis.drive.bus, "node": axis.drive.node or axis.drive.module,
        "min": limits.min, "max": limits.max, "speed": limits.speed, "accel": limits.accel, "jerk": limits.jerk,
        "gear": axis.mechanics.gear, "feed": axis.mechanics.feed_per_turn, "vertical": axis.mechanics.vertical,
        "warn": warn.warn if warn else None, "trip": warn.trip if warn else None, "home": axis.home.by,
    }  # fmt: skip


def _line(line: Line, url: str) -> Row:
    return {
        "name": line.name, "port": line.port, "played": url, "format": line.format, "protocol": line.protocol, "profile": line.profile,
        "layer": line.layer, "role": line.role, "priority": line.priority, "on_loss": line.supervision.on_loss,
        "silence_ms": line.supervision.max_silence_ms,
    }  # fmt: skip


def _bus(bus: Bus, url: str, *, listens: bool) -> Row:
    return {"name": bus.name, "port": bus.port, "played": url, "protocol": bus.protocol, "bitrate": bus.bitrate, "cycle_ms": bus.cycle_ms,
            "listens": listens}  # fmt: skip


def wiring(cell: Cell) -> list[Row]:
    """Wiring, one row per connection: from, to and how in both languages."""
    rows: list[Row] = [
        {
            "from": f"line {line.name}",
            "to": line.port,
            "how": f"{line.format} {line.wiring}".strip(),
            "signal": f"{line.protocol} {line.layer}",
        }
        for line in cell.line
    ]
    rows += [
        {"from": f"bus {bus.name}", "to": bus.port, "how": f"{bus.bitrate}, 120 ohm at both ends", "signal": bus.protocol}
        for bus in cell.bus
    ]
    rows += [
        {
            "from": f"axis {axis.name}",
            "to": f"bus {axis.drive.bus}",
            "how": f"address {axis.drive.node or axis.drive.module}",
            "signal": axis.drive.type,
        }
        for axis in cell.axis
    ]
    rows += [
        {
            "from": f"contact {io.name}",
            "to": f"{io.device.type} {io.device.bus} {io.device.node or ''}".strip(),
            "how": "contact",
            "signal": io.signal,
        }
        for io in cell.io
    ]
    return [{**row, **{name: wired(row[name]) for name in ("from", "to", "how")}} for row in rows]


def evidence(plan: RunPlan) -> list[Row]:
    """How far the parts of this cell were proved, out of configs/evidence.toml: specified, emulator, bench, plant; in both languages."""
    return [{"level": row["level"], "what": says(row["what"]), "why": row["why"]} for row in _evidence(plan)]


def _evidence(plan: RunPlan) -> list[Row]:
    cell = plan.cell
    rows: list[Row] = []
    for kind in dict.fromkeys(axis.drive.type for axis in cell.axis):
        rows += [{"what": f"drives {kind}", **row} for row in proved(f"drive:{kind}")]
        rows += [{"what": f"layout of {kind} telegrams", **row} for row in proved(f"layout:{kind}")]
    for bus in cell.bus:
        if bus.layout_evidence:
            rows.append({"what": f"layout of bus {bus.name}", "level": "specified", "why": says(bus.layout_evidence)})
    for line in cell.line:
        parts: tuple[str, ...] = (line.protocol, line.layer)
        for part in parts:
            rows += [{"what": f"line {line.name}: {part}", **row} for row in proved(f"line:{part}")]
    rows += [{"what": f"Modbus {server.name}", **row} for server in cell.modbus for row in proved("modbus")]
    for part, there in (("io", cell.io), ("route", cell.route), ("robot", cell.robot), ("northbound", cell.northbound)):
        rows += [{"what": part, **row} for row in proved(part) if there]
    return rows


def proved(part: str) -> list[Row]:
    """Level of this part in the data, and its judges in both languages."""
    found = [(table["level"], plain(str(table["what"])), plain(str(table["by"]))) for table in read_evidence() if part in _parts(table)]
    return [{"level": level, "why": [f"{what}: {by}", f"{german(what)}: {german(by)}"]} for level, what, by in found]


def _parts(table: dict[str, object]) -> list[object]:
    parts = table.get("parts", [])
    return parts if isinstance(parts, list) else []


def plain(text: str) -> str:
    """Without links and marks: the data is written for pages of text."""
    text = re.sub(r"\s*\((?:\[[^\]]*\]\([^)]*\)(?:, )?)+\)", "", text)
    return re.sub(r"\[([^\]]*)\]\([^)]*\)|\*\*|`", r"\1", text)
