"""Contents of the monitor's tabs, from regions and services."""

from collections.abc import Sequence

from gateway.files.error_catalogue import lookup
from gateway.observer.names import MOST, Entry
from gateway.observer.regions import Regions
from gateway.observer.tool_link import Row
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import AxisFlag, Motion, Quality
from gateway.tools.monitor.tables import Table, number
from protocols.base.errors import ProtocolError
from protocols.base.step5 import Step5Type, decode

STATES = (
    (AxisFlag.LOST, "no telegram"),
    (AxisFlag.FAULT, "fault"),
    (AxisFlag.UNCONFIGURED, "not started up"),
    (AxisFlag.WARNING, "warning"),
    (AxisFlag.HOMING, "referencing"),
    (AxisFlag.ENABLED, "enabled"),
    (AxisFlag.REFERENCED, "referenced"),
    (AxisFlag.IN_POSITION, "in position"),
)
QUALITIES = {int(Quality.GOOD): "good", int(Quality.STALE): "old", int(Quality.BAD): "bad"}
AXES = ("axis", "unit", "set", "actual", "lag", "speed", "torque %", "limits", "state", "fault")
SIGNALS = ("name", "address", "value", "quality", "age s", "unit", "says")
SOURCES = ("source", "name", "kind", "link", "losses", "command", "reason", "counters")
SENTENCES = ("line", "ms", "side", "what", "text")
ERRORS = ("from", "code", "text", "cause", "what to do")
OURS, SHOWN_SENTENCES = "axisgate", 60
COUNTED = ("sends", "fetches", "refused", "bad_blocks", "own_jobs", "own_faults", "requests", "telegrams", "repeats", "attempts")


def headline(name: str, regions: Regions, *, simulated: bool) -> str:
    """One line; a silent cycle is reported before its last values."""
    head = regions.head()
    if not head["cycle_alive"]:
        state = "CYCLE SILENT: all values are old"
    elif head["emergency"]:
        state = "EMERGENCY STOP"
    else:
        state = "ready" if head["ready"] else f"not ready ({', '.join(head['missing']) or 'drives off'})"
    parts = [
        name + (" (simulated)" if simulated else ""),
        state,
        Motion(head["motion"]).name.lower(),
        f"override {head['override']:g} %",
        f"drives {head['enabled']}/{head['axes']}",
        f"control: command source {head['owner']}" if head["owner"] else "control: not in use",
    ]
    if head["forced"]:
        parts.append(f"{head['forced']} FORCED")
    if not head["services_alive"]:
        parts.append("SERVICES SILENT")
    return " | ".join(parts)


def axes_table(cell: Cell, regions: Regions) -> Table:
    """One row an axis."""
    rows, marks = [], []
    for axis, row in zip(cell.axis, regions.drives(), strict=False):
        flags = AxisFlag(row["flags"])
        words = ", ".join(word for flag, word in STATES if flags & flag) or "off"
        limits = f"{axis.limits.min:g} .. {axis.limits.max:g}"
        figures = [number(row[name]) for name in ("set", "actual", "lag", "speed")]
        rows.append((axis.name, axis.unit, *figures, number(row["torque"], 1), limits, words, str(row["fault"] or "")))
        marks.append("bad" if flags & (AxisFlag.FAULT | AxisFlag.LOST) else "warn" if flags & AxisFlag.WARNING else "")
    return Table("Axes", AXES, tuple(rows), tuple(marks), "this cell has no axis")


def signals_table(entries: Sequence[Entry], values: Row, chosen: str, found: int, language: str) -> Table:
    """Those of a search that pass the filter: all | on | forced | old."""
    rows, marks = [], []
    for entry in entries:
        value, quality, age, forced = values.get(entry.id) or [None, int(Quality.BAD), None, False]
        if not _passes(chosen, value, quality, forced=forced):
            continue
        says = entry.de if language == "de" else entry.en
        state = "FORCED" if forced else QUALITIES.get(quality, "bad")
        rows.append(
            (entry.name, entry.addresses[0] if entry.addresses else "", shown(entry, value), state, _seconds(age), entry.unit, says)
        )
        marks.append("warn" if forced else "" if quality == Quality.GOOD else "old")
    more = f", the first {MOST} are shown" if found > MOST else ""
    return Table(f"Signals: {found} found{more}, filter: {chosen}", SIGNALS, tuple(rows), tuple(marks), "nothing fits search and filter")


