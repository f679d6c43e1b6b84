"""A read list as a cell file, with a report: applied, assumed, missing and ignored values (AX-272)."""

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.parameter_list.lines import Entry, Unread, Value, read

PER_AXIS = (103, 104, 108, 109, 114, 204, 205, 207, 208)
NEEDED = (103, 104, 108, 204, 205)  # without them an axis cannot be checked
DRIVE = tuple(range(602, 616))
WHOLE_DRIVE = (602, 603, 610, 614)
SINGLE = (2, 5, 9, 20)  # one integer
FIELDS: tuple[tuple[str, str], ...] = (  # label of P401 -> key of [[rho3.P401]]; "" is read and not needed (L3763-3781, L3903-3923)
    (r"^servo.?b|^servokarte", ""),
    (r"plug|connector|stecker", ""),
    (r"^modul|can.?modul", ""),
    (r"input|eingang", "module"),
    (r"ref\.?.?mod|referenz.?mod|ref\.?.?art", "ref_mode"),
    (r"gear|getriebe", "gear_factor"),
    (r"puls|inkr", "pulses"),
    (r"m.?bewert|evaluation", "evaluation"),
    (r"set.?point output|set value output|sollwert.?ausgang", "output"),
)
NO_AXIS = "no axis precedes it (A_1 ...)"
NO_NUMBER = "its value is not a number"
PULSES = {16384: 1, 8192: 2, 4096: 3}  # L7586-7588
RANGES = ("i.start", "i.end", "o.start", "o.end")
BLOCK = re.compile(r"block\s*(\d)", re.IGNORECASE)


@dataclass
class Report:
    """Sentences, each beginning with the line of the list it is about where there is one."""

    taken: list[str] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)


@dataclass
class Collected:
    """The list by parameter."""

    single: dict[int, int] = field(default_factory=dict)
    per_axis: dict[int, dict[int, list[float]]] = field(default_factory=lambda: defaultdict(dict))
    systems: dict[int, dict[str, float]] = field(default_factory=lambda: defaultdict(dict))
    boards: list[int] = field(default_factory=list)
    ranges: dict[str, int] = field(default_factory=dict)
    buses: dict[int, dict[str, int]] = field(default_factory=lambda: defaultdict(dict))
    blocks: dict[int, list[dict[str, int]]] = field(default_factory=lambda: defaultdict(list))
    clear: int | str | None = None  # P24
    download: bool | None = None  # P601
    monitoring: list[int] = field(default_factory=list)  # P306 sub-query 6 of each kinematic


def import_list(text: str, name: str) -> tuple[str, Report]:
    """Cell file and report of a printed list; `name` is the cell's name."""
    name = re.sub(r"[^\w .-]", "_", name) or "cell"
    report, kept = Report(), Collected()
    for each in read(text):
        if isinstance(each, Unread):
            report.ignored.append(f"line {each.line}: {each.text!r}: {each.why}")
        elif why := _take(each, kept):
            report.ignored.append(f"line {each.line}: P{each.parameter} {each.label!r}: {why}")
        else:
            report.taken.append(f"line {each.line}: P{each.parameter} {each.label} = {', '.join(map(str, each.values))}".replace("  ", " "))
    axes = sorted(kept.systems)
    _complete(kept, axes, report)
    return "\n".join(_file(kept, axes, name, report)) + "\n", report


# ------------------------------------------------------------------------------------------------ into the tables


def _take(entry: Entry, kept: Collected) -> str:
    """Empty, or why the entry is left aside."""
    number = entry.parameter
    takers: dict[int, Callable[[Entry, Collected], str]] = {
        15: _boards, 21: _range, 24: _clear, 30: _bus, 31: _block, 32: _block, 306: _kinematic, 401: _system, 601: _download,
        **dict.fromkeys(SINGLE, _single), **dict.fromkeys((*PER_AXIS, *DRIVE), _per_axis),
    }  # fmt: skip
    return takers[number](entry, kept) if number in takers else "axisgate does not use it"


def _several(entry: Entry) -> str:
    """Of what has one value."""
    return f"one value is expected, there are {len(entry.values)}" if len(entry.values) != 1 else ""


def _number(entry: Entry) -> str:
    return _several(entry) or (NO_NUMBER if isinstance(entry.values[0], str) else "")


