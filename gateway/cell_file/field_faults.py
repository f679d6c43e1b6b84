"""Field faults: what pydantic found, reported with key, value, allowed range, unit and a hint."""

import dataclasses
import difflib
from collections.abc import Mapping, Sequence
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from drivers.emulator.servo.settings import RANGES
from gateway.pure.cell.axes import PlantAxis
from gateway.pure.cell.cell import CellTables
from gateway.pure.cell.columns import Column, bare_type, column_of, columns, parts_of
from gateway.pure.cell.faults import Fault
from gateway.pure.cell.lines import NumberForm
from gateway.pure.reports.toml_lines import Path, nearest

RESERVED: Mapping[str, tuple[str, ...]] = {  # line kinds whose shape is kept free (issue 2, item 8)
    "protocol": ("plain", "raw", "ascii", "3964", "buep19e", "modbus-rtu", "xon-xoff"),
    "layer": ("plain", "raw", "ascii", "lines"),
    "role": ("client",),
    "types": ("P", "B", "S"),
}
UNKNOWN_KEY = "unexpected_keyword_argument"
BEYOND = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
_KINDS = {
    "int_type": "a whole number", "int_from_float": "a whole number", "float_type": "a number", "bool_type": "true or false",
    "string_type": 'a text in "quotes"', "tuple_type": "a list [ .. ]", "dict_type": "a table", "dataclass_type": "a table",
    "date_type": "a date, 2026-11-20", "finite_number": "a finite number",
}  # fmt: skip


def field_faults(file: str, raw: Mapping[str, Any], places: Mapping[Path, int], error: ValidationError) -> list[Fault]:
    """One fault for each key pydantic complained about, in the order of the file."""
    faults: dict[str, Fault] = {}
    for detail in error.errors(include_url=False):
        fault = _fault(file, raw, dict(places), detail)
        faults.setdefault(fault.key, fault)
    return sorted(faults.values(), key=lambda fault: fault.line or 0)


def key_of(raw: Any, path: Sequence[str | int]) -> str:
    """A path as a person writes it: elements of lists by their name or number where they have one."""
    words: list[str] = []
    here = raw
    for part in path:
        here = _step(here, part)
        if isinstance(part, str):
            words.append(part)
        else:
            words[-1:] = [_element(words[-1] if words else "", here, part)]
    return ".".join(words)


def field_of(parts: Sequence[str]) -> tuple[str, str]:
    """Range and unit of a key written as people write it; the names of elements are stepped over."""
    current: Any = CellTables
    column: Column | None = None
    for part in parts:
        if _is_table(current):
            if current is PlantAxis and part in RANGES:
                return f"{RANGES[part].low:g}..{RANGES[part].high:g}", RANGES[part].unit
            column = column_of(current, part)
            current = bare_type(column.annotation) if column else None
        elif current is not None and get_args(current):
            column = parts_of(_inside(current))
            current = bare_type(column.annotation)
    return (column.range, column.unit) if column else ("", "")


def _fault(file: str, raw: Mapping[str, Any], places: dict[Path, int], detail: ErrorDetails) -> Fault:
    path: Path = tuple(part for part in detail["loc"] if part != "[key]")
    kind, value = detail["type"], detail["input"]
    _, column = _walk(path)
    if "[key]" in detail["loc"]:
        column = _key_column(path)
    span, unit = (column.range, column.unit) if column else ("", "")
    shown = "" if kind == "missing" or isinstance(value, dict | list) else _show(value)
    hint = ""
    if kind == UNKNOWN_KEY:
        span, shown, hint = "", "", _unknown_key(path)
    elif kind == "missing":
        hint = _missing(path, span, unit)
        span = ""
    elif kind == "literal_error":
        span = _literal(detail)
        hint = _reserved(path, value) or _near(str(value), span.split(" | "))
    elif kind in _KINDS:
        span = _KINDS[kind] if not span else f"{_KINDS[kind]}, {span}"
        hint = _header_hint(path, value)
    elif kind == "string_too_short":
        span, hint = "a text", "must not be empty"
    elif kind in BEYOND:
        hint = column.why if column else ""
    elif kind != "string_pattern_mismatch":
        hint = detail["msg"]
    if path[:2] == ("robot", 0) and ("robot", 0) not in places:
        path = ("robot", *path[2:])  # one table [robot]
    return Fault(file, key_of(raw, path), shown, span, _axis_unit(raw, path, unit), hint, nearest(places, path))


