"""Electronic data sheets (EDS) and device configurations (DCF), read tolerantly: every fault is named with its line.

Source: CiA 306-1.  A file is never refused: unusable entries are left out, and `Fault.taken` reports them.
"""

import collections
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from protocols.canopen.dictionary import Access, Entry, Head, ObjectDictionary, Shape, fits
from protocols.canopen.types import DOMAIN, TYPES, UNSIGNED8, DataType, Kind, Value

_OBJECT = re.compile(r"([0-9a-f]{1,4})$")
_SUB = re.compile(r"([0-9a-f]{1,4})sub([0-9a-f]{1,2})$")
_LISTS = ("mandatoryobjects", "optionalobjects", "manufacturerobjects")
_COMPACT = "compactsubobj"


@dataclass(frozen=True, slots=True)
class Fault:
    line: int
    section: str
    what: str
    taken: str  # treatment of the fault

    def __str__(self) -> str:
        return f"line {self.line}: [{self.section}] {self.what}; {self.taken}"


@dataclass(slots=True)
class Section:
    """One [section] of the file: lower-case key -> (value, line)."""

    name: str
    line: int
    items: dict[str, tuple[str, int]] = field(default_factory=dict)

    def text(self, key: str) -> str:
        """The value without remark; empty when it is missing."""
        return self.items.get(key, ("", 0))[0]

    def line_of(self, key: str) -> int:
        return self.items.get(key, ("", self.line))[1]


def parse(text: str) -> tuple[ObjectDictionary, tuple[Fault, ...]]:
    """The dictionary and everything that is wrong with the file, in order of lines."""
    reader = _Reader(text)
    dictionary = reader.dictionary()
    return dictionary, tuple(sorted(reader.faults, key=lambda fault: fault.line))


def sections(text: str) -> tuple[dict[str, Section], list[Fault]]:
    """The file cut into sections, by lower-case name."""
    found: dict[str, Section] = {}
    faults: list[Fault] = []
    here: Section | None = None
    for number, raw in enumerate(text.lstrip("\ufeff").splitlines(), 1):
        line = raw.strip()
        if not line or line[0] in ";#":
            continue
        if line[0] == "[":
            name = line[1:].partition("]")[0].strip()
            if "]" not in line:
                faults.append(Fault(number, name, "section without closing bracket", f"read as [{name}]"))
            here = found.get(name.lower())
            if here is None:
                here = found[name.lower()] = Section(name, number)
            else:
                faults.append(Fault(number, name, f"duplicate section (first in line {here.line})", "its keys are added to the first"))
            continue
        key, equals, value = line.partition("=")
        if here is None or not equals:
            faults.append(Fault(number, here.name if here else "", f"{line[:40]!r} is neither section nor key=value", "ignored"))
        elif key.strip().lower() in here.items:
            faults.append(Fault(number, here.name, f"duplicate key {key.strip()}", "the first one counts"))
        else:
            here.items[key.strip().lower()] = (value.strip(), number)
    return found, faults


def number_of(text: str) -> int:
    """A number as files write it: 10, 0x1A, 1Ah, 012 (octal, CiA 306).  Raises ValueError."""
    plain = text.partition(";")[0].replace(" ", "").lower()
    if re.fullmatch(r"-?0[0-7]+", plain):
        return int(plain, 8)
    if re.fullmatch(r"[0-9a-f]+h", plain):
        return int(plain[:-1], 16)
    return int(plain, 0) if not re.fullmatch(r"-?0\d+", plain) else int(plain, 10)