def _single(entry: Entry, kept: Collected) -> str:
    first = entry.values[0]
    if why := _number(entry):
        return why
    if isinstance(first, bool | str) or first != int(first):
        return "a whole number is expected"
    if kept.single.setdefault(entry.parameter, int(first)) != int(first):
        return f"given above as {kept.single[entry.parameter]}, which is used"
    return ""


def _clear(entry: Entry, kept: Collected) -> str:
    first = entry.values[0]
    kept.clear = first if isinstance(first, int) else "all"
    return _several(entry)


def _download(entry: Entry, kept: Collected) -> str:
    kept.download = bool(entry.values[0])
    return _several(entry)


def _per_axis(entry: Entry, kept: Collected) -> str:
    if any(isinstance(value, str) for value in entry.values):
        return NO_NUMBER
    numbers = [float(value) for value in entry.values if not isinstance(value, str)]
    if entry.axis:
        kept.per_axis[entry.parameter].setdefault(entry.axis, []).extend(numbers)
    else:
        kept.per_axis[entry.parameter] |= {n: [value] for n, value in enumerate(numbers, 1)}
    return ""


def _boards(entry: Entry, kept: Collected) -> str:
    kept.boards += [int(value) for value in entry.values if not isinstance(value, str)]
    return NO_NUMBER if any(isinstance(value, str) for value in entry.values) else ""


def _range(entry: Entry, kept: Collected) -> str:
    label = next((each for each in RANGES if each in entry.label.lower().replace(" ", "")), "")
    if not label and len(entry.values) == 4:
        kept.ranges |= {each: _whole(value) for each, value in zip(RANGES, entry.values, strict=True)}
        return ""
    if not label:
        return "neither one of I.START, I.END, O.START, O.END nor four numbers"
    kept.ranges[label] = _whole(entry.values[0])
    return _number(entry)


def _kinematic(entry: Entry, kept: Collected) -> str:
    if not re.search(r"monitoring|berwachung", entry.label.lower()):
        return "axisgate does not use it"
    kept.monitoring.append(_whole(entry.values[0]))
    return _number(entry)


def _bus(entry: Entry, kept: Collected) -> str:
    label = entry.label.lower()
    found = (("inputs", r"input|eing"), ("outputs", r"output|ausg"), ("baud", r"baud"))
    key = next((key for key, pattern in found if re.search(pattern, label)), "")
    if not key:
        return "neither input blocks, output blocks nor baud rate"
    if why := _number(entry):
        return why
    bus = entry.bus or next(n for n in range(1, 100) if key not in kept.buses[n])
    kept.buses[bus][key] = _whole(entry.values[0])
    return ""


def _block(entry: Entry, kept: Collected) -> str:
    found = (("start", r"addr|start"), ("length", r"length|l(ae|\u00e4)nge"), ("id", r"identif"))
    key = next((key for key, pattern in found if re.search(pattern, entry.label.lower())), "")
    if not key:
        return "neither address, length nor identifier of a block"
    if why := _number(entry):
        return why
    blocks = kept.blocks[entry.parameter]
    if not blocks or key in blocks[-1]:
        blocks.append({"bus": entry.bus})
    blocks[-1][key] = _whole(entry.values[0])
    return ""


def _system(entry: Entry, kept: Collected) -> str:
    key = next((key for pattern, key in FIELDS if re.search(pattern, entry.label.lower())), None)
    if key is None:
        return "no entry of a measuring system that is known"
    if not key:
        return "axisgate does not use it"
    if any(isinstance(value, str) for value in entry.values):
        return NO_NUMBER
    if not entry.axis and len(entry.values) == 1:
        return NO_AXIS
    if entry.axis and len(entry.values) > 1:
        return _several(entry)
    for axis, value in enumerate(entry.values, entry.axis or 1):  # several numbers in a row are one for each axis
        if not isinstance(value, str):
            kept.systems[axis][key] = value
    return ""


def _whole(value: Value) -> int:
    return int(value) if not isinstance(value, str) else 0


# ------------------------------------------------------------------------------------------------ what the list leaves open


