"""Explains a key of a cell: value, unit, source; also addresses and words.  Used by `axisgate explain`."""

import dataclasses
import textwrap
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from gateway.assembly.data_block_signals import place_of
from gateway.assembly.line_dialects import rk512_dialect
from gateway.cell_file.explain_operands import operand_lines
from gateway.cell_file.field_faults import field_of
from gateway.cell_file.glossary import ALIASES, ALSO_CALLED, MEANINGS, PARAMETERS, WORDS
from gateway.cell_file.keys import line_of, steps_of, written
from gateway.cell_file.rho3_parameters import LEGAL
from gateway.files.decisions import read_decision
from gateway.files.find import find_config, read_text
from gateway.files.signal_lists import signal_list
from gateway.files.texts import read_texts
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.cell import Line as CellLine
from gateway.pure.image.addresses import (
    AddressFault,
    CellName,
    DataBit,
    DataWord,
    Operand,
    RcBit,
    Register,
    cl300,
    parse,
    parse_operand,
    pic,
    rc,
)
from gateway.pure.lines.line_profiles import link_profile
from gateway.pure.reports.toml_lines import lines_of
from gateway.registry import LINE_LAYERS
from protocols.p3964r.profiles import NETWORK, PROFILES, Profile
from protocols.rk512.dialects import dialect_of


@dataclass(frozen=True, slots=True)
class Line:
    """One explained value."""

    key: str
    value: str
    unit: str = ""
    source: str = ""


class Explainer:
    """Everything `explain` knows about one cell file."""

    def __init__(self, cell: Cell, path: str) -> None:
        self.cell = cell
        text = read_text(find_config(path, "cells"))
        self._raw, self._places, self._name = tomllib.loads(text), lines_of(text), path

    def key(self, key: str) -> list[Line]:
        """All values at and below a key; [] when the cell has none there."""
        found = _find(self.cell, key)
        if found is None:
            return []
        full, value = found
        return [
            Line(name, _shown(each), self._unit(name), self._source(name))
            for name, each in _leaves(full, value)
            if not (each is None and self._source(name) == "default")
        ]

    def block_place(self, text: str) -> list[Line]:
        """The entry at DB10.DW2, DB10.D0.8; [] when there is none."""
        try:
            place = parse(text)
        except AddressFault:
            return []
        for block in self.cell.db if isinstance(place, DataWord | DataBit) else ():
            for entry in block.entries:
                if place_of(block, entry) == place:
                    return self.key(f"db.{block.number}[{entry.at}]")
        return []

    def parameter(self, number: str) -> list[Line]:
        """A P number: its value, and its effect."""
        meaning, unit = PARAMETERS.get(number) or _not_used(number)
        params = self.cell.rho3
        raw = self._raw.get("rho3")
        given = isinstance(raw, dict) and number in raw
        value = getattr(params, number, None) if params and given else params.others.get(number) if params and given else None
        if number not in LEGAL:
            return []
        lines = [
            Line(
                f"rho3.{number}",
                _shown(value) if given else "not set",
                unit if given else "",
                self._place(f"rho3.{number}") if given else meaning,
            )
        ]
        lines += [Line("meaning", meaning)] if given else []
        if number == "P5":
            lines.append(Line("clock of this cell", str(self.cell.cycle_ms), "ms", lines[0].source if given else "bus.cycle_ms"))
        own = {
            key: source
            for key, source in self.cell.sources.items()
            if source.text.split("[")[0] == f"rho3.{number}" or source.text == f"rho3.{number}"
        }
        return lines + [Line(key, _shown(_value(self.cell, key)), self._unit(key), f"from {source.text}") for key, source in own.items()]

    def _unit(self, key: str) -> str:
        parts = [part.strip("[]") for part in steps_of(key)]
        unit = field_of(parts)[1]
        if "{u}" in unit:
            axis = next((axis for axis in self.cell.axis if axis.name in parts), None)
            return unit.replace("{u}", axis.unit if axis else "unit")
        return unit

    def _source(self, key: str) -> str:
        for name in _parents(key):
            if name in self.cell.sources:
                source = self.cell.sources[name]
                return source.text if source.line is None else f"{source.text}, {self._name}:{source.line}"
        return self._place(key) if written(self._raw, _toml(key)) else "default"

    def _place(self, key: str) -> str:
        line = line_of(self._raw, self._places, _toml(key))
        return self._name if line is None else f"{self._name}:{line}"


