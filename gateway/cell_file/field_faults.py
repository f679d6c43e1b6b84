"""Field faults: what pydantic found, told with key, value, allowed range, unit and a hint."""

import difflib
import types
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Union, get_args, get_origin

import annotated_types
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from drivers.emulator.servo.settings import RANGES
from gateway.cell_file.models.axes import PlantAxis
from gateway.cell_file.models.cell import CellFile
from gateway.cell_file.models.lines import STEP5_TYPES
from gateway.pure.cell.faults import Fault
from gateway.pure.reports.toml_lines import Path, nearest

RESERVED: Mapping[str, tuple[str, ...]] = {  # line kinds whose shape is kept free (issue 2, item 8)
    "protocol": ("plain", "raw", "ascii", "3964", "buep19e", "modbus-rtu", "xon-xoff"),
    "layer": ("plain", "raw", "ascii", "lines"),
    "role": ("client",),
    "types": ("P", "B", "S"),
}
_KINDS = {
    "int_type": "a whole number", "int_from_float": "a whole number", "float_type": "a number", "bool_type": "true or false",
    "string_type": 'a text in "quotes"', "list_type": "a list [ .. ]", "dict_type": "a table", "model_type": "a table",
    "model_attributes_type": "a table", "date_type": "a date, 2026-11-20", "finite_number": "a finite number",
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


def allowed(info: FieldInfo | None) -> tuple[str, str]:
    """Range and unit of a field, as words."""
    if info is None:
        return "", ""
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    unit = str(extra.get("unit", ""))
    if "allowed" in extra:
        return str(extra["allowed"]), unit
    low, high = "", ""
    for mark in info.metadata:
        low = f"{mark.ge}" if isinstance(mark, annotated_types.Ge) else f"> {mark.gt}" if isinstance(mark, annotated_types.Gt) else low
        high = f"{mark.le}" if isinstance(mark, annotated_types.Le) else f"< {mark.lt}" if isinstance(mark, annotated_types.Lt) else high
    if low and high:
        return f"{low}..{high}", unit
    return (low if low.startswith(">") else f">= {low}" if low else high and f"<= {high}"), unit


def field_of(parts: Sequence[str]) -> tuple[str, str]:
    """Range and unit of a key written as people write it; the names of elements are stepped over."""
    current: Any = CellFile
    info: FieldInfo | None = None
    for part in parts:
        if isinstance(current, type) and issubclass(current, BaseModel):
            if current is PlantAxis and part in RANGES:
                return f"{RANGES[part].low:g}..{RANGES[part].high:g}", RANGES[part].unit
            info = _field(current, part) or _field(current, f"{part}_")
            current = _bare(info.annotation) if info else None
        elif current is not None and get_args(current):
            info, current = _annotated(get_args(current)[-1]), _bare(get_args(current)[-1])
    return allowed(info)


def _fault(file: str, raw: Mapping[str, Any], places: dict[Path, int], detail: ErrorDetails) -> Fault:
    path: Path = tuple(part for part in detail["loc"] if part != "[key]")
    kind, value = detail["type"], detail["input"]
    _, info = _walk(path)
    span, unit = allowed(info)
    shown = "" if kind == "missing" or isinstance(value, dict | list) else _show(value)
    hint = ""
    if kind == "extra_forbidden":
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
    elif kind not in ("greater_than", "greater_than_equal", "less_than", "less_than_equal", "string_pattern_mismatch"):
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
    """axis[0] becomes axis.X, db[1] becomes db.11, an entry the place it stands at."""
    for name in ("name", "number", "at", "axis"):
        if isinstance(here, Mapping) and isinstance(here.get(name), str | int):
            return f"{word}.{here[name]}" if name != "at" else f"{word}[{here[name]}]"
    return f"{word}[{number}]"


def _walk(path: Sequence[str | int]) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The innermost model around a path and the field it ends in."""
    current: Any = CellFile
    model: type[BaseModel] | None = None
    info: FieldInfo | None = None
    for part in path:
        if isinstance(current, type) and issubclass(current, BaseModel):
            model, info = current, _field(current, str(part))
            current = _bare(info.annotation) if info else None
        elif current is not None:
            inner = get_args(current)
            current = _bare(inner[-1]) if inner else None
            info = _annotated(inner[-1]) if inner else None
    return model, info


def _field(model: type[BaseModel], key: str) -> FieldInfo | None:
    for name, info in model.model_fields.items():
        if key in (name, info.alias):
            return info
    return None


def _annotated(annotation: Any) -> FieldInfo | None:
    return FieldInfo.from_annotation(annotation) if hasattr(annotation, "__metadata__") else None


def _bare(annotation: Any) -> Any:
    """Without Optional and Annotated."""
    if hasattr(annotation, "__metadata__"):
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        inner = [each for each in get_args(annotation) if each is not type(None)]
        return _bare(inner[0])
    return None if get_origin(annotation) is Literal else annotation


def _keys(model: Any) -> list[str]:
    fields = model.model_fields if isinstance(model, type) and issubclass(model, BaseModel) else {}
    keys = [info.alias or name for name, info in fields.items() if name not in ("others", "settings")]
    return [*keys, *RANGES] if model is PlantAxis else keys


def _unknown_key(path: Path) -> str:
    model, _ = _walk(path)
    key, known = str(path[-1]), _keys(model)
    for name in known:
        inner = _bare(model.model_fields[name].annotation) if model and name in model.model_fields else None
        if key in _keys(inner):
            return f"unknown key here; it belongs into {name}"
    near = _near(key, known)
    return f"unknown key; {near}" if near else f"unknown key; known are {', '.join(known)}"


def _near(word: str, known: Sequence[str]) -> str:
    lower = {each.lower(): each for each in known}
    found = difflib.get_close_matches(word.lower(), lower, n=1, cutoff=0.6)
    return f"did you mean {lower[found[0]]}?" if found else ""


def _missing(path: Path, span: str, unit: str) -> str:
    if path[-1] == "type" and "entries" in path:
        return f"missing: every entry says how the number is written, there is no default; types are {', '.join(STEP5_TYPES)}"
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