def _complete(kept: Collected, axes: list[int], report: Report) -> None:
    if not axes:
        report.missing.append("P401: no axis with a CAN measuring system; without it the cell has no axes")
    for axis in axes:
        _complete_system(axis, kept.systems[axis], report)
    _name_unwritten(kept, axes, report)
    for number in NEEDED:
        lacking = [axis for axis in axes if not kept.per_axis.get(number, {}).get(axis)]
        if lacking:
            report.missing.append(f"P{number} of axis {', '.join(map(str, lacking))}: axisgate check reports it as missing")
    if 5 not in kept.single:
        report.assumed.append("P5 is not in the list: 8 ms")
        kept.single[5] = 8
    if kept.download:
        report.assumed.append("P601 = TRUE in the list: written as false until the drives' present parameters are saved")
    _give_blocks_a_bus(kept, report)


def _name_unwritten(kept: Collected, axes: list[int], report: Report) -> None:
    """Values that were read and cannot be written."""
    without: dict[int, list[str]] = defaultdict(list)
    for number in (*PER_AXIS, *DRIVE):
        values = kept.per_axis.get(number, {})
        for axis in sorted(set(values) - set(axes)):
            without[axis].append(f"P{number}")
        lacking = [axis for axis in axes if axis not in values]
        if lacking and set(values) & set(axes) and number not in NEEDED:
            there = _listed(axis for axis in axes if axis in values)
            report.missing.append(f"P{number} of axis {_listed(lacking)}: values of axis {there} only are not written")
    for axis, numbers in sorted(without.items()) if axes else ():
        report.missing.append(f"P401 of axis {axis}: {', '.join(numbers)} have values of it; without it the axis is not in the file")
    if kept.ranges and len(kept.ranges) < len(RANGES):
        lacking_ranges = ", ".join(each.upper() for each in RANGES if each not in kept.ranges)
        report.missing.append(f"P21: {lacking_ranges}; what the list has of P21 is not written")
    for number in (31, 32):
        for n, block in enumerate(kept.blocks[number], 1):
            if lost := [word for key, word in (("start", "address"), ("length", "length"), ("id", "identifier")) if key not in block]:
                report.missing.append(f"P{number} block {n}: {', '.join(lost)}; the block is not written")
    for bus in range(1, max(kept.buses, default=0) + 1):
        words = (("inputs", "input blocks"), ("outputs", "output blocks"), ("baud", "baud rate"))
        if lost := [word for key, word in words if key not in kept.buses.get(bus, {})]:
            report.assumed.append(f"P30 of bus {bus}: {', '.join(lost)} not in the list: 0")


def _listed(axes: Iterable[int]) -> str:
    return ", ".join(map(str, axes))


def _complete_system(axis: int, system: dict[str, float], report: Report) -> None:
    pulses = system.get("pulses")
    if pulses not in PULSES:
        said = "not in the list" if pulses is None else f"{pulses:g}, which is not one of 16384, 8192, 4096"
        report.assumed.append(f"P401 of axis {axis}: pulses/rotation {said}: 16384")
        pulses = 16384
    system["pulses"] = PULSES[int(pulses)]
    if "module" not in system:
        report.assumed.append(f"P401 of axis {axis}: input on module is not in the list: {axis}")
        system["module"] = axis
    if "evaluation" not in system:
        report.assumed.append(f"P401 of axis {axis}: measuring-system evaluation is not in the list: positive")
        system["evaluation"] = float(pulses)
    if "gear_factor" not in system:  # the control asks for it in modes 1 and 3 only (L7383)
        turns = 360.0 * pulses / abs(system["evaluation"]) if system["evaluation"] else 1.0
        how = f"read out of the evaluation {system['evaluation']:g} as degrees a motor turn x {pulses:g}"
        report.assumed.append(f"P401 of axis {axis}: gear factor {turns:g}: {how}; measure it")
        system["gear_factor"] = turns


def _give_blocks_a_bus(kept: Collected, report: Report) -> None:
    """Blocks without a heading belong to the buses in the order of P30's counts."""
    for number, key in ((31, "inputs"), (32, "outputs")):
        places = [bus for bus in sorted(kept.buses) for _ in range(kept.buses[bus].get(key, 0))]
        for n, block in enumerate(kept.blocks[number]):
            if not block["bus"]:
                block["bus"] = places[n] if n < len(places) else 1
                report.assumed.append(f"P{number} block {n + 1}: on bus {block['bus']}, by the numbers of blocks in P30")


# ------------------------------------------------------------------------------------------------ the file