class _Reader:
    def __init__(self, text: str) -> None:
        self.sections, self.faults = sections(text)
        self.entries: dict[tuple[int, int], Entry] = {}
        self.heads: dict[int, Head] = {}

    def dictionary(self) -> ObjectDictionary:
        objects = {int(name, 16): section for name, section in self.sections.items() if _OBJECT.match(name)}
        for index, section in objects.items():
            self._object(index, section)
        for name, section in self.sections.items():
            if match := _SUB.match(name):
                self._sub(int(match[1], 16), int(match[2], 16), section)
        self._check_counts(objects)
        self._check_lists(objects)
        info = self.sections.get("deviceinfo")
        device = {key: value for key, (value, _) in info.items.items()} if info else {}
        if info is None:
            self._fault(1, "DeviceInfo", "section is missing", "identity unknown")
        else:
            self._check_device(info)
        commissioning = self.sections.get("devicecomissioning") or self.sections.get("devicecommissioning")
        node = self._whole(commissioning, "nodeid") if commissioning else None
        rate = self._whole(commissioning, "baudrate") if commissioning else None
        return ObjectDictionary(self.entries, self.heads, device, self._dummies(), node, rate * 1000 if rate else None)

    # -- objects --------------------------------------------------------------------------------

    def _object(self, index: int, section: Section) -> None:
        name = section.text("parametername")
        if not name:
            name = f"object {index:04X}h"
            self._fault(section.line, section.name, "ParameterName is missing or empty", f"called {name!r}")
        shape = self._shape(index, section)
        self.heads[index] = Head(index, name, shape)
        count = self._whole(section, _COMPACT) if section.text(_COMPACT) else None
        if count:
            self._compact(index, section, count)
        elif shape in (Shape.VAR, Shape.DOMAIN, Shape.DEFTYPE):
            self._add(self._entry(index, 0, name, section, DOMAIN if shape is Shape.DOMAIN else None))

    def _shape(self, index: int, section: Section) -> Shape:
        if not section.text("objecttype"):
            return Shape.RECORD if section.text("subnumber") or f"{index:x}sub0" in self.sections else Shape.VAR
        try:
            return Shape(number_of(section.text("objecttype")))
        except ValueError:
            self._fault(section.line_of("objecttype"), section.name, f"ObjectType={section.text('objecttype')} is unknown", "read as VAR")
            return Shape.VAR

    def _sub(self, index: int, sub: int, section: Section) -> None:
        if index not in self.heads:
            self._fault(section.line, section.name, f"section [{index:04X}] is missing", "object made up as RECORD")
            self.heads[index] = Head(index, f"object {index:04X}h", Shape.RECORD)
        name = section.text("parametername")
        if not name:
            name = f"sub-index {sub}"
            self._fault(section.line, section.name, "ParameterName is missing or empty", f"called {name!r}")
        self._add(self._entry(index, sub, name, section, None))

    def _compact(self, index: int, section: Section, count: int) -> None:
        """CompactSubObj: sub-indexes 1..count are all alike; names and values may be in [xxxxName], [xxxxValue]."""
        names = self.sections.get(f"{index:x}name") or self.sections.get(f"{index:04x}name")
        values = self.sections.get(f"{index:x}value") or self.sections.get(f"{index:04x}value")
        head = self.heads[index]
        if head.shape is Shape.VAR:
            self.heads[index] = Head(index, head.name, Shape.ARRAY)
        pattern = self._entry(index, 1, head.name, section, None)
        self._add(Entry(index, 0, "NrOfObjects", UNSIGNED8, Access.RO, count))
        for sub in range(1, count + 1):
            if pattern is None:
                return
            name = (names.text(str(sub)) if names else "") or f"{head.name}{sub}"
            entry = replace(pattern, sub=sub, name=name)
            if values and values.text(str(sub)):
                value, relative = self._value(values, str(sub), entry.type)
                entry = replace(entry, default=value, relative=relative)
            self._add(entry)

    def _add(self, entry: Entry | None) -> None:
        if entry is not None:
            self.entries[entry.key] = entry

    def _entry(self, index: int, sub: int, name: str, section: Section, kind: DataType | None) -> Entry | None:
        kind = kind or self._type(section)
        if kind is None:
            return None
        default, relative = self._value(section, "defaultvalue", kind)
        parameter, moved = self._value(section, "parametervalue", kind)
        low, high = self._limit(section, "lowlimit", kind), self._limit(section, "highlimit", kind)
        if low is not None and high is not None and low > high:
            self._fault(section.line_of("lowlimit"), section.name, f"LowLimit {low} is above HighLimit {high}", "no limits")
            low = high = None
        entry = Entry(index, sub, name, kind, self._access(section), default, relative, low, high, self._mappable(section))
        if default is not None and not relative and fits(entry, default):
            text = f"DefaultValue {default!r} is outside {low}..{high}"
            self._fault(section.line_of("defaultvalue"), section.name, text, "taken all the same")
        return replace(entry, parameter=parameter, parameter_relative=moved)

    # -- fields ---------------------------------------------------------------------------------

    def _type(self, section: Section) -> DataType | None:
        text = section.text("datatype")
        try:
            code = number_of(text)
        except ValueError:
            what = f"DataType={text} is not a number" if text else "DataType is missing or empty"
            self._fault(section.line_of("datatype"), section.name, what, "left out")
            return None
        if code in TYPES:
            return TYPES[code]
        own = self.sections.get(f"{code:x}sub1")  # a type with limits, as some editors write it: this is its real type
        try:
            return TYPES[number_of(own.text("defaultvalue"))] if own else self._unknown_type(section, code)
        except (ValueError, KeyError):
            return self._unknown_type(section, code)

    def _unknown_type(self, section: Section, code: int) -> DataType:
        self._fault(section.line_of("datatype"), section.name, f"DataType {code:04X}h is unknown", "read as DOMAIN")
        return DOMAIN

    def _access(self, section: Section) -> Access:
        text = section.text("accesstype").lower()
        try:
            return Access(text)
        except ValueError:
            what = f"AccessType={text} is unknown" if text else "AccessType is missing or empty"
            self._fault(section.line_of("accesstype"), section.name, what, "read as ro")
            return Access.RO

    def _mappable(self, section: Section) -> bool:
        return bool(self._whole(section, "pdomapping")) if section.text("pdomapping") else False

    def _limit(self, section: Section, key: str, kind: DataType) -> int | float | None:
        value, _ = self._value(section, key, kind) if kind.whole or kind.kind is Kind.REAL else (None, False)
        return value if isinstance(value, int | float) else None

    def _value(self, section: Section, key: str, kind: DataType) -> tuple[Value | None, bool]:
        """The value and whether it counts from the node number; None when there is none."""
        text = section.text(key)
        if not text:
            return None, False
        try:
            return _value_of(text, kind)
        except ValueError as error:
            shown = {"defaultvalue": "DefaultValue", "parametervalue": "ParameterValue", "lowlimit": "LowLimit", "highlimit": "HighLimit"}
            why = str(error) if "outside" in str(error) else f"no value of {kind.name}"
            self._fault(section.line_of(key), section.name, f"{shown.get(key, key)}={text}: {why}", "ignored")
            return None, False

    def _whole(self, section: Section, key: str) -> int | None:
        try:
            return number_of(section.text(key))
        except ValueError:
            self._fault(section.line_of(key), section.name, f"{key}={section.text(key)} is not a number", "ignored")
            return None

    def _fault(self, line: int, section: str, what: str, taken: str) -> None:
        self.faults.append(Fault(line, section, what, taken))

    # -- the complete file ------------------------------------------------------------------------

    def _check_counts(self, objects: Mapping[int, Section]) -> None:
        described = collections.Counter(int(match[1], 16) for name in self.sections if (match := _SUB.match(name)))
        for index, section in objects.items():
            if self.heads[index].shape not in (Shape.ARRAY, Shape.RECORD) or section.text(_COMPACT):
                continue
            found = described[index]
            if not found:
                self._fault(section.line, section.name, "object without any sub-index", "left out")
                del self.heads[index]
            elif section.text("subnumber") and self._whole(section, "subnumber") not in (found, None):
                text = f"SubNumber={section.text('subnumber')}, but {found} sub-indexes are described"
                self._fault(section.line_of("subnumber"), section.name, text, "the described ones count")

    def _check_lists(self, objects: Mapping[int, Section]) -> None:
        listed: dict[int, tuple[str, int]] = {}
        for name in _LISTS:
            section = self.sections.get(name)
            for key, (text, line) in section.items.items() if section else ():
                if not key.isdigit():
                    continue
                try:
                    listed[number_of(text)] = (section.name if section else name, line)
                except ValueError:
                    self._fault(line, section.name if section else name, f"{key}={text} is not an object", "ignored")
        for index, (place, line) in listed.items():
            if index not in objects:
                self._fault(line, place, f"object {index:04X}h is listed but not described", "it does not exist")
        for index, section in objects.items():
            if listed and index not in listed and index >= 0x1000:
                self._fault(section.line, section.name, f"object {index:04X}h is described but not listed", "it exists")

    def _check_device(self, info: Section) -> None:
        for key in ("vendornumber", "productnumber", "revisionnumber"):
            try:
                number_of(info.text(key))
            except ValueError:
                text = f"{key}={info.text(key)} is not a number" if info.text(key) else f"{key} is missing or empty"
                self._fault(info.line_of(key), info.name, text, "read as 0")
                info.items[key] = ("0", info.line_of(key))

    def _dummies(self) -> frozenset[int]:
        section = self.sections.get("dummyusage")
        used = set()
        for key, (text, _) in section.items.items() if section else ():
            if key.startswith("dummy") and text.strip() == "1":
                used.add(int(key.removeprefix("dummy"), 16))
        return frozenset(used)


def _value_of(text: str, kind: DataType) -> tuple[Value, bool]:
    """Raises ValueError when the text is not a value of this type."""
    if kind.kind is Kind.TEXT:
        return text, False
    if kind.kind is Kind.BYTES:
        return bytes.fromhex(text), False
    if kind.kind is Kind.REAL:
        return float(text), False
    plain = re.sub(r"\s", "", text.partition(";")[0]).upper()
    relative = "$NODEID" in plain
    value = number_of(re.sub(r"\+?\$NODEID\+?", "", plain) or "0")
    if value > kind.high and kind.kind is Kind.SIGNED and value < 1 << kind.bits:
        value -= 1 << kind.bits  # negative numbers are often written as the bits they have
    if not kind.low <= value <= kind.high:
        raise ValueError(f"outside the range of {kind.name}, {kind.low}..{kind.high}")
    return value, relative