def parameter_of_any_cell(number: str) -> list[Line]:
    """Effect of a P number; [] for one the rho 3 does not have."""
    if number not in LEGAL:
        return []
    meaning, unit = PARAMETERS.get(number) or _not_used(number)
    return [Line(f"rho3.{number}", meaning, f"[{unit}]" if unit else "", "its value: --cell CELL")]


def decision_lines(number: str) -> list[Line]:
    """A decision: title and text; [] where there is none of that number."""
    found = read_decision(number)
    return [Line(number, found.title, "", found.chapter), *(Line("", part) for part in lines_in(found.text))] if found else []


def lines_in(text: str) -> Iterator[str]:
    """Paragraphs in lines of a terminal; tables and code stay as they are."""
    for line in text.splitlines():
        yield from textwrap.wrap(line, 110) if line and line[0] not in "| " else [line]


def word(text: str, cell: Cell | None) -> list[Line]:
    """A word of the trade: meaning, and for times the value of each profile and line."""
    name = ALIASES.get(text.upper(), text.upper())
    if name not in WORDS:
        return []
    meaning, key = WORDS[name]
    shown = f"{name} = {ALSO_CALLED[name]}" if name in ALSO_CALLED else name
    lines = [Line(shown, meaning, "", f"set by {key}")]
    lines += [Line(f"{shown} also", other, "", source) for other, source in MEANINGS.get(name, ())]
    if name in TIMES:
        lines += [_of_profile(name, profile) for profile in PROFILES.values()]
        lines += [_of_line(name, line) for line in cell.line if line.profile.removesuffix(NETWORK) in PROFILES] if cell else []
    return lines


TIMES = {"QVZ": "ack_delay", "ZVZ": "char_delay", "BWZ": "block_wait"}


def _of_profile(name: str, profile: Profile) -> Line:
    """A time as one station has it, in every meaning the word has there."""
    field = TIMES[name]
    value = f"{getattr(profile, field) / 1e6:g}"
    also = []
    if name == "QVZ":
        also = [f"under 3964: {profile.ack_delay_plain / 1e6:g} ms"]
    if name == "BWZ":
        waits = dialect_of(profile.name)
        also = [f"reaction: {waits.waits(9600) / 1e6:g} ms" if waits.reaction else "no reaction telegrams"]
    marks = ["no source names it [open]"] if field in profile.open_fields else []
    if profile.settable is not None:
        marks.append(f"settable {profile.settable.least}..{profile.settable.most}, step {profile.settable.step}")
    return Line(f"profile {profile.name}", value, "ms", "; ".join([*also, profile.source, *marks]))


def _of_line(name: str, cell_line: CellLine) -> Line:
    """The time a line of this cell runs with, and who set it."""
    given = {"QVZ": ("QVZ", "ADT"), "ZVZ": ("ZVZ", "CDT"), "BWZ": ("BWZ",)}[name]
    key = next((each for each in given if getattr(cell_line.times, each) is not None), "")
    value = f"{getattr(link_profile(cell_line), TIMES[name]) / 1e6:g}"
    source = f"times.{key}" if key else f'profile = "{cell_line.profile}"'
    if name == "BWZ" and LINE_LAYERS[cell_line.layer].blocks:
        source += f"; reaction: {rk512_dialect(cell_line).waits(cell_line.baud) / 1e6:g} ms at {cell_line.baud} Bd"
    return Line(f"line.{cell_line.name}", value, "ms", source)


