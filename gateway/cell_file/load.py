"""Loads a cell file: text -> tables -> P numbers and defaults worked in -> validated data, with every fault in one run.

`load_cell` is the only way in. Faults come in this order: field faults (each key alone), then cross faults among the parts without field
faults. A part with a field fault is left out of the cross checks; its name stays known.
"""

import dataclasses
import tomllib
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from drivers.emulator.servo.settings import RANGES, ServoSettings
from gateway.cell_file.field_faults import UNKNOWN_KEY, field_faults
from gateway.cell_file.keys import line_of
from gateway.cell_file.rho3_parameters import merge
from gateway.cell_file.syntax_hints import syntax_fault
from gateway.cell_file.validation import validated
from gateway.checks import cross_faults, notices
from gateway.files.find import find_config, read_text
from gateway.files.signal_lists import signal_list
from gateway.pure.cell.cell import Cell, CellTables, Source
from gateway.pure.cell.faults import CellFaults, Fault
from gateway.pure.reports.toml_lines import Path, lines_of, nearest
from gateway.registry import LINE_LAYERS

__all__ = ["CellFaults", "Fault", "load_cell", "load_tables"]

DEFAULTS_TAKEN = ("mode", "stop_on_bus_loss", "stop_evidence", "brake", "following_error", "home", "first_enable")
JERK_PER_ACCEL = 10.0  # 1/s: full acceleration is reached in 0.1 s (AX-123)
FIRST = next(layer.name for layer in LINE_LAYERS.values() if layer.first)
SERVING = tuple(layer.name for layer in LINE_LAYERS.values() if layer.blocks)
QUIET = tuple(layer.name for layer in LINE_LAYERS.values() if layer.telegrams)  # partners that send only when they have data
PLANT_KEYS = frozenset(RANGES) | set(ServoSettings.__dataclass_fields__)
PLANT_OWN = frozenset(name for name in PLANT_KEYS if name.startswith(("start", "reference_switch", "hard_limit", "following_error")))


def load_cell(path: str, text: str | None = None) -> Cell:
    """The checked cell of a file (found by `find_config`).  CellFaults names everything that is wrong with it; OSError: no such file."""
    if text is None:
        found = find_config(path, "cells")
        path, text = str(found), _decoded(str(found))
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CellFaults([syntax_fault(path, text, error)]) from None
    return load_tables(path, raw, lines_of(text))


def load_tables(path: str, raw: dict[str, Any], places: dict[Path, int] | None = None) -> Cell:
    """The checked cell of tables already parsed; `places` has the lines of their keys.  Raises CellFaults."""
    return _Loader(path, raw, places or {}).load()


def _decoded(path: str) -> str:
    try:
        return read_text(find_config(path, "cells"))
    except UnicodeDecodeError as error:
        hint = f"byte {error.start} is not UTF-8: save the file as UTF-8 (an old editor's cp850 or cp1252 is not read)"
        raise CellFaults([Fault(path, "file", hint=hint, kind="syntax")]) from None


def _former_keys(raw: dict[str, Any]) -> None:
    """Rename keys of recordings and earlier versions to their present names.  If the present key exists, the former one is unknown."""
    table = raw.get("controller")
    if isinstance(table, dict) and "command_source" not in table and "door" in table:
        table["command_source"] = table.pop("door")


