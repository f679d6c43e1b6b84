"""The rho 3's machine parameters merged into our own tables: P has priority, and setting both for one thing is a fault that names both.

Source of the numbers: rho3 8 (list), 2.3 (P401), 2.9 (direction), users.md 3.5 (b); P205 as a magnitude: AX-124.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from gateway.pure.cell.cell import Source
from gateway.pure.cell.faults import Fault
from gateway.pure.cell.rho3 import COMPONENTS, ENDLESS
from gateway.pure.reports.toml_lines import Path, nearest
from gateway.registry import BUS_PROTOCOLS

V = TypeVar("V")
LEGAL = frozenset(
    "P2 P3 P5 P9 P11 P13 P14 P15 P16 P18 P20 P21 P24 P25 P26 P27 P28 P29 P30 P31 P32 P33 P34 P35 P36 P103 P104 P105 P108 P109 P110 "
    "P111 P112 P113 P114 P117 P122 P128 P129 P130 P201 P202 P203 P204 P205 P207 P208 P212 P213 P214 P301 P303 P304 P305 P306 P310 "
    "P311 P313 P401 P402 P405 P501 P503 P506 P508 P601 P602 P603 P604 P605 P606 P607 P608 P609 P610 P611 P612 P613 P614 P615".split()
)
USED = frozenset("P2 P5 P9 P15 P20 P21 P24 P30 P31 P32 P103 P104 P108 P109 P204 P205 P207 P208 P303 P306 P311 P313 P401 P601".split())
PER_AXIS = {  # P number -> (table, key) of [[axis]], sign
    "P103": ("limits", "speed", 1.0),
    "P104": ("limits", "accel", 1.0),
    "P108": ("home", "speed", 1.0),
    "P109": ("home", "slow_speed", 1.0),
    "P204": ("limits", "max", 1.0),
    "P205": ("limits", "min", -1.0),  # printed as a magnitude (AX-124)
    "P207": ("home", "position", 1.0),
    "P208": ("home", "offset", 1.0),
}
BOOSTED = tuple(protocol.name for protocol in BUS_PROTOCOLS.values() if protocol.boosted)
BLOCKS = tuple(protocol.name for protocol in BUS_PROTOCOLS.values() if protocol.blocks)
MANUAL = (1, 4)  # P303
PULSES = {1: 16384, 2: 8192, 3: 4096}  # increments per turn (rho3 2.6, L7586-7588)
BITRATE = {0: "1 Mbit/s", 1: "500 kbit/s", 2: "250 kbit/s", 3: "125 kbit/s"}  # P30 (rho3 2.1, L7411-7415)


@dataclass
class Merged:
    """The raw file with P numbers worked in, the source of each such value, and the collisions."""

    raw: dict[str, Any]
    sources: dict[str, Source] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)


def merge(file: str, raw: Mapping[str, Any], places: dict[Path, int]) -> Merged:
    """Works [rho3] into axis and bus tables; never judges values, that is the models' part."""
    merged = Merged({key: _copy(value) for key, value in raw.items()})
    params = merged.raw.get("rho3")
    if not isinstance(params, dict):
        return merged
    others = {key: params.pop(key) for key in list(params) if key in LEGAL - USED}
    if others:
        params["others"] = others
    work = _Work(file, merged, places, params)
    work.clock()
    work.axes()
    work.kinematics()
    return merged


def _copy(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copy(each) for key, each in value.items()}
    return [_copy(each) for each in value] if isinstance(value, list) else value