def _file(kept: Collected, axes: list[int], name: str, report: Report) -> Iterable[str]:
    control = "rho3.0" if 9 in kept.boards else "rho3.1"
    report.assumed.append(f"the control was a {control}: from P15" if kept.boards else f"the control was a {control}")
    yield f"# {name}: drafted by axisgate import p-list; read the report, then axisgate check"
    yield "format = 1"
    yield ""
    yield "[cell]"
    yield f'name     = "{name}"'
    yield f'replaces = "{control}"'
    yield 'target   = "simulation"           # "machine" once [safety] is filled in'
    yield ""
    yield "[rho3]"
    yield from _numbers(kept, axes)
    for axis in axes:
        yield from _table(axis, kept.systems[axis])
    yield from _buses(kept, axes, report)
    if axes:
        report.assumed.append('every axis turns (deg); a linear one needs an [[axis]] table with unit = "mm"')
        report.assumed.append("reference switches lie in direction -, lag limits are the drive's own: [[axis]] tables change them")


def _numbers(kept: Collected, axes: list[int]) -> Iterable[str]:
    for number in SINGLE:
        if number in kept.single:
            yield f"P{number} = {kept.single[number]}"
    if kept.boards:
        yield f"P15 = {kept.boards}"
    if len(kept.ranges) == len(RANGES):
        yield f"P21 = {[kept.ranges[each] for each in RANGES]}"
    if kept.clear is not None:
        yield f"P24 = {kept.clear}" if isinstance(kept.clear, int) else 'P24 = "all"'
    if kept.buses:
        rows = [kept.buses.get(bus, {}) for bus in range(1, max(kept.buses) + 1)]
        yield f"P30 = [ {', '.join(_row(row, ('inputs', 'outputs', 'baud')) for row in rows)} ]"
    for number in (31, 32):
        rows = [row for row in kept.blocks[number] if len(row) == 4]
        if rows:
            yield f"P{number} = [ {', '.join(_row(row, ('bus', 'start', 'length', 'id')) for row in rows)} ]"
    if kept.monitoring:
        yield f"P306 = [ {', '.join(f'{{ monitoring = {mode} }}' for mode in kept.monitoring)} ]"
    for number in (*PER_AXIS, *DRIVE):
        values = kept.per_axis.get(number, {})
        if values and axes and all(axis in values for axis in axes):
            yield f"P{number} = [ {', '.join(_one(number, values[axis]) for axis in axes)} ]"
    yield "P601 = false                     # true downloads P602..P615 to the drives"


def _row(row: Mapping[str, int], keys: tuple[str, ...]) -> str:
    return "{ " + ", ".join(f"{key} = {row.get(key, 0)}" for key in keys) + " }"


def _one(number: int, values: list[float]) -> str:
    if number == 615:
        return "true" if values[0] else "false"
    written = [str(round(value)) if number in WHOLE_DRIVE else repr(float(value)) for value in values]
    return written[0] if len(written) == 1 else f"[{', '.join(written)}]"


def _table(axis: int, system: Mapping[str, float]) -> Iterable[str]:
    yield ""
    yield "[[rho3.P401]]"
    yield f"axis = {axis}"
    for key in ("module", "ref_mode", "pulses", "output"):
        if key in system:
            yield f"{key} = {round(system[key])}"
    for key in ("gear_factor", "evaluation"):
        yield f"{key} = {float(system[key])!r}"


def _buses(kept: Collected, axes: list[int], report: Report) -> Iterable[str]:
    """Bus n is the n-th table: drives where P401 puts axes, digital I/O where P30 has blocks and no axes."""
    modules = [round(kept.systems[axis]["module"]) for axis in axes]
    most = max([*kept.buses, *(1 + (module - 1) // 6 for module in modules)], default=0)
    for number in range(1, most + 1):
        here = sorted((module - 1) % 6 + 1 for module in modules if 1 + (module - 1) // 6 == number)
        io = kept.buses.get(number, {})
        if not here and not (io.get("inputs") or io.get("outputs")) and number == most:
            continue
        yield ""
        yield "[[bus]]"
        yield f'name     = "can{number - 1}"'
        yield 'port     = "sim"'
        yield f'protocol = "{"servodyn" if here else "rho3-io"}"'
        if here:
            yield 'layout   = "servodyn_gc.dbc"'
            if here == list(range(here[0], here[-1] + 1)) and not report.missing:
                yield f'axes     = "{here[0]}..{here[-1]}"' if len(here) > 1 else f'axes     = "{here[0]}"'
    if most:
        report.assumed.append('every bus has port = "sim"; write socketcan:can0 and layout_evidence for real drives')