def _seconds(age: object) -> str:
    """Tenths: a finer figure would change with every look."""
    return f"{age / 1000:.1f}" if isinstance(age, int) else ""


def _passes(chosen: str, value: object, quality: int, *, forced: bool) -> bool:
    match chosen:
        case "on":
            return value not in (None, 0, 0.0, "", "00000000")
        case "forced":
            return forced
        case "old":
            return quality != Quality.GOOD
    return True


def shown(entry: Entry, value: object) -> str:
    """By the entry's type; words of a block come as four bytes in hexadecimal."""
    if value is None:
        return "-"
    if entry.kind != "word" or not isinstance(value, str):
        return number(value)
    try:
        kind, data = Step5Type(entry.type), bytes.fromhex(value)
        if entry.id.endswith(("DL", "DR")):
            data = bytes((0, data[entry.id.endswith("DR")]))
        return number(decode(kind, data[: kind.size]))
    except (ValueError, ProtocolError):
        return value


def sources_table(regions: Regions) -> Table:
    """Lines and servers with their counters."""
    rows, marks = [], []
    known = regions.head()["services_alive"]  # without the services the state of their links is unknown
    for source in regions.status.get("command_sources", []):
        link = "?" if not known else "up" if source["alive"] else "DOWN"
        counted = ", ".join(
            [f"{name} {source[name]}" for name in COUNTED if source.get(name)] + [source[w] for w in ("why", "advice") if source.get(w)]
        )
        fixed = (str(source["number"]), source["name"], source["kind"], link, str(source["losses"]), source["state"].lower())
        rows.append((*fixed, "" if source["reason"] == "NONE" else source["reason"].lower(), counted))
        marks.append("" if link == "up" else "bad")
    return Table("Command sources", SOURCES, tuple(rows), tuple(marks), "this cell has no command source")


def sentences_table(lines: Row, language: str) -> Table:
    """Sentences about the traffic on the lines, newest last."""
    sentences = sorted(((line, one) for line, kept in lines.items() for one in kept), key=lambda said: said[1]["ms"])[-SHOWN_SENTENCES:]
    rows = tuple((line, f"{one['ms']:.1f}", *_sentence(one, language == "de")) for line, one in sentences)
    marks = tuple("bad" if one.get("kind") in ("BROKEN", "DAMAGED") or one["ok"] is False else "" for _, one in sentences)
    return Table("Traffic on the lines", SENTENCES, rows, marks, "no traffic yet")


def _sentence(one: Row, german: bool) -> tuple[str, str, str]:
    """Side, kind and words, of which the views have both languages; of a Modbus server one row is a client's request with its answer."""
    if "client" in one:
        return one["client"], f"FC {one['function']}", f"unit {one['unit']}, {one['asked'][german]}: {one['answered'][german]}"
    return one["side"], one["kind"], one["say"][german]


def errors_table(regions: Regions, alarms: Sequence[str], language: str) -> Table:
    """Pending errors, first one first, with cause and remedy from the catalogue."""
    rows: list[tuple[str, ...]] = [
        ("supervisor", "", alarm, "a process ended again and again", "see the journal; axisgate doctor") for alarm in alarms
    ]
    rows += [_row(OURS, int(error["code"]), str(error["text"]), language) for error in regions.status.get("errors", [])]
    control = regions.status.get("controller") or {}
    for error in control.get("errors", []):
        where = f"{error['text']} {error['where']}".strip() + ("" if error["active"] else " (waits for its reset)")
        rows.append(_row("rho3", int(error["code"]), where, language))
    return Table("Errors, first one first", ERRORS, tuple(rows), ("bad",) * len(rows), "no error pending")


def _row(family: str, code: int, text: str, language: str) -> tuple[str, ...]:
    entry = lookup(family, code)
    if entry is None:
        return family, str(code), text, "", f"axisgate explain {code}"
    return family, str(code), text or entry.text.text(language), entry.cause.text(language), entry.todo.text(language)