class _Work:
    def __init__(self, file: str, merged: Merged, places: dict[Path, int], params: dict[str, Any]) -> None:
        self.file, self.merged, self.places, self.params = file, merged, places, params

    def clock(self) -> None:
        """P5 is the cycle of every drive bus, P30 the bit rate of an I/O bus."""
        blocks = self.params.get("P30")
        for number, bus in enumerate(_tables(self.merged.raw.get("bus"))):
            name = f"bus.{bus.get('name', number)}"
            if "P5" in self.params and bus.get("protocol") in BOOSTED:
                self.put(bus, "cycle_ms", self.params["P5"], "P5", f"{name}.cycle_ms", ("rho3", "P5"))
            if bus.get("protocol") in BLOCKS and isinstance(blocks, list) and number < len(blocks) and isinstance(blocks[number], dict):
                rate = _row(BITRATE, blocks[number].get("baud", 0))
                if rate:
                    self.put(bus, "bitrate", rate, f"P30[{number + 1}].baud", f"{name}.bitrate", ("rho3", "P30", number))

    def axes(self) -> None:
        systems = _tables(self.params.get("P401"))
        axes = self.merged.raw.get("axis")
        if not axes and systems:
            axes = self.merged.raw["axis"] = [{"name": str(system.get("axis")), "unit": "deg"} for system in systems]
            for system in systems:
                for key in ("name", "unit", "drive.type", "drive.bus"):
                    self.merged.sources[f"axis.{system.get('axis')}.{key}"] = Source(
                        "rho3.P401, no [[axis]] table: an axis in deg for each"
                    )
        for number, axis in enumerate(_tables(axes)):
            endless = self.endless(number, axis)
            for param, (table, key, sign) in PER_AXIS.items():
                if endless and param in ("P204", "P205"):
                    continue  # an axis that goes round has no ends
                self.per_axis(param, number, axis, table, key, sign, len(_tables(axes)))
            for index, system in enumerate(systems):
                if system.get("axis") == number + 1:
                    self.measuring_system(index, system, axis)

    def per_axis(self, param: str, number: int, axis: dict[str, Any], table: str, key: str, sign: float, axes: int) -> None:
        values = self.params.get(param)
        if not isinstance(values, list):
            return
        if number >= len(values):
            hint = f"{axes} axes need {axes} values"
            line = nearest(self.places, ("rho3", param))
            fault = Fault(self.file, f"rho3.{param}", f"{len(values)} values", "", "", hint, line)
            self.merged.faults += [] if fault in self.merged.faults else [fault]
            return
        value = values[number]
        if isinstance(value, int | float) and not isinstance(value, bool):
            inner = axis.setdefault(table, {})
            where = f"axis.{axis.get('name', number)}.{table}.{key}"
            self.put(inner, key, sign * value, f"{param}[{number + 1}]", where, ("rho3", param, number))

    def kinematics(self) -> None:
        """P306 sub-query 6: reaction to a path that is too fast for an axis; P313: axes that a workpiece system corrects."""
        robots = self.merged.raw.get("robot")
        robots = [robots] if isinstance(robots, dict) else _tables(robots)
        rows = _tables(self.params.get("P306"))
        for number, (robot, row) in enumerate(zip(robots, rows, strict=False)):
            if "monitoring" in row:
                where = f"robot.{robot.get('name', number)}.too_fast"
                self.put(robot, "too_fast", row["monitoring"], f"P306[{number + 1}].monitoring", where, ("rho3", "P306", number))
        given = self.params.get("P313")
        assigned = given if isinstance(given, list) else []  # its model reports a value that is not a list
        for number, (robot, row) in enumerate(zip(robots, assigned, strict=False)):
            if isinstance(row, list) and len(row) == len(COMPONENTS) and all(isinstance(value, int) for value in row):
                self.assigned(number, robot, row)
        if robots and len(assigned) > len(robots):
            self.fault("P313", f"{len(assigned)} lists", f"{len(robots)} [[robot]] tables: one each at most", ("rho3", "P313"))
        if robots and len(rows) > len(robots):
            self.fault("P306", f"{len(rows)} tables", f"{len(robots)} [[robot]] tables: one each at most", ("rho3", "P306"))

    def assigned(self, number: int, robot: dict[str, Any], row: list[int]) -> None:
        """P313 of one kinematic.  Points of programs name x y z a b c themselves, so of its numbers counts which are 0."""
        place: Path = ("rho3", "P313", number)
        if any(value > len(COMPONENTS) for value in row) or len({value for value in row if value}) < sum(map(bool, row)):
            hint = "six numbers of components 1..6, each at most once, 0: not corrected; belt values of blocks are not corrected"
            self.fault(f"P313[{number + 1}]", row, hint, place)
            return
        corrects = "".join(letter for letter, value in zip(COMPONENTS, row, strict=True) if value)
        self.put(robot, "corrects", corrects, f"P313[{number + 1}]", f"robot.{robot.get('name', number)}.corrects", place)

    def endless(self, number: int, axis: dict[str, Any]) -> bool:
        """P303 = 3, 4: the axis goes round at P311; 1, 4: it is a manual axis."""
        kind, modulo = _nth(self.params.get("P303"), number), _nth(self.params.get("P311"), number)
        name = axis.get("name", number)
        if kind in MANUAL:
            self.put(axis, "manual", True, f"P303[{number + 1}]", f"axis.{name}.manual", ("rho3", "P303", number))
        if kind is None or kind in (0, 1):
            return False
        if kind not in ENDLESS:
            self.fault(f"P303[{number + 1}]", kind, "0 main, 1 manual, 3 endless main, 4 endless manual axis", ("rho3", "P303", number))
        elif not isinstance(modulo, int | float) or not modulo > 0:
            hint = f"axis {name} is endless (P303 = {kind}): its modulo value is needed"
            self.fault(f"P311[{number + 1}]", "" if modulo is None else modulo, hint, ("rho3", "P311", number))
        else:
            place: Path = ("rho3", "P311", number)
            self.put(axis, "modulo", modulo, f"P311[{number + 1}]", f"axis.{name}.modulo", place)
            for key, value in (("min", 0.0), ("max", modulo)):
                self.put(axis.setdefault("limits", {}), key, value, f"P311[{number + 1}]", f"axis.{name}.limits.{key}", place)
            return True
        return False

    def fault(self, key: str, value: object, hint: str, place: Path) -> None:
        self.merged.faults.append(Fault(self.file, f"rho3.{key}", str(value), "", "", hint, nearest(self.places, place)))

    def measuring_system(self, index: int, system: dict[str, Any], axis: dict[str, Any]) -> None:
        """One P401 table: module, gear, increments, direction, referencing mode."""
        drive, mechanics, home = axis.setdefault("drive", {}), axis.setdefault("mechanics", {}), axis.setdefault("home", {})
        if not isinstance(drive, dict) or not isinstance(mechanics, dict) or not isinstance(home, dict):
            return
        name = f"axis.{axis.get('name')}"
        label, place = f"P401[{system.get('axis')}]", ("rho3", "P401", index)
        module = system.get("module")
        if isinstance(module, int) and not isinstance(module, bool):
            self.drive_of(drive, module, f"{label}.module", name, place)
        gear, pulses = system.get("gear_factor"), _row(PULSES, system.get("pulses", 1))
        reversed_ = isinstance(system.get("evaluation"), float | int) and system["evaluation"] < 0
        if isinstance(gear, int | float):
            self.put(mechanics, "gear", f"{gear}:1", f"{label}.gear_factor", f"{name}.mechanics.gear", place)
        if pulses:
            self.put(drive, "inc_per_turn", pulses, f"{label}.pulses", f"{name}.drive.inc_per_turn", place)
        self.put(mechanics, "direction", "-" if reversed_ else "+", f"{label}.evaluation", f"{name}.mechanics.direction", place)
        if isinstance(system.get("ref_mode"), int):
            self.put(home, "mode", system["ref_mode"], f"{label}.ref_mode", f"{name}.home.mode", place)

    def drive_of(self, drive: dict[str, Any], module: int, label: str, name: str, place: Path) -> None:
        """Modules 1..6 hang on the first SERVODYN bus, 7..12 (counted on) on the second (rho3 2.1, L7250)."""
        buses = [bus for bus in _tables(self.merged.raw.get("bus")) if bus.get("protocol") in BOOSTED]
        rack = (module - 1) // 6
        if 0 <= rack < len(buses):
            drive.setdefault("type", "servodyn")
            drive.setdefault("bus", buses[rack].get("name", ""))
        own = (module - 1) % 6 + 1 if module >= 1 else module  # an invalid number is reported as typed
        self.put(drive, "module", own, label, f"{name}.drive.module", place)

    def put(self, table: Any, key: str, value: object, label: str, where: str, place: Path) -> None:
        if not isinstance(table, dict):
            return
        if key in table:
            hint = f"rho3.{label} sets the same (P takes precedence): keep only one"
            line = nearest(self.places, place)
            self.merged.faults.append(Fault(self.file, where, str(table[key]), "", "", hint, line, "cross"))
        table[key] = value
        self.merged.sources[where] = Source(f"rho3.{label}", nearest(self.places, place))


def _nth(values: Any, number: int) -> Any:
    """Element of a list that is long enough; None for anything else."""
    return values[number] if isinstance(values, list) and number < len(values) else None


def _row(table: Mapping[int, V], key: object) -> V | None:
    """The row of a number; None for anything else."""
    return table.get(key) if isinstance(key, int) else None


def _tables(value: Any) -> list[dict[str, Any]]:
    return [each for each in value if isinstance(each, dict)] if isinstance(value, list) else []
