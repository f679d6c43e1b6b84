"""What the rho 3 sends its boosters at start-up: numbers 1..24 out of P601..P615 and parameters it has anyway.

Source: rho 3 Releases part 5, 7.3 (L7549-7592); formulas of 8 and 9: part 3, 5.2 (L3724-3748, "rho3 D-17").  The chapters with ranges
and units of P602..P615 are missing (rho3 D-29): units below are AX-267.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from drivers.drives.limits import booster_limits
from gateway.pure.cell.cell import Axis, ParamValue, Rho3
from protocols.servodyn.parameters import Value

INC_PER_TURN = {1: 16384, 2: 8192, 3: 4096}  # number 21 (L7572)
DEGREES = 360.0


class DownloadGap(ValueError):
    """Parameters that are switched on and not there; `missing` names each with its axis."""

    def __init__(self, missing: Sequence[str]) -> None:
        super().__init__(f"P601 = TRUE needs {', '.join(missing)}")
        self.missing = tuple(missing)


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table; `part`: which of P607's three values."""

    number: int
    source: str
    meaning: str
    command: str  # BOSCHTRM
    unit: str = ""
    part: int = 0


ROWS = (
    Row(1, "P601", "store to EEPROM if TRUE", ""),
    Row(2, "P602", "booster type", "", "code"),
    Row(3, "P603", "motor type", "SM", "code"),
    Row(4, "P5", "clock of the control", "SC", "ms"),
    Row(5, "P604", "gain of the speed controller", "SP", "Nm s/rad"),
    Row(6, "P605", "integral time of the speed controller", "SI", "ms"),
    Row(7, "P606", "gain of the position controller", "SG", "1/s"),
    Row(8, "P204", "software limit clockwise", "OL", "inc"),
    Row(9, "P205", "software limit counter-clockwise", "OL", "inc"),
    Row(10, "P607", "current limit, automatic", "ST", "% of rated", 0),
    Row(11, "P607", "current limit, manual", "ST", "% of rated", 1),
    Row(12, "P103", "speed limit, automatic", "SL", "rpm"),
    Row(13, "P114", "speed limit, manual", "SL", "rpm"),
    Row(14, "P607", "current limit, emergency stop", "ST", "% of rated", 2),
    Row(15, "P608", "slope of the emergency-stop ramp", "SE", "rpm/s"),
    Row(16, "P609", "speed at which the brake locks", "SL", "rpm"),
    Row(17, "P610", "largest static position error", "SS", "inc"),
    Row(18, "P611", "lag error relative to speed: max lag = motor speed x Kev_SI", "SF", "s"),
    Row(19, "P612", "bandwidth of the torque filter", "SW", "Hz"),
    Row(20, "P613", "damping of the 2nd order filter", "SZ"),
    Row(21, "P401", "position scaling", "OR", "1 = 16384, 2 = 8192, 3 = 4096 inc/rev"),
    Row(22, "P614", "zero shift of the position check-back", "OO", "inc"),
    Row(23, "P401", "TRUE: positive is clockwise", "OD"),
    Row(24, "P615", "over-temperature protection", "OW"),
)
COUNTS = frozenset({2, 3, 4, 8, 9, 17, 21, 22})  # integers
FLAGS = frozenset({1, 23, 24})


@dataclass(frozen=True, slots=True)
class Parameter:
    """What is sent to one drive."""

    row: Row
    value: Value


def position_scaling(increments: int) -> int:
    """Number 21 for increments a turn: 16384 -> 1, 8192 -> 2, 4096 -> 3 (L7586-7588).  Raises ValueError for any other."""
    for code, size in INC_PER_TURN.items():
        if size == increments:
            return code
    raise ValueError(f"{increments} increments a turn; the booster knows {', '.join(map(str, INC_PER_TURN.values()))}")


def direction_flag(direction: str) -> bool:
    """Number 23: TRUE whatever the axis' direction ("+" or "-"): reversal is done inside the control (L7590-7592)."""
    return direction in ("+", "-")


def zero_offset_deg(axis: Axis) -> float:
    """Where referencing ends, in degrees at the resolver from the nearest zero crossing, -180..180; should be -90..90 (L3736-3748)."""
    degrees = axis.home.offset * _resolver_degrees(axis)
    return degrees - DEGREES * round(degrees / DEGREES)


def software_limits(axis: Axis) -> tuple[int, int]:
    """(clockwise, counter-clockwise) in inc, magnitudes from the booster's zero; a reversed axis has them exchanged (AX-267)."""
    home, limits = axis.home, axis.limits
    gear, per_turn = _resolver_degrees(axis), axis.drive.inc_per_turn
    ends = booster_limits(-limits.min, limits.max, home.position, home.offset, gear, zero_offset_deg(axis), per_turn)
    lower, upper = round(ends[0]), round(ends[1])
    return (lower, upper) if axis.mechanics.direction == "-" else (upper, lower)


def download(params: Rho3, axis: Axis, index: int) -> list[Parameter]:
    """Numbers 1..24 for the axis at `index` (0..) of the P lists; nothing when P601 is FALSE.  Raises DownloadGap."""
    if not params.P601:
        return []
    missing = list(gaps(params, axis, index))
    if missing:
        raise DownloadGap(missing)
    computed = _computed(params, axis, index)
    found = []
    for row in ROWS:
        value = computed[row.number] if row.number in computed else _given(params.others, row, index)
        assert value is not None, "gaps() looked"
        found.append(Parameter(row, _typed(row.number, value)))
    return found


def gaps(params: Rho3, axis: Axis, index: int) -> Iterator[str]:
    """What a download of this axis lacks, as "P604 of axis 3"."""
    computed = _computed(params, axis, index)
    for row in ROWS:
        if row.number not in computed and _given(params.others, row, index) is None:
            place = ("", " (manual)", " (emergency stop)")[row.part]
            yield f"{row.source}{place} of axis {axis.name}"


def _computed(params: Rho3, axis: Axis, index: int) -> dict[int, float | bool]:
    clockwise, counter = software_limits(axis)
    found: dict[int, float | bool] = {
        1: True,
        4: params.P5 if params.P5 is not None else 0,
        8: clockwise,
        9: counter,
        12: axis.limits.speed * _resolver_degrees(axis) / 6.0,
        23: direction_flag(axis.mechanics.direction),
    }
    jog = _element(params.others.get("P114"), index)
    if isinstance(jog, int | float):
        found[13] = jog * _resolver_degrees(axis) / 6.0
    if params.P5 is None:
        del found[4]
    if axis.drive.inc_per_turn in INC_PER_TURN.values():  # any other the booster cannot be given
        found[21] = position_scaling(axis.drive.inc_per_turn)
    return found


def _given(others: Mapping[str, ParamValue], row: Row, index: int) -> float | bool | None:
    """P602..P615 of one axis: a list with a value for each axis, or one for all; P607 may hold three a piece."""
    value = _element(others.get(row.source), index)
    if isinstance(value, Sequence) and not isinstance(value, str):
        value = value[row.part] if row.part < len(value) else None
    return value if isinstance(value, int | float) else None


def _element(value: ParamValue | None, index: int) -> ParamValue | None:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return value[index] if index < len(value) else None
    return value


def _typed(number: int, value: float | bool) -> Value:
    if number in FLAGS:
        return bool(value)
    return round(value) if number in COUNTS else float(value)


def _resolver_degrees(axis: Axis) -> float:
    """Degrees at the resolver for one mm or degree of the axis: GF of the formulas (L3746-3748)."""
    return axis.mechanics.ratio * DEGREES / axis.mechanics.feed_per_turn