def _literal(detail: ErrorDetails) -> str:
    return str(detail.get("ctx", {}).get("expected", "")).replace("'", "").replace(" or ", " | ").replace(", ", " | ")


def _show(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else str(value)


def _step(here: Any, part: str | int) -> Any:
    if isinstance(part, int):
        return here[part] if isinstance(here, list) and part < len(here) else None
    return here.get(part) if isinstance(here, Mapping) else None


def _element(word: str, here: Any, number: int) -> str:
    """axis[0] becomes axis.X, db[1] becomes db.11, an entry the place it is at."""
    for name in ("name", "number", "at", "axis"):
        if isinstance(here, Mapping) and isinstance(here.get(name), str | int):
            return f"{word}.{here[name]}" if name != "at" else f"{word}[{here[name]}]"
    return f"{word}[{number}]"


def _walk(path: Sequence[str | int]) -> tuple[type | None, Column | None]:
    """The innermost table around a path and the column it ends in."""
    current: Any = CellTables
    table: type | None = None
    column: Column | None = None
    for part in path:
        if _is_table(current):
            table, column = current, column_of(current, str(part))
            current = bare_type(column.annotation) if column else None
        elif current is not None:
            column = parts_of(_inside(current)) if get_args(current) else None
            current = bare_type(column.annotation) if column else None
    return table, column


def _key_column(path: Path) -> Column | None:
    """Permitted names of a table by names."""
    _, column = _walk(path[:-1])
    names = get_args(bare_type(column.annotation)) if column else ()
    return parts_of(names[0]) if names else None


def _inside(container: Any) -> Any:
    """The element type of a list or mapping."""
    return [each for each in get_args(container) if each is not Ellipsis][-1]


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and dataclasses.is_dataclass(kind)


def _keys(table: Any) -> list[str]:
    keys = [key for key, column in columns(table).items() if not column.loaded] if _is_table(table) else []
    return [*keys, *RANGES] if table is PlantAxis else keys


def _unknown_key(path: Path) -> str:
    table, _ = _walk(path)
    key, known = str(path[-1]), _keys(table)
    for name in known:
        column = column_of(table, name) if table else None
        if column and key in _keys(bare_type(column.annotation)):
            return f"unknown key here; it belongs in {name}"
    near = _near(key, known)
    return f"unknown key; {near}" if near else f"unknown key; known are {', '.join(known)}"


def _near(word: str, known: Sequence[str]) -> str:
    lower = {each.lower(): each for each in known}
    found = difflib.get_close_matches(word.lower(), lower, n=1, cutoff=0.6)
    return f"did you mean {lower[found[0]]}?" if found else ""


def _missing(path: Path, span: str, unit: str) -> str:
    if path[-1] == "type" and "entries" in path:
        return f"missing: each entry needs the number format, there is no default; types are {', '.join(get_args(NumberForm))}"
    what = " ".join(word for word in (span, unit if "{u}" not in unit else "") if word)
    return f"missing{f' ({what})' if what else ''}"


def _reserved(path: Path, value: object) -> str:
    key = next((str(part) for part in reversed(path) if isinstance(part, str)), "")
    return f"{key} = {_show(value)} is reserved for a later version" if value in RESERVED.get(key, ()) else ""


def _header_hint(path: Path, value: object) -> str:
    if len(path) == 1 and isinstance(value, dict):
        return f"write [[{path[0]}]] with double brackets first; [{path[0]}.xxx] then belongs to the last [[{path[0]}]] above it"
    return ""


def _axis_unit(raw: Mapping[str, Any], path: Path, unit: str) -> str:
    """{u} becomes the unit of the axis the path is in."""
    if "{u}" not in unit:
        return unit
    axis: Any = None
    if path[0] == "axis" and len(path) > 1:
        axis = _step(raw.get("axis"), path[1])
    elif path[0] == "plant" and len(path) > 2:
        axis = next((each for each in raw.get("axis", []) if isinstance(each, Mapping) and each.get("name") == path[2]), None)
    name = axis.get("unit") if isinstance(axis, Mapping) else None
    return unit.replace("{u}", name if name in ("mm", "deg") else "unit")