class _Loader:
    def __init__(self, path: str, raw: dict[str, Any], places: dict[Path, int]) -> None:
        self.path, self.raw, self.places = path, raw, places

    def load(self) -> Cell:
        merged = merge(self.path, self.raw, self.places)
        sources = dict(merged.sources)
        _former_keys(merged.raw)
        self._defaults(merged.raw, sources)
        if isinstance(merged.raw.get("robot"), dict):
            merged.raw["robot"] = [merged.raw["robot"]]
        faults = [fault for fault in merged.faults if fault.kind == "field"] + self._plant(merged.raw)
        tables, found = self._validated(merged.raw)
        faults = sorted(faults + found, key=lambda fault: fault.line or 0)
        crossed = [fault for fault in merged.faults if fault.kind == "cross"]
        if tables is not None:
            cell = self._cell(tables, sources)
            known = self._known_names(merged.raw)
            crossed += cross_faults(cell, known, signal_list(), self._line)
            if not faults and not crossed:
                return dataclasses.replace(cell, notices=tuple(notices(cell)))
        raise CellFaults([*faults, *sorted(crossed, key=lambda fault: fault.line or 0)])

    def _validated(self, raw: dict[str, Any]) -> tuple[CellTables | None, list[Fault]]:
        """The tables that are valid, and the field faults of the rest: a faulty part is cut out and the rest tried again."""
        faults: list[Fault] = []
        for attempt in range(100):
            try:
                return validated(raw), faults
            except ValidationError as error:
                if attempt == 0:
                    faults = field_faults(self.path, raw, self.places, error)
                for where in sorted({_part(each["loc"], each["type"]) for each in error.errors()}, key=_cut_order, reverse=True):
                    _cut(raw, where)
        return None, faults

    def _defaults(self, raw: dict[str, Any], sources: dict[str, Source]) -> None:
        """[defaults.axis] under every axis; jerk from acceleration; the RK512 line of a block when there is only one."""
        defaults = raw.get("defaults")
        common = defaults.get("axis") if isinstance(defaults, dict) else None
        for axis in _tables(raw.get("axis")):
            for key in DEFAULTS_TAKEN:
                if isinstance(common, dict) and key in common and key not in axis:
                    axis[key] = common[key]
                    sources[f"axis.{axis.get('name')}.{key}"] = Source("[defaults.axis]", nearest(self.places, ("defaults", "axis", key)))
            limits = axis.get("limits")
            if isinstance(limits, dict) and "jerk" not in limits and isinstance(limits.get("accel"), int | float):
                limits["jerk"] = JERK_PER_ACCEL * limits["accel"]
                sources[f"axis.{axis.get('name')}.limits.jerk"] = Source(f"default: {JERK_PER_ACCEL:g} x limits.accel (AX-123)")
        for line in _tables(raw.get("line")):
            timeout = line.get("output_timeout")
            if isinstance(timeout, int) and "priority" not in line:
                line["priority"] = "low" if timeout == -1 else "high"
                place = self._line(f"line.{line.get('name')}.output_timeout")
                sources[f"line.{line.get('name')}.priority"] = Source(f"output_timeout = {timeout}", place)
            if line.get("layer") in QUIET and "supervision" not in line:  # such a partner sends only when it has data
                line["supervision"] = {"max_silence_ms": 0}
                sources[f"line.{line.get('name')}.supervision.max_silence_ms"] = Source("default of telegrams: no supervision (AX-195)")
        layers = {name: line.get("layer", FIRST) for line in _tables(raw.get("line")) if isinstance(name := line.get("name"), str)}
        usual = [name for name, layer in layers.items() if layer == FIRST]
        served = usual or [name for name, layer in layers.items() if layer in SERVING]
        why = "the only RK512 line" if usual else "the only line that serves data blocks"
        for block in _tables(raw.get("db")):
            if "line" not in block and len(served) == 1:
                block["line"] = served[0]
                sources[f"db.{block.get('number')}.line"] = Source(why)

    def _plant(self, raw: dict[str, Any]) -> list[Fault]:
        """Keys named like the emulator's settings go into `settings`; each is held against the emulator's own range."""
        faults: list[Fault] = []
        plant = raw.get("plant")
        axes = plant.get("axis") if isinstance(plant, dict) else None
        for name, table in axes.items() if isinstance(axes, dict) else ():
            if not isinstance(table, dict):
                continue
            settings = {key: table.pop(key) for key in list(table) if key in PLANT_KEYS - PLANT_OWN}
            for key, value in settings.items():
                faults += self._plant_fault(f"plant.axis.{name}.{key}", key, value)
            table["settings"] = {key: value for key, value in settings.items() if isinstance(value, int | float)}
        return faults

    def _plant_fault(self, where: str, key: str, value: object) -> list[Fault]:
        allowed = RANGES.get(key)
        number = isinstance(value, int | float) and (allowed is None) == isinstance(value, bool)
        if number and (allowed is None or allowed.low <= float(str(value)) <= allowed.high):
            return []
        span = "true or false" if allowed is None else f"{allowed.low:g}..{allowed.high:g}"
        unit, hint = ("", "") if allowed is None else (allowed.unit, allowed.hint)
        return [Fault(self.path, where, str(value), span, unit, hint, self._line(where))]

    def _cell(self, tables: CellTables, sources: Mapping[str, Source]) -> Cell:
        values = {field.name: getattr(tables, field.name) for field in dataclasses.fields(CellTables)}
        return Cell(file=self.path, sources=sources, **values)

    def _known_names(self, raw: Mapping[str, Any]) -> Mapping[str, frozenset[str]]:
        """Names of all parts, also of those with field faults: a reference to them is not a second fault."""
        known = {
            kind: frozenset(str(each.get("name")) for each in _tables(self.raw.get(kind)))
            for kind in ("line", "bus", "axis", "modbus", "telegram")
        }
        robots = self.raw.get("robot")
        known["robot"] = frozenset(
            str(each["name"]) for each in ([robots] if isinstance(robots, dict) else _tables(robots)) if each.get("name")
        )
        blocks = frozenset(str(each.get("number")) for each in _tables(self.raw.get("db")))
        params = self.raw.get("rho3")
        given = frozenset(key for key, value in params.items() if value) if isinstance(params, dict) else frozenset()
        return {**known, "rho3": given, "db": blocks, "axis": known["axis"] | {str(each.get("name")) for each in _tables(raw.get("axis"))}}

    def _line(self, key: str) -> int | None:
        return line_of(self.raw, self.places, key)


def _tables(value: Any) -> list[dict[str, Any]]:
    return [each for each in value if isinstance(each, dict)] if isinstance(value, list) else []


def _part(where: tuple[str | int, ...], kind: str) -> Path:
    """The part to remove so that the rest can be judged: an unknown key alone, else the list element or table around it."""
    if kind == UNKNOWN_KEY:
        return where
    if where[0] == "telegram":  # its entries are counted: none may leave the row
        return where[:2]
    for end in range(len(where) - 1, 0, -1):
        if isinstance(where[end], int) and where[0] != "rho3":
            return where[: end + 1]
    if where[0] in ("handshake", "rho3", "defaults"):
        return where[:2]
    return where[:3] if where[:2] == ("plant", "axis") else where[:1]


def _cut_order(where: Path) -> tuple[tuple[bool, int, str], ...]:
    """Sorted backwards: later elements before earlier ones, inner ones before their containers."""
    return tuple((isinstance(part, int), part if isinstance(part, int) else 0, str(part)) for part in where)


def _cut(raw: dict[str, Any], where: Path) -> None:
    here: Any = raw
    for part in where[:-1]:
        here = here.get(part) if isinstance(here, dict) else here[part] if isinstance(part, int) and part < len(here) else None
        if here is None:
            return
    last = where[-1]
    if where in (("cell",), ("format",)):
        raw[where[0]] = {"name": "?"} if where == ("cell",) else 1
    elif isinstance(here, dict):
        here.pop(last, None)
    elif isinstance(here, list) and isinstance(last, int) and last < len(here):
        del here[last]