def address(text: str, language: str, cell: Cell | None = None) -> list[Line]:
    """An address in all worlds, signals where the cell has them; [] when it is none."""
    signals = signal_list()
    signals = signals.moved(cell.signals) if cell is not None else signals
    try:
        place = parse_operand(text, signals.symbols())
    except AddressFault:
        return []
    if isinstance(place, CellName):
        return []
    if isinstance(place, Operand):
        return [Line(*row) for row in operand_lines(place, cell.controller.kind if cell and cell.controller else "")]
    if not isinstance(place, RcBit):
        shown = f"{place.table.name.lower()} {place.address}, base 0" if isinstance(place, Register) else str(place)
        return [Line(text, shown, "", "read it with axisgate var")]
    signal = signals.at(place)
    lines = [Line(place.direction.value, str(place.number), "bit"), Line("PIC", pic(place))]
    for name, convert in (("CL300", cl300), ("RC byte.bit", rc)):
        try:
            lines.append(Line(name, convert(place)))
        except AddressFault as error:
            lines.append(Line(name, "-", "", str(error)))
    if signal is not None:
        decision = signal.lines if signal.lines.startswith("AX-") else "AX-002"
        source = f"axisgate ({decision})" if signal.source == "axisgate" else f"rho3 {signal.lines}"
        lines.append(Line(signal.name, signal.text(language), "", source))
    return lines


def _parents(key: str) -> Iterator[str]:
    parts = key.split(".")
    for end in range(len(parts), 1, -1):
        yield ".".join(parts[:end])


def _toml(key: str) -> str:
    return key.replace("from_", "from").replace(".settings.", ".")


def _find(cell: Cell, key: str) -> tuple[str, Any] | None:
    """The value a key points at, and the key spelled in full (axis.1 may be the first axis)."""
    here: Any = cell
    spelled: list[str] = []
    for part in steps_of(key):
        step = _step(here, part)
        if step is None:
            return None
        name, here = step
        spelled.append(name)
    return ".".join(spelled).replace(".[", "["), here


def _step(here: Any, part: str) -> tuple[str, Any] | None:
    if isinstance(here, tuple):
        bare = part.strip("[]")
        for each in here:
            for name in ("name", "number", "at", "axis"):
                if str(getattr(each, name, None)) == bare:
                    return part, each
        if bare.isdecimal() and 1 <= int(bare) <= len(here):
            each = here[int(bare) - 1]
            return str(getattr(each, "name", part)), each
        return None
    if isinstance(here, Mapping):
        found = next((key for key in here if str(key) == part), None)
        return None if found is None else (part, here[found])
    if dataclasses.is_dataclass(here) and not isinstance(here, type):
        fields = {each.name: getattr(here, each.name) for each in dataclasses.fields(here)}
        if part.startswith("[") and hasattr(here, "entries"):
            return _step(here.entries, part)
        for name in (part, f"{part}_"):
            if name in fields:
                return part, fields[name]
        if "settings" in fields:
            return _step(fields["settings"], part)
    return None


def _value(cell: Cell, key: str) -> Any:
    found = _find(cell, key)
    return None if found is None else found[1]


def _not_used(number: str) -> tuple[str, str]:
    """A P number that has no effect."""
    return (f"has no effect: {read_texts('rho3-parameters').said(number)}" if number in LEGAL else "", "")


def _leaves(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        for each in dataclasses.fields(value):
            inner = getattr(value, each.name)
            name = key if each.name == "settings" else f"{key}.{each.name.rstrip('_')}"
            yield from _leaves(name, inner)
    elif isinstance(value, Mapping):
        for part, inner in value.items():
            yield from _leaves(f"{key}.{part}", inner)
    elif isinstance(value, tuple) and value and dataclasses.is_dataclass(value[0]):
        for number, inner in enumerate(value, 1):
            named = next((getattr(inner, name) for name in ("name", "number", "axis") if hasattr(inner, name)), number)
            yield from _leaves(f"{key}[{inner.at}]" if hasattr(inner, "at") else f"{key}.{named}", inner)
    else:
        yield key, value


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return "[" + ", ".join(_shown(each) for each in value) + "]"
    if isinstance(value, float):
        return f"{value:g}"
    return "-" if value is None else str(value) or '""'
